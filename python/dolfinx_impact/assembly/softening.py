# SPDX-License-Identifier: MIT
"""Warning about yield stresses that fall: plastic strain localises, and the result depends on the mesh."""

import warnings

import numpy as np
from dolfinx.fem import Function
from dolfinx.mesh import Mesh
from mpi4py import MPI

from .. import compat
from ..common.types import IntArray
from ..materials import Material
from ..plasticity import J2Plasticity


def warn_of_softening(u: Function, material: Material) -> None:
    """Warn on rank 0, once for each material of a problem that softens. Collective.

    Softening in a layer of cells of the length h between elastic ones: the body of length L gives way by
    dsigma (L/E + h/H), which with H < 0 changes its sign at h = L |H|/E. With shorter cells the body snaps back under a
    prescribed displacement.

    Args:
        u: displacement function.
        material: material of the bodies.
    """
    mesh = u.function_space.mesh
    tags = material.cell_tags
    for tag, part in material.parts():
        if not isinstance(part, J2Plasticity) or part.steepest_softening == 0.0:
            continue
        shortest, longest, extent = _lengths(mesh, None if tag is None or tags is None else tags.find(tag))
        if mesh.comm.rank != 0:
            continue
        slope = part.steepest_softening
        warnings.warn(
            f"J2Plasticity softens: its yield stress falls over the plastic strain with a slope of up to {slope:.6g} "
            "[F/L^2]. Plastic strain localises in one layer of cells, and the result depends on the mesh: the element "
            f"length is {shortest:.4g} to {longest:.4g} [L], and the slope holds for this length only. A body of the "
            f"length {extent:.4g} [L] snaps back under a prescribed displacement if the element length is below "
            f"{extent * -slope / part.E:.4g} [L]",
            stacklevel=3,
        )


def _lengths(mesh: Mesh, cells: IntArray | None) -> tuple[float, float, float]:
    """Least and largest element length, the largest distance of two vertices of a cell, and the largest extent of the
    cells, on all ranks; `cells` None: all of them."""
    tdim, num_owned = mesh.topology.dim, mesh.topology.index_map(mesh.topology.dim).size_local
    cells = np.arange(num_owned, dtype=np.int32) if cells is None else cells[cells < num_owned]
    h = mesh.h(tdim, cells)
    x = mesh.geometry.x[np.unique(compat.geometry_dofmap(mesh)[cells])]
    low = np.concatenate([[h.min(initial=np.inf)], x.min(axis=0, initial=np.inf)])
    high = np.concatenate([[h.max(initial=-np.inf)], x.max(axis=0, initial=-np.inf)])
    mesh.comm.Allreduce(MPI.IN_PLACE, low, op=MPI.MIN)
    mesh.comm.Allreduce(MPI.IN_PLACE, high, op=MPI.MAX)
    return float(low[0]), float(high[0]), float((high[1:] - low[1:]).max())
