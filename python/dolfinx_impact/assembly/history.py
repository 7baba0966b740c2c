# SPDX-License-Identifier: MIT
"""Internal variables of a problem by name: values at the quadrature points, averages at the nodes."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping

import numpy as np
import ufl
from dolfinx import fem, la
from dolfinx.fem import Function
from dolfinx.mesh import Mesh

from .ffcx_form import ffcx_form
from ..common.types import FloatArray
from ..forms import quadrature
from .inelastic_part import HistoryFunctions, InelasticParts, quadrature_element, set_values
from .inelastic_stress import STRESS, VON_MISES, InelasticStress, components, von_mises
from .point_values import PointHistory


class HistoryField:
    """One internal variable of a problem.

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


class MaterialHistory(Mapping[str, HistoryField]):
    """Internal variables of a problem by name; also the Cauchy stress, "stress" (xx, yy, zz, xy, and in space yz, xz),
    and "von_mises", which are evaluated when they are asked for.

    Args:
        parts: inelastic parts of the problem.
        points: the values at the points.
    """

    def __init__(self, parts: InelasticParts, points: PointHistory) -> None:
        self._parts, self._points = parts, points
        self._stress: InelasticStress | None = None

    def __iter__(self) -> Iterator[str]:
        return iter(dict.fromkeys(name for part in self._parts for name in part.history))

    def __len__(self) -> int:
        return len(list(iter(self)))

    def __repr__(self) -> str:
        return f"MaterialHistory({', '.join(self)})"

    def __getitem__(self, name: str) -> HistoryField:
        part = next(iter(self._parts))
        if name in (STRESS, VON_MISES):
            if self._stress is None:
                self._stress = InelasticStress(part.u, self._parts.material, self._points)
            evaluate = self._stress.values
            if name == VON_MISES:
                return HistoryField(name, (), part.degree, part.mesh, lambda: von_mises(evaluate())[..., None])
            return HistoryField(name, (len(components(part.mesh.geometry.dim)),), part.degree, part.mesh, evaluate)
        found = {part.response.history[name]: part for part in self._parts if name in part.history}
        if not found:
            raise KeyError(f"no material has the internal variable {name!r}: there are {', '.join(self)}")
        if len(found) > 1:
            raise ValueError(f"the materials have {name!r} with different shapes, {sorted(found)}")
        ((shape, part),) = found.items()
        points = self._points
        return HistoryField(
            name, shape, part.degree, part.mesh, lambda: points.values(name), lambda v: points.set_values(name, v)
        )

    def functions(self) -> list[HistoryFunctions]:
        """Functions for history and unknowns of each part; they are not filled."""
        return [HistoryFunctions(part) for part in self._parts]


def existing(history: MaterialHistory | None) -> MaterialHistory:
    """Internal variables of a problem that has some.

    Args:
        history: internal variables, or None.

    Returns:
        `history`.

    Raises:
        ValueError: there are none.
    """
    if history is None:
        raise ValueError("no material of the problem has internal variables")
    return history
