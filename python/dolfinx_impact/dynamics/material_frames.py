# SPDX-License-Identifier: MIT
"""Frames of internal variables and stresses of an explicit run, averaged at the vertices."""

from __future__ import annotations

from collections.abc import Sequence

from dolfinx import fem
from dolfinx.mesh import Mesh

from ..assembly.history import HistoryField, MaterialHistory
from ..assembly.inelastic_stress import STRESS, components
from ..io.frames import Frames
from ..io.run_folder import RunFolder


def component_names(field: HistoryField, gdim: int) -> list[str]:
    """Names of the components of a field.

    Args:
        field: the field.
        gdim: dimension.

    Returns:
        The field's name for a number; stress_xx, ... for the stress; else the name with the number of each component.
    """
    if not field.shape:
        return [field.name]
    if field.name == STRESS:
        return [f"{field.name}_{'xyz'[i]}{'xyz'[j]}" for i, j in components(gdim)]
    return [f"{field.name}_{k}" for k in range(field.shape[0])]


class MaterialFrames:
    """Series of frames materials.bp. A series has functions of one element, so that each component is a scalar.

    Args:
        folder: RunFolder that the series is written into.
        history: internal variables of the problem.
        mesh: mesh of the problem.
        names: names of fields of `history`.

    Raises:
        RuntimeError: no room, or the folder cannot be written; on all ranks.
    """

    def __init__(self, folder: RunFolder, history: MaterialHistory, mesh: Mesh, names: Sequence[str]) -> None:
        self._fields = [history[name] for name in names]
        space = fem.functionspace(mesh, ("Lagrange", 1))
        self._functions = [
            [fem.Function(space, name=name) for name in component_names(field, mesh.geometry.dim)]
            for field in self._fields
        ]
        self._frames = Frames(folder, "materials.bp", [f for functions in self._functions for f in functions])

    def write(self, now: float) -> None:
        """Add a frame with the present values. Collective.

        Args:
            now: time of the frame [T].

        Raises:
            RuntimeError: no room; on all ranks.
        """
        for field, functions in zip(self._fields, self._functions):
            values = field.at_nodes().x.array.reshape(-1, len(functions))
            for k, f in enumerate(functions):
                f.x.array[:] = values[:, k]
        self._frames.write(now)

    def close(self) -> None:
        """Close the series. Collective.

        Raises:
            RuntimeError: the end of the series cannot be written; on all ranks.
        """
        self._frames.close()
