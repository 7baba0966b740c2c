# SPDX-License-Identifier: MIT
"""A field of a problem's bodies: values at the quadrature points, averages at the nodes."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import ufl
from dolfinx import fem, la
from dolfinx.fem import Function
from dolfinx.mesh import Mesh

from .ffcx_form import ffcx_form
from ..common.types import FloatArray
from ..forms import quadrature
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
        self._average: _NodalAverage | None = None

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
        if self._average is None:
            self._average = _NodalAverage(self.function(), self.shape, self.degree)
        f, values = self._average.source, self.values
        set_values(f, np.arange(len(values), dtype=np.int32), values)
        f.x.scatter_forward()
        out = Function(self._average.space, name=self.name)
        self._average.evaluate(out)
        return out


class _NodalAverage:
    """Averages at the vertices of a function on a quadrature element; forms are made once.

    Args:
        source: function on a quadrature element.
        shape: shape of a value, () or (n,).
        degree: quadrature degree of its points [1].
    """

    def __init__(self, source: Function, shape: tuple[int, ...], degree: int) -> None:
        mesh = source.function_space.mesh
        self.source, self.space = source, fem.functionspace(mesh, ("Lagrange", 1, shape))
        scalars = fem.functionspace(mesh, ("Lagrange", 1))
        dx = ufl.dx(domain=mesh, metadata=quadrature.metadata(degree))
        v, w = ufl.TestFunction(self.space), ufl.TestFunction(scalars)
        self._form = ffcx_form(ufl.inner(source, v) * dx)
        weights = fem.assemble_vector(ffcx_form(w * dx))
        weights.scatter_reverse(la.InsertMode.add)
        self._weights = weights.array[: scalars.dofmap.index_map.size_local, None].copy()

    def evaluate(self, out: Function) -> None:
        """Set a function on `space` to the averages. Collective."""
        sums = fem.assemble_vector(self._form)
        sums.scatter_reverse(la.InsertMode.add)
        bs, num_owned = self.space.dofmap.bs, len(self._weights)
        out.x.array.reshape(-1, bs)[:num_owned] = sums.array.reshape(-1, bs)[:num_owned] / self._weights
        out.x.scatter_forward()
