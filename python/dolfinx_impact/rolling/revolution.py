# SPDX-License-Identifier: MIT
"""Check that a spinning body is one of revolution: no material flows through its boundary."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import ufl
from dolfinx import fem
from dolfinx.mesh import MeshTags, exterior_facet_indices

from .. import compat
from ..assembly.ffcx_form import ffcx_form
from ..common.cell_numbers import input_cell_numbers
from ..common.types import FloatArray
from .motions import Spin

# Root mean square of w . N over |w| on a facet, over the facet's size divided by its distance from the axis. A chord of
# a circle has 0.29, a triangle of a sphere less than 0.6.
FACETED = 0.6
ROUND_OFF = 1e-9  # of |w|, on facets of any size


def fault(V: fem.FunctionSpace, cell_tags: MeshTags, tag: int, spin: Spin, bcs: Sequence[fem.DirichletBC] = ()) -> str:
    """Describe the worst cell through whose boundary the spinning material flows. Collective.

    Material may flow through facets that are held: the ends of a sector.

    Args:
        V: displacement space.
        cell_tags: tags of the bodies.
        tag: tag of the spinning body.
        spin: its motion.
        bcs: boundary conditions.

    Returns:
        A sentence on all ranks; an empty text if the body is one of revolution.
    """
    mesh = V.mesh
    tdim = mesh.topology.dim
    mesh.topology.create_connectivity(tdim - 1, tdim)
    mesh.topology.create_connectivity(tdim, tdim - 1)
    facets = exterior_facet_indices(mesh.topology)
    to_cell = mesh.topology.connectivity(tdim - 1, tdim)
    cells = np.array([to_cell.links(f)[0] for f in facets], dtype=np.int32)
    own = np.isin(cells, cell_tags.find(tag)) & (cells < mesh.topology.index_map(tdim).size_local)
    facets, cells = facets[own], cells[own]
    piecewise = fem.functionspace(mesh, ("DG", 0))
    c, N, w = ufl.TestFunction(piecewise), ufl.FacetNormal(mesh), spin.velocity(mesh, 1.0)

    def on_cells(integrand: ufl.core.expr.Expr) -> FloatArray:
        values = fem.assemble_vector(ffcx_form(integrand * c * ufl.ds(domain=mesh, degree=4)))
        return values.array[cells]

    free = fem.Function(V)
    free.x.array[:] = 1.0
    for bc in bcs:
        free.x.array[bc.dof_indices()[0]] = 0.0
    free.x.scatter_forward()
    through, along = on_cells(ufl.inner(w, N) ** 2 * ufl.inner(free, free)), on_cells(ufl.inner(w, w))
    area = on_cells(ufl.as_ufl(1.0) * ufl.inner(N, N))
    # Facets are straight or curved: their size is the distance of their vertices.
    of_cell = np.zeros(int(cells.max(initial=-1)) + 1)
    if len(facets):
        np.maximum.at(of_cell, cells, mesh.h(tdim - 1, facets))  # the integrals are of all facets of a cell
    size = of_cell[cells]
    radius = np.sqrt(along / np.where(area > 0, area, 1.0))
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.sqrt(through) / np.where(along > 0, np.sqrt(along), 1.0)
        allowed = np.where(radius > 0, FACETED * size / radius, np.inf) + ROUND_OFF
    excess = np.where(along > 0, ratio / allowed, 0.0)
    worst = int(np.argmax(excess)) if len(excess) else -1
    here: tuple[float, str] = (0.0, "")
    if worst >= 0 and excess[worst] > 1.0:
        nodes = mesh.geometry.x[compat.geometry_dofmap(mesh)[cells[worst]]].mean(axis=0)[: mesh.geometry.dim]
        number = int(input_cell_numbers(mesh.topology)[cells[worst]])
        place = ", ".join(f"{x:.4g}" for x in nodes)
        here = (
            float(excess[worst]),
            f"the body with the tag {tag} is not one of revolution about the axis of its Spin: at the boundary of "
            f"cell {number} (number in the mesh's input) at ({place}), {ratio[worst]:.2g} of the velocity is normal "
            "to the boundary",
        )
    return max(mesh.comm.allgather(here))[1]
