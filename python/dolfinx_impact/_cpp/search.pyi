# SPDX-License-Identifier: MIT
# Written by `make stub` from cpp/bindings: not to be changed by hand.
import enum
from typing import Any

import dolfinx.cpp
import numpy
from numpy.typing import NDArray

import dolfinx_impact._cpp

class BoxTree:
    """Bounding-volume hierarchy; a box is gdim lower, then gdim upper bounds"""

    def __init__(self, gdim: int, boxes: NDArray[numpy.floating[Any]]) -> None: ...
    def refit(self, boxes: NDArray[numpy.floating[Any]]) -> None: ...
    @property
    def size(self) -> int: ...
    def overlapping(self, box: NDArray[numpy.floating[Any]]) -> NDArray[numpy.int32]:
        """Ascending numbers of the boxes that overlap `box`"""

    def nearest(self, x: NDArray[numpy.floating[Any]]) -> tuple[int, float]:
        """
        Number of the box nearest to a point (-1 without boxes) and its distance
        """

class Exchange:
    """
    A rank's slave facets and the master facets of all ranks within reach of them
    """

    def __init__(
        self,
        V: dolfinx.cpp.fem.FunctionSpace_float64,
        slave: dolfinx_impact._cpp.surface.Facets,
        master: dolfinx_impact._cpp.surface.Facets,
        reach: float,
    ) -> None:
        """
        Collective. reach: master facets are kept whose boxes come within it of the box around all slave facets of the rank: the distance of pairing and what the surfaces may move before the next Exchange [L]
        """

    @property
    def slave(self) -> dolfinx_impact._cpp.surface.Facets: ...
    @property
    def master(self) -> dolfinx_impact._cpp.surface.Facets: ...
    @property
    def map(self) -> dolfinx.cpp.common.IndexMap:
        """Nodal map: owned blocks of V, then ghosts"""

    @property
    def size(self) -> int:
        """Entries of a vector over the map"""

    def forward(self, u: NDArray[numpy.floating[Any]]) -> NDArray[numpy.float64]:
        """Values at the map's nodes from a vector of V. Collective"""

    def reverse(self, values: NDArray[numpy.floating[Any]], b: NDArray[numpy.float64]) -> None:
        """Add values at the map's nodes to a vector of V (changed). Collective"""

    def move(self, u: NDArray[numpy.floating[Any]]) -> None:
        """Both surfaces to X + u, u a vector of V. Collective"""

class PairSearch:
    """
    Two deformable surfaces as they move; candidates are kept while they hold
    """

    def __init__(
        self,
        V: dolfinx.cpp.fem.FunctionSpace_float64,
        slave: dolfinx_impact._cpp.surface.Facets,
        master: dolfinx_impact._cpp.surface.Facets,
        reach: float = 0.0,
    ) -> None: ...
    def update(self, u: NDArray[numpy.floating[Any]], start: NDArray[numpy.floating[Any]]) -> None:
        """Move both surfaces to u and search anew where needed. Collective"""

    def forget(self) -> None:
        """Exchange candidates in the next update, whatever has moved"""

    @property
    def slave(self) -> dolfinx_impact._cpp.surface.Facets: ...
    @property
    def master(self) -> dolfinx_impact._cpp.surface.Facets: ...
    @property
    def map(self) -> dolfinx.cpp.common.IndexMap: ...
    @property
    def reach(self) -> float: ...
    @property
    def kept(self) -> bool: ...
    @property
    def num_exchanges(self) -> int: ...

class ProjectionStatus(enum.IntEnum):
    converged = 0

    edge = 1

    vertex = 2

    outside = 3

class SurfaceSearch:
    """Closest points of a surface"""

    def __init__(self, master: dolfinx_impact._cpp.surface.Facets) -> None: ...
    @property
    def master(self) -> dolfinx_impact._cpp.surface.Facets: ...
    def update(self) -> None:
        """To be called when the facets have moved"""

    def project(
        self,
        x: NDArray[numpy.floating[Any]],
        slave_normals: NDArray[numpy.floating[Any]],
        reach: float,
        previous: NDArray[numpy.integer[Any]] | None = None,
    ) -> dict[str, NDArray[Any]]:
        """
        Closest points: dictionary of status (0 inside, 1 edge, 2 vertex, 3 none), entity, facet, xi, gap, normal
        """

def bounding_boxes(facets: dolfinx_impact._cpp.surface.Facets) -> NDArray[numpy.float64]:
    """Boxes around facets, curved ones included"""
