# SPDX-License-Identifier: MIT
"""Load steps with cut-back, as in seed figure 3.5: increment, changes of contact, equilibrium iterations."""

import logging
from dataclasses import dataclass, field

import numpy as np

LOG = logging.getLogger("dolfinx_impact")
SAME = 1e-3  # of a residual, of a state that has come again


@dataclass
class Increment:
    """Iterations of one attempt at an increment."""

    fault: str = "not finished"
    hopeless: bool = False  # a smaller increment would not help
    advice: str = "Apply the load in smaller parts, or pass more iterations"
    residual_norms: list = field(default_factory=list)
    active_set_sizes: list = field(default_factory=list)
    changes: list = field(default_factory=list)
    iterations: int = 0  # linear problems, each with its contact settled
    unsettled: int = 0  # those whose contact was not settled in the end

    def add(self, norm, size, changes):
        self.residual_norms.append(norm)
        self.active_set_sizes.append(size)
        self.changes.append(changes)

    def converged(self):
        self.fault = ""
        return self

    def failed(self, fault, hopeless=False, advice=None):
        self.fault, self.hopeless = fault, hopeless
        if advice is not None:
            self.advice = advice
        return self

    def cycle(self):
        """After how many iterations the same state has come again, the last three times; 0: it has not."""
        for period in (2, 3):
            norms, sizes = self.residual_norms[-3 * period :], self.active_set_sizes[-3 * period :]
            if len(norms) < 3 * period:
                continue
            norms, sizes = np.reshape(norms, (3, period)), np.reshape(sizes, (3, period))
            same = np.abs(norms - norms[-1]) <= SAME * norms[-1]
            if np.all(same) and np.all(sizes == sizes[-1]) and np.ptp(norms[-1]) > SAME * norms[-1].max():
                return period
        return 0


@dataclass
class Report:
    """What a solve did; lists have one entry per converged increment.

    Attributes:
        converged: of all steps. iterations: Newton iterations (linearised problems, each with its contact settled).
        residual_norms: lists of the norms of the free residual by iteration [F].
        active_set_sizes: lists of the number of contact points that touch, by iteration.
        contact_changes: lists of the number of points whose state changed, by iteration.
        fractions: of the whole way, reached at the end of each increment.
        cut_backs: increments that were halved. rejected_iterations: what each of them had taken until then.
        unsettled: by increment, iterations whose contact states went to and fro on the linear problem until the changes
        were stopped; the iterations after them have settled it.
        seconds: this rank's, dict of "bodies" (residual, stiffness), "contact" (search, integrals, assembly, states),
        "linear" (condensation, preconditioner, solution).
    """

    converged: bool = True
    iterations: list = field(default_factory=list)
    residual_norms: list = field(default_factory=list)
    active_set_sizes: list = field(default_factory=list)
    contact_changes: list = field(default_factory=list)
    fractions: list = field(default_factory=list)
    cut_backs: int = 0
    rejected_iterations: list = field(default_factory=list)
    unsettled: list = field(default_factory=list)
    seconds: dict = field(default_factory=dict)

    def __str__(self):
        end = "converged" if self.converged else "did not converge"
        steps = f"{len(self.fractions)} increments, {sum(self.iterations)} iterations"
        return (
            f"Report: {end}, {steps}, cut back {self.cut_backs} times" if self.cut_backs else f"Report: {end}, {steps}"
        )

    def add(self, increment, fraction):
        self.iterations.append(increment.iterations)
        self.residual_norms.append(increment.residual_norms)
        self.active_set_sizes.append(increment.active_set_sizes)
        self.contact_changes.append(increment.changes)
        self.unsettled.append(increment.unsettled)
        self.fractions.append(fraction)

    def table(self):
        """The steps as text: fraction reached, iterations, changes of contact, points in contact, last residual."""
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


class _Log:
    """Lines on rank 0, to the log and, if asked for, to the screen."""

    def __init__(self, comm, verbose):
        self.rank, self.verbose = comm.rank, verbose

    def __call__(self, text):
        if self.rank == 0:
            LOG.info(text)
            if self.verbose:
                print(text, flush=True)

    def iteration(self, i, norm, scale, size, changes):
        relative = f"{norm / scale:.2e}" if scale > 0 else "0"
        self(f"  iteration {i:2d}: residual {norm:.3e} (relative {relative}), {size} in contact, {changes} changed")


class _Path:
    """From the state that was reached to the present values of loads, boundary values and obstacles."""

    def __init__(self, problem):
        self.problem = problem
        self.start = problem.u.x.array.copy()
        target = problem.u.copy()
        for bc in problem.bcs:
            bc.set(target.x.array)
        target.x.scatter_forward()
        self.target = target.x.array.copy()
        # A load of the user's own may have nothing to ramp: it acts in full from the first increment.
        ramped = [load for load in problem.loads if hasattr(load, "ramps")]
        self.loads = [(c, reached) for load in ramped for c, reached in load.ramps()]
        self.load_ends = [np.array(c.value) for c, _ in self.loads]
        self.obstacles = [c for c in problem.contact if c.pair.rigid]
        self.obstacle_starts = [c.displacement.copy() for c in self.obstacles]
        self.obstacle_ends = [c.pair.rigid_master.displacement for c in self.obstacles]

    def values(self, fraction):
        """Prescribed displacements at a fraction (an array over all dofs, prescribed entries count)."""
        return self.target if fraction == 1.0 else self.start + fraction * (self.target - self.start)

    def apply(self, fraction):
        """Set loads; returns the displacements of the obstacles."""
        for (constant, reached), end in zip(self.loads, self.load_ends):
            constant.value = reached + fraction * (end - reached)
        return [a + fraction * (b - a) for a, b in zip(self.obstacle_starts, self.obstacle_ends)]

    def finish(self, fraction):
        """What was reached is where the next solve starts; the users' values come back."""
        for (constant, reached), end in zip(self.loads, self.load_ends):
            reached[...] = reached + fraction * (end - reached)
            constant.value = end


def _back(problem, good, states):
    """Displacements and contacts as they were when the increment began."""
    problem.u.x.array[:] = good
    for contact, state in zip(problem.contact, states):
        contact.restore_state(state)


def run_steps(problem, solver, steps, cut_backs, verbose):
    """The loop of StaticProblem.solve."""
    report, log, path = Report(), _Log(problem.space.mesh.comm, verbose), _Path(problem)
    width, done, halved = 1.0 / steps, 0.0, 0
    good = problem.u.x.array.copy()
    while done < 1.0 - 1e-12:
        fraction = min(done + width, 1.0)
        if fraction <= done:
            path.finish(done)
            raise RuntimeError(f"increments of {width:.1e} of the way are round-off: ask for fewer cut_backs")
        if fraction > 1.0 - 1e-9:
            fraction = 1.0
        log(f"increment {len(report.iterations) + 1}: to {fraction:.4f} of the way")
        states = [c.save_state() for c in problem.contact]
        displacements = iter(path.apply(fraction))
        target = path.values(fraction)
        for contact in problem.contact:
            contact.begin_step(problem.u.x.array, next(displacements) if contact.pair.rigid else None, target)
        try:
            increment = solver.run(target, log)
        except BaseException:  # Ctrl-C, a user's function: what counts is the last converged state
            _back(problem, good, states)
            path.finish(done)
            raise
        if not increment.fault:
            overlaps = [text for text in [c.prescribed_overlap() for c in problem.contact] if text]
            if overlaps:
                increment.failed("; ".join(overlaps), hopeless=True)
        if not increment.fault:
            for contact in problem.contact:
                contact.accept_step()
            report.add(increment, fraction)
            good, done = problem.u.x.array.copy(), fraction
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
    report.seconds = solver.seconds
    log(report.table())
    return report
