# SPDX-License-Identifier: MIT
"""Kernels applied over the cells of a mesh: thin wrappers of cpp/dolfinx_impact/operators."""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import ufl
from dolfinx import cpp, fem, la
from dolfinx.fem import DirichletBC, Function, FunctionSpace
from dolfinx.mesh import MeshTags
from mpi4py import MPI
from petsc4py import PETSc

from .averaged_form import compile_columns, split_averages
from .ffcx_form import ffcx_form
from .interior_facets import interior_facets
from .nodal_mean import NodalMean, StrainParts, is_averaged, mean_of
from .one_point import check_integration
from ..common.described import Described
from .. import _cpp, compat
from ..common import arguments
from ..common.collective import comm_of, guard, same
from ..common.types import AnyArray, ArrayLike, FloatArray, IntArray
from ..forms import elasticity, quadrature
from ..forms.consistent_tangent import DIRECTION
from ..forms.materials import Law
from ..inelastic import InelasticMaterial
from ..materials import REDUCED, Material, _Material
from ..forms.compiler import frontend
from .jit import Compiled, Laws, compile_expression, compile_form, find_form
from .point_values import PointHistory


def domain_of(form: Any) -> cpp.mesh.Mesh_float64:
    """C++ mesh of a form."""
    if not isinstance(form, ufl.Form):
        raise TypeError(f"expected a UFL form, found {type(form).__name__}: {form!r:.80}")
    return _cargo(form.ufl_domain())


def _is_expression(thing: object) -> bool:
    return isinstance(thing, ufl.core.expr.Expr)


def _cargo(domain: ufl.Mesh | None) -> cpp.mesh.Mesh_float64:
    """C++ mesh of a UFL domain."""
    mesh = None if domain is None else domain.ufl_cargo()
    if mesh is None:
        raise ValueError("the form is on a symbolic mesh: use functions and constants of a DOLFINx mesh")
    return mesh


def entities_of(mesh: cpp.mesh.Mesh_float64, integral_type: str, subdomain: int, data: MeshTags | None) -> IntArray:
    """Entities of one integral on this rank, as the kernels take them (operators/Batches.h): owned cells, or facets."""
    tdim = mesh.topology.dim
    if integral_type == "cell":
        num_owned = mesh.topology.index_map(tdim).size_local
        if subdomain == -1:
            return np.arange(num_owned, dtype=np.int32)
        cells = _tagged(data, subdomain, "dx", tdim)
        return cells[cells < num_owned]
    if integral_type == "interior_facet":
        return interior_facets(mesh, None if subdomain == -1 else _tagged(data, subdomain, "dS", tdim - 1))
    topology = mesh.topology
    topology.create_connectivity(tdim - 1, tdim)
    topology.create_connectivity(tdim, tdim - 1)
    facets = cpp.mesh.exterior_facet_indices(topology)
    if subdomain != -1:
        facets = np.intersect1d(_tagged(data, subdomain, "ds", tdim - 1), facets)
    return compat.facet_entities(topology, facets)


PARTS = (None, "early", "outer", "late")  # of the cells of a form


def _choose(V: FunctionSpace, entities: IntArray, integral_type: str, part: str) -> IntArray:
    """Entities whose cells have ghost nodes ("outer"), the first half of the others ("early"), or their rest ("late").

    Without outer ones there is nothing to wait for: all are early.
    """
    num_owned, dofs = V.dofmap.index_map.size_local, V.dofmap.list
    rows, cells = entity_rows(entities, integral_type)
    outer = np.any(dofs[cells] >= num_owned, axis=(1, 2))
    if part == "outer":
        return rows[outer].ravel()
    inner = rows[~outer]
    half = (len(inner) + 1) // 2 if np.any(outer) else len(inner)
    return (inner[:half] if part == "early" else inner[half:]).ravel()


def entity_rows(entities: IntArray, integral_type: str) -> tuple[IntArray, IntArray]:
    """Entities of an integral one by one.

    Args:
        entities: as `entities_of` returns them.
        integral_type: "cell", "exterior_facet" or "interior_facet".

    Returns:
        Rows of what kernels take for an entity, (num_entities, 1 to 3), and the cells of each, (num_entities, 1 or 2).
    """
    cells = 2 if integral_type == "interior_facet" else 1
    rows = entities.reshape(-1, 1 if integral_type == "cell" else cells + 1)
    return rows, rows[:, :cells]


def _tagged(data: Any, subdomain: int, measure: str, dim: int) -> IntArray:
    """Entities of a subdomain, from the checked tags of its measure."""
    if data is None:
        raise ValueError(f"the form integrates over {measure}({subdomain}), but the measure has no subdomain_data")
    if not hasattr(data, "find"):
        raise TypeError(f"subdomain_data of {measure} must be MeshTags, found {type(data).__name__}")
    if data.dim != dim:
        raise ValueError(f"{measure} needs tags of dimension {dim}, found tags of dimension {data.dim}")
    return data.find(subdomain).astype(np.int32)


def _constants(compiled: Compiled, kernel: _cpp.kernels.Kernel) -> FloatArray:
    """Present values of the constants of a form that a kernel reads, one after the other; empty if it reads none."""
    read = [compiled.constants[c["position"]] for c in kernel.constants]
    return np.concatenate([np.ravel(np.asarray(c.value, dtype=np.float64)) for c in read]) if read else np.empty(0)


def constants_of(compiled: Compiled, kernel: _cpp.kernels.Kernel) -> list[Any]:
    """Constants of a form that one of its kernels reads, in its order (C++).

    Args:
        compiled: kernels of the form.
        kernel: one of them.
    """
    return [compiled.constants[c["position"]]._cpp_object for c in kernel.constants]


class BilinearKernels(Described):
    """Kernels of a bilinear form with their entities, for KernelTangent of C++.

    Args:
        form: form of rank 2, or of rank 1 with a direction (forms/consistent_tangent.py).
        compiled: its kernels.
        fields: names in the history of coefficients that stand for internal variables.
        history: internal variables of the cells; None without.

    Attributes:
        integrals: integrals (C++).
        sources: where the coefficients of each come from (C++).
        constants: constants of each (C++).
        functions: functions that they read.
    """

    def __init__(
        self,
        form: ufl.Form,
        compiled: Compiled,
        fields: Mapping[Any, str] | None = None,
        history: PointHistory | None = None,
    ) -> None:
        mesh, data = domain_of(form), next(iter(form.subdomain_data().values()))
        self.integrals: list[_cpp.operators.Integral] = []
        self.sources: list[list[_cpp.operators.Source]] = []
        self.constants: list[list[Any]] = []
        self.functions: list[Function] = []
        self._compiled, self._kernels = compiled, []
        known = fields or {}
        for kernel in compiled.kernels:
            tags = next((t for t in data.get(kernel.integral_type, []) if t is not None), None)
            objects = [compiled.coefficients[c["position"]] for c in kernel.coefficients]
            self.functions += [f for f in objects if f not in known and f.name != DIRECTION]
            for subdomain in kernel.subdomains:
                entities = np.ascontiguousarray(entities_of(mesh, kernel.integral_type, subdomain, tags))
                part = None if history is None else _history_of_cells(history.parts, entities)
                integral = _cpp.operators.Integral(kernel.address, entities, _constants(compiled, kernel), part)
                self.integrals.append(integral)
                self.sources.append([self._source(f, known) for f in objects])
                self.constants.append(constants_of(compiled, kernel))
                self._kernels.append(kernel)

    @staticmethod
    def _source(f: Any, fields: Mapping[Any, str]) -> _cpp.operators.Source:
        """Where a coefficient comes from."""
        if f in fields:
            return _cpp.operators.Source(field=fields[f])
        return _cpp.operators.Source() if f.name == DIRECTION else _cpp.operators.Source(f._cpp_object)

    def values(self) -> list[FloatArray]:
        """Present values of the constants of each integral."""
        return [_constants(self._compiled, kernel) for kernel in self._kernels]


def _history_of_cells(parts: Sequence[_cpp.operators.PointHistory], entities: IntArray) -> _cpp.operators.PointHistory:
    """The part of a history that belongs to the cells of an integral."""
    for part in parts:
        if np.array_equal(part.cells, entities):
            return part
    raise ValueError("the history that is shared belongs to other cells: use the same subdomains in both forms")


def _cells_of(mesh: cpp.mesh.Mesh_float64) -> str:
    """Number and type of the cells that this rank owns."""
    topology = mesh.topology
    return f"{topology.index_map(topology.dim).size_local} {topology.cell_type.name} cells on this rank"


class _Operator:
    """Kernels of a form with their entities, coefficients and constants on the C++ side."""

    test: FunctionSpace | None  # of the test function; a form of rank 0 has none

    def __init__(
        self,
        form: ufl.Form,
        rank: int,
        width: int,
        part: str | None = None,
        law: Laws | None = None,
        history: PointHistory | None = None,
    ) -> None:
        name = type(self).__name__
        with guard(comm_of(form), name, form=form, width=width, part=part):
            self.mesh = domain_of(form)
            found = len(form.arguments())
            if found != rank:
                raise ValueError(f"{name} takes a form of rank {rank}, this one has {found} arguments")
            if part not in PARTS:
                raise ValueError(f"part is {part!r}: {name} takes 'early', 'outer', 'late' or None")
            arguments.double_precision("the mesh of the form", self.mesh.geometry.x)
            inner = frontend.history_of(law)
            for f in frontend.objects_of(form, law)[0]:
                if f not in inner:
                    arguments.function("a coefficient of the form", f)
            shared = [] if history is None else history.parts
        self.form = form
        self.compiled = compile_form(form, law=law)
        spaces = [a.ufl_function_space() for a in form.arguments()]
        self.test = spaces[0] if spaces else None
        data = next(iter(form.subdomain_data().values()))
        coefficients: dict[str, Function] = {}
        integrals, self._kernels = [], []
        averaged = any(isinstance(f, NodalMean) for f in self.compiled.coefficients)
        tags: list[int] = []
        for kernel in self.compiled.kernels:
            kept = {o["coefficient"] for o in kernel.outputs}
            for number, c in enumerate(kernel.coefficients):
                if number in kept:
                    continue
                function = self.compiled.coefficients[c["position"]]
                if coefficients.setdefault(c["name"], function) is not function:
                    raise ValueError(f"two coefficients are called {c['name']!r}: give each function a name of its own")
            for subdomain in kernel.subdomains:
                given = [d for d in data.get(kernel.integral_type, []) if d is not None]
                if any(d is not given[0] for d in given):
                    raise ValueError(f"the {kernel.integral_type} integrals of one form must share one subdomain_data")
                entities = entities_of(self.mesh, kernel.integral_type, subdomain, given[0] if given else None)
                if averaged and part:  # averages need the displacements of ghosts: no cell is computed without them
                    entities = entities if part == "outer" else entities[:0]
                elif part and self.test is not None:
                    entities = _choose(self.test, entities, kernel.integral_type, part)
                entities = np.ascontiguousarray(entities)
                constants = _constants(self.compiled, kernel)
                known = _history_of_cells(shared, entities) if kernel.outputs and history is not None else None
                integrals.append(_cpp.operators.Integral(kernel.address, entities, constants, known))
                self._kernels.append(kernel)
                tags.append(subdomain)
        self.coefficients, self._tags = coefficients, tags
        self._cpp_object = _cpp.operators.InternalForce_float64(
            self.mesh,
            None if self.test is None else self.test._cpp_object,
            integrals,
            {name: f._cpp_object for name, f in coefficients.items()},
            width,
        )
        for f in coefficients.values():
            if isinstance(f, NodalMean) and part in (None, "outer"):
                names = [name for name, other in coefficients.items() if other is f.displacement]
                self._cpp_object.add_average(nodal_average(f, width), names[0] if names else "")

        parts = [(tag, self._cpp_object.history(i)) for i, tag in enumerate(tags)]
        num_cells = self.mesh.topology.index_map(self.mesh.topology.dim).size_local
        self.history = PointHistory(num_cells, [(tag, p) for tag, p in parts if p is not None])

    def __repr__(self) -> str:
        kinds = [kernel.integral_type for kernel in self._kernels]
        integrals = ", ".join(f"{kinds.count(kind)} {kind}" for kind in dict.fromkeys(kinds))
        read = f", of {', '.join(self.coefficients)}" if self.coefficients else ""
        return f"{type(self).__name__}(integrals: {integrals}{read}; {_cells_of(self.mesh)}, {self.width} at once)"

    @property
    def width(self) -> int:
        """Number of cells that one kernel call computes."""
        return self._cpp_object.width(0)

    @property
    def flops(self) -> float:
        """Number of floating-point operations of one application on this rank."""
        return self._cpp_object.flops

    def sum(self, name: str) -> float:
        """Sum of a law's density over all cells in the last evaluation. Collective.

        Args:
            name: name of one of the law's sums.

        Returns:
            The sum over all ranks; zero where no law has it.
        """
        same(self.mesh.comm, f"{type(self).__name__}.sum", name=name)
        return self.mesh.comm.allreduce(self._cpp_object.sum(name), MPI.SUM)

    def fault(self) -> str:
        """Say which local equations were not solved in the last evaluation. Collective.

        Returns:
            A sentence with their number, and cell, point, residual and unknowns of the first; "" if all were solved.
        """
        return self._cpp_object.fault()

    def _update(self) -> None:
        """Update the ghosts of coefficients, and the constants. Collective."""
        for f in self.coefficients.values():
            f.x.scatter_forward()
        self.update_constants()

    def live(self) -> _cpp.problems.KernelForce:
        """The operator with its constants, whose values bodies in C++ read anew at every call."""
        constants = [constants_of(self.compiled, kernel) for kernel in self._kernels]
        return _cpp.problems.KernelForce(self._cpp_object, constants)

    def update_constants(self) -> None:
        """Copy the present values of the constants to the C++ side."""
        for i, kernel in enumerate(self._kernels):
            if kernel.constants:
                self._cpp_object.set_constants(i, _constants(self.compiled, kernel))


class InternalForce(_Operator):
    """Vector of a linear form, assembled without a matrix for several cells at a time.

    The result equals that of dolfinx.fem.assemble_vector to round-off.

    Args:
        form: UFL form of rank 1 over dx, ds and dS of one mesh; every call reads its functions and constants anew.
        width: cells per kernel call, 1, 4 or 8; 0: the default of the machine.
        part: "outer": only cells with ghost nodes; "early", "late": the first and the second half of the others, all of
            which are early where there are no outer ones; None: all cells.
        law: internal variables and local equations of all cells, or by cell tag (forms/point_law.py); None: none.
            Every evaluation starts from the values of the last `history.commit`.

    Attributes:
        history: internal variables, `PointHistory`; empty without a law.

    Raises:
        TypeError: `form` is not a UFL form, or not of double precision.
        ValueError: a form of another rank, two functions of one name, a subdomain without tags, or another part.
        RuntimeError: kernels cannot be compiled (see jit.compile_form), or do not fit the elements.
    """

    test: FunctionSpace

    def __init__(self, form: ufl.Form, width: int = 0, part: str | None = None, law: Laws | None = None) -> None:
        super().__init__(form, 1, width, part, law)

    def vector(self) -> la.Vector:
        """Make a vector of the test space.

        Returns:
            A vector with zero entries.
        """
        return la.vector(self.test.dofmap.index_map, self.test.dofmap.index_map_bs)

    def apply(self, b: la.Vector | None = None) -> la.Vector:
        """Assemble the vector, complete on owned and ghost entries. Collective.

        Args:
            b: vector to overwrite; None: a new one is made.

        Returns:
            The vector.

        Raises:
            TypeError: `b` is not a vector of float64; on all ranks.
            ValueError: `b` has another size than the test space; on all ranks.
        """
        with guard(self.mesh.comm, "InternalForce.apply"):
            if b is not None and not isinstance(b, la.Vector):
                raise TypeError(f"b must be a dolfinx.la.Vector, found {type(b).__name__}; arrays go to assemble")
            if b is not None:
                self._check_size(b.array)
        b = self.vector() if b is None else b
        self._update()
        self._cpp_object.apply(b._cpp_object)
        return b

    def assemble(self, array: AnyArray) -> None:
        """Add this rank's contributions to an array, as dolfinx.fem.assemble_vector does. Collective.

        Args:
            array: owned and ghost entries, C-contiguous, of type float64.

        Raises:
            TypeError: `array` is not an array of float64; on all ranks.
            ValueError: `array` has another size, is not contiguous or not writeable; on all ranks.
        """
        with guard(self.mesh.comm, "InternalForce.assemble"):
            if not isinstance(array, np.ndarray):
                raise TypeError(f"array must be a NumPy array, found {type(array).__name__}")
            self._check_size(array)
            if array.ndim != 1 or not array.flags.c_contiguous or not array.flags.writeable:
                raise ValueError("array must have one dimension, no gaps, and be writeable: forces are added to it")
        self._update()
        self._cpp_object.assemble(array)

    def _check_size(self, array: AnyArray) -> None:
        arguments.double_precision("the vector", array)
        dofmap = self.test.dofmap
        needed = (dofmap.index_map.size_local + dofmap.index_map.num_ghosts) * dofmap.index_map_bs
        if array.size != needed:
            raise ValueError(f"the vector has {array.size} entries on this rank, the test space has {needed}")


def nodal_average(mean: NodalMean, width: int = 0) -> _cpp.operators.NodalAverage:
    """What computes a function of means at nodes. Collective.

    Args:
        mean: the function.
        width: cells per kernel call, as for InternalForce.

    Returns:
        An object of its own for each operator (C++): it may read the displacement from another place.
    """
    measure, volume = InternalForce(mean.measure, width), InternalForce(mean.volume, width)
    name = next(name for name, f in measure.coefficients.items() if f is mean.displacement)
    return _cpp.operators.NodalAverage(measure._cpp_object, volume._cpp_object, mean._cpp_object, name, mean.is_linear)


def _add_nodal_forces(operator: InternalForce, parts: StrainParts) -> None:
    """Add to the cells' forces those of their nodes' mean strains. Collective."""
    u = parts.mean.displacement
    name = next(name for name, f in operator.coefficients.items() if f is u)
    average = nodal_average(parts.mean)
    operator._cpp_object.add_average(average, name, parts.stress)
    if parts.moduli is not None:
        log_mean, space = parts.cells.mean._cpp_object, u.function_space._cpp_object
        integrals = [i for i, tag in enumerate(operator._tags) if not parts.tags or tag in parts.tags]
        together = _cpp.operators.AveragedNeoHookean(integrals, log_mean, average, space, name, *parts.moduli)
        operator._cpp_object.add_together(together)


def update_means(functions: Iterable[Function]) -> None:
    """Compute the means at nodes among some functions at the present displacement. Collective.

    Args:
        functions: functions that forms read.
    """
    for f in functions:
        if isinstance(f, NodalMean):
            f.own_average = f.own_average or nodal_average(f)
            f.own_average.update()


class Inputs(Described):
    """Constants and coefficients that a form reads; finds whether they have changed since they were last stored.

    Args:
        constants: constants of the form.
        coefficients: coefficients of the form.
        without: functions whose changes do not count.
    """

    def __init__(
        self,
        constants: Iterable[fem.Constant],
        coefficients: Iterable[Function],
        without: Iterable[Function | None] = (),
    ) -> None:
        self._constants = list(constants)
        # Means at nodes follow from the displacement.
        read = [f for f in coefficients if not isinstance(f, NodalMean)]
        self._functions = [f for f in read if not any(f is other for other in without)]
        self.store()

    def store(self) -> None:
        """Update ghosts and store copies of the present values. Collective."""
        for f in self._functions:
            f.x.scatter_forward()
        self._known = [np.array(values) for values in self._values()]

    def changed(self) -> bool:
        """Compare the present values with the stored ones.

        Returns:
            Whether a constant or an owned entry has changed on this rank.
        """
        return any(not np.array_equal(new, old) for new, old in zip(self._values(), self._known))

    def change(self) -> float:
        """Compare the present values with the stored ones, each by itself.

        Returns:
            Largest change on this rank, relative to the stored value; 1 where that is zero [1].
        """
        largest = 0.0
        for new, old in zip(self._values(), self._known):
            size = np.where(old == 0.0, np.maximum(np.abs(new), np.finfo(float).tiny), np.abs(old))
            largest = max(largest, float(np.max(np.abs(new - old) / size, initial=0.0)))
        return largest

    def _values(self) -> Iterator[AnyArray]:
        """Values of the constants, then owned entries of the functions."""
        yield from (c.value for c in self._constants)
        for f in self._functions:
            yield f.x.array[: f.function_space.dofmap.index_map.size_local * f.function_space.dofmap.index_map_bs]


class SplitForce(Described):
    """Vector of a linear form in three parts, for the explicit integrator: cells with ghost nodes, and two halves of
    the others, as `part` of InternalForce.

    Args:
        form: UFL form of rank 1, as for InternalForce.
        displacement: coefficient that the integrator sets to the displacement; None: the form has none.
        velocity: coefficient that the integrator sets to the velocity; None: the form has none.
        law: as for InternalForce; each evaluation ends a step, internal variables are overwritten in place.
        mixed: whether the element vectors are computed in float.
        nodal: means of strains whose forces are added to those of the form.

    Attributes:
        history: internal variables of all parts, `PointHistory`; empty without a law.
    """

    def __init__(
        self,
        form: ufl.Form,
        displacement: Function | None = None,
        velocity: Function | None = None,
        law: Laws | None = None,
        mixed: bool = False,
        nodal: Sequence[StrainParts] = (),
    ) -> None:
        self._parts = [InternalForce(form, part=part, law=law) for part in ("early", "outer", "late")]
        outer = self._parts[1]  # which is computed when the displacements of ghosts are known
        for means in nodal:
            _add_nodal_forces(outer, means)
        self.history = self._parts[0].history + self._parts[1].history + self._parts[2].history
        for operator in self._parts:
            operator._cpp_object.set_in_place(True)
            if mixed:
                operator._cpp_object.set_mixed()
        compiled, coefficients = self._parts[0].compiled, self._parts[0].coefficients
        self._names = {id(f): name for name, f in coefficients.items()}
        self._given = displacement, velocity
        self._inputs = Inputs(compiled.constants, coefficients.values(), self._given)

    def changed(self) -> bool:
        """Compare constants, and coefficients that the integrator does not set, with those of the last `update`.

        Returns:
            Whether one of them has changed on this rank.
        """
        return self._inputs.changed()

    def update(self) -> None:
        """Read constants, and coefficients that the integrator does not set. Collective."""
        self._inputs.store()
        for part in self._parts:
            part.update_constants()

    def fault(self) -> str:
        """Which local equations the last evaluation could not solve; an empty text if all were. Collective."""
        return next(filter(None, [part.fault() for part in self._parts]), "")

    def forces(self) -> _cpp.integrators.FormForces:
        """Make the object of the C++ side.

        Returns:
            All parts, with the names of the displacement and of the velocity among the coefficients.
        """
        given = [self._names.get(id(f), "") for f in self._given]
        early, outer, late = (part._cpp_object for part in self._parts)
        return _cpp.integrators.FormForces(early, outer, late, *given)


class Energy(_Operator):
    """Value of a form of rank 0, for example a strain energy.

    Args:
        form: UFL form of rank 0 over dx, ds and dS of one mesh; every call reads its functions and constants anew.
        width: cells per kernel call, 1, 4 or 8; 0: the default of the machine.
        law: as for InternalForce.
        history: internal variables of an operator with the same cells, rule and width, which are read and left as they
            are; None: those of this object.

    Raises:
        TypeError: as InternalForce.
        ValueError: as InternalForce.
        RuntimeError: as InternalForce.
    """

    def __init__(
        self, form: ufl.Form, width: int = 0, law: Laws | None = None, history: PointHistory | None = None
    ) -> None:
        super().__init__(form, 0, width, law=law, history=history)

    def value(self) -> float:
        """Assemble the value. Collective.

        Returns:
            The sum over all ranks.
        """
        same(self.mesh.comm, "Energy.value")
        self._update()
        return self.mesh.comm.allreduce(self._cpp_object.value(), MPI.SUM)


class Tangent:
    """Matrix of a bilinear form in a PETSc matrix that is created once, with the package's kernels of forms of the
    catalogue, FFCx's of others.

    Integrals over cells with averages, ufl.cell_avg, which FFCx does not know, have kernels of our own.

    Args:
        form: UFL form of rank 2.
        bcs: Dirichlet condition, or a list of them; their rows and columns are zero, with one on the diagonal.

    Raises:
        TypeError: `form` is not a UFL form, or `bcs` are not Dirichlet conditions; on all ranks.
        ValueError: a form of another rank, conditions on another space, or arguments that differ between ranks; on all
            ranks.
    """

    def __init__(self, form: ufl.Form, bcs: DirichletBC | Sequence[DirichletBC] = ()) -> None:
        with guard(comm_of(form, bcs), "Tangent") as ranks:
            if not isinstance(form, ufl.Form):
                raise TypeError(f"Tangent takes a UFL form of rank 2, found {type(form).__name__}")
            if len(form.arguments()) != 2:
                raise ValueError(f"Tangent takes a UFL form of rank 2, this one has {len(form.arguments())} arguments")
            self.bcs = arguments.one_or_list("bcs", bcs, "a DirichletBC", ("dof_indices",))
            for bc in self.bcs:
                arguments.boundary_values("bcs", bc, form.arguments()[0].ufl_function_space())
            ranks.same(form=form, bcs=[arguments.value_of(bc) for bc in self.bcs])
        plain, averaged = split_averages(form)
        test, trial = (a.ufl_function_space() for a in sorted(form.arguments(), key=lambda a: a.number()))
        self._mesh = form.ufl_domain().ufl_cargo()
        built_in = None if plain is None or averaged is not None else find_form(plain)
        if built_in is not None and any(k.integral_type == "interior_facet" for k in built_in.kernels):
            built_in = None  # their matrices are assembled by DOLFINx's kernels
        self.form = None if plain is None or built_in is not None else ffcx_form(plain)
        self._kernels = None if averaged is None else BilinearKernels(averaged, compile_columns(averaged, test))
        if built_in is not None:
            self._kernels = BilinearKernels(form, built_in)
        own = ([], []) if self._kernels is None else (self._kernels.integrals, self._kernels.sources)
        other = None if self.form is None else self.form._cpp_object
        self._cpp_object = _cpp.operators.KernelTangent(test._cpp_object, trial._cpp_object, *own, other)
        self.matrix: PETSc.Mat = self._cpp_object.matrix

    def __repr__(self) -> str:
        rows, columns = self.matrix.getSize()
        return f"Tangent({rows} x {columns}, {len(self.bcs)} boundary conditions; {_cells_of(self._mesh)})"

    def assemble(self) -> PETSc.Mat:
        """Assemble the matrix at the present coefficients. Collective.

        Returns:
            The matrix of this object; the next call overwrites it.
        """
        same(self._mesh.comm, "Tangent.assemble")
        if self._kernels is not None:
            for f in self._kernels.functions:
                f.x.scatter_forward()
            for i, values in enumerate(self._kernels.values()):
                self._cpp_object.set_constants(i, values)
        self._cpp_object.assemble([bc._cpp_object for bc in self.bcs])
        return self.matrix


class PointValues:
    """A UFL expression at given reference points of every owned cell, for example stresses.

    Args:
        expression: UFL expression of DOLFINx functions.
        points: points in the reference cell, (num_points, tdim) [1].

    Raises:
        TypeError: `expression` is not a UFL expression; on all ranks.
        ValueError: `points` have another shape or lie outside the reference cell; on all ranks.
    """

    def __init__(self, expression: ufl.core.expr.Expr, points: ArrayLike) -> None:
        comm = comm_of(*ufl.algorithms.extract_coefficients(expression)) if _is_expression(expression) else None
        with guard(comm, "PointValues") as ranks:
            if not _is_expression(expression):
                raise TypeError(f"PointValues takes a UFL expression, found {type(expression).__name__}")
            domain = ufl.domain.extract_unique_domain(expression)
            self.mesh = _cargo(domain)
            points = arguments.reference_points(points, self.mesh.topology.dim, compat.cell_name(domain))
            ranks.same(shape=expression.ufl_shape, points=points)
        self._shape = expression.ufl_shape
        self.compiled = compile_expression(expression, points)
        self.kernel = self.compiled.kernels[0]
        self.kernel.check_mesh(self.mesh)

    def __repr__(self) -> str:
        points = self.kernel.shape[0]
        return f"PointValues(values of shape {self._shape} at {points} points; {_cells_of(self.mesh)})"

    def values(self) -> FloatArray:
        """Evaluate the expression at the present coefficients. Collective.

        Returns:
            Values, (num_owned_cells, num_points, num_components).
        """
        same(self.mesh.comm, "PointValues.values")
        num_cells = self.mesh.topology.index_map(self.mesh.topology.dim).size_local
        points, components = self.kernel.shape
        out = np.zeros((num_cells, points, components))
        c = _constants(self.compiled, self.kernel)
        parts = []
        for e in self.kernel.coefficients:
            f = self.compiled.coefficients[e["position"]]
            f.x.scatter_forward()
            dofmap = f.function_space.dofmap
            parts.append((e["offset"], f.x.array.reshape(-1, dofmap.bs)[dofmap.list[:num_cells]]))
        columns = [v.reshape(num_cells, math.prod(v.shape[1:])) for _, v in sorted(parts, key=lambda part: part[0])]
        w = np.hstack(columns) if columns else np.empty((num_cells, 0))
        x = self.mesh.geometry.x[compat.geometry_dofmap(self.mesh)[:num_cells]]
        self.kernel.tabulate_cells(out.reshape(-1), w.reshape(-1), c, x.reshape(-1), num_cells)
        return out


def strain_energy_form(u: Function, material: Material) -> ufl.Form:
    """UFL form of the strain energy.

    Args:
        u: displacement function [L].
        material: material of the body.

    Returns:
        Form of rank 0 [F L].
    """
    return sum_laws(u, material, lambda law, dx: elasticity.internal_energy(u, law, dx))


def internal_force_form(u: Function, v: ufl.Argument, material: Material) -> ufl.Form:
    """UFL form of the internal virtual work.

    Args:
        u: displacement function [L].
        v: test function.
        material: material of the body.

    Returns:
        Form of rank 1.
    """
    return sum_laws(u, material, lambda law, dx: elasticity.internal_force(u, v, law, dx))


def tangent_form(u: Function, du: ufl.Argument, v: ufl.Argument, material: Material) -> ufl.Form:
    """UFL form of the derivative of the internal virtual work.

    Args:
        u: displacement function at which the derivative is taken [L].
        du: trial function, its direction.
        v: test function.
        material: material of the body.

    Returns:
        Form of rank 2.
    """
    return sum_laws(u, material, lambda law, dx: elasticity.tangent(u, du, v, law, dx))


def partial_tangent_form(u: Function, du: ufl.Argument, v: ufl.Argument, material: Material) -> ufl.Form:
    """UFL form of the derivative of the internal virtual work at given means at the nodes; of materials without them
    that of `tangent_form`.

    Args:
        u: displacement function at which the derivative is taken [L].
        du: trial function, its direction.
        v: test function.
        material: material of the body.

    Returns:
        Form of rank 2.
    """

    def term(law: Any, dx: Any) -> Any:
        if not hasattr(law, "mean"):
            return elasticity.tangent(u, du, v, law, dx)
        return ufl.derivative(elasticity.internal_force(u, v, law, dx), u, du)

    return sum_laws(u, material, term)


def cells_measure(u: Function, material: Material) -> tuple[ufl.Measure, int]:
    """Measure of the cells with the quadrature degree of the stiffness.

    Args:
        u: displacement function.
        material: material of the body, whose cell tags are the measure's subdomain data.

    Returns:
        The measure, and its quadrature degree [1].
    """
    V = u.function_space
    mesh = V.mesh
    cell, p, g = mesh.topology.cell_name(), V.element.basix_element.degree, compat.coordinate_element(mesh).degree
    check_integration(u, material)
    reduced = material.integration == REDUCED
    degree = (
        quadrature.one_point_degree()
        if reduced
        else quadrature.stiffness_degree(cell, p, g, material.hypothesis_on(mesh))
    )
    metadata = quadrature.metadata(degree)
    return ufl.Measure("dx", domain=mesh, metadata=metadata, subdomain_data=material.cell_tags), degree


def sum_materials(
    u: Function, material: Material, term: Callable[[_Material, ufl.Measure], ufl.Form], inertia: bool = False
) -> ufl.Form:
    """Sum of UFL forms over the materials of a body, with the quadrature degree of the stiffness or of the mass.

    Args:
        u: displacement function.
        material: material of the body.
        term: form of one material over the measure of its cells.
        inertia: take the quadrature degree of the mass.

    Returns:
        The sum of term(m, dx) over the materials m.
    """
    dx, _ = cells_measure(u, material)
    if inertia:
        V, mesh = u.function_space, u.function_space.mesh
        cell, p, g = mesh.topology.cell_name(), V.element.basix_element.degree, compat.coordinate_element(mesh).degree
        dx = dx(metadata=quadrature.metadata(quadrature.mass_degree(cell, p, g, material.hypothesis_on(mesh))))
    return sum(term(m, dx if tag is None else dx(tag)) for tag, m in material.parts())


def sum_laws(u: Function, material: Material, term: Callable[[Law, ufl.Measure], ufl.Form]) -> Any:
    """Sum of UFL forms over the elastic laws of the materials of a body; 0 if there are none."""
    dx, _ = cells_measure(u, material)
    parts = [(tag, m) for tag, m in material.parts() if not isinstance(m, InelasticMaterial)]
    return sum(term(elastic_law_of(u, m, material), dx if tag is None else dx(tag)) for tag, m in parts)


def elastic_law_of(u: Function, material: _Material, whole: Material) -> Any:
    """Elastic law of some cells of a body, which reads the means at the nodes if its pressure is averaged. Collective.

    Args:
        u: displacement function [L].
        material: elastic material of the cells.
        whole: material of the body.
    """
    if not is_averaged(material):
        return material.law(u.function_space.mesh)
    return mean_of(u, material, whole, cells_measure(u, whole)[0]).law
