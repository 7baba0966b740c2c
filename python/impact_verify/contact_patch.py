# SPDX-License-Identifier: MIT
"""Level contact at a given state: both sides evaluate the same displacements, penalties and multipliers."""

from collections.abc import Sequence
from typing import Any, cast

import impact_reference
import numpy as np
from dolfinx import fem
from dolfinx.fem import DirichletBC
from petsc4py import PETSc
from scipy.sparse import coo_matrix

from dolfinx_impact import _cpp, contact
from dolfinx_impact.common.types import AnyArray, ArrayLike, FloatArray, IntArray
from dolfinx_impact.materials import _Material
from dolfinx_impact.statics.static_problem import StaticProblem
from . import differences, matched_body
from .contact_bodies import MASTER, SLAVE, TwoBodies, rule
from .report import Report

TOLERANCE = 1e-10
REASON = "round-off of projections, times body size over gap"
NORMALS_TOLERANCE = 1e-8
PENALTY, TANGENTIAL = 3.0, 2.0  # [F/L^3]
#: Pairs whose gaps are not the distances of the meshes: a layer; all initial gaps one; those up to a limit one [L].
ADJUSTMENTS: dict[str, dict[str, float]] = {
    "with a layer": {"offset": 0.004},
    "with a clearance": {"clearance": 0.002},
    "adjusted up to a gap": {"offset": 0.003, "adjust": 0.006, "clearance": -0.001},
}


class Rows:
    """Adds the rows of one body and one kind of master to a report.

    Args:
        report: report to add to.
        body: bodies of both sides.
        name: name of the master in the rows.
    """

    def __init__(self, report: Report, body: TwoBodies, name: str) -> None:
        self.report, self.body, self.name = report, body, name

    def __call__(
        self,
        form: str,
        ours: ArrayLike,
        theirs: ArrayLike,
        tolerance: float = TOLERANCE,
        reason: str = REASON,
        remark: str = "",
    ) -> None:
        """Add the row of two arrays: their largest difference over the largest entry.

        Args:
            form: quantity that is compared.
            ours: our array.
            theirs: array of the other side, of the same shape.
            tolerance: bound on the difference [1].
            reason: what the tolerance follows from.
            remark: text that is appended to the note of the row.
        """
        body = self.body
        ours, theirs = np.asarray(ours, dtype=float), np.asarray(theirs, dtype=float)
        difference: float
        if ours.shape != theirs.shape:
            difference, note = np.inf, f"UFL side {ours.shape} values, hand-written side {theirs.shape}"
        elif not np.any(theirs):
            difference, note = np.max(np.abs(ours), initial=0.0), "all values of the hand-written side are zero"
        else:
            error = np.where(np.isnan(ours - theirs), np.inf, np.abs(ours - theirs))
            k = np.unravel_index(np.argmax(error), error.shape)
            difference = error[k] / np.max(np.abs(theirs))
            note = f"entry {[int(i) for i in k]}: UFL {ours[k]:.15g}, hand-written {theirs[k]:.15g}"
        element = (body.cell, body.degree, body.geometry_degree, body.hypothesis)
        self.report.add("contact", f"contact.{form}", *element, difference, tolerance, reason, self.name, note + remark)


def displacements(body: TwoBodies, seed: int) -> tuple[FloatArray, FloatArray]:
    """Two random states near each other; the surfaces partly penetrate in both.

    Args:
        body: bodies of both sides.
        seed: seed of the random numbers.

    Returns:
        Displacements of the last converged state and of the present one, shape (num_dofs) each [L].
    """
    rng = np.random.default_rng([seed, 1])
    start, step = (0.02 * rng.uniform(-1, 1, len(body.u.x.array)) for _ in range(2))
    return start, start + 0.2 * step


def bind(body: TwoBodies, method: contact.Penalty | contact.Lagrange, bcs: Sequence[DirichletBC] = ()) -> Any:
    """Make a problem with one contact.

    Args:
        body: bodies of both sides.
        method: our contact.
        bcs: Dirichlet conditions of the problem.

    Returns:
        The problem's contact.
    """
    return StaticProblem(body.u, cast(_Material, body.material), bcs=bcs, contact=[method]).contact[0]


def begin_step(body: TwoBodies, ours: Any, start: FloatArray, displacement: FloatArray) -> None:
    """Begin an increment on both sides.

    Args:
        body: bodies of both sides.
        ours: our contact.
        start: displacements at the start, shape (num_dofs) [L].
        displacement: displacement of a rigid master in the increment, shape (gdim) [L].
    """
    ours.begin_step(start, np.pad(displacement, (0, 3 - body.gdim)) if body.rigid else None)
    if body.rigid:
        body.rigid[1].displacement = displacement


def match_points(body: TwoBodies, ours: Any, theirs: impact_reference.Contact) -> IntArray:
    """Match the slave's quadrature points of both sides by their reference positions.

    Call it before our contact has moved.

    Args:
        body: bodies of both sides.
        ours: our contact.
        theirs: contact of the other side.

    Returns:
        Number of the other side's point at each of our points, shape (num_points).
    """
    return matched_body.match_nodes(
        ours.points, theirs.closest_points(np.zeros(len(body.u.x.array))).position, body.size
    )


def empty_matrix(size: int) -> PETSc.Mat:
    """Empty square matrix on this rank that takes entries anywhere.

    Args:
        size: number of rows.

    Returns:
        Assembled matrix.
    """
    A = PETSc.Mat().createAIJ((size, size))
    A.setUp()
    A.setOption(PETSc.Mat.Option.NEW_NONZERO_ALLOCATION_ERR, False)
    A.assemble()
    return A


# --- penalty ---------------------------------------------------------------------------------------------------------


def penalty(report: Report, body: TwoBodies, name: str, seed: int) -> None:
    """Add the rows of penalty contact: gaps, normals, forces, tangent and friction, with random tractions before.

    Args:
        report: report to add to.
        body: bodies of both sides.
        name: name of the master in the rows.
        seed: seed of the random numbers.
    """
    rows, rng = Rows(report, body, name), np.random.default_rng(seed)
    degree = 2 * body.degree + 2
    ours = bind(body, contact.Penalty(body.pair(), PENALTY, TANGENTIAL, quadrature_degree=degree))
    theirs = body.theirs(rule(body.facet, degree))
    their_points = match_points(body, ours, theirs)
    start, u = displacements(body, seed)
    begin_step(body, ours, start, 0.004 * rng.uniform(-1, 1, body.gdim))
    ours.update_gap(u)
    at, n = theirs.closest_points(body.to_theirs(u)), ours.normal
    # Tractions near the friction bound, so that some points stick and some slip; open points have none.
    t = 0.02 * body.friction * PENALTY * rng.uniform(-1, 1, n.shape)
    t -= np.einsum("qa,qb,qb->qa", n, n, t)
    t[~np.isfinite(at.gap[their_points])] = 0.0
    ours.history.traction, ours.history.slip = t.ravel(), (0.01 * t).ravel()
    our_points = np.argsort(their_points)
    history = theirs.no_history()  # no point was closed: only a part of the motion of closing points is slip
    history.u, history.traction, history.slip = body.to_theirs(start), t[our_points], 0.01 * t[our_points]
    ours.update_gap(u)
    result = theirs.penalty(body.to_theirs(u), PENALTY, TANGENTIAL, history)
    _points(rows, ours, result.points, their_points)
    rows("penalty_force", ours.contact_forces(), body.to_ours(result.force))
    tangent = differences.petsc_to_scipy(ours.tangent())
    rows("penalty_tangent", tangent.toarray(), body.matrix_to_ours(result.tangent).toarray())
    ours.accept_step()
    rows("friction_slip", ours.history.slip.reshape(-1, body.gdim), result.history.slip[their_points])


def adjusted(report: Report, body: TwoBodies, name: str, seed: int) -> None:
    """Add the rows of penalty contact again, with a layer on the surfaces and with initial gaps that are adjusted.

    Args:
        report: report to add to.
        body: bodies of both sides.
        name: name of the master in the rows.
        seed: seed of the random numbers.
    """
    for text, adjustment in ADJUSTMENTS.items():
        body.adjustment = adjustment
        penalty(report, body, f"{name}, {text}", seed)
    body.adjustment = {}


def _points(rows: Rows, ours: Any, points: impact_reference.contact.Points, place: IntArray) -> None:
    gap, normal = points.gap[place], points.normal[place]
    faces = np.isfinite(gap)
    rows("gap", ours.gap[faces], gap[faces])
    # Beyond the master's edge the other side has no gap and ours a positive one; both must have status open.
    rows("status", ours.status, points.status[place])
    rows("normals", ours.normal[faces], normal[faces])
    rows("point_area", ours.weight, points.weight[place])
    rows("pressure", ours.pressure, points.pressure[place])
    rows("friction_traction", ours.evaluated.tangential, points.traction[place])


# --- multipliers -----------------------------------------------------------------------------------------------------


def _symmetry_conditions(body: TwoBodies) -> tuple[list[DirichletBC], IntArray]:
    """Conditions on the first component of the first slave nodes and of the master, as on a plane of symmetry; and
    their degrees of freedom."""
    nodes, master_nodes = (
        fem.locate_dofs_topological(body.V, body.gdim - 1, body.tags.find(tag)).astype(np.int32)
        for tag in (SLAVE, MASTER)
    )
    x = body.V.tabulate_dof_coordinates()[nodes, 0]
    dofs = body.gdim * np.union1d(nodes[x < x.min() + 0.1], master_nodes)
    return [fem.dirichletbc(np.asarray(0.0), dofs, body.V.sub(0))], dofs


def mortar(report: Report, body: TwoBodies, name: str, seed: int) -> None:
    """Add the rows of mortar contact: matrices, gaps, slips, normals, forces and tangents of random multipliers.

    Every basis is compared. For degree 1 the linear functions are the shape functions.

    Args:
        report: report to add to.
        body: bodies of both sides.
        name: name of the master in the rows.
        seed: seed of the random numbers.
    """
    for basis in ("dual", "standard", "linear")[: body.degree + 1]:
        _mortar(report, body, name, seed, basis)


def _geometry(body: TwoBodies, basis: str, degree: int, bcs: Sequence[DirichletBC]) -> Any:
    return bind(body, contact.Lagrange(body.pair(), degree, basis), bcs).geometry


def _mortar(report: Report, body: TwoBodies, name: str, seed: int, basis: str) -> None:
    rows, rng = Rows(report, body, name), np.random.default_rng(seed)
    degree, kind = 3 * body.degree + 4, "mortar" if basis == "dual" else basis
    bcs, body.prescribed = _symmetry_conditions(body)
    ours = _geometry(body, basis, degree, bcs)
    theirs = body.theirs(rule(body.segment, degree))
    start, u = displacements(body, seed)
    ours.begin_step(start, np.zeros(3))
    ours.update_gap(u)
    nodes, on = ours.nodes, ours.participates
    history = theirs.no_history()
    history.u = body.to_theirs(start)
    z = np.zeros((len(body.nodes), body.gdim))
    z[nodes[on]] = rng.uniform(-1, 1, (on.sum(), body.gdim))
    result = theirs.mortar(body.to_theirs(u), basis, body.nodal_to_theirs(z), history)
    _matrices(rows, body, ours, result, kind)
    everywhere = np.zeros(len(body.nodes), dtype=bool)
    everywhere[nodes[on]] = True
    rows(f"{kind}_participates", everywhere, body.nodal_to_ours(result.participates))
    normals = body.nodal_to_ours(result.normals)[nodes]
    gap, cover = (body.nodal_to_ours(v)[nodes][on] for v in (result.gap, result.cover))
    both = [np.where(np.isfinite(g), g, 0.0) for g in (ours.gap[on], gap)]  # `participates` has a row of its own
    rows(f"{kind}_gap", both[0] * ours.cover[on], both[1] * cover)
    slip = body.nodal_to_ours(result.moved)[nodes][on] / ours.cover[on, None]
    n = normals[on]
    rows(f"{kind}_slip", ours.slip()[on], slip - np.einsum("ja,jb,jb->ja", n, n, slip))
    rows(f"{kind}_force", ours.forces(z[nodes]), body.to_ours(result.force))
    if basis == "dual":
        rows("normals", ours.normal, normals)
        _normal_derivative(rows, body, ours, theirs, u, rng)
    body.prescribed = ()


def _dense(entries: tuple[IntArray, IntArray, FloatArray], size: int) -> FloatArray:
    rows, cols, values = entries
    return coo_matrix((values, (rows, cols)), shape=(size, size)).toarray()


def _matrices(rows: Rows, body: TwoBodies, ours: Any, theirs: impact_reference.contact.Mortar, kind: str) -> None:
    num = len(body.nodes)
    D, M = (body.nodal_matrix_to_ours(matrix).toarray() for matrix in (theirs.D, theirs.M))
    rows(f"{kind}_D", _dense(ours.mortar.D, num), D)
    rows(f"{kind}_M", _dense(ours.mortar.M, num), M)
    jump = ours.jump_matrix()
    rows(f"{kind}_jump", differences.petsc_to_scipy(jump).toarray(), D - M)
    gamma = np.zeros((num, body.gdim))
    np.add.at(gamma, ours.search.slave.nodes.ravel(), ours.mortar.gamma.reshape(-1, body.gdim))
    rows(f"{kind}_gamma", gamma, body.nodal_to_ours(theirs.gamma))


def _normal_derivative(
    rows: Rows,
    body: TwoBodies,
    ours: Any,
    theirs: impact_reference.Contact,
    u: FloatArray,
    rng: np.random.Generator,
    step: float = 1e-4,
) -> None:
    """Derivative of the nodal normals along a random direction: ours against differences of the other side's."""
    # Without prescribed degrees of freedom, because this tangent does not contain their effect on the normals.
    theirs = type(theirs)(
        body.model, body.their_facets(body.tags, SLAVE), body.their_facets(body.tags, MASTER), rule=theirs.rule
    )
    force = np.zeros(len(body.nodes))
    force[ours.nodes] = rng.uniform(-1, 1, len(ours.nodes))
    tangent = _cpp.gap.turning_tangent(ours.search.slave, ours.integrals.normal_sums, force)
    direction = rng.uniform(-1, 1, len(u))

    def normals(h: float) -> AnyArray:
        return body.nodal_to_ours(theirs.mortar(body.to_theirs(u + h * direction)).normals)

    # Central differences of fourth order: their error is step^4 plus round-off over the step.
    derivative = (8 * (normals(step) - normals(-step)) - (normals(2 * step) - normals(-2 * step))) / (12 * step)
    reason = "differences of fourth order, step 1e-4"
    product = (_dense(tangent, len(u)) @ direction).reshape(-1, body.gdim)
    rows("turning_tangent", product, -force[:, None] * derivative, NORMALS_TOLERANCE, reason)


def nodes_on_obstacle(report: Report, body: TwoBodies, name: str, seed: int) -> None:
    """Add the rows of multipliers against a rigid master: gaps, normals and forces at the slave's nodes.

    Args:
        report: report to add to.
        body: bodies of both sides.
        name: name of the master in the rows.
        seed: seed of the random numbers.
    """
    rows, rng = Rows(report, body, name), np.random.default_rng(seed)
    ours = bind(body, contact.Lagrange(body.pair())).geometry
    theirs = body.theirs(rule(body.facet, 2 * body.degree + 2))
    start, u = displacements(body, seed)
    begin_step(body, ours, start, 0.004 * rng.uniform(-1, 1, body.gdim))
    ours.update_gap(u)
    nodes = ours.nodes
    z = np.zeros((len(body.nodes), body.gdim))
    z[nodes] = rng.uniform(-1, 1, (len(nodes), body.gdim))
    history = theirs.no_history()
    history.u = body.to_theirs(start)
    result = theirs.mortar(body.to_theirs(u), multipliers=body.nodal_to_theirs(z), history=history)
    normals = body.nodal_to_ours(result.normals)[nodes]
    rows("normals", ours.normal, normals)
    gap, cover = (body.nodal_to_ours(v)[nodes] for v in (result.gap, result.cover))
    rows("mortar_gap", ours.gap * ours.cover, gap * cover)
    slip = body.nodal_to_ours(result.moved)[nodes] / ours.cover[:, None]
    rows("mortar_slip", ours.slip(), slip - np.einsum("ja,jb,jb->ja", normals, normals, slip))
    rows("mortar_force", ours.forces(z[nodes]), body.to_ours(result.force))
