# SPDX-License-Identifier: MIT
"""Internal variables of a problem by name: values at the quadrature points, averages at the nodes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import ufl
from dolfinx import fem, la
from dolfinx.fem import Function

from ..common.types import FloatArray, IntArray
from ..forms import quadrature
from .inelastic_part import HistoryFunctions, InelasticPart, quadrature_element, set_values


class HistoryField:
    """One internal variable of a problem.

    Args:
        name: name of the variable.
        shape: shape of a value, () or (n,).
        degree: quadrature degree of its points [1].
        parts: cells of each inelastic part that has the variable, and a function that returns their values
            (num_cells, num_points, num_components).
        mesh: mesh of the problem.
    """

    def __init__(self, name: str, shape: tuple[int, ...], degree: int, parts: Sequence[Any], mesh: Any) -> None:
        self.name, self.shape, self.degree = name, shape, degree
        self._parts, self._mesh = list(parts), mesh

    def __repr__(self) -> str:
        what = "a number" if not self.shape else f"{self.shape[0]} components"
        return f"HistoryField({self.name!r}: {what} at the points of degree {self.degree})"

    @property
    def num_points(self) -> int:
        """Number of points in a cell [1]."""
        element = quadrature_element(self._mesh, (), self.degree)
        return int(element.custom_quadrature()[0].shape[0])

    @property
    def values(self) -> FloatArray:
        """Values of the last completed step on this rank, (num_owned_cells, num_points, ...); zero in cells of materials
        without the variable."""
        topology = self._mesh.topology
        num_cells = topology.index_map(topology.dim).size_local
        out = np.zeros((num_cells, self.num_points, int(np.prod(self.shape, dtype=int))))
        for cells, read in self._parts:
            out[cells] = np.asarray(read()).reshape(len(cells), *out.shape[1:])
        return out.reshape(*out.shape[:2], *self.shape)

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
        space = fem.functionspace(self._mesh, ("Lagrange", 1, self.shape))
        scalars = fem.functionspace(self._mesh, ("Lagrange", 1))
        dx = ufl.dx(domain=self._mesh, metadata=quadrature.metadata(self.degree))
        f, v, w = self.function(), ufl.TestFunction(space), ufl.TestFunction(scalars)
        sums = fem.assemble_vector(fem.form(ufl.inner(f, v) * dx))
        weights = fem.assemble_vector(fem.form(w * dx))
        out = Function(space, name=self.name)
        for vector in (sums, weights):
            vector.scatter_reverse(la.InsertMode.add)
        num_owned = scalars.dofmap.index_map.size_local
        means = sums.array.reshape(-1, space.dofmap.bs)[:num_owned] / weights.array[:num_owned, None]
        out.x.array.reshape(-1, space.dofmap.bs)[:num_owned] = means
        out.x.scatter_forward()
        return out


class MaterialHistory(Mapping[str, HistoryField]):
    """Internal variables of a problem by name.

    Args:
        parts: inelastic parts of the problem.
        stores: for each part the stores of its kernels (_cpp.operators.PointHistory), whose cells together are the
            part's owned cells.
    """

    def __init__(self, parts: Sequence[InelasticPart], stores: Sequence[Sequence[Any]]) -> None:
        self._parts, self._stores = list(parts), [list(s) for s in stores]

    def __iter__(self) -> Iterator[str]:
        return iter(dict.fromkeys(name for part in self._parts for name in part.history))

    def __len__(self) -> int:
        return len(list(iter(self)))

    def __repr__(self) -> str:
        return f"MaterialHistory({', '.join(self)})"

    def __getitem__(self, name: str) -> HistoryField:
        shapes = {part.response.history[name] for part in self._parts if name in part.history}
        if not shapes:
            raise KeyError(f"no material has the internal variable {name!r}: there are {', '.join(self)}")
        if len(shapes) > 1:
            raise ValueError(f"the materials have {name!r} with different shapes, {sorted(shapes)}")
        found = [
            (np.asarray(store.cells, dtype=np.int32), lambda store=store: store.values(name))
            for part, stores in zip(self._parts, self._stores)
            if name in part.history
            for store in stores
        ]
        part = self._parts[0]
        return HistoryField(name, shapes.pop(), part.degree, found, part.mesh)

    def set(self, name: str, values: FloatArray) -> None:
        """Replace the committed values of a variable.

        Args:
            name: name of the variable.
            values: values on this rank, (num_owned_cells, num_points, ...).
        """
        flat = np.asarray(values, dtype=float).reshape(len(values), -1)
        for part, stores in zip(self._parts, self._stores):
            if name in part.history:
                for store in stores:
                    store.set_values(name, np.ascontiguousarray(flat[store.cells]).ravel())

    def functions(self) -> list[HistoryFunctions]:
        """Functions for the history of each part; they are not filled."""
        return [HistoryFunctions(part) for part in self._parts]

    def cells(self) -> IntArray:
        """Owned cells with internal variables."""
        found = [np.asarray(store.cells, dtype=np.int32) for stores in self._stores for store in stores]
        return np.sort(np.concatenate(found)) if found else np.zeros(0, dtype=np.int32)
