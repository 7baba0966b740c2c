# SPDX-License-Identifier: MIT
# Written by `make stub` from cpp/bindings: not to be changed by hand.
from collections.abc import Callable, Sequence
import enum
from typing import Any, overload

import dolfinx.cpp
import mpi4py.MPI
import numpy
from numpy.typing import NDArray

import dolfinx_impact._cpp

class FacetShape(Shape):
    """Segments or triangles"""

    def __init__(
        self, gdim: int, points: NDArray[numpy.floating[Any]], facets: NDArray[numpy.integer[Any]]
    ) -> None: ...

class GapAdjustment:
    """How gaps differ from the distances of meshed surfaces"""

    def __init__(self, *, offset: float = 0.0, clearance: float | None = None, adjust: float | None = None) -> None: ...
    @property
    def offset(self) -> float: ...
    @property
    def clearance(self) -> float | None: ...
    @property
    def adjust(self) -> float | None: ...

class HeightField(Shape):
    """A cubic spline over a plane"""

    def __init__(
        self,
        gdim: int,
        origin: Sequence[float],
        axes: Sequence[Sequence[float]],
        low: Sequence[float],
        spacing: Sequence[float],
        cells: Sequence[int],
        coefficients: NDArray[numpy.floating[Any]],
    ) -> None: ...

class InitialPenetration:
    """Penetrations in the reference configuration"""

    @property
    def num_points(self) -> int: ...
    @property
    def depth(self) -> float: ...
    @property
    def where(self) -> list[float]: ...
    @property
    def num_adjusted(self) -> int: ...
    @property
    def largest_adjustment(self) -> float: ...
    @property
    def where_adjusted(self) -> list[float]: ...
    @property
    def offset(self) -> NDArray[numpy.float64]: ...
    @property
    def warning(self) -> str: ...

class Mortar:
    """Mortar integrals; properties are copies"""

    @property
    def D(self) -> tuple[NDArray[numpy.int32], NDArray[numpy.int32], NDArray[numpy.float64]]: ...
    @property
    def M(self) -> tuple[NDArray[numpy.int32], NDArray[numpy.int32], NDArray[numpy.float64]]: ...
    @property
    def gamma(self) -> NDArray[numpy.float64]: ...
    @property
    def psi(self) -> NDArray[numpy.float64]: ...

class Multipliers(enum.Enum):
    """Functions of the multipliers"""

    dual = 0

    standard = 1

    linear = 2

class Rigid:
    """A rigid obstacle: plane, sphere, cylinder, surface"""

    @overload
    def __init__(self, shape: Shape) -> None: ...
    @overload
    def __init__(
        self, kind: str, gdim: int, point: Sequence[float], direction: Sequence[float], radius: float
    ) -> None: ...
    @property
    def displacement(self) -> list[float]: ...
    @displacement.setter
    def displacement(self, arg: Sequence[float], /) -> None: ...
    @property
    def centre(self) -> list[float]:
        """About which it rotates, before the displacement"""

    @centre.setter
    def centre(self, arg: Sequence[float], /) -> None: ...
    @property
    def rotates(self) -> bool:
        """Without, the rotation has no effect"""

    @rotates.setter
    def rotates(self, arg: bool, /) -> None: ...
    @property
    def rotation(self) -> list[float]:
        """A matrix, row by row"""

    @rotation.setter
    def rotation(self, arg: Sequence[float], /) -> None: ...
    @property
    def orientation_hint(self) -> str:
        """What can be changed if the body is on its wrong side"""

    @orientation_hint.setter
    def orientation_hint(self, arg: str, /) -> None: ...
    def evaluate(
        self, x: NDArray[numpy.floating[Any]]
    ) -> tuple[NDArray[numpy.float64], NDArray[numpy.float64], NDArray[numpy.float64]]:
        """
        Gaps, normals and their derivatives at points (flat array of coordinates)
        """

class Segments:
    """
    Quadrature points where slave facets face master facets; properties are copies
    """

    @property
    def slave(self) -> NDArray[numpy.int32]: ...
    @property
    def master(self) -> NDArray[numpy.int32]: ...
    @property
    def weight(self) -> NDArray[numpy.float64]: ...
    @property
    def covered(self) -> NDArray[numpy.float64]: ...

class Shape:
    """Surface of a rigid obstacle of any form"""

def check_side(
    name: str, V: dolfinx.cpp.fem.FunctionSpace_float64, slave: dolfinx_impact._cpp.surface.Facets, obstacle: Rigid
) -> None:
    """
    Refuse a rigid obstacle whose surface does not face the slave. Collective
    """

def cover(slave: dolfinx_impact._cpp.surface.Facets, segments: Segments, basis: Multipliers) -> NDArray[numpy.float64]:
    """
    Integrals of the multiplier functions over the points of each facet, (facets, nodes)
    """

def mortar(
    slave: dolfinx_impact._cpp.surface.Facets,
    master: dolfinx_impact._cpp.surface.Facets,
    segments: Segments,
    basis: Multipliers,
    carries: NDArray[numpy.integer[Any]],
) -> Mortar:
    """
    Mortar integrals; `carries` (by node, int8) marks the nodes that have a multiplier
    """

def segment(
    slave: dolfinx_impact._cpp.surface.Facets,
    master: dolfinx_impact._cpp.surface.Facets,
    points: NDArray[numpy.floating[Any]],
    weights: NDArray[numpy.floating[Any]],
    reach: float,
    axisymmetric: bool = False,
) -> Segments:
    """Segments of slave facets with the master facets within reach of them"""

def through_master(
    comm: mpi4py.MPI.Comm,
    suspects: NDArray[numpy.integer[Any]],
    sizes: NDArray[numpy.floating[Any]],
    gap_at: Callable[[float], NDArray[numpy.floating[Any]]],
) -> NDArray[numpy.int8]:
    """Marks of points that have passed through a deformable master"""

def through_obstacle(
    obstacle: Rigid,
    start: NDArray[numpy.floating[Any]],
    end: NDArray[numpy.floating[Any]],
    offset: NDArray[numpy.floating[Any]],
    tolerance: float,
) -> NDArray[numpy.int8]:
    """
    Marks of points that are open on the far side of a rigid obstacle, through which their paths lead
    """

def turning_tangent(
    slave: dolfinx_impact._cpp.surface.Facets, sums: NDArray[numpy.floating[Any]], force: NDArray[numpy.floating[Any]]
) -> tuple[NDArray[numpy.int32], NDArray[numpy.int32], NDArray[numpy.float64]]: ...
