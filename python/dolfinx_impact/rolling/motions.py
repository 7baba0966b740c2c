# SPDX-License-Identifier: MIT
"""Motions of the material through a mesh that stands still: spin about an axis, and translation."""

from __future__ import annotations

from typing import Any

import numpy as np
import ufl
from dolfinx import default_scalar_type, fem
from dolfinx.mesh import Mesh

from .. import _cpp
from ..common.arguments import number
from ..common.fixed import Fixed, read_only
from ..common.types import ArrayLike, FloatArray, IntArray
from ..forms import ale

PARALLEL = 1e-12  # sine of the angle between a given axis and z at which they are parallel


def _components(name: str, value: Any, counts: tuple[int, ...]) -> FloatArray:
    """A finite vector with one of the given numbers of components."""
    try:
        if any(isinstance(x, (str, bytes)) for x in np.ravel(np.asarray(value, dtype=object))):
            raise TypeError
        array = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        raise TypeError(f"{name} must be numbers, found {value!r:.60}") from None
    if array.ndim != 1 or len(array) not in counts:
        wanted = " or ".join(str(n) for n in counts)
        raise ValueError(f"{name} has shape {array.shape}: it needs {wanted} components")
    if not np.all(np.isfinite(array)):
        raise ValueError(f"{name} is {array.tolist()}: give finite numbers")
    held: FloatArray = read_only(array)
    return held


class Spin(Fixed):
    """Rotation of the material about a fixed axis.

    Args:
        point: a point on the axis, (gdim) [L].
        axis: direction of the axis, (3), of any length; (0, 0, 1) or (0, 0, -1) on meshes of the plane [1].
        omega: angular velocity about the axis by the right-hand rule [1/T].

    Attributes:
        point: a point on the axis, (gdim) [L].
        axis: unit vector along the axis, (3) [1].
        omega: angular velocity; a new value counts from the next solve [1/T].

    Raises:
        TypeError: an argument is not a number or not a vector of numbers.
        ValueError: an axis without direction, wrong numbers of components, values that are not finite.
    """

    def __init__(self, point: ArrayLike, axis: ArrayLike, omega: float) -> None:
        self.point = _components("point of a Spin", point, (2, 3))
        axis = _components("axis of a Spin", axis, (3,))
        length = float(np.linalg.norm(axis))
        if length == 0.0:
            raise ValueError("axis of a Spin is zero: it has no direction")
        self.axis: FloatArray = read_only(axis / length)
        self.omega = omega

    @property
    def omega(self) -> float:
        """Angular velocity [1/T]."""
        return self._omega

    @omega.setter
    def omega(self, value: float) -> None:
        self._omega = number("omega of a Spin", value, unit=" [1/T]")

    def __repr__(self) -> str:
        return f"Spin(point={self.point.tolist()}, axis={self.axis.tolist()}, omega={self.omega})"

    def same_on_all_ranks(self) -> list[Any]:
        """What must be the same on all ranks."""
        return [self.point, self.axis, self.omega]

    @property
    def rate(self) -> FloatArray:
        """What load steps ramp: the angular velocity, () [1/T]."""
        return np.array(self.omega)

    def check(self, mesh: Mesh) -> None:
        """Raise ValueError unless point and axis fit the mesh.

        Args:
            mesh: mesh of the displacement.
        """
        gdim = mesh.geometry.dim
        if len(self.point) != gdim:
            raise ValueError(f"point of a Spin has {len(self.point)} components: on this mesh it needs {gdim}")
        if gdim == 2 and float(np.hypot(*self.axis[:2])) > PARALLEL:
            raise ValueError(f"axis of a Spin is {self.axis.tolist()}: on a mesh of the plane it must be along z")

    def vector(self, rate: Any, gdim: int) -> Any:
        """Angular velocity in UFL: a scalar about z in the plane, a vector in space [1/T].

        Args:
            rate: angular velocity about the axis [1/T].
            gdim: dimension of space.
        """
        return float(self.axis[2]) * rate if gdim == 2 else ufl.as_vector([float(a) * rate for a in self.axis])

    def velocity(self, mesh: Mesh, rate: Any) -> Any:
        """Velocity w of the material through the mesh in UFL [L/T].

        Args:
            mesh: mesh.
            rate: angular velocity about the axis [1/T].
        """
        centre = ufl.as_vector([float(c) for c in self.point])
        return ale.convection(mesh, self.vector(rate, mesh.geometry.dim), centre)

    def turned(self, u: Any, rate: Any) -> Any:
        """Omega x u in UFL: what a turn of the frame adds to the derivative of a vector.

        Args:
            u: vector.
            rate: angular velocity about the axis [1/T].
        """
        spin = self.vector(rate, len(u))
        return ufl.as_vector([-spin * u[1], spin * u[0]]) if len(u) == 2 else ufl.cross(spin, u)

    def constant(self, mesh: Mesh) -> fem.Constant:
        """Constant for the rate, zero."""
        return fem.Constant(mesh, default_scalar_type(0.0))

    def in_cpp(self, rate: fem.Constant, nodes: IntArray) -> _cpp.rolling.Motion:
        """The motion of a body in C++.

        Args:
            rate: constant of the angular velocity.
            nodes: of the body, owned and ghosts, sorted.
        """
        point = np.zeros(3)
        point[: len(self.point)] = self.point
        return _cpp.rolling.Motion.spin(list(map(float, point)), list(map(float, self.axis)), rate._cpp_object, nodes)


class Translation(Fixed):
    """Translation of the material through the mesh with one velocity, as of a rail under a wheel that does not travel.

    Args:
        velocity: components, (gdim) [L/T].

    Attributes:
        velocity: components; a new value counts from the next solve [L/T].

    Raises:
        TypeError: `velocity` is not a vector of numbers.
        ValueError: a wrong number of components, values that are not finite.
    """

    def __init__(self, velocity: ArrayLike) -> None:
        self.velocity: FloatArray = velocity  # type: ignore[assignment]

    @property
    def velocity(self) -> FloatArray:
        """Components [L/T]."""
        return self._velocity

    @velocity.setter
    def velocity(self, value: ArrayLike) -> None:
        self._velocity = _components("velocity of a Translation", value, (2, 3))

    def __repr__(self) -> str:
        return f"Translation(velocity={self.velocity.tolist()})"

    def same_on_all_ranks(self) -> list[Any]:
        """What must be the same on all ranks."""
        return [self.velocity]

    @property
    def rate(self) -> FloatArray:
        """What load steps ramp: the velocity, (gdim) [L/T]."""
        return self.velocity

    def check(self, mesh: Mesh) -> None:
        """Raise ValueError unless the velocity fits the mesh.

        Args:
            mesh: mesh of the displacement.
        """
        gdim = mesh.geometry.dim
        if len(self.velocity) != gdim:
            raise ValueError(f"velocity of a Translation has {len(self.velocity)} components: this mesh needs {gdim}")

    def constant(self, mesh: Mesh) -> fem.Constant:
        """Constant for the rate, zero."""
        return fem.Constant(mesh, np.zeros(mesh.geometry.dim, dtype=default_scalar_type))

    def in_cpp(self, rate: fem.Constant, nodes: IntArray) -> _cpp.rolling.Motion:
        """The motion of a body in C++.

        Args:
            rate: constant of the velocity.
            nodes: of the body, owned and ghosts, sorted.
        """
        return _cpp.rolling.Motion.translation(rate._cpp_object, nodes)
