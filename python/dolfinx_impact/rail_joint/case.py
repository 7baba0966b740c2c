# SPDX-License-Identifier: MIT
"""One case from its parameters to its report: preload, passages, unloading; a run that was killed goes on."""

from __future__ import annotations

import json
import resource
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from dolfinx import fem
from mpi4py import MPI

from ..common.types import FilePath, FloatArray
from ..dynamics.explicit import ExplicitProblem
from ..dynamics.time_stepper import SAFETY
from ..io.frames import Frames
from ..io.gather import gather_field, together
from ..io.hdf5 import write_whole
from ..io.run_folder import RunFolder
from . import figures, report
from .model import JointModel
from .parameters import RailJoint
from .passage import FRAMES, Footprint, Frame, History, Passage, footprint
from .results import Summary, summarise
from .stress import NodalStress

CHECKPOINT, STATE = "checkpoint.h5", "state.json"
STATIONS = (0.10, 0.25, 0.40)  # places along the second rail where waves are recorded [m]
STATION_HEIGHT = -0.02  # in the rail head [m]
SAMPLES = 5  # steps between samples of points
# Time of the equilibria of a passage over that of its rolling, and their memory by unknown [B]: 8e3 with `coarse`, 1e4
# with `medium`; measured on two ranks.
STATIC_TIME, STATIC_MEMORY = 1.5, 1e4
TRIAL = 20.0  # wall-clock time of the measurement before a long run [s]

CAPTIONS = {
    "force.png": "Contact force over the place of the wheel; the end post is shaded. The stiffness of the running "
    "surface is lower at the joint: the force drops there, and rises when the wheel is thrown onto the second rail.",
    "footprint.png": "Nodal pressures at six moments; dotted the ellipse of Hertz. At the end post the contact splits.",
    "sequence.png": "Von Mises stress around the contact, cut in the middle of the rail.",
    "passage.gif": "The passage.",
    "ends.png": "Heights of the rail ends: the dip that the wheel has to climb out of.",
    "passages.png": "What the passages leave: equivalent plastic strain, what each adds to it, and its largest force.",
    "plastic.png": "Equivalent plastic strain of the rail heads after the last passage.",
    "residual.png": "Residual stress along the rail without a wheel.",
    "shear.png": "Shear stress in the plane of the rail while the wheel is on the edge of the second rail.",
    "waves.png": "Velocities along the second rail at three stations, the lowest of each marked, and when waves from "
    "the first station pass the others.",
    "energy.png": "Changes of the energies of what is computed, and what their balance misses.",
}


class UnusableJoint(ValueError):
    """The mesh or the wheel cannot be made with the parameters."""


class Case:
    """A case in its folder.

    Args:
        data: the joint.
        path: folder; None: as RunFolder.
        comm: communicator.
        pictures: whether pictures, fields and the report are made.
        progress: show progress bars on rank 0.
        resume: go on from the folder's checkpoint if there is one; else begin anew.
        interval: wall-clock time between checkpoints [s].
        frames: pictures of the animation, and moments at which fields are written [1].

    Attributes:
        data: as given.
        run: the folder.

    Raises:
        ValueError: the folder has a checkpoint of another joint; on all ranks.
        RuntimeError: the folder cannot be written; on all ranks.
    """

    def __init__(
        self,
        data: RailJoint,
        path: FilePath | None = None,
        comm: MPI.Intracomm = MPI.COMM_WORLD,
        pictures: bool = True,
        progress: bool = True,
        resume: bool = False,
        interval: float = 240.0,
        frames: int = FRAMES,
    ) -> None:
        self.data, self._comm, self._pictures, self._progress = data, comm, pictures, progress
        self._interval, self._frames = interval, frames
        folder = RunFolder(path, comm=comm, name="rail_joint", parameters={"toml": data.to_toml().splitlines()})
        self.run = folder
        self._state = self._read_state() if resume else {}
        if self._state and self._state["parameters"] != data.to_toml():
            raise ValueError(f"{folder.path} has a checkpoint of another joint: give another folder, or its parameters")
        self._seconds: dict[str, float] = dict(self._state.get("seconds", {}))
        self._passes: list[dict[str, Any]] = list(self._state.get("passes", []))
        folder.write("parameters.toml", lambda: write_whole(folder.file("parameters.toml"), data.to_toml()))

    def _read_state(self) -> dict[str, Any]:
        def work() -> dict[str, Any]:
            path = self.run.file(STATE)
            if not path.exists() or not self.run.file(CHECKPOINT).exists():
                return {}
            found = json.loads(path.read_text(encoding="utf-8"))
            assert isinstance(found, dict)
            return found

        return together(self._comm, work)

    def _write_state(self, number: int, **more: Any) -> None:
        state = {
            "parameters": self.data.to_toml(), "pass": number, "seconds": self._seconds, "passes": self._passes, **more
        }  # fmt: skip
        self.run.write(STATE, lambda: write_whole(self.run.file(STATE), json.dumps(state, indent=1) + "\n"))

    def _stage(self, name: str, work: Callable[[], Any]) -> Any:
        """Run a stage, count its time. Collective."""
        started = time.perf_counter()
        out = work()
        seconds = self._comm.bcast(time.perf_counter() - started)
        self._seconds[name] = self._seconds.get(name, 0.0) + seconds
        self.run.print(f"{name:12s} {seconds:7.1f} s")
        return out

    def solve(self) -> Summary:
        """All stages to the report. Collective.

        Returns:
            Numbers of the last passage, on all ranks.

        Raises:
            RuntimeError: no equilibrium was found, or the run went unstable; on all ranks.
        """
        data, run = self.data, self.run
        model = self._stage("mesh", lambda: JointModel(data, self._comm))
        run.print(
            f"{model.num_cells} cells of {1e3 * data.cell_size:.2f} mm and more on {self._comm.size} rank(s); by Hertz "
            f"the contact's half-axes are {1e3 * data.hertz.a:.2f} mm along and {1e3 * data.hertz.b:.2f} mm across the "
            f"rail, its pressure {1e-6 * data.hertz.peak_pressure:.0f} MPa"
        )
        passage = Passage(model, self._progress)
        if data.preset != "coarse":
            self._stage("trial", lambda: self._predict(passage))
        first = int(self._state.get("pass", 0))
        summary: Summary | None = None
        for number in range(first, data.passes):
            summary = self._pass(passage, number, resume=bool(self._state) and number == first)
            self._stage("unloading", passage.unload)
            self._passes.append(summary.as_dict())
        assert summary is not None
        run.write("summary.json", lambda: write_whole(run.file("summary.json"), json.dumps(
            {"parameters": data.to_toml(), "summary": summary.as_dict(), "passes": self._passes,
             "seconds": self._seconds}, indent=1, default=float) + "\n"))  # fmt: skip
        if self._pictures:
            self._stage("drawing", lambda: self._draw_residual(passage))
            if len(self._passes) > 1 and passage.yields:
                run.pictures(figures.passages, run.file("passages.png"), self._passes)
            seconds = dict(self._seconds)
            run.write("report.html", lambda: report.write(
                run.file("report.html"), data, summary, CAPTIONS, seconds, self._passes))  # fmt: skip
            run.write("paraview_state.py", lambda: report.write_state(run.file("paraview_state.py")))
        for name in (CHECKPOINT, STATE):
            run.write(name, partial(run.file(name).unlink, missing_ok=True))
        run.print(report.text_table(report.rows_of(data, summary)))
        return summary

    def _predict(self, passage: Passage) -> None:
        """Time and memory of the run, from some seconds of steps with the wheel at its start. Collective."""
        data, model = self.data, passage.model
        u, v = fem.Function(model.V), fem.Function(model.V)
        trial = ExplicitProblem(u, model.material, velocity=v, **passage.explicit_arguments())
        dt = SAFETY * trial.stable_step()
        trial.advance(3 * dt, progress=False)
        step, started, more = trial.step, time.perf_counter(), 10
        while self._comm.bcast(time.perf_counter() - started) < TRIAL and trial.time < data.duration:
            trial.advance(trial.time + more * dt, progress=False)
            more = min(2 * more, 2000)
        rate = (trial.step - step) / self._comm.bcast(time.perf_counter() - started)
        memory = self._comm.allreduce(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss) / 1e6
        steps = data.duration / dt
        minutes, unknowns = steps / rate / 60, 3 * model.V.dofmap.index_map.size_global
        self.run.print(
            f"predicted: {data.passes} x {steps:.0f} steps of {1e9 * dt:.0f} ns, {data.passes * minutes:.0f} min of "
            f"rolling at {rate:.1f} steps per second, some {STATIC_TIME * minutes:.0f} min of equilibria in the first "
            f"passage and half of it in others; {memory:.1f} GB so far, of all ranks, and "
            f"{STATIC_MEMORY * unknowns / 1e9:.0f} GB more for equilibria"
        )

    def _pass(self, passage: Passage, number: int, resume: bool) -> Summary:
        """One passage and its numbers. Collective."""
        data, run = self.data, self.run
        what = f" {number + 1}" if data.passes > 1 else ""
        if resume:
            problem = self._stage("restart", lambda: passage.resume(run.file(CHECKPOINT)))
            passage.static_force = float(self._state["static_force"])
            self.run.print(f"goes on at {1e3 * (data.begin + data.speed * problem.time):+.1f} mm")
            static = _footprint_from(self._state.get("footprint"))
        else:
            equilibrium = self._stage("preload" + what, passage.preload)
            problem = self._stage("start" + what, partial(passage.start, equilibrium))
            del equilibrium  # its matrices are larger than all that the wheel needs to roll
            static = passage.static_footprint
            self._write_state(number, static_force=passage.static_force, footprint=self._comm.bcast(_as_lists(static)))
        recorder = problem.record(
            run.file("rolling"), fields=(), points=self._points(), points_every=SAMPLES, every=10**9
        )
        kept: list[tuple[Frame, Any]] = []
        writer: list[Frames] = []

        def show(frame: Frame) -> None:
            gathered = figures.Picture(
                frame.place, gather_field(frame.displacement), gather_field(frame.stress["von_mises"])
            )
            shear = gather_field(frame.stress["tau_xz"])
            kept.append((Frame(frame.time, frame.place, frame.displacement, {}), (gathered, shear)))
            fields = [frame.displacement, *frame.stress.values()]
            if not writer:
                self._shown = fields
                writer.append(Frames(run, "frames.bp", fields))
            for mine, new in zip(self._shown[1:], fields[1:]):
                mine.x.array[:] = new.x.array
            writer[0].write(frame.time)

        last = number == data.passes - 1
        pictured = self._pictures and last
        places = [float(x) for x in np.linspace(data.begin, data.end, self._frames)]
        history = self._stage("rolling" + what, lambda: passage.roll(
            places, show if pictured else None, run.file(CHECKPOINT), self._interval))  # fmt: skip
        recorder.close()
        for frames in writer:
            frames.close()
        plastic = passage.plastic_strain()

        def numbers() -> tuple[Summary, FloatArray, Any]:
            ends, waves = _recorded(run.file("rolling") / "history.h5", data)
            found = summarise(
                data, history, passage.static_force, static, plastic, passage.model.num_cells, self._comm.size, ends
            )
            return found, ends, waves

        summary, ends, waves = run.write("rolling", numbers)
        self._table(history, ends)
        if pictured:
            self._stage("pictures", lambda: run.pictures(self._draw, history, summary, kept, ends, waves))
        return summary

    def _points(self) -> FloatArray:
        """Points that are recorded: both rail ends, then the stations."""
        half = 0.5 * self.data.gap
        ends = [(-half, 0.0, -0.25 * self.data.cell_size), (half, 0.0, -0.25 * self.data.cell_size)]
        return np.array([*ends, *((x, 0.0, STATION_HEIGHT) for x in STATIONS)])

    def _table(self, history: History, ends: FloatArray) -> None:
        columns = {"time": (history.time, "s"), "place": (history.place, "m")}
        columns |= {f"F{axis}": (history.force[:, k], "N") for k, axis in enumerate("xyz")}
        self.run.table("force", columns)
        self.run.table("energy", {"time": (history.time, "s"), **{n: (v, "J") for n, v in history.energy.items()}})
        self.run.table("ends", {name: (ends[:, k], "m") for k, name in enumerate(("place", "first", "second"))})

    def _draw(
        self, history: History, summary: Summary, kept: list[tuple[Frame, Any]], ends: FloatArray, waves: Any
    ) -> None:
        """Pictures of the passage; on rank 0."""
        data, file = self.data, self.run.file
        figures.force(file("force.png"), data, history, summary)
        figures.energies(file("energy.png"), data, history)
        figures.rail_ends(file("ends.png"), data, ends)
        figures.waves(file("waves.png"), data, *waves)
        places = _moments(data)
        footprints = history.footprints
        chosen = [min(footprints, key=lambda f: abs(f.place - x)) for x in places]
        figures.footprints(file("footprint.png"), data, chosen)
        pictures = [picture for _, (picture, _) in kept]
        six = [min(pictures, key=lambda p: abs(p.place - x)) for x in places]
        figures.sequence(file("sequence.png"), data, six, history)
        figures.animation(file("passage.gif"), data, pictures)
        edge = min(kept, key=lambda pair: abs(pair[0].place - 0.5 * data.gap))[1][1]
        edge.values[:] *= 1e-6
        figures.field_on_rail(file("shear.png"), data, edge, "shear stress xz [MPa]", (-300.0, 300.0), "RdBu_r")

    def _draw_residual(self, passage: Passage) -> None:
        """Pictures of the unloaded rail. Collective."""
        residual, run, data = passage.residual, self.run, self.data
        assert residual is not None
        history = residual.history if passage.yields else None
        stress = gather_field(NodalStress(passage.model, residual.u).evaluate(history)["sigma_xx"])
        plastic = gather_field(residual.history["plastic_strain"].at_nodes()) if passage.yields else None

        def draw() -> None:
            assert stress.values is not None and stress.points is not None
            stress.values[:] *= 1e-6
            near = np.abs(stress.points[:, 0]) < figures.ZONE[0]
            high = max(1.0, 0.8 * float(np.abs(stress.values[near]).max()))
            label = "residual stress along the rail [MPa]"
            figures.field_on_rail(run.file("residual.png"), data, stress, label, (-high, high), "RdBu_r")
            if plastic is not None and plastic.values is not None:
                plastic.values[:] *= 100.0
                high = max(1e-4, float(plastic.values.max()))
                figures.field_on_rail(run.file("plastic.png"), data, plastic, "plastic strain [%]", (0.0, high))

        run.pictures(draw)


def _moments(data: RailJoint) -> list[float]:
    """Six places of the wheel to look at."""
    a, half = data.hertz.a, 0.5 * data.gap
    return [data.begin, -half - 0.5 * a, 0.0, half + 0.5 * a, min(half + 1.5 * a, 0.6 * data.end), data.end]


def _recorded(path: Path, data: RailJoint) -> tuple[FloatArray, tuple[FloatArray, FloatArray, FloatArray]]:
    """Rail ends (place, two heights), and time, stations and velocities, from the recorder's file."""
    with h5py.File(path) as file:
        t = file["points/time"][:]
        u, v = file["points/displacement"][:], file["points/velocity"][:]
    ends = np.column_stack([data.begin + data.speed * t, u[:, 0, 2], u[:, 1, 2]])
    return ends, (t, np.array(STATIONS), v[:, 2:, 0])


def _as_lists(found: Footprint | None) -> dict[str, Any] | None:
    if found is None:
        return None
    return {
        "place": found.place, "points": found.points.tolist(), "pressure": found.pressure.tolist(),
        "weight": found.weight.tolist(),
    }  # fmt: skip


def _footprint_from(found: dict[str, Any] | None) -> Footprint | None:
    if found is None:
        return None
    return Footprint(found["place"], np.array(found["points"]), np.array(found["pressure"]), np.array(found["weight"]))


__all__ = ["FRAMES", "Case", "footprint"]
