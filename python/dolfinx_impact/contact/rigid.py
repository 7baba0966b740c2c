# SPDX-License-Identifier: MIT
"""Rigid obstacles as masters."""

import numpy as np

from .. import _cpp
from ..common.arguments import number


def _vector(name, value):
    try:
        array = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        raise TypeError(f"{name} must be two or three numbers, found {value!r}") from None
    if array.shape not in ((2,), (3,)):
        raise ValueError(f"{name} must have two or three components, found shape {array.shape}")
    if not np.all(np.isfinite(array)):
        raise ValueError(f"{name} is {array.tolist()}: give finite numbers")
    return np.pad(array, (0, 3 - len(array)))


def _unit(name, value):
    vector = _vector(name, value)
    length = np.linalg.norm(vector)
    if length == 0.0:
        raise ValueError(f"{name} is zero: it has no direction")
    return vector / length


class _Rigid:
    """Common part: a displacement that may be changed between solves; load steps go there in equal parts.

    Attributes:
        motion: of explicit problems, added to the displacement: function of time with three components, or a pair
            (times, values), or None [L].
    """

    _checksum = ""  # of a form that numbers do not tell

    def __init__(self, kind, point, direction, radius):
        self._kind, self._point, self._direction, self._radius = kind, point, direction, radius
        self._displacement = np.zeros(3)
        self.motion = None

    def __repr__(self):
        moved = f", displacement={self._displacement.tolist()}" if np.any(self._displacement) else ""
        driven = ", motion=..." if self.motion is not None else ""
        return f"{type(self).__name__}({self._made_of()}{moved}{driven})"

    def _made_of(self):
        """Arguments as `repr` shows them."""
        return f"center={self._point.tolist()}, radius={self._radius}"

    def same_on_all_ranks(self):
        """What collective.describe compares."""
        return [self._kind, self._point, self._direction, self._radius, self._displacement, self.motion]

    @property
    def displacement(self):
        """Displacement from where it was made (3 components) [L]."""
        return self._displacement.copy()

    @displacement.setter
    def displacement(self, value):
        self._displacement = _vector("displacement", value)

    def _turn(self):
        """What to do where the slave is on the wrong side."""
        place = "inside" if self._radius > 0.0 else "around"
        return (
            f"change the sign of the radius {self._radius:g} of the {self._kind} if the body is {place} it "
            "(positive: the obstacle is solid, negative: a hole that holds the body), or correct the slave's tag"
        )

    def _obstacle(self, gdim):
        if gdim == 2:
            if self._kind == "plane" and self._direction[2] != 0.0:
                raise ValueError("the normal of a rigid plane on a plane mesh has a third component")
            if self._point[2] != 0.0:
                raise ValueError("the rigid obstacle lies outside the plane of the mesh")
        return _cpp.gap.Rigid(self._kind, gdim, self._point.tolist(), self._direction.tolist(), self._radius)


class RigidPlane(_Rigid):
    """Rigid half-space.

    Args:
        point: a point of its surface (2 or 3 components) [L].
        normal: out of the obstacle, towards the body; any length [1].

    Raises:
        TypeError, ValueError: not numbers, not finite, a normal of zero.
    """

    def __init__(self, point, normal):
        super().__init__("plane", _vector("point", point), _unit("normal", normal), 0.0)

    def _made_of(self):
        return f"point={self._point.tolist()}, normal={self._direction.tolist()}"

    def _turn(self):
        return f"turn the plane's normal {self._direction.tolist()} round, it must point out of the obstacle"


def _radius(value):
    radius = number("radius", value, unit=" [L]")
    if radius == 0.0:
        raise ValueError("the radius of a rigid obstacle is zero")
    return radius


class RigidSphere(_Rigid):
    """Rigid ball; in an axisymmetric problem its centre must be on the axis.

    Args:
        center: (2 or 3 components) [L].
        radius: positive; negative for a cavity that holds the body [L].
    """

    def __init__(self, center, radius):
        super().__init__("sphere", _vector("center", center), np.array([0.0, 0.0, 1.0]), _radius(radius))


class RigidCylinder(_Rigid):
    """Rigid cylinder of infinite length.

    Args:
        center: a point of its axis (2 or 3 components) [L].
        radius: positive; negative for a bore that holds the body
            [L].
        axis: direction of the axis; on plane meshes it points out of the plane [1].
    """

    def __init__(self, center, radius, axis=(0.0, 0.0, 1.0)):
        super().__init__("cylinder", _vector("center", center), _unit("axis", axis), _radius(radius))

    def _made_of(self):
        return f"{super()._made_of()}, axis={self._direction.tolist()}"
