# SPDX-License-Identifier: MIT
"""Saving and restoring static problems."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import ufl
from dolfinx.fem import Function, FunctionSpace

from .. import _cpp
from ..common.types import BoolArray, FloatArray, IntArray
from ..io import checkpoints
from ..io.checkpoint import Subject, without_nodes
from ..io.checkpoints import Checkpoints, number
from ..io.given_arguments import GivenArguments
from ..io.signature import Signature
from ..materials import MaterialMap, _Material


@dataclass
class Solves:
    """How far a static problem has come.

    Attributes:
        signs_are_checked: whether the signs of a residual of a user's own have been looked at, in the state of the
            first solve.
        under_way: whether a solve is under way.
    """

    signs_are_checked: bool
    under_way: bool = False


class SavedStatics(Protocol):
    """A static problem as checkpoints see it.

    Attributes:
        u: displacement [L].
        space: displacement space.
        material: material of the bodies; None with a residual of the user's own.
        residual_form: that residual, or None.
        axisymmetric: whether x is the radius.
        fixed: mask of prescribed degrees of freedom, owned and ghosts.
        num_owned: number of degrees of freedom that this rank owns [1].
        solves: how far the problem has come.
    """

    u: Function
    space: FunctionSpace
    material: _Material | MaterialMap | None
    residual_form: ufl.Form | None
    axisymmetric: bool
    fixed: BoolArray
    num_owned: int
    solves: Solves

    @property
    def loads(self) -> Sequence[Any]: ...

    @property
    def contact(self) -> Sequence[Any]: ...

    @property
    def _cpp_object(self) -> _cpp.problems.StaticProblem:
        """The problem in C++."""


class StaticRestart(Checkpoints):
    """Saves and restores a static problem; see StaticProblem.save and restore.

    Args:
        problem: the problem.
    """

    def __init__(self, problem: SavedStatics) -> None:
        super().__init__(Subject(problem.space, self._signature, self._supports))
        self.problem = problem

    def _signature(self, x: FloatArray) -> Signature:
        """Signature: what the problem was made of, but no values that a solve leads to. Collective."""
        p = self.problem
        given = GivenArguments(p.space.mesh, (p.u,))
        given.table["problem"] = type(p).__name__
        given.add_mesh(p.space)
        given.table["hypothesis"] = "axisymmetric" if p.axisymmetric else "not axisymmetric"
        if p.material is not None:
            given.add_material("material", p.material)
        else:
            given.add("residual", p.residual_form, numbers=False)
        given.table["loads"] = ", ".join(type(load).__name__ for load in p.loads)
        for k, load in enumerate(p.loads):
            given.add_load(f"loads[{k}]", load, numbers=False)
        given.table["contact"] = ", ".join(contact.kind for contact in p.contact)
        for k, contact in enumerate(p.contact):
            of_pair = contact.options, contact.pair, contact.facets()
            given.add_contact(f"contact[{k}]", contact.kind, *of_pair, places=False)
        return given.table

    def _supports(self) -> tuple[IntArray, FloatArray]:
        """Prescribed degrees of freedom, as of problems in time, but without their values."""
        bs = self.problem.space.dofmap.index_map_bs
        fixed = self.problem.fixed[: self.problem.num_owned].reshape(-1, bs)
        nodes = np.flatnonzero(fixed.any(axis=1))
        none = np.zeros((len(nodes), bs))
        return nodes, np.hstack([fixed[nodes].astype(float), none, none - 1.0])

    def _check_kind(self, call: str) -> None:
        if self.problem.solves.under_way:
            raise ValueError(f"{call}: the problem is being solved: call it before or after `solve`")
        if other := without_nodes(self.problem.space):
            raise ValueError(f"{call}: checkpoints hold values at nodes, which the {other} of u does not have")

    def _recorders(self) -> tuple[()]:
        """None: load steps are written when they have converged."""
        return ()

    def _state(self) -> _cpp.state.State:
        out = self.problem._cpp_object.saved_state()
        checkpoints.add_numbers(out, signs_are_checked=int(self.problem.solves.signs_are_checked))
        return out

    def _apply(self, saved: _cpp.state.State, attributes: Mapping[str, Any], checked: Any) -> None:
        self.problem._cpp_object.resume(saved)
        self.problem.solves.signs_are_checked = bool(number(saved, "signs_are_checked"))

    def _forget(self) -> None:
        """Factors, candidates of the search."""
        self.problem._cpp_object.forget()
