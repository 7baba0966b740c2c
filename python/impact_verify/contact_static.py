# SPDX-License-Identifier: MIT
"""Level contact, solutions: the same bodies, supports, obstacles and load steps on both sides."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, cast, TypeAlias, Union

from dolfinx_impact.own_forms import distorted_block
import impact_reference
import numpy as np
from dolfinx import fem, mesh
from dolfinx.mesh import Mesh, MeshTags
from impact_reference.contact import ContactSolution

from dolfinx_impact import compat, contact
from dolfinx_impact.common.types import BoolArray, FloatArray, IntArray
from dolfinx_impact.materials import _Material
from dolfinx_impact.statics.static_problem import StaticProblem
from . import operator
from .contact_bodies import BOTTOM, SLAVE, TOP, ObstaclePair, TwoBodies, rule, two_bodies
from .contact_patch import Rows, match_points
from .report import Report

TOLERANCE = 1e-8
REASON = "tolerance of Newton's methods times condition of the stiffness matrix"
SLIP_TOLERANCE = 1e-7
SLIP_REASON = "slip of up to 1e-11 of the size passes for stick"
PENALTY, TANGENTIAL = 20.0, 15.0  # [F/L^3]
Method: TypeAlias = Callable[[contact.ContactPair], Union[contact.Penalty, contact.Lagrange]]
# Function of the other side's prescribed degrees of freedom, their values and the previous solution.
Solve: TypeAlias = Callable[[IntArray, FloatArray, ContactSolution | None], ContactSolution]


@dataclass
class Case:
    """A body, and the displacements of its upper face and of a rigid obstacle in each stage.

    Args:
        name: name in the rows.
        body: bodies of both sides.
        tops: displacement of the upper face in each stage, shape (gdim) each [L].
        obstacles: displacement of the rigid obstacle in each stage, shape (gdim) each [L].
        steps: number of load steps per stage.
        remark: text about load steps that the two sides divided.
    """

    name: str
    body: TwoBodies
    tops: Sequence[FloatArray]
    obstacles: Sequence[FloatArray] = ()
    steps: int = 1
    remark: str = ""


def run(report: Report) -> None:
    """Add the rows of the solutions.

    Args:
        report: report to add to.
    """
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
            compare_methods(report, "static", pressed(cell, hypothesis, degree))
    for cell, hypothesis, degree in (("quadrilateral", "plane_strain", 1), ("hexahedron", "3d", 1)):
        if report.wants(cell, degree):
            compare_methods(report, "friction", pressed(cell, hypothesis, degree, friction=0.3))
    if report.wants("quadrilateral", 1):  # here some points leave the facets that they were on
        case = pressed("quadrilateral", "plane_strain", 1, 0.3, cells=((11, 3), (9, 2)), start=(0.152,))
        compare_penalty(report, "friction_penalty", case)
    for cell, hypothesis, degree in (("triangle", "plane_strain", 1), ("quadrilateral", "plane_strain", 2),
                                     ("tetrahedron", "3d", 2), ("hexahedron", "3d", 1)):  # fmt: skip
        if report.wants(cell, degree):
            compare_methods(report, "static", under_obstacle(cell, hypothesis, degree))
    for cell, degree in (("tetrahedron", 1), ("hexahedron", 2)):
        if report.wants(cell, degree):
            compare_methods(report, "static", under_obstacle(cell, "3d", degree, shape="Sphere"))
    for cell, hypothesis, degree in (("quadrilateral", "plane_strain", 1), ("hexahedron", "3d", 1)):
        if report.wants(cell, degree):
            compare_methods(report, "static", under_obstacle(cell, hypothesis, degree, "neo_hookean"))
            case = under_obstacle(cell, hypothesis, degree, "neo_hookean", friction=0.3)
            compare_methods(report, "friction", case)


def compare_methods(report: Report, form: str, case: Case) -> None:
    """Add the rows of a case with penalty and with multipliers; without friction also with Uzawa's method.

    Args:
        report: report to add to.
        form: "static" or "friction".
        case: bodies and displacements.
    """
    compare_penalty(report, f"{form}_penalty", case)
    if not case.body.friction:
        compare_penalty(report, f"{form}_augmented", case, augmented=True)
    compare_lagrange(report, f"{form}_lagrange", case)


# --- bodies ----------------------------------------------------------------------------------------------------------


def _two_bodies(
    domain: Mesh,
    tags: MeshTags,
    degree: int,
    hypothesis: str,
    law: str,
    friction: float,
    rigid: ObstaclePair | None = None,
) -> TwoBodies:
    material = operator.LAWS[law](1.0, 0.3, 1.0, hypothesis)
    their_rule = operator.stiffness_rule(domain, degree, hypothesis, law)
    return TwoBodies(domain, tags, degree, material, friction, rigid, law=law, rule=their_rule)


def pressed(
    cell: str,
    hypothesis: str,
    degree: int,
    friction: float = 0.0,
    cells: tuple[Sequence[int], Sequence[int]] | None = None,
    start: Sequence[float] = (0.17, 0.13),
    push: float = 0.03,
    pull: float = 0.02,
) -> Case:
    """A block with a round lower face pressed on another one; with friction it is then pulled sideways.

    Args:
        cell: cell.
        hypothesis: hypothesis of the material.
        degree: degree of the displacement, 1 or 2.
        friction: Coulomb's friction coefficient [1].
        cells: number of cells of the lower and of the upper body along each axis; None for the default.
        start: least coordinates of the upper body along the horizontal axes [L].
        push: downward displacement [L].
        pull: sideways displacement [L].

    Returns:
        Bodies and displacements.
    """
    dim = 3 if hypothesis == "3d" else 2
    lower, upper = cells or (((5, 3), (4, 2)) if dim == 2 else ((3, 2, 2), (2, 2, 1)))
    domain, tags = two_bodies(cell, lower, upper, start=start)
    x = domain.geometry.x
    above = np.zeros(len(x), dtype=bool)
    above[np.unique(compat.geometry_dofmap(domain)[_upper_cells(domain)])] = True
    # Round below, flat above, and open at the start, so that round-off does not decide which points are in contact.
    round_part = 0.3 * ((x[:, :1] - 0.52) ** 2).sum(axis=1) * (1.5 - x[:, dim - 1]) / 0.5
    x[above, dim - 1] += 0.002 + round_part[above]
    if hypothesis == "axisymmetric":
        x[:, 0] += 0.5
    body = _two_bodies(domain, tags, degree, hypothesis, "linear_elastic", friction)
    down = -push * np.eye(dim)[-1]
    tops = [down]
    if friction:
        side = np.append(pull * np.array([1.0, 0.4])[: dim - 1], 0.0)
        tops = [down, down + side, down]
    return Case("block pressed on a block", body, tops, steps=4 if friction else 1)


def _upper_cells(domain: Mesh) -> BoolArray:
    dim = domain.geometry.dim
    x = domain.geometry.x[compat.geometry_dofmap(domain)][:, :, dim - 1]
    return x.mean(axis=1) > 1.0


def under_obstacle(
    cell: str,
    hypothesis: str,
    degree: int,
    law: str = "linear_elastic",
    friction: float = 0.0,
    push: float = 0.06,
    shape: str = "Cylinder",
) -> Case:
    """A block, clamped below, under a rigid cylinder or sphere; with friction the obstacle then moves sideways.

    Args:
        cell: cell.
        hypothesis: hypothesis of the material.
        degree: degree of the displacement, 1 or 2.
        law: name of the law.
        friction: Coulomb's friction coefficient [1].
        push: downward displacement of the obstacle [L].
        shape: "Cylinder" or "Sphere".

    Returns:
        Bodies and displacements.
    """
    dim = 3 if hypothesis == "3d" else 2
    domain = distorted_block.block(cell, 8 if dim == 2 and degree == 1 else 4 if dim == 2 or degree == 1 else 3)
    top = mesh.locate_entities_boundary(domain, dim - 1, lambda x: np.isclose(x[dim - 1], 1.0))
    bottom = mesh.locate_entities_boundary(domain, dim - 1, lambda x: np.isclose(x[dim - 1], 0.0))
    facets, values = np.concatenate([top, bottom]), np.repeat([SLAVE, BOTTOM], [len(top), len(bottom)])
    order = np.argsort(facets)
    tags = mesh.meshtags(domain, dim - 1, facets[order], values[order].astype(np.int32))
    center, radius = np.array([0.47, 0.5, 0.0])[:dim], 0.8
    center[-1] = 1.0 + radius + 0.003
    more = [np.array([0.1, 1.0, 0.0])] if dim == 3 and shape == "Cylinder" else []
    ours, theirs = (getattr(m, f"Rigid{shape}")(center, radius, *more) for m in (contact, impact_reference))
    body = _two_bodies(domain, tags, degree, hypothesis, law, friction, (ours, theirs))
    down, side = -push * np.eye(dim)[-1], 0.003 * np.eye(dim)[0]
    stages = [down, down + side] if friction else [down]
    name = f"{law.replace('_', '-')} block under a {shape.lower()}"
    return Case(name, body, [np.zeros(dim)] * len(stages), stages, steps=6)


# --- both sides ------------------------------------------------------------------------------------------------------


class Supports:
    """Supports of both sides: the lower face is fixed, the upper face is displaced by `moving`.

    Args:
        case: bodies and displacements.
    """

    def __init__(self, case: Case) -> None:
        body = case.body
        zero, self.moving = (fem.Constant(body.mesh, np.zeros(body.gdim)) for _ in range(2))
        self.bcs = []
        for tag, value in ((BOTTOM, zero), (TOP, self.moving)):
            nodes = fem.locate_dofs_topological(body.V, body.gdim - 1, body.tags.find(tag))
            self.bcs.append(fem.dirichletbc(value, nodes, body.V))
        fixed_dofs, self.moved_dofs = (bc.dof_indices()[0] for bc in self.bcs)
        self.dofs = np.union1d(fixed_dofs, self.moved_dofs)
        self.order, self.gdim = body.order, body.gdim

    def theirs(self, top: FloatArray) -> tuple[IntArray, FloatArray]:
        """Prescribed values of the other side.

        Args:
            top: displacement of the upper face, shape (gdim) [L].

        Returns:
            Degrees of freedom in their numbers, shape (num_fixed), and values, shape (num_fixed) [L].
        """
        values = np.where(np.isin(self.dofs, self.moved_dofs), top[self.dofs % self.gdim], 0.0)
        return self.order[self.dofs], values


def solve_stages(
    case: Case, supports: Supports, method: Method, solve: Solve, on_start: Callable[[Any], None] | None = None
) -> Iterator[tuple[str, StaticProblem, Any, ContactSolution]]:
    """Solve both sides, stage by stage.

    Args:
        case: bodies and displacements; its remark is set.
        supports: supports of both sides.
        method: function of a pair of surfaces that makes our contact.
        solve: function that solves the other side.
        on_start: called with our contact before anything moves.

    Yields:
        Name of the stage, our problem, our contact and the other side's solution.
    """
    body = case.body
    theirs: ContactSolution | None = None
    body.u.x.array[:] = 0.0
    problem = StaticProblem(body.u, cast(_Material, body.material), bcs=supports.bcs, contact=[method(body.pair())])
    if on_start is not None:
        on_start(problem.contact[0])
    for i, top in enumerate(case.tops):
        supports.moving.value[:] = top
        if body.rigid:
            body.rigid[0].displacement = body.rigid[1].displacement = case.obstacles[i]
        ours = problem.solve(steps=case.steps, rtol=1e-13, max_iterations=60)
        theirs = solve(*supports.theirs(top), theirs)
        case.remark = ""
        if ours.cut_backs or len(theirs.iterations) != case.steps:  # with friction the result depends on the steps
            case.remark = f"; steps were divided: UFL {len(ours.iterations)}, hand-written {len(theirs.iterations)}"
        name = f"{case.name}, stage {i + 1}" if len(case.tops) > 1 else case.name
        yield name, problem, problem.contact[0], theirs


def compare_penalty(report: Report, form: str, case: Case, augmented: bool = False) -> None:
    """Add the rows of the penalty method: displacements, forces, pressures and status.

    Args:
        report: report to add to.
        form: name of the row's form without "contact.".
        case: bodies and displacements.
        augmented: use Uzawa's method.
    """
    body, degree = case.body, 2 * case.body.degree + 2
    supports, other = Supports(case), body.theirs(rule(body.facet, degree))
    # Both sides stop when multipliers change by 1e-8 of the body size, which is the diagonal of the bounding box on our
    # side and its longest side on the other.
    tolerance = 1e-8 * np.ptp(body.points, axis=0).max() / body.size

    def method(pair: contact.ContactPair) -> contact.Penalty:
        options: dict[str, Any] = {"augmented": augmented, "tolerance": tolerance, "quadrature_degree": degree}
        return contact.Penalty(pair, PENALTY, TANGENTIAL, **options)

    def solve(fixed: IntArray, values: FloatArray, start: ContactSolution | None) -> ContactSolution:
        options: dict[str, Any] = {"steps": case.steps, "tolerance": 1e-13, "augmented": augmented}
        return other.solve_penalty(fixed, values, chi=PENALTY, chi_t=TANGENTIAL, start=start, **options)

    their_points: list[IntArray] = []
    for name, problem, ours, theirs in solve_stages(
        case, supports, method, solve, lambda ours: their_points.append(match_points(body, ours, other))
    ):
        at = their_points[0]
        tractions = ours.evaluated.tangential, theirs.traction[at]
        _rows(report, form, case, name, problem, ours, theirs, theirs.pressure[at], tractions, theirs.status[at])


def compare_lagrange(report: Report, form: str, case: Case) -> None:
    """Add the rows of mortar multipliers: displacements, forces, pressures and status.

    Args:
        report: report to add to.
        form: name of the row's form without "contact.".
        case: bodies and displacements.
    """
    body, degree = case.body, 3 * case.body.degree + 4
    supports = Supports(case)
    body.prescribed = supports.dofs
    # On obstacles our side integrates only shape functions, always with this rule.
    points = rule(body.facet, 2 * body.degree + 2) if body.rigid else rule(body.segment, degree)
    other = body.theirs(points)

    def method(pair: contact.ContactPair) -> contact.Lagrange:
        return contact.Lagrange(pair, quadrature_degree=degree)

    def solve(fixed: IntArray, values: FloatArray, start: ContactSolution | None) -> ContactSolution:
        return other.solve_lagrange(fixed, values, start=start, steps=case.steps, tolerance=1e-13)

    for name, problem, ours, theirs in solve_stages(case, supports, method, solve):
        pressure, traction, status = (
            body.nodal_to_ours(v)[ours.nodes] for v in (theirs.pressure, theirs.traction, theirs.status)
        )
        tractions = ours.friction_traction, traction
        _rows(report, form, case, name, problem, ours, theirs, pressure, tractions, status)


def _rows(
    report: Report,
    form: str,
    case: Case,
    name: str,
    problem: StaticProblem,
    ours: Any,
    theirs: ContactSolution,
    pressure: FloatArray,
    tractions: tuple[FloatArray, FloatArray],
    status: IntArray,
) -> None:
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
        slip = what == "friction traction" and form.endswith("lagrange")
        tolerance = (SLIP_TOLERANCE, SLIP_REASON) if slip else (TOLERANCE, REASON)
        Rows(report, body, f"{what} of the {name}")(form, a, b, *tolerance, case.remark)
