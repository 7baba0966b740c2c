# SPDX-License-Identifier: MIT
"""Coefficients and coordinates of cells, side by side as kernels take them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from dolfinx import fem
from dolfinx.mesh import Mesh

from .. import _cpp, compat
from ..common.types import FloatArray, IntArray


def packed_cells(
    mesh: Mesh, kernel: _cpp.kernels.Kernel, functions: Mapping[str, fem.Function], cells: IntArray
) -> tuple[FloatArray, FloatArray]:
    """Coefficients and coordinates of cells.

    Args:
        mesh: their mesh.
        kernel: kernel that reads them.
        functions: its coefficients by name.
        cells: local numbers, (n).

    Returns:
        Coefficients, (n, size of a cell's coefficients), and coordinates, (n, nodes of a cell, 3) [L].
    """
    w = np.zeros((len(cells), sum(c["num_dofs"] for c in kernel.coefficients)))
    for c in kernel.coefficients:
        f = functions[c["name"]]
        dofmap = f.function_space.dofmap
        values = f.x.array.reshape(-1, dofmap.bs)[dofmap.list[cells]]
        w[:, c["offset"] : c["offset"] + c["num_dofs"]] = values.reshape(len(cells), c["num_dofs"])
    return w, mesh.geometry.x[compat.geometry_dofmap(mesh)[cells]]
