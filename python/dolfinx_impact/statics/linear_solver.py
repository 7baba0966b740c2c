# SPDX-License-Identifier: MIT
"""PETSc linear solvers for the problems: chosen by size, factors kept while they serve, every solution checked."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from dolfinx.fem import FunctionSpace
from mpi4py import MPI
from petsc4py import PETSc

from .. import _cpp
from ..common.described import Described
from ..common.memory import free_garbage

LIMITS = _cpp.solve.LinearSolverLimits()
"""Which systems are factorised; solvers that are made take over its present values."""


class LinearSolver(Described):
    """A KSP with options of its own: cpp/dolfinx_impact/solve/LinearSolver.h.

    Args:
        V: displacement space.
        options: PETSc options without prefix; None chooses by size.
        prefix: options of the command line that begin with it override `options`; a number is added to it, so that
            the options of one problem are not those of the next.
        indefinite: the systems are saddle points: a direct solver is the default at any size.
        limits: which systems are factorised, and how long factors are kept.

    Raises:
        ValueError: options that PETSc does not take, or that choose an iterative solver for saddle points.
    """

    def __init__(
        self,
        V: FunctionSpace,
        options: Mapping[str, Any] | None,
        prefix: str,
        indefinite: bool = False,
        limits: _cpp.solve.LinearSolverLimits = LIMITS,
    ) -> None:
        make_room(V)
        warn = warnings_on(V.mesh.comm)
        self._cpp_object = _cpp.solve.LinearSolver(
            V._cpp_object, petsc_options(options), prefix, indefinite, limits, warn
        )

    @classmethod
    def of(cls, solver: _cpp.solve.LinearSolver) -> LinearSolver:
        """A view of a solver that a problem in C++ has.

        Args:
            solver: the solver.
        """
        view = cls.__new__(cls)
        view._cpp_object = solver
        return view

    @property
    def ksp(self) -> PETSc.KSP:
        """PETSc's solver."""
        return self._cpp_object.ksp

    @property
    def prefix(self) -> str:
        """Prefix of its options in PETSc's database."""
        return self._cpp_object.prefix

    @property
    def direct(self) -> bool:
        """Whether it factorises."""
        return self._cpp_object.direct

    @property
    def num_set_ups(self) -> int:
        """Number of preconditioners made so far."""
        return self._cpp_object.num_set_ups

    @property
    def num_iterations(self) -> int:
        """Number of iterations of all solutions."""
        return self._cpp_object.num_iterations

    @property
    def factors(self) -> PETSc.Mat | None:
        """Factors of the system that was factorised last; None if there are none."""
        return self._cpp_object.factors

    @property
    def null_pivots(self) -> int:
        """Number of pivots of these factors that are round-off: motions that nothing resists."""
        return self._cpp_object.null_pivots

    def set_up(self, system: _cpp.solve.LinearSystem) -> None:
        """Make the preconditioner of a system now: the next solution does not look for an earlier one. Collective.

        Args:
            system: the system.
        """
        self._cpp_object.set_up(system)

    def reset(self) -> None:
        """Forget the preconditioner and give back its memory: the next solution does not depend on earlier systems.
        Collective."""
        self._cpp_object.reset()

    def solve(self, system: _cpp.solve.LinearSystem, b: PETSc.Vec, x: PETSc.Vec, rtol: float = 1e-10) -> str | None:
        """Solve a linear system. Collective.

        Args:
            system: the system.
            b: right-hand side.
            x: a guess; becomes the solution.
            rtol: tolerance of the residual, if the options do not set one [1].

        Returns:
            What is wrong with the solution, or None.
        """
        return self._cpp_object.solve(system, b, x, rtol) or None

    def set_near_nullspace(self, A: PETSc.Mat) -> None:
        """Attach the rigid body modes to a matrix as its near null space, if preconditioners need them. Collective.

        Args:
            A: the matrix.
        """
        self._cpp_object.set_near_nullspace(A)

    def warn_of_unused(self) -> None:
        """Warn, once and on rank 0, of given options that PETSc has not read in a solution."""
        self._cpp_object.warn_of_unused()


def make_room(V: FunctionSpace) -> None:
    """Free what earlier problems have left where a new one takes much. Collective.

    Args:
        V: displacement space.
    """
    free_garbage(V.mesh.comm, V.dofmap.index_map.size_global * V.dofmap.index_map_bs)


def petsc_options(options: Mapping[str, Any] | None) -> dict[str, str]:
    """Options as PETSc reads them.

    Args:
        options: options by name, without prefix; None: none.
    """
    return {key: _as_text(value) for key, value in (options or {}).items()}


def warnings_on(comm: MPI.Comm) -> Callable[[str], None]:
    """A function that warns on rank 0.

    Args:
        comm: communicator of the problem.
    """
    return partial(_warn, comm.rank)


def _warn(rank: int, text: str) -> None:
    if rank == 0:
        warnings.warn(text, stacklevel=4)


def _as_text(value: Any) -> str:
    """A value of an option as PETSc reads it; empty: the option has none."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, (list, tuple)):
        return ",".join(str(v) for v in value)
    return str(value)
