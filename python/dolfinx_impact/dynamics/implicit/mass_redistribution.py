# SPDX-License-Identifier: MIT
"""Nodes of contact surfaces, and the redistribution of their mass to the nodes behind them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from dolfinx import fem, la
from dolfinx.fem import FunctionSpace

from ...common.types import BoolArray, FloatArray, IntArray
from ...contact.pair import ContactPair


class MassRedistribution:
    """Nodes of contact surfaces, and the cells that pass their mass on.

    The mass of a contact node goes, cell by cell, to the nodes of the cell that are on no contact surface: in the
    kinetic energy of the cell the velocity of a contact node is the mean of theirs, v_c = sum_i w_ci v_i with
    w_ci ~ 1/|x_i - x_c|^2. The cell keeps its mass and its momentum, and its mass matrix stays positive semi-definite.
    In place of the global problem of Khenous, Laborde and Renard (2008) it needs nothing but the cells at the surface,
    as the quadrature formulas of Hager, Hueeber and Wohlmuth (2008).

    Args:
        V: displacement space.
        pairs: contact pairs.

    Attributes:
        on_surface: mask of contact nodes, owned and ghosts.
        massless: mask of those whose cells all pass their mass on, owned and ghosts: a cell without other nodes keeps
            the mass of its contact nodes.
        cells: owned cells that pass mass on, sorted.
    """

    def __init__(self, V: FunctionSpace, pairs: Sequence[ContactPair]) -> None:
        self.space = V
        index_map = V.dofmap.index_map
        mask = la.vector(index_map, 1)
        for pair in pairs:
            tagged = [pair.slave, pair.master] if isinstance(pair.master, int) else [pair.slave]
            for tag in tagged:
                tags = pair.facet_tags
                V.mesh.topology.create_connectivity(tags.dim, V.mesh.topology.dim)
                mask.array[fem.locate_dofs_topological(V, tags.dim, tags.find(tag))] = 1.0
        _share(mask)
        self.on_surface: BoolArray = mask.array > 0.0
        num_cells = V.mesh.topology.index_map(V.mesh.topology.dim).size_local
        touched = self.on_surface[V.dofmap.list[:num_cells]]
        mixed = touched.any(axis=1) & ~touched.all(axis=1)
        self.cells: IntArray = np.flatnonzero(mixed).astype(np.int32)
        keeping = la.vector(index_map, 1)
        keeping.array[V.dofmap.list[:num_cells][touched.all(axis=1)]] = 1.0
        _share(keeping)
        self.massless: BoolArray = self.on_surface & (keeping.array == 0.0)
        self._x = V.tabulate_dof_coordinates()

    def weights(self, cell: int) -> FloatArray:
        """Velocities of a cell's nodes as means of those of its nodes on no contact surface.

        Args:
            cell: one of `cells`.

        Returns:
            Matrix T of the means, (num_nodes, num_nodes), with unit rows for the other nodes [1].
        """
        nodes = self.space.dofmap.cell_dofs(cell)
        surface = self.on_surface[nodes]
        T = np.diag(np.where(surface, 0.0, 1.0))
        inside = np.flatnonzero(~surface)
        for c in np.flatnonzero(surface):
            w = 1.0 / np.sum((self._x[nodes[inside]] - self._x[nodes[c]]) ** 2, axis=1)
            T[c, inside] = w / w.sum()
        return T


def _share(mask: la.Vector) -> None:
    """Make a mask positive on all ranks that know a node where it is positive on one. Collective."""
    mask.scatter_reverse(la.InsertMode.add)
    mask.scatter_forward()
