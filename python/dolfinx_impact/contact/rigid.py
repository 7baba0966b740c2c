# SPDX-License-Identifier: MIT
"""Rigid obstacles as masters."""

from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from .. import _cpp
from ..amplitude import Amplitude, is_in_time
from ..common.arguments import number
from ..common.fixed import Fixed, read_only
from ..common.types import ArrayLike, FloatArray


def _vector(name: str, value: Any) -> FloatArray:
    """A checked vector of two or three components, with a third component of zero in the plane, (3)."""
    try:
        array = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        raise TypeError(f"{name} must be two or three numbers, found {value!r}") from None
    if array.shape not in ((2,), (3,)):
        raise ValueError(f"{name} must have two or three components, found shape {array.shape}")
    if not np.all(np.isfinite(array)):
        raise ValueError(f"{name} is {array.tolist()}: give finite numbers")
    padded: FloatArray = read_only(np.pad(array, (0, 3 - len(array))))
    return padded


def _unit(name: str, value: Any) -> FloatArray:
    """A checked direction of length one, (3)."""
    vector = _vector(name, value)
    length = np.linalg.norm(vector)
    if length == 0.0:
        raise ValueError(f"{name} is zero: it has no direction")
    return vector / length


def rotation_vector(name: str, value: Any) -> FloatArray:
    """A checked vector of rotation; a number is one about z, (3)."""
    return _vector(name, (0.0, 0.0, number(name, value)) if np.ndim(value) == 0 else value)


class _Rigid(Fixed):
    """Base of rigid obstacles: a displacement that may be changed between solves; load steps divide it equally.
    Problems in time read displacement and motion when they are made, and refuse to go on with others.

    Attributes:
        motion: of problems in time, added to the displacement: a function of time with three components, a pair
            (times, values), or None [L].
        velocity: of rolling problems, (3): that of its surface, which stays where it is, as of a rigid rail that moves
            along itself [L/T].
        angle: rotation about `pivot`, before the displacement: a rotation vector, (3), in the plane a number, of which
            static problems take the present value; in problems in time a function of time, or a pair (times, values),
            too. It turns the obstacle by the length of the vector about its direction. None: it does not turn [1].
        pivot: point that it turns about, before the displacement, (3); None: a point of the plane, or the centre [L].
    """

    given_once: tuple[str, ...] = ()  # arguments whose names have the present values, which change in a run
    _checksum = ""  # of a shape that is not given by a few numbers

    def __init__(self, kind: str, point: FloatArray, direction: FloatArray, radius: float) -> None:
        self._kind, self._point, self._direction, self._radius = kind, point, direction, radius
        self._displacement = self._velocity = _vector("displacement", (0.0, 0.0, 0.0))
        self._motion: Any = None
        self._angle: Any = None
        self._pivot: FloatArray | None = None
        self._shared: dict[tuple[int, bool, tuple[float, ...]], _cpp.gap.Rigid] = {}

    def __repr__(self) -> str:
        moved = f", displacement={self._displacement.tolist()}" if np.any(self._displacement) else ""
        driven = ", motion=..." if self.motion is not None else ""
        turned = ", angle=..." if self.angle is not None else ""
        return f"{type(self).__name__}({self._made_of()}{moved}{driven}{turned})"

    def _made_of(self) -> str:
        """Arguments as `repr` shows them."""
        return f"center={self._point.tolist()}, radius={self._radius}"

    def description(self) -> str:
        """Shape, position and whether it moves, by which checkpoints of problems in time recognise the obstacle."""
        motion = "with" if self.motion is not None else "without"
        turned = "" if self.angle is None else f", turned as a function of time {is_in_time(self.angle)}"
        return f"{self.shape_description()} at {self.displacement.tolist()!r} {motion} motion{turned}"

    def shape_description(self) -> str:
        """Shape, by which checkpoints of static problems recognise the obstacle."""
        numbers: list[Any] = [np.asarray(v).tolist() for v in (self._point, self._direction, self._radius)]
        numbers += [self._checksum] if self._checksum else []
        numbers += [] if self.angle is None else [self.pivot.tolist()]
        return f"rigid {self._kind} {numbers!r}"

    def same_on_all_ranks(self) -> list[Any]:
        """Values that collective.describe compares between ranks.

        Returns:
            Shape, displacement and motion.
        """
        turned = [] if self.angle is None else [self.angle, self.pivot]
        moved = [self._displacement, self.motion, self._velocity]
        return [self._kind, self._point, self._direction, self._radius, *moved, *turned]

    @property
    def displacement(self) -> FloatArray:
        """Displacement from the position at which the obstacle was made, (3) [L]."""
        return self._displacement

    @displacement.setter
    def displacement(self, value: ArrayLike) -> None:
        self._displacement = _vector("displacement", value)

    @property
    def velocity(self) -> FloatArray:
        """Velocity of the surface in rolling problems, (3) [L/T]."""
        return self._velocity

    @velocity.setter
    def velocity(self, value: ArrayLike) -> None:
        self._velocity = _vector("velocity", value)

    @property
    def motion(self) -> Any:
        """Of problems in time, added to the displacement: a function of time with three components, a pair
        (times, values), or None [L]."""
        return self._motion

    @motion.setter
    def motion(self, value: Any) -> None:
        self._motion = value

    @property
    def angle(self) -> Any:
        """Rotation vector about `pivot`, (3), or a function of time; None: it does not turn [1]."""
        return self._angle

    @angle.setter
    def angle(self, value: Any) -> None:
        self._angle = value if value is None or is_in_time(value) else rotation_vector("angle", value)

    @property
    def pivot(self) -> FloatArray:
        """Point that it turns about, before the displacement, (3) [L]."""
        return self._point if self._pivot is None else self._pivot

    @pivot.setter
    def pivot(self, value: ArrayLike) -> None:
        self._pivot = _vector("pivot", value)

    def turns_in(self, problem: Any) -> bool:
        """Whether a problem rotates it.

        Args:
            problem: the problem.
        """
        return self.angle is not None

    def rotation_at_start(self, name: str) -> list[float]:
        """Its rotation when a run starts, a matrix row by row, (9) [1].

        Args:
            name: of the contact, for messages.
        """
        turned = self.angle_in_time(name)
        start = np.zeros(3) if turned is None else turned.sample(np.zeros(1))[0]
        return [*map(float, Rotation.from_rotvec(start).as_matrix().ravel())]

    def angle_in_time(self, name: str) -> Amplitude | None:
        """Its angle as a function of time with three components; None: it does not turn.

        Args:
            name: of the contact, for messages.
        """
        if self.angle is None:
            return None
        given = self.angle
        what = f"angle of the rigid master of {name}"
        if not is_in_time(given):
            return Amplitude(lambda t: given, what, size=3)
        return Amplitude(given, what, size=3)

    def orientation_hint(self) -> str:
        """What a user can change if the slave is on the wrong side of the obstacle."""
        place = "inside" if self._radius > 0.0 else "around"
        return (
            f"change the sign of the radius {self._radius:g} of the {self._kind} if the body is {place} it "
            "(positive: the obstacle is solid, negative: a hole that holds the body), or correct the slave's tag"
        )

    def shared(self, gdim: int, turns: bool = False) -> _cpp.gap.Rigid:
        """The obstacle at rest on the C++ side, one object for all contacts by multipliers, which know by it that they
        have the same master.

        Args:
            gdim: dimension of the meshes.
            turns: whether the problem rotates it.
        """
        key = gdim, turns, tuple(map(float, self.pivot))
        if key not in self._shared:
            made = self.obstacle(gdim)
            made.rotates = turns
            made.orientation_hint = self.orientation_hint()
            self._shared[key] = made
        return self._shared[key]

    def obstacle(self, gdim: int) -> _cpp.gap.Rigid:
        """The obstacle on the C++ side, on meshes of a dimension."""
        if gdim == 2:
            if self._kind == "plane" and self._direction[2] != 0.0:
                raise ValueError("the normal of a rigid plane on a plane mesh has a third component")
            if self._point[2] != 0.0:
                raise ValueError("the rigid obstacle lies outside the plane of the mesh")
        made = _cpp.gap.Rigid(
            self._kind, gdim, [*map(float, self._point)], [*map(float, self._direction)], self._radius
        )
        return self._turning(made, gdim)

    def _turning(self, made: _cpp.gap.Rigid, gdim: int) -> _cpp.gap.Rigid:
        """The obstacle on the C++ side with what it turns about."""
        if self.angle is not None:
            fixed_angle = None if is_in_time(self.angle) else self.angle
            if gdim == 2 and (self.pivot[2] != 0.0 or (fixed_angle is not None and np.any(fixed_angle[:2]))):
                raise ValueError("on a plane mesh a rigid obstacle turns about z, and its pivot lies in the plane")
            made.centre = [*map(float, self.pivot)]
            made.rotates = True
        return made


class RigidPlane(_Rigid):
    """Rigid half-space.

    Args:
        point: a point of its surface, (2) or (3) [L].
        normal: direction out of the obstacle, towards the body, of any length, (2) or (3) [1].

    Raises:
        TypeError: an argument is not made of numbers.
        ValueError: an argument is not finite or has another shape, or the normal is zero.
    """

    def __init__(self, point: ArrayLike, normal: ArrayLike) -> None:
        super().__init__("plane", _vector("point", point), _unit("normal", normal), 0.0)

    def _made_of(self) -> str:
        return f"point={self._point.tolist()}, normal={self._direction.tolist()}"

    def orientation_hint(self) -> str:
        return f"turn the plane's normal {self._direction.tolist()} round, it must point out of the obstacle"


def _radius(value: Any) -> float:
    """A checked radius that is not zero."""
    radius = number("radius", value, unit=" [L]")
    if radius == 0.0:
        raise ValueError("the radius of a rigid obstacle is zero")
    return radius


class RigidSphere(_Rigid):
    """Rigid ball, or spherical cavity; in an axisymmetric problem its centre must be on the axis.

    Args:
        center: centre, (2) or (3) [L].
        radius: radius, positive for a ball, negative for a cavity around the body [L].

    Raises:
        TypeError: an argument is not made of numbers.
        ValueError: an argument is not finite or has another shape, or the radius is zero.
    """

    def __init__(self, center: ArrayLike, radius: float) -> None:
        super().__init__("sphere", _vector("center", center), np.array([0.0, 0.0, 1.0]), _radius(radius))


class RigidCylinder(_Rigid):
    """Rigid cylinder of infinite length, or cylindrical bore.

    Args:
        center: a point of its axis, (2) or (3) [L].
        radius: radius, positive for a cylinder, negative for a bore around the body [L].
        axis: direction of the axis, (2) or (3); on plane meshes it is normal to the plane [1].

    Raises:
        TypeError: an argument is not made of numbers.
        ValueError: an argument is not finite or has another shape, or radius or axis is zero.
    """

    def __init__(self, center: ArrayLike, radius: float, axis: ArrayLike = (0.0, 0.0, 1.0)) -> None:
        super().__init__("cylinder", _vector("center", center), _unit("axis", axis), _radius(radius))

    def _made_of(self) -> str:
        return f"{super()._made_of()}, axis={self._direction.tolist()}"
