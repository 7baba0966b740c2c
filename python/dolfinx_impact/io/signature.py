# SPDX-License-Identifier: MIT
"""Signature of a problem in time: a checkpoint is accepted by problems with the same signature.

The signature does not depend on the number of ranks. Texts and integers are compared exactly. Sums over nodes are
compared to round-off, as the order of the summation depends on the ranks.
"""

import hashlib
from collections.abc import Mapping, Sequence
from typing import Any, Protocol, TypeAlias

import numpy as np
import ufl
from dolfinx import cpp, fem, la
from dolfinx.mesh import Mesh, MeshTags
from mpi4py import MPI

from ..common.types import FloatArray, IntArray
from ..assembly import operators
from ..foundation import Foundation, foundations
from ..loads import DeadLoad, Load
from ..materials import MaterialMap, Rayleigh, _Material

LONG = 2000  # characters; the rest of a longer text is replaced by a checksum

Signature: TypeAlias = dict[str, str | int | FloatArray]


class Pair(Protocol):
    """What a signature reads of a contact pair; see contact.pair.ContactPair."""

    @property
    def facet_tags(self) -> MeshTags:
        """Tags of facets."""

    @property
    def slave(self) -> int:
        """Tag of the slave's facets."""

    @property
    def master(self) -> Any:
        """Tag of the master's facets, or a rigid obstacle."""

    @property
    def rigid(self) -> bool:
        """Whether the master is a rigid obstacle."""

    @property
    def friction(self) -> float:
        """Friction coefficient [1]."""

    @property
    def search_distance(self) -> float | None:
        """Search distance; None: chosen by the contact [L]."""


class Contact(Protocol):
    """What a signature reads of a contact; see contact.explicit.nodal.NodalResult."""

    @property
    def pair(self) -> Pair:
        """Contact pair."""

    @property
    def options(self) -> Mapping[str, object]:
        """Options of the contact by name."""

    @property
    def kind(self) -> str:
        """Name of the method that enforces the contact."""


class Functions(Protocol):
    """Functions of time of a problem; see dynamics.functions_of_time.FunctionsOfTime."""

    def table(self, times: FloatArray) -> FloatArray:
        """Values at times.

        Args:
            times: times, (num_times) [T].

        Returns:
            Values, (num_times, num_columns).
        """


class Problem(Protocol):
    """What a checkpoint reads of a problem in time, explicit or implicit."""

    comm: MPI.Intracomm
    space: fem.FunctionSpace
    num_owned: int
    mass: la.Vector
    material: _Material | MaterialMap | None
    damping: Rayleigh
    loads: list[Load]
    supports: list[tuple[IntArray, FloatArray, int]]
    bulk_viscosity: tuple[float, float]
    residual_form: ufl.Form | None
    given_density: float | ufl.core.expr.Expr | None

    @property
    def scheme(self) -> object:
        """Scheme; its text is compared."""

    @property
    def lumping(self) -> str | None:
        """Lumping scheme."""

    @property
    def mass_scaling(self) -> float | None:
        """Step to which cells are scaled, or None [T]."""

    @property
    def dead_loads(self) -> Sequence[DeadLoad]:
        """Loads that do not follow the body, as nodal forces."""

    @property
    def contact(self) -> Sequence[Contact]:
        """Contacts."""


def signature(problem: Problem, x: FloatArray) -> Signature:
    """Signature of a problem. Collective.

    Args:
        problem: problem in time.
        x: undeformed coordinates of this rank's owned nodes, (num_nodes, gdim) [L].

    Returns:
        Texts, integers and arrays by name; the names of arrays begin with "sums".
    """
    V, mesh, comm = problem.space, problem.space.mesh, problem.comm
    n, bs = V.dofmap.index_map.size_local, V.dofmap.index_map_bs
    mass = problem.mass.array[: n * bs].reshape(n, bs)[:, 0]
    out: Signature = {
        "cell": mesh.topology.cell_name(),
        "degree": int(V.element.basix_element.degree),
        "degree of the geometry": int(mesh.geometry.cmap.degree),
        "num_cells": int(mesh.topology.index_map(mesh.topology.dim).size_global),
        "num_nodes": int(V.dofmap.index_map.size_global),
        "material": _material(problem),
        "damping": f"alpha {problem.damping.alpha!r}, beta {problem.damping.beta!r}",
        "bulk viscosity": repr(problem.bulk_viscosity),
        "lumping": repr(problem.lumping),
        "mass scaling": repr(problem.mass_scaling),
        "scheme": str(problem.scheme),
        "loads": "; ".join(_load(load, mesh) for load in problem.loads),
        "contact": "; ".join(_contact(c, mesh) for c in problem.contact),
        "sums of masses": comm.allreduce(np.concatenate([[mass.sum()], mass @ x, mass @ x**2]), MPI.SUM),
    }
    for k, load in enumerate(problem.dead_loads):
        # Present forces: the value of the load may have changed since the last step.
        forces = np.zeros(n * bs)
        forces[load.dofs] = load.forces()
        values = forces.reshape(n, bs)
        out[f"sums of load {k}"] = comm.allreduce(
            np.concatenate([[np.abs(values).sum()], values.sum(axis=0), *(values.T @ x)]), MPI.SUM
        )
    for k, springs in enumerate(foundations(problem.loads)):
        out[f"sums of foundation {k}"] = _foundation(problem, springs, x)
    return {name: short(value) if isinstance(value, str) else value for name, value in out.items()}


def _foundation(problem: Problem, springs: Foundation, x: FloatArray) -> FloatArray:
    """Sums of the nodal forces of springs and dashpots under the displacement and velocity one. Collective."""
    assert problem.material is not None  # loads go with materials
    V, hypothesis, sums = problem.space, problem.material.hypothesis_on(problem.space.mesh), []
    one = fem.Function(V, name="u")
    one.x.array[:] = 1.0
    for work in (springs.springs, springs.dashpots):
        nodal = operators.InternalForce(work(one, ufl.TestFunction(V), hypothesis)).apply().array
        values = nodal[: x.shape[0] * V.dofmap.index_map_bs].reshape(-1, V.dofmap.index_map_bs)
        sums.append(np.concatenate([[np.abs(values).sum()], values.sum(axis=0), *(values.T @ x)]))
    return problem.comm.allreduce(np.concatenate(sums), MPI.SUM)


def supports(problem: Problem) -> tuple[IntArray, FloatArray]:
    """Prescribed degrees of freedom.

    Args:
        problem: problem in time.

    Returns:
        Owned nodes with prescribed components, (n); and rows (n, 3 * components) that have, for all components, whether
        they are prescribed (1 or 0), then their values [L], then the numbers of their functions of time (-1: none).
    """
    bs = problem.space.dofmap.index_map_bs
    rows = np.zeros((problem.num_owned, 3))
    rows[:, 2] = -1
    for dofs, values, column in problem.supports:
        rows[dofs] = np.column_stack([np.ones(len(dofs)), values, np.full(len(dofs), column)])
    rows = rows.reshape(-1, bs, 3)
    nodes = np.flatnonzero(rows[:, :, 0].any(axis=1))
    return nodes, np.ascontiguousarray(rows[nodes].transpose(0, 2, 1)).reshape(-1, 3 * bs)


def functions_of_time(functions: Functions, time: float, beyond: float) -> FloatArray:
    """Sample all functions of time up to the present.

    Args:
        functions: functions of time of a problem.
        time: present time [T].
        beyond: time of the next step [T].

    Returns:
        Values as a flat array.
    """
    times = np.append(np.linspace(0.0, time, 5), beyond)
    return functions.table(times).ravel()


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


def _marks(comm: MPI.Intracomm, numbers: IntArray) -> str:
    """Count and checksum of the numbers of all ranks, independent of their order. Collective."""
    x = np.asarray(numbers, dtype=np.uint64) + np.uint64(0x9E3779B97F4A7C15)
    for factor, shift in ((0xBF58476D1CE4E5B9, 30), (0x94D049BB133111EB, 27)):  # as the generator splitmix64 mixes
        x = (x ^ (x >> np.uint64(shift))) * np.uint64(factor)
    sums = np.array([len(x), (x ^ (x >> np.uint64(31))).sum(dtype=np.uint64)], dtype=np.uint64)
    comm.Allreduce(MPI.IN_PLACE, sums, MPI.SUM)
    return f"{sums[0]} of checksum {sums[1]:x}"


def _cells(tags: MeshTags, tag: int) -> str:
    """Checksum of the cells with a tag, by their numbers in the mesh's input. Collective."""
    topology = tags.topology
    cells = tags.find(tag)
    cells = cells[cells < topology.index_map(topology.dim).size_local]
    return f"cells {_marks(topology.comm, topology.original_cell_index[cells])}"


def _facets(mesh: Mesh, tags: MeshTags, tag: int) -> str:
    """Checksum of the boundary facets with a tag, by the numbers of their cells in the mesh's input and their local
    numbers in the cells. Collective."""
    topology, dim = mesh.topology, mesh.topology.dim
    topology.create_connectivity(dim - 1, dim)
    topology.create_connectivity(dim, dim - 1)
    to_cell, to_facet = topology.connectivity(dim - 1, dim), topology.connectivity(dim, dim - 1)
    facets = tags.find(tag)
    cells = to_cell.array[to_cell.offsets[facets]]
    own = cells < topology.index_map(dim).size_local
    facets, cells = facets[own], cells[own]
    around = to_facet.array.reshape(-1, cpp.mesh.cell_num_entities(topology.cell_type, dim - 1))[cells]
    local = np.argmax(around == facets[:, None], axis=1)
    return f"facets {_marks(mesh.comm, 8 * topology.original_cell_index[cells] + local)}"


def _material(problem: Problem) -> str:
    """Material, or residual and density; collective."""
    if problem.material is not None:
        tags = problem.material.cell_tags
        parts = [
            repr(m) if tag is None or tags is None else f"{tag}: {m!r} on {_cells(tags, tag)}"
            for tag, m in problem.material.parts()
        ]
        return ", ".join(parts)
    assert problem.residual_form is not None
    constants = [np.asarray(c.value).tolist() for c in problem.residual_form.constants()]
    density = problem.given_density
    if isinstance(density, ufl.core.expr.Expr):
        density = (density * ufl.dx(domain=problem.space.mesh)).signature()[:32]
    return f"a residual of one's own, {problem.residual_form.signature()[:32]}, {constants!r}, density {density!r}"


def _load(load: Load, mesh: Mesh) -> str:
    """Type, facets and present value of a load. Collective."""
    words = [type(load).__name__]
    if hasattr(load, "per_mass"):
        words.append("per mass" if load.per_mass else "per volume")
    if hasattr(load, "tag") and hasattr(load, "facet_tags"):
        words.append(f"tag {load.tag}, {_facets(mesh, load.facet_tags, load.tag)}")
    constant = getattr(load, "constant", None)
    if isinstance(constant, fem.Constant):
        words.append(f"constant.value {np.asarray(constant.value).tolist()!r}")
    words.append("with an amplitude" if getattr(load, "amplitude", None) is not None else "without amplitude")
    return ", ".join(words)


def _contact(contact: Contact, mesh: Mesh) -> str:
    """Pair, law and options of a contact. Collective."""
    pair = contact.pair
    master = pair.master
    if pair.rigid:
        master = master.description()
    else:
        master = f"master {master}, {_facets(mesh, pair.facet_tags, master)}"
    slave = f"slave {pair.slave}, {_facets(mesh, pair.facet_tags, pair.slave)}"
    options = ", ".join(f"{name} {value!r}" for name, value in sorted(contact.options.items()))
    limits = f"friction {pair.friction!r}, search distance {pair.search_distance!r}"
    return f"{slave}, {master}, {limits}, {contact.kind}, {options}"
