# SPDX-License-Identifier: MIT
"""Redistribution of the mass of contact nodes, a view of
cpp/dolfinx_impact/integrators/newmark/MassRedistribution.h."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from dolfinx.fem import FunctionSpace

from ... import _cpp
from ...common.types import BoolArray, FloatArray, IntArray
from ...contact.pair import ContactPair


class MassRedistribution:
    """Nodes of contact surfaces, and the cells that pass their mass on.

    Args:
        V: displacement space.
        pairs: contact pairs.

    Attributes:
        massless: mask of contact nodes whose cells all pass their mass on, owned and ghosts: a cell without other nodes
            keeps the mass of its contact nodes.
        cells: owned cells that pass mass on, sorted.
    """

    def __init__(self, V: FunctionSpace, pairs: Sequence[ContactPair]) -> None:
        facets = [pair.facet_tags.find(tag) for pair in pairs for tag in (pair.slave, *pair.masters)]
        self._cpp_object = _cpp.integrators.MassRedistribution(V._cpp_object, np.concatenate(facets).astype(np.int32))
        self.massless: BoolArray = self._cpp_object.massless
        self.cells: IntArray = self._cpp_object.cells

    def matrix(self, cell: int, M: FloatArray) -> FloatArray:
        """Mass matrix of a cell after redistribution.

        Args:
            cell: one of `cells`.
            M: its mass matrix over its degrees of freedom, node by node [M].

        Returns:
            Matrix of the same size [M].
        """
        return self._cpp_object.matrix(cell, np.ascontiguousarray(M))

    def lumped(self, cell: int, masses: FloatArray) -> FloatArray:
        """Lumped masses of a cell after redistribution.

        Args:
            cell: one of `cells`.
            masses: its masses over its degrees of freedom, node by node [M].

        Returns:
            As many masses [M].
        """
        return self._cpp_object.lumped(cell, np.ascontiguousarray(masses))
