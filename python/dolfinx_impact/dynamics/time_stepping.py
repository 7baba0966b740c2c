# SPDX-License-Identifier: MIT
"""Marching through time: plans of equal steps, energies, what happens when a run goes unstable."""

import contextlib
import math
import warnings
import zlib
from dataclasses import dataclass

import numpy as np
from mpi4py import MPI

from . import energy_gain
from ..common.collective import agree, attempt, guard
from .history import History
from ..common.interrupts import Interrupts
from ..materials import _number
from ..common.progress import Bar

SAFETY = 0.9  # of the stable step that dt="auto" takes; contact stiffness needs the rest
CHUNK = 1000  # steps between which nothing but C++ runs
RECHECK = 500  # steps after which the stable step of a body that deforms is looked at again
SNAPSHOT = 100  # steps between states that a run that goes unstable falls back on
MOST_STEPS = 10**9  # of one call: the energies of as many steps take a hundred gigabytes
ENERGIES = ("kinetic", "internal", "contact", "friction", "impact", "damping", "viscosity", "external")


@dataclass
class Plan:
    """Equal steps from one time to another."""

    begin: float  # [T]
    until: float  # [T]
    first: int  # number of the step at `begin`
    last: int  # at `until`
    auto: bool = False  # made with dt="auto"

    @property
    def dt(self):
        return (self.until - self.begin) / (self.last - self.first)

    def times(self, steps):
        """Times of steps, numbered as the run's."""
        return np.where(steps == self.last, self.until, self.begin + (steps - self.first) * self.dt)


class March:
    """The part of ExplicitProblem that runs."""

    def _fingerprint(self):
        mesh = self.space.mesh
        return zlib.crc32(mesh.geometry.x), mesh.topology.index_map(mesh.topology.dim).size_global

    def _begin(self):
        self._mesh_then = self._fingerprint()
        self.time, self.step = 0.0, 0
        self._plan, self._good, self._recorders = None, None, []
        self._history = History(1 + self._cpp.row_size)
        self._total_start, self._known_start, self._largest = 0.0, False, 0.0
        self._warn_at, self._warned = math.inf, False
        self._safe, self._stale = self.stable_step(), False
        self._nominal = SAFETY * self._safe
        self._cpp.set_contact_step(self._nominal)
        self._cpp.start(self.u.x.array[: self.num_owned], self.velocity.x.array[: self.num_owned])
        self._run(0)
        for contact in self.contact:
            contact.check_start()
        self._look()

    # --- the loop --------------------------------------------------------------------------------------------------

    def advance(self, until, dt="auto", callback=None, progress=True, unsafe=False, energy_limits=energy_gain.LIMITS):
        """Go on to a time. Collective.

        Args:
            until: time to reach [T]. dt: step, or "auto": 0.9 of the stable step; steps are equal and at most that [T].
            callback: called as callback(problem) after each step, and before the first step of a run (at step 0). What
                it changes, constants, functions and loads of forms, holds from the time at which it is called; ghosts
                are brought up to date. progress: show a bar on rank 0.
            unsafe: take a dt beyond the stable step all the same, with a warning.
            energy_limits: two numbers, or None for no limits. The energy that the run has gained without the work of
                loads and supports, relative to the energies so far (docs/explicit/energies.md): beyond the first it
                warns, once; beyond the second it stops [1].

        Raises:
            TypeError, ValueError: a time that has passed, dt not positive, beyond the stable step, or so small that the
            time cannot be reached; energy limits that are no two positive numbers in order; arguments that differ
            between ranks. RuntimeError: called from a callback of `advance`; or the run went unstable or gained energy
            beyond the limit; the message says when and where, displacement and velocity are back at the last good
            state, from which works count anew and friction has no history.
            KeyboardInterrupt: Ctrl-C, on all ranks after the same step, once the callback has returned.

        What the callback raises on one rank is raised on all. After KeyboardInterrupt, or an exception of the callback,
        the problem is as after the last step: it may be saved, and `advance` to the same time goes on with the very
        steps that were left.
        """
        with guard(self.comm, "advance", callback=callback, unsafe=bool(unsafe)) as ranks:
            until, limits = self._check_advance(until, callback), energy_gain.checked(energy_limits)
            ranks.same(until=until, dt=dt, energy_limits=limits)
        if until == self.time:
            return
        self._warn_at, self._cpp.gain_limit = limits
        self._advancing = True
        try:
            with Interrupts(self.comm) as interrupts:
                self._advance(until, dt, callback, progress, unsafe, interrupts)
                interrupts.check()
        finally:
            self._advancing = False

    _advancing = False

    def _check_advance(self, until, callback):
        """Arguments of advance, on this rank; the time to reach."""
        if self._advancing:
            raise RuntimeError(
                "advance was called while it runs, by a callback: let the callback return, and call advance again after"
            )
        until = _number("until", until, unit=" [T]")
        if until < self.time:
            raise ValueError(f"until is {until:g}, but the time is {self.time:g} already")
        if callback is not None and not callable(callback):
            raise TypeError(f"callback must be a function of the problem, found {type(callback).__name__}")
        if self._fingerprint() != self._mesh_then:
            raise ValueError("the mesh was changed after the problem was set up: make a new problem")
        return until

    def _advance(self, until, dt, callback, progress, unsafe, interrupts):
        self._refresh()
        if callback and self.step == 0:
            interrupts.check(self._call(callback))
        if self._stale:
            self._safe, self._stale = self.stable_step(), False
        self._choose(until, dt, unsafe)
        with Bar(self, progress) as bar:
            try:
                while self.step < self._plan.last:
                    self._piece(until, dt, callback, unsafe, bar, interrupts)
            except BaseException:  # the same on all ranks
                self._look()
                for recorder in self._recorders:
                    with contextlib.suppress(RuntimeError):  # rows that could not be written are kept
                        recorder.flush()
                raise
        self._plan = None
        self._look()

    def _piece(self, until, dt, callback, unsafe, bar, interrupts):
        """Steps between which nothing but C++ runs, then what follows them. Exceptions are those of all ranks; the
        state is that after a step. Collective."""
        if (self._nonlinear or self._stale) and self.step > 0 and self.step % RECHECK == 0:
            self._recheck(until, dt, unsafe)
        first = self.step == 0
        self._run(1 if callback or first else self._chunk(), interrupts)
        if first:  # kinematic contact looks at gaps in steps
            for contact in self.contact:
                contact.check_start()
        for recorder in self._recorders:
            recorder.after()
        error = None
        if callback:
            error = self._call(callback)
        interrupts.check(error or attempt(bar.show)[1])

    def _call(self, callback):
        """Show the present state to a callback and take over what it has changed; its error on this rank, or None.
        Collective."""
        self._look()
        error = attempt(callback, self)[1]
        self._refresh()
        return error

    def _chunk(self):
        rest = self._plan.last - self.step
        waits = [recorder.steps_left() for recorder in self._recorders]
        return min(CHUNK, rest, RECHECK - self.step % RECHECK if self._nonlinear else rest, *waits)

    def _choose(self, until, dt, unsafe):
        """Plan the steps to `until`."""
        if isinstance(dt, str):
            if dt != "auto":
                raise ValueError(f"dt is {dt!r}: give a step in units of time, or 'auto'")
            nominal = SAFETY * self._safe
            known = self._plan is not None and self._plan.auto and not self._nominal > nominal
        else:
            nominal = _number("dt", dt, 0.0, " [T]")
            known = self._plan is not None and nominal == self._nominal
            if nominal > self._safe * (1 + 1e-12):
                text = f"dt = {nominal:.6g} is beyond the stable step {self._safe:.6g}"
                if not unsafe:
                    raise ValueError(f"{text}: take a smaller one, or pass unsafe=True to try it")
                if self.comm.rank == 0:
                    warnings.warn(f"{text}: the run may go unstable", stacklevel=3)
        if known and self._plan.until == until:
            return  # a run that was restored or interrupted goes on with the very steps it had
        if not math.isfinite(nominal):
            raise ValueError("nothing limits the step: give dt")
        number = (until - self.time) / nominal * (1 - 1e-12)
        if number > MOST_STEPS or nominal < np.spacing(until):
            why = ": the stable step is that small; check the mesh for tiny cells and the contacts for a large penalty"
            raise ValueError(
                f"a step of {nominal:g} takes {number:.3g} steps to the time {until:g}, more than {MOST_STEPS:g}"
                f"{why if isinstance(dt, str) else '; take a larger dt'}"
            )
        count = max(1, math.ceil(number))
        self._nominal = nominal
        self._plan = Plan(self.time, until, self.step, self.step + count, dt == "auto")
        self._cpp.set_contact_step(nominal)

    def _recheck(self, until, dt, unsafe):
        """A body that has deformed has another stable step. Collective."""
        self._copy_motion()
        self._safe, self._stale = self.stable_step(), False
        if self._nominal > (SAFETY if dt == "auto" else 1.0) * self._safe:
            self._plan = None
            self._choose(until, dt, unsafe)

    def _run(self, count, interrupts=None):
        """Take steps, fewer if a rank is interrupted. Collective."""
        steps = np.arange(self.step, self.step + count + 2)  # and one beyond
        times = self._plan.times(steps) if self._plan else np.full(2, self.time)
        table, error = attempt(self._table, times)
        agree(self.comm, error, "functions of time")
        if self.step - (self._good[0] if self._good else -SNAPSHOT) >= SNAPSHOT or count > SNAPSHOT:
            self._good = (self.step, self.time, *self._motion())
        rows = np.zeros((count, self._cpp.row_size))
        lengths = np.full(count, self._plan.dt if count else 1.0)
        table, columns = np.ascontiguousarray(table).ravel(), table.shape[1]
        done = self._cpp.run(lengths, table, columns, rows.reshape(-1), interrupts and interrupts.asked)
        self._keep(np.column_stack([times[:done], rows[:done]]))
        if done < count and not self._cpp.stopped:
            self._unstable(times[done])
        self.step, self.time, self._beyond = self.step + done, float(times[done]), float(times[done + 1])
        if self._cpp.most_gained > self._warn_at and not self._warned:
            self._warned = True
            if self.comm.rank == 0:
                text = energy_gain.told(self._cpp.most_gained)
                warnings.warn(f"the run gains energy: by the time {self.time:.6g} {text}", stacklevel=4)

    def _keep(self, rows):
        """Rows of steps: the history, what `drift` is measured by."""
        if len(rows) == 0:
            return
        energies = rows[:, 1 : 1 + len(ENERGIES)]
        if not self._known_start:
            self._total_start, self._known_start = self._total(rows[0]), True
        self._largest = max(self._largest, float(np.abs(energies).sum(axis=1).max()))
        self._history.add(rows)
        for recorder in self._recorders:
            recorder.take(rows)

    @staticmethod
    def _total(row):
        """Total energy of a row of the history."""
        return float(row[1 : len(ENERGIES)].sum() - row[len(ENERGIES)])

    def _table(self, times):
        """Values of all amplitudes, a row for each time."""
        table = [a.sample(times) for a in self._amplitudes]
        return np.hstack(table) if table else np.zeros((len(times), 0))

    def _unstable(self, time):
        """Back to the last good state; raises RuntimeError, on all ranks."""
        pair, node, facets = self._cpp.passage()
        # Nodes of a run that blows up go everywhere.
        passed = self.comm.allreduce(facets, MPI.MAX) if self._nominal <= self._safe * (1 + 1e-12) else 0.0
        gain, limit = self._cpp.gain, self._cpp.gain_limit
        if passed > 0.0:
            rank = self.comm.allreduce(self.comm.rank if facets == passed else self.comm.size, MPI.MIN)
        else:
            dof, speed = self._cpp.fastest()
            node = dof // self.space.dofmap.index_map_bs
            worst = -1.0 if dof < 0 else math.inf if math.isnan(speed) else speed
            rank = int(np.argmax(self.comm.allgather(worst)))
        where = self.comm.bcast(self._describe_node(node) if self.comm.rank == rank else None, root=rank)
        name = self.comm.bcast(self.contact[pair].pair.name if pair >= 0 else "", root=rank)
        self._plan = None
        for recorder in self._recorders:
            with contextlib.suppress(RuntimeError):  # a full disk must not keep the problem from going back
                recorder.flush()
        self.step, self.time, u, v, _ = self._good
        for contact in self.contact:
            contact.reset_history()
        self._known_start, self._largest = False, 0.0
        self._history.clear()
        self._cpp.start(u, v)
        self._run(0)
        self._look()
        if passed > 0.0:
            raise RuntimeError(
                f"{name}: a slave node went through the master at the time {time:.6g}: {where}. Contact holds back "
                f"nodes that come through the surface by up to one facet in a step, this one came by {passed:.3g}; "
                f"the problem is back at the time {self.time:.6g}. Take steps below "
                f"{0.9 * self._nominal / passed:.3g} (now {self._nominal:.3g}), or coarser facets"
            )
        why = f"{energy_gain.told(gain)} What moves fastest is" if gain > limit else "first"
        advice = "" if gain > limit else " Take a smaller step, or check loads and contact"
        raise RuntimeError(
            f"the run went unstable at the time {time:.6g}, step {self._nominal:.6g} (stable: {self._safe:.6g}), {why} "
            f"in {where}; the problem is back at the time {self.time:.6g}.{advice}"
        )

    def _describe_node(self, node):
        """Number, cell and place at rest of a node of this rank, as text."""
        V = self.space
        cell = int(np.argmax(np.any(V.dofmap.list == node, axis=1)))
        x = V.tabulate_dof_coordinates()[node]
        number = int(V.mesh.topology.original_cell_index[cell])
        text = f"cell {number} (number in the mesh's input) at {x[: V.mesh.geometry.dim].round(9).tolist()}"
        geometry = V.mesh.geometry
        places = geometry.x[geometry.dofmap[cell]]
        distance = np.linalg.norm(places - x, axis=1)
        nearest = int(np.argmin(distance))
        if distance[nearest] < 1e-9 * np.ptp(places, axis=0).max():
            text = f"node {int(geometry.input_global_indices[geometry.dofmap[cell, nearest]])} of {text}"
        return text

    # --- what a user sees ------------------------------------------------------------------------------------------

    def _motion(self):
        """Displacement, velocity and acceleration at the present time, owned entries."""
        v, a = np.empty(self.num_owned), np.empty(self.num_owned)
        self._cpp.motion(v, a)
        return self._cpp.displacement(), v, a

    def _copy_motion(self):
        for f, values in zip((self.u, self.velocity, self.acceleration), self._motion()):
            f.x.array[: self.num_owned] = values
            f.x.scatter_forward()

    def _look(self):
        """Functions, energies and contact results as they are now. Collective."""
        self._copy_motion()
        for contact in self.contact:
            contact.update_results()
        values = dict(zip(ENERGIES, self._cpp.energies().tolist()))
        parts = np.array(list(values.values()))
        values["total"] = total = float(parts[:-1].sum() - parts[-1])
        start = self._total_start if self._known_start else total
        values["drift"] = self._drift(total - start, float(np.abs(parts).sum()))
        self._energy = values

    def _drift(self, change, size):
        """Change of the total over the largest sum of absolute values of all steps and of the present one."""
        largest = max(self._largest, size)
        return change / largest if largest > 0.0 else 0.0

    @property
    def energy(self):
        """Energies at the present time: dict of kinetic, internal, contact, friction, impact, damping, viscosity,
        external, total [F L] and drift [1]; docs/explicit/energies.md."""
        return dict(self._energy)

    @property
    def energy_history(self):
        """Time and energies before every step, the first at the start of the run, (num_steps, 9): time [T], then those
        of `energy` in its order, external last [F L]. Runs of more than `history_limit` steps: every second, fourth,
        ... step."""
        return self._history.rows()[:, : 1 + len(ENERGIES)]

    @property
    def force_history(self):
        """Contact forces on the slaves, by contact: list of arrays (num_steps, gdim) at the times of `energy_history`
        [F]."""
        rows, first, gdim = self._history.rows(), 1 + len(ENERGIES), self.space.mesh.geometry.dim
        return [rows[:, first + 3 * k : first + 3 * k + gdim] for k in range(len(self.contact))]

    @property
    def history_limit(self):
        """Largest number of rows that histories keep in memory, 250,000 unless set; a Recorder writes all rows [1]."""
        return self._history.limit

    @history_limit.setter
    def history_limit(self, value):
        self._history.limit = value

    def record(self, path=None, fields=("displacement", "velocity"), every=100, points=None, points_every=10):
        """Write fields and histories into a folder from now on; see Recorder. Collective.

        Args:
            path: folder; None as for RunFolder. fields: some of displacement, velocity, acceleration. every: steps
                between frames. points: (n, gdim) places whose nearest nodes' motion is kept every `points_every` steps
                [L].

        Returns:
            Recorder; `close()` it at the end.

        Raises:
            ValueError: unknown fields, intervals that are no positive integers. RuntimeError: the folder cannot be
            written; on all ranks.
        """
        from .recorder import Recorder, check_arguments

        with guard(self.comm, "record", path=path, fields=fields, every=every, points_every=points_every) as ranks:
            fields, points = check_arguments(self, path, fields, every, points, points_every)
            ranks.same(points=points)
        recorder = Recorder(self, path, fields, every, points, points_every)
        self._recorders.append(recorder)
        return recorder

    def _refresh(self):
        """Take over constants, functions and loads that were changed since the last time: forces of the present time
        level are those of the new values. Collective."""
        changed = [any(term.changed() for term in self._terms), self._frequencies.changed()]
        changed += [load.changed() for load in self._loads]
        changed = np.array(changed, dtype=np.int32)
        self.comm.Allreduce(MPI.IN_PLACE, changed, MPI.MAX)
        if changed[0]:
            for term in self._terms:
                term.update()
            self._cpp.revise()
        if changed[1]:
            self._frequencies.take()
            self._stale = True
        for i, load in enumerate(self._loads):
            if changed[2 + i]:
                self._cpp.set_load(i, load.values())
