# SPDX-License-Identifier: MIT
"""The picture that is wanted most often: a field on the deformed body."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import ufl
from dolfinx import fem

from ..assembly.history_field import HistoryField
from ..common.collective import comm_of, guard
from ..common.types import FilePath, FloatArray, IntArray
from . import plots
from .gather import Gathered, gather_field, gather_rows, together
from .run_folder import vertex_average

if TYPE_CHECKING:
    import matplotlib.axes
    from matplotlib.cm import ScalarMappable

# Corners and middles of edges in VTK's order of the nodes, around a plane cell, by name and number of nodes.
OUTLINES = {
    ("triangle", 3): [0, 1, 2],
    ("triangle", 6): [0, 3, 1, 4, 2, 5],
    ("quadrilateral", 4): [0, 1, 2, 3],
    ("quadrilateral", 9): [0, 4, 1, 5, 2, 6, 3, 7],
}
VIEW = ((-1.0, -1.5, 0.8), (0.0, 0.0, 1.0), None)  # of bodies in space: towards the viewer, up


class DeformedBody:
    """A field on the deformed body, gathered for pictures. Collective.

        picture = di.DeformedBody(u, problem.von_mises)
        picture.save("stress.png", label="von Mises stress [MPa]", factor=1e-6)

    Plane bodies are drawn by matplotlib, bodies in space by PyVista, which needs a screen or Xvfb.

    Args:
        u: displacement: a Lagrange function of degree 1 or 2 with a component for each direction of space [L].
        field: what is shown: a scalar function, one of vectors, of which the length counts; problem.stress-like fields
            of one component, as problem.von_mises; or a scalar UFL expression. Expressions and fields at quadrature
            points are averaged at the vertices. None: the length of u.
        scale: factor of the displacement [1].

    Attributes:
        limits: smallest and largest value of the field, of all ranks.

    Raises:
        TypeError: `u` is no function, or `field` none of the above; on all ranks.
        ValueError: `u` is no displacement, or `field` has values that are no numbers; on all ranks.
    """

    def __init__(
        self, u: fem.Function, field: fem.Function | HistoryField | ufl.core.expr.Expr | None = None, scale: float = 1.0
    ) -> None:
        with guard(comm_of(u), "DeformedBody", scale=scale):
            _check(u, field)
        mesh = u.function_space.mesh
        self._comm, self._plane, self._scale = mesh.comm, mesh.geometry.dim == 2, float(scale)
        self._displacement = gather_field(u)
        shown: Any = u if field is None else field
        self._shown = getattr(shown, "name", "an expression")
        if isinstance(shown, HistoryField):
            shown = shown.at_nodes()
        elif not isinstance(shown, fem.Function):
            shown = vertex_average(shown, mesh, "field")
        self._field: Gathered | None = None  # values at the vertices
        self._by_cell: FloatArray | None = None  # values of cells, of a field that is constant in each
        if shown.function_space.element.basix_element.degree == 0:
            num_cells = mesh.topology.index_map(mesh.topology.dim).size_local
            values = shown.x.array[shown.function_space.dofmap.list[:num_cells, 0]]
            self._by_cell = gather_rows(mesh.comm, values)
        else:
            self._field = gather_field(shown)
            if self._field.values is not None and self._field.values.shape[1] > 1:
                self._field.values = np.linalg.norm(self._field.values, axis=1)[:, None]
        self.limits: tuple[float, float] = together(mesh.comm, self._range)

    def __repr__(self) -> str:
        low, high = self.limits
        return f"DeformedBody({self._shown}, {low:.6g} to {high:.6g}, displacement x {self._scale:g})"

    def _range(self) -> tuple[float, float]:
        """Smallest and largest value, on rank 0."""
        values = self._by_cell if self._field is None else self._field.values
        assert values is not None  # on rank 0
        return float(np.min(values)), float(np.max(values))

    def draw(
        self,
        axes: matplotlib.axes.Axes,
        label: str = "",
        factor: float = 1.0,
        clim: tuple[float, float] | None = None,
        cmap: str = "viridis",
        lengths: float = 1.0,
        unit: str = "",
        edges: bool = True,
        bar: bool = True,
        **options: Any,
    ) -> ScalarMappable:
        """Draw into matplotlib axes, on rank 0. It does not communicate.

        Args:
            axes: axes.
            label: label of the colour bar, with the unit.
            factor: factor of the values, as 1e-6 for MPa.
            clim: smallest and largest value of the colours, after `factor`; None: those of the field.
            cmap: matplotlib's name of the colour map.
            lengths: factor of the coordinates, as 1e3 for millimetres.
            unit: unit of the coordinates, for the labels of plane bodies.
            edges: whether edges of cells are drawn.
            bar: whether a colour bar is added.
            options: of bodies in space, further arguments of plots.draw: size, view, zoom.

        Returns:
            What matplotlib makes a colour bar of.

        Raises:
            NoScreen: there is no display, for bodies in space.
        """
        from matplotlib import cm, colors

        low, high = (factor * value for value in self.limits) if clim is None else clim
        mappable = cm.ScalarMappable(colors.Normalize(low, high), cmap)
        if self._plane:
            self._draw_plane(axes, mappable, factor, lengths, edges)
            blank = f" [{unit}]" if unit else ""
            axes.set(aspect="equal", xlabel=f"x{blank}", ylabel=f"y{blank}")
            axes.autoscale_view()
        else:
            part = self._grid(factor)
            view = options.pop("view", VIEW)
            plots.show(axes, plots.draw([part], (low, high), cmap, edges=edges, view=view, **options))
        axes.grid(False)
        if bar:
            shrink = 1.0 if self._plane else 0.85  # images have margins
            axes.figure.colorbar(mappable, ax=axes, label=label, shrink=shrink).ax.grid(False)
        return mappable

    def save(self, path: FilePath, label: str = "", title: str | None = None, **options: Any) -> None:
        """Write a picture of its own. Collective.

        Args:
            path: PNG that is written.
            label: label of the colour bar, with the unit.
            title: title, or None.
            options: further arguments of `draw`.

        Raises:
            RuntimeError: the file cannot be written, or there is no display for a body in space; on all ranks.
        """

        def work() -> None:
            height = 4.2
            if self._plane:  # of the body, at a width of 5 inch, with room for the labels
                extent = np.ptp(self._moved()[0], axis=0)
                height = float(np.clip(5.0 * extent[1] / extent[0] + 0.9, 2.0, 7.0))
            with plots.styled() as plt:
                figure, axes = plt.subplots(figsize=(6.4, height), layout="constrained")
                self.draw(axes, label, **options)
                if title:
                    axes.set_title(title, fontsize=10)
                plots.save(figure, path)

        together(self._comm, work)

    def _moved(self) -> tuple[FloatArray, IntArray]:
        """Positions of the displacement's nodes, and its cells in VTK's order; on rank 0."""
        d = self._displacement
        assert d.points is not None and d.values is not None, "pictures are drawn on rank 0"
        return d.points + self._scale * d.values, d.vtk()[0]

    def _draw_plane(self, axes: Any, mappable: ScalarMappable, factor: float, lengths: float, edges: bool) -> None:
        """Cells of a plane body as polygons; values at vertices are interpolated."""
        from matplotlib.collections import PolyCollection

        x, cells = self._moved()
        outline = OUTLINES[self._displacement.cell_type, cells.shape[1]]
        polygons = list(lengths * x[cells[:, outline]])
        line: dict[str, Any] = (
            {"edgecolor": "#20202040", "linewidth": 0.4} if edges else {"edgecolor": "face", "linewidth": 0.1}
        )
        style: dict[str, Any] = {"cmap": mappable.cmap, "norm": mappable.norm}
        if self._field is None:
            assert self._by_cell is not None
            axes.add_collection(PolyCollection(polygons, array=factor * self._by_cell, **style, **line))
            return
        f = self._field
        assert f.cells is not None and f.values is not None  # on rank 0
        order = [0, 1, 2] if f.cell_type == "triangle" else [0, 1, 3, 2]  # around the cell, from DOLFINx's order
        corners = f.cells[:, : len(order)][:, order]
        places = lengths * x[cells[:, : len(order)]]
        values = factor * f.values[corners, 0]
        # A cell is a fan of triangles about its middle, so that quadrilaterals have no preferred diagonal.
        places = np.concatenate([places, places.mean(axis=1, keepdims=True)], axis=1)
        values = np.concatenate([values, values.mean(axis=1, keepdims=True)], axis=1)
        n = len(order)
        fan = np.array([[k, (k + 1) % n, n] for k in range(n)])
        triangles = (np.arange(len(cells))[:, None, None] * (n + 1) + fan).reshape(-1, 3)
        flat = places.reshape(-1, 2)
        axes.tripcolor(flat[:, 0], flat[:, 1], triangles, values.ravel(), shading="gouraud", **style)
        if edges:
            axes.add_collection(PolyCollection(polygons, facecolor="none", **line))

    def _grid(self, factor: float) -> Any:
        """Grid of PyVista, on rank 0."""
        if self._field is None:
            d = self._displacement
            out = plots.grid(d, d.values, self._scale)
            assert self._by_cell is not None
            out.cell_data["value"] = factor * self._by_cell
            return out
        f = self._field
        if f.degree == 1:
            return plots.deformed_grid(f, self._displacement, self._scale, factor)
        assert f.values is not None and f.degree == self._displacement.degree, "checked by the constructor"
        out = plots.grid(f, self._displacement.values, self._scale)
        out.point_data["value"] = factor * f.values[:, 0]
        return out


def _check(u: Any, field: Any) -> None:
    """Check the arguments of a DeformedBody, on this rank."""
    if not isinstance(u, fem.Function):
        raise TypeError(f"u must be a Function of dolfinx.fem, found {type(u).__name__}")
    V = u.function_space
    gdim = V.mesh.geometry.dim
    degree = 0 if V.ufl_element().is_mixed else V.element.basix_element.degree
    if V.value_shape != (gdim,) or V.mesh.topology.dim != gdim or V.ufl_element().family_name != "P":
        raise ValueError(
            f"u must be a displacement: a Lagrange function of {gdim} components on a mesh of {gdim}D cells"
        )
    if degree not in (1, 2):
        raise ValueError(f"u is of degree {degree}: interpolate it to degree 1 or 2 for a picture")
    if isinstance(field, HistoryField):
        if field.shape:
            raise ValueError(f"{field.name} has {field.shape[0]} components: show one number, as problem.von_mises")
    elif isinstance(field, fem.Function):
        W = field.function_space
        if W.mesh._cpp_object is not V.mesh._cpp_object:
            raise ValueError("field is on another mesh than u")
        known = not W.ufl_element().is_mixed and W.ufl_element().family_name in ("P", "Discontinuous Lagrange", "DP")
        if not known or len(W.value_shape) > 1:
            raise ValueError("field must have scalars or vectors, on a Lagrange space or constant in each cell")
        own = W.element.basix_element.degree
        if own > 0 and (W.element.basix_element.discontinuous or own not in (1, degree)):
            raise ValueError(
                f"field is of degree {own}: continuous functions of degree 1 or of that of u, and those that are "
                "constant in each cell, can be shown; give others as expressions, for example 1.0*field"
            )
        if own == 0 and len(W.value_shape):
            raise ValueError("field has vectors that are constant in each cell: give their length as an expression")
    elif field is not None and not isinstance(field, ufl.core.expr.Expr):
        raise TypeError(
            f"field must be a function, problem.von_mises or a UFL expression, found {type(field).__name__}"
        )
    elif field is not None and field.ufl_shape != ():
        raise ValueError(f"field has the shape {field.ufl_shape}: give a number")
