# SPDX-License-Identifier: MIT
"""Rigid bodies that move by the forces of contacts and loads; docs/rigid_bodies.md."""

from __future__ import annotations

import weakref
from collections.abc import Sequence
from typing import Any

import numpy as np
from mpi4py import MPI

from .. import _cpp
from ..amplitude import Amplitude, is_in_time
from ..common.arguments import number
from ..common.fixed import read_only
from ..common.types import ArrayLike, FloatArray
from .rigid import RigidCylinder, RigidSphere, _Rigid, _vector, rotation_vector

TRANSLATIONS = ("x", "y", "z")
ROTATIONS = ("rx", "ry", "rz")
PLANE = ("z", "rx", "ry")  # what does not move in the plane
AXIAL = ("x", "z", *ROTATIONS)  # what does not move in axisymmetric problems: r is x, the axis y


class StaticBody:
    """A rigid body in a static problem: what it reads, and results.

    Args:
        body: the body.
        problem: the problem.
        contacts: numbers of its contacts.
        fixed: which components are fixed, translations before rotations, (6).

    Attributes:
        contacts: as given.
        fixed: as given.
        force: external force at the present part of a load step, (3) [F].
        torque: external torque about the centre, likewise [F L].
        reached: force of the last solve, (3) [F].
        reached_torque: torque of the last solve, (3) [F L].
    """

    def __init__(self, body: RigidBody, problem: Any, contacts: list[int], fixed: list[bool]) -> None:
        self._centre, self._problem = body.centre, weakref.ref(problem)
        self.contacts, self.fixed = contacts, fixed
        assert body._given_force is not None and body._given_torque is not None  # they were checked
        self.force: Any = body._given_force
        self.torque: Any = body._given_torque
        self.reached: Any = np.zeros(3)
        self.reached_torque: Any = np.zeros(3)

    def _contacts(self) -> list[Any]:
        problem: Any = self._problem()
        return [problem.contact[k] for k in self.contacts]

    @property
    def position(self) -> FloatArray:
        """Centre, (3) [L]."""
        return self._centre + np.array(self._contacts()[0].displacement)

    @property
    def rotation(self) -> FloatArray:
        """Rotation since the start, a matrix row by row, (9) [1]."""
        turned = self._contacts()[0]._cpp_object.rotation
        return np.eye(3).ravel() if turned is None else np.array(turned)

    @property
    def contact_force(self) -> FloatArray:
        """Force of all contacts on the body, (3) [F]."""
        total: FloatArray = np.zeros(3)
        for contact in self._contacts():
            if contact.force is not None:  # there was a solve
                total[: len(contact.force)] -= contact.force
        return total

    @property
    def contact_torque(self) -> FloatArray:
        """Torque of all contacts about the centre, (3) [F L]."""
        total: FloatArray = np.zeros(3)
        for contact in self._contacts():
            if contact.force is None:
                continue
            about_origin = np.array([0.0, 0.0, contact.moment[0]]) if len(contact.force) == 2 else contact.moment
            total -= about_origin
        return total - np.cross(self.position, self.contact_force)

    def velocity(self, dt: float) -> FloatArray:
        """Zero, as spin, momentum and angular momentum, (3) [L/T].

        Args:
            dt: not used.
        """
        return np.zeros(3)

    spin = momentum = angular_momentum = velocity

    def kinetic_energy(self, dt: float) -> float:
        """Zero [F L].

        Args:
            dt: not used.
        """
        return 0.0


class RigidBody(_Rigid):
    """A rigid body that contact forces and loads move: the master of one or several pairs. ExplicitProblem and
    NewmarkProblem have its motion; StaticProblem moves it until the forces on it cancel. Explicit problems take
    Penalty, the others Lagrange, too. docs/rigid_bodies.md has the equations.

    Its results, at the present time of the problem that was made with it last, have three components in the plane too.

    Args:
        surface: its surface where it is at the start: RigidPlane, RigidSphere, RigidCylinder or RigidSurface.
        mass: mass; None: in static problems, or if all translations are `fixed`. Where the mesh is a part of the
            bodies between planes of symmetry, the same part of it [M].
        inertia: about the centre: a number (of the rotation in the plane, or about all axes in space), the moments
            about x, y and z, (3), or the tensor, (3, 3); None: all rotations are fixed. Static problems rotate a body
            that has one, and do not read its value [M L^2].
        centre: centre of mass, (2) or (3); None: the centre of a ball or of a cylinder [L].
        velocity: velocity of the centre at the start, (2) or (3) [L/T].
        spin: angular velocity at the start, (3), in the plane a number [1/T].
        force: external force at the centre, beside the contacts': (2) or (3), or a function of time with three
            components, or a pair (times, values); None: none. Weight is mass times gravity [F].
        torque: external torque about the centre, likewise; in the plane a number will do [F L].
        fixed: components that keep their velocity of the start, as a support or a drive holds them: some of x, y, z,
            rx, ry, rz (rotations about the axes through the centre).
        meets: other RigidBody objects, and rigid obstacles that do not move, that it touches in explicit problems: with
            the surface of a RigidSphere, in the plane of a RigidCylinder, or with the points of a RigidSurface of
            facets. Of two bodies one meets the other: one that is the master of a pair, or is met by such a body.
        friction: coefficient of friction with what it meets [1].

    Attributes:
        surface: as given.
        mass: as given [M].
        inertia: tensor at the start, (3, 3); None: all rotations are fixed [M L^2].
        centre: centre of mass at the start, (3) [L].
        fixed: as given.
        meets: as given.
        friction: as given [1].

    Raises:
        TypeError: an argument is of the wrong type.
        ValueError: a mass or inertia that is not positive, or is missing where the body moves; a surface that moves as
            prescribed; an unknown component.
    """

    given_once = ("surface", "velocity", "spin", "force", "torque")

    surface: _Rigid
    mass: float | None
    inertia: FloatArray | None
    centre: FloatArray
    fixed: tuple[str, ...]
    meets: tuple[_Rigid, ...]
    friction: float

    def __init__(
        self,
        surface: _Rigid,
        mass: float | None = None,
        inertia: ArrayLike | None = None,
        centre: ArrayLike | None = None,
        velocity: ArrayLike = (0.0, 0.0, 0.0),
        spin: ArrayLike = (0.0, 0.0, 0.0),
        force: Any = None,
        torque: Any = None,
        fixed: Sequence[str] = (),
        meets: _Rigid | Sequence[_Rigid] = (),
        friction: float = 0.0,
    ) -> None:
        if not isinstance(surface, _Rigid) or isinstance(surface, RigidBody):
            raise TypeError(
                "surface must be a RigidPlane, RigidSphere, RigidCylinder or RigidSurface, found "
                f"{type(surface).__name__}"
            )
        if surface.motion is not None or surface.angle is not None:
            what = "a motion" if surface.motion is not None else "an angle"
            raise ValueError(f"the surface of a rigid body has {what}: it moves by forces, not as a function of time")
        super().__init__(surface._kind, surface._point, surface._direction, surface._radius)
        self._checksum, self._displacement = surface._checksum, surface.displacement
        self.surface, self.fixed = surface, _components(fixed)
        self.mass = None if mass is None else number("mass", mass, 0.0, " [M]")
        self.inertia = _inertia(inertia)
        if centre is None:
            if not isinstance(surface, (RigidSphere, RigidCylinder)):
                raise ValueError(
                    f"a rigid body with the surface of a {type(surface).__name__} needs its centre of mass"
                )
            centre = surface._point + surface.displacement
        self.centre = _vector("centre", centre)
        self._start_velocity, self._start_spin = _vector("velocity", velocity), rotation_vector("spin", spin)
        #: as a vector, which static problems read; None: a function of time
        self._given_force = (
            None if is_in_time(force) else np.array(_vector("force", (0, 0, 0) if force is None else force))
        )
        self._given_torque = (
            None if is_in_time(torque) else np.array(rotation_vector("torque", (0, 0, 0) if torque is None else torque))
        )
        self._force, self._torque = _load("force", force), _load("torque", torque)
        if self.inertia is None and np.any(self._start_spin) and not set(ROTATIONS) <= set(self.fixed):
            raise ValueError(
                "a rigid body with spin needs its inertia, or the spin must be fixed: fixed=('rx', 'ry', 'rz')"
            )
        some = [k for k, name in enumerate(ROTATIONS) if name in self.fixed]
        if 0 < len(some) < 3 and np.any(self._start_spin[some]):
            raise ValueError(
                "a spin that is fixed in some components, not in all, must be zero there: a body cannot turn freely "
                "about one axis while it is driven about another"
            )
        self.meets, self.friction = _met(meets), number("friction", friction)
        if self.friction < 0.0:
            raise ValueError(f"friction is {self.friction}: a coefficient of friction is zero or positive")
        self._met_by: list[weakref.ref[RigidBody]] = []
        for other in self.met_bodies():
            other._met_by.append(weakref.ref(self))
        self._body: _cpp.problems.RigidBodyInTime | _cpp.problems.ImplicitBodyInTime | StaticBody | None = None
        self._problem: Any = None  # weak reference to the problem that moves it

    def _made_of(self) -> str:
        mass = "" if self.mass is None else f", mass={self.mass:g}"
        fixed = f", fixed={self.fixed}" if self.fixed else ""
        return f"{self.surface!r}{mass}, centre={self.centre.tolist()}{fixed}"

    def shape_description(self) -> str:
        inertia = None if self.inertia is None else self.inertia.tolist()
        start = [self._start_velocity.tolist(), self._start_spin.tolist()]
        met = f" meets {[other.shape_description() for other in self.meets]} {self.friction!r}" if self.meets else ""
        return (
            f"body of {super().shape_description()} {self.mass!r} {inertia!r} {self.centre.tolist()!r} {start!r}{met}"
        )

    def same_on_all_ranks(self) -> list[Any]:
        """Surface, and what moves it."""
        start = [self._start_velocity, self._start_spin, self._force is None, self._torque is None]
        return [self.surface, self.mass, self.inertia, self.centre, *start, self.fixed, *self.meets, self.friction]

    def orientation_hint(self) -> str:
        return self.surface.orientation_hint()

    @property
    def displacement(self) -> FloatArray:
        """Displacement of the surface at the start, (3) [L]."""
        return self._displacement

    @displacement.setter
    def displacement(self, value: ArrayLike) -> None:
        raise AttributeError(
            "displacement of a RigidBody cannot be changed: it moves by forces; displace its surface before it is made"
        )

    @property
    def angle(self) -> Any:
        """None: it turns by torques."""
        return None

    @angle.setter
    def angle(self, value: Any) -> None:
        raise AttributeError("angle of a RigidBody cannot be changed: it turns by torques; give `fixed` and a spin")

    @property
    def pivot(self) -> FloatArray:
        """Its centre: a body turns about it, (3) [L]."""
        return self.centre

    @pivot.setter
    def pivot(self, value: Any) -> None:
        raise AttributeError("pivot of a RigidBody cannot be changed: it turns about its centre")

    @property
    def motion(self) -> Any:
        """None: it moves by forces."""
        return None

    @motion.setter
    def motion(self, value: Any) -> None:
        raise AttributeError(
            "motion of a RigidBody cannot be changed: it moves by forces, not as a function of time; give `fixed` and "
            "a velocity"
        )

    def obstacle(self, gdim: int) -> _cpp.gap.Rigid:
        made = self.surface.obstacle(gdim)
        made.centre = [*map(float, self.centre - self._displacement)]
        return made

    def bind(self, problem: Any) -> _cpp.problems.RigidBodyInTime:
        """The body on the C++ side, one object for all contacts of a problem.

        Args:
            problem: the problem that moves it from now on.

        Returns:
            The body at the start.

        Raises:
            ValueError: the centre or a velocity lies outside the plane of the mesh, or the body can move off the axis.
        """
        if isinstance(self._body, _cpp.problems.RigidBodyInTime) and self._problem() is problem:
            return self._body
        self._body = body = _cpp.problems.RigidBodyInTime(**self._in_time(problem))
        self._problem = weakref.ref(problem)
        gdim = problem.space.mesh.geometry.dim
        for other in self.meets:
            if isinstance(other, RigidBody) and self in other.meets:
                raise ValueError("of two rigid bodies one meets the other: name the other in `meets` of one of them")
            points, areas, radius = self._touching(gdim)
            master = other.obstacle(gdim)
            master.displacement = [*map(float, other.displacement)]
            met = other.bind(problem) if isinstance(other, RigidBody) else None
            body.meet(points.ravel(), areas, radius, master, self.friction, met)
        return body

    def _touching(self, gdim: int) -> tuple[FloatArray, FloatArray, float]:
        """Points of the surface before the displacement, (n, 3), areas that belong to them, (n), and the distance of
        the surface from the points: of a ball its centre and its radius."""
        shape = self.surface
        if isinstance(shape, RigidSphere) or (isinstance(shape, RigidCylinder) and gdim == 2):
            if shape._radius > 0.0:
                return np.array([shape._point]), np.ones(1), shape._radius
        found = getattr(shape, "vertices", lambda: None)()
        if found is None:
            raise ValueError(
                f"a rigid body with the surface {shape!r} cannot meet others: one of two bodies has the surface of a "
                "ball, of a disc in the plane, or a RigidSurface of facets, and `meets` the other"
            )
        points, areas = found
        return np.pad(points, ((0, 0), (0, 3 - points.shape[1]))), areas, 0.0

    def met_bodies(self) -> list[RigidBody]:
        """Rigid bodies among what it meets, in their order."""
        return [other for other in self.meets if isinstance(other, RigidBody)]

    def met_by(self) -> list[RigidBody]:
        """Rigid bodies that were made to meet this one, and that still exist."""
        return [other for one in self._met_by if (other := one()) is not None]

    @property
    def meeting_gaps(self) -> FloatArray:
        """Smallest gap to each of what it meets, (n) [L]."""
        body = self._moving()[0]
        assert isinstance(body, _cpp.problems.RigidBodyInTime)
        return np.array(body.meeting_gaps)

    @property
    def meeting_forces(self) -> FloatArray:
        """Force on the body of each of what it meets, (n, 3) [F]."""
        body = self._moving()[0]
        assert isinstance(body, _cpp.problems.RigidBodyInTime)
        return np.array(body.meeting_forces).reshape(-1, 3)

    def bind_implicit(self, problem: Any) -> _cpp.problems.ImplicitBodyInTime:
        """The body in an implicit problem, which moves it from now on.

        Args:
            problem: the problem; its contacts are made.

        Returns:
            The body on the C++ side, at the start.

        Raises:
            ValueError: as `bind`.
        """
        self._refuse_meeting("implicit")
        contacts = [k for k, c in enumerate(problem.contact) if c.pair.rigid_body is self]
        length = float(np.linalg.norm(np.ptp(problem.space.mesh.geometry.x, axis=0)))
        length = problem.comm.allreduce(length, MPI.MAX)
        self._body = _cpp.problems.ImplicitBodyInTime(**self._in_time(problem), length=length, contacts=contacts)
        self._problem = weakref.ref(problem)
        return self._body

    def _refuse_meeting(self, kind: str) -> None:
        """Refuse contacts of rigid bodies with each other."""
        if self.meets:
            raise ValueError(f"rigid bodies meet each other in explicit problems, not in {kind} ones")

    def _in_time(self, problem: Any) -> dict[str, Any]:
        """Arguments of the body on the C++ side in a problem in time."""
        gdim = problem.space.mesh.geometry.dim
        if self.mass is None and not set(TRANSLATIONS[:gdim]) <= set(self.fixed):
            raise ValueError("a rigid body needs a mass, or its translations must be fixed: fixed=('x', 'y', 'z')")
        fixed = set(self.fixed) | self._fixed_by(problem)
        if gdim == 2:
            off = [self.centre[2], self._start_velocity[2], *self._start_spin[:2]]
            if problem.axisymmetric:
                off += [self.centre[0], self._start_velocity[0], self._start_spin[2]]
            if np.any(off):
                where = "moves along its axis" if problem.axisymmetric else "moves in its plane"
                raise ValueError(f"a rigid body of this problem {where}: centre, velocity and spin do not fit")
        return dict(
            mass=self.mass or 0.0,
            inertia=[*map(float, (np.zeros((3, 3)) if self.inertia is None else self.inertia).ravel())],
            centre=[*map(float, self.centre - self._displacement)],
            displacement=[*map(float, self._displacement)],
            velocity=[*map(float, self._start_velocity)],
            spin=[*map(float, self._start_spin)],
            fixed_velocity=[name in fixed for name in TRANSLATIONS],
            fixed_spin=[name in fixed for name in ROTATIONS],
            force=None if self._force is None else self._force.sample([0.0])[0],
            torque=None if self._torque is None else self._torque.sample([0.0])[0],
        )

    def bind_static(self, problem: Any) -> StaticBody:
        """The body in a static problem, which moves it from now on.

        Args:
            problem: the problem; its contacts are made.

        Returns:
            Its contacts, fixed components, force and torque.

        Raises:
            ValueError: it has a velocity, its surface is displaced, or a load is a function of time.
        """
        self._refuse_meeting("static")
        if np.any(self._start_velocity) or np.any(self._start_spin):
            raise ValueError("a RigidBody of a static problem has no velocity and no spin")
        if np.any(self._displacement):
            raise ValueError("make the surface of a RigidBody where it is at the start: it is displaced")
        for name, load in (("force", self._given_force), ("torque", self._given_torque)):
            if load is None:
                raise ValueError(f"the {name} on a RigidBody is a function of time: static problems take a vector")
        fixed = set(self.fixed) | self._fixed_by(problem)
        contacts = [k for k, c in enumerate(problem.contact) if c.pair.rigid_body is self]
        self._body = StaticBody(self, problem, contacts, [name in fixed for name in (*TRANSLATIONS, *ROTATIONS)])
        self._problem = weakref.ref(problem)
        return self._body

    def _fixed_by(self, problem: Any) -> set[str]:
        """Components that do not move in a problem, whatever acts on them."""
        fixed = set(ROTATIONS) if self.inertia is None else set()
        if problem.space.mesh.geometry.dim == 2:
            fixed |= set(AXIAL if problem.axisymmetric else PLANE)
        return fixed

    def turns_in(self, problem: Any) -> bool:
        """Whether a problem of implicit kind rotates it.

        Args:
            problem: a static or an implicit problem.
        """
        return not set(ROTATIONS) <= set(self.fixed) | self._fixed_by(problem) or bool(np.any(self._start_spin))

    @property
    def external_torque(self) -> FloatArray:
        """External torque about the centre, which the next solve of a static problem leads to, (3) [F L]."""
        if self._given_torque is None:
            raise ValueError("the torque on this RigidBody is a function of time")
        return self._given_torque.copy()

    @external_torque.setter
    def external_torque(self, value: ArrayLike) -> None:
        if self._given_torque is None or not isinstance(self._body, StaticBody | None):
            raise ValueError(
                "problems in time read the torque on a RigidBody when they are made: give `torque` a function of time"
            )
        self._given_torque[:] = rotation_vector("external_torque", value)

    @property
    def external_force(self) -> FloatArray:
        """External force at the centre, which the next solve of a static problem leads to, (3) [F]."""
        if self._given_force is None:
            raise ValueError("the force on this RigidBody is a function of time")
        return self._given_force.copy()

    @external_force.setter
    def external_force(self, value: ArrayLike) -> None:
        if self._given_force is None or not isinstance(self._body, StaticBody | None):
            raise ValueError(
                "problems in time read the force on a RigidBody when they are made: give `force` a function of time"
            )
        self._given_force[:] = _vector("external_force", value)

    def loads(self) -> list[Amplitude]:
        """Functions of time of force and torque, those that there are, in the order of the C++ side."""
        return [load for load in (self._force, self._torque) if load is not None]

    # --- results ---------------------------------------------------------------------------------------------------

    def _moving(self) -> tuple[_cpp.problems.RigidBodyInTime | _cpp.problems.ImplicitBodyInTime | StaticBody, float]:
        """The body and the last step of its problem."""
        problem = None if self._problem is None else self._problem()
        if self._body is None or problem is None:
            raise RuntimeError("the rigid body belongs to no problem: it moves in one that is kept")
        made = getattr(problem, "_cpp_object", None)
        if not isinstance(self._body, _cpp.problems.RigidBodyInTime) or made is None:
            return self._body, 0.0
        return self._body, float(made.integrator.last_step)

    @property
    def position(self) -> FloatArray:
        """Centre of mass, (3) [L]."""
        return np.array(self._moving()[0].position)

    @property
    def rotation(self) -> FloatArray:
        """Rotation since the start, an orthogonal matrix, (3, 3) [1]."""
        return np.array(self._moving()[0].rotation).reshape(3, 3)

    @property
    def velocity(self) -> FloatArray:
        """Velocity of the centre, (3) [L/T]."""
        body, dt = self._moving()
        return np.array(body.velocity(dt))

    @velocity.setter
    def velocity(self, value: ArrayLike) -> None:
        raise ValueError("the velocity of a RigidBody is a result: give that of the start when it is made")

    @property
    def spin(self) -> FloatArray:
        """Angular velocity, (3) [1/T]."""
        body, dt = self._moving()
        return np.array(body.spin(dt))

    @property
    def momentum(self) -> FloatArray:
        """Momentum, (3) [M L/T]."""
        body, dt = self._moving()
        return np.array(body.momentum(dt))

    @property
    def angular_momentum(self) -> FloatArray:
        """Angular momentum about the centre, (3) [M L^2/T]."""
        body, dt = self._moving()
        return np.array(body.angular_momentum(dt))

    @property
    def kinetic_energy(self) -> float:
        """Kinetic energy; without that of a rotation whose components are all fixed [F L]."""
        body, dt = self._moving()
        return float(body.kinetic_energy(dt))

    @property
    def force(self) -> FloatArray:
        """Force of all contacts on the body, (3) [F]."""
        return np.array(self._moving()[0].contact_force)

    @property
    def torque(self) -> FloatArray:
        """Torque of all contacts about the centre, (3) [F L]."""
        return np.array(self._moving()[0].contact_torque)


def _met(given: Any) -> tuple[_Rigid, ...]:
    """Checked bodies and obstacles that a body meets."""
    met = (given,) if isinstance(given, _Rigid) else tuple(given)
    for other in met:
        if not isinstance(other, _Rigid):
            raise TypeError(f"meets has {other!r:.60}: give rigid bodies and rigid obstacles")
        if other.motion is not None or other.angle is not None:
            raise ValueError(
                "meets has an obstacle with a motion or an angle: give a RigidBody whose components are fixed, with a "
                "velocity and a spin"
            )
    return met


def _components(fixed: Any) -> tuple[str, ...]:
    """Checked names of components."""
    names = (fixed,) if isinstance(fixed, str) else tuple(fixed)
    for name in names:
        if name not in (*TRANSLATIONS, *ROTATIONS):
            raise ValueError(f"fixed has {name!r}: the components are {', '.join((*TRANSLATIONS, *ROTATIONS))}")
    return names


def _inertia(value: Any) -> FloatArray | None:
    """Checked tensor of inertia, (3, 3)."""
    if value is None:
        return None
    try:
        given = np.array(value, dtype=float)
    except (TypeError, ValueError):
        raise TypeError(f"inertia must be a number, three or 3 x 3 numbers, found {value!r:.60}") from None
    if given.shape not in ((), (3,), (3, 3)):
        raise ValueError(f"inertia is a number, three moments or a 3 x 3 tensor, found shape {given.shape}")
    tensor: FloatArray = given if given.ndim == 2 else np.eye(3) * given
    if not np.all(np.isfinite(tensor)) or not np.allclose(tensor, tensor.T, rtol=1e-12, atol=0.0):
        raise ValueError(f"inertia is {tensor.tolist()}: give finite numbers, a symmetric tensor")
    if np.linalg.eigvalsh(tensor)[0] <= 0.0:
        raise ValueError(f"inertia is {given.tolist()}: its principal moments must be positive")
    checked: FloatArray = read_only(0.5 * (tensor + tensor.T))
    return checked


def _load(name: str, value: Any) -> Amplitude | None:
    """A load as a function of time with three components."""
    if value is None:
        return None
    if is_in_time(value):
        return Amplitude(value, f"{name} on a rigid body", size=3)
    vector = rotation_vector(name, value) if name == "torque" else _vector(name, value)
    return Amplitude(lambda t: vector, f"{name} on a rigid body", size=3)
