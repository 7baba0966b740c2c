# SPDX-License-Identifier: MIT
"""Contact as docs/contact.md states it: brute-force search, exact tangents, two discretisations and their solvers.

Signs: the normal points out of the master, the gap is positive when open, pressures are positive in compression and are
forces per reference area, tractions act on the slave, a contact force stands on the right-hand side. Status: 0 open,
1 stick, 2 slip (a closed point without friction slips). Not a fast code: it is what a fast one is compared with.
"""

from dataclasses import dataclass, field

import numpy as np

from . import _reference, rules
from .model import _floats, _integers, _vector
from .sparse import Csr

OPEN, STICK, SLIP = 0, 1, 2


@dataclass
class RigidPlane:
    """Half-space below a point [L] and behind a normal that points out of it; both (gdim)."""

    point: np.ndarray
    normal: np.ndarray
    displacement: np.ndarray = 0.0  # (gdim) [L]; read whenever a Contact is evaluated or solved


@dataclass
class RigidSphere:
    """Ball; a disc in plane problems, a ball on the axis or a torus in axisymmetric ones. center (gdim) [L]."""

    center: np.ndarray
    radius: float  # [L]
    displacement: np.ndarray = 0.0  # (gdim) [L]


@dataclass
class RigidCylinder:
    """Endless cylinder about an axis through the center (gdim) [L]; in 2D a disc, without axis."""

    center: np.ndarray
    radius: float  # [L]
    axis: np.ndarray = None  # (3) [1]
    displacement: np.ndarray = 0.0  # (gdim) [L]


@dataclass
class History:
    """Converged state that friction refers to."""

    u: np.ndarray  # (num_dofs) [L]
    displacement: np.ndarray  # of the rigid master (gdim) [L]
    traction: np.ndarray  # tangential, at the slave's points (num_points, gdim) [F/L^2]
    slip: np.ndarray  # sum over the steps (num_points, gdim) [L]
    touched: np.ndarray  # 1 where a point was closed, integers (num_points)


@dataclass
class Points:
    """Values at the quadrature points of the slave, facet by facet."""

    gap: np.ndarray  # inf without master [L]
    normal: np.ndarray  # out of the master (num_points, gdim); zero without master
    facet: np.ndarray  # row of `master`, or -1
    coordinate: np.ndarray  # own reference coordinates on that facet (num_points, gdim - 1)
    position: np.ndarray  # current, of the slave point (num_points, gdim) [L]
    weight: np.ndarray  # reference area of the point, 2 pi R in it if axisymmetric [L^2], [L] in the plane
    pressure: np.ndarray  # [F/L^2]
    traction: np.ndarray  # tangential (num_points, gdim) [F/L^2]
    status: np.ndarray  # 0 open, 1 stick, 2 slip


@dataclass
class Penalty:
    """Answer of `Contact.penalty`."""

    force: np.ndarray  # on both bodies (num_dofs) [F]
    tangent: Csr  # derivative of minus the force: to be added to K [F/L]
    points: Points
    history: History  # of this state, for the next step

    gap = property(lambda self: self.points.gap)
    pressure = property(lambda self: self.points.pressure)
    traction = property(lambda self: self.points.traction)
    status = property(lambda self: self.points.status)


@dataclass
class Mortar:
    """Answer of `Contact.mortar`. Nodes are those of the field."""

    D: Csr  # int psi_j phi_k dA_0 (num_nodes, num_nodes)
    M: Csr  # int psi_j phi_l dA_0, l on the master (num_nodes, num_nodes)
    gamma: np.ndarray  # int psi_j (x_s - x_m) dA_0 (num_nodes, gdim)
    normals: np.ndarray  # (num_nodes, gdim), zero off the slave
    moved: np.ndarray  # sum D_jk du_k - sum M_jl du_l since the history (num_nodes, gdim)
    cover: np.ndarray  # int psi_j (num_nodes)
    participates: np.ndarray  # True where a multiplier lives
    force: np.ndarray  # of the multipliers (num_dofs) [F]
    tangent: Csr  # derivative of minus this force at constant multipliers [F/L]

    @property
    def gap(self):
        """n_j . gamma_j / int psi_j [L]; inf where no multiplier lives."""
        part = self.participates
        gap = np.full(len(part), np.inf)
        gap[part] = np.einsum("ja,ja->j", self.normals[part], self.gamma[part]) / self.cover[part]
        return gap


@dataclass
class ContactSolution:
    """Answer of the solvers. For multipliers pressure, gap and status are per field node, for penalty per point."""

    u: np.ndarray  # (num_dofs) [L]
    pressure: np.ndarray  # [F/L^2]
    traction: np.ndarray  # tangential [F/L^2]
    gap: np.ndarray  # inf where there is no master or no multiplier [L]
    status: np.ndarray
    contact_force: np.ndarray  # (num_dofs) [F]
    reactions: np.ndarray  # internal force less load and contact force on fixed dofs, zero elsewhere [F]
    iterations: list  # Newton's, of every load step
    residuals: list
    multipliers: np.ndarray = None  # z_j (num_nodes, gdim) [F/L^2]
    points: Points = None  # of the penalty method
    history: History = None
    state: tuple = field(default=None, repr=False)  # what `start` takes


def _obstacle(master, gdim):
    zero = np.zeros(gdim)
    if isinstance(master, RigidPlane):
        return ("plane", _vector(master.point), _vector(master.normal), 0.0)
    axis = getattr(master, "axis", None)
    if isinstance(master, RigidCylinder) and gdim == 3 and axis is None:
        raise ValueError("a rigid cylinder in space needs an axis")
    shape = "sphere" if isinstance(master, RigidSphere) else "cylinder"
    return (shape, _vector(master.center), zero if axis is None else _vector(axis), float(master.radius))


class Contact:
    """Contact of two parts of the surface of a Model, or of one and a rigid obstacle.

    slave, master: facets (m, nodes), as in Model.traction; master may be a RigidPlane, RigidSphere or RigidCylinder.
    friction: Coulomb's coefficient [1]. prescribed: dofs with Dirichlet values, which the normals of mortar contact
    respect. rule: None, a degree, or (points, weights): on the facet (interval [-1, 1], triangle, quadrilateral
    [-1, 1]^2) for the penalty method and rigid masters; on the interval or triangle that segments are made of for
    mortar integrals. search_distance [L]: masters further away do not count; None for no limit.
    ValueError for facets that are repeated or not on the boundary, and for numbers out of range.
    """

    def __init__(self, model, slave, master, friction=0.0, rule=None, prescribed=(), search_distance=None):
        self.model, self.friction, self.rule = model, float(friction), rule
        self.gdim = model.field_points.shape[1]
        rigid = isinstance(master, (RigidPlane, RigidSphere, RigidCylinder))
        self.obstacle = master if rigid else None
        facets = np.zeros((0, 1), dtype=np.int64) if rigid else _integers(master, "master", 2)
        prescribed = np.asarray(prescribed, dtype=np.int64).reshape(-1)
        limit = np.inf if search_distance is None else float(search_distance)
        self._contact = _reference.Contact(
            model._model,
            _integers(slave, "slave", 2),
            facets,
            [_obstacle(master, self.gdim)] if rigid else [],
            self.friction,
            prescribed,
            limit,
        )
        self.facet_rule = self._resolve(rules.facet_type(model.cell_type), 2 * model.degree + 2)
        self.num_points = self._contact.num_facets * len(self.facet_rule[1])

    def _resolve(self, cell, default):
        rule = default if self.rule is None else self.rule
        if isinstance(rule, (int, float, np.number)):
            if int(rule) != rule or rule < 0:
                raise ValueError(f"rule is {rule!r}: give a degree, a name or (points, weights)")
            rule = f"table:{int(rule)}" if cell != "triangle" or rule <= 8 else f"gauss_jacobi:{int(rule)}"
        points, weights = rules.points_and_weights(cell, rule, None, None, None, None)
        points = points.reshape(len(weights), -1) if points.size else points
        if points.ndim != 2 or points.shape[1] != self.gdim - 1 or not len(weights):
            raise ValueError(f"a rule here needs points of shape (n, {self.gdim - 1}) and n weights")
        return points, weights

    def segment_rule(self):
        """Points and weights of mortar integrals: on segments, or on the facet if the master is rigid."""
        cell, p = rules.facet_type(self.model.cell_type), self.model.degree
        affine = cell != "quadrilateral" and p == 1 and self.model.geometry_degree == 1
        if self.obstacle is None and cell == "quadrilateral":
            cell = "triangle"
        return self._resolve(cell, 3 * p + (2 if affine else 4))

    def _displacement(self):
        if self.obstacle is None:
            return np.zeros(self.gdim)
        return np.broadcast_to(_floats(self.obstacle.displacement), (self.gdim,)).copy()

    def no_history(self):
        """The state before anything happened."""
        zero = np.zeros((self.num_points, self.gdim))
        touched = np.zeros(self.num_points, dtype=np.int64)
        return History(np.zeros(self.model.num_dofs), np.zeros(self.gdim), zero, zero.copy(), touched)

    def _history(self, history):
        h = self.no_history() if history is None else history
        traction, slip = _floats(h.traction), _floats(h.slip)
        if traction.shape != (self.num_points, self.gdim) or slip.shape != traction.shape:
            raise ValueError(f"a history of this contact has {self.num_points} points, found {traction.shape}")
        return _vector(h.u), _vector(h.displacement), traction, slip, _integers(h.touched, "touched", 1)

    def closest_points(self, u):
        """Points: gap, normal, master facet, coordinate and position of every slave point; pressures are zero."""
        return self.penalty(u, 0.0).points

    def penalty(self, u, chi, chi_t=None, history=None, multiplier=None):
        """Gauss point to surface at u (num_dofs) [L] with chi [F/L^3]; returns a Penalty.

        chi_t (default chi) is the tangential stiffness, multiplier (num_points) the lambda_q of the augmented method.
        """
        chi_t = chi if chi_t is None else chi_t
        if not (np.isfinite(chi) and chi >= 0 and np.isfinite(chi_t) and chi_t >= 0) or chi > 0 == chi_t:
            raise ValueError(f"penalties must be positive and finite, found chi = {chi!r}, chi_t = {chi_t!r}")
        multiplier = np.zeros(0) if multiplier is None else _vector(multiplier)
        if multiplier.size not in (0, self.num_points):
            raise ValueError(f"multiplier needs {self.num_points} values, found {multiplier.size}")
        force, tangent, points, history = self._contact.penalty(
            *self.facet_rule,
            self._displacement(),
            _vector(u),
            float(chi),
            float(chi_t),
            *self._history(history),
            multiplier,
        )
        return Penalty(force, Csr(*tangent.arrays), Points(*points), History(*history))

    def mortar(self, u, basis="dual", multipliers=None, history=None):
        """Mortar integrals at u (num_dofs) [L], and the force of multipliers (num_nodes, gdim); returns a Mortar.

        basis: "dual", "standard" (the shape functions) or "linear" (hats of the corners). ValueError for others.
        """
        nodes = len(self.model.field_points)
        z = np.zeros((nodes, self.gdim)) if multipliers is None else _floats(multipliers)
        if z.shape != (nodes, self.gdim):
            raise ValueError(f"multipliers need shape ({nodes}, {self.gdim}), found {z.shape}")
        h = self.no_history() if history is None else history
        D, M, gamma, normals, moved, cover, part, force, tangent = self._contact.mortar(
            *self.segment_rule(),
            self._displacement(),
            basis,
            _vector(u),
            _vector(h.u),
            _vector(h.displacement),
            z,
        )
        D, M, tangent = (Csr(*a.arrays) for a in (D, M, tangent))
        return Mortar(D, M, gamma, normals, moved, cover, part.astype(bool), force, tangent)

    def _start(self, start):
        if start is not None:
            return start.state if isinstance(start, ContactSolution) else start
        h, nodes = self.no_history(), len(self.model.field_points)
        load = np.zeros(self.model.num_dofs)
        z = np.zeros((nodes, self.gdim))
        return (h.u, load, h.u, h.displacement, h.traction, h.slip, h.touched, np.zeros(0), z)

    def _loads(self, fixed_dofs, values, load):
        fixed = _integers(fixed_dofs, "fixed_dofs", 1)
        values = np.broadcast_to(_floats(values), fixed.shape).copy()
        load = np.zeros(self.model.num_dofs) if load is None else _vector(load)
        return fixed, values, load, self._displacement()

    def solve_penalty(
        self,
        fixed_dofs,
        values=0.0,
        load=None,
        chi=None,
        chi_t=None,
        steps=1,
        start=None,
        augmented=False,
        tolerance=1e-12,
        max_iterations=60,
    ):
        """Equilibrium by the penalty method; returns a ContactSolution.

        Prescribed values, load and the obstacle's displacement go linearly from the state `start` (an earlier
        solution; at rest by default) to what is given here, in `steps` steps. augmented: Uzawa's method with linear
        multipliers on the facets. RuntimeError if Newton's method fails.
        """
        if chi is None or not chi > 0 or (chi_t is not None and not chi_t > 0):
            raise ValueError(f"penalties must be positive, found chi = {chi!r}, chi_t = {chi_t!r}")
        result = self._contact.solve_penalty(
            *self.model._strain_rule(),
            *self.facet_rule,
            float(chi),
            float(chi if chi_t is None else chi_t),
            self._start(start),
            *self._loads(fixed_dofs, values, load),
            steps,
            max_iterations,
            tolerance,
            augmented,
        )
        state, force, reactions, iterations, residuals, points, *_ = result
        p = Points(*points)
        common = (force, reactions, iterations, residuals)
        history = History(*state[2:7])
        return ContactSolution(
            state[0], p.pressure, p.traction, p.gap, p.status, *common, points=p, history=history, state=state
        )

    def solve_lagrange(
        self,
        fixed_dofs,
        values=0.0,
        load=None,
        steps=1,
        basis="dual",
        start=None,
        tolerance=1e-12,
        max_iterations=60,
    ):
        """Equilibrium with mortar multipliers; arguments as for solve_penalty. Returns a ContactSolution."""
        result = self._contact.solve_lagrange(
            *self.model._strain_rule(),
            *self.segment_rule(),
            basis,
            self._start(start),
            *self._loads(fixed_dofs, values, load),
            steps,
            max_iterations,
            tolerance,
        )
        state, force, reactions, iterations, residuals, _, pressure, gap, status = result
        z = state[8]
        normals = self.mortar(state[0], basis).normals
        traction = z - pressure[:, None] * normals
        common = (force, reactions, iterations, residuals)
        history = History(*state[2:7])
        return ContactSolution(
            state[0], pressure, traction, gap, status, *common, multipliers=z, history=history, state=state
        )
