# SPDX-License-Identifier: MIT
# Written by `make stub` from cpp/bindings: not to be changed by hand.
from collections.abc import Sequence
from typing import Any, overload

import dolfinx.cpp
import numpy
from numpy.typing import NDArray

ABI: int = 5

class Kernel:
    """A compiled integral"""

    @property
    def name(self) -> str: ...
    @property
    def signature(self) -> str: ...
    @property
    def integral_type(self) -> str: ...
    @property
    def cell(self) -> str: ...
    @property
    def hypothesis(self) -> str: ...
    @property
    def geometry_degree(self) -> int: ...
    @property
    def gdim(self) -> int: ...
    @property
    def rank(self) -> int: ...
    @property
    def shape(self) -> tuple[int, int]: ...
    @property
    def size_A(self) -> int: ...
    @property
    def num_points(self) -> int: ...
    @property
    def sums(self) -> dict[str, int]: ...
    @property
    def outputs(self) -> list[dict[str, Any]]: ...
    @property
    def flops(self) -> float: ...
    @property
    def subdomains(self) -> list[int]: ...
    @property
    def arguments(self) -> list[dict[str, Any]]: ...
    @property
    def coefficients(self) -> list[dict[str, Any]]: ...
    @property
    def constants(self) -> list[dict[str, Any]]: ...
    def placed(self, subdomains: Sequence[int], coefficients: Sequence[int], constants: Sequence[int]) -> Kernel:
        """
        The kernel as a part of a form: the tags that it belongs to there, and the number of each of its coefficients and constants in the form's lists
        """

    @property
    def widths(self) -> list[int]: ...
    def tabulate(
        self,
        A: NDArray[numpy.float64],
        w: NDArray[numpy.floating[Any]],
        c: NDArray[numpy.floating[Any]],
        x: NDArray[numpy.floating[Any]],
        entity: int = 0,
        lanes: int = 1,
    ) -> None:
        """
        Element tensor of `lanes` cells, added to A; layout in kernels/Kernel.h
        """

    def tabulate_cells(
        self,
        A: NDArray[numpy.float64],
        w: NDArray[numpy.floating[Any]],
        c: NDArray[numpy.floating[Any]],
        x: NDArray[numpy.floating[Any]],
        num_cells: int,
    ) -> None:
        """
        Element tensors of many cells, one after another in each array, added to A; layout of a cell in kernels/Kernel.h
        """

    def seconds_per_cell(self, widths: Sequence[int]) -> list[float]:
        """
        Time per cell of each of some widths, arrays in the cache (kernels/timing.h) [s]
        """

    @property
    def width(self) -> int:
        """Cells per call that operators take by default"""

    @property
    def num_nodes(self) -> int:
        """Nodes of the cell, of both cells at a facet between two"""

    def check_mesh(self, mesh: dolfinx.cpp.mesh.Mesh_float64) -> None:
        """
        Raise RuntimeError unless the kernel was compiled for this kind of mesh
        """

    @property
    def address(self) -> int: ...

def find(name: str, cell: str, degree: int, geometry_degree: int = 1, hypothesis: str = "") -> list[Kernel]: ...
def find_signature(signature: str) -> list[Kernel]: ...
@overload
def load(path: str, symbols: Sequence[str]) -> list[Kernel]: ...
@overload
def load(path: bytes, symbols: Sequence[str]) -> list[Kernel]:
    """
    Kernels of a shared library; path: bytes as the file system has them, which need be no text
    """

def processor_width() -> int:
    """Widest vector of doubles of this processor that is used: 1, 4 or 8"""

def table() -> list[Kernel]:
    """Kernels built with the package"""
