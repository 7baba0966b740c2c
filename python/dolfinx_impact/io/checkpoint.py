# SPDX-License-Identifier: MIT
"""Checkpoints of runs in one HDF5 file, written by all ranks together, readable on any number of ranks.

The files are written and read in C++ (cpp/dolfinx_impact/files/checkpoint.h, Block.h), for any problem that describes
its state as a tree of named arrays. Here is by what a problem of Python is recognised.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from dolfinx.fem import FunctionSpace

from .. import _cpp
from ..assembly.fields import fields_of, is_mixed
from ..common.collective import agree, attempt
from ..common.types import AnyArray, FilePath, FloatArray, IntArray
from .signature import Signature

Place, State = _cpp.state.Place, _cpp.state.State

Attribute: TypeAlias = str | int | float | AnyArray

CHANGED_LOAD = "constant.value may be changed again after restore"


@dataclass(frozen=True)
class Subject:
    """A problem as a checkpoint sees it.

    Attributes:
        space: displacement space; nodes are the blocks of its degrees of freedom.
        signature: by what the problem is recognised, of its present arguments, a function that takes the undeformed
            coordinates of this rank's owned nodes, (num_nodes, gdim). Collective.
        supports: owned nodes with prescribed components, (n), and rows of numbers of them, (n, 3 * components): see
            signature.supports.
    """

    space: FunctionSpace
    signature: Callable[[FloatArray], Signature]
    supports: Callable[[], tuple[IntArray, FloatArray]]

    def identity(self) -> tuple[dict[str, Attribute], _cpp.state.State]:
        """Signature, and supports as a part of a state. Collective.

        Raises:
            RuntimeError: cells cannot be identified: the mesh is a submesh; on all ranks.
        """
        mesh = self.space.mesh
        agree(mesh.comm, attempt(_cpp.files.input_cells, mesh._cpp_object)[1], "checkpoint")
        supports, out = State("supports"), State("identity")
        nodes, rows = self.supports()
        supports.at(Place.node, np.ascontiguousarray(nodes, dtype=np.int64))
        supports.add("values", Place.node, np.ascontiguousarray(rows, dtype=float))
        out.add(supports)
        return _plain(self.signature(_cpp.files.places(self.space._cpp_object))), out


def without_nodes(space: FunctionSpace) -> str:
    """Describe a field whose values are not those at nodes.

    Args:
        space: displacement space.

    Returns:
        The first of them, or an empty text.
    """
    if is_mixed(space):
        return next((str(field) for field in fields_of(space) if not field.is_lagrange), "")
    element = space.ufl_element()
    scalar = element.sub_elements[0] if element.block_size > 1 else element
    return "" if scalar.family_name == "P" else f"element {scalar.family_name}"


def write(
    path: FilePath, subject: Subject, state: _cpp.state.State, attributes: Mapping[str, Attribute] | None = None
) -> None:
    """Write a state. Collective.

    Args:
        path: file to write.
        subject: by what a problem is recognised.
        state: state to write; its parts at any depth have names of their own.
        attributes: further numbers, texts and arrays by name, the same on all ranks; None: there are none.

    Raises:
        RuntimeError: the folder cannot be written, or no space is left; on all ranks. An earlier file is as it was.
    """
    _cpp.files.write(
        str(Path(path)), subject.space._cpp_object, state, *subject.identity(), _plain(attributes or {})
    )  # fmt: skip


def read(
    path: FilePath,
    subject: Subject,
    like: _cpp.state.State,
    attributes: Iterable[str] = (),
    equal: Collection[str] = (),
    infinite: Collection[str] = (),
) -> tuple[_cpp.state.State, dict[str, Any]]:
    """Read a state. Collective.

    Args:
        path: file that `write` has written, on these ranks or on others.
        subject: by what the problem is recognised that it is for.
        like: state with the structure that is wanted; its values are not read.
        attributes: names of further attributes.
        equal: names of vectors of ranks that are equal on all ranks; others add up.
        infinite: names, up to digits at their ends, of tables that may have infinite values.

    Returns:
        The state, with values of its own, and all attributes by name.

    Raises:
        RuntimeError: the file cannot be read, or is damaged; on all ranks.
        ValueError: the file belongs to another problem, or has values that no state has; on all ranks.
    """
    signature, supports = subject.identity()
    advice = {name: CHANGED_LOAD for name in signature if name.startswith("loads[")}
    return _cpp.files.read(
        str(Path(path)), subject.space._cpp_object, like, signature, supports, advice, list(attributes), list(equal),
        list(infinite),
    )  # fmt: skip


def _plain(values: Mapping[str, Attribute]) -> dict[str, Attribute]:
    """Values as texts, ints, floats and arrays of floats."""
    out: dict[str, Attribute] = {}
    for name, value in values.items():
        plain = value.item() if isinstance(value, np.generic) else value
        out[name] = plain if isinstance(plain, str | int | float) else np.ascontiguousarray(plain, dtype=float)
    return out
