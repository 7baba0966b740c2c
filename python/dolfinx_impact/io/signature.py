# SPDX-License-Identifier: MIT
"""Signature of a problem in time: a checkpoint is accepted by problems with the same signature.

The signature has every argument of the problem and of what it is made of, one entry each (given_arguments.py), but its
state, which the checkpoint replaces. It does not depend on the number of ranks. Texts and integers are compared
exactly. Sums over nodes are compared to round-off, as the order of the summation depends on the ranks.
"""

from collections.abc import Mapping, Sequence
from typing import Any, Protocol, TypeAlias

import numpy as np
import ufl
from dolfinx import fem, la
from dolfinx.mesh import MeshTags
from mpi4py import MPI

from .. import compat
from ..common.types import FloatArray, IntArray
from ..foundation import Foundation, foundations
from ..loads import DeadLoad, Load
from ..materials import MaterialMap, Rayleigh, _Material
from .given_arguments import SUMS, GivenArguments

SAMPLES = 65  # times at which functions of time are compared

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
    def friction(self) -> Any:
        """Friction coefficient, or a law with an `identity` [1]."""

    @property
    def search_distance(self) -> float | None:
        """Search distance; None: chosen by the contact [L]."""


class Contact(Protocol):
    """What a signature reads of a contact; see contact.explicit.nodal.NodalPair."""

    @property
    def pair(self) -> Pair:
        """Contact pair."""

    @property
    def options(self) -> Mapping[str, object]:
        """Options of the contact by name."""

    def facets(self) -> tuple[Any, Any]:
        """Facets of slave and master on this rank (C++); of rigid masters None or the obstacle."""

    @property
    def kind(self) -> str:
        """Name of the method that enforces the contact."""


class Functions(Protocol):
    """Functions of time of a problem; see dynamics.functions_of_time.FunctionsOfTime."""

    def table(self, times: FloatArray) -> FloatArray: ...


class Problem(Protocol):
    """What a checkpoint reads of a problem in time, explicit or implicit."""

    comm: MPI.Intracomm
    u: fem.Function
    velocity: fem.Function
    acceleration: fem.Function
    axisymmetric: bool
    space: fem.FunctionSpace
    num_owned: int
    mass: la.Vector
    material: _Material | MaterialMap | None
    damping: Rayleigh
    loads: tuple[Load, ...]

    @property
    def supports(self) -> Sequence[tuple[IntArray, FloatArray, int]]:
        """Owned degrees of freedom of each support, their values [L] and the column of their function of time."""

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
    given = GivenArguments(mesh, (problem.u, problem.velocity, problem.acceleration))
    out: Signature = given.table
    out |= {
        "cell": mesh.topology.cell_name(),
        "degree": int(V.element.basix_element.degree),
        "degree of the geometry": int(compat.coordinate_element(mesh).degree),
        "hypothesis": "axisymmetric" if problem.axisymmetric else "not axisymmetric",
    }
    if problem.material is not None:
        given.add_material("material", problem.material)
    else:
        given.add("residual", problem.residual_form)
        given.add("density", problem.given_density)
    given.add_attributes("damping", problem.damping)
    for name in ("bulk_viscosity", "lumping", "mass_scaling", "impact"):
        given.add(name, getattr(problem, name, None))
    given.add("scheme", problem.scheme)
    precision = getattr(problem, "precision", "double")
    if precision != "double":  # older checkpoints, which are all of double precision, do not name it
        out["scheme"] = f"{out['scheme']}, {precision} precision"
    out["loads"] = ", ".join(type(load).__name__ for load in problem.loads)
    for k, load in enumerate(problem.loads):
        given.add_load(f"loads[{k}]", load)
    out["contact"] = ", ".join(contact.kind for contact in problem.contact)
    for k, contact in enumerate(problem.contact):
        given.add_contact(f"contact[{k}]", contact.kind, contact.options, contact.pair, contact.facets())
    out[f"{SUMS}masses"] = comm.allreduce(np.concatenate([[mass.sum()], mass @ x, mass @ x**2]), MPI.SUM)
    for k, load in enumerate(problem.dead_loads):
        # Present forces: the value of the load may have changed since the last step.
        forces = np.zeros(n * bs)
        forces[load.dofs] = load.forces()
        values = forces.reshape(n, bs)
        out[f"{SUMS}loads[{k}]"] = comm.allreduce(
            np.concatenate([[np.abs(values).sum()], values.sum(axis=0), *(values.T @ x)]), MPI.SUM
        )
    for k, springs in enumerate(foundations(problem.loads)):
        out[f"{SUMS}foundation {k}"] = _foundation(problem, springs, x)
    return out


def _foundation(problem: Problem, springs: Foundation, x: FloatArray) -> FloatArray:
    """Sums of the nodal forces of springs and dashpots under the displacement and velocity one. Collective."""
    assert problem.material is not None  # loads go with materials
    V, hypothesis, sums = problem.space, problem.material.hypothesis_on(problem.space.mesh), []
    for values in springs.unit_forces(V, hypothesis):
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
    times = np.append(np.linspace(0.0, time, SAMPLES), beyond)
    return functions.table(times).ravel()
