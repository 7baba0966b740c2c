# SPDX-License-Identifier: MIT
"""Level contact, rigid bodies: equilibrium under forces and torques, and bodies that meet each other."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, cast

import impact_reference
import numpy as np
from dolfinx import fem
from impact_reference import rigid_body, rigid_meeting
from impact_reference.contact import ContactSolution

from dolfinx_impact import contact
from dolfinx_impact.common.types import FloatArray
from dolfinx_impact.dynamics.explicit import ExplicitProblem
from dolfinx_impact.dynamics.run_history import ENERGIES
from dolfinx_impact.materials import _Material
from dolfinx_impact.own_forms import distorted_block
from dolfinx_impact.statics.static_problem import StaticProblem
from .contact_bodies import BOTTOM, TwoBodies, rule
from .contact_patch import Rows
from .report import Report
from .scenarios.placed_bodies import body_of, face_tags

PENALTY, TANGENTIAL = 20.0, 15.0  # [F/L^3]
TOLERANCE = 1e-6
REASON = "the rigid body's equilibrium, to 1e-8 of the forces, times condition of its stiffness"
MEETING = 1e-9
MEETING_REASON = "round-off of 200 steps, which impacts carry on"
STEPS = 200
PART_OF_LIMIT = float(np.sin(np.pi / 14.0) ** 2)  # of what the problem's step bears, docs/rigid_bodies.md [1]
SAFETY = 0.9  # of the stable step in the problem's step [1]


def run(report: Report) -> None:
    """Add the rows of rigid bodies.

    Args:
        report: report to add to.
    """
    for cell, degree in (("quadrilateral", 1), ("triangle", 2), ("hexahedron", 1)):
        if report.wants(cell, degree):
            compare_at_rest(report, tilted_plate(cell, degree))
    if report.wants("quadrilateral", 1):
        compare_at_rest(report, disc_with_torque("quadrilateral", 1))
        compare_at_rest(report, disc_with_torque("quadrilateral", 1), multipliers=True)
    if report.wants("hexahedron", 1):
        for name, bodies in (("balls", balls()), ("a brick and a ball", brick_on_ball())):
            compare_meeting(report, name, *bodies)


# --- statics ---------------------------------------------------------------------------------------------------------


@dataclass
class AtRest:
    """A rigid body on a block, and what acts on it in each stage.

    Args:
        name: name in the rows.
        body: bodies of both sides; the other side's rigid body is its `moving`.
        loads: force and torque of each stage, (3) each [F], [F L].
        guess: displacement of the rigid body with which the other side begins [L].
    """

    name: str
    body: TwoBodies
    loads: list[tuple[FloatArray, FloatArray]]
    guess: float


def _hypothesis(dim: int) -> str:
    return "3d" if dim == 3 else "plane_strain"


def _set_rigid(body: TwoBodies, surfaces: tuple[Any, Any], centre: FloatArray, fixed: tuple[str, ...]) -> None:
    """Give the body a rigid one that loads move, on both sides."""
    ours, theirs = surfaces
    names = ("x", "y", "z", "rx", "ry", "rz")
    in_plane = (0, 1, 5) if body.gdim == 2 else range(6)
    theirs.pivot = centre
    both: Any = contact.RigidBody(ours, inertia=1.0, centre=centre, fixed=fixed), theirs
    body.rigid = both
    free = tuple(c for c in in_plane if names[c] not in fixed)
    body.moving = impact_reference.RigidBody(theirs, free=free)


def tilted_plate(cell: str, degree: int) -> AtRest:
    """A rigid half-space pressed on a block beside its middle, then turned by a torque, too.

    Args:
        cell: cell.
        degree: degree of the displacement, 1 or 2.
    """
    dim = 3 if cell == "hexahedron" else 2
    domain = distorted_block.block(cell, 4 if dim == 2 else 2)
    body = body_of(domain, face_tags(domain, 1.0), degree, _hypothesis(dim))
    up = np.eye(dim)[-1]
    centre = np.append(np.full(dim - 1, 0.57), 1.3)
    planes = contact.RigidPlane(1.001 * up, -up), impact_reference.RigidPlane(1.001 * up, -up)
    _set_rigid(body, planes, centre, ("x",) if dim == 2 else ("x", "y", "rz"))
    force, torque = np.zeros(3), np.zeros(3)
    force[dim - 1] = -0.05
    torque[2 if dim == 2 else 1] = 0.002
    return AtRest("block under a plate that tilts", body, [(force, 0 * torque), (1.2 * force, torque)], -0.03)


def disc_with_torque(cell: str, degree: int) -> AtRest:
    """A disc pressed on a block, then turned by less than friction holds.

    Args:
        cell: cell.
        degree: degree of the displacement, 1 or 2.
    """
    domain = distorted_block.block(cell, 6)
    body = body_of(domain, face_tags(domain, 1.0), degree, "plane_strain", friction=0.4)
    centre = np.array([0.47, 1.803])
    discs = contact.RigidCylinder(centre, 0.8), impact_reference.RigidCylinder(centre, 0.8)
    _set_rigid(body, discs, centre + np.array([0.02, 0.05]), ("x",))  # else it rolls
    force = np.array([0.0, -0.02, 0.0])
    turned = 1.2 * force, np.array([0.0, 0.0, 0.0008])
    return AtRest("block under a disc that friction holds", body, [(force, np.zeros(3)), turned], -0.03)


def compare_at_rest(report: Report, case: AtRest, multipliers: bool = False) -> None:
    """Add the rows of displacements, place and forces of each stage.

    Args:
        report: report to add to.
        case: the bodies and loads.
        multipliers: in the place of a penalty.
    """
    body = case.body
    assert body.rigid is not None and body.moving is not None
    ours, theirs = cast(contact.RigidBody, body.rigid[0]), body.moving
    nodes = fem.locate_dofs_topological(body.V, body.gdim - 1, body.tags.find(BOTTOM))
    fixed: Any = (nodes[:, None] * body.gdim + np.arange(body.gdim)).ravel()
    held = fem.dirichletbc(np.zeros(body.gdim), nodes, body.V)
    degree = 2 * body.degree + 2
    other = body.theirs(rule(body.facet, degree))
    method: Any = contact.Penalty(body.pair(), PENALTY, TANGENTIAL, quadrature_degree=degree)
    if multipliers:
        body.prescribed = fixed
        other, method = body.theirs(rule(body.facet, degree)), contact.Lagrange(body.pair())
    problem = StaticProblem(body.u, cast(_Material, body.material), bcs=[held], contact=[method])
    solution: ContactSolution | None = None
    guess: FloatArray = np.zeros(len(theirs.free))
    guess[theirs.free.index(body.gdim - 1)] = case.guess
    for number, (force, torque) in enumerate(case.loads):
        ours.external_force, ours.external_torque = force, torque
        theirs.force, theirs.torque = force, torque
        problem.solve(rtol=1e-13, max_iterations=60)

        def solve(start: ContactSolution | None) -> ContactSolution:
            if multipliers:
                return other.solve_lagrange(body.order[fixed], 0.0, start=start)
            return other.solve_penalty(body.order[fixed], 0.0, chi=PENALTY, chi_t=TANGENTIAL, start=start)

        solution = rigid_body.solve_static(other, theirs, solve, solution, guess)
        guess = np.zeros(len(theirs.free))
        moved = np.pad(np.asarray(theirs.obstacle.displacement), (0, 3 - body.gdim))
        angle = impact_reference.rotation.matrix_of(np.asarray(theirs.obstacle.angle))
        pairs: dict[str, tuple[Any, Any]] = {
            "displacement": (problem.u.x.array, solution.u[body.order]),
            "motion of the body": (ours.position - ours.centre, moved),
            "rotation": (ours.rotation - np.eye(3), angle - np.eye(3)),
            "contact force": (problem.contact[0].contact_forces(), body.to_ours(solution.contact_force)),
        }
        for what, (a, b) in pairs.items():
            name = f"{what} of the {case.name}{', multipliers' if multipliers else ''}, stage {number + 1}"
            Rows(report, body, name)("rigid_static", a, b, TOLERANCE, REASON)


# --- bodies that meet ------------------------------------------------------------------------------------------------

Meeting = tuple[list[contact.RigidBody], list[rigid_meeting.MeetingBody], rigid_meeting.Meeting]


def _body(
    surface: Any, their_surface: Any, centre: FloatArray, mass: float, inertia: Any, **given: Any
) -> tuple[contact.RigidBody, rigid_meeting.MeetingBody]:
    """A body of both sides."""
    more = {name: given.pop(name) for name in ("meets", "friction") if name in given}
    ours = contact.RigidBody(surface, mass=mass, inertia=inertia, centre=centre, **given, **more)
    obstacle = impact_reference.RigidSphere(centre, 1.0, pivot=centre) if their_surface is None else their_surface
    obstacle.pivot = centre
    return ours, rigid_meeting.MeetingBody(impact_reference.RigidBody(obstacle, mass, inertia, **given))


def balls() -> Meeting:
    """Two balls with spin and friction, of which one has its centre of mass beside its own."""
    far = 9.0
    middle, radius = np.array([1.55, 0.1, far]), 0.7
    other, their_other = _body(
        contact.RigidSphere(middle, radius), impact_reference.RigidSphere(middle, radius),
        middle + np.array([0.1, 0.05, -0.1]), 1.0, np.array([[0.2, 0.01, 0.0], [0.01, 0.25, 0.0], [0.0, 0.0, 0.3]]),
        velocity=np.array([-0.2, 0.0, 0.1]), spin=np.array([0.3, 0.0, -0.2]),
    )  # fmt: skip
    start = np.array([0.0, 0.0, far])
    first, their_first = _body(
        contact.RigidSphere(start, 0.8), None, start, 0.5, 0.13 * np.eye(3), velocity=np.array([0.5, 0.0, 0.0]),
        spin=np.array([0.0, 0.0, 0.4]), meets=other, friction=0.3,
    )  # fmt: skip
    surface = impact_reference.RigidSphere(middle, radius)
    meeting = rigid_meeting.Meeting(
        their_first, start[None], np.ones(1), surface, their_other, radius=0.8, friction=0.3
    )  # fmt: skip
    return [first, other], [their_first, their_other], meeting


def brick_on_ball() -> Meeting:
    """The corners of a brick that tumbles fall on a heavy ball, with friction and weight."""
    low, size = np.array([0.0, 0.0, 8.0]), np.array([1.0, 0.6, 0.3])
    corners = low + size * np.array([[i, j, k] for k in (0, 1) for j in (0, 1) for i in (0, 1)], dtype=float)
    quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    facets = np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])
    centre, middle = low + size / 2, np.array([0.6, 0.4, 6.9])
    ball, their_ball = _body(
        contact.RigidSphere(middle, 1.05), impact_reference.RigidSphere(middle, 1.05), middle, 5.0, 2.0 * np.eye(3)
    )
    moments = 2.0 / 12.0 * (size @ size - size**2)
    brick, their_brick = _body(
        contact.RigidSurface.from_facets(corners, facets), None, centre, 2.0, np.diag(moments),
        velocity=np.array([0.1, 0.0, -0.5]), spin=np.array([0.5, 1.0, 0.3]), force=np.array([0.0, 0.0, -3.0]),
        meets=ball, friction=0.2,
    )  # fmt: skip
    areas = np.zeros(8)
    for facet in facets:
        a, b, c = corners[facet]
        areas[facet] += np.linalg.norm(np.cross(b - a, c - a)) / 6.0
    surface = impact_reference.RigidSphere(middle, 1.05)
    meeting = rigid_meeting.Meeting(their_brick, corners, areas, surface, their_ball, friction=0.2)
    return [brick, ball], [their_brick, their_ball], meeting


def compare_meeting(
    report: Report,
    name: str,
    ours: list[contact.RigidBody],
    theirs: list[rigid_meeting.MeetingBody],
    meeting: rigid_meeting.Meeting,
) -> None:
    """Add the rows of places, velocities and energies of two bodies that meet.

    Args:
        report: report to add to.
        name: what meets.
        ours: our bodies.
        theirs: the other side's.
        meeting: their contact.
    """
    domain = distorted_block.block("hexahedron", 1)
    body = body_of(domain, face_tags(domain, 1.0), 1, "3d")
    pair = contact.ContactPair(body.tags, 1, ours[0])  # far away: it brings the bodies into a problem
    problem = ExplicitProblem(body.u, cast(_Material, body.material), contact=[contact.Penalty(pair)])
    natural = SAFETY * problem.stable_step()
    dt = 0.02 * natural
    rows: list[Any] = []

    def keep(_: ExplicitProblem) -> None:
        states = [(b.position, b.rotation.reshape(3, 3), b.velocity, b.spin) for b in ours]
        rows.append([np.array(field) for field in zip(*states)])

    problem.advance(STEPS * dt, dt=dt, progress=False, callback=keep)
    meeting.stiffen(natural, PART_OF_LIMIT)
    result = rigid_meeting.run(theirs, [meeting], dt, STEPS)
    history = problem.energy_history
    names = ("kinetic", "contact", "friction", "external")
    columns = {what: history[:, 1 + ENERGIES.index(what)] for what in names}
    fields = [np.array(field) for field in zip(*rows)]
    pairs = {
        "position": (fields[0], result.position), "rotation": (fields[1], result.rotation),
        "velocity": (fields[2], result.velocity), "spin": (fields[3], result.spin),
        "kinetic energy": (columns["kinetic"], result.kinetic), "contact energy": (columns["contact"], result.stored),
        "friction energy": (columns["friction"], result.dissipated),
        "external energy": (columns["external"], result.external),
    }  # fmt: skip
    for what, (a, b) in pairs.items():
        if np.any(a) or np.any(b):
            Rows(report, body, f"{what} of {name}")("rigid_meeting", a, b, MEETING, MEETING_REASON)
