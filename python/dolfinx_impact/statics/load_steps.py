# SPDX-License-Identifier: MIT
"""Load steps of cpp/dolfinx_impact/solve/LoadSteps.h: their log, their recorders and their report."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Protocol

from dolfinx.fem import FunctionSpace
from mpi4py import MPI

from .. import _cpp
from ..amplitude import is_in_time
from ..common.interrupts import Interrupts
from ..common.messages import inform, warn
from ..common.types import FloatArray
from .progress import SolveProgress

if TYPE_CHECKING:
    from .load_step_recorder import LoadStepRecorder


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
        brought_together: bodies that were apart and were moved together before an increment: how far, along which
            direction, which contacts are closed then.
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
    brought_together: list[str] = field(default_factory=list)
    seconds: dict[str, float] = field(default_factory=dict)

    def __str__(self) -> str:
        end = "converged" if self.converged else "did not converge"
        steps = f"{len(self.fractions)} increments, {sum(self.iterations)} iterations"
        return (
            f"Report: {end}, {steps}, cut back {self.cut_backs} times" if self.cut_backs else f"Report: {end}, {steps}"
        )

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
            inform(text)
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


#: A `solve` of C++: of StaticProblem, or of a problem that has one.
SolveInCpp = Callable[..., _cpp.solve.LoadStepReport]


class LoadedProblem(Protocol):
    """What is applied in steps.

    Attributes:
        space: displacement space.
        recorders: recorders that write during a solve.
        angles: rotation vectors of rigid masters that turn as prescribed, by number of the contact: at the present part
            of a load step, and of the last solve, (3) [1].
    """

    space: FunctionSpace
    angles: dict[int, tuple[FloatArray, FloatArray]]
    recorders: list[LoadStepRecorder]

    @property
    def contact(self) -> Sequence[Any]: ...

    @property
    def _cpp_object(self) -> _cpp.problems.StaticProblem:
        """The problem in C++."""


@dataclass(frozen=True)
class Limits:
    """How far a solve goes.

    Attributes:
        steps: number of equal increments [1].
        cut_backs: largest number of times that the increment is halved; None: as C++ chooses [1].
        rtol: relative tolerance, as in StaticProblem.solve; -snes_rtol takes precedence [1].
        atol: absolute tolerance, as in StaticProblem.solve; -snes_atol takes precedence [F].
        max_iterations: largest number of iterations; -snes_max_it takes precedence [1].
    """

    steps: int
    cut_backs: int | None
    rtol: float
    atol: float
    max_iterations: int


def run_steps(
    problem: LoadedProblem,
    solve: SolveInCpp,
    limits: Limits,
    interrupts: Interrupts,
    verbose: bool,
    progress: bool = False,
) -> Report:
    """Solve all increments of a load step. Collective.

    Args:
        problem: loads, supports and contacts.
        solve: function of the problem in C++, or of one that has it.
        limits: how far the solve goes.
        interrupts: interrupts, checked in every iteration.
        verbose: whether iterations are printed on the terminal.
        progress: whether a solve that takes long says from time to time how far it is.

    Returns:
        Report.

    Raises:
        RuntimeError: an increment did not converge; the problem is in its last converged state.
        ValueError: options that PETSc does not take.
    """
    log = StepLog(problem.space.mesh.comm, verbose, progress)

    def iteration(i: int, norm: float, scale: float, size: int, changes: int) -> None:
        log.iteration(i, norm, scale, size, changes)
        interrupts.check()

    accepted = _begin(problem)
    found = solve(
        limits.steps, limits.rtol, limits.atol, limits.max_iterations, limits.cut_backs, log=log,
        progress=log.progress.show, iteration=iteration, begins=log.progress.begin, accepted=accepted,
    )  # fmt: skip
    return _report(problem, found, log)


def _begin(problem: LoadedProblem) -> Callable[[float], None]:
    """Tell the obstacles where they go, and recorders that a solve begins.

    Returns:
        Function that is called with the fraction that is reached after every converged increment.
    """
    for k, contact in enumerate(problem.contact):
        if contact.pair.rigid:
            there = [float(value) for value in contact.pair.rigid_master.displacement]
            problem._cpp_object.move_obstacle(k, there)
            if (contact.pair.rigid_master.angle is not None) != (k in problem.angles):
                raise ValueError(
                    f"{contact.pair.name}: give the rigid master its angle, (0, 0, 0) for a start, before the problem "
                    "is made, and do not take it away"
                )
    for k, (angle, _) in problem.angles.items():
        given = problem.contact[k].pair.rigid_master.angle
        if is_in_time(given):
            raise ValueError(
                f"{problem.contact[k].pair.name}: the angle of the rigid master is a function of time: static problems "
                "take a vector"
            )
        angle[:] = given
    for recorder in problem.recorders:
        recorder.begin()

    def accepted(fraction: float) -> None:
        for recorder in problem.recorders:
            recorder.after(fraction)

    return accepted


def _report(problem: LoadedProblem, found: _cpp.solve.LoadStepReport, log: StepLog) -> Report:
    """What a solve has found, for users; warns of contacts that were lost."""
    if problem.space.mesh.comm.rank == 0:
        for moved in found.brought_together:
            warn(moved)
    if found.lost and problem.space.mesh.comm.rank == 0:
        warn(f"contacts that were closed carry no force at the end of the solve: {'; '.join(found.lost)}")
    report = Report(
        iterations=found.iterations, residual_norms=found.residual_norms, active_set_sizes=found.active_set_sizes,
        contact_changes=found.contact_changes, fractions=found.fractions, cut_backs=found.cut_backs,
        rejected_iterations=found.rejected_iterations, unsettled=found.unsettled, seconds=found.seconds,
        brought_together=found.brought_together,
    )  # fmt: skip
    log(report.table())
    return report
