# SPDX-License-Identifier: MIT
"""Level contact, solutions: the same bodies, supports, obstacles and load steps on both sides."""

from dataclasses import dataclass

import impact_reference
import numpy as np
from dolfinx import fem, mesh

from .. import contact
from ..statics.problem import StaticProblem
from . import bodies, operator
from .contact_bodies import BOTTOM, SLAVE, TOP, TwoBodies, rule, two_bodies
from .contact_patch import Rows, same_points

TOLERANCE = 1e-8
REASON = "tolerance of Newton's methods times condition of the stiffness matrix"
SLIP_TOLERANCE = 1e-7
SLIP_REASON = "slip of up to 1e-11 of the size passes for stick"
PENALTY, TANGENTIAL = 20.0, 15.0


@dataclass
class Case:
    """A body, and where its upper face and a rigid obstacle are moved to, stage by stage."""

    name: str
    body: TwoBodies
    tops: list  # displacements (gdim) [L]
    obstacles: list = None  # displacements (gdim) [L]
    steps: int = 1
    remark: str = ""  # on what the two sides did to come here


def run(report):
    """Add the rows of the solutions."""
    for cell, hypothesis, degree in (
        ("quadrilateral", "plane_strain", 1),
        ("triangle", "plane_strain", 2),
        ("quadrilateral", "axisymmetric", 1),
        ("quadrilateral", "axisymmetric", 2),
        ("tetrahedron", "3d", 1),
        ("hexahedron", "3d", 1),
        ("hexahedron", "3d", 2),
    ):
        if report.wants(cell, degree):
            both(report, "static", pressed(cell, hypothesis, degree))
    for cell, hypothesis, degree in (("quadrilateral", "plane_strain", 1), ("hexahedron", "3d", 1)):
        if report.wants(cell, degree):
            both(report, "friction", pressed(cell, hypothesis, degree, friction=0.3))
    if report.wants("quadrilateral", 1):  # here points end up a little beside facets they were on
        case = pressed("quadrilateral", "plane_strain", 1, 0.3, cells=((11, 3), (9, 2)), start=(0.152,))
        compare_penalty(report, "friction_penalty", case)
    for cell, hypothesis, degree in (("triangle", "plane_strain", 1), ("quadrilateral", "plane_strain", 2),
                                     ("tetrahedron", "3d", 2), ("hexahedron", "3d", 1)):  # fmt: skip
        if report.wants(cell, degree):
            both(report, "static", under_obstacle(cell, hypothesis, degree))
    for cell, degree in (("tetrahedron", 1), ("hexahedron", 2)):
        if report.wants(cell, degree):
            both(report, "static", under_obstacle(cell, "3d", degree, shape="Sphere"))
    for cell, hypothesis, degree in (("quadrilateral", "plane_strain", 1), ("hexahedron", "3d", 1)):
        if report.wants(cell, degree):
            both(report, "static", under_obstacle(cell, hypothesis, degree, "neo_hookean"))
            both(report, "friction", under_obstacle(cell, hypothesis, degree, "neo_hookean", friction=0.3))


def both(report, form, case):
    """Penalty and multipliers; without friction also the penalty with multipliers of Uzawa's method."""
    compare_penalty(report, f"{form}_penalty", case)
    if not case.body.friction:
        compare_penalty(report, f"{form}_augmented", case, augmented=True)
    compare_lagrange(report, f"{form}_lagrange", case)


# --- bodies ----------------------------------------------------------------------------------------------------------


def _two(domain, tags, degree, hypothesis, law, friction, rigid=None):
    material = operator.LAWS[law](1.0, 0.3, 1.0, hypothesis)
    named = operator._rule(domain, degree, hypothesis, law)
    return TwoBodies(domain, tags, degree, material, friction, rigid, law=law, rule=named)


def pressed(cell, hypothesis, degree, friction=0.0, cells=None, start=(0.17, 0.13), push=0.03, pull=0.02):
    """A block with a round lower face pressed on another one; with friction it is pulled sideways afterwards."""
    dim = 3 if hypothesis == "3d" else 2
    lower, upper = cells or (((5, 3), (4, 2)) if dim == 2 else ((3, 2, 2), (2, 2, 1)))
    domain, tags = two_bodies(cell, lower, upper, start=start)
    x = domain.geometry.x
    above = np.zeros(len(x), dtype=bool)
    above[np.unique(domain.geometry.dofmap[_upper_cells(domain)])] = True
    # Round below, flat above, and nowhere touching to begin with: round-off must not decide what is in contact.
    round_part = 0.3 * ((x[:, :1] - 0.52) ** 2).sum(axis=1) * (1.5 - x[:, dim - 1]) / 0.5
    x[above, dim - 1] += 0.002 + round_part[above]
    if hypothesis == "axisymmetric":
        x[:, 0] += 0.5
    body = _two(domain, tags, degree, hypothesis, "linear_elastic", friction)
    down = -push * np.eye(dim)[-1]
    tops = [down]
    if friction:
        side = np.append(pull * np.array([1.0, 0.4])[: dim - 1], 0.0)
        tops = [down, down + side, down]
    return Case("block pressed on a block", body, tops, steps=4 if friction else 1)


def _upper_cells(domain):
    dim = domain.geometry.dim
    x = domain.geometry.x[domain.geometry.dofmap][:, :, dim - 1]
    return x.mean(axis=1) > 1.0


def under_obstacle(cell, hypothesis, degree, law="linear_elastic", friction=0.0, push=0.06, shape="Cylinder"):
    """A block, held below, under a rigid cylinder or sphere; with friction that is moved sideways afterwards."""
    dim = 3 if hypothesis == "3d" else 2
    domain = bodies.block(cell, 8 if dim == 2 and degree == 1 else 4 if dim == 2 or degree == 1 else 3)
    top = mesh.locate_entities_boundary(domain, dim - 1, lambda x: np.isclose(x[dim - 1], 1.0))
    bottom = mesh.locate_entities_boundary(domain, dim - 1, lambda x: np.isclose(x[dim - 1], 0.0))
    facets, values = np.concatenate([top, bottom]), np.repeat([SLAVE, BOTTOM], [len(top), len(bottom)])
    order = np.argsort(facets)
    tags = mesh.meshtags(domain, dim - 1, facets[order], values[order].astype(np.int32))
    center, radius = np.array([0.47, 0.5, 0.0])[:dim], 0.8
    center[-1] = 1.0 + radius + 0.003
    more = [np.array([0.1, 1.0, 0.0])] if dim == 3 and shape == "Cylinder" else []
    made = [getattr(m, f"Rigid{shape}")(center, radius, *more) for m in (contact, impact_reference)]
    body = _two(domain, tags, degree, hypothesis, law, friction, made)
    down, side = -push * np.eye(dim)[-1], 0.003 * np.eye(dim)[0]
    stages = [down, down + side] if friction else [down]
    name = f"{law.replace('_', '-')} block under a {shape.lower()}"
    return Case(name, body, [np.zeros(dim)] * len(stages), stages, steps=6)


# --- both sides ------------------------------------------------------------------------------------------------------


class Supports:
    """Our boundary conditions and the same degrees of freedom and values for the other side."""

    def __init__(self, case):
        body = case.body
        still, self.moving = (fem.Constant(body.mesh, np.zeros(body.gdim)) for _ in range(2))
        self.bcs = []
        for tag, value in ((BOTTOM, still), (TOP, self.moving)):
            nodes = fem.locate_dofs_topological(body.V, body.gdim - 1, body.tags.find(tag))
            self.bcs.append(fem.dirichletbc(value, nodes, body.V))
        held, self.moved = (bc.dof_indices()[0] for bc in self.bcs)
        self.dofs = np.union1d(held, self.moved)
        self.order, self.gdim = body.order, body.gdim

    def theirs(self, top):
        """Their degrees of freedom, and values when the upper face is displaced by `top`."""
        return self.order[self.dofs], np.where(np.isin(self.dofs, self.moved), top[self.dofs % self.gdim], 0.0)


def solved(case, supports, method, solve, bound=lambda ours: None):
    """Both sides, stage by stage: yields name, problem, our contact, their solution.

    Args:
        method: function of a ContactPair.
        solve: function of their dofs, values and the solution to start from.
        bound: called with our contact before anything moves.
    """
    body, theirs = case.body, None
    body.u.x.array[:] = 0.0
    problem = StaticProblem(body.u, body.material, bcs=supports.bcs, contact=[method(body.pair())])
    bound(problem.contact[0])
    for i, top in enumerate(case.tops):
        supports.moving.value[:] = top
        if body.rigid:
            body.rigid[0].displacement = body.rigid[1].displacement = case.obstacles[i]
        ours = problem.solve(steps=case.steps, rtol=1e-13, max_iterations=60)
        theirs = solve(*supports.theirs(top), theirs)
        case.remark = ""
        if ours.cut_backs or len(theirs.iterations) != case.steps:  # with friction the result depends on the steps
            case.remark = f"; steps were cut: UFL {len(ours.iterations)}, hand-written {len(theirs.iterations)}"
        name = f"{case.name}, stage {i + 1}" if len(case.tops) > 1 else case.name
        yield name, problem, problem.contact[0], theirs


def compare_penalty(report, form, case, augmented=False):
    """Displacements, forces, pressures and status of the penalty method."""
    body, degree = case.body, 2 * case.body.degree + 2
    supports, other = Supports(case), body.theirs(rule(body.facet, degree))
    # Both stop when multipliers change by 1e-8 of the size: ours is the diagonal of the box, theirs its longest side.
    tolerance = 1e-8 * np.ptp(body.points, axis=0).max() / body.size

    def method(pair):
        options = {"augmented": augmented, "tolerance": tolerance, "quadrature_degree": degree}
        return contact.Penalty(pair, PENALTY, TANGENTIAL, **options)

    def solve(fixed, values, start):
        options = {"chi": PENALTY, "chi_t": TANGENTIAL, "steps": case.steps, "tolerance": 1e-13, "augmented": augmented}
        return other.solve_penalty(fixed, values, start=start, **options)

    place = []
    for name, problem, ours, theirs in solved(
        case, supports, method, solve, lambda ours: place.append(same_points(body, ours, other))
    ):
        at = place[0]
        tractions = ours._cpp.state.tangential, theirs.traction[at]
        _rows(report, form, case, name, problem, ours, theirs, theirs.pressure[at], tractions, theirs.status[at])


def compare_lagrange(report, form, case):
    """The same of multipliers."""
    body, degree = case.body, 3 * case.body.degree + 4
    supports = Supports(case)
    body.prescribed = supports.dofs
    # On obstacles our side integrates shape functions only, always with this rule.
    points = rule(body.facet, 2 * body.degree + 2) if body.rigid else rule(body.segment, degree)
    other = body.theirs(points)

    def method(pair):
        return contact.Lagrange(pair, quadrature_degree=degree)

    def solve(fixed, values, start):
        return other.solve_lagrange(fixed, values, start=start, steps=case.steps, tolerance=1e-13)

    for name, problem, ours, theirs in solved(case, supports, method, solve):
        pressure, traction, status = (
            body.nodal_to_ours(v)[ours.nodes] for v in (theirs.pressure, theirs.traction, theirs.status)
        )
        tractions = ours.friction_traction, traction
        _rows(report, form, case, name, problem, ours, theirs, pressure, tractions, status)


def _rows(report, form, case, name, problem, ours, theirs, pressure, tractions, status):
    body = case.body
    pairs = {
        "u": (body.u.x.array, body.to_ours(theirs.u)),
        "contact force": (ours.contact_forces(), body.to_ours(theirs.contact_force)),
        "reactions": (problem.reactions().x.array, body.to_ours(theirs.reactions)),
        "pressure": (ours.pressure, pressure),
        "status": (ours.status, status),
    }
    if body.friction:
        pairs["friction traction"] = tractions
    for what, (a, b) in pairs.items():
        slips = what == "friction traction" and form.endswith("lagrange")
        tolerance = (SLIP_TOLERANCE, SLIP_REASON) if slips else (TOLERANCE, REASON)
        Rows(report, body, f"{what} of the {name}")(form, a, b, *tolerance, case.remark)
