# SPDX-License-Identifier: MIT
"""States in checkpoints: a tree of named arrays (cpp/dolfinx_impact/state/State.h) written and read, whoever has it.

How a tree is laid out in a file, which `checkpoint` writes and reads:

| field | of the tree itself | of a part |
|---|---|---|
| at all nodes | table nodes/FIELD | table nodes/FIELD with the digits at the end of the part's name |
| at some nodes, at facets | table some/FIELD, facets/FIELD | table some/PART, facets/PART: fields side by side |
| of cells | table cells/values/FIELD | table cells/values/FIELD |
| of ranks | table ranks/FIELD | table ranks/PART: fields one after the other |
| of none | attribute FIELD | attribute PART: fields one after the other |

Values are real numbers there; whole ones are checked when they are read.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from .. import _cpp
from ..common.collective import agree, attempt
from ..common.types import AnyArray, FilePath, FloatArray, IntArray
from . import checkpoint
from .checkpoint import Attribute, Subject

Place, State = _cpp.state.Place, _cpp.state.State


@dataclass
class Block:
    """Fields of a state that are one table, or one attribute, of a file.

    Attributes:
        name: name of the table or attribute.
        place: what its rows belong to.
        state: the tree or part that has the fields.
        fields: their names, in the order of the columns.
    """

    name: str
    place: _cpp.state.Place
    state: _cpp.state.State
    fields: list[str]

    @property
    def numbers(self) -> IntArray | None:
        """Nodes or facets of the rows; None: all."""
        return self.state.numbers(self.place)

    @property
    def flat(self) -> bool:
        """Whether the values are one vector, and not rows by place."""
        return self.place in (Place.rank, Place.all)

    @property
    def widths(self) -> list[int]:
        """Number of columns of each field; of vectors their lengths."""
        sizes = [self.state.array(f).size if self.flat else self.state.columns(f) for f in self.fields]
        return [int(size) for size in sizes]

    def values(self) -> FloatArray:
        """The fields side by side, (rows, columns), or one after the other, as real numbers."""
        parts = [np.asarray(self.state.array(f), dtype=float) for f in self.fields]
        if self.flat:
            return np.concatenate([part.ravel() for part in parts])
        return np.hstack([part.reshape(-1, width) for part, width in zip(parts, self.widths)])

    def assign(self, values: FloatArray) -> None:
        """Set the fields.

        Args:
            values: as `values` returns them.

        Raises:
            ValueError: a whole number is none.
        """
        for field, part in zip(self.fields, np.split(values, np.cumsum(self.widths)[:-1], axis=-1)):
            array = self.state.array(field)
            converted = part.reshape(array.shape).astype(array.dtype)
            if not np.issubdtype(array.dtype, np.floating) and np.any(converted != part.reshape(array.shape)):
                raise ValueError(f"the {field}s in {self.name} are no whole numbers")
            array[...] = converted


def blocks(state: _cpp.state.State) -> Iterator[Block]:
    """Tables and attributes of a state.

    Args:
        state: the tree; its parts at any depth have names of their own.

    Yields:
        Each of them.
    """
    for field in state.names:
        yield Block(field, state.place(field), state, [field])
    yield from _blocks_of_parts(state)


def _blocks_of_parts(state: _cpp.state.State) -> Iterator[Block]:
    for name in state.parts:
        part = state.part(name)
        number = name[len(name.rstrip("0123456789")) :]
        for place in (Place.node, Place.facet, Place.cell, Place.rank, Place.all):
            fields = [f for f in part.names if part.place(f) == place]
            if place == Place.cell:
                yield from (Block(f, place, part, [f]) for f in fields)
            elif place == Place.node and part.numbers(place) is None:
                yield from (Block(f"{f}{number}", place, part, [f]) for f in fields)
            elif fields:
                yield Block(name, place, part, fields)
        yield from _blocks_of_parts(part)


def write(
    path: FilePath, subject: Subject, state: _cpp.state.State, attributes: Mapping[str, Attribute] | None = None
) -> None:
    """Write a state. Collective.

    Args:
        path: file to write.
        subject: by what a problem is recognised.
        state: state to write.
        attributes: further numbers, texts and arrays by name, the same on all ranks; None: there are none.

    Raises:
        RuntimeError: the folder cannot be written, or no space is left; on all ranks. An earlier file is as it was.
    """
    arrays: dict[str, FloatArray] = {}
    nodal: dict[str, tuple[IntArray, FloatArray]] = {}
    facets: dict[str, tuple[IntArray, FloatArray]] = {}
    cellwise: dict[str, FloatArray] = {}
    ranks: dict[str, FloatArray] = {}
    more: dict[str, Attribute] = dict(attributes or {})
    for block in blocks(state):
        numbers = block.numbers
        if block.place == Place.all:
            more[block.name] = _attribute(block)
        elif block.place == Place.rank:
            ranks[block.name] = block.values()
        elif block.place == Place.cell:
            cellwise[block.name] = block.values()
        elif numbers is None:
            arrays[block.name] = block.values()
        else:
            (facets if block.place == Place.facet else nodal)[block.name] = (numbers, block.values())
    checkpoint.write(path, subject, arrays, nodal, cellwise, ranks, more, facets)


def read(
    path: FilePath,
    subject: Subject,
    like: _cpp.state.State,
    attributes: Iterable[str] = (),
    equal: Collection[str] = (),
) -> tuple[_cpp.state.State, dict[str, Any]]:
    """Read a state. Collective.

    Args:
        path: file that `write` has written, on these ranks or on others.
        subject: by what the problem is recognised that it is for.
        like: state with the structure that is wanted; its values are not read.
        attributes: names of further attributes.
        equal: names of vectors of ranks that are equal on all ranks; others add up.

    Returns:
        The state, with values of its own, and all attributes by name.

    Raises:
        RuntimeError: the file cannot be read, or is damaged; on all ranks.
        ValueError: the file belongs to another problem, or has values that no state has; on all ranks.
    """
    found = like.copy()
    parts = list(blocks(found))

    def widths(place: _cpp.state.Place, some: bool = False) -> dict[str, int]:
        chosen = [b for b in parts if b.place == place and (b.numbers is not None) == some]
        return {block.name: sum(block.widths) for block in chosen}

    names = [*attributes, *(b.name for b in parts if b.place == Place.all)]
    file = checkpoint.Reader(
        path, subject, widths(Place.node), widths(Place.node, True), widths(Place.cell), widths(Place.rank), names,
        widths(Place.facet, True),
    )  # fmt: skip
    file.check_supports()
    rows = [_rows(file, block, equal) for block in parts]

    def assign() -> None:
        for block, values in zip(parts, rows):
            try:
                block.assign(_numbers(block, values))
            except ValueError as error:
                raise ValueError(f"{path} is of no run: {error}") from None

    _, error = attempt(assign)
    agree(subject.space.mesh.comm, error, "restore")
    return found, file.attributes


def _attribute(block: Block) -> Attribute:
    """Value of an attribute: a number where the tree has one."""
    first = np.asarray(block.state.array(block.fields[0]))
    if len(block.fields) == 1 and first.size == 1 and block.name == block.fields[0]:
        return int(first[0]) if np.issubdtype(first.dtype, np.integer) else float(first[0])
    return block.values()


def _rows(file: checkpoint.Reader, block: Block, equal: Collection[str]) -> AnyArray:
    """What a file has for a block on this rank. Collective."""
    numbers = block.numbers
    if block.place == Place.all:
        return np.asarray(file.attributes[block.name])
    if block.place == Place.rank:
        return file.rank(block.name, block.name not in equal)
    if block.place == Place.cell:
        return file.cellwise[block.name]
    if numbers is None:
        return file.arrays[block.name]
    return file.at_facets(block.name, numbers) if block.place == Place.facet else file.all_at(block.name, numbers)


def _numbers(block: Block, values: AnyArray) -> FloatArray:
    """Values as real numbers of the shape that the block has."""
    if block.place != Place.all:
        return np.asarray(values)
    size = sum(block.widths)
    if not np.issubdtype(values.dtype, np.number) or np.iscomplexobj(values) or values.ndim > 1 or values.size != size:
        raise ValueError(f"{block.name} is {values.tolist()!r}")
    flat: FloatArray = values.astype(float).ravel()
    return flat
