# SPDX-License-Identifier: MIT
"""Passages of a wheel over a rail joint: static preload, explicit rolling, unloading."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from dolfinx import fem
from mpi4py import MPI

from dolfinx_impact import _cpp
from dolfinx_impact.common.memory import free_garbage
from dolfinx_impact.common.types import AnyArray, FilePath, FloatArray
from dolfinx_impact.contact import Lagrange, Penalty
from dolfinx_impact.contact.explicit.nodal import NodalPair
from dolfinx_impact.dynamics.explicit import ExplicitProblem
from dolfinx_impact.dynamics.static_start import start_again
from dolfinx_impact.dynamics.subject import in_time
from dolfinx_impact.io import checkpoint
from dolfinx_impact.io.checkpoint import Place, State
from dolfinx_impact.io.gather import gather_rows
from dolfinx_impact.statics.static_problem import StaticProblem
from .model import JointModel
from .way_bar import WayBar

# Rails are long and thin, so that their factors are short: those of 235,000 unknowns take 14 s, some 80 iterations with
# multigrid, which is three digits, 16 s (time of one core).
LARGEST_DIRECT = 400_000
TOLERANCE = 3e-5  # of the preload's residual: the time steps that follow make larger errors
FRAMES = 25  # pictures of a passage
LOOKS = 20  # steps between looks at the progress bar, each of which takes as long as a step
ROUND_OFF = 1e-12  # of times
CARRIED = ("pressed", "sunk", "unloaded")  # displacements that later equilibria begin with
ENERGIES = ("kinetic", "internal", "contact", "friction", "impact", "damping", "viscosity", "plastic", "external")
ROWS = 100_000_000  # of histories: all steps are kept, as a run that is resumed keeps them, too


@dataclass
class Footprint:
    """Slave nodes in contact, of all ranks; on rank 0 only.

    Attributes:
        place: of the wheel [m].
        points: (n, 3) [m].
        pressure: (n) [Pa].
        weight: areas of the nodes, (n) [m^2].
    """

    place: float
    points: FloatArray
    pressure: FloatArray
    weight: FloatArray


@dataclass
class Frame:
    """Fields of one moment.

    Attributes:
        time: since the start [s].
        place: of the wheel [m].
        displacement: [m].
        stress: at the nodes by name [Pa].
    """

    time: float
    place: float
    displacement: fem.Function
    stress: dict[str, fem.Function]


@dataclass
class History:
    """A passage in numbers; rows are time steps.

    Attributes:
        time: (n) [s].
        place: of the wheel, (n) [m].
        force: on the wheel, of both sides of the rail, (n, 3); across the rail zero where one side is computed [N].
        energy: by name, of what is computed, (n) [J].
        steps: number of time steps [1].
        dt: the step [s].
        seconds: wall-clock time of rolling [s].
        footprints: at the frames; on rank 0.
        frames: number of places at which footprints were taken so far [1].
    """

    time: FloatArray
    place: FloatArray
    force: FloatArray
    energy: dict[str, FloatArray]
    steps: int
    dt: float
    seconds: float
    footprints: list[Footprint] = field(default_factory=list)
    frames: int = 0

    def tables(self) -> dict[str, AnyArray]:
        """Arrays from which `of_tables` makes the same history."""
        out: dict[str, AnyArray] = {
            "time": self.time, "place": self.place, "force": self.force,
            "energy": np.column_stack([self.energy[name] for name in ENERGIES]),
            "numbers": np.array([self.steps, self.dt, self.seconds, self.frames]),
            "footprint_sizes": np.array([len(f.points) for f in self.footprints], dtype=np.int64),
            "footprint_places": np.array([f.place for f in self.footprints]),
        }  # fmt: skip
        rows = [np.column_stack([f.points, f.pressure, f.weight]) for f in self.footprints]
        out["footprints"] = np.concatenate(rows) if rows else np.zeros((0, 5))
        return out

    @classmethod
    def of_tables(cls, tables: Mapping[str, AnyArray]) -> History:
        """The history whose `tables` these are.

        Args:
            tables: arrays by name.
        """
        ends = np.cumsum(tables["footprint_sizes"])
        rows = np.split(tables["footprints"], ends[:-1]) if len(ends) else []
        steps, dt, seconds, frames = (float(number) for number in tables["numbers"])
        return cls(
            tables["time"], tables["place"], tables["force"],
            {name: tables["energy"][:, k] for k, name in enumerate(ENERGIES)}, int(steps), dt, seconds,
            [Footprint(float(x), r[:, :3], r[:, 3], r[:, 4]) for x, r in zip(tables["footprint_places"], rows)],
            int(frames),
        )  # fmt: skip


def _carried(nodes: Mapping[str, FloatArray], cells: Mapping[str, FloatArray]) -> _cpp.state.State:
    """What passages hand on as a state: views of arrays at owned nodes and of owned cells by name, rows of numbers."""
    out, history = State("carried"), State("history")
    for name, values in nodes.items():
        out.add(name, Place.node, np.asarray(values, dtype=np.float64))
    for name, values in cells.items():
        history.add(name, Place.cell, np.asarray(values, dtype=np.float64))
    out.add(history)
    return out


def footprint(contact: Any, place: float) -> Footprint | None:
    """Nodes in contact of all ranks, on rank 0; None on others. Collective.

    Args:
        contact: of a static or an explicit problem.
        place: of the wheel [m].
    """
    on = contact.pressure > 0.0
    rows = gather_rows(contact.comm, np.column_stack([contact.points, contact.pressure, contact.weight])[on])
    if rows is None:
        return None
    return Footprint(place, rows[:, :3], rows[:, 3], rows[:, 4])


class Passage:
    """One wheel that rolls over the joint, once or several times.

    Args:
        model: the joint.
        progress: show progress bars on rank 0.

    Attributes:
        model: as given.
        u: displacement [m].
        static_force: vertical contact force of the last preload, of both sides of the rail [N].
        static_footprint: nodes in contact then; on rank 0.
        run: explicit problem of the last passage.
        residual: static problem without a wheel after the last passage.
    """

    def __repr__(self) -> str:
        return f"Passage(static force {self.static_force:.6g}, {self.model!r})"

    def __init__(self, model: JointModel, progress: bool = True) -> None:
        self.model, self._progress = model, progress
        self.u = fem.Function(model.V, name="displacement")
        self.static_force = 0.0
        self.static_footprint: Footprint | None = None
        self.run: ExplicitProblem | None = None
        self.residual: StaticProblem | None = None
        self._history: dict[str, AnyArray] = {}  # of the materials, from earlier passages
        self._mean_pressure = 0.0  # in the contact of the last preload [Pa]
        self._wheel = np.unique(model.V.dofmap.list[model.wheel.cells])  # its nodes, owned and ghosts
        self._penalty: float | None = None  # median of the springs with which the explicit problem begins [Pa/m]
        self._unloaded: FloatArray | None = None  # displacements after the passage before, without a wheel [m]
        self._pressed: FloatArray | None = None  # what the last preload added to the displacements [m]
        self._first: StaticProblem | None = None  # the first preload, whose factors serve the equilibria that follow
        self._shares = False  # whether they do
        self._sunk: FloatArray | None = None  # what springs in the place of its multipliers added to them [m]

    @property
    def yields(self) -> bool:
        """May the rails yield?"""
        return not np.isinf(self.model.data.yield_stress)

    @property
    def _options(self) -> dict[str, Any] | None:
        """PETSc options of equilibria; None: chosen by size. Ties keep their multipliers, which have factors anyway."""
        small = 3 * self.model.V.dofmap.index_map.size_global <= LARGEST_DIRECT
        return {"pc_type": "cholesky"} if small and not self.model.ties else None

    def _springs_contact(self) -> Penalty:
        """Springs in the place of the preload's multipliers."""
        if self._penalty is None:
            raise RuntimeError("springs take their stiffness from the first start: there was none")
        return Penalty(self.model.pair(0.0), penalty=self._penalty)

    def _static(self, contact: Lagrange | Penalty, u: fem.Function | None = None) -> StaticProblem:
        """The wheel under its load on the rail, without friction, with centrifugal forces. Collective.

        Args:
            contact: of the wheel and the rail.
            u: displacement of steel that has not yielded yet; None: the passage's own, with the history of the steel.
        """
        model = self.model
        static = StaticProblem(
            self.u if u is None else u, model.material, bcs=[*model.bcs, *model.upright()],
            loads=[model.press, model.track, model.centrifugal()], contact=[contact, *model.ties],
            options=self._options,
        )  # fmt: skip
        if u is None:
            self._give_history(static)
        return static

    def preload(self) -> StaticProblem:
        """Press the wheel on the rail at the start, by multipliers. Collective.

        Raises:
            RuntimeError: no equilibrium was found; on all ranks.
        """
        model = self.model
        self.residual = None  # its matrices need not lie beside those of the next passage
        before: FloatArray = self.u.x.array.copy()
        if self._pressed is None:
            static = self._press(self.u)
        else:
            static = self._static(Lagrange(model.pair(0.0)))
            self.u.x.array[:] += self._pressed  # the wheel comes back to a rail that has hardly changed there
            static.solve(rtol=TOLERANCE)
        if self._pressed is None and self._options is not None:  # factors for all equilibria that follow
            self._first, self._shares = static, True
        else:
            static.linear_solver.reset()
        self._pressed = self.u.x.array - before
        contact = static.contact[0]
        assert contact.force is not None
        self.static_force = model.data.sides * float(contact.force[2])
        self.static_footprint = footprint(contact, model.data.begin)
        on = contact.pressure > 0.0
        area = model.comm.allreduce(float(contact.weight[on].sum()))
        self._mean_pressure = self.static_force / model.data.sides / area
        return static

    def _press(self, u: fem.Function) -> StaticProblem:
        """Press the wheel on rails that no wheel has passed. Collective.

        Args:
            u: zero; becomes the displacement [m].
        """
        static = self._static(Lagrange(self.model.pair(0.0)), u)
        # A sphere that overlaps a plane by half of Hertz's approach cuts out Hertz's contact: the active set of the
        # start is hardly wrong.
        u.x.array.reshape(-1, 3)[self._wheel, 2] -= 0.5 * self.model.data.hertz.approach
        static.solve(rtol=TOLERANCE)
        return static

    def _solve_with_factors(self, static: StaticProblem) -> None:
        """Solve with the factors of the first preload while they serve. Multipliers of later preloads would take 60
        iterations: they have factors of their own.

        A run that was resumed has no factors, and its numbers shall be those of one that was not to the last digit: it
        solves the first preload again. Collective."""
        if self._first is None and self._shares:
            self._first = self._press(fem.Function(self.model.V))
        if self._first is None:
            static.solve(rtol=TOLERANCE)
            static.linear_solver.reset()
            return
        static.share_linear_solver(self._first)
        before = static.linear_solver.num_set_ups
        static.solve(rtol=TOLERANCE)
        if static.linear_solver.num_set_ups > before:
            # Factors of a state that could not be found again.
            static.linear_solver.reset()
            self._first, self._shares = None, False

    def _give_history(self, problem: Any) -> None:
        for name, values in self._history.items():
            problem.history[name].values = values

    def explicit_arguments(self) -> dict[str, Any]:
        """Supports, loads and contact of the explicit problem."""
        model = self.model
        data = model.data
        # The wheel loads the springs for the whole passage: softer ones would smooth the impact.
        contact = Penalty(model.pair(data.friction), penalty=data.penalty or "step", balanced=False)
        return {"bcs": model.bcs, "loads": [model.press, model.track], "contact": [contact, *model.ties]}

    def start(self, static: StaticProblem) -> ExplicitProblem:
        """The explicit problem in the state of steady rolling under the static load. Collective.

        Args:
            static: the preload.

        Raises:
            RuntimeError: the springs found no equilibrium; on all ranks.
        """
        run: ExplicitProblem | None = None
        if self._penalty is None:
            run = ExplicitProblem.from_static(static, **self.explicit_arguments())
            pressed = run.contact[0]
            assert isinstance(pressed, NodalPair)  # the joint has no other contact
            closed = pressed.stiffness > 0.0
            found = self.model.comm.allgather(pressed.stiffness[closed] / pressed.weight[closed])
            self._penalty = float(np.median(np.concatenate(found)))
        # The springs' compliance makes the contact a little longer: without this equilibrium of their own, their
        # transition to it would make the force swing by 3 % in the first 20 mm.
        springs = self._static(self._springs_contact())
        before: FloatArray = self.u.x.array.copy()
        if self._sunk is None:
            # The wheel as a rigid body sinks in until the springs bear its load on the area that is in contact.
            self.u.x.array.reshape(-1, 3)[self._wheel, 2] -= self._mean_pressure / self._penalty
        else:
            self.u.x.array[:] += self._sunk
        self._solve_with_factors(springs)
        self._sunk = self.u.x.array - before
        velocity = self.model.rolling_velocity(self.u)
        if run is None:
            run = ExplicitProblem.from_static(springs, velocity=velocity, **self.explicit_arguments())
        else:
            start_again(run, springs, velocity)
        self.run, self.u = run, run.u
        return run

    def _bare(self, u: fem.Function) -> ExplicitProblem:
        """An explicit problem of the joint into which a state is read. Collective."""
        zero = fem.Function(self.model.V, name="velocity")
        return ExplicitProblem(u, self.model.material, velocity=zero, **self.explicit_arguments())

    def resume(self, path: FilePath) -> ExplicitProblem:
        """The explicit problem of a checkpoint. Collective.

        Args:
            path: file that `run.save` has written in the same passage of the same joint.

        Raises:
            RuntimeError: the file cannot be read; on all ranks.
            ValueError: it belongs to another joint; on all ranks.
        """
        self.run = self._bare(self.u)
        self.run.restore(path)
        return self.run

    @property
    def numbers(self) -> dict[str, Any]:
        """What `read_carried` needs beside the file of `write_carried`, for JSON."""
        columns = {name: int(np.prod(values.shape[1:])) for name, values in self._history.items()}
        fields = [name for name in CARRIED if getattr(self, f"_{name}") is not None]
        return {
            "penalty": self._penalty, "static_force": self.static_force, "history": columns, "fields": fields,
            "shares": self._shares,
        }  # fmt: skip

    def write_carried(self, path: FilePath) -> None:
        """Write what the next passages begin with: starts of their equilibria, history of the steel. Collective.

        Args:
            path: file to write.

        Raises:
            RuntimeError: it cannot be written; on all ranks.
        """
        run, n = self.run, self.model.V.dofmap.index_map.size_local * 3
        assert run is not None, "preload and start come first"
        fields = {name: getattr(self, f"_{name}")[:n].reshape(-1, 3) for name in self.numbers["fields"]}
        cells = {
            name: values.reshape(len(values), math.prod(values.shape[1:])) for name, values in self._history.items()
        }
        checkpoint.write(path, in_time(run), _carried(fields, cells))

    def read_carried(self, path: FilePath, numbers: Mapping[str, Any]) -> None:
        """Read what `write_carried` has written. Collective.

        Args:
            path: file.
            numbers: as they were then.

        Raises:
            RuntimeError: the file cannot be read; on all ranks.
            ValueError: it belongs to another joint; on all ranks.
        """
        V = self.model.V
        run = self.run or self._bare(fem.Function(V, name="displacement"))
        num = V.dofmap.index_map.size_local
        num_cells = V.mesh.topology.index_map(V.mesh.topology.dim).size_local
        like = _carried(
            {name: np.zeros((num, 3)) for name in numbers["fields"]},
            {name: np.zeros((num_cells, columns)) for name, columns in numbers["history"].items()},
        )
        found, _ = checkpoint.read(path, in_time(run), like)
        for name in numbers["fields"]:
            values = found.array(name)
            f = fem.Function(V)
            f.x.array[: values.size] = values.ravel()
            f.x.scatter_forward()
            setattr(self, f"_{name}", f.x.array.copy())
        history = found.part("history")
        self._history = {n: history.array(n).reshape(run.history[n].values.shape) for n in history.names}
        self._penalty, self.static_force = numbers["penalty"], float(numbers["static_force"])
        self._shares = bool(numbers.get("shares", False))  # older folders name other factors, or none
        if self.run is None and self._unloaded is not None:
            self.u.x.array[:] = self._unloaded

    def roll(
        self,
        frames: Sequence[float] | None = None,
        show: Callable[[Frame], None] | None = None,
        save: Callable[[History], None] | None = None,
        interval: float = 300.0,
        dt: float | str = "auto",
        so_far: History | None = None,
    ) -> History:
        """Roll to the end of the way. Collective.

        Args:
            frames: places of the wheel at which `show` is called and the footprint is kept, ascending; None: FRAMES of
                them, evenly [m].
            show: called with the fields of that moment.
            save: called with the passage so far every `interval` seconds, and at the end.
            interval: wall-clock time between calls of `save` [s].
            dt: time step, as in ExplicitProblem.advance [s].
            so_far: what `save` got before the run was resumed; None: it begins.

        Returns:
            The whole passage, from its start.

        Raises:
            ValueError: the step is longer than the stable one; on all ranks.
            RuntimeError: the run went unstable; on all ranks.
        """
        from .stress import NodalStress

        run, data, comm = self.run, self.model.data, self.model.comm
        assert run is not None, "preload and start, or resume, come first"
        places = np.linspace(data.begin, data.end, FRAMES) if frames is None else np.asarray(frames, dtype=float)
        places = np.append(places[places < data.end], data.end)
        stress = NodalStress(self.model, run.u) if show is not None else None
        begun = saved = time.perf_counter()
        run.history_limit = ROWS
        done = comm.bcast(0 if so_far is None else so_far.frames)
        footprints = [] if so_far is None else list(so_far.footprints)
        free_garbage(self.model.mesh.comm, 3 * self.model.V.dofmap.index_map.size_global)  # matrices of the equilibria

        def history() -> History:
            return self._history_of(run, so_far, footprints, done, time.perf_counter() - begun)

        with WayBar(comm, data, self._progress) as bar:
            for place in places[done:]:
                moment = (place - data.begin) / data.speed
                while run.time < moment * (1.0 - ROUND_OFF):
                    until = min(moment, run.time + data.duration / FRAMES)
                    look = bar if self._progress else None
                    run.advance(until, dt=dt, progress=False, callback=look, callback_every=LOOKS)
                    if save is not None and comm.bcast(time.perf_counter() - saved > interval):
                        save(history())
                        saved = time.perf_counter()
                found = footprint(run.contact[0], float(place))
                if found is not None:
                    footprints.append(found)
                if show is not None and stress is not None:
                    show(Frame(run.time, float(place), run.u, stress.evaluate(run.history if self.yields else None)))
                done += 1
        whole = history()
        if save is not None:
            save(whole)
        return whole

    def begun(self) -> History:
        """The passage before its first step."""
        assert self.run is not None, "preload and start come first"
        return self._history_of(self.run, None, [], 0, 0.0)

    def _history_of(
        self, run: ExplicitProblem, so_far: History | None, footprints: list[Footprint], frames: int, seconds: float
    ) -> History:
        """The passage up to the present, with what was before it was resumed."""
        data, rows, force = self.model.data, run.energy_history, self.model.data.sides * run.force_history[0]
        if data.sides == 2:
            # The other half bears the opposite force across the rail: together none.
            force[:, 1] = 0.0
        times = rows[:, 0]
        energy = {name: rows[:, 1 + k] for k, name in enumerate(ENERGIES)}
        place = data.begin + data.speed * times
        if so_far is not None:
            # The run begins anew with the row of the moment at which it was saved.
            old = so_far.time < (times[0] if len(times) else np.inf)
            seconds += so_far.seconds
            times, place = np.append(so_far.time[old], times), np.append(so_far.place[old], place)
            force = np.concatenate([so_far.force[old], force])
            energy = {name: np.append(so_far.energy[name][old], values) for name, values in energy.items()}
        step = float(np.diff(times).max(initial=0.0))
        return History(times, place, force, energy, run.step, step, seconds, list(footprints), frames)

    def unload(self) -> StaticProblem:
        """Lift the wheel off: residual displacement and stress, and the history for another passage. Collective.

        Raises:
            RuntimeError: no equilibrium was found; on all ranks.
        """
        model, run = self.model, self.run
        assert run is not None, "roll comes first"
        u = fem.Function(model.V, name="displacement")
        if self._unloaded is None:
            u.x.array[:] = run.u.x.array
            u.x.array.reshape(-1, 3)[self._wheel] = 0.0  # lifted off, without load
        else:
            u.x.array[:] = self._unloaded  # a passage adds little to what the passages before have left
        bcs = [*model.bcs, *model.parked()]
        static = StaticProblem(
            u, model.material, bcs=bcs, loads=[model.track], contact=model.ties, options=self._options
        )
        if self.yields:
            self._history = {name: run.history[name].values.copy() for name in run.history}
            self._give_history(static)
        self._solve_with_factors(static)
        self.residual = static
        if self.yields:
            self._history = {name: static.history[name].values.copy() for name in static.history}
        self.u = fem.Function(model.V, name="displacement")
        self.u.x.array[:] = u.x.array
        self._unloaded = u.x.array.copy()
        return static

    def plastic_strain(self) -> float:
        """Largest equivalent plastic strain of all ranks so far [1]. Collective."""
        if not self.yields or self.run is None:
            return 0.0
        values = self.run.history["plastic_strain"].values
        return float(self.model.comm.allreduce(float(values.max(initial=0.0)), MPI.MAX))
