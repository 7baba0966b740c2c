# SPDX-License-Identifier: MIT
"""Central differences as docs/explicit/scheme.md states them: the loop, its histories and its stable step."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias, Union

import numpy as np

from . import _reference
from .array_types import ArrayLike, FloatArray, IntArray, TimeValues, floats, integers, vector
from .contact import Obstacle, RigidCylinder, RigidPlane, RigidSphere, _obstacle
from .discretisation import Discretisation

# A vector, or a pair (vector, amplitude over time).
Load: TypeAlias = Union[ArrayLike, tuple[ArrayLike, TimeValues]]

ENERGIES = (
    "kinetic",
    "internal",
    "contact",
    "friction",
    "impact",
    "damping",
    "viscosity",
    "plastic",
    "external",
    "total",
    "drift",
)


class RigidBall:
    """A rigid ball, in the plane a disc, that contact and a constant force move; the master of one `NodalPenalty`.

    Args:
        center: centre at the start, shape (gdim) [L].
        radius: radius [L].
        mass: mass [M].
        inertia: moment of inertia about the centre [M L^2].
        velocity: velocity at the start, shape (gdim) [L/T].
        spin: angular velocity at the start, shape (3) [1/T].
        force: external force, shape (gdim) [F].
    """

    def __init__(
        self,
        center: ArrayLike,
        radius: float,
        mass: float,
        inertia: float,
        velocity: ArrayLike = (0.0, 0.0, 0.0),
        spin: ArrayLike = (0.0, 0.0, 0.0),
        force: ArrayLike = (0.0, 0.0, 0.0),
    ) -> None:
        self.center, self.radius, self.mass, self.inertia = vector(center), float(radius), float(mass), float(inertia)
        self.velocity, self.spin, self.force = vector(velocity), vector(spin), vector(force)

    def surface(self, gdim: int) -> RigidSphere | RigidCylinder:
        """Its surface at the start.

        Args:
            gdim: dimension of space.
        """
        return RigidSphere(self.center, self.radius) if gdim == 3 else RigidCylinder(self.center, self.radius)

    def bind(self, gdim: int) -> _reference.RigidBall:
        """The ball at the start of a run.

        Args:
            gdim: dimension of space.
        """
        start = self.velocity, self.spin, self.force
        return _reference.RigidBall(gdim, self.radius, self.center, self.mass, self.inertia, *start)


class _Nodal:
    def __init__(
        self,
        slave: ArrayLike,
        master: ArrayLike | Obstacle | RigidBall,
        friction: float,
        search_distance: float | None,
        motion: TimeValues | None,
        normals: dict[str, ArrayLike | None],
        gaps: tuple[float, float | None, float | None] = (0.0, None, None),
        angle: TimeValues | None = None,
    ) -> None:
        self.angle = angle
        self.gaps = [np.nan if value is None else float(value) for value in gaps]  # offset, clearance, adjust
        self.slave, self.master, self.friction = slave, master, float(friction)
        self.normals = normals
        self.search_distance = np.nan if search_distance is None else float(search_distance)
        self.motion = motion
        self.rigid = isinstance(master, (RigidPlane, RigidSphere, RigidCylinder, RigidBall))
        if motion is not None and isinstance(master, RigidBall):
            raise ValueError("a ball moves by forces: it takes no motion")
        if angle is not None and not isinstance(master, (RigidPlane, RigidSphere, RigidCylinder)):
            raise ValueError("an angle is for rigid obstacles")
        if motion is not None and not self.rigid:
            raise ValueError("motion is for rigid masters; a deformable one moves with its nodes")
        if self.rigid and any(given is not None for given in normals.values()):
            raise ValueError("normals are for smooth surfaces of deformable masters")

    def _bind(
        self, model: Discretisation, times: FloatArray, lumping: str, plastic: _reference.PlasticBody | None
    ) -> Any:  # an object of the compiled module
        raise NotImplementedError

    def _arguments(
        self, model: Discretisation, times: FloatArray, lumping: str
    ) -> tuple[Any, ...]:  # of the compiled classes
        d = model.points.shape[1]
        facets: IntArray = np.zeros((0, 1), dtype=np.int64)
        obstacle, motion = [], self.motion
        if isinstance(self.master, RigidBall):
            obstacle = [_obstacle(self.master.surface(d), d)]
        elif isinstance(self.master, (RigidPlane, RigidSphere, RigidCylinder)):
            obstacle = [_obstacle(self.master, d)]
            motion = self.master.displacement if motion is None else motion
        else:
            facets = integers(self.master, "master", 2)
        displacement = _time_levels(0.0 if motion is None else motion, times, d, "motion")
        mass = model.mass(lumped=True, scheme=lumping)
        slave = integers(self.slave, "slave", 2)
        normals = []
        for side, surface in (("slave", slave), ("master", facets)):
            given = self.normals.get(side)
            values = np.zeros((0, d)) if given is None else np.asarray(given, dtype=float)
            if given is not None and values.shape != (*surface.shape, d):
                raise ValueError(f"normals of the {side} have shape {values.shape}, not {(*surface.shape, d)}")
            normals.append(np.ascontiguousarray(values.reshape(-1, d)))
        return model._model, slave, facets, obstacle, self.search_distance, mass, displacement, *normals, self.gaps


class NodalPenalty(_Nodal):
    """Node-to-surface penalty contact of docs/explicit/penalty.md, for `Model.run_explicit`.

    A run raises ValueError for facets that are repeated or not on the boundary.

    Args:
        slave: points of every slave facet, shape (num_facets, nodes per facet); its vertices suffice.
        master: points of every master facet, as `slave`; or a rigid obstacle, or a ball that forces move.
        friction: Coulomb's friction coefficient [1].
        penalty: penalty; None takes half of the stiffness of the outermost layer of both bodies, within what their
            masses bear [F/L^3].
        balanced: apply the contact once in each direction, with half the stiffness.
        search_distance: masters further away are ignored, and so are masters further away than twice the motion of
            node and master against each other in a step; None takes the longest distance between corners of any
            facet [L].
        motion: displacement of a rigid master over time: shape (gdim), a function of t, or a table (times, values) with
            values of shape (n, gdim); None takes `master.displacement` at all times [L].
        angle: rotation vector of a rigid obstacle over time, likewise, shape (3); None: it does not turn [1].
        stiffness_step: step that springs without a given penalty are made for; None: each step of the run [T].
        master_normals: of a smooth master (docs/contact.md, "Smooth surfaces"): normals at the vertices of its facets,
            shape (num_facets, vertices per facet, gdim), not a number for that of the facet; None: facets as they are.
        slave_normals: likewise, for the direction of a balanced contact in which the slave is the master.
        offset: thickness of layers on both surfaces: gaps are less by it [L].
        clearance: gap at rest of the nodes that are adjusted; None: zero [L].
        adjust: nodes whose gap at rest is at most this are adjusted; None: with a clearance all that have a master,
            else none [L].

    Raises:
        ValueError: a penalty that is not positive, a motion of a deformable master, or normals of another shape.
    """

    def __init__(
        self,
        slave: ArrayLike,
        master: ArrayLike | Obstacle | RigidBall,
        friction: float = 0.0,
        penalty: float | None = None,
        balanced: bool = False,
        search_distance: float | None = None,
        motion: TimeValues | None = None,
        master_normals: ArrayLike | None = None,
        slave_normals: ArrayLike | None = None,
        stiffness_step: float | None = None,
        offset: float = 0.0,
        clearance: float | None = None,
        adjust: float | None = None,
        angle: TimeValues | None = None,
    ) -> None:
        self.stiffness_step = stiffness_step
        normals = {"slave": slave_normals, "master": master_normals}
        super().__init__(slave, master, friction, search_distance, motion, normals, (offset, clearance, adjust), angle)
        if penalty is not None and not penalty > 0:
            raise ValueError(f"penalty is {penalty!r}: it must be positive, or None")
        self.penalty, self.balanced = penalty, bool(balanced)

    def _bind(
        self, model: Discretisation, times: FloatArray, lumping: str, plastic: _reference.PlasticBody | None
    ) -> _reference.NodalPenalty:
        arguments = self._arguments(model, times, lumping)
        rules = *model._rule("stiffness"), *model._rule("mass"), lumping, [] if plastic is None else [plastic]
        ball = [self.master.bind(model.points.shape[1])] if isinstance(self.master, RigidBall) else []
        given = self.friction, float(self.penalty or 0), self.balanced
        angles: FloatArray = np.zeros((0, 3))
        if self.angle is not None:
            angles = _time_levels(self.angle, times, 3, "angle")
        return _reference.NodalPenalty(*arguments, *given, *rules, ball, float(self.stiffness_step or 0), angles)


class NodalKinematic(_Nodal):
    """Kinematic contact of docs/explicit/kinematic.md, for `Model.run_explicit`.

    Args:
        slave: points of every slave facet, shape (num_facets, nodes per facet); its vertices suffice.
        master: points of every master facet, as `slave`; or a rigid obstacle.
        friction: Coulomb's friction coefficient [1].
        sweeps: number of sweeps over the nodes in a step.
        search_distance: masters further away are ignored, as in `NodalPenalty` [L].
        motion: displacement of a rigid master over time, as in `NodalPenalty` [L].
        master_normals: of a smooth master, as in `NodalPenalty`.
        offset: as in `NodalPenalty` [L].
        clearance: as in `NodalPenalty` [L].
        adjust: as in `NodalPenalty` [L].

    Raises:
        ValueError: a motion of a deformable master, or normals of another shape.
    """

    def __init__(
        self,
        slave: ArrayLike,
        master: ArrayLike | Obstacle,
        friction: float = 0.0,
        sweeps: int = 3,
        search_distance: float | None = None,
        motion: TimeValues | None = None,
        master_normals: ArrayLike | None = None,
        offset: float = 0.0,
        clearance: float | None = None,
        adjust: float | None = None,
    ) -> None:
        gaps = offset, clearance, adjust
        super().__init__(slave, master, friction, search_distance, motion, {"master": master_normals}, gaps)
        self.sweeps = int(sweeps)

    def _bind(
        self, model: Discretisation, times: FloatArray, lumping: str, plastic: _reference.PlasticBody | None
    ) -> _reference.NodalKinematic:
        return _reference.NodalKinematic(*self._arguments(model, times, lumping), self.friction, self.sweeps)


class GeneralContact:
    """Contact of facets with each other of docs/explicit/general_contact.md, for `Model.run_explicit`.

    Args:
        facets: vertices of every facet, shape (num_facets, vertices per facet); of equally near ones the first counts.
        friction: Coulomb's friction coefficient [1].

    Raises:
        ValueError: a friction that is negative or not finite, bodies of revolution, or degree 2; when a run is made.
    """

    def __init__(self, facets: ArrayLike, friction: float = 0.0) -> None:
        self.facets, self.friction = integers(facets, "facets", 2), float(friction)

    def _bind(
        self, model: Discretisation, times: FloatArray, lumping: str, plastic: _reference.PlasticBody | None
    ) -> _reference.GeneralContact:
        if plastic is not None:
            raise ValueError("contact without pairs takes elastic bodies only")
        mass = model.mass(lumped=True, scheme=lumping)
        rules = *model._rule("stiffness"), *model._rule("mass"), lumping
        return _reference.GeneralContact(model._model, self.facets, mass, self.friction, *rules)


@dataclass
class ContactHistory:
    """Values of a contact over time; the first axis counts the states kept.

    The gap is that of t_n for the penalty method, and what remains at t_(n+1) for kinematic contact.
    """

    total: FloatArray  # force on the slave (num_states, gdim) [F]
    force: FloatArray  # nodal, on both bodies (num_states, num_dofs) [F]
    nodes: IntArray  # field nodes of the slave (num_slave_nodes)
    gap: FloatArray  # inf without master (num_states, num_slave_nodes) [L]
    status: IntArray  # 0 open, 1 stick, 2 slip or closed without friction (num_states, num_slave_nodes)
    traction: FloatArray  # friction force on a slave node (num_states, num_slave_nodes, gdim) [F]
    slip: FloatArray  # since it closed (num_states, num_slave_nodes, gdim) [L]


@dataclass
class ExplicitResult:
    """Result of `Model.run_explicit`; the first axis counts the states kept, the initial one is the first."""

    time: FloatArray  # (num_states) [T]
    u: FloatArray  # (num_states, num_dofs) [L]
    v: FloatArray  # at the time levels, (3.75) (num_states, num_dofs) [L/T]
    a: FloatArray  # (num_states, num_dofs) [L/T^2]
    v_half: FloatArray  # half a step later (num_states, num_dofs) [L/T]
    support: FloatArray  # force on prescribed dofs, zero elsewhere (num_states, num_dofs) [F]
    energies: dict[str, FloatArray]  # by the names of ENERGIES, each (num_states) [F L]; drift is relative [1]
    contacts: list[ContactHistory]  # one of each contact
    # Of a PlasticBody, as in J2History; without points otherwise.
    plastic_strain: FloatArray  # equivalent (num_states, num_points) [1]
    plastic_strain_tensor: FloatArray  # (num_states, num_points, 3, 3) [1]
    back_stress: FloatArray  # (num_states, num_points, 3, 3) [F/L^2]


def _time_levels(table: TimeValues, times: FloatArray, width: int, what: str) -> FloatArray:
    """Values at time levels, shape (len(times), width): a constant, a function of t, or (times, values), linear."""
    if callable(table):
        rows = [np.broadcast_to(floats(table(t)), (width,)) for t in times]
        return np.array(rows).reshape(len(times), width)
    if isinstance(table, tuple):
        at, values = floats(table[0]), floats(table[1])
        if at.ndim != 1 or values.shape[:1] != at.shape or np.any(np.diff(at) <= 0):
            raise ValueError(
                f"{what}: a table needs increasing times (n) and n values, found {at.shape}, {values.shape}"
            )
        columns = np.broadcast_to(values.reshape(len(at), -1), (len(at), width))
        result = [np.interp(times, at, column) for column in columns.T]
        return np.ascontiguousarray(np.array(result).reshape(width, len(times)).T)
    return np.broadcast_to(floats(table), (len(times), width)).copy()


def _loads(
    loads: FloatArray | Sequence[Load] | None, times: FloatArray, num_dofs: int
) -> tuple[FloatArray, FloatArray]:
    """Loads, shape (num_loads, num_dofs), and their amplitudes, shape (len(times), num_loads)."""
    if loads is None:
        loads = []
    elif isinstance(loads, np.ndarray) and loads.ndim == 1:
        loads = [loads]
    pairs = [load if isinstance(load, tuple) else (load, 1.0) for load in loads]
    vectors = np.array([vector(load) for load, _ in pairs]).reshape(len(pairs), num_dofs)
    amplitudes = [_time_levels(amplitude, times, 1, "load")[:, 0] for _, amplitude in pairs]
    return vectors, np.ascontiguousarray(np.array(amplitudes).reshape(len(pairs), len(times)).T)


def _is_classical(scheme: str) -> bool:
    if scheme not in ("half_step", "classical"):
        raise ValueError(f"unknown scheme {scheme!r}: use 'half_step' or 'classical'")
    return scheme == "classical"


def run_explicit(
    model: Discretisation,
    dt: ArrayLike,
    num_steps: int | None = None,
    *,
    u0: ArrayLike | None = None,
    v0: ArrayLike | None = None,
    fixed_dofs: ArrayLike = (),
    values: TimeValues = 0.0,
    loads: FloatArray | Sequence[Load] | None = None,
    alpha: float = 0.0,
    beta: float = 0.0,
    scheme: str = "half_step",
    viscosity: tuple[float, float] | None = None,
    contacts: Sequence[_Nodal | GeneralContact] = (),
    lumping: str = "auto",
    every: int = 1,
    plastic: _reference.PlasticBody | None = None,
) -> ExplicitResult:
    """Explicit dynamics of a model by central differences, docs/explicit/scheme.md.

    Values over time are a constant, a function of t, or a table (times, values) with linear interpolation.

    Args:
        model: the bodies.
        dt: time step; or all steps, shape (num_steps) [T].
        num_steps: number of steps; None where `dt` has all steps.
        u0: initial displacements, shape (num_dofs); None for zero [L].
        v0: initial velocities, shape (num_dofs); None for zero [L/T].
        fixed_dofs: prescribed degrees of freedom, shape (num_fixed).
        values: their displacements over time: one number or shape (num_fixed). The value one step beyond the end
            gives the last state its velocity [L].
        loads: an array, shape (num_dofs); or a list of vectors and of pairs (vector, amplitude over time) [F].
        alpha: Rayleigh damping, factor of the lumped mass [1/T].
        beta: Rayleigh damping, factor of the stiffness [T].
        scheme: "half_step", or "classical" (equal steps, beta 0).
        viscosity: linear and quadratic bulk viscosity (b1, b2); None for none [1].
        contacts: contacts, `NodalPenalty`, `NodalKinematic` and `GeneralContact`.
        lumping: how the mass is lumped, as in `element_lumped_mass`.
        every: keep each state whose number is a multiple of this; the last one is always kept.
        plastic: compiled part of a `PlasticBody` on this model, whose forces replace the elastic ones.

    Returns:
        States, energies and contact histories.

    Raises:
        ValueError: data that do not fit.
        RuntimeError: the run overflows.
    """
    steps = vector(dt)
    if num_steps is not None:
        if steps.size not in (1, num_steps):
            raise ValueError(f"dt has {steps.size} steps, but num_steps is {num_steps}")
        steps = np.broadcast_to(steps, (num_steps,)).copy()
    classical = _is_classical(scheme)
    # cumsum adds in the order of the compiled loop, so that both have the same round-off.
    times = np.cumsum(np.concatenate([[0.0], steps, steps[-1:]]))
    fixed = np.asarray(fixed_dofs, dtype=np.int64).reshape(-1)
    vectors, amplitudes = _loads(loads, times[:-1], model.num_dofs)
    zero = np.zeros(model.num_dofs)
    b1, b2 = (0.0, 0.0) if viscosity is None else viscosity
    bound = [contact._bind(model, times, lumping, plastic) for contact in contacts]
    result = _reference.run_explicit(
        model._model,
        *model._strain_rule(),
        *model._rule("mass"),
        lumping,
        steps,
        zero if u0 is None else vector(u0),
        zero if v0 is None else vector(v0),
        fixed,
        _time_levels(values, times, fixed.size, "values"),
        vectors,
        amplitudes,
        float(alpha),
        float(beta),
        classical,
        float(b1),
        float(b2),
        int(every),
        bound,
        [] if plastic is None else [plastic],
    )
    energies = dict(zip(ENERGIES, result.energies.T.copy()))
    histories = []
    for contact, raw in zip(bound, result.contacts):
        shape = raw.gap.shape + (model.points.shape[1],)
        nodes = np.array(contact.nodes, dtype=np.int64)
        traction, slip = raw.traction.reshape(shape), raw.slip.reshape(shape)
        histories.append(ContactHistory(raw.total, raw.force, nodes, raw.gap, raw.status, traction, slip))
    r = result
    tensors = (rows.reshape(len(r.time), -1, 3, 3) for rows in (r.plastic, r.back_stress))
    points = r.equivalent.reshape(len(r.time), -1)
    return ExplicitResult(r.time, r.u, r.v, r.a, r.half, r.support, energies, histories, points, *tensors)


def stable_step(
    model: Discretisation,
    method: str = "element",
    *,
    alpha: float = 0.0,
    beta: float = 0.0,
    scheme: str = "half_step",
    fixed_dofs: ArrayLike = (),
    contacts: Sequence[_Nodal] = (),
    u: ArrayLike | None = None,
    lumping: str = "auto",
) -> float:
    """Longest stable step of `run_explicit` for a model.

    Args:
        model: the bodies.
        method: "length" (edge over wave speed), "element" (a bound by the cells' frequencies) or "eigenvalue".
        alpha: Rayleigh damping, factor of the lumped mass [1/T].
        beta: Rayleigh damping, factor of the stiffness [T].
        scheme: "half_step" or "classical".
        fixed_dofs: degrees of freedom without displacement, which "eigenvalue" respects, shape (num_fixed).
        contacts: contacts; those with a penalty of their own shorten the step.
        u: displacements at which the contacts are evaluated, shape (num_dofs); None for zero [L].
        lumping: how the mass is lumped, as in `element_lumped_mass`.

    Returns:
        Stable step [T].

    Raises:
        ValueError: an unknown method or scheme.
    """
    u = np.zeros(model.num_dofs) if u is None else vector(u)
    springs = [contact for contact in contacts if isinstance(contact, NodalPenalty)]
    bound = [contact._bind(model, np.zeros(2), lumping, None) for contact in springs]
    if method == "length":
        frequency = 2 / _reference.passage(model._model)
    elif method == "element":
        rules = *model._rule("stiffness"), *model._rule("mass")
        frequency = _reference.cell_frequency(model._model, *rules, lumping)
    elif method == "eigenvalue":
        K, mass = model.stiffness(), model.mass(lumped=True, scheme=lumping)
        fixed = np.asarray(fixed_dofs, dtype=np.int64).reshape(-1)
        springs = [model._model.springs] + [contact.springs(u) for contact in bound]
        frequency = _reference.highest_frequency(K.indptr, K.indices, K.data, springs, mass, fixed)
    else:
        raise ValueError(f"unknown method {method!r}: use 'length', 'element' or 'eigenvalue'")
    if method != "eigenvalue":
        frequency = np.sqrt(frequency**2 + sum(contact.added_frequency(u) for contact in bound))
    damped = 0.0 if _is_classical(scheme) else (alpha / frequency + beta * frequency) / 2
    return 2 / frequency * (np.sqrt(1 + damped**2) - damped)
