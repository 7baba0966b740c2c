# SPDX-License-Identifier: MIT
"""Load steps with cut-back, as in seed figure 3.5: increment, changes of contact, equilibrium iterations."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from mpi4py import MPI

from .. import _cpp
from ..common.types import FloatArray
from .progress import SolveProgress

if TYPE_CHECKING:
    from .problem import StaticProblem

LOG = logging.getLogger("dolfinx_impact")


@dataclass
class Report:
    """Course of a solve; lists have one entry per converged increment.

    Attributes:
        converged: whether all steps have converged.
        iterations: number of Newton iterations by increment: linearised problems, each with its active set updated to
            convergence [1].
        residual_norms: norms of the free residual by increment and iteration [F].
        active_set_sizes: number of active contact points by increment and iteration [1].
        contact_changes: number of points whose status changed by increment and iteration [1].
        fractions: fraction of the load step reached at the end of each increment [1].
        cut_backs: number of increments that were halved [1].
        rejected_iterations: number of iterations of each increment that was halved [1].
        unsettled: number of iterations by increment in which the active set of the linearised problem did not converge;
            it has converged in later iterations [1].
        seconds: time spent on this rank in "bodies" (residual, stiffness), "contact" (search, integrals, assembly,
            active set) and "linear" (condensation, preconditioner, solution) [s].
    """

    converged: bool = True
    iterations: list[int] = field(default_factory=list)
    residual_norms: list[list[float]] = field(default_factory=list)
    active_set_sizes: list[list[int]] = field(default_factory=list)
    contact_changes: list[list[int]] = field(default_factory=list)
    fractions: list[float] = field(default_factory=list)
    cut_backs: int = 0
    rejected_iterations: list[int] = field(default_factory=list)
    unsettled: list[int] = field(default_factory=list)
    seconds: dict[str, float] = field(default_factory=dict)

    def __str__(self) -> str:
        end = "converged" if self.converged else "did not converge"
        steps = f"{len(self.fractions)} increments, {sum(self.iterations)} iterations"
        return (
            f"Report: {end}, {steps}, cut back {self.cut_backs} times" if self.cut_backs else f"Report: {end}, {steps}"
        )

    def add(self, increment: _cpp.solve.Increment, fraction: float) -> None:
        """Add a converged increment.

        Args:
            increment: its iterations.
            fraction: fraction of the load step reached at its end [1].
        """
        self.iterations.append(increment.iterations)
        self.residual_norms.append(increment.residual_norms)
        self.active_set_sizes.append(increment.active_set_sizes)
        self.contact_changes.append(increment.changes)
        self.unsettled.append(increment.unsettled)
        self.fractions.append(fraction)

    def table(self) -> str:
        """The increments as a text table.

        Returns:
            Lines with the fraction reached, iterations, changes of contact, points in contact and last residual.
        """
        lines = ["increment  fraction  iterations  changes  in contact  residual"]
        rows = zip(self.fractions, self.iterations, self.contact_changes, self.active_set_sizes, self.residual_norms)
        for i, (fraction, iterations, changes, sizes, norms) in enumerate(rows, 1):
            lines.append(
                f"{i:9d}  {fraction:8.4f}  {iterations:10d}  {sum(changes):7d}  {sizes[-1]:10d}  {norms[-1]:8.1e}"
            )
        if self.cut_backs:
            lines.append(f"cut back {self.cut_backs} times, after {sum(self.rejected_iterations)} iterations in all")
        if sum(self.unsettled):
            lines.append(f"contact not settled on the linear problem in {sum(self.unsettled)} iterations")
        return "\n".join([*lines, ", ".join(f"{part} {s:.2f} s" for part, s in self.seconds.items())])


class StepLog:
    """Writes lines on rank 0 to the log, and to the terminal if wanted.

    Args:
        comm: communicator of the problem.
        verbose: whether lines are printed on the terminal.
        progress: whether a solve that takes long says from time to time how far it is; not with `verbose`.

    Attributes:
        progress: lines of progress.
    """

    def __init__(self, comm: MPI.Comm, verbose: bool, progress: bool = False) -> None:
        self.rank, self.verbose = comm.rank, verbose
        self.progress = SolveProgress(comm, progress and not verbose)

    def __call__(self, text: str) -> None:
        if self.rank == 0:
            LOG.info(text)
            if self.verbose:
                print(text, flush=True)

    def iteration(self, i: int, norm: float, scale: float, size: int, changes: int) -> None:
        """Write the line of an iteration.

        Args:
            i: number of the iteration [1].
            norm: norm of the free residual [F].
            scale: force that the norm is relative to [F].
            size: number of active contact points [1].
            changes: number of points whose status changed [1].
        """
        relative = f"{norm / scale:.2e}" if scale > 0 else "0"
        self.progress.show(f"iteration {i}: residual {norm:.1e} (relative {relative}), {size} in contact")
        self(f"  iteration {i:2d}: residual {norm:.3e} (relative {relative}), {size} in contact, {changes} changed")


class LoadPath:
    """Loads, prescribed displacements and obstacles between the last solve and their present values.

    Args:
        problem: StaticProblem.
    """

    def __init__(self, problem: StaticProblem) -> None:
        self.problem = problem
        self.start = problem.u.x.array.copy()
        target = problem.u.copy()
        for bc in problem.bcs:
            bc.set(target.x.array)
        target.x.scatter_forward()
        self.target = target.x.array.copy()
        # A load of a user's own class without `ramps` acts in full from the first increment.
        ramped = [load for load in problem.loads if hasattr(load, "ramps")]
        self.loads = [(c, reached) for load in ramped for c, reached in load.ramps()]
        self.load_ends = [np.array(c.value) for c, _ in self.loads]
        self.obstacles = [c for c in problem.contact if c.pair.rigid]
        self.obstacle_starts = [c.displacement.copy() for c in self.obstacles]
        self.obstacle_ends = [c.pair.rigid_master.displacement for c in self.obstacles]

    def values(self, fraction: float) -> FloatArray:
        """Prescribed displacements at a fraction of the step.

        Args:
            fraction: fraction of the step [1].

        Returns:
            Displacements over all degrees of freedom, of which only prescribed entries are used [L].
        """
        return self.target if fraction == 1.0 else self.start + fraction * (self.target - self.start)

    def apply(self, fraction: float) -> list[FloatArray]:
        """Set the loads to a fraction of the step.

        Args:
            fraction: fraction of the step [1].

        Returns:
            Displacement of each obstacle, (3) [L].
        """
        for (constant, reached), end in zip(self.loads, self.load_ends):
            constant.value = reached + fraction * (end - reached)
        return [a + fraction * (b - a) for a, b in zip(self.obstacle_starts, self.obstacle_ends)]

    def finish(self, fraction: float) -> None:
        """Store the loads at a fraction as the start of the next solve, and set them to the user's values again.

        Args:
            fraction: fraction of the step that was reached [1].
        """
        for (constant, reached), end in zip(self.loads, self.load_ends):
            reached[...] = reached + fraction * (end - reached)
            constant.value = end


def _back(problem: StaticProblem, good: FloatArray, states: Sequence[dict[str, Any]]) -> None:
    """Restore displacements and contacts to the start of the increment."""
    problem.u.x.array[:] = good
    for contact, state in zip(problem.contact, states):
        contact.restore_state(state)


class IncrementSolver(Protocol):
    """What `run_steps` asks of a solver of increments."""

    @property
    def equilibrium(self) -> _cpp.solve.EquilibriumProblem:
        """The problem as C++ sees it."""

    @property
    def seconds(self) -> dict[str, float]:
        """Time by part [s]."""

    def run(self, target: FloatArray, log: StepLog) -> _cpp.solve.Increment:
        """Solve from the present u to prescribed values. Collective.

        Args:
            target: displacements over all degrees of freedom, of which only prescribed entries are used [L].
            log: log of the iterations.
        """
        ...


def run_steps(
    problem: StaticProblem,
    solver: IncrementSolver,
    steps: int,
    cut_backs: int,
    verbose: bool,
    progress: bool = False,
) -> Report:
    """Solve all increments of a load step. Collective.

    Args:
        problem: StaticProblem.
        solver: solver of an increment.
        steps: number of equal increments [1].
        cut_backs: largest number of times that the increment is halved [1].
        verbose: whether iterations are printed on the terminal.
        progress: whether a solve that takes long says from time to time how far it is.

    Returns:
        Report.

    Raises:
        RuntimeError: an increment did not converge; the problem is in its last converged state.
    """
    report, log, path = Report(), StepLog(problem.space.mesh.comm, verbose, progress), LoadPath(problem)
    width, done, halved = 1.0 / steps, 0.0, 0
    for recorder in problem.recorders:
        recorder.begin()
    closed = [c.num_active > 0 for c in problem.contact]
    good = problem.u.x.array.copy()
    while done < 1.0 - 1e-12:
        fraction = min(done + width, 1.0)
        if fraction <= done:
            path.finish(done)
            raise RuntimeError(f"increments of {width:.1e} of the way are round-off: ask for fewer cut_backs")
        if fraction > 1.0 - 1e-9:
            fraction = 1.0
        log(f"increment {len(report.iterations) + 1}: to {fraction:.4f} of the way")
        log.progress.begin(len(report.iterations) + 1, done, fraction)
        states = [c.save_state() for c in problem.contact]
        displacements = iter(path.apply(fraction))
        target = path.values(fraction)
        for contact in problem.contact:
            contact.begin_step(problem.u.x.array, next(displacements) if contact.pair.rigid else None, target)
        try:
            increment = solver.run(target, log)
        except BaseException:  # Ctrl-C, a user's function: return to the last converged state
            _back(problem, good, states)
            path.finish(done)
            raise
        if not increment.fault:
            overlaps = [text for text in [c.prescribed_overlap() for c in problem.contact] if text]
            if overlaps:
                increment.failed("; ".join(overlaps), hopeless=True)
        if not increment.fault:
            problem.body.accept_step()
            for contact in problem.contact:
                contact.accept_step()
            report.add(increment, fraction)
            known = increment.closed or closed
            closed = [was or at_start or c.num_active > 0 for was, at_start, c in zip(closed, known, problem.contact)]
            good, done = problem.u.x.array.copy(), fraction
            try:
                for recorder in problem.recorders:
                    recorder.after(fraction)
            except BaseException:
                path.finish(done)
                raise
            continue
        _back(problem, good, states)
        if increment.hopeless:
            path.finish(done)
            raise RuntimeError(increment.fault)
        if halved == cut_backs:
            path.finish(done)
            where = f" (reached {done:.4f} of the way)" if done > 0 else ""
            end = "" if increment.fault.endswith("?") and not where else "."
            raise RuntimeError(f"{increment.fault}{where}{end} {increment.advice}".rstrip())
        halved, width = halved + 1, width / 2
        report.cut_backs += 1
        report.rejected_iterations.append(increment.iterations)
        log(f"  cut back to increments of {width:.3e}: {increment.fault}")
    path.finish(1.0)
    lost = _cpp.solve.open_contacts(solver.equilibrium, closed)
    if lost and problem.space.mesh.comm.rank == 0:
        LOG.warning(f"contacts that were closed carry no force at the end of the solve: {'; '.join(lost)}")
    report.seconds = solver.seconds
    log(report.table())
    return report
