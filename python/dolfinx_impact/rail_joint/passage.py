# SPDX-License-Identifier: MIT
"""Passages of a wheel over a rail joint: static preload, explicit rolling, unloading."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from dolfinx import fem
from mpi4py import MPI

from ..common.memory import free_garbage
from ..common.types import AnyArray, FilePath, FloatArray
from ..contact import Lagrange, Penalty
from ..dynamics.explicit import ExplicitProblem
from ..io.gather import gather_rows
from ..statics.problem import StaticProblem
from .model import JointModel
from .way_bar import WayBar

TOLERANCE = 3e-5  # of the preload's residual: the time steps that follow make larger errors
FRAMES = 25  # pictures of a passage


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
        force: on the wheel, of both sides of the rail, (n, 3) [N].
        energy: by name, of what is computed, (n) [J].
        steps: number of time steps [1].
        dt: the step [s].
        seconds: wall-clock time of rolling [s].
        footprints: at the frames.
    """

    time: FloatArray
    place: FloatArray
    force: FloatArray
    energy: dict[str, FloatArray]
    steps: int
    dt: float
    seconds: float
    footprints: list[Footprint] = field(default_factory=list)


ENERGIES = ("kinetic", "internal", "contact", "friction", "impact", "damping", "viscosity", "plastic", "external")


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

    def __init__(self, model: JointModel, progress: bool = True) -> None:
        self.model, self._progress = model, progress
        self.u = fem.Function(model.V, name="displacement")
        self.static_force = 0.0
        self.static_footprint: Footprint | None = None
        self.run: ExplicitProblem | None = None
        self.residual: StaticProblem | None = None
        self._history: dict[str, AnyArray] = {}  # of the materials, from earlier passages
        self._penalty: float | None = None  # median of the springs with which the explicit problem begins [Pa/m]
        self._unloaded: FloatArray | None = None  # displacements after the passage before, without a wheel [m]
        self._pressed: FloatArray | None = None  # what the last preload added to the displacements [m]
        self._sunk: FloatArray | None = None  # what springs in the place of its multipliers added to them [m]

    @property
    def yields(self) -> bool:
        """May the rails yield?"""
        return not np.isinf(self.model.data.yield_stress)

    def _static(self, contact: Lagrange | Penalty) -> StaticProblem:
        """The wheel under its load on the rail, without friction, with centrifugal forces. Collective."""
        model = self.model
        static = StaticProblem(
            self.u, model.material, bcs=[*model.bcs, *model.upright()],
            loads=[model.press, model.track, model.centrifugal()], contact=[contact],
        )  # fmt: skip
        self._give_history(static)
        return static

    def preload(self) -> StaticProblem:
        """Press the wheel on the rail at the start, by multipliers. Collective.

        Raises:
            RuntimeError: no equilibrium was found; on all ranks.
        """
        model = self.model
        self.residual = None  # its matrices need not lie beside those of the next passage
        static = self._static(Lagrange(model.pair(0.0)))
        before: FloatArray = self.u.x.array.copy()
        if self._pressed is None:
            # A sphere that overlaps a plane by half of Hertz's approach cuts out Hertz's contact: the active set of the
            # start is hardly wrong.
            wheel = np.unique(model.V.dofmap.list[model.wheel.cells])
            self.u.x.array.reshape(-1, 3)[wheel, 2] -= 0.5 * model.data.hertz.approach
        else:
            self.u.x.array[:] += self._pressed  # the wheel comes back to a rail that has hardly changed there
        static.solve(rtol=TOLERANCE)
        static.linear_solver.reset()
        self._pressed = self.u.x.array - before
        contact = static.contact[0]
        assert contact.force is not None
        self.static_force = model.data.sides * float(contact.force[2])
        self.static_footprint = footprint(contact, model.data.begin)
        return static

    def _give_history(self, problem: Any) -> None:
        for name, values in self._history.items():
            problem.history[name].values = values

    def explicit_arguments(self) -> dict[str, Any]:
        """Supports, loads and contact of the explicit problem."""
        model = self.model
        data = model.data
        return {
            "bcs": model.bcs, "loads": [model.press, model.track],
            "contact": [Penalty(model.pair(data.friction), penalty=data.penalty or "auto", balanced=False)],
        }  # fmt: skip

    def start(self, static: StaticProblem) -> ExplicitProblem:
        """The explicit problem in the state of steady rolling under the static load. Collective.

        Args:
            static: the preload.

        Raises:
            RuntimeError: the springs found no equilibrium; on all ranks.
        """
        if self._penalty is None:
            trial = ExplicitProblem.from_static(static, **self.explicit_arguments()).contact[0]
            closed = trial.stiffness > 0.0
            found = self.model.comm.allgather(trial.stiffness[closed] / trial.weight[closed])
            self._penalty = float(np.median(np.concatenate(found)))
        # The springs' compliance makes the contact a little longer: without this equilibrium of their own, their
        # transition to it would make the force swing by 3 % in the first 20 mm.
        springs = self._static(Penalty(self.model.pair(0.0), penalty=self._penalty))
        before: FloatArray = self.u.x.array.copy()
        if self._sunk is not None:
            self.u.x.array[:] += self._sunk
        springs.solve(rtol=TOLERANCE)
        self._sunk = self.u.x.array - before
        velocity = self.model.rolling_velocity(self.u)
        self.run = ExplicitProblem.from_static(springs, velocity=velocity, **self.explicit_arguments())
        self.u = self.run.u
        return self.run

    def resume(self, checkpoint: FilePath) -> ExplicitProblem:
        """The explicit problem of a checkpoint. Collective.

        Args:
            checkpoint: file that `run.save` has written in the same passage of the same joint.

        Raises:
            RuntimeError: the file cannot be read; on all ranks.
            ValueError: it belongs to another joint; on all ranks.
        """
        model = self.model
        zero = fem.Function(model.V, name="velocity")
        self.run = ExplicitProblem(self.u, model.material, velocity=zero, **self.explicit_arguments())
        self.run.restore(checkpoint)
        return self.run

    def roll(
        self,
        frames: Sequence[float] | None = None,
        show: Callable[[Frame], None] | None = None,
        checkpoint: FilePath | None = None,
        interval: float = 300.0,
        dt: float | str = "auto",
    ) -> History:
        """Roll to the end of the way. Collective.

        Args:
            frames: places of the wheel at which `show` is called and the footprint is kept, ascending; None: FRAMES of
                them, evenly [m].
            show: called with the fields of that moment.
            checkpoint: file that is written every `interval` seconds, and can be resumed from.
            interval: wall-clock time between checkpoints [s].
            dt: time step, as in ExplicitProblem.advance [s].

        Raises:
            ValueError: the step is longer than the stable one; on all ranks.
            RuntimeError: the run went unstable; on all ranks.
        """
        from .stress import NodalStress

        run, data = self.run, self.model.data
        assert run is not None, "preload and start, or resume, come first"
        places = np.linspace(data.begin, data.end, FRAMES) if frames is None else np.asarray(frames, dtype=float)
        stress = NodalStress(self.model, run.u) if show is not None else None
        footprints, before, saved = [], time.perf_counter(), time.perf_counter()
        first = run.step
        free_garbage(self.model.mesh.comm, 3 * self.model.V.dofmap.index_map.size_global)  # matrices of the equilibria
        with WayBar(self.model.comm, data, self._progress) as bar:
            for place in np.append(places[places < data.end], data.end):
                moment = (place - data.begin) / data.speed
                if moment < run.time * (1.0 - 1e-12):
                    continue
                while run.time < moment:
                    until = min(moment, run.time + data.duration / FRAMES)
                    run.advance(until, dt=dt, progress=False, callback=bar if self._progress else None)
                    late = self.model.comm.bcast(time.perf_counter() - saved > interval)
                    if checkpoint is not None and late:
                        run.save(checkpoint)
                        saved = time.perf_counter()
                found = footprint(run.contact[0], float(place))
                if found is not None:
                    footprints.append(found)
                if show is not None and stress is not None:
                    history = run.history if self.yields else None
                    show(Frame(run.time, float(place), run.u, stress.evaluate(history)))
        if checkpoint is not None:
            run.save(checkpoint)
        rows, force = run.energy_history, run.force_history[0]
        times = rows[:, 0]
        energy = {name: rows[:, 1 + k] for k, name in enumerate(ENERGIES)}
        steps = run.step - first
        return History(
            times, data.begin + data.speed * times, data.sides * force, energy, run.step,
            float(np.diff(times).max(initial=0.0)), time.perf_counter() - before if steps else 0.0, footprints,
        )  # fmt: skip

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
            wheel = np.unique(model.V.dofmap.list[model.wheel.cells])
            u.x.array.reshape(-1, 3)[wheel] = 0.0  # lifted off, without load
        else:
            u.x.array[:] = self._unloaded  # a passage adds little to what the passages before have left
        static = StaticProblem(u, model.material, bcs=[*model.bcs, *model.parked()], loads=[model.track])
        if self.yields:
            self._history = {name: run.history[name].values.copy() for name in run.history}
            self._give_history(static)
        static.solve(rtol=TOLERANCE)
        static.linear_solver.reset()
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
