# SPDX-License-Identifier: MIT
"""Level contact, contact without pairs at quadrature points: two surfaces in one against the hand-written penalty of
each of them on the other one."""

from typing import Any

import impact_reference
import numpy as np

from dolfinx_impact import GeneralContact, StaticProblem
from . import differences, matched_body
from .contact_bodies import CASES, MASTER, SLAVE, TwoBodies, facet_of, roughen, rule, steel, two_bodies
from .contact_patch import Rows
from .report import Report

FRICTION = 0.1
#: Surfaces touch in the undeformed state but for less than a fiftieth of a cell: where they overlapped by a twentieth,
#: contact without pairs would not know on which side they are.
ROUGH = 0.004
SHIFT = 0.006  # of the upper body along the lower one in the increment [L]
PRESSED = 0.02  # by which the upper body is moved down, and the amplitude of its random displacements [L]


def run(report: Report) -> None:
    """Add the rows of contact without pairs at quadrature points.

    Args:
        report: report to add to.
    """
    for cell, hypothesis in CASES:
        for degree in (1, 2):
            if report.wants(cell, degree):
                compare(report, cell, hypothesis, degree)


def pressed_bodies(cell: str, hypothesis: str, degree: int, seed: int) -> TwoBodies:
    """Two bodies on each other, whose facets do not match; the upper one extends beyond the lower one's edge.

    Args:
        cell: cell.
        hypothesis: hypothesis of the material.
        degree: degree of the displacement, 1 or 2.
        seed: seed of the random numbers.
    """
    dim = 2 if facet_of(cell) == "interval" else 3
    lower, upper = ((4, 2), (4, 1)) if dim == 2 else ((2, 2, 1), (3, 1, 1))
    domain, tags = two_bodies(cell, lower, upper, 1, start=(0.45, 0.15), length=(0.9, 0.7))
    roughen(domain, np.random.default_rng(seed), ROUGH)
    if hypothesis == "axisymmetric":
        domain.geometry.x[:, 0] += 0.5
    return TwoBodies(domain, tags, degree, steel(hypothesis), FRICTION)


def compare(report: Report, cell: str, hypothesis: str, degree: int, seed: int = 1) -> None:
    """Add the rows of one kind of element: gaps, pressures, forces with friction and the tangent of all points.

    Args:
        report: report to add to.
        cell: cell.
        hypothesis: hypothesis of the material.
        degree: degree of the displacement, 1 or 2.
        seed: seed of the random numbers.
    """
    body = pressed_bodies(cell, hypothesis, degree, seed)
    rows, rng = Rows(report, body, "contact without pairs"), np.random.default_rng(seed)
    surface = GeneralContact(body.tags, tags=(SLAVE, MASTER), friction=FRICTION)
    ours: Any = StaticProblem(body.u, body.material, contact=[surface]).contact[0]  # type: ignore[arg-type]
    weights = rule(body.facet, 2 * degree + 2)
    facets = [body.their_facets(body.tags, tag) for tag in (SLAVE, MASTER)]
    theirs = [
        impact_reference.Contact(body.model, own, other, FRICTION, weights) for own, other in (facets, facets[::-1])
    ]
    at_rest = np.zeros(len(body.u.x.array))
    positions = np.vstack([side.closest_points(at_rest).position for side in theirs])
    place = matched_body.match_nodes(ours.points, positions, body.size)
    u = PRESSED * rng.uniform(-0.5, 0.5, (len(at_rest) // body.gdim, body.gdim))
    height = body.V.tabulate_dof_coordinates()[:, body.gdim - 1]
    above = np.zeros(len(height), dtype=bool)
    for nodes in body.V.dofmap.list:
        above[nodes] = height[nodes].mean() > 1.0
    u[above, body.gdim - 1] -= PRESSED
    # The increment brings the upper body down and moves it along the other one. Nearly no point comes from beside it
    # over its rim: what it has slipped before is not defined alike on both sides.
    start = u.copy()
    start[above] += np.array([-SHIFT, *([0.0] * (body.gdim - 2)), 3.0 * PRESSED])
    ours.begin_step(start.ravel(), None)
    ours.update_gap(u.ravel())
    # Both ways have the same part of the penalty, that of the softer body.
    chi = ours.penalty * ours._cpp_object.forces.share_of(0)
    histories = [side.no_history() for side in theirs]
    for history in histories:
        history.u = body.to_theirs(start.ravel())
    results = [side.penalty(body.to_theirs(u.ravel()), chi, chi, history) for side, history in zip(theirs, histories)]
    gap, pressure, normal, status = (
        np.concatenate([getattr(r.points, name) for r in results])[place]
        for name in ("gap", "pressure", "normal", "status")
    )
    closed = status > 0
    rows("general_static_gap", np.where(closed, ours.gap, 0.0), np.where(closed, gap, 0.0))
    rows("general_static_normal", ours.normal[closed], normal[closed])
    rows("general_static_status", ours.status, status)
    rows("general_static_pressure", ours.pressure, 2.0 * pressure)  # ours are those of both ways
    force = results[0].force + results[1].force
    rows("general_static_force", ours.contact_forces(), body.to_ours(force))
    tangent = differences.petsc_to_scipy(ours.tangent()).toarray()
    rows("general_static_tangent", tangent, sum(body.matrix_to_ours(r.tangent).toarray() for r in results))
