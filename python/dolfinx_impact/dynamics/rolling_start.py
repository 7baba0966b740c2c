# SPDX-License-Identifier: MIT
"""Steady rolling as the start of an explicit run: moving supports, springs that bear the steady tractions."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from dolfinx import default_scalar_type, fem

from .. import _cpp
from ..amplitude import PrescribedMotion
from ..common.types import BoolArray, FloatArray
from ..contact.pair import ContactPair
from ..contact.penalty.penalty import Penalty
from ..materials import LinearElastic
from ..plasticity import J2Plasticity
from ..rolling.motions import Spin, Translation
from ..rolling.rolling_problem import RollingProblem
from .started_problem import StartedProblem

ALONG = 1e-12  # of a unit vector: an axis is a coordinate axis


def check(rolling: RollingProblem, given: dict[str, Any]) -> None:
    """Refuse what cannot go on in time, on this rank.

    Args:
        rolling: the steady state.
        given: further arguments of the explicit problem.

    Raises:
        TypeError: `rolling` is no RollingProblem, or an argument follows from it.
        ValueError: bodies that turn and whose law takes a turn for a strain; loads without instruction; several
            contacts.
    """
    if not isinstance(rolling, RollingProblem):
        raise TypeError(f"from_rolling takes a RollingProblem, found {type(rolling).__name__}")
    twice = sorted({"u", "material", "velocity", "residual", "contact"} & set(given))
    if twice:
        raise TypeError(f"{', '.join(twice)}: given by the RollingProblem")
    if len(rolling.contact) > 1:
        raise ValueError(f"from_rolling hands over one contact, the problem has {len(rolling.contact)}")
    if rolling.loads and "loads" not in given:
        raise ValueError("the RollingProblem has loads: give the loads of the material that moves, loads=[...]")
    turning = np.unique(np.concatenate([np.zeros(0, dtype=np.int32), *(
        rolling.cell_tags.find(tag) for tag, motion in rolling.motions.items() if isinstance(motion, Spin)
    )]))  # fmt: skip
    for tag, law in rolling.material.parts():
        small = isinstance(law, LinearElastic) or (isinstance(law, J2Plasticity) and not law.finite_strain)
        tags = rolling.material.cell_tags
        cells = turning if tag is None or tags is None else np.intersect1d(turning, tags.find(tag))
        if small and len(cells):
            raise ValueError(
                f"{type(law).__name__} of small strain takes the turn of a body for a strain: take StVenantKirchhoff, "
                "or another law of finite strain, for the body that spins, in the RollingProblem as well"
            )


def moving_supports(rolling: RollingProblem, u: FloatArray) -> list[PrescribedMotion]:
    """Supports of the rolling problem, which move on with their bodies. Collective.

    A support of a body that spins turns about its displaced axis; that of a straight flow moves with the velocity. Each
    value that is prescribed at the start is a function of time of its own.

    Args:
        rolling: the steady state.
        u: displacement at the start, owned and ghost dofs [L].

    Raises:
        ValueError: a node of a spinning body is held in some directions only, and not just along the axis; on all
            ranks.
    """
    V = rolling.u.function_space
    gdim, comm = V.mesh.geometry.dim, V.mesh.comm
    held: BoolArray = np.zeros(len(u), dtype=bool)
    for bc in rolling.bcs:
        held[bc.dof_indices()[0]] = True
    held = held.reshape(-1, gdim)
    u = u.reshape(-1, gdim)
    place = V.tabulate_dof_coordinates()[:, :gdim] + u
    out: list[PrescribedMotion] = []
    for motion in dict.fromkeys(rolling.motions.values()):
        nodes = rolling.nodes_of(motion)
        nodes = nodes[held[nodes].any(axis=1)]
        if isinstance(motion, Spin):
            # On a plane of symmetry across the axis nodes are held along the axis only, which no turn changes.
            turning = np.abs(motion.axis[:gdim]) < 1.0 - ALONG
            all_of_it = held[nodes].all(axis=1) | ~held[nodes][:, turning].any(axis=1)
            if comm.allreduce(int(not np.all(all_of_it))):
                raise ValueError(
                    "a node of a spinning body is held in some directions only, and cannot turn with the body: give "
                    "the supports of the run, bcs=[...]"
                )
            arm = np.zeros((len(nodes), 3))
            arm[:, :gdim] = place[nodes] - motion.point
            arm -= rolling.axle(motion)
            across = np.cross(motion.axis, arm)
            inward = np.cross(motion.axis, across)
        for c in range(gdim):
            here = held[nodes, c]
            start = u[nodes[here], c]
            if isinstance(motion, Spin):
                rows = np.column_stack([start, across[here, c], inward[here, c]])
            else:
                rows = np.column_stack([start, np.full(len(start), motion.velocity[c])])
            for row in np.unique(np.vstack(comm.allgather(rows)), axis=0):
                same = np.all(rows == row, axis=1)
                dofs = (nodes[here][same] * gdim + c).astype(np.int32)
                one = fem.dirichletbc(default_scalar_type(1.0), dofs, V.sub(c))
                out.append(PrescribedMotion(one, _path(row, motion)))
    return out


def _path(row: FloatArray, motion: Spin | Translation) -> Callable[[float], float]:
    """Displacement of a support in one direction as a function of time."""
    if isinstance(motion, Translation):
        return lambda t: float(row[0] + row[1] * t)
    omega = motion.omega
    return lambda t: float(row[0] + row[1] * np.sin(omega * t) + row[2] * 2.0 * np.sin(0.5 * omega * t) ** 2)


def _driven(pair: ContactPair) -> ContactPair:
    """The pair, with a rigid master that moves with its velocity in time."""
    if not pair.rigid or pair.rigid_master.motion is not None:
        return pair
    velocity = pair.rigid_master.velocity
    driven: ContactPair = pair._copy(master=pair.rigid_master._copy(_motion=lambda t: velocity * t))
    return driven


def make(
    kind: Callable[..., StartedProblem], rolling: RollingProblem, penalty: float | str, given: dict[str, Any]
) -> Any:
    """Make the explicit problem; arguments are checked. Collective.

    Args:
        kind: ExplicitProblem.
        rolling: the steady state.
        penalty: of the contact [F/L^3].
        given: further arguments of the explicit problem.
    """
    velocity = rolling.velocity()
    more = {name: value for name, value in given.items() if name != "bcs"}

    def build(u: fem.Function) -> StartedProblem:
        bcs = given["bcs"] if "bcs" in given else moving_supports(rolling, u.x.array)
        contact = [Penalty(_driven(c.pair), penalty=penalty) for c in rolling.contact]
        return kind(u, rolling.material, velocity=velocity, contact=contact, bcs=bcs, **more)

    u = rolling.u.copy()
    u.name = rolling.u.name
    problem = build(u)
    if not rolling.contact:
        return problem
    steady = rolling.contact[0]._cpp_object
    start = _cpp.problems.SpringStart(steady, problem._cpp_object, 0, supports_move=True)
    moved = fem.Function(u.function_space, name=u.name)
    moved.x.array[:] = u.x.array
    start.move(moved.x.array, start.approach())
    problem = build(moved)
    _cpp.problems.SpringStart(steady, problem._cpp_object, 0, supports_move=True).hand_over()
    problem.restart_forces()
    return problem
