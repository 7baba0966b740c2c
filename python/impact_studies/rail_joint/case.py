# SPDX-License-Identifier: MIT
"""One case from its parameters to its report: preload, passages, unloading; a run that was killed goes on."""

from __future__ import annotations

import contextlib
import dataclasses
import json
import resource
import time
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import h5py
import numpy as np
from dolfinx import fem
from mpi4py import MPI

from dolfinx_impact import __version__
from dolfinx_impact.common.types import FilePath, FloatArray
from dolfinx_impact.dynamics.explicit import ExplicitProblem
from dolfinx_impact.dynamics.time_stepper import SAFETY
from dolfinx_impact.io.gather import gather_field, gather_rows
from dolfinx_impact.io.hdf5 import write_whole
from dolfinx_impact.io.run_folder import RunFolder
from . import figures, report
from .model import JointModel
from .parameters import RailJoint
from .frame_series import FrameSeries
from .passage import FRAMES, Footprint, History, Passage
from .results import Summary, summarise
from .saved_case import SavedCase
from .stress import NodalStress

STATIONS = (0.10, 0.25, 0.40)  # places along the second rail where waves are recorded [m]
STATION_HEIGHT = -0.02  # in the rail head [m]
RESIDUAL_NAMES = ("sigma_xx", "von_mises")  # of the stress whose limits are told
SURFACE = 1e-9  # nodes of the rails are not above [m]
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
    "plastic.png": "Equivalent plastic strain of the rail heads after the last passage: the largest of each cell's "
    "points, as in the table.",
    "residual.png": "Residual stress of the rail heads without a wheel, averaged at the nodes; positive in tension.",
    "shear.png": "Shear stress in the plane of the rail while the wheel is on the edge of the second rail.",
    "waves.png": "Velocities along the second rail at three stations, the lowest of each marked, and when waves from "
    "the first station pass the others.",
    "energy.png": "Changes of the energies of what is computed, and what their balance misses.",
}

TABLES = ("force", "energy", "ends")
# What a run leaves; the report shows every picture that it finds.
RESULTS = ("summary.json", "report.html", *CAPTIONS, *(f"{name}.{kind}" for name in TABLES for kind in ("csv", "h5")))


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
        resume: go on from the folder's checkpoint if there is one; a run that is complete is not run again; else begin
            anew.
        interval: wall-clock time between checkpoints [s].
        frames: pictures of the animation, and moments at which fields are written [1].

    Attributes:
        data: as given.
        run: the folder.

    Raises:
        ValueError: the folder has a checkpoint of another joint or number of ranks; on all ranks.
        RuntimeError: the folder cannot be written, another run writes to it, or its checkpoint is damaged; on all
            ranks.
    """

    def __repr__(self) -> str:
        return f"Case({str(self.run.path)!r})"

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
        parameters = {"toml": data.to_toml().splitlines()}
        folder = self.run = RunFolder(path, comm=comm, name="rail_joint", alone=True)
        try:
            self._identity = {
                "parameters": data.identity(), "version": __version__, "frames": frames, "pictures": pictures,
            }  # fmt: skip
            # The wheel's densities are sums over ranks: on other ranks their last digits would be another joint's.
            self._saved = SavedCase(folder, {**self._identity, "ranks": comm.size})
            self._goes_on = resume and self._saved.read()
            self._finished = self._find_finished() if resume and not self._goes_on else None
            if not self._goes_on and self._finished is None:
                self._saved.clear()
                for name in RESULTS:  # of an earlier run
                    folder.write(name, partial(folder.file(name).unlink, missing_ok=True))
            state = self._saved.state
            self._seconds: dict[str, float] = dict(state.get("seconds", {}))
            self._passes: list[dict[str, Any]] = list(state.get("passes", []))
            folder.write_parameters(parameters)
            folder.write("parameters.toml", lambda: write_whole(folder.file("parameters.toml"), data.to_toml()))
        except BaseException:
            folder.close()
            raise

    def _find_finished(self) -> Summary | None:
        """Numbers of the folder if the same run is complete in it, on all ranks. Collective."""
        found: Summary | None = None
        if self._comm.rank == 0:
            with contextlib.suppress(OSError, ValueError, KeyError, TypeError):
                record = json.loads(self.run.file("summary.json").read_text(encoding="utf-8"))
                if record["run"] == self._identity and (not self._pictures or self.run.file("report.html").exists()):
                    found = Summary.of_dict(record["summary"])
        return self._comm.bcast(found)

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
        with self.run:
            return self._solve()

    def _solve(self) -> Summary:
        """As solve, in a folder that is locked. Collective."""
        data, run = self.data, self.run
        if self._finished is not None:
            run.print("the run is complete: without --resume it begins anew")
            run.print(report.text_table(report.rows_of(data, self._finished)))
            return self._finished
        model = self._stage("mesh", self._make_model)
        run.print(
            f"{model.num_cells} cells of {1e3 * data.cell_size:.2f} mm and more on {self._comm.size} rank(s); by Hertz "
            f"the contact's half-axes are {1e3 * data.hertz.a:.2f} mm along and {1e3 * data.hertz.b:.2f} mm across the "
            f"rail, its pressure {1e-6 * data.hertz.peak_pressure:.0f} MPa"
        )
        passage, state = Passage(model, self._progress), dict(self._saved.state)
        first, rolling = int(state.get("pass", 0)), bool(state.get("rolling", False))
        if self._goes_on:
            self._stage("restart", lambda: self._restart(passage, rolling))
        elif data.preset != "coarse" or data.shows_p2:
            self._stage("trial", lambda: self._predict(passage))
        summary: Summary | None = None
        for number in range(first, data.passes):
            summary = self._pass(passage, number, resumed=rolling and number == first)
            self._stage("unloading", passage.unload)
            summary = self._with_residual(passage, summary)
            self._passes.append(summary.as_dict())
            if number + 1 < data.passes:
                self._save(passage, number + 1)
        assert summary is not None
        run.write("summary.json", lambda: write_whole(run.file("summary.json"), json.dumps(
            {"identity": data.identity(), "run": self._identity, "parameters": data.to_toml(),
             "summary": summary.as_dict(), "passes": self._passes, "seconds": self._seconds},
            indent=1, default=float) + "\n"))  # fmt: skip
        if self._pictures:
            self._stage("drawing", lambda: self._draw_residual(passage))
            if len(self._passes) > 1 and passage.yields:
                run.pictures(figures.passages, run.file("passages.png"), self._passes)
            seconds = dict(self._seconds)
            run.write("report.html", lambda: report.write(
                run.file("report.html"), data, summary, CAPTIONS, seconds, self._passes))  # fmt: skip
            run.write("paraview_state.py", lambda: report.write_state(run.file("paraview_state.py")))
        self._saved.clear()
        run.print(report.text_table(report.rows_of(data, summary)))
        return summary

    def _make_model(self) -> JointModel:
        try:
            return JointModel(self.data, self._comm)
        except ValueError as error:
            raise UnusableJoint(str(error)) from error

    def _save(self, passage: Passage, number: int) -> None:
        """Save the state between two passages. Collective."""
        self._saved.save(
            {"pass": number, "rolling": False, "seconds": self._seconds, "passes": self._passes,
             "carried": passage.numbers}, dict, {"carried": passage.write_carried},
        )  # fmt: skip

    def _save_rolling(
        self, passage: Passage, number: int, history: History, static: Footprint | None, samples: Samples | None,
        frames: Sequence[str], keep: tuple[str, ...],
    ) -> None:  # fmt: skip
        """Save the state of a wheel that rolls. Collective."""
        run = passage.run
        assert run is not None

        def tables() -> dict[str, Any]:
            out = {**history.tables(), **_static_tables(static)}
            found = _samples(self.run.file("rolling") / "history.h5", samples)
            return out | ({} if found is None else found._asdict())

        write: dict[str, Callable[[Path], object]] = {"checkpoint": run.save}
        if "carried" not in keep:
            write["carried"] = passage.write_carried
        self._saved.save(
            {"pass": number, "rolling": True, "seconds": self._seconds, "passes": self._passes,
             "carried": passage.numbers, "frames": len(frames)}, tables, write, (*keep, *frames),
        )  # fmt: skip

    def _restart(self, passage: Passage, rolling: bool) -> None:
        """Read what was saved. Collective."""
        saved = self._saved
        try:
            if rolling:
                passage.resume(saved.file("checkpoint"))
            passage.read_carried(saved.file("carried"), saved.state["carried"])
        except ValueError as error:
            raise RuntimeError(f"{saved.path} cannot be gone on from: {error}") from error

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

    def _pass(self, passage: Passage, number: int, resumed: bool) -> Summary:
        """One passage and its numbers. Collective."""
        data, run, saved = self.data, self.run, self._saved
        what = f" {number + 1}" if data.passes > 1 else ""
        so_far: History | None = None
        samples: Samples | None = None
        begin = self._comm.rank == 0
        if resumed:
            problem = passage.run
            assert problem is not None
            run.print(f"goes on at {1e3 * (data.begin + data.speed * problem.time):+.1f} mm")
            static = None
            if begin:
                so_far, static = History.of_tables(saved.tables), _static_of(saved.tables)
                samples = Samples(*(saved.tables[name] for name in Samples._fields))
            so_far = self._comm.bcast(so_far)
        else:
            equilibrium = self._stage("preload" + what, passage.preload)
            problem = self._stage("start" + what, partial(passage.start, equilibrium))
            del equilibrium  # its matrices are larger than all that the wheel needs to roll
            static = passage.static_footprint
        assert problem is not None
        pictured = self._pictures and number == data.passes - 1
        frames = FrameSeries(passage.model, saved, run) if pictured else None
        if frames is not None and resumed:
            frames.read(passage, int(saved.state["frames"]))
        recorder = problem.record(
            run.file("rolling"), fields=(), points=self._points(), points_every=SAMPLES, every=10**9
        )
        keep = ["carried"] if resumed else []

        def save(history: History) -> None:
            names = frames.names if frames is not None else []
            self._save_rolling(passage, number, history, static, samples, names, tuple(keep))
            keep[:] = ["carried"]

        places = [float(x) for x in np.linspace(data.begin, data.end, self._frames)]
        if not resumed:
            save(passage.begun())
        show = None if frames is None else partial(frames.add, passage)
        history = self._stage("rolling" + what, lambda: passage.roll(
            places, show, save, self._interval, so_far=so_far))  # fmt: skip
        recorder.close()
        if frames is not None:
            frames.close()
        plastic = passage.plastic_strain()

        def numbers() -> tuple[Summary, FloatArray, Any]:
            found = _samples(run.file("rolling") / "history.h5", samples)
            assert found is not None
            ends, waves = _recorded(found, data)
            summary = summarise(
                data, history, passage.static_force, static, plastic, passage.model.num_cells, self._comm.size, ends
            )
            return summary, ends, waves

        summary, ends, waves = run.write("rolling", numbers)
        self._table(history, ends)
        if frames is not None:
            self._stage("pictures", lambda: run.pictures(self._draw, history, summary, frames, ends, waves))
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

    def _draw(self, history: History, summary: Summary, frames: FrameSeries, ends: FloatArray, waves: Any) -> None:
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
        pictures = frames.pictures
        six = [min(pictures, key=lambda p: abs(p.place - x)) for x in places]
        figures.sequence(file("sequence.png"), data, six, history)
        figures.animation(file("passage.gif"), data, pictures)
        nearest = min(range(len(pictures)), key=lambda k: abs(pictures[k].place - 0.5 * data.gap))
        edge = frames.shears[nearest]
        assert edge.values is not None  # rank 0 has them
        edge.values[:] *= 1e-6
        figures.field_on_rail(file("shear.png"), data, edge, "shear stress xz [MPa]", (-300.0, 300.0), "RdBu_r")

    def _residual(self, passage: Passage) -> dict[str, fem.Function]:
        """Stress of the rails without a wheel, at the nodes [Pa]. Collective."""
        residual = passage.residual
        assert residual is not None
        return NodalStress(passage.model, residual.u).evaluate(residual.history if passage.yields else None)

    def _with_residual(self, passage: Passage, summary: Summary) -> Summary:
        """The numbers with those of the residual stress of the heads near the path. Collective."""
        stress = {name: gather_field(f) for name, f in self._residual(passage).items() if name in RESIDUAL_NAMES}
        limits: list[float] = []
        if self._comm.rank == 0:
            points = stress["sigma_xx"].points
            assert points is not None
            near = (np.abs(points) < figures.ZONE).all(axis=1) & (points[:, 2] < SURFACE)
            along, von_mises = (v[near, 0] for v in (stress[name].values for name in RESIDUAL_NAMES) if v is not None)
            limits = [float(along.max()), float(along.min()), float(von_mises.max())]
        tension, compression, largest = self._comm.bcast(limits)
        return dataclasses.replace(
            summary, residual_tension=tension, residual_compression=compression, residual_von_mises=largest
        )

    def _draw_residual(self, passage: Passage) -> None:
        """Pictures of the unloaded rail. Collective."""
        residual, run, data = passage.residual, self.run, self.data
        assert residual is not None
        stress = {name: gather_field(f) for name, f in self._residual(passage).items()}
        largest = None
        if passage.yields:
            values = residual.history["plastic_strain"].values
            largest = gather_rows(self._comm, values.max(axis=tuple(range(1, values.ndim)), initial=0.0))

        def draw() -> None:
            for found in stress.values():
                assert found.values is not None and found.points is not None
                found.values[:] *= 1e-6
            along = stress["sigma_xx"]
            figures.residual(run.file("residual.png"), data, stress)
            if largest is not None:
                high = max(1e-4, 100.0 * float(largest.max()))
                label = "largest plastic strain of a cell's points [%]"
                figures.field_on_rail(run.file("plastic.png"), data, along, label, (0.0, high), by_cell=100.0 * largest)

        run.pictures(draw)


def _moments(data: RailJoint) -> list[float]:
    """Six places of the wheel to look at."""
    a, half = data.hertz.a, 0.5 * data.gap
    return [data.begin, -half - 0.5 * a, 0.0, half + 0.5 * a, min(half + 1.5 * a, 0.6 * data.end), data.end]


class Samples(NamedTuple):
    """Points that were sampled.

    Attributes:
        sample_time: (n) [s].
        sample_displacement: (n, points, 3) [m].
        sample_velocity: (n, points, 3) [m/s].
    """

    sample_time: FloatArray
    sample_displacement: FloatArray
    sample_velocity: FloatArray


def _samples(path: Path, before: Samples | None) -> Samples | None:
    """Samples of the recorder's file, behind those from before the run was resumed."""
    with h5py.File(path) as file:
        new = Samples(*(file[f"points/{name}"][:] for name in ("time", "displacement", "velocity")))
    if before is None:
        return new
    later = new.sample_time > before.sample_time[-1] if len(before.sample_time) else np.ones(len(new[0]), dtype=bool)
    return Samples(*(np.concatenate([old, rows[later]]) for old, rows in zip(before, new)))


def _recorded(found: Samples, data: RailJoint) -> tuple[FloatArray, tuple[FloatArray, FloatArray, FloatArray]]:
    """Rail ends (place, two heights), and time, stations and velocities."""
    t, u, v = found
    ends = np.column_stack([data.begin + data.speed * t, u[:, 0, 2], u[:, 1, 2]])
    return ends, (t, np.array(STATIONS), v[:, 2:, 0])


def _static_tables(found: Footprint | None) -> dict[str, FloatArray]:
    """Footprint of the preload as arrays; on rank 0."""
    assert found is not None
    return {"static": np.column_stack([found.points, found.pressure, found.weight]), "static_at": np.array(found.place)}


def _static_of(tables: Mapping[str, FloatArray]) -> Footprint:
    rows = tables["static"]
    return Footprint(float(tables["static_at"]), rows[:, :3], rows[:, 3], rows[:, 4])


__all__ = ["FRAMES", "Case", "UnusableJoint"]
