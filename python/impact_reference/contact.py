# SPDX-License-Identifier: MIT
"""Contact as docs/contact.md states it: brute-force search, exact tangents, two discretisations and their solvers.

Signs: the normal points out of the master, the gap is positive when open, pressures are positive in compression and are
forces per reference area, tractions act on the slave, a contact force stands on the right-hand side. Status: 0 open,
1 stick, 2 slip (a closed point without friction slips). The code is simple rather than fast: fast code is compared with
it.
"""

from dataclasses import dataclass, field
from typing import TypeAlias, Union

import numpy as np

from . import _reference, rules
from .array_types import ArrayLike, BoolArray, FloatArray, IntArray, Rule, floats, integers, vector
from .discretisation import Discretisation
from .sparse import Csr

OPEN, STICK, SLIP = 0, 1, 2


@dataclass
class RigidPlane:
    """Rigid half-space. Its displacement is read whenever a contact is evaluated or solved.

    Args:
        point: point of the plane, shape (gdim) [L].
        normal: normal that points out of the half-space, shape (gdim) [1].
        displacement: rigid displacement, shape (gdim) [L].
        angle: rotation vector, shape (3), in the plane a number, by which it turns before it is displaced [1].
        pivot: point that it turns about, shape (gdim); None: the point or the centre [L].
    """

    point: ArrayLike
    normal: ArrayLike
    displacement: ArrayLike = 0.0
    angle: ArrayLike = 0.0
    pivot: ArrayLike | None = None


@dataclass
class RigidSphere:
    """Rigid ball; a disc in plane problems, a ball on the axis or a torus in axisymmetric ones.

    Args:
        center: centre, shape (gdim) [L].
        radius: radius [L].
        displacement: rigid displacement, shape (gdim) [L].
        angle: rotation vector, shape (3), in the plane a number, by which it turns before it is displaced [1].
        pivot: point that it turns about, shape (gdim); None: the point or the centre [L].
    """

    center: ArrayLike
    radius: float
    displacement: ArrayLike = 0.0
    angle: ArrayLike = 0.0
    pivot: ArrayLike | None = None


@dataclass
class RigidCylinder:
    """Rigid cylinder of infinite length; in the plane a disc, without axis.

    Args:
        center: point of the axis, shape (gdim) [L].
        radius: radius [L].
        axis: direction of the axis, shape (3); None in the plane [1].
        displacement: rigid displacement, shape (gdim) [L].
        angle: rotation vector, shape (3), in the plane a number, by which it turns before it is displaced [1].
        pivot: point that it turns about, shape (gdim); None: the point or the centre [L].
    """

    center: ArrayLike
    radius: float
    axis: ArrayLike | None = None
    displacement: ArrayLike = 0.0
    angle: ArrayLike = 0.0
    pivot: ArrayLike | None = None


Obstacle: TypeAlias = Union[RigidPlane, RigidSphere, RigidCylinder]
# Shape, point, direction, radius and pivot as the compiled module takes them.
_ObstacleData: TypeAlias = tuple[str, FloatArray, FloatArray, float, FloatArray]
# u, load, u at the history, obstacle's displacement, traction, slip, touched, penalty multipliers, mortar multipliers,
# obstacle's rotation vector.
_State: TypeAlias = tuple[
    FloatArray, FloatArray, FloatArray, FloatArray, FloatArray, FloatArray, IntArray, FloatArray, FloatArray, FloatArray
]


@dataclass
class History:
    """Converged state that friction refers to."""

    u: FloatArray  # (num_dofs) [L]
    displacement: FloatArray  # of the rigid master (gdim) [L]
    traction: FloatArray  # tangential, at the slave's points (num_points, gdim) [F/L^2]
    slip: FloatArray  # sum over the steps (num_points, gdim) [L]
    touched: IntArray  # 1 where a point was closed (num_points)
    angle: FloatArray = field(default_factory=lambda: np.zeros(3))  # rotation vector of the rigid master (3) [1]


@dataclass
class Points:
    """Values at the quadrature points of the slave, facet by facet."""

    gap: FloatArray  # inf without master (num_points) [L]
    normal: FloatArray  # out of the master, zero without master (num_points, gdim) [1]
    facet: IntArray  # row of `master`, or -1 (num_points)
    coordinate: FloatArray  # reference coordinates of the projection on that facet (num_points, gdim - 1) [1]
    position: FloatArray  # current position of the slave point (num_points, gdim) [L]
    weight: FloatArray  # reference area of the point, including 2 pi R if axisymmetric [L^2], in the plane [L]
    pressure: FloatArray  # (num_points) [F/L^2]
    traction: FloatArray  # tangential (num_points, gdim) [F/L^2]
    status: IntArray  # 0 open, 1 stick, 2 slip (num_points)
    beside: IntArray  # 1 beside the master's rim, where layers and adjusted gaps do not count (num_points)


@dataclass
class Penalty:
    """Result of `Contact.penalty`."""

    force: FloatArray  # on both bodies (num_dofs) [F]
    tangent: Csr  # derivative of minus the force, to be added to K [F/L]
    points: Points
    history: History  # of this state, for the next step

    @property
    def gap(self) -> FloatArray:
        """Gap at the slave's points, shape (num_points) [L]."""
        return self.points.gap

    @property
    def pressure(self) -> FloatArray:
        """Contact pressure at the slave's points, shape (num_points) [F/L^2]."""
        return self.points.pressure

    @property
    def traction(self) -> FloatArray:
        """Tangential traction at the slave's points, shape (num_points, gdim) [F/L^2]."""
        return self.points.traction

    @property
    def status(self) -> IntArray:
        """Status of the slave's points, shape (num_points): 0 open, 1 stick, 2 slip."""
        return self.points.status


@dataclass
class Mortar:
    """Result of `Contact.mortar`. Nodes are those of the field."""

    D: Csr  # int psi_j phi_k dA_0 (num_nodes, num_nodes) [L^2]
    M: Csr  # int psi_j phi_l dA_0, l on the master (num_nodes, num_nodes) [L^2]
    gamma: FloatArray  # int psi_j (x_s - x_m) dA_0 (num_nodes, gdim) [L^3]
    normals: FloatArray  # zero off the slave (num_nodes, gdim) [1]
    moved: FloatArray  # sum D_jk du_k - sum M_jl du_l since the history (num_nodes, gdim) [L^3]
    cover: FloatArray  # int psi_j dA_0 (num_nodes) [L^2]
    participates: BoolArray  # True where a node has a multiplier (num_nodes)
    force: FloatArray  # of the multipliers (num_dofs) [F]
    tangent: Csr  # derivative of minus this force at constant multipliers [F/L]

    @property
    def gap(self) -> FloatArray:
        """Weighted gap n_j . gamma_j / int psi_j, shape (num_nodes); inf at nodes without multiplier [L]."""
        part = self.participates
        gap = np.full(len(part), np.inf)
        gap[part] = np.einsum("ja,ja->j", self.normals[part], self.gamma[part]) / self.cover[part]
        return gap


@dataclass
class ContactSolution:
    """Result of the solvers. For multipliers the values are per field node, for the penalty method per point."""

    u: FloatArray  # (num_dofs) [L]
    pressure: FloatArray  # (num_nodes or num_points) [F/L^2]
    traction: FloatArray  # tangential (num_nodes or num_points, gdim) [F/L^2]
    gap: FloatArray  # inf without master or multiplier (num_nodes or num_points) [L]
    status: IntArray  # 0 open, 1 stick, 2 slip (num_nodes or num_points)
    contact_force: FloatArray  # (num_dofs) [F]
    reactions: FloatArray  # internal force less load and contact force on fixed dofs, zero elsewhere (num_dofs) [F]
    iterations: list[int]  # Newton's, of every load step
    residuals: list[float]  # at the end of every load step, relative [1]
    multipliers: FloatArray | None = None  # z_j of mortar contact (num_nodes, gdim) [F/L^2]
    points: Points | None = None  # of the penalty method
    history: History | None = None
    state: _State | None = field(default=None, repr=False)  # for the argument `start` of the solvers


def _obstacle(master: Obstacle, gdim: int) -> _ObstacleData:
    zero = np.zeros(gdim)
    point = vector(master.point if isinstance(master, RigidPlane) else master.center)
    pivot = point if master.pivot is None else vector(master.pivot)
    if isinstance(master, RigidPlane):
        return ("plane", point, vector(master.normal), 0.0, pivot)
    axis = master.axis if isinstance(master, RigidCylinder) else None
    if isinstance(master, RigidCylinder) and gdim == 3 and axis is None:
        raise ValueError("a rigid cylinder in space needs an axis")
    shape = "sphere" if isinstance(master, RigidSphere) else "cylinder"
    return (shape, point, zero if axis is None else vector(axis), float(master.radius), pivot)


def rotation_vector(angle: ArrayLike) -> FloatArray:
    """A rotation as a vector of three components.

    Args:
        angle: rotation vector, shape (3), or the angle about the third axis [1].
    """
    given = floats(angle).ravel()
    return np.array([0.0, 0.0, given[0]]) if given.size == 1 else vector(given)


class Contact:
    """Contact of two parts of the surface of a Model, or of one part and a rigid obstacle.

    Args:
        model: the bodies.
        slave: points of every slave facet, shape (num_facets, nodes per facet); its vertices suffice.
        master: points of every master facet, as `slave`; or a rigid obstacle.
        friction: Coulomb's friction coefficient [1].
        rule: None, a degree, a name, or a pair (points, weights). For the penalty method and rigid masters it belongs
            to the facet (interval [-1, 1], triangle, quadrilateral [-1, 1]^2); for mortar integrals to the intervals
            or triangles that the facets are divided into.
        prescribed: degrees of freedom with Dirichlet values, which the normals of mortar contact respect.
        search_distance: masters further away are ignored; None for no limit [L].
        offset: of the penalty method: thickness of layers on both surfaces, gaps are less by it [L].
        clearance: of the penalty method: gap at rest of the points that are adjusted; None: zero [L].
        adjust: of the penalty method: points whose gap at rest is at most this are adjusted; None: with a clearance all
            that have a master, else none [L].

    Raises:
        ValueError: facets that are repeated or not on the boundary, or numbers out of range.
        TypeError: facets that are not integers.
    """

    def __init__(
        self,
        model: Discretisation,
        slave: ArrayLike,
        master: ArrayLike | Obstacle,
        friction: float = 0.0,
        rule: Rule | float = None,
        prescribed: ArrayLike = (),
        search_distance: float | None = None,
        offset: float = 0.0,
        clearance: float | None = None,
        adjust: float | None = None,
    ) -> None:
        self.model, self.friction, self.rule = model, float(friction), rule
        self.gdim = model.field_points.shape[1]
        self.obstacle: Obstacle | None = None
        facets: IntArray = np.zeros((0, 1), dtype=np.int64)
        if isinstance(master, (RigidPlane, RigidSphere, RigidCylinder)):
            self.obstacle = master
        else:
            facets = integers(master, "master", 2)
        self.slave_facets, self.master_facets = integers(slave, "slave", 2), facets
        self._prescribed: IntArray = np.asarray(prescribed, dtype=np.int64).reshape(-1)
        self._limit = np.inf if search_distance is None else float(search_distance)
        self._contact = self._compiled(self.friction)
        self.facet_rule = self._resolve(rules.facet_type(model.cell_type), 2 * model.degree + 2)
        self.num_points: int = self._contact.num_facets * len(self.facet_rule[1])
        self.gap_shift: FloatArray = np.zeros(0)
        if offset != 0.0 or clearance is not None or adjust is not None:
            self.gap_shift = self._shift(offset, clearance, adjust)
            self._contact.shift_gaps(self.gap_shift)

    def _shift(self, offset: float, clearance: float | None, adjust: float | None) -> FloatArray:
        """What is added to the gaps of the points, from those at rest, an obstacle where it was made."""
        kept = None if self.obstacle is None else self.obstacle.displacement
        if self.obstacle is not None:
            self.obstacle.displacement = 0.0
        at_rest = self.closest_points(np.zeros(self.model.num_dofs))
        if self.obstacle is not None and kept is not None:
            self.obstacle.displacement = kept
        meshed = at_rest.gap
        chosen = (
            np.isfinite(meshed)
            & (at_rest.beside == 0)
            & (clearance is not None if adjust is None else meshed - offset <= adjust)
        )
        return np.where(chosen, (clearance or 0.0) - np.where(chosen, meshed, 0.0), -offset)

    def _compiled(self, friction: float) -> _reference.Contact:
        return _reference.Contact(
            self.model._model,
            self.slave_facets,
            self.master_facets,
            [] if self.obstacle is None else [_obstacle(self.obstacle, self.gdim)],
            friction,
            self._prescribed,
            self._limit,
        )

    def _resolve(self, cell: str, default: int) -> tuple[FloatArray, FloatArray]:
        rule: Rule | float = default if self.rule is None else self.rule
        if isinstance(rule, (int, float, np.number)):
            if int(rule) != rule or rule < 0:
                raise ValueError(f"rule is {rule!r}: give a degree, a name or (points, weights)")
            rule = f"table:{int(rule)}" if cell != "triangle" or rule <= 8 else f"gauss_jacobi:{int(rule)}"
        points, weights = rules.points_and_weights(cell, rule, None, None, None, None)
        points = points.reshape(len(weights), -1) if points.size else points
        if points.ndim != 2 or points.shape[1] != self.gdim - 1 or not len(weights):
            raise ValueError(f"a rule here needs points of shape (n, {self.gdim - 1}) and n weights")
        return points, weights

    def segment_rule(self) -> tuple[FloatArray, FloatArray]:
        """Rule of mortar integrals: on segments of facets, or on the facet if the master is rigid.

        Returns:
            Points, shape (num_points, gdim - 1) [1], and weights, shape (num_points) [1].
        """
        cell, p = rules.facet_type(self.model.cell_type), self.model.degree
        affine = cell != "quadrilateral" and p == 1 and self.model.geometry_degree == 1
        if self.obstacle is None and cell == "quadrilateral":
            cell = "triangle"
        return self._resolve(cell, 3 * p + (2 if affine else 4))

    def _displacement(self) -> FloatArray:
        if self.obstacle is None:
            return np.zeros(self.gdim)
        return np.broadcast_to(floats(self.obstacle.displacement), (self.gdim,)).copy()

    def _angle(self) -> FloatArray:
        return np.zeros(3) if self.obstacle is None else rotation_vector(self.obstacle.angle)

    def pivot(self) -> FloatArray:
        """What the rigid master turns about, before it is displaced, shape (gdim) [L]."""
        assert self.obstacle is not None
        return _obstacle(self.obstacle, self.gdim)[4]

    def no_history(self) -> History:
        """History of a contact that was never closed.

        Returns:
            History with zero displacements, tractions and slips.
        """
        zero = np.zeros((self.num_points, self.gdim))
        touched = np.zeros(self.num_points, dtype=np.int64)
        return History(np.zeros(self.model.num_dofs), np.zeros(self.gdim), zero, zero.copy(), touched)

    def _history(
        self, history: History | None
    ) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, IntArray, FloatArray]:
        h = self.no_history() if history is None else history
        traction, slip = floats(h.traction), floats(h.slip)
        if traction.shape != (self.num_points, self.gdim) or slip.shape != traction.shape:
            raise ValueError(f"a history of this contact has {self.num_points} points, found {traction.shape}")
        return vector(h.u), vector(h.displacement), traction, slip, integers(h.touched, "touched", 1), vector(h.angle)

    def closest_points(self, u: ArrayLike) -> Points:
        """Closest points of the master to the slave's quadrature points.

        Args:
            u: displacements, shape (num_dofs) [L].

        Returns:
            Gap, normal, master facet, coordinate and position of every slave point; pressures are zero.
        """
        return self.penalty(u, 0.0).points

    def penalty(
        self,
        u: ArrayLike,
        chi: float,
        chi_t: float | None = None,
        history: History | None = None,
        multiplier: ArrayLike | None = None,
    ) -> Penalty:
        """Forces and tangent of penalty contact at quadrature points.

        Args:
            u: displacements, shape (num_dofs) [L].
            chi: normal penalty [F/L^3].
            chi_t: tangential penalty; None takes `chi` [F/L^3].
            history: state that friction refers to; None for a contact that was never closed.
            multiplier: multipliers lambda_q of the augmented method, shape (num_points); None for zero [F/L^2].

        Returns:
            Force, tangent, values at the points and the new history.

        Raises:
            ValueError: penalties that are not positive, or arrays of a wrong size.
        """
        chi_t = chi if chi_t is None else chi_t
        if not (np.isfinite(chi) and chi >= 0 and np.isfinite(chi_t) and chi_t >= 0) or chi > 0 == chi_t:
            raise ValueError(f"penalties must be positive and finite, found chi = {chi!r}, chi_t = {chi_t!r}")
        multiplier = np.zeros(0) if multiplier is None else vector(multiplier)
        if multiplier.size not in (0, self.num_points):
            raise ValueError(f"multiplier needs {self.num_points} values, found {multiplier.size}")
        force, tangent, points, history = self._contact.penalty(
            *self.facet_rule,
            self._displacement(),
            self._angle(),
            vector(u),
            float(chi),
            float(chi_t),
            *self._history(history),
            multiplier,
        )
        return Penalty(force, Csr(*tangent.arrays), Points(*points), History(*history))

    def mortar(
        self,
        u: ArrayLike,
        basis: str = "dual",
        multipliers: ArrayLike | None = None,
        history: History | None = None,
    ) -> Mortar:
        """Mortar integrals, and the force of multipliers.

        Args:
            u: displacements, shape (num_dofs) [L].
            basis: basis of the multipliers: "dual", "standard" (the shape functions) or "linear" (linear functions of
                the corners).
            multipliers: multipliers z_j, shape (num_nodes, gdim); None for zero [F/L^2].
            history: state that friction refers to; None for a contact that was never closed.

        Returns:
            Integrals, normals, force and tangent.

        Raises:
            ValueError: an unknown basis, or multipliers of a wrong shape.
        """
        nodes = len(self.model.field_points)
        z = np.zeros((nodes, self.gdim)) if multipliers is None else floats(multipliers)
        if z.shape != (nodes, self.gdim):
            raise ValueError(f"multipliers need shape ({nodes}, {self.gdim}), found {z.shape}")
        h = self.no_history() if history is None else history
        D, M, gamma, normals, moved, cover, part, force, tangent = self._contact.mortar(
            *self.segment_rule(),
            self._displacement(),
            self._angle(),
            basis,
            vector(u),
            vector(h.u),
            vector(h.displacement),
            vector(h.angle),
            z,
        )
        D, M, tangent = (Csr(*a.arrays) for a in (D, M, tangent))
        return Mortar(D, M, gamma, normals, moved, cover, part.astype(bool), force, tangent)

    def _start(self, start: ContactSolution | _State | None) -> _State | None:
        if start is not None:
            return start.state if isinstance(start, ContactSolution) else start
        h, nodes = self.no_history(), len(self.model.field_points)
        load = np.zeros(self.model.num_dofs)
        z = np.zeros((nodes, self.gdim))
        return (h.u, load, h.u, h.displacement, h.traction, h.slip, h.touched, np.zeros(0), z, h.angle)

    def _loads(
        self, fixed_dofs: ArrayLike, values: ArrayLike, load: ArrayLike | None
    ) -> tuple[IntArray, FloatArray, FloatArray, FloatArray, FloatArray]:
        fixed = integers(fixed_dofs, "fixed_dofs", 1)
        values = np.broadcast_to(floats(values), fixed.shape).copy()
        load = np.zeros(self.model.num_dofs) if load is None else vector(load)
        return fixed, values, load, self._displacement(), self._angle()

    def solve_penalty(
        self,
        fixed_dofs: ArrayLike,
        values: ArrayLike = 0.0,
        load: ArrayLike | None = None,
        chi: float | None = None,
        chi_t: float | None = None,
        steps: int = 1,
        start: ContactSolution | _State | None = None,
        augmented: bool = False,
        tolerance: float = 1e-12,
        max_iterations: int = 60,
    ) -> ContactSolution:
        """Equilibrium by the penalty method.

        Prescribed values, load and the obstacle's displacement vary linearly from the state `start` to the arguments.

        Args:
            fixed_dofs: prescribed degrees of freedom, shape (num_fixed).
            values: their displacements: one number, or shape (num_fixed) [L].
            load: external force, shape (num_dofs); None for zero [F].
            chi: normal penalty [F/L^3].
            chi_t: tangential penalty; None takes `chi` [F/L^3].
            steps: number of load steps.
            start: an earlier solution, or its `state`; None for the bodies at rest.
            augmented: use Uzawa's method with linear multipliers on the facets.
            tolerance: bound on the relative residual [1].
            max_iterations: bound on Newton's iterations per load step.

        Returns:
            Solution with values at the quadrature points.

        Raises:
            ValueError: penalties that are not positive.
            RuntimeError: Newton's method does not converge.
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
        history = History(state[2], state[3], state[4], state[5], state[6], state[9])
        return ContactSolution(
            state[0], p.pressure, p.traction, p.gap, p.status, *common, points=p, history=history, state=state
        )

    def solve_lagrange(
        self,
        fixed_dofs: ArrayLike,
        values: ArrayLike = 0.0,
        load: ArrayLike | None = None,
        steps: int = 1,
        basis: str = "dual",
        start: ContactSolution | _State | None = None,
        tolerance: float = 1e-12,
        max_iterations: int = 60,
    ) -> ContactSolution:
        """Equilibrium with mortar multipliers.

        Prescribed values, load and the obstacle's displacement vary linearly from the state `start` to the arguments.

        Args:
            fixed_dofs: prescribed degrees of freedom, shape (num_fixed).
            values: their displacements: one number, or shape (num_fixed) [L].
            load: external force, shape (num_dofs); None for zero [F].
            steps: number of load steps.
            basis: basis of the multipliers, as in `mortar`.
            start: an earlier solution, or its `state`; None for the bodies at rest.
            tolerance: bound on the relative residual [1].
            max_iterations: bound on Newton's iterations per load step.

        Returns:
            Solution with values at the field nodes.

        Raises:
            ValueError: an unknown basis.
            RuntimeError: Newton's method does not converge.
        """
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
        history = History(state[2], state[3], state[4], state[5], state[6], state[9])
        return ContactSolution(
            state[0], pressure, traction, gap, status, *common, multipliers=z, history=history, state=state
        )
