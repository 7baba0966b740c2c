# SPDX-License-Identifier: MIT
# Written by `make stub` from cpp/bindings: not to be changed by hand.
from typing import Any

import dolfinx.cpp
import numpy
from numpy.typing import NDArray

class HandWrittenContact:
    """
    Penalty contact of nodes over quadrilaterals, written by hand: nodes stay over their facets
    """

    def __init__(
        self,
        x: NDArray[numpy.floating[Any]],
        slaves: NDArray[numpy.integer[Any]],
        facets: NDArray[numpy.integer[Any]],
        stiffness: float,
        friction: float,
    ) -> None: ...
    @staticmethod
    def available() -> bool:
        """Has this processor the vectors that it is written for?"""

    def evaluate(self, u: NDArray[numpy.floating[Any]], du: NDArray[numpy.floating[Any]], cold: bool) -> float:
        """Add the forces of one step; returns the time that it takes [s]"""

    def gap(self) -> NDArray[numpy.float64]: ...
    def forces(self) -> NDArray[numpy.float64]: ...

class HandWrittenStep:
    """
    Central differences of a linear elastic body, written by hand for one cell and one law
    """

    def __init__(
        self,
        x: NDArray[numpy.floating[Any]],
        cells: NDArray[numpy.integer[Any]],
        nodes_per_cell: int,
        mu: float,
        lambda_: float,
        mass: NDArray[numpy.floating[Any]],
        width: int,
        one_point: bool = False,
    ) -> None: ...
    def start(self, u: NDArray[numpy.floating[Any]], v: NDArray[numpy.floating[Any]]) -> None: ...
    @staticmethod
    def widths() -> list[int]:
        """Cells at a time that this processor can take"""

    def run(self, num_steps: int, step: float) -> None: ...
    def displacement(self) -> NDArray[numpy.float64]: ...

class Packed:
    """Coefficients of a DOLFINx form, packed into storage that is reused"""

    def __init__(self, form: dolfinx.cpp.fem.Form_float64) -> None: ...
    def pack(self) -> None: ...

def peak_flops(lanes: int = 0) -> float:
    """
    Double-precision operations of one core [1/s], in vectors of 2, 4 or 8 numbers (0: the best of this processor; 0.0 where it does not have such vectors)
    """

def triad_bandwidth(n: int = 16777216) -> float:
    """
    Bandwidth of one core [B/s], of the memory; of the cache that three arrays of n numbers fit in
    """
