# SPDX-License-Identifier: MIT
"""Output of a run while it runs: fields for ParaView, histories in HDF5."""

from __future__ import annotations

import contextlib
import math
import time
import warnings
from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt
from mpi4py import MPI

from ..assembly.fields import is_mixed
from ..common import arguments
from ..common.collective import is_common
from ..common.types import AnyArray, ArrayLike, FilePath, FloatArray
from ..io import hdf5
from ..io.output_folder import FolderGone
from ..io.run_folder import RunFolder
from ..common.units import Units
from ..recording.field_arguments import check_fields
from ..recording.field_sources import field_sources
from ..recording.field_writer import FieldWriter
from ..recording.names import MOTION
from ..recording.output_options import OutputOptions
from .row_blocks import RowBlocks
from .run_history import ENERGIES

if TYPE_CHECKING:
    import h5py

    from .problem_in_time import ProblemInTime

ROWS = 100_000  # largest number of history rows that wait in memory
INTERVAL = 1.0  # s of wall-clock time: opening the file takes milliseconds, as long as several steps of a small model


def check_arguments(
    problem: ProblemInTime,
    path: FilePath | None,
    fields: Iterable[str],
    every: int,
    points: ArrayLike | None,
    points_every: int,
    options: OutputOptions,
) -> tuple[tuple[str, ...], FloatArray | None]:
    """Check the arguments of a Recorder on this rank.

    Args:
        problem: problem in time.
        path: folder, or None.
        fields: names of fields.
        every: steps between frames [1].
        points: points, (n, gdim) or (gdim); None: no points [L].
        points_every: steps between samples of points [1].
        options: how fields are written, and expressions.

    Returns:
        `fields`, and `points` as an array (n, gdim) or None.

    Raises:
        TypeError: an argument is of the wrong type.
        ValueError: a field is unknown, a number is not positive, or points have too few or infinite coordinates.
    """
    if path is not None:
        arguments.path("path", path)
    names = check_fields(problem, fields, list(MOTION), options)
    if is_mixed(problem.space) and points is not None:
        raise ValueError("points: u is on a mixed space, which has no nodes whose values are the displacement")
    for name, number in (("every", every), ("points_every", points_every)):
        arguments.integer(name, number, 1, unit=" of steps")
    if points is None:
        return names, None
    gdim = problem.space.mesh.geometry.dim
    try:
        x = np.atleast_2d(np.asarray(points, dtype=float))
    except (TypeError, ValueError):
        raise TypeError(f"points must be numbers of shape (n, {gdim}), found {points!r:.60}") from None
    if x.ndim != 2 or x.shape[1] < gdim:
        raise ValueError(f"points have {x.shape[-1]} coordinates: {gdim} are needed")
    if not np.all(np.isfinite(x)):
        raise ValueError("points have coordinates that are not finite: give places in the body")
    return names, x


class Recorder:
    """Writes frames and histories of a problem in time into a folder; made by the problem's `record`.

    Files: fields.bp has the motion (ParaView 5.12 or newer); materials.bp the stresses, internal variables and
    expressions, averaged at the vertices: a scalar for each component, stress_xx, ... and back_stress_0, ...;
    contact.bp the results of contacts at the nodes of the slaves, pressure, slip_x, ...: with several contacts,
    pressure_0, ... history.h5 has `time`, energies and contact forces `force_0`, ... of every step, and `points/time`,
    `points/displacement` and `points/velocity` of shape (frames, points, gdim). Datasets have units as attributes, and
    the group `fields` those of the fields; without `units`, T, L and F stand for time, length, force.

    Histories are written with frames, at most once a second; after 100,000 steps; with checkpoints; when `advance` ends
    by an exception; and by `close`. If the disk is full, `advance` ends with a RuntimeError after a step. The files can
    then be read, and the rows that are missing in them are kept and written when there is room. If the folder is
    removed during the run, the run warns once and goes on without the recorder; `close` raises an error then.

    Args:
        problem: problem in time.
        recorders: recorders that its time stepper runs; this one is appended.
        update_functions: sets the problem's functions to the present time.
        path: folder; None as for RunFolder.
        fields: names of fields, as check_fields returned them.
        every: steps between frames [1].
        points: points whose nearest nodes are sampled, (n, gdim); None: no points [L].
        points_every: steps between samples of points [1].
        times: times of frames, if there are any in place of `every`; the stepper must meet them [T].
        name: beginning of the folder's name if `path` is None.
        options: how fields are written, and expressions; None: neither.

    Attributes:
        folder: RunFolder with the files.
        fields: writer of the frames.
        seconds: wall-clock time that frames, samples and histories have taken during the run [s].

    Raises:
        RuntimeError: the folder cannot be written; on all ranks.
    """

    def __init__(
        self,
        problem: ProblemInTime,
        recorders: list[Recorder],
        update_functions: Callable[[], None],
        path: FilePath | None,
        fields: Sequence[str],
        every: int,
        points: FloatArray | None,
        points_every: int,
        times: Sequence[float] = (),
        name: str = "explicit",
        options: OutputOptions | None = None,
    ) -> None:
        options = options or OutputOptions({}, ".bp", None)
        self._units = options.units or Units()
        self._times = sorted(times)
        self.problem, self.every, self.points_every = problem, int(every), int(points_every)
        self._recorders, self._update_functions = recorders, update_functions
        self._nodes = [] if points is None else self._nearest(points)
        self.folder = RunFolder(path, {}, comm=problem.comm, name=name)
        functions = {"displacement": problem.u, "velocity": problem.velocity, "acceleration": problem.acceleration}
        for name, f in functions.items():
            f.name = name
        sources = field_sources(problem, fields, functions, options)
        self.fields = FieldWriter(self.folder, sources, options.ending, options.units)
        self._samples: list[tuple[float, FloatArray]] = []
        self._rows: RowBlocks | None = None  # those that wait
        self._frame = -1
        self._gone: FolderGone | None = None
        self._open()
        self._flushed = time.monotonic()
        self.seconds = 0.0
        self.after()
        recorders.append(self)

    def __repr__(self) -> str:
        due = f"at {len(self._times)} times" if self._times else f"every {self.every} steps"
        return f"Recorder({str(self.folder.path)!r}, {due}: {', '.join(self.fields.dimensions) or 'histories alone'})"

    def _nearest(self, points: FloatArray) -> list[tuple[int, int]]:
        """Rank and local number of the node nearest to each point. Collective."""
        V, comm = self.problem.space, self.problem.comm
        x = V.tabulate_dof_coordinates()[: V.dofmap.index_map.size_local, : V.mesh.geometry.dim]
        out = []
        for p in points[:, : x.shape[1]]:
            distance = np.linalg.norm(x - p, axis=1)
            node = int(np.argmin(distance)) if len(x) else -1
            _, rank = comm.allreduce((float(distance[node]) if len(x) else np.inf, comm.rank), MPI.MINLOC)
            out.append((rank, node))
        return out

    def _open(self) -> None:
        """Create the history file with extendible datasets, on rank 0."""

        def fill(file: h5py.File) -> None:
            gdim, grow = self.problem.space.mesh.geometry.dim, {"chunks": True}
            names = {"time": "T", **{name: "F L" for name in ENERGIES}}
            for name, unit in names.items():
                d = file.create_dataset(name, (0,), maxshape=(None,), dtype=float, **grow)
                d.attrs["units"] = self._units.of(unit)
            for k, contact in enumerate(self.problem.contact):
                d = file.create_dataset(f"force_{k}", (0, gdim), maxshape=(None, gdim), dtype=float, **grow)
                d.attrs["units"], d.attrs["contact"] = self._units.of("F"), contact.pair.name
            fields = file.create_group("fields")
            for name, dimension in self.fields.dimensions.items():
                fields.attrs[name] = self._units.of(dimension)
            if self._nodes:
                shape = (0, len(self._nodes), self.problem.space.dofmap.index_map_bs)
                d = file.create_dataset("points/time", (0,), maxshape=(None,), dtype=float, **grow)
                d.attrs["units"] = self._units.of("T")
                for name in ("displacement", "velocity"):
                    d = file.create_dataset(f"points/{name}", shape, maxshape=(None, *shape[1:]), dtype=float, **grow)
                    d.attrs["units"] = self._units.of(MOTION[name])

        self.folder.write("history.h5", lambda: hdf5.create(self.folder.file("history.h5"), fill))

    def steps_left(self) -> int:
        """Distance to the next output.

        Returns:
            Number of steps until the next frame or sample [1].
        """
        step = self.problem.step
        waits = [self.every - step % self.every]
        if self._nodes:
            waits.append(self.points_every - step % self.points_every)
        return min(waits)

    @property
    def next_time(self) -> float:
        """Time of the next frame that is given by a time; infinite if there is none [T]."""
        return next((t for t in self._times if t > self.problem.time), math.inf)

    def _frame_is_due(self) -> bool:
        """Whether a frame is written at the present step."""
        p = self.problem
        return p.time in self._times if self._times else p.step % self.every == 0

    def add(self, rows: npt.NDArray[np.void]) -> None:
        """Add rows that the next `flush` writes.

        Args:
            rows: (n) rows of RunHistory.row_type.
        """
        if self._gone is not None:
            return
        if self._rows is None:
            self._rows = RowBlocks(rows.dtype)
        self._rows.add(rows)

    def after(self) -> None:
        """Write frame, sample and histories if they are due after the present step. Collective.

        Raises:
            RuntimeError: no room; on all ranks.
        """
        if self._gone is not None:
            return
        try:
            self._write_what_is_due()
        except FolderGone as gone:
            self._give_up(gone)

    def _give_up(self, gone: FolderGone) -> None:
        """Record nothing more: nobody could read it, and the run is worth more than its records. Collective."""
        p, self._gone = self.problem, gone
        self._rows, self._samples = None, []
        if p.comm.rank == 0:
            warnings.warn(f"{gone}; from the time {p.time:.6g} the run goes on without its recorder", stacklevel=2)
        with contextlib.suppress(RuntimeError):
            self.fields.close()

    def _write_what_is_due(self) -> None:
        p, begin = self.problem, time.perf_counter()
        frame, sample = self._frame_is_due(), bool(self._nodes) and p.step % self.points_every == 0
        if (frame or sample) and p.step != self._frame:
            self._update_functions()
            self._frame = p.step
            if sample:
                self._sample()
            if frame:
                self.fields.write(p.time)
                if p.comm.bcast(time.monotonic() - self._flushed > INTERVAL, root=0):
                    self._flush()
            self.seconds += time.perf_counter() - begin
        if self._rows is not None and len(self._rows) > ROWS:
            self._flush()
            self.seconds += time.perf_counter() - begin

    def _sample(self) -> None:
        p, values = self.problem, []
        for rank, node in self._nodes:
            mine = [f.x.array.reshape(-1, p.space.dofmap.index_map_bs)[node].copy() if p.comm.rank == rank else None
                    for f in (p.u, p.velocity)]  # fmt: skip
            values.append(p.comm.bcast(mine, root=rank))
        self._samples.append((p.time, np.array(values)))

    def flush(self) -> None:
        """Write the rows and samples that wait in memory. Collective.

        Raises:
            RuntimeError: no room; on all ranks. The file has what was written before; the rest is kept for the next
                call.
        """
        if self._gone is not None:
            return
        try:
            self._flush()
        except FolderGone as gone:
            self._give_up(gone)

    def _flush(self) -> None:
        p, samples, rows = self.problem, self._samples, self._rows

        def work(file: h5py.File) -> None:
            if rows:
                for name in ("time", *ENERGIES):
                    _append(file[name], np.concatenate([block[name] for block in rows]))
                for k in range(len(p.contact)):
                    gdim = p.space.mesh.geometry.dim
                    _append(file[f"force_{k}"], np.concatenate([block["force"][:, k, :gdim] for block in rows]))
            if samples:
                values = np.array([v for _, v in samples])
                _append(file["points/time"], np.array([t for t, _ in samples]))
                for k, name in enumerate(("displacement", "velocity")):
                    _append(file[f"points/{name}"], values[:, :, k])

        self.folder.write("history.h5", lambda: hdf5.update(self.folder.file("history.h5"), work))
        self._rows, self._samples, self._flushed = None, [], time.monotonic()

    def close(self) -> None:
        """Write what waits in memory, close the files and stop recording. Collective.

        Raises:
            FolderGone: the folder was removed before; its files are given up.
            RuntimeError: no room for what waits in memory; the files are closed nevertheless.
        """
        try:
            if self._gone is not None:
                raise self._gone
            self._flush()
        except BaseException as error:
            if is_common(self.problem.comm, error):
                self._stop()
            raise
        self._stop()

    def _stop(self) -> None:
        """Close the files and stop recording. Collective."""
        if self in self._recorders:
            self._recorders.remove(self)
        self.fields.close()


def _append(dataset: h5py.Dataset, rows: AnyArray) -> None:
    size = len(dataset)
    dataset.resize(size + len(rows), axis=0)
    dataset[size:] = rows
