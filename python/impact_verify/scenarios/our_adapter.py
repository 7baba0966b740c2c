# SPDX-License-Identifier: MIT
"""Scenarios with dolfinx_impact."""

from __future__ import annotations

import warnings
from typing import Any, TypeAlias, Union, cast

import numpy as np
from dolfinx import fem

from dolfinx_impact import contact, materials
from dolfinx_impact.added_mass import AddedMass
from dolfinx_impact.amplitude import PrescribedMotion
from dolfinx_impact.common.types import FloatArray
from dolfinx_impact.dynamics.explicit import ExplicitProblem
from dolfinx_impact.dynamics.implicit.newmark_problem import NewmarkProblem
from dolfinx_impact.dynamics.run_history import ENERGIES
from dolfinx_impact.foundation import Foundation
from dolfinx_impact.loads import BodyForce, Load
from dolfinx_impact.materials import _Material
from ..contact_bodies import SLAVE
from .record import Record, largest
from .scenario import PENALTY, TANGENTIAL, USUAL_FRACTION, Explicit, Implicit, Scenario

# Gap of an active node that is left in sizes of the bodies: 1e-11, which problems leave by themselves, is 1e-8 of the
# velocity of a node without mass, (u1 - u0)/h.
VIOLATION = 1e-13

Problem: TypeAlias = Union[ExplicitProblem, NewmarkProblem]
Support: TypeAlias = Union[fem.DirichletBC, PrescribedMotion]


def loads_of(case: Scenario) -> list[Load]:
    """Loads of a scenario.

    Args:
        case: scenario.
    """
    loads: list[Load] = [] if case.gravity is None else [BodyForce(case.gravity[0], amplitude=case.gravity[1])]
    if case.added_mass is not None:
        loads.append(AddedMass(case.body.tags, SLAVE, case.added_mass))
    return loads if case.foundation is None else [*loads, Foundation(case.body.tags, SLAVE, *case.foundation)]


def _supports(case: Scenario) -> list[Support]:
    if not len(case.fixed_nodes):
        return []
    V, gdim = case.body.V, case.body.gdim
    nodes = np.asarray(case.fixed_nodes, dtype=np.int32)
    if case.motion is None:
        return [fem.dirichletbc(np.zeros(gdim), nodes, V)]
    return [PrescribedMotion(fem.dirichletbc(np.eye(gdim)[-1], nodes, V), case.motion)]


def _contacts(case: Scenario) -> list[Any]:
    if not case.contact:
        return []
    body, motion = case.body, case.obstacle
    if body.rigid and not isinstance(body.rigid[0], contact.RigidBody):
        body.rigid[0].motion = None if motion is None else lambda t: np.pad(motion(t), (0, 3 - body.gdim))
        body.rigid[0].angle = case.angle
    if case.contact == "general":
        return [contact.GeneralContact(body.tags, friction=body.friction)]
    if isinstance(case.scheme, Explicit):
        kind = contact.Penalty if case.contact == "penalty" else contact.Kinematic
        return [kind(body.pair(everywhere=False, smooth=case.smooth or False), **case.options)]
    if case.contact == "penalty":
        return [contact.Penalty(body.pair(), PENALTY, TANGENTIAL, quadrature_degree=2 * body.degree + 2)]
    return [contact.Lagrange(body.pair(), quadrature_degree=3 * body.degree + 4)]


def problem_of(case: Scenario) -> Problem:
    """The problem of a scenario, at its start.

    Args:
        case: scenario.
    """
    body, scheme = case.body, case.scheme
    u, v = fem.Function(body.V, name="u"), fem.Function(body.V)
    v.x.array[:] = case.velocity(body.V.tabulate_dof_coordinates()[:, : body.gdim]).ravel()
    contacts = _contacts(case)
    given: dict[str, Any] = {
        "velocity": v, "bcs": _supports(case), "loads": loads_of(case), "contact": contacts,
    }  # fmt: skip
    material, damping = cast(_Material, body.material), materials.Rayleigh(*case.damping)
    if isinstance(scheme, Explicit):
        return ExplicitProblem(
            u, material, **given, scheme=scheme.velocities, damping=damping, bulk_viscosity=scheme.viscosity,
            precision=scheme.precision,
        )  # fmt: skip
    return NewmarkProblem(
        u, material, **given, lumping=scheme.lumping, damping=damping if any(case.damping) else None,
        impact=scheme.impact, options={"contact_tolerance": VIOLATION} if contacts else None, **scheme.parameters,
    )  # fmt: skip


def time_step(case: Scenario, problem: Problem | None = None) -> float:
    """Time step of a scenario [T].

    Args:
        case: scenario.
        problem: its problem, which explicit scenarios need.
    """
    if isinstance(case.scheme, Implicit):
        return case.scheme.dt * case.step_fraction / USUAL_FRACTION
    assert isinstance(problem, ExplicitProblem)
    return case.step_fraction * problem.stable_step()


def run(case: Scenario, steps: int) -> Record:
    """Make a run.

    Args:
        case: scenario.
        steps: number of steps.

    Returns:
        What came out.
    """
    problem = problem_of(case)
    return record_of(problem, time_step(case, problem), steps, getattr(case.scheme, "error", None))


def record_of(problem: Problem, dt: float, steps: int, error: float | None = None) -> Record:
    """Advance a problem and keep its states.

    Args:
        problem: problem at its start.
        dt: time step [T].
        steps: number of steps, if all are equal.
        error: local error by which implicit steps are chosen, dt at most; None: all are equal [1].

    Returns:
        States of all time levels, with energies and forces.
    """
    rows: list[tuple[Any, ...]] = []  # the first call of the callback has the initial state
    names = {"displacement": "u", "velocity": "velocity", "acceleration": "acceleration"}

    def keep(p: Any) -> None:
        rows.append((p.time, *(getattr(p, name).x.array.copy() for name in names.values())))

    options: dict[str, Any] = {}
    if isinstance(problem, NewmarkProblem):
        options = {"tolerance": error, "rtol": 1e-13, "max_iterations": 40}
    with warnings.catch_warnings():
        if isinstance(problem, ExplicitProblem):
            # Both sides have the same springs: that they are soft does not matter here, nor that nodes which return
            # below the surface beside which they have passed find them under load and gain energy.
            warnings.filterwarnings("ignore", "under load .* is penetration")
            warnings.filterwarnings("ignore", "the run gains energy")
        problem.advance(steps * dt, dt=dt, progress=False, callback=keep, **options)
    time, *fields = (np.array(values) for values in zip(*rows))
    if isinstance(problem, ExplicitProblem):
        time = dt * np.arange(len(time))
    energies: dict[str, FloatArray] = dict(zip(ENERGIES, problem.energy_history[:, 1:].T))
    # Forces of contact without pairs add up to zero.
    paired = problem.contact and isinstance(problem.contact[0].pair, contact.ContactPair)
    force = problem.force_history[0] if paired else None
    return Record(time, dict(zip(names, fields)), energies, largest(energies), force)
