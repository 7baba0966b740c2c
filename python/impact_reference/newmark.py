# SPDX-License-Identifier: MIT
"""Implicit dynamics: Newmark's method and generalised-alpha, with the static contacts solved in every step.

With the step h, the acceleration-like variable A and the parameters of `NewmarkScheme`, a step solves

    u1 = u0 + h v0 + h^2 ((1/2 - beta) A0 + beta A1),
    v1 = v0 + h ((1 - gamma) A0 + gamma A1),
    (1 - alpha_m) A1 + alpha_m A0 = (1 - alpha_f) a1 + alpha_f a0,
    M a1 + (alpha M + beta_R K(u1)) v1 + F(u1) = L(t1) + contact force(u1)

(Arnold and Bruels 2007; A = a where alpha_m = alpha_f). Nodes that have passed on their mass ("massless") have
v1 = (u1 - u0)/h and no acceleration.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from . import _reference
from .array_types import ArrayLike, BoolArray, FloatArray, IntArray, TimeValues, vector
from .contact import Contact, History, _State
from .explicit import Load, _loads, _time_levels
from .discretisation import Discretisation
from .rigid_body import MovingBody, RigidBody, RigidState, find_root, forces_on
from .rotation import angle_of, matrix_of

ENERGIES = ("kinetic", "internal", "contact", "friction", "damping", "plastic", "external", "total")


@dataclass(frozen=True)
class NewmarkScheme:
    """Parameters of a scheme; the default is the trapezoidal rule.

    Args:
        beta: weight of A1 in the displacement, positive [1].
        gamma: weight of A1 in the velocity [1].
        alpha_m: weight of A0 against A1 [1].
        alpha_f: weight of a0 against a1 [1].

    Raises:
        ValueError: beta that is not positive.
    """

    beta: float = 0.25
    gamma: float = 0.5
    alpha_m: float = 0.0
    alpha_f: float = 0.0

    def __post_init__(self) -> None:
        if not self.beta > 0:
            raise ValueError(f"beta is {self.beta!r}: an implicit scheme needs a positive one")

    @staticmethod
    def chung_hulbert(rho: float) -> NewmarkScheme:
        """Generalised-alpha method (Chung and Hulbert 1993).

        Args:
            rho: spectral radius at infinite frequency, 0 to 1 [1].

        Returns:
            Scheme of second order.
        """
        alpha_m, alpha_f = (2 * rho - 1) / (rho + 1), rho / (rho + 1)
        s = 1 - alpha_m + alpha_f
        return NewmarkScheme(s**2 / 4, s - 0.5, alpha_m, alpha_f)

    @staticmethod
    def hht(alpha: float) -> NewmarkScheme:
        """Method of Hilber, Hughes and Taylor (1977).

        Args:
            alpha: their alpha, -1/3 to 0 [1].

        Returns:
            Scheme of second order.
        """
        return NewmarkScheme((1 - alpha) ** 2 / 4, 0.5 - alpha, 0.0, -alpha)


@dataclass
class ImplicitContact:
    """Contact of an implicit run: mortar multipliers, or the penalty method if `chi` is given.

    Args:
        contact: surfaces, friction and rule; its `prescribed` are the run's `fixed_dofs`.
        chi: normal penalty; None for multipliers [F/L^3].
        chi_t: tangential penalty; None takes `chi` [F/L^3].
        basis: basis of the multipliers, as in `Contact.mortar`.
        motion: displacement of a rigid master over time: shape (gdim), a function of t, or a table (times, values);
            None takes `displacement` of the obstacle at all times [L].
        angle: rotation vector of a rigid master over time, likewise, shape (3) [1].
        body: rigid body whose surface the obstacle is; it moves by forces.

    Raises:
        ValueError: penalties that are not positive, or a motion of a deformable master.
    """

    contact: Contact
    chi: float | None = None
    chi_t: float | None = None
    basis: str = "dual"
    motion: TimeValues | None = None
    angle: TimeValues | None = None
    body: RigidBody | None = None

    def __post_init__(self) -> None:
        if any(c is not None and not c > 0 for c in (self.chi, self.chi_t)):
            raise ValueError(f"penalties must be positive, found chi = {self.chi!r}, chi_t = {self.chi_t!r}")
        if (self.motion is not None or self.angle is not None) and self.contact.obstacle is None:
            raise ValueError("motion is for rigid masters; a deformable one moves with its nodes")
        self.chi_t = self.chi if self.chi_t is None else self.chi_t


@dataclass
class NewmarkContactHistory:
    """Values of a contact over time; the first axis counts the time levels.

    Points are the slave's quadrature points (penalty) or the field nodes (multipliers). At the start multipliers are
    zero.
    """

    total: FloatArray  # force on the slave (num_levels, gdim) [F]
    force: FloatArray  # nodal, on both bodies (num_levels, num_dofs) [F]
    pressure: FloatArray  # (num_levels, num_points) [F/L^2]
    traction: FloatArray  # tangential (num_levels, num_points, gdim) [F/L^2]
    gap: FloatArray  # inf without master (num_levels, num_points) [L]
    status: IntArray  # 0 open, 1 stick, 2 slip or closed without friction (num_levels, num_points)


@dataclass
class NewmarkResult:
    """Result of `Model.run_newmark`; the first axis counts the time levels, the start is the first."""

    time: FloatArray  # (num_levels) [T]
    u: FloatArray  # (num_levels, num_dofs) [L]
    v: FloatArray  # (num_levels, num_dofs) [L/T]
    a: FloatArray  # (num_levels, num_dofs) [L/T^2]
    support: FloatArray  # force on prescribed dofs, zero elsewhere (num_levels, num_dofs) [F]
    energies: dict[str, FloatArray]  # by the names of ENERGIES, each (num_levels) [F L]
    iterations: list[int]  # Newton's, of every step
    contact: NewmarkContactHistory | None = None
    plastic_strain: FloatArray = field(
        default_factory=lambda: np.zeros((0, 0))
    )  # of a PlasticBody (num_levels, points)
    bodies: list[RigidState] = field(default_factory=list)  # the rigid body at all time levels, if there is one


@dataclass
class _Level:
    """State and forces at one time level."""

    u: FloatArray
    v: FloatArray
    a: FloatArray
    A: FloatArray
    load: FloatArray
    inertia: FloatArray
    damping: FloatArray
    internal: FloatArray
    contact_force: FloatArray
    support: FloatArray
    total: FloatArray  # on the slave
    obstacle: FloatArray  # displacement of it
    angle: FloatArray  # its rotation vector
    torque: FloatArray  # on it, about its pivot
    springs: float = 0.0
    points: tuple[FloatArray, FloatArray, FloatArray, IntArray] | None = None  # pressure, traction, gap, status
    body: RigidState | None = None


class _Run:
    """One run: bodies with their mass, supports, loads, contact."""

    def __init__(
        self,
        model: Discretisation,
        times: FloatArray,
        scheme: NewmarkScheme,
        fixed_dofs: ArrayLike,
        motion: tuple[ArrayLike, ArrayLike, ArrayLike] | None,
        loads: FloatArray | Sequence[Load] | None,
        damping: tuple[float, float],
        lumping: str,
        contact: ImplicitContact | None,
        redistribute: bool,
        tolerance: float,
        max_iterations: int,
        plastic: Any,  # compiled part of a PlasticBody, or None
    ) -> None:
        self.model, self.times, self.scheme, self.contact, self.plastic = model, times, scheme, contact, plastic
        self.gdim: int = model.field_points.shape[1]
        self.fixed: IntArray = np.asarray(fixed_dofs, dtype=np.int64).reshape(-1)
        self.motion = motion
        self.vectors, self.amplitudes = _loads(loads, times, model.num_dofs)
        self.newton = int(max_iterations), float(tolerance)
        surface = np.zeros(len(model.field_points), dtype=bool)
        if contact is not None and redistribute:
            surface[contact.contact._contact.slave_nodes()] = True
            surface[contact.contact._contact.master_nodes()] = True
        mass = _reference.inertia_matrix(model._model, *model._rule("mass"), lumping, surface.tolist())
        alpha, beta = damping
        self.bodies = _reference.MovingBodies(
            model._model, *model._strain_rule(), [] if plastic is None else [plastic], mass, float(alpha), float(beta)
        )
        indptr, _, entries = mass.arrays
        largest = np.maximum.reduceat(np.abs(entries), indptr[:-1])
        self.is_fixed: BoolArray = np.zeros(model.num_dofs, dtype=bool)
        self.is_fixed[self.fixed] = True
        self.massless: BoolArray = (largest == 0.0) & ~self.is_fixed
        if np.any(self.massless & ~np.repeat(surface, self.gdim)):
            raise ValueError("a node has no mass: give every material a density, or take another lumping scheme")
        self.obstacle: FloatArray = np.zeros((len(times), self.gdim))
        self.angles: FloatArray = np.zeros((len(times), 3))
        if contact is not None and contact.contact.obstacle is not None:
            table = contact.contact.obstacle.displacement if contact.motion is None else contact.motion
            self.obstacle = _time_levels(table, times, self.gdim, "motion")
            turns = contact.contact.obstacle.angle if contact.angle is None else contact.angle
            self.angles = _time_levels(turns, times, 3, "angle")
        self.friction_work = 0.0
        self.body: MovingBody | None = None
        if contact is not None and contact.body is not None:
            self.body = MovingBody(contact.body, self.gdim, scheme)
        self.slave: IntArray = np.zeros(0, dtype=np.int64)
        if contact is not None:
            self.slave = contact.contact._contact.slave_nodes()

    def on_slave(self, force: FloatArray) -> FloatArray:
        """Sum of nodal contact forces on the slave."""
        return force.reshape(-1, self.gdim)[self.slave].sum(axis=0)

    def forces_on_master(self, force: FloatArray, u: FloatArray, place: FloatArray) -> FloatArray:
        """Force of contact on a rigid master, and torque about its pivot."""
        if self.contact is None or self.contact.contact.obstacle is None:
            return np.zeros(6)
        pivot = self.contact.contact.pivot()
        centre = np.pad(pivot + place, (0, 3 - self.gdim))
        return forces_on(self.contact.contact, force, u, centre)

    def prescribed(self, level: int, u0: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Displacements, velocities and accelerations of the fixed dofs at a time level."""
        if self.motion is None:
            zero = np.zeros(self.fixed.size)
            return u0[self.fixed], zero, zero
        tables = (np.asarray(values, dtype=float)[level] for values in self.motion)
        u, v, a = (np.broadcast_to(row, self.fixed.shape).copy() for row in tables)
        return u, v, a

    def load(self, level: int) -> FloatArray:
        return self.amplitudes[level] @ self.vectors if len(self.vectors) else np.zeros(self.model.num_dofs)

    def start(self, u0: FloatArray, v0: FloatArray) -> tuple[_Level, _State | None]:
        """Level 0: accelerations in equilibrium with all forces but those of multipliers."""
        u, v, a = u0.copy(), v0.copy(), np.zeros(u0.size)
        values, speeds, accelerations = self.prescribed(0, u0)
        u[self.fixed], v[self.fixed], a[self.fixed] = values, speeds, accelerations
        load = self.load(0)
        state: _State | None = None
        contact_force: FloatArray = np.zeros(u.size)
        springs, points = 0.0, None
        if self.contact is not None:
            c = self.contact.contact
            place = self.obstacle[0]
            h = c.no_history()
            z = np.zeros((len(self.model.field_points), self.gdim))
            if self.contact.chi is not None:
                self._place(place, self.angles[0])
                before = replace(h, u=u.copy(), displacement=place.copy(), angle=self.angles[0].copy())
                p = c.penalty(u, self.contact.chi, self.contact.chi_t, before)
                h, contact_force = p.history, p.force
                springs = self._springs(p.points.weight, p.pressure, p.traction)
                points = (p.pressure, p.traction, p.gap, p.status)
            else:
                count = len(self.model.field_points)
                open_nodes = np.zeros(count, dtype=np.int64)
                points = (np.zeros(count), np.zeros((count, self.gdim)), np.full(count, np.inf), open_nodes)
            state = (
                u,
                load,
                u.copy(),
                place.copy(),
                h.traction,
                h.slip,
                h.touched,
                np.zeros(0),
                z,
                self.angles[0].copy(),
            )
        internal, damping = self.bodies.internal_force(u), self.bodies.damping_force(u, v)
        unknown = ~self.is_fixed & ~self.massless
        a = self.bodies.solve_acceleration(load + contact_force - internal - damping, a, unknown.tolist())
        inertia = self.bodies.inertia_force(a)
        support = np.where(self.is_fixed, inertia + damping + internal - load - contact_force, 0.0)
        place, total = self.obstacle[0], self.on_slave(contact_force)
        forces = load, inertia, damping, internal, contact_force, support, total
        on_master = self.forces_on_master(contact_force, u, place)
        body = None if self.body is None else self.body.start(on_master)
        at = place, self.angles[0], on_master[3:]
        return _Level(u, v, a, a.copy(), *forces, *at, springs, points, body), state

    def _place(self, displacement: FloatArray, angle: FloatArray) -> None:
        """Put the obstacle in its place."""
        if self.contact is not None and self.contact.contact.obstacle is not None:
            self.contact.contact.obstacle.displacement = displacement.copy()
            self.contact.contact.obstacle.angle = angle.copy()

    def _springs(self, weight: FloatArray, pressure: FloatArray, traction: FloatArray) -> float:
        assert self.contact is not None and self.contact.chi is not None and self.contact.chi_t is not None
        normal = weight @ pressure**2 / (2 * self.contact.chi)
        return float(normal + weight @ np.sum(traction**2, axis=1) / (2 * self.contact.chi_t))

    def step(self, number: int, old: _Level, state: _State | None) -> tuple[_Level, _State | None, int]:
        """From level `number` - 1 to level `number`."""
        s, h = self.scheme, float(self.times[number] - self.times[number - 1])
        values, speeds, accelerations = self.prescribed(number, old.u)
        # A1 = (u1 - u0)/(beta h^2) + A_rest; a1 and v1 follow.
        A_slope = 1 / (s.beta * h**2)
        A_rest = -old.v / (s.beta * h) - (0.5 - s.beta) / s.beta * old.A
        a_rest = ((1 - s.alpha_m) * A_rest + s.alpha_m * old.A - s.alpha_f * old.a) / (1 - s.alpha_f)
        a_slope = np.full(old.u.size, (1 - s.alpha_m) / (1 - s.alpha_f) * A_slope)
        v_rest = old.v + h * ((1 - s.gamma) * old.A + s.gamma * A_rest)
        v_slope = np.full(old.u.size, s.gamma * h * A_slope)
        loose = self.massless
        a_slope[loose], a_rest[loose], v_slope[loose], v_rest[loose] = 0.0, 0.0, 1 / h, 0.0
        f = self.fixed
        a_slope[f], a_rest[f], v_slope[f], v_rest[f] = 0.0, accelerations, 0.0, speeds
        self.bodies.set_motion(old.u, a_slope, a_rest, v_slope, v_rest)
        load, place, angle = self.load(number), self.obstacle[number], self.angles[number]
        body: RigidState | None = None
        if self.body is None:
            solved = self._solve(old, state, values, load, place, angle)
        else:
            solved, body = self._solve_with_body(old, state, values, load, h)
            place, angle = body.displacement[: self.gdim], angle_of(body.rotation)
        u, support, contact_force, iterations, springs, points, state = solved
        v, a = self.bodies.velocity(u), self.bodies.acceleration(u)
        A = A_slope * (u - old.u) + A_rest
        A[loose | self.is_fixed] = a[loose | self.is_fixed]
        internal, damping = self.bodies.internal_force(u), self.bodies.damping_force(u, v)
        inertia = self.bodies.inertia_force(a)
        forces = load, inertia, damping, internal, contact_force, support, self.on_slave(contact_force)
        at = place, angle, self.forces_on_master(contact_force, u, place)[3:]
        return _Level(u, v, a, A, *forces, *at, springs, points, body), state, iterations

    def _solve_with_body(
        self, old: _Level, state: _State | None, values: FloatArray, load: FloatArray, h: float
    ) -> tuple[tuple[Any, ...], RigidState]:
        """The end of a step of the deformable bodies and of the rigid one together."""
        assert self.body is not None and old.body is not None
        moving, before, work = self.body, old.body, self.friction_work
        last: list[Any] = []

        def missing(q: FloatArray) -> tuple[FloatArray, float]:
            at = moving.end(before, h, q, np.zeros(6))
            self.friction_work = work
            place = at.displacement[: self.gdim]
            solved = self._solve(old, state, values, load, place, angle_of(at.rotation))
            body = moving.end(before, h, q, self.forces_on_master(solved[2], solved[0], place))
            last[:] = solved, body
            return moving.lacks(body)

        guess = h * before.rate[moving.free] + h**2 / 2.0 * before.mean[moving.free]
        find_root(missing, guess, 1e-6, 1e-11)
        return last[0], last[1]

    def _solve(
        self,
        old: _Level,
        state: _State | None,
        values: FloatArray,
        load: FloatArray,
        place: FloatArray,
        angle: FloatArray,
    ) -> tuple[Any, ...]:
        """Displacement at the end of a step and what belongs to it."""
        if self.contact is None:
            result = self.bodies.step(self.model._model, old.u, self.fixed, values, load, *self.newton)
            u, support, iterations, _ = result
            return u, support, np.zeros(u.size), iterations, 0.0, None, None
        c, compiled = self.contact.contact, self.contact.contact._contact
        self._place(place, angle)
        arguments = state, self.fixed, values, load, place, angle, *self.newton
        assert state is not None
        if self.contact.chi is not None:
            result = compiled.step_penalty(self.bodies, *c.facet_rule, self.contact.chi, self.contact.chi_t, *arguments)
            after, force, support, iterations, _, at_points, *_ = result
            gap, _, _, _, _, weight, pressure, traction, status, _ = at_points
            self.friction_work -= weight @ np.sum(traction * (after[5] - state[5]), axis=1)
            springs, points = self._springs(weight, pressure, traction), (pressure, traction, gap, status)
            return after[0], support, force, iterations[-1], springs, points, after
        result = compiled.step_lagrange(self.bodies, *c.segment_rule(), self.contact.basis, *arguments)
        after, force, support, iterations, _, _, pressure, gap, status = result
        z = after[8]
        before = replace(c.no_history(), u=state[2], displacement=state[3], angle=state[9])
        m = c.mortar(after[0], self.contact.basis, z, before)
        traction = z - pressure[:, None] * m.normals
        slip = m.moved - np.sum(m.moved * m.normals, axis=1)[:, None] * m.normals
        if c.friction > 0.0:
            slip = self._part_after_closing(old, state, before, slip, m.cover)[:, None] * slip
        self.friction_work -= float(np.sum(traction * slip))
        return after[0], support, force, iterations[-1], 0.0, (pressure, traction, gap, status), after

    def _part_after_closing(
        self, old: _Level, state: _State, before: History, slip: FloatArray, cover: FloatArray
    ) -> FloatArray:
        """Part of a node's motion that is slip: one that was open slides freely over friction times its gap."""
        assert self.contact is not None
        c, z = self.contact.contact, state[8]
        self._place(old.obstacle, old.angle)
        m = c.mortar(old.u, self.contact.basis, z, before)
        touched = (np.sum(z * m.normals, axis=1) > 0.0) | (m.gap <= 1e-12)
        free = np.where(touched, 0.0, c.friction * m.gap)
        covered = np.where(cover > 0.0, cover, 1.0)
        length = np.linalg.norm(slip, axis=1) / covered
        return np.where(length > free, 1.0 - free / np.where(length > 0.0, length, 1.0), 0.0)


def _work(old: _Level, new: _Level, force: str) -> float:
    """Work of a force over a step by the trapezoidal rule."""
    return float((getattr(old, force) + getattr(new, force)) @ (new.u - old.u)) / 2


def run_newmark(
    model: Discretisation,
    dt: ArrayLike,
    num_steps: int | None = None,
    *,
    scheme: NewmarkScheme | None = None,
    u0: ArrayLike | None = None,
    v0: ArrayLike | None = None,
    fixed_dofs: ArrayLike = (),
    motion: tuple[ArrayLike, ArrayLike, ArrayLike] | None = None,
    loads: FloatArray | Sequence[Load] | None = None,
    damping: tuple[float, float] = (0.0, 0.0),
    lumping: str = "consistent",
    contact: ImplicitContact | None = None,
    redistribute: bool = True,
    tolerance: float = 1e-13,
    max_iterations: int = 60,
    plastic: Any = None,
) -> NewmarkResult:
    """Implicit dynamics of a model by Newmark's method or generalised-alpha; see the equations of this module.

    Energies: "contact" is that of penalty springs, "friction" the sum of end traction times slip of the steps,
    "damping" and "external" the trapezoidal rule over the steps (external: loads, supports, and the obstacle's force
    on the slave times its motion), "plastic" what the work of the internal forces of a `PlasticBody`, by the same
    rule, leaves beside the stored energy.

    Args:
        model: the bodies.
        dt: time step; or all steps, shape (num_steps) [T].
        num_steps: number of steps; None where `dt` has all steps.
        scheme: parameters; None for the trapezoidal rule.
        u0: initial displacements, shape (num_dofs); None for zero [L].
        v0: initial velocities, shape (num_dofs); None for zero [L/T].
        fixed_dofs: prescribed degrees of freedom, shape (num_fixed).
        motion: their displacements [L], velocities [L/T] and accelerations [L/T^2] at the time levels, shape
            (num_levels, num_fixed) or (num_levels, 1) each; None: they rest at u0.
        loads: an array, shape (num_dofs); or a list of vectors and of pairs (vector, amplitude over time) [F].
        damping: Rayleigh damping, factors of the mass [1/T] and of the tangent stiffness, of a `PlasticBody` the
            elastic one in small strain [T].
        lumping: "consistent", or how the mass is lumped, as in `element_lumped_mass`.
        contact: contact; None for none.
        redistribute: whether the nodes of contact surfaces pass on their mass, cell by cell, to the cell's nodes off
            these surfaces.
        tolerance: bound on the relative residual of Newton's method [1].
        max_iterations: bound on its iterations per step.
        plastic: compiled part of a `PlasticBody` on this model, whose forces replace the elastic ones.

    Returns:
        States, energies and contact history of all time levels.

    Raises:
        ValueError: data that do not fit.
        RuntimeError: Newton's method does not converge.
    """
    steps = vector(dt)
    if num_steps is not None:
        if steps.size not in (1, num_steps):
            raise ValueError(f"dt has {steps.size} steps, but num_steps is {num_steps}")
        steps = np.broadcast_to(steps, (num_steps,)).copy()
    if not np.all(steps > 0):
        raise ValueError("time steps must be positive")
    times = np.cumsum(np.concatenate([[0.0], steps]))
    scheme = NewmarkScheme() if scheme is None else scheme
    run = _Run(
        model, times, scheme, fixed_dofs, motion, loads, damping, lumping, contact, redistribute, tolerance,
        max_iterations, plastic,
    )  # fmt: skip
    zero = np.zeros(model.num_dofs)
    obstacle = None if contact is None else contact.contact.obstacle
    place = None if obstacle is None else (obstacle.displacement, obstacle.angle)
    try:
        return _levels(run, zero if u0 is None else vector(u0), zero if v0 is None else vector(v0))
    finally:
        if obstacle is not None and place is not None:
            obstacle.displacement, obstacle.angle = place


def _levels(run: _Run, u0: FloatArray, v0: FloatArray) -> NewmarkResult:
    """All time levels of a run."""
    model, plastic, times = run.model, run.plastic, run.times
    level, state = run.start(u0, v0)
    levels, iterations = [level], []
    works = {name: [0.0] for name in ("internal", "friction", "damping", "external")}
    stored: list[float] = []
    strains: list[FloatArray] = []

    def record(level: _Level) -> None:
        if plastic is None:
            stored.append(model.energy(level.u))
            return
        trial = plastic.evaluate(level.u, False)
        stored.append(trial.energy + model._model.springs_energy(level.u))
        plastic.commit(trial)
        strains.append(np.array(plastic.history[1]))

    record(level)
    for number in range(1, len(times)):
        old = level
        level, state, count = run.step(number, old, state)
        levels.append(level)
        iterations.append(count)
        record(level)
        works["friction"].append(run.friction_work)
        works["internal"].append(works["internal"][-1] + _work(old, level, "internal"))
        works["damping"].append(works["damping"][-1] + _work(old, level, "damping"))
        outside = _work(old, level, "load") + _work(old, level, "support")
        if run.body is None:
            outside += float((old.total + level.total) @ (level.obstacle - old.obstacle)) / 2
            turned = angle_of(matrix_of(level.angle) @ matrix_of(old.angle).T)
            outside -= float((old.torque + level.torque) @ turned) / 2
        works["external"].append(works["external"][-1] + outside)
    energies = {
        "kinetic": np.array([x.v @ run.bodies.inertia_force(x.v) / 2 for x in levels]),
        "internal": np.array(stored),
        "contact": np.array([x.springs for x in levels]),
        **{name: np.array(works[name]) for name in ("friction", "damping", "external")},
        "plastic": np.zeros(len(levels)) if plastic is None else np.array(works["internal"]) - np.array(stored),
    }
    if run.body is not None:
        energies["kinetic"] += [x.body.kinetic for x in levels if x.body is not None]
        energies["external"] += [x.body.work for x in levels if x.body is not None]
    energies["total"] = sum(values for name, values in energies.items() if name != "external") - energies["external"]
    history = None
    if run.contact is not None:
        rows = [np.array(values) for values in zip(*(x.points for x in levels if x.points is not None))]
        total, force = (np.array([getattr(x, name) for x in levels]) for name in ("total", "contact_force"))
        history = NewmarkContactHistory(total, force, *rows)
    u, v, a, support = (np.array([getattr(x, name) for x in levels]) for name in ("u", "v", "a", "support"))
    result = NewmarkResult(times, u, v, a, support, energies, iterations, history)
    result.bodies = [x.body for x in levels if x.body is not None]
    if plastic is not None:
        result.plastic_strain = np.array(strains)
    return result
