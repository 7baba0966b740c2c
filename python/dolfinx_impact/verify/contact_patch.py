# SPDX-License-Identifier: MIT
"""Level contact, a state given: what the two sides make of the same displacements, penalties and multipliers."""

import numpy as np
from dolfinx import fem
from petsc4py import PETSc
from scipy.sparse import coo_matrix

from .. import _cpp, contact
from ..contact.mortar.mortar_geometry import MortarGeometry
from ..statics.problem import StaticProblem
from . import bodies
from .contact_bodies import rule

TOLERANCE = 1e-10
REASON = "round-off of projections, times body size over gap"
TURNING = 1e-8
PENALTY, TANGENTIAL = 3.0, 2.0


class Rows:
    """Adds the rows of one body and one kind of master to a report."""

    def __init__(self, report, body, name):
        self.report, self.body, self.name = report, body, name

    def __call__(self, form, ours, theirs, tolerance=TOLERANCE, reason=REASON, remark=""):
        """Arrays are compared entry by entry, against the largest entry."""
        body = self.body
        ours, theirs = np.asarray(ours, dtype=float), np.asarray(theirs, dtype=float)
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


def displacements(body, seed):
    """Two random states near each other: the last converged one, and one; the surfaces partly penetrate in both."""
    rng = np.random.default_rng([seed, 1])
    start, step = (0.02 * rng.uniform(-1, 1, len(body.u.x.array)) for _ in range(2))
    return start, start + 0.2 * step


def bind(body, method, bcs=()):
    """Our contact in a problem of its own."""
    return StaticProblem(body.u, body.material, bcs=bcs, contact=[method]).contact[0]


def begin(body, ours, start, moved):
    """Our side at the start of an increment in which a rigid master goes to `moved`."""
    ours.begin_step(start, np.pad(moved, (0, 3 - body.gdim)) if body.rigid else None)
    if body.rigid:
        body.rigid[1].displacement = moved


def same_points(body, ours, theirs):
    """Numbers of their quadrature points at ours, by reference positions: to be called before ours has moved."""
    return bodies.matched(ours.points, theirs.closest_points(np.zeros(len(body.u.x.array))).position, body.size)


def empty_matrix(size):
    A = PETSc.Mat().createAIJ((size, size))
    A.setUp()
    A.setOption(PETSc.Mat.Option.NEW_NONZERO_ALLOCATION_ERR, False)
    A.assemble()
    return A


# --- penalty ---------------------------------------------------------------------------------------------------------


def penalty(report, body, name, seed):
    """Gaps, normals, forces, tangent and friction at the quadrature points, from a history with random tractions."""
    rows, rng = Rows(report, body, name), np.random.default_rng(seed)
    degree = 2 * body.degree + 2
    ours = bind(body, contact.Penalty(body.pair(), PENALTY, TANGENTIAL, quadrature_degree=degree))
    theirs = body.theirs(rule(body.facet, degree))
    place = same_points(body, ours, theirs)
    start, u = displacements(body, seed)
    moved = 0.004 * rng.uniform(-1, 1, body.gdim)
    begin(body, ours, start, moved)
    ours.update_gap(u)
    at, n = theirs.closest_points(body.to_theirs(u)), ours.normal
    # Tractions of about the bound, so that some points stick and some slip; open points have none.
    t = 0.02 * body.friction * PENALTY * rng.uniform(-1, 1, n.shape)
    t -= np.einsum("qa,qb,qb->qa", n, n, t)
    t[~np.isfinite(at.gap[place])] = 0.0
    ours.history.traction, ours.history.slip = t.ravel(), (0.01 * t).ravel()
    back = np.argsort(place)
    history = theirs.no_history()  # nothing touched: the motion of points that close counts in part
    history.u, history.traction, history.slip = body.to_theirs(start), t[back], 0.01 * t[back]
    ours.update_gap(u)
    answer = theirs.penalty(body.to_theirs(u), PENALTY, TANGENTIAL, history)
    _points(rows, ours, answer, place)
    rows("penalty_force", ours.contact_forces(), body.to_ours(answer.force))
    tangent = bodies.petsc_to_scipy(ours.tangent())
    rows("penalty_tangent", tangent.toarray(), body.matrix_to_ours(answer.tangent).toarray())
    ours.accept_step()
    rows("friction_slip", ours.history.slip.reshape(-1, body.gdim), answer.history.slip[place])


def _points(rows, ours, answer, place):
    points = answer.points
    gap, normal = points.gap[place], points.normal[place]
    faces = np.isfinite(gap)
    rows("gap", ours.gap[faces], gap[faces])
    # Beside the master's edge the other side knows no gap, ours a positive one: open is what both must say.
    rows("status", ours.status, points.status[place])
    rows("normals", ours.normal[faces], normal[faces])
    rows("point_area", ours.weight, points.weight[place])
    rows("pressure", ours.pressure, points.pressure[place])
    rows("friction_traction", ours._cpp.state.tangential, points.traction[place])


# --- multipliers -----------------------------------------------------------------------------------------------------


def _prescribed(body):
    """Boundary conditions on the first component of the first slave nodes and of the master, as on a plane of symmetry;
    and the dofs."""
    from .contact_bodies import MASTER, SLAVE

    nodes, faced = (
        fem.locate_dofs_topological(body.V, body.gdim - 1, body.tags.find(tag)).astype(np.int32)
        for tag in (SLAVE, MASTER)
    )
    x = body.V.tabulate_dof_coordinates()[nodes, 0]
    dofs = body.gdim * np.union1d(nodes[x < x.min() + 0.1], faced)
    return [fem.dirichletbc(0.0, dofs, body.V.sub(0))], dofs


def mortar(report, body, name, seed):
    """Mortar matrices, weighted gaps and slips, nodal normals, forces and tangents of random multipliers of every
    basis. For degree 1 the linear functions are the shape functions."""
    for basis in ("dual", "standard", "linear")[: body.degree + 1]:
        _mortar(report, body, name, seed, basis)


def _geometry(body, basis, degree, bcs):
    method = contact.Lagrange(body.pair(), quadrature_degree=degree)
    ours = bind(body, method, bcs)
    if basis == "dual":
        return ours.geometry
    return MortarGeometry(method, body.V, ours.problem.axisymmetric, ours.problem.fixed, basis)


def _mortar(report, body, name, seed, basis):
    rows, rng = Rows(report, body, name), np.random.default_rng(seed)
    degree, kind = 3 * body.degree + 4, "mortar" if basis == "dual" else basis
    bcs, body.prescribed = _prescribed(body)
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
    answer = theirs.mortar(body.to_theirs(u), basis, body.nodal_to_theirs(z), history)
    _matrices(rows, body, ours, answer, kind)
    everywhere = np.zeros(len(body.nodes), dtype=bool)
    everywhere[nodes[on]] = True
    rows(f"{kind}_participates", everywhere, body.nodal_to_ours(answer.participates))
    normals = body.nodal_to_ours(answer.normals)[nodes]
    gap, cover = (body.nodal_to_ours(v)[nodes][on] for v in (answer.gap, answer.cover))
    both = [np.where(np.isfinite(g), g, 0.0) for g in (ours.gap[on], gap)]  # who takes part is a row of its own
    rows(f"{kind}_gap", both[0] * ours.cover[on], both[1] * cover)
    slip = body.nodal_to_ours(answer.moved)[nodes][on] / ours.cover[on, None]
    n = normals[on]
    rows(f"{kind}_slip", ours.slip()[on], slip - np.einsum("ja,jb,jb->ja", n, n, slip))
    rows(f"{kind}_force", ours.forces(z[nodes]), body.to_ours(answer.force))
    if basis == "dual":
        rows("normals", ours.normal, normals)
        _turning(rows, body, ours, theirs, u, rng)
    body.prescribed = ()


def _dense(entries, size):
    rows, cols, values = entries
    return coo_matrix((values, (rows, cols)), shape=(size, size)).toarray()


def _matrices(rows, body, ours, answer, kind):
    num = len(body.nodes)
    D, M = (body.nodal_matrix_to_ours(matrix).toarray() for matrix in (answer.D, answer.M))
    rows(f"{kind}_D", _dense(ours.mortar.D, num), D)
    rows(f"{kind}_M", _dense(ours.mortar.M, num), M)
    jump = ours.jump_matrix()
    rows(f"{kind}_jump", bodies.petsc_to_scipy(jump).toarray(), D - M)
    gamma = np.zeros((num, body.gdim))
    np.add.at(gamma, ours.search.slave.nodes.ravel(), ours.mortar.gamma.reshape(-1, body.gdim))
    rows(f"{kind}_gamma", gamma, body.nodal_to_ours(answer.gamma))


def _turning(rows, body, ours, theirs, u, rng, step=1e-4):
    """Derivative of the nodal normals along a random direction: ours against differences of the other side's."""
    theirs = type(theirs)(
        body.model, body.their_facets(body.tags, 1), body.their_facets(body.tags, 2), rule=theirs.rule
    )  # nothing prescribed: what that changes is no part of this tangent
    force = np.zeros(len(body.nodes))
    force[ours.nodes] = rng.uniform(-1, 1, len(ours.nodes))
    tangent = _cpp.gap.turning_tangent(ours.search.slave, ours.integrals.normal_sums, force)
    direction = rng.uniform(-1, 1, len(u))

    def normals(h):
        return body.nodal_to_ours(theirs.mortar(body.to_theirs(u + h * direction)).normals)

    # Central differences of fourth order: of step^4, over round-off divided by the step.
    turn = (8 * (normals(step) - normals(-step)) - (normals(2 * step) - normals(-2 * step))) / (12 * step)
    reason = "differences of fourth order, step 1e-4"
    product = (_dense(tangent, len(u)) @ direction).reshape(-1, body.gdim)
    rows("turning_tangent", product, -force[:, None] * turn, TURNING, reason)


def nodes_on_obstacle(report, body, name, seed):
    """Gaps, normals and forces at the slave's nodes against a rigid master."""
    rows, rng = Rows(report, body, name), np.random.default_rng(seed)
    ours = bind(body, contact.Lagrange(body.pair())).geometry
    theirs = body.theirs(rule(body.facet, 2 * body.degree + 2))
    start, u = displacements(body, seed)
    begin(body, ours, start, 0.004 * rng.uniform(-1, 1, body.gdim))
    ours.update_gap(u)
    nodes = ours.nodes
    z = np.zeros((len(body.nodes), body.gdim))
    z[nodes] = rng.uniform(-1, 1, (len(nodes), body.gdim))
    history = theirs.no_history()
    history.u = body.to_theirs(start)
    answer = theirs.mortar(body.to_theirs(u), multipliers=body.nodal_to_theirs(z), history=history)
    normals = body.nodal_to_ours(answer.normals)[nodes]
    rows("normals", ours.normal, normals)
    gap, cover = (body.nodal_to_ours(v)[nodes] for v in (answer.gap, answer.cover))
    rows("mortar_gap", ours.gap * ours.cover, gap * cover)
    slip = body.nodal_to_ours(answer.moved)[nodes] / ours.cover[:, None]
    rows("mortar_slip", ours.slip(), slip - np.einsum("ja,jb,jb->ja", normals, normals, slip))
    rows("mortar_force", ours.forces(z[nodes]), body.to_ours(answer.force))
