# SPDX-License-Identifier: MIT
"""A field of a problem's bodies: values at the quadrature points, averages at the nodes."""

from __future__ import annotations

import math
from collections.abc import Callable

import basix
import numpy as np
from dolfinx import fem
from dolfinx.fem import Function
from dolfinx.mesh import Mesh

from .. import _cpp
from ..common.types import FloatArray
from .inelastic_part import quadrature_element, set_values


class HistoryField:
    """One internal variable of a problem, or its stress.

    Args:
        name: name of the variable.
        shape: shape of a value, () or (n,).
        degree: quadrature degree of its points [1].
        mesh: mesh of the problem.
        read: function that returns the values on this rank, (num_owned_cells, num_points, num_components).
        write: function that replaces them; None: they follow from others.
    """

    def __init__(
        self,
        name: str,
        shape: tuple[int, ...],
        degree: int,
        mesh: Mesh,
        read: Callable[[], FloatArray],
        write: Callable[[FloatArray], None] | None = None,
    ) -> None:
        self.name, self.shape, self.degree = name, shape, degree
        self._mesh, self._read, self._write = mesh, read, write
        self._nodes: fem.FunctionSpace | None = None  # of averages, made once

    def __repr__(self) -> str:
        what = "a number" if not self.shape else f"{self.shape[0]} components"
        return f"HistoryField({self.name!r}: {what} at the points of degree {self.degree})"

    @property
    def values(self) -> FloatArray:
        """Values of the last completed step on this rank, (num_owned_cells, num_points, ...); zero in cells whose
        material does not have the variable."""
        values = self._read()
        return values.reshape(*values.shape[:2], *self.shape)

    @values.setter
    def values(self, values: FloatArray) -> None:
        if self._write is None:
            raise AttributeError(f"{self.name} follows from the displacement and the history: set those")
        given = np.asarray(values, dtype=float)
        self._write(given.reshape(*given.shape[:2], math.prod(given.shape[2:])))

    def function(self) -> Function:
        """The values as a function on a quadrature element, for forms with this quadrature degree."""
        space = fem.functionspace(self._mesh, quadrature_element(self._mesh, self.shape, self.degree))
        f = Function(space, name=self.name)
        values = self.values
        set_values(f, np.arange(len(values), dtype=np.int32), values)
        f.x.scatter_forward()
        return f

    def at_nodes(self) -> Function:
        """Averages at the vertices, for ParaView. Collective.

        A vertex gets the mean of the points of the cells around it, weighted by volume and by its shape function.

        Returns:
            Continuous function of degree 1, with as many components as the variable.
        """
        if self._nodes is None:
            self._nodes = fem.functionspace(self._mesh, ("Lagrange", 1, self.shape))
        out = Function(self._nodes, name=self.name)
        points, weights = basix.make_quadrature(self._mesh.basix_cell(), self.degree)
        values = np.ascontiguousarray(self._read()).ravel()
        averages = _cpp.operators.nodal_averages(
            out.function_space._cpp_object, np.ravel(points), np.asarray(weights), values
        )
        out.x.array[: len(averages)] = averages
        out.x.scatter_forward()
        return out
