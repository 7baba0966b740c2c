# SPDX-License-Identifier: MIT
"""What a problem was made of, as a flat table from the names of arguments to texts and sums; see signature.py.

The table is made by a walk through the arguments of constructors: an object of this package is its type and what its
constructor takes, by the names that are in the constructor, as `contact[0].pair.friction`. Entries do not depend on the
ranks. Numbers are texts with all digits. Of functions and expressions there is what can be told:

- a UFL expression or form: its signature, values of constants, and of every function in it the sums over its degrees
  of freedom of values and of values times places;
- a function of positions (normals of smooth surfaces): the sums of the surface that it makes;
- a function of time: values at times so far (signature.functions_of_time);
- a law of one's own: its attributes, and the code of its methods as Python compiles it.

Of a DOLFINx function sums are compared to round-off, all else exactly.
"""

from __future__ import annotations

import hashlib
import inspect
from collections.abc import Callable, Iterable, Mapping, Sequence
from types import CodeType
from typing import Any, TypeAlias

import numpy as np
import ufl
from dolfinx import cpp, default_scalar_type, fem
from dolfinx.mesh import Mesh, MeshTags
from mpi4py import MPI
from ufl.algorithms.analysis import extract_coefficients, extract_constants

from .. import _cpp, compat
from ..assembly.fields import is_mixed
from ..common.types import FloatArray, IntArray
from ..forms.compiler.frontend import form_signature
from ..materials import FULL, Material

LONG = 2000  # characters; the rest of a longer text is replaced by a checksum
SUMS = "sums of "  # beginning of the names of arrays

Table: TypeAlias = dict[str, str | int | FloatArray]

# Attributes that have other names than the arguments of the constructor: of rigid obstacles.
STORED_AS = {"point": "_point", "normal": "_direction", "center": "_point", "radius": "_radius", "axis": "_direction"}
# Constants with the present values of arguments of loads.
CONSTANT_OF = {
    "vector": "constant", "pressure": "constant", "stiffness": "constant", "damping": "damping_constant",
}  # fmt: skip
NAMES = ("name",)  # names for messages and files, which may be others


def short(text: str) -> str:
    """Shorten a long text to its beginning and a checksum.

    Args:
        text: any text.

    Returns:
        The text, if it has at most LONG characters, or its beginning and checksum.
    """
    if len(text) <= LONG:
        return text
    return f"{text[: LONG // 10]}... (checksum {hashlib.blake2b(text.encode(), digest_size=16).hexdigest()})"


class GivenArguments:
    """Collects what a problem was made of. All methods are collective.

    Args:
        mesh: mesh of the problem.
        state: functions that are the problem's state; their values are not compared.

    Attributes:
        table: entries by name.
    """

    def __init__(self, mesh: Mesh, state: Sequence[fem.Function]) -> None:
        self.mesh, self._state = mesh, state
        self.table: Table = {}

    def add(self, name: str, value: Any, numbers: bool = True) -> None:
        """Add a value: a number, text, array, expression, function, or an object of this package with its arguments.

        Args:
            name: name of the argument.
            value: its value.
            numbers: whether the values of constants and functions in a form or an expression belong to it.
        """
        if isinstance(value, (ufl.Form, ufl.core.expr.Expr)) and not isinstance(value, fem.Constant):
            self._add_expression(name, value, numbers)
        elif isinstance(value, _cpp.integrators.ImplicitScheme):
            self.table[name] = type(value).__name__
            for key in ("beta", "gamma", "alpha_m", "alpha_f"):
                self.add(f"{name}.{key}", getattr(value, key))
        elif type(value).__module__.split(".")[0] == __name__.split(".")[0]:
            self.table[name] = type(value).__name__
            self.add_attributes(name, value)
        else:
            self.table[name] = short(_text(value))

    def add_attributes(self, name: str, thing: Any, but: Iterable[str] = ()) -> None:
        """Add what an object was made of: the arguments of its constructor, and further public attributes.

        Args:
            name: name of the object.
            thing: the object, which has its arguments as attributes.
            but: names of arguments that are left out.
        """
        taken = [p for p in inspect.signature(type(thing).__init__).parameters if p != "self"]
        public = [key for key in vars(thing) if not key.startswith("_")]
        left_out = {*but, *NAMES}
        for key in dict.fromkeys(k for k in [*taken, *public] if k not in left_out):
            stored = key if hasattr(thing, key) else STORED_AS.get(key, key)
            if hasattr(thing, stored):
                self.add(f"{name}.{key}", getattr(thing, stored))

    def add_material(self, name: str, material: Material) -> None:
        """Add a material, or those of a MaterialMap with their cells.

        Args:
            name: name of the argument.
            material: the material.
        """
        tags = material.cell_tags
        parts = material.parts()
        # Checkpoints that are older than `integration` are of full integration: it is not named.
        kinds = [type(m).__name__ + ("" if m.integration == FULL else f" ({m.integration})") for _, m in parts]
        self.table[name] = ", ".join(k if tag is None else f"{tag}: {k}" for k, (tag, _) in zip(kinds, parts))
        for tag, m in parts:
            of = name if tag is None else f"{name}[{tag}]"
            if tag is not None and tags is not None:
                self.table[f"{of}.cells"] = cells_with(tags, tag)
            self.add_attributes(of, m, but=("cell_tags", "steepest_softening", "integration"))
            for key in ("finite_strain", "average", "history", "unknown"):  # of laws with internal variables
                if hasattr(m, key):
                    self.table[f"{of}.{key}"] = short(_text(getattr(m, key)))
            for key, function in _own_methods(type(m)).items():
                self.table[f"{of}.{key}"] = _code(function)

    def add_load(self, name: str, load: Any, numbers: bool = True) -> None:
        """Add a load.

        Args:
            name: name of the argument.
            load: the load.
            numbers: whether the present values of its constants and functions belong to it.
        """
        self.table[name] = type(load).__name__
        for key in (p for p in inspect.signature(type(load).__init__).parameters if p != "self"):
            value, of = getattr(load, key), f"{name}.{key}"
            if isinstance(value, MeshTags):
                self.table[of] = facets_with(self.mesh, value, load.tag)
            elif key == "amplitude":
                self.table[of] = "without" if value is None else "with"  # its values: functions of time
            elif not numbers and key in CONSTANT_OF:
                if isinstance(value, ufl.core.expr.Expr):
                    self._add_expression(of, value, numbers)
            else:
                # The first value of a load is that of `constant`; that of an expression is a factor.
                constant = getattr(load, CONSTANT_OF[key], None) if key in CONSTANT_OF else None
                if isinstance(value, ufl.core.expr.Expr):
                    self._add_expression(of, value)
                    self.table[f"{of}.factor"] = _text(1.0 if constant is None else constant.value)
                else:
                    self.table[of] = _text(value if constant is None else constant.value)

    def add_contact(
        self, name: str, kind: str, options: Mapping[str, object], pair: Any, surfaces: Any, places: bool = True
    ) -> None:
        """Add a contact.

        Args:
            name: name of the argument.
            kind: name of the method that enforces it.
            options: options of the method by name.
            pair: contact pair.
            surfaces: facets of slave and master on this rank (C++), the latter None or an obstacle if it is rigid.
            places: whether displacement and motion of a rigid master belong to it.
        """
        self.table[name] = kind
        for key, value in sorted(options.items()):
            self.table[f"{name}.{key}"] = short(_text(value))
        of = f"{name}.pair"
        if not hasattr(pair, "slave"):  # a surface that meets itself
            tags = (
                "all"
                if pair.tags is None
                else [f"{t}, {facets_with(self.mesh, pair.facet_tags, t)}" for t in pair.tags]
            )
            self.table[f"{of}.tags"], self.table[f"{of}.friction"] = short(str(tags)), _text(pair.friction)
            return
        self.table[f"{of}.slave"] = f"{pair.slave}, {facets_with(self.mesh, pair.facet_tags, pair.slave)}"
        if pair.rigid:
            master = pair.master
            self.table[f"{of}.master"] = type(master).__name__
            self.add_attributes(f"{of}.master", master, but=("motion", "shape", "hint", "numbers", *master.given_once))
            self.table[f"{of}.master.shape"] = master.description() if places else master.shape_description()
            if places:
                self.table[f"{of}.master.displacement"] = _text(master.displacement)
                if "velocity" not in master.given_once:
                    self.table[f"{of}.master.velocity"] = _text(master.velocity)
                self.table[f"{of}.master.motion"] = "without" if master.motion is None else "with"
        else:
            found = [f"{tag}, {facets_with(self.mesh, pair.facet_tags, tag)}" for tag in pair.masters]
            self.table[f"{of}.master"] = "; ".join(found)
        law = getattr(pair.friction, "identity", None)  # of a coefficient that is a law
        self.table[f"{of}.friction"] = short(law(self.mesh.geometry.dim)) if law else _text(pair.friction)
        for key in ("search_distance", "remove_penetration", "crease"):
            self.table[f"{of}.{key}"] = _text(getattr(pair, key))
        # In one entry with it, and only where gaps change: files that were written before have no entries of their own.
        changes = [
            f", {key} {_text(getattr(pair, key))}"
            for key, none in (("clearance", None), ("offset", (0.0, 0.0)), ("adjust", None))
            if getattr(pair, key) != none
        ]
        self.table[f"{of}.remove_penetration"] = "".join([_text(pair.remove_penetration), *changes])
        self.table[f"{of}.smooth"] = repr(tuple("function" if callable(side) else side for side in pair.smooth))
        for side, smooth, facets in zip(("slave", "master"), pair.smooth, surfaces):
            if callable(smooth):
                self.table[f"{SUMS}{of}.smooth, {side}"] = self._sums(facets.X.reshape(-1, facets.gdim))

    def add_prescribed(self, name: str, V: fem.FunctionSpace, fixed: IntArray, values: FloatArray) -> None:
        """Add prescribed displacements.

        Args:
            name: name of the argument.
            V: displacement space.
            fixed: owned degrees of freedom, (n).
            values: their values, (n) [L].
        """
        num = V.dofmap.index_map.size_local * V.dofmap.index_map_bs
        rows = np.zeros((num, 2))
        rows[fixed] = np.column_stack([np.ones(len(fixed)), values])
        self.table[f"{SUMS}{name}"] = self._moments(rows.reshape(-1, 2 * V.dofmap.index_map_bs), V)

    def add_mesh(self, V: fem.FunctionSpace) -> None:
        """Add the mesh: kind, numbers, and sums over the places of the nodes and over the cells.

        Args:
            V: displacement space.
        """
        topology = V.mesh.topology
        self.table["mesh.cell"] = topology.cell_name()
        mixed = is_mixed(V)
        self.table["mesh.degree"] = str(V.ufl_element()) if mixed else int(V.element.basix_element.degree)
        self.table["mesh.degree of the geometry"] = int(compat.coordinate_element(V.mesh).degree)
        self.table["mesh.num_cells"] = int(topology.index_map(topology.dim).size_global)
        self.table["mesh.num_nodes"] = int(V.dofmap.index_map.size_global)
        num, gdim = topology.index_map(topology.dim).size_local, V.mesh.geometry.dim
        corners = V.mesh.geometry.x[compat.geometry_dofmap(V.mesh)[:num]][:, :, :gdim]
        # Of each cell the sums over its nodes and their squares: these change with places and with what is joined.
        sums = corners.sum(axis=1)
        self.table[f"{SUMS}mesh"] = self._sums(corners.reshape(-1, gdim), sums, sums**2, sums**3)

    def _add_expression(self, name: str, value: Any, values: bool = True) -> None:
        form = value
        if not isinstance(value, ufl.Form):  # its product with a constant of its shape is a form, and as unique
            one = fem.Constant(self.mesh, np.ones(value.ufl_shape, dtype=default_scalar_type))
            form = ufl.inner(value, one) * ufl.dx(domain=self.mesh)
        self.table[name] = f"expression {form_signature(form)[:32]}"
        if not values:
            return
        constants = form.constants() if form is value else extract_constants(value)
        numbers = [np.asarray(c.value).tolist() for c in constants]
        self.table[f"{name}.constants"] = short(repr(numbers))
        coefficients = form.coefficients() if form is value else extract_coefficients(value)
        for k, f in enumerate(f for f in coefficients if not any(f is s for s in self._state)):
            V = f.function_space
            bs, num = V.dofmap.index_map_bs, V.dofmap.index_map.size_local
            self.table[f"{name}.function {k}"] = str(V.ufl_element())
            self.table[f"{SUMS}{name}.function {k}"] = self._moments(f.x.array[: num * bs].reshape(num, bs), V)

    def _moments(self, values: FloatArray, V: fem.FunctionSpace) -> FloatArray:
        """Sums of values at the owned nodes of a space, and of values times places; spaces may have no places."""
        try:
            x = V.tabulate_dof_coordinates()[: len(values), : V.mesh.geometry.dim]
        except RuntimeError:
            x = np.zeros((len(values), 0))
        return self._sums(np.abs(values), values, *(values * x[:, [k]] for k in range(x.shape[1])))

    def _sums(self, *columns: FloatArray) -> FloatArray:
        """Sums over rows and ranks, infinite or missing values as zeros."""
        here = [np.where(np.isfinite(v), v, 0.0).sum(axis=0) for v in columns]
        found: FloatArray = self.mesh.comm.allreduce(np.concatenate(here), MPI.SUM)
        return found


def _text(value: Any) -> str:
    """Text of a value with all digits, the same for equal numbers."""
    if isinstance(value, fem.Constant):
        value = value.value
    if isinstance(value, (np.ndarray, np.generic)):
        value = value.tolist()
    if isinstance(value, Mapping):
        return f"{{{', '.join(f'{key!r}: {_text(v)}' for key, v in value.items())}}}"
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(_text(v) for v in value)}]"
    if isinstance(value, int) and not isinstance(value, bool):
        value = float(value) if abs(value) < 2**53 else value
    if value is None or isinstance(value, (bool, int, float, complex, str, bytes)):
        return repr(value)
    if callable(value) and hasattr(value, "__code__"):
        return f"function of the code {_code(value)}"
    return type(value).__name__


def _own_methods(kind: type) -> dict[str, Callable[..., Any]]:
    """Methods by name of the classes of a user's own from which a class derives."""
    package = __name__.split(".")[0]
    own = [c for c in reversed(kind.__mro__) if c is not object and c.__module__.split(".")[0] != package]
    return {k: f for c in own for k, f in vars(c).items() if inspect.isfunction(f) and not k.startswith("__")}


def _code(function: Callable[..., Any]) -> str:
    """Checksum of a function: its code, defaults, and numbers that it has from where it was defined."""
    plain: Any = inspect.unwrap(function)
    cells = [c.cell_contents for c in plain.__closure__ or () if not _empty(c)]
    kept = [_text(v) for v in (*cells, *(plain.__defaults__ or ()), plain.__kwdefaults__ or {})]
    return hashlib.blake2b(repr((_compiled(plain.__code__), kept)).encode(), digest_size=16).hexdigest()


def _empty(cell: Any) -> bool:
    try:
        cell.cell_contents
    except ValueError:
        return True
    return False


def _compiled(code: CodeType) -> tuple[Any, ...]:
    """What a code does, without the place where it was written."""
    constants = [_compiled(c) if isinstance(c, CodeType) else repr(c) for c in code.co_consts]
    return code.co_code, constants, code.co_names, code.co_varnames, code.co_freevars


def _marks(comm: MPI.Intracomm, numbers: IntArray) -> str:
    """Count and checksum of the numbers of all ranks, independent of their order. Collective."""
    x = np.asarray(numbers, dtype=np.uint64) + np.uint64(0x9E3779B97F4A7C15)
    for factor, shift in ((0xBF58476D1CE4E5B9, 30), (0x94D049BB133111EB, 27)):  # as the generator splitmix64 mixes
        x = (x ^ (x >> np.uint64(shift))) * np.uint64(factor)
    sums = np.array([len(x), (x ^ (x >> np.uint64(31))).sum(dtype=np.uint64)], dtype=np.uint64)
    comm.Allreduce(MPI.IN_PLACE, sums, MPI.SUM)
    return f"{sums[0]} of checksum {sums[1]:x}"


def cells_with(tags: MeshTags, tag: int) -> str:
    """Checksum of the cells with a tag, by their numbers in the mesh's input. Collective.

    Args:
        tags: tags of cells.
        tag: the tag.
    """
    topology = tags.topology
    cells = tags.find(tag)
    cells = cells[cells < topology.index_map(topology.dim).size_local]
    return f"cells {_marks(topology.comm, topology.original_cell_index[cells])}"


def facets_with(mesh: Mesh, tags: MeshTags, tag: int) -> str:
    """Checksum of the boundary facets with a tag, by the numbers of their cells in the mesh's input and their local
    numbers in the cells. Collective.

    Args:
        mesh: mesh.
        tags: tags of facets.
        tag: the tag.
    """
    topology, dim = mesh.topology, mesh.topology.dim
    topology.create_connectivity(dim - 1, dim)
    topology.create_connectivity(dim, dim - 1)
    to_cell, to_facet = topology.connectivity(dim - 1, dim), topology.connectivity(dim, dim - 1)
    facets = tags.find(tag)
    cells = to_cell.array[to_cell.offsets[facets]]
    own = cells < topology.index_map(dim).size_local
    facets, cells = facets[own], cells[own]
    # A rank may own no cells: the number of columns does not follow from the array then.
    around = to_facet.array.reshape(-1, cpp.mesh.cell_num_entities(topology.cell_type, dim - 1))[cells]
    local = np.argmax(around == facets[:, None], axis=1)
    return f"facets {_marks(mesh.comm, 8 * topology.original_cell_index[cells] + local)}"
