# SPDX-License-Identifier: MIT
# Written by `make stub` from cpp/bindings: not to be changed by hand.
from typing import Any

import dolfinx.cpp
import numpy
from numpy.typing import NDArray

class FacetElement:
    """Lagrange element of degree 1 or 2 on a reference facet"""

    def __init__(self, shape: str, degree: int) -> None: ...
    @property
    def num_nodes(self) -> int: ...
    @property
    def degree(self) -> int: ...
    @property
    def shape(self) -> str: ...
    def node(self, i: int) -> list[float]: ...
    def tabulate(self, x: float, y: float = 0.0) -> NDArray[numpy.float64]:
        """Rows: values, first and second derivatives (11, 22, 12)"""

class Facets:
    """Facets of a surface in flat arrays; properties are copies"""

    @property
    def size(self) -> int: ...
    @property
    def gdim(self) -> int: ...
    @property
    def displacement(self) -> FacetElement: ...
    @property
    def geometry(self) -> FacetElement: ...
    @property
    def nodes(self) -> NDArray[numpy.int32]: ...
    @property
    def X(self) -> NDArray[numpy.float64]: ...
    @property
    def x(self) -> NDArray[numpy.float64]: ...
    @property
    def orientation(self) -> NDArray[numpy.int8]: ...
    @property
    def id(self) -> NDArray[numpy.int64]: ...
    def move(self, u: NDArray[numpy.floating[Any]]) -> None:
        """Current positions from displacements, numbered as `nodes`"""

    @property
    def smooth(self) -> bool: ...
    def move_and_turn(self, u: NDArray[numpy.floating[Any]]) -> None:
        """As `move`, where smooth facets turn by any angle"""

    def evaluate(self, facet: int, x: float, y: float = 0.0) -> NDArray[numpy.float64]:
        """Position (3), normal (3) and Jacobian at a point"""

def make_smooth(
    V: dolfinx.cpp.fem.FunctionSpace_float64, facets: Facets, crease: float, normals: NDArray[numpy.floating[Any]]
) -> Facets:
    """
    Curved facets of degree 2 through the corners of facets of degree 1; normals at these corners, or none. Collective
    """

def make_surface(V: dolfinx.cpp.fem.FunctionSpace_float64, facets: NDArray[numpy.integer[Any]]) -> Facets:
    """This rank's facets of a surface; nodes number the blocks of V's dofmap"""
