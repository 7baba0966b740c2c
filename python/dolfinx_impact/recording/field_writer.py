# SPDX-License-Identifier: MIT
"""Frames of the fields of a problem, in a series of files for each element."""

from __future__ import annotations

import contextlib
from collections.abc import Sequence

from dolfinx.fem import Function

from ..common.described import Described
from ..common.units import Units
from ..io.frames import Frames
from ..io.run_folder import RunFolder
from ..io.xdmf_series import XdmfSeries
from .field_source import FieldSource

ENDINGS = (".bp", ".xdmf")


class FieldWriter(Described):
    """Writes frames of fields into a folder.

    Args:
        folder: RunFolder that the series are written into.
        sources: what is written.
        ending: ".bp" for ADIOS2's format, ".xdmf" for XDMF with HDF5.
        units: units that the names of fields end with; None: names alone.

    Attributes:
        dimensions: dimension of every field, by the name that it has without a unit.

    Raises:
        RuntimeError: no room, or the folder cannot be written; on all ranks.
    """

    def __init__(
        self, folder: RunFolder, sources: Sequence[FieldSource], ending: str = ".bp", units: Units | None = None
    ) -> None:
        self.sources, self.dimensions = list(sources), {}
        self._series: list[Frames | XdmfSeries] = []
        for source in self.sources:
            dimensions = dict(zip((f.name for f in source.functions), source.dimensions))
            self.dimensions |= dimensions
            known = units or Units()
            in_units = {name: known.of(d) for name, d in dimensions.items() if d}
            names = {name: f"{name} [{in_units[name]}]" if units and name in in_units else name for name in dimensions}
            # They share their values with the source's functions, whose names stay as they are.
            functions = [Function(f.function_space, f.x, name=names[f.name]) for f in source.functions]
            if ending == ".xdmf":
                self._series.append(XdmfSeries(folder, f"{source.series}.xdmf", functions, list(in_units.items())))
            else:
                self._series.append(Frames(folder, f"{source.series}.bp", functions))

    def write(self, now: float) -> None:
        """Add a frame with the present values to every series. Collective.

        Args:
            now: time of the frame [T].

        Raises:
            RuntimeError: no room; on all ranks.
        """
        for source, series in zip(self.sources, self._series):
            source.update()
            series.write(now)

    def close(self) -> None:
        """Close all series, whatever the first ones raise. Collective.

        Raises:
            RuntimeError: the end of a series cannot be written; on all ranks.
        """
        series, self._series = self._series, []
        with contextlib.ExitStack() as stack:
            for one in reversed(series):
                stack.callback(one.close)
