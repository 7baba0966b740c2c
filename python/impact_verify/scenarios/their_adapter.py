# SPDX-License-Identifier: MIT
"""Scenarios with the hand-written solver, impact_reference."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import impact_reference
import numpy as np
from impact_reference import ExplicitResult, NewmarkResult, NewmarkScheme
from impact_reference.array_types import TimeValues

from dolfinx_impact.common.types import FloatArray, IntArray
from dolfinx_impact.dynamics.run_history import ENERGIES
from ..contact_bodies import MASTER, SLAVE, rule
from .general_runs import OUTSIDE
from .record import Record, largest
from .scenario import PENALTY, TANGENTIAL, Explicit, Implicit, Scenario


def run(case: Scenario, time: FloatArray) -> Record:
    """Make a run.

    Args:
        case: scenario.
        time: time levels, shape (num_levels); those of explicit runs have equal distances [T].

    Returns:
        What came out.
    """
    if isinstance(case.scheme, Explicit):
        steps = len(time) - 1
        return _explicit_record(explicit_result(case, case.scheme, float(time[1]), steps), case.body.order, steps)
    return implicit_record(_run_implicit(case, case.scheme, time), case.body.order)


def _initial_velocity(case: Scenario) -> FloatArray:
    body = case.body
    v0: FloatArray = np.empty(len(body.order))
    v0[body.order] = case.velocity(body.V.tabulate_dof_coordinates()[:, : body.gdim]).ravel()
    return v0


def _loads(case: Scenario) -> list[Any] | None:
    if case.gravity is None:
        return None
    return [(case.body.model.body_force(np.asarray(case.gravity[0])), case.gravity[1])]


def _along_last_axis(case: Scenario) -> FloatArray:
    """Of each prescribed degree of freedom, whether it is along the last axis, as a number."""
    gdim = case.body.gdim
    return (case.fixed_dofs % gdim == gdim - 1).astype(float)


def explicit_result(case: Scenario, scheme: Explicit, dt: float, steps: int) -> ExplicitResult:
    """Make an explicit run.

    Args:
        case: scenario.
        scheme: its scheme.
        dt: time step [T].
        steps: number of steps.

    Returns:
        Result of the hand-written solver, in its own order of nodes.
    """
    body, motion = case.body, case.motion
    values: TimeValues = 0.0
    if motion is not None:
        along_last_axis = _along_last_axis(case)
        values = lambda t: along_last_axis * motion(t)  # noqa: E731
    return body.model.run_explicit(
        dt, steps, v0=_initial_velocity(case), fixed_dofs=body.order[case.fixed_dofs], values=values,
        loads=_loads(case), alpha=case.damping[0], beta=case.damping[1], scheme=scheme.velocities,
        viscosity=scheme.viscosity, contacts=_nodal_contacts(case, dt),
    )  # fmt: skip


def _nodal_contacts(case: Scenario, dt: float) -> list[Any]:
    if not case.contact:
        return []
    body = case.body
    if case.contact == "general":
        return [impact_reference.GeneralContact(body.their_facets(body.tags, OUTSIDE), body.friction)]
    kind = impact_reference.NodalPenalty if case.contact == "penalty" else impact_reference.NodalKinematic
    slave = body.their_facets(body.tags, SLAVE)
    options = {**case.options, **body.adjustment}
    if body.rigid:
        master: Any = body.rigid[1]
        options["motion"] = case.obstacle
        if isinstance(master, impact_reference.RigidBall):
            # Our springs without a given penalty are made for 0.9 of the stable step, or for longer ones that are made.
            options["stiffness_step"] = dt * max(0.9 / case.step_fraction, 1.0)
        elif case.angle is not None:
            options["angle"] = case.angle
    else:
        master = body.their_facets(body.tags, MASTER)
    if case.smooth is not None:
        x = body.mesh.geometry.x[master]
        normals = case.smooth(x.reshape(-1, 3).T[: body.gdim]).T
        options["master_normals"] = normals.reshape(*master.shape, body.gdim)
    return [kind(slave, master, body.friction, **options)]


def _explicit_record(result: ExplicitResult, order: IntArray, steps: int) -> Record:
    """Energies and forces are known one step later than states: those of the last level are left out, as on our
    side."""
    energies = {name: result.energies[name][:steps] for name in ENERGIES}
    paired = result.contacts and np.any(result.contacts[0].total)
    force = result.contacts[0].total[:steps] if paired else None
    fields = {"displacement": result.u[:, order], "velocity": result.v[:, order]}
    return Record(np.arange(steps + 1.0), fields, energies, largest(result.energies), force)


def scheme_of(parameters: dict[str, Any]) -> NewmarkScheme:
    """Scheme of the hand-written solver.

    Args:
        parameters: of NewmarkProblem.

    Returns:
        Scheme with these parameters.
    """
    if "rho_inf" in parameters:
        return NewmarkScheme.chung_hulbert(parameters["rho_inf"])
    if "hht" in parameters:
        return NewmarkScheme.hht(parameters["hht"])
    return NewmarkScheme(**parameters)


def motion_tables(motion: Callable[[float], float], time: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """A motion and its derivatives at time levels, by central differences over a hundredth of a step to either side; at
    the start a hundredth of the first step later, because there is no time before it.

    Args:
        motion: displacement as a function of time [L].
        time: time levels, shape (num_levels) [T].

    Returns:
        Displacements [L], velocities [L/T] and accelerations [L/T^2], shape (num_levels, 1) each.
    """
    steps = np.diff(time, prepend=time[0] - (time[1] - time[0]))
    rows = []
    for t, h in zip(time, steps):
        d = float(h) / 100
        middle = max(float(t), d)
        before, now, after = motion(middle - d), motion(middle), motion(middle + d)
        rows.append((motion(float(t)), (after - before) / (2 * d), (after - 2 * now + before) / d**2))
    u, v, a = (np.array(column)[:, None] for column in zip(*rows))
    return u, v, a


def _run_implicit(case: Scenario, scheme: Implicit, time: FloatArray) -> NewmarkResult:
    body = case.body
    body.prescribed = case.fixed_dofs
    motion = None
    if case.motion is not None:
        along_last_axis = _along_last_axis(case)
        u, v, a = (table * along_last_axis for table in motion_tables(case.motion, time))
        motion = u, v, a
    return body.model.run_newmark(
        np.diff(time), scheme=scheme_of(scheme.parameters), v0=_initial_velocity(case),
        fixed_dofs=body.order[case.fixed_dofs], motion=motion, loads=_loads(case), damping=case.damping,
        lumping=scheme.lumping or "consistent", contact=_implicit_contact(case), redistribute=scheme.impact != "none",
        # A rigid body's places are many, and the residual at some of them stays just above that of the others.
        tolerance=1e-13 if body.moving is None else 1e-12,
    )  # fmt: skip


def _implicit_contact(case: Scenario) -> Any:
    if not case.contact:
        return None
    body = case.body
    facet = rule(body.facet, 2 * body.degree + 2)
    if case.contact == "penalty":
        touching = impact_reference.ImplicitContact(body.theirs(facet), PENALTY, TANGENTIAL)
    else:
        points = facet if body.rigid else rule(body.segment, 3 * body.degree + 4)
        touching = impact_reference.ImplicitContact(body.theirs(points))
    if body.rigid:
        touching.motion, touching.angle, touching.body = case.obstacle, case.angle, body.moving
    return touching


def implicit_record(result: NewmarkResult, order: IntArray) -> Record:
    """What came out of an implicit run.

    Args:
        result: of the hand-written solver.
        order: number of its degree of freedom of each of ours, shape (num_dofs).
    """
    levels = len(result.time)
    energies = {name: result.energies.get(name, np.zeros(levels)) for name in ENERGIES}
    fields = {"displacement": result.u[:, order], "velocity": result.v[:, order], "acceleration": result.a[:, order]}
    force = None if result.contact is None else result.contact.total
    return Record(result.time, fields, energies, largest(result.energies), force)
