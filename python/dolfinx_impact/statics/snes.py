# SPDX-License-Identifier: MIT
"""PETSc's SNES for a StaticProblem: tolerances, monitors and other nonlinear methods by options with its prefix.

The package's own method (newton.py), which updates active sets, is SNES's type "python". Without contact and with
penalty contact the equations are smooth enough for other types: -snes_type newtontr, ngmres, ...
"""

from __future__ import annotations

from collections.abc import Callable
from types import TracebackType
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from petsc4py import PETSc

from .. import _cpp
from ..common.collective import attempt, is_common
from ..common.interrupts import Interrupts
from ..common.types import FloatArray
from .newton import Newton
from .load_steps import StepLog

if TYPE_CHECKING:
    from .equilibrium_problem import EquilibriumProblem

LINEAR_STEP = 1e-3  # relative tolerance of the linear step to prescribed values
OWN = "python"  # SNES's type of methods that are not PETSc's

T = TypeVar("T")


class Solver:
    """Solves the increments of a problem by the SNES that its options choose.

    Args:
        problem: problem; options are read with the prefix of its linear solver.
        rtol: relative tolerance, as in StaticProblem.solve; -snes_rtol takes precedence [1].
        atol: absolute tolerance, as in StaticProblem.solve; -snes_atol takes precedence [F].
        max_iterations: largest number of iterations; -snes_max_it takes precedence [1].
        interrupts: interrupts, checked in every iteration.

    Attributes:
        snes: PETSc's solver.

    Raises:
        ValueError: PETSc rejects the options, or a problem with multipliers has another method than the package's own.
    """

    def __init__(
        self, problem: EquilibriumProblem, rtol: float, atol: float, max_iterations: int, interrupts: Interrupts
    ) -> None:
        self.problem, self._interrupts, space = problem, interrupts, problem.space
        self.snes = PETSc.SNES().create(space.mesh.comm)
        self.snes.setOptionsPrefix(problem.linear_solver.ksp.getOptionsPrefix())
        self.snes.setType(OWN)
        self.snes.setPythonContext(self)
        self.snes.setTolerances(rtol=rtol, atol=atol, stol=0.0, max_it=max_iterations)
        self._F, self._x = (PETSc.Vec().create(space.mesh.comm) for _ in range(2))
        for vector in (self._F, self._x):
            vector.setSizes((problem.num_owned, None))
            vector.setUp()
        self.snes.setFunction(self._function, self._F)
        self._J: PETSc.Mat | None = None
        self._changes = 0  # of contact status since the last increment was reported
        try:
            self.snes.setFromOptions()
        except PETSc.Error as error:
            self.free()
            said = " ".join(str(error).split("[0]")[-1].split())
            raise ValueError(f"PETSc does not take the options of SNES: {said}") from error
        self._rtol, self._atol, self._stol, self._max_it = self.snes.getTolerances()
        self._newton = Newton(problem, self._rtol, self._atol, self._max_it, self._tell)
        kind = self.snes.getType()
        if kind != OWN and self._newton.multipliers:
            self.free()
            raise ValueError(
                f"snes_type is {kind!r}: Lagrange multipliers need the package's own method, snes_type {OWN!r}; "
                "or take Penalty"
            )

    def __enter__(self) -> Solver:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        # PETSc's objects are destroyed by all ranks together: after an error of one rank the garbage collector does it.
        if is_common(self.problem.space.mesh.comm, error):
            self.free()

    @property
    def equilibrium(self) -> _cpp.solve.EquilibriumProblem:
        """The problem as C++ sees it."""
        return self._newton.equilibrium

    @property
    def seconds(self) -> dict[str, float]:
        """Time spent on this rank by part, as in Newton [s]."""
        return self._newton.seconds

    def forget(self) -> None:
        """Forget what was kept from earlier increments, start vectors and places of matrices. Collective."""
        seconds = self.seconds
        self._newton = Newton(self.problem, self._rtol, self._atol, self._max_it, self._tell)
        self._newton.seconds = seconds
        if self._J is not None:
            self._J.destroy()
            self._J = None
            self.snes.getKSP().reset()

    def free(self) -> None:
        """Destroy PETSc's objects. Collective."""
        for thing in (self.snes, self._F, self._x, *([self._J] if self._J else [])):
            thing.destroy()

    def run(self, target: FloatArray, log: StepLog) -> _cpp.solve.Increment:
        """Solve from the present u to prescribed values. Collective.

        Args:
            target: displacements over all degrees of freedom, of which only prescribed entries are used [L].
            log: log of the iterations.

        Returns:
            Increment; its `fault` says why it did not converge.
        """
        if self.snes.getType() != OWN:
            return self._run_other(target, log)
        self._target, self._log = target, log
        self._copy_from_u()
        self._result = _cpp.solve.Increment()
        self._fault: BaseException | None = None
        self.snes.solve(None, self._x)
        if self._fault is not None:
            raise self._fault
        return self._result

    # --- the package's own method: PETSc calls this ------------------------------------------------------------------

    def solve(self, snes: PETSc.SNES, _: PETSc.Vec | None, x: PETSc.Vec) -> None:
        """Solve for SNES's type "python", which calls this method. Collective.

        Args:
            snes: PETSc's solver.
            _: right-hand side, not used.
            x: displacements over owned degrees of freedom; overwritten [L].
        """
        reasons = PETSc.SNES.ConvergedReason
        # PETSc replaces exceptions that pass through it, so that they are kept here.
        self._result, self._fault = attempt(self._newton.run, self._target, self._log)
        if self._fault is not None:
            snes.setConvergedReason(reasons.DIVERGED_FUNCTION_DOMAIN)
            return
        x.array[:] = self.problem.u.x.array[: self.problem.num_owned]
        snes.setIterationNumber(self._result.iterations)
        snes.setConvergedReason(reasons.DIVERGED_MAX_IT if self._result.fault else reasons.CONVERGED_FNORM_RELATIVE)

    def _tell(self, iteration: int, norm: float) -> None:
        self.snes.monitor(iteration, norm)
        self._interrupts.check()

    # --- PETSc's methods ----------------------------------------------------------------------------------------------

    def _copy_from_u(self) -> None:
        self._x.array[:] = self.problem.u.x.array[: self.problem.num_owned]

    def _copy_to_u(self, x: PETSc.Vec) -> None:
        u = self.problem.u.x
        u.array[: self.problem.num_owned] = x.array_r
        u.scatter_forward()

    def _residual(self) -> tuple[FloatArray, int]:
        """Internal minus external and contact forces at u, over owned degrees of freedom [F], and number of changes of
        contact status. Collective."""
        p, changes = self.problem, 0
        b = self.equilibrium.body.residual()
        for contact in p.contact:
            contact.update_gap(p.u.x.array)
            contact.add_residual(b)
            changes += contact.update_active_set(False)
        return b.array.copy(), changes

    def _solve_by_petsc(self) -> None:
        """Call snes.solve, and raise exceptions of functions that PETSc calls unchanged. Collective."""
        self._fault = None
        try:
            self.snes.solve(None, self._x)
        except PETSc.Error:
            if self._fault is not None:
                raise self._fault from None
            raise

    def _kept(self, work: Callable[..., T], *args: Any) -> T:
        """Call a function on behalf of PETSc, and keep its exception for `_solve_by_petsc`."""
        try:
            return work(*args)
        except BaseException as error:
            self._fault = error
            raise

    def _function(self, snes: PETSc.SNES, x: PETSc.Vec, F: PETSc.Vec) -> None:
        self._kept(self._evaluate, x, F)

    def _evaluate(self, x: PETSc.Vec, F: PETSc.Vec) -> None:
        self._interrupts.check()
        self._copy_to_u(x)
        residual, changes = self._residual()
        residual[self._newton.fixed] = 0.0  # prescribed values are there already
        F.array[:] = residual
        self._changes += changes

    def _jacobian(self, snes: PETSc.SNES, x: PETSc.Vec, J: PETSc.Mat, P: PETSc.Mat) -> None:
        self._kept(self._linearise, snes, x, J)

    def _linearise(self, snes: PETSc.SNES, x: PETSc.Vec, J: PETSc.Mat) -> None:
        """Assemble the tangent at x, which need not be where PETSc has evaluated the function last. Collective."""
        self._copy_to_u(x)
        self._residual()
        K = self.equilibrium.body.tangent()
        diagonal = K.getDiagonal()
        J.zeroEntries()
        J.axpy(1.0, K, PETSc.Mat.Structure.SUBSET_NONZERO_PATTERN)
        for contact in self.problem.contact:
            J.axpy(1.0, contact.tangent(), PETSc.Mat.Structure.DIFFERENT_NONZERO_PATTERN)
        rows = J.getOwnershipRange()[0] + self._newton.fixed.astype(np.int32)
        J.zeroRowsColumns(rows, diagonal.sum() / diagonal.getSize() or 1.0)
        diagonal.destroy()
        if self.problem.contact:  # PETSc does not always notice that the sparsity pattern has changed
            snes.getKSP().getPC().reset()
        self.problem.linear_solver.set_near_nullspace(J)

    def _run_other(self, target: FloatArray, log: StepLog) -> _cpp.solve.Increment:
        """Solve an increment by a method of PETSc's: a linear step to the prescribed values, then its iterations.

        Arguments and result are those of `run`. Collective.
        """
        p, newton, result = self.problem, self._newton, _cpp.solve.Increment()
        residual, self._changes = self._residual()
        K = self.equilibrium.body.tangent()
        loose = newton.unconstrained_modes(K) if p.contact else ""
        if loose:
            return result.failed(loose, hopeless=True)
        if self._J is None:
            self._J = K.copy()
            self._J.setOption(PETSc.Mat.Option.KEEP_NONZERO_PATTERN, True)
            self.snes.setJacobian(self._jacobian, self._J)
        scale = max(newton.norm(residual), newton.tangent_force(K))
        jump = target[newton.fixed] - p.u.x.array[newton.fixed]
        fault = newton.solve_linearised(K, residual, jump, LINEAR_STEP)
        if fault:
            return result.failed(f"the linear solver failed ({fault}): is the body held against rigid motion?")
        p.u.x.array[p.fixed] = target[p.fixed]
        while True:
            residual, _ = self._residual()  # with the support forces of the linear step
            scale = max(scale, newton.norm(residual), newton.tangent_force(K))
            tolerance = max(self._atol, newton.round_off(K), self._rtol * scale)
            self.snes.setTolerances(rtol=0.0, atol=tolerance, stol=self._stol, max_it=self._max_it)
            self.snes.setConvergenceHistory(length=1000, reset=True)
            self._copy_from_u()
            self._solve_by_petsc()
            self._copy_to_u(self._x)
            self._residual()
            norms = self.snes.getConvergenceHistory()[0]
            size = sum(c.num_active for c in p.contact)
            for iteration, norm in enumerate(norms):
                result.add(float(norm), size, self._changes if iteration == len(norms) - 1 else 0)
                log.iteration(iteration, norm, scale, size, result.changes[-1])
            self._changes = 0
            result.iterations += self.snes.getIterationNumber()
            unsolved = self.equilibrium.body.fault()
            if unsolved:
                return result.failed(unsolved)
            reason = self.snes.getConvergedReason()
            if reason < 0:
                return result.failed(f"SNES of type {self.snes.getType()} did not converge: PETSc reason {reason}")
            again = any([c.augment() for c in p.contact])
            faults = [c.fault for c in p.contact if c.fault]
            if faults:
                return result.failed("; ".join(faults), hopeless=True)
            if not again:
                if not newton.fields_balance(K, self.equilibrium.body.residual().array.copy()):
                    return result.failed(
                        f"SNES of type {self.snes.getType()} has converged in one norm of all fields, in which the "
                        "equation of one does not hold yet: take the package's own method (leave out snes_type)",
                        hopeless=True,
                    )
                bodies = self.equilibrium.body.residual().array.copy()
                missing = _cpp.solve.out_of_balance(newton.equilibrium, bodies, max(tolerance, float(norms[-1])))
                if missing:
                    return result.failed(missing, hopeless=True)
                result.iterations += 1  # the linear step to the prescribed values
                return result.converged()
