# SPDX-License-Identifier: MIT
# Written by `make stub` from cpp/bindings: not to be changed by hand.
from collections.abc import Mapping, Sequence
from typing import Any

import dolfinx.cpp
import numpy
from numpy.typing import NDArray

import dolfinx_impact._cpp

class Block:
    """Fields of a state that are one table, or one attribute, of a file"""

    @property
    def name(self) -> str: ...
    @property
    def place(self) -> dolfinx_impact._cpp.state.Place: ...
    @property
    def numbers(self) -> NDArray[numpy.int64] | None:
        """Nodes or facets of the rows; None: all"""

    @property
    def width(self) -> int:
        """Number of columns, length of a vector"""

    def values(self) -> NDArray[numpy.float64]:
        """The fields side by side, (rows, width), or one after the other"""

    def assign(self, values: NDArray[numpy.floating[Any]]) -> None:
        """Set the fields"""

class Damaged(RuntimeError):
    pass

FORMAT: int = 11

class SealedFile:
    """A file under checksums, whose structure has been verified"""

    def __init__(self, path: str) -> None: ...
    @property
    def mark(self) -> bytes:
        """Checksum of all checksums, 16 bytes"""

    @property
    def size(self) -> int:
        """Bytes before the seal"""

    @property
    def sections(self) -> list[tuple[int, int, bool]]:
        """Offset, length and whether it is data, of every section"""

def blocks(state: dolfinx_impact._cpp.state.State) -> list[Block]:
    """Tables and attributes of a state in a file"""

def input_cells(mesh: dolfinx.cpp.mesh.Mesh_float64) -> NDArray[numpy.int64]:
    """
    Numbers of this rank's owned cells in the mesh's input; raises for submeshes
    """

def places(V: dolfinx.cpp.fem.FunctionSpace_float64) -> NDArray[numpy.float64]:
    """Undeformed coordinates of this rank's owned nodes, (num_nodes, gdim)"""

def read(
    path: str,
    V: dolfinx.cpp.fem.FunctionSpace_float64,
    like: dolfinx_impact._cpp.state.State,
    identity: dict[str, Any],
    supports: dolfinx_impact._cpp.state.State,
    advice: Mapping[str, str],
    more: Sequence[str],
    equal: Sequence[str],
    infinite: Sequence[str],
) -> tuple[dolfinx_impact._cpp.state.State, dict[str, Any]]:
    """State and all attributes of a file. Collective."""

def seal(content: bytes) -> bytes:
    """Seal of a file with this content, to be written behind it"""

def set_input_numbers(
    mesh: dolfinx.cpp.mesh.Mesh_float64, cells: NDArray[numpy.integer[Any]], nodes: NDArray[numpy.integer[Any]]
) -> None:
    """
    Give cells and geometry nodes of a mesh, ghosts included, other numbers in its input
    """

def write(
    path: str,
    V: dolfinx.cpp.fem.FunctionSpace_float64,
    state: dolfinx_impact._cpp.state.State,
    identity: dict[str, Any],
    supports: dolfinx_impact._cpp.state.State,
    more: dict[str, Any],
) -> None:
    """Write a state. Collective."""
