# SPDX-License-Identifier: MIT
"""Output of load steps: fields for ParaView, contact forces in HDF5."""

from __future__ import annotations

import contextlib
import warnings
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from ..common.types import FilePath
from ..common.units import Units
from ..io import hdf5
from ..io.output_folder import FolderGone
from ..io.run_folder import RunFolder
from ..recording.field_arguments import RecordedProblem
from ..recording.field_sources import field_sources
from ..recording.field_writer import FieldWriter
from ..recording.output_options import OutputOptions

if TYPE_CHECKING:
    import h5py


class RecordedStatics(RecordedProblem, Protocol):
    """A static problem as its recorders see it.

    Attributes:
        axisymmetric: whether x is the radius.
        recorders: recorders that write during a solve.
    """

    axisymmetric: bool
    recorders: list[LoadStepRecorder]


class LoadStepRecorder:
    """Writes frames and contact forces of a static problem into a folder; made by its `record`.

    Files, as of Recorder: fields.bp, materials.bp, contact.bp. history.h5 has a row for each frame: `load_step`, and
    for each contact `force_0`, ... (frames, gdim) and `area_0`, ... (frames). The load step is the number of solves so
    far, one whose loads have been applied in part counting by its part: 0.25, 0.5, ... in a first solve in four steps.

    If the folder is removed the problem warns once and goes on without the recorder; `close` raises an error then.

    Args:
        problem: the problem; this recorder is appended to its `recorders`.
        path: folder; None as for RunFolder.
        fields: names of fields, as check_fields returned them.
        every: increments between frames; the end of a solve is always written [1].
        options: how fields are written, and expressions.

    Attributes:
        folder: RunFolder with the files.
        fields: writer of the frames.

    Raises:
        RuntimeError: the folder cannot be written; on all ranks.
    """

    def __init__(
        self, problem: RecordedStatics, path: FilePath | None, fields: Sequence[str], every: int, options: OutputOptions
    ) -> None:
        self.problem, self._every, self._units = problem, every, options.units or Units()
        self.folder = RunFolder(path, {}, comm=problem.space.mesh.comm, name="static")
        sources = field_sources(problem, fields, {"displacement": problem.u}, options)
        self.fields = FieldWriter(self.folder, sources, options.ending, options.units)
        self._before = self._now = 0.0  # load steps at the start of the present solve, and now
        self._increments = 0  # since the last frame
        self._gone: FolderGone | None = None
        self._open()
        problem.recorders.append(self)

    def __repr__(self) -> str:
        names = ", ".join(self.fields.dimensions) or "histories alone"
        return f"LoadStepRecorder({str(self.folder.path)!r}, every {self._every} increments: {names})"

    def _open(self) -> None:
        """Create the file of forces, on rank 0."""
        gdim = self.problem.space.mesh.geometry.dim

        def fill(file: h5py.File) -> None:
            grow = {"dtype": float, "chunks": True}
            file.create_dataset("load_step", (0,), maxshape=(None,), **grow).attrs["units"] = "1"
            for k, contact in enumerate(self.problem.contact):
                force = file.create_dataset(f"force_{k}", (0, gdim), maxshape=(None, gdim), **grow)
                area = file.create_dataset(f"area_{k}", (0,), maxshape=(None,), **grow)
                force.attrs["units"], force.attrs["contact"] = self._units.of("F"), contact.pair.name
                area.attrs["units"] = self._units.of("L^2" if gdim == 3 or self.problem.axisymmetric else "L")
            fields = file.create_group("fields")
            for name, dimension in self.fields.dimensions.items():
                fields.attrs[name] = self._units.of(dimension)

        self.folder.write("history.h5", lambda: hdf5.create(self.folder.file("history.h5"), fill))

    def begin(self) -> None:
        """A solve begins."""
        self._before = self._now

    def after(self, fraction: float) -> None:
        """Write a frame if it is due after a converged increment. Collective.

        Args:
            fraction: part of the load step that has been reached [1].

        Raises:
            RuntimeError: no room; on all ranks.
        """
        self._now, self._increments = self._before + fraction, self._increments + 1
        if self._gone is not None or (self._increments < self._every and fraction < 1.0):
            return
        self._increments = 0
        try:
            self.fields.write(self._now)
            self._write_row()
        except FolderGone as gone:
            self._gone = gone
            if self.folder.comm.rank == 0:
                warnings.warn(f"{gone}; from the load step {self._now:g} on nothing is recorded", stacklevel=2)
            with contextlib.suppress(RuntimeError):
                self.fields.close()

    def _write_row(self) -> None:
        """Add the present forces to the history. Collective."""
        gdim = self.problem.space.mesh.geometry.dim
        forces = [np.zeros(gdim) if c.force is None else c.force for c in self.problem.contact]
        areas = [c.area for c in self.problem.contact]

        def add(file: h5py.File) -> None:
            rows: dict[str, Any] = {f"force_{k}": force for k, force in enumerate(forces)}
            rows["load_step"] = self._now
            rows |= {f"area_{k}": area for k, area in enumerate(areas)}
            for name, value in rows.items():
                file[name].resize(len(file[name]) + 1, axis=0)
                file[name][-1] = value

        self.folder.write("history.h5", lambda: hdf5.update(self.folder.file("history.h5"), add))

    def close(self) -> None:
        """Close the files and stop recording. Collective.

        Raises:
            FolderGone: the folder was removed before.
            RuntimeError: the end of a file cannot be written; on all ranks.
        """
        if self in self.problem.recorders:
            self.problem.recorders.remove(self)
        if self._gone is not None:
            raise self._gone
        self.fields.close()
