# SPDX-License-Identifier: MIT
# Written by `make stub` from cpp/bindings: not to be changed by hand.
import enum
from typing import Any, overload

import numpy
from numpy.typing import NDArray

class Place(enum.Enum):
    """What the rows of an array belong to"""

    node = 0

    facet = 1

    cell = 2

    rank = 3

    all = 4

class State:
    """
    A tree of named arrays, which are views of the memory of what has the state
    """

    def __init__(self, name: str = "") -> None: ...
    @property
    def name(self) -> str: ...
    @property
    def names(self) -> list[str]: ...
    @property
    def parts(self) -> list[str]: ...
    def numbers(self, place: Place) -> NDArray[numpy.int64] | None:
        """Nodes or facets that rows at a place belong to; None: all"""

    def columns(self, name: str) -> int: ...
    def at(self, place: Place, numbers: NDArray[numpy.integer[Any]]) -> None:
        """Say which nodes or facets the rows at a place belong to"""

    def rename(self, name: str) -> None: ...
    def place(self, name: str) -> Place: ...
    def array(self, name: str) -> NDArray[Any]:
        """Values of a field, (rows) or (rows, columns); a view"""

    def part(self, name: str) -> State: ...
    @overload
    def add(self, name: str, place: Place, values: NDArray[numpy.float64]) -> None:
        """A view of an array"""

    @overload
    def add(self, name: str, place: Place, values: NDArray[numpy.int8]) -> None: ...
    @overload
    def add(self, name: str, place: Place, values: NDArray[numpy.int32]) -> None: ...
    @overload
    def add(self, name: str, place: Place, values: NDArray[numpy.int64]) -> None: ...
    @overload
    def add(self, part: State) -> None: ...
    def copy(self) -> State:
        """The same tree with values of its own"""

    def assign(self, other: State) -> None:
        """Set the values to those of a tree with the same fields and parts"""

    def difference_of_values(self, other: State) -> str: ...
    def __repr__(self) -> str: ...
