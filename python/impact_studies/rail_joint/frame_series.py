# SPDX-License-Identifier: MIT
"""Fields of moments of a passage: for ParaView, for pictures, and saved for a run that goes on."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from dolfinx import fem

from dolfinx_impact import _cpp
from dolfinx_impact.common.types import FloatArray
from dolfinx_impact.dynamics.subject import in_time
from dolfinx_impact.io import checkpoint
from dolfinx_impact.io.checkpoint import Place, State
from dolfinx_impact.io.frames import Frames
from dolfinx_impact.io.gather import Gathered, gather_field
from . import figures
from .model import JointModel
from .passage import Frame, Passage
from .saved_case import SavedCase
from .stress import NAMES


def _frame(displacement: FloatArray, stress: FloatArray) -> _cpp.state.State:
    """Values at owned nodes as a state: views of arrays with rows by node."""
    out = State("frame")
    out.add("displacement", Place.node, np.asarray(displacement, dtype=np.float64))
    out.add("stress", Place.node, np.asarray(stress, dtype=np.float64))
    return out


class FrameSeries:
    """Frames of a passage in frames.bp, gathered for pictures, and saved.

    Args:
        model: the joint.
        saved: where frames are saved.
        run: folder of the run.

    Attributes:
        pictures: of all frames; their fields are on rank 0.
        shears: shear stress of all frames.
        names: under which the frames are saved.
    """

    def __init__(self, model: JointModel, saved: SavedCase, run: Any) -> None:
        self._saved = saved
        self.pictures: list[figures.Picture] = []
        self.shears: list[Gathered] = []
        self.names: list[str] = []
        self._displacement = fem.Function(model.V, name="displacement")
        scalars = fem.functionspace(model.mesh, ("Lagrange", 1))
        self._stress = {name: fem.Function(scalars, name=name) for name in NAMES}
        # Nodes of both spaces are those of the cells, in the same order.
        self._dofs, self._scalar_dofs = model.V.dofmap.list.ravel(), scalars.dofmap.list.ravel()
        self._writer = Frames(run, "frames.bp", [self._displacement, *self._stress.values()])

    def add(self, passage: Passage, frame: Frame) -> None:
        """Keep a frame. Collective.

        Args:
            passage: whose frame it is.
            frame: fields of the moment.
        """
        run = passage.run
        assert run is not None
        for name, f in self._stress.items():
            f.x.array[:] = frame.stress[name].x.array
        self._displacement.x.array[:] = frame.displacement.x.array
        V = run.space
        n = V.dofmap.index_map.size_local
        columns = np.zeros((n + V.dofmap.index_map.num_ghosts, len(NAMES)))
        columns[self._dofs] = np.column_stack([f.x.array for f in self._stress.values()])[self._scalar_dofs]
        state = _frame(self._displacement.x.array.reshape(-1, 3)[:n], columns[:n])
        moment = {"moment": np.array([frame.time, frame.place])}
        name = f"frame_{len(self.names)}"
        self._saved.add(name, lambda path: checkpoint.write(path, in_time(run), state, moment))
        self._keep(name, frame.time, frame.place)

    def _keep(self, name: str, time: float, place: float) -> None:
        """Write and gather the present fields. Collective."""
        self.names.append(name)
        self._writer.write(time)
        self.pictures.append(
            figures.Picture(place, gather_field(self._displacement), gather_field(self._stress["von_mises"]))
        )
        self.shears.append(gather_field(self._stress["tau_xz"]))

    def read(self, passage: Passage, count: int) -> None:
        """Read frames that were saved before the run was killed. Collective.

        Args:
            passage: resumed.
            count: number of frames.

        Raises:
            RuntimeError: a file is damaged; on all ranks.
        """
        for k in range(count):
            name = f"frame_{k}"
            self._read(passage, self._saved.file(name), partial(self._keep, name))

    def _read(self, passage: Passage, path: Path, keep: Any) -> None:
        run = passage.run
        assert run is not None
        V = run.space
        values = fem.Function(V)
        n = V.dofmap.index_map.size_local
        like = _frame(np.zeros((n, 3)), np.zeros((n, len(NAMES))))
        found, attributes = checkpoint.read(path, in_time(run), like, ["moment"])
        self._displacement.x.array.reshape(-1, 3)[:n] = found.array("displacement")
        self._displacement.x.scatter_forward()
        for k, f in enumerate(self._stress.values()):
            values.x.array.reshape(-1, 3)[:n, 0] = found.array("stress")[:, k]
            values.x.scatter_forward()
            f.x.array[self._scalar_dofs] = values.x.array.reshape(-1, 3)[self._dofs, 0]
        keep(*attributes["moment"].tolist())

    def close(self) -> None:
        """Close frames.bp. Collective."""
        self._writer.close()
