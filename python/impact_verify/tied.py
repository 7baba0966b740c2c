# SPDX-License-Identifier: MIT
"""Level contact, tied surfaces: solutions at rest, and histories in time."""

from typing import cast

import impact_reference
import numpy as np
from dolfinx import fem

from dolfinx_impact import contact
from dolfinx_impact.dynamics.explicit import ExplicitProblem
from dolfinx_impact.materials import _Material
from dolfinx_impact.statics.static_problem import StaticProblem
from .contact_bodies import BOTTOM, MASTER, SLAVE, TwoBodies, rule
from .contact_patch import Rows
from .contact_static import Case, Supports, pressed
from .report import Report

TOLERANCE = 1e-9
REASON = "round-off times condition of the stiffness matrix; dense solutions on the other side"
STEPS = 40
CASES = (
    ("quadrilateral", "plane_strain", 1),
    ("triangle", "plane_strain", 2),
    ("tetrahedron", "3d", 1),
    ("hexahedron", "3d", 1),
    ("hexahedron", "3d", 2),
)


def run(report: Report) -> None:
    """Add the rows of ties.

    Args:
        report: report to add to.
    """
    for cell, hypothesis, degree in CASES:
        if report.wants(cell, degree):
            at_rest(report, pressed(cell, hypothesis, degree))
            in_time(report, pressed(cell, hypothesis, degree))


def _theirs(body: TwoBodies, degree: int) -> impact_reference.Tie:
    slave, master = (body.their_facets(body.tags, tag) for tag in (SLAVE, MASTER))
    return impact_reference.Tie(body.model, slave, master, rule(body.segment, degree))


def _degree(body: TwoBodies) -> int:
    return 3 * body.degree + 4


def at_rest(report: Report, case: Case) -> None:
    """Add the rows of a block with a round face that is tied to another one and pulled away from it and sideways.

    Args:
        report: report to add to.
        case: bodies; its displacements do not count.
    """
    body = case.body
    supports = Supports(case)
    pull = np.linspace(0.01, 0.03, body.gdim)
    supports.moving.value[:] = pull
    body.u.x.array[:] = 0.0
    spec = contact.Tie(body.pair(), quadrature_degree=_degree(body))
    ours = StaticProblem(body.u, cast(_Material, body.material), bcs=supports.bcs, contact=[spec])
    ours.solve(rtol=1e-13, progress=False)
    theirs = _theirs(body, _degree(body)).solve_static(*supports.theirs(pull))
    tie = ours.contact[0]
    traction = body.nodal_to_ours(theirs.multipliers)[tie.nodes]
    for what, a, b in (
        ("u", body.u.x.array, body.to_ours(theirs.u)),
        ("contact force", tie.contact_forces(), body.to_ours(theirs.force)),
        ("traction", tie.traction, traction),
    ):
        Rows(report, body, f"{what} of tied blocks that are pulled apart")("tied_static", a, b, TOLERANCE, REASON)


def in_time(report: Report, case: Case) -> None:
    """Add the rows of two blocks that are tied to each other, the lower one held, and vibrate freely.

    Args:
        report: report to add to.
        case: bodies; its displacements do not count.
    """
    body = case.body
    body.u.x.array[:] = 0.0
    zero = fem.Constant(body.mesh, np.zeros(body.gdim))
    nodes = fem.locate_dofs_topological(body.V, body.gdim - 1, body.tags.find(BOTTOM))
    held = fem.dirichletbc(zero, nodes, body.V)
    velocity = fem.Function(body.V)
    velocity.x.array[:] = np.random.default_rng(7).uniform(-0.01, 0.01, len(velocity.x.array))
    fixed = held.dof_indices()[0]
    # At rest at the joint: no part of this contradicts the tie.
    joint = np.concatenate([body.tags.find(SLAVE), body.tags.find(MASTER)])
    at_joint = fem.locate_dofs_topological(body.V, body.gdim - 1, joint)
    velocity.x.array.reshape(-1, body.gdim)[at_joint] = 0.0
    velocity.x.array[fixed] = 0.0
    spec = contact.Tie(body.pair(), quadrature_degree=_degree(body))
    ours = ExplicitProblem(body.u, cast(_Material, body.material), velocity=velocity, bcs=[held], contact=[spec])
    dt = 0.5 * ours.stable_step()
    start = body.to_theirs(velocity.x.array)
    theirs = _theirs(body, _degree(body)).run_explicit(start, dt, STEPS, body.order[fixed])
    tie = ours.contact[0]
    for step in (1, STEPS):
        ours.advance(until=step * dt, dt=dt, progress=False)
        found = theirs[step - 1]
        traction = body.nodal_to_ours(found.multipliers)[tie.nodes]
        for what, a, b in (("u", body.u.x.array, body.to_ours(found.u)), ("traction", tie.traction, traction)):
            name = f"{what} of tied blocks that vibrate, step {step}"
            Rows(report, body, name)("tied_history", a, b, TOLERANCE, REASON)
