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
from ..assembly.history import MaterialHistory
from ..common.types import BoolArray, FloatArray, IntArray
from ..contact.saved_contacts import add_contacts, resume_contacts
from ..io import checkpoints
from ..io.checkpoint import Subject, without_nodes
from ..io.checkpoints import Checkpoints, Place, State, number
from ..io.given_arguments import GivenArguments
from ..io.signature import Signature
from ..materials import MaterialMap, _Material
from .linear_solver import LinearSolver


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
        linear_solver: solver of the linear systems.
        solves: how far the problem has come.
    """

    u: Function
    space: FunctionSpace
    material: _Material | MaterialMap | None
    residual_form: ufl.Form | None
    axisymmetric: bool
    fixed: BoolArray
    num_owned: int
    linear_solver: LinearSolver
    solves: Solves

    @property
    def loads(self) -> Sequence[Any]:
        """Loads."""

    @property
    def contact(self) -> Sequence[Any]:
        """Contacts with their results."""

    @property
    def has_history(self) -> bool:
        """Whether a material has internal variables."""

    @property
    def history(self) -> MaterialHistory:
        """Internal variables of the materials."""


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
        """Displacement and loads are views."""
        p = self.problem
        out = State("static problem")
        u = p.u.x.array[: p.num_owned].reshape(-1, p.space.dofmap.index_map_bs)
        out.add("displacement", Place.node, u)
        checkpoints.add_numbers(out, signs_are_checked=int(p.solves.signs_are_checked))
        checkpoints.add_history(out, p)
        reached = State("reached")  # values of loads that the last solve has reached
        for k, load in enumerate(p.loads):
            # A load of a user's own class without `ramps` acts in full from the first increment.
            for i, (_, value) in enumerate(load.ramps() if hasattr(load, "ramps") else ()):
                reached.add(f"load {k}, {i}", Place.all, value.reshape(-1))
        out.add(reached)
        add_contacts(out, p.contact)
        return out

    def _apply(self, saved: _cpp.state.State, attributes: Mapping[str, Any], checked: Any) -> None:
        p, now = self.problem, self._state()
        now.part("reached").assign(saved.part("reached"))
        p.u.x.array[: p.num_owned] = saved.array("displacement").ravel()
        p.u.x.scatter_forward()
        checkpoints.set_history(saved, p)
        resume_contacts(saved, p.contact, p.u.x.array)
        p.solves.signs_are_checked = bool(number(saved, "signs_are_checked"))

    def _forget(self) -> None:
        """Factors, candidates of the search."""
        self.problem.linear_solver.reset()
        for contact in self.problem.contact:
            contact.forget()
