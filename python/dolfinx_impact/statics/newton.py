# SPDX-License-Identifier: MIT
"""Newton's method for equilibrium and contact, a view of cpp/dolfinx_impact/solve/Newton.h."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from petsc4py import PETSc

from .. import _cpp
from ..common.described import Described
from ..common.types import FloatArray, IntArray
from ..contact.mortar.lagrange import LagrangeContact
from ..contact.penalty.quadrature_penalty import QuadraturePenalty
from .load_steps import StepLog

if TYPE_CHECKING:
    from .equilibrium_problem import EquilibriumProblem


def contact_in_cpp(contact: Any) -> _cpp.enforcement.StaticContact:
    """A contact as Newton's method in C++ sees it. What derived classes may have replaced is called through Python.

    Args:
        contact: contact of a static or implicit problem.
    """
    own = type(contact) in (LagrangeContact, QuadraturePenalty)
    return contact._cpp_object if own else _cpp.solve.PythonContact(contact)


class Newton(Described):
    """Solves one increment of a problem.

    Args:
        problem: problem.
        rtol: relative tolerance of the residual, as in StaticProblem.solve [1].
        atol: absolute tolerance of the residual, as in StaticProblem.solve [F].
        max_iterations: largest number of iterations [1].
        tell: function that is called with the number of every iteration and the norm of its residual, or None.

    Attributes:
        problem: as given.
        equilibrium: the problem as C++ sees it.
    """

    def __init__(
        self,
        problem: EquilibriumProblem,
        rtol: float,
        atol: float,
        max_iterations: int,
        tell: Callable[[int, float], None] | None = None,
    ) -> None:
        self.problem, self._tell = problem, tell
        options = _cpp.solve.NewtonOptions().with_database(problem.linear_solver.prefix)
        options.rtol, options.atol, options.max_iterations = rtol, atol, max_iterations
        self.equilibrium = problem.equilibrium
        self._cpp_object = _cpp.solve.Newton(self.equilibrium, options)

    def run(self, target: FloatArray, log: StepLog) -> _cpp.solve.Increment:
        """Solve from the present u to prescribed values. Collective.

        Args:
            target: displacements over all degrees of freedom, of which only prescribed entries are used [L].
            log: log of the iterations.

        Returns:
            Increment; its `fault` says why it did not converge.
        """

        def iteration(i: int, norm: float, scale: float, size: int, changes: int) -> None:
            log.iteration(i, norm, scale, size, changes)
            if self._tell is not None:
                self._tell(i, norm)

        return self._cpp_object.run(target, log, log.progress.show, iteration)

    @property
    def seconds(self) -> dict[str, float]:
        """Time spent on this rank so far in "bodies" (residual, stiffness), "contact" (search, integrals, assembly,
        active set) and "linear" (condensation, preconditioner, solution) [s]."""
        return self._cpp_object.seconds

    @seconds.setter
    def seconds(self, values: dict[str, float]) -> None:
        self._cpp_object.seconds = values

    @property
    def fixed(self) -> IntArray:
        """Owned degrees of freedom that are prescribed."""
        return self._cpp_object.prescribed

    @property
    def multipliers(self) -> bool:
        """Whether contacts have multipliers."""
        return self._cpp_object.has_multipliers

    def solve_linearised(self, K: PETSc.Mat, residual: FloatArray, jump: FloatArray, rtol: float) -> str:
        """Solve the linearised problem with updates of its active set, and update u. Collective.

        Args:
            K: stiffness of the bodies [F/L].

        Returns:
            What went wrong; empty if nothing did.
        """
        return self._cpp_object.solve_linearised(K, residual, jump, rtol)

    def unconstrained_modes(self, K: PETSc.Mat) -> str:
        """Message about bodies that neither supports nor contacts constrain, or an empty text. Collective.

        Args:
            K: tangent of the bodies [F/L].
        """
        return self._cpp_object.unconstrained_modes(K)

    def tangent_force(self, K: PETSc.Mat) -> float:
        """Norm of the free entries of tangent times u [F]: the size of internal forces that balance each other. With
        inertia, u is the displacement of the step. Collective.

        Args:
            K: tangent of the bodies [F/L].
        """
        return self._cpp_object.tangent_force(K)

    def round_off(self, K: PETSc.Mat) -> float:
        """Norm of the round-off in the residual [F]. Collective.

        Args:
            K: tangent of the bodies [F/L].
        """
        return self._cpp_object.round_off(K)

    def fields_balance(self, K: PETSc.Mat, residual: FloatArray) -> bool:
        """Whether the equation of each field of a mixed space holds; true for others. Collective.

        Args:
            K: tangent.
            residual: residual over owned degrees of freedom.
        """
        return self._cpp_object.fields_balance(K, residual)

    def norm(self, values: FloatArray) -> float:
        """Norm of values over the owned degrees of freedom of all ranks. Collective.

        Args:
            values: values of this rank.
        """
        return self._cpp_object.norm(values)
