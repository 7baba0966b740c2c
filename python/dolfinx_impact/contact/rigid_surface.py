# SPDX-License-Identifier: MIT
"""Rigid obstacles of any shape: heights over a plane, facets, the boundary of a mesh."""

import hashlib
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np
import scipy
from dolfinx.mesh import Mesh, MeshTags, entities_to_geometry

from .. import _cpp, compat
from ..common.arguments import number
from ..common.types import AnyArray, ArrayLike, FloatArray, IntArray
from ..loads import check_tag
from .rigid import _Rigid, _unit, _vector

FIRST = 64  # cells of the first grid along one direction
MOST = {2: 1 << 17, 3: 1 << 10}  # largest number of cells of a grid along one direction, by dimension of space
PLACES = (0.21, 0.5, 0.84)  # points in each cell of a grid at which the spline is compared with the function


class RigidSurface(_Rigid):
    """Rigid obstacle of any shape, made by `from_function`, `from_facets` or `from_mesh`; every rank has all of it.

    Its `displacement` and `motion` move it as the other obstacles.

    Args:
        shape: shape on the C++ side.
        gdim: dimension of space.
        hint: what a user can change if the slave is on the wrong side.
        numbers: arrays that define the shape, to be compared between ranks.

    Raises:
        TypeError: `shape` is not a shape of the C++ side.
    """

    def __init__(self, shape: _cpp.gap.Shape, gdim: int = 0, hint: str = "", numbers: Iterable[AnyArray] = ()) -> None:
        if not isinstance(shape, _cpp.gap.Shape):
            raise TypeError("make a RigidSurface by from_function, from_facets or from_mesh")
        super().__init__("surface", np.zeros(3), np.array([0.0, 0.0, 1.0]), 0.0)
        self._shape, self._gdim, self._hint = shape, gdim, hint
        self._given = tuple(numbers)
        parts = b"".join(np.ascontiguousarray(n, dtype=float).tobytes() for n in self._given)
        self._checksum = hashlib.blake2b(parts, digest_size=16).hexdigest()

    def _made_of(self) -> str:
        return f"{self._gdim}D" if self._gdim else ""

    def same_on_all_ranks(self) -> list[Any]:
        """The shape counts by its checksum."""
        return [self._checksum, self.displacement, self.motion, self.angle, self.pivot]

    @classmethod
    def from_function(
        cls,
        height: Callable[..., ArrayLike],
        bounds: ArrayLike,
        point: ArrayLike,
        normal: ArrayLike,
        tolerance: float | None = None,
    ) -> "RigidSurface":
        """Surface given by a function of heights over a line (in the plane) or a plane (in space).

        The heights are interpolated by a cubic spline on a grid that is refined until the spline differs from the
        function by less than `tolerance`. Gaps, normals and curvatures are those of the spline. Outside the bounds the
        surface is extended straight.

        Args:
            height: function of arrays of one coordinate x, or of two, x and y, that returns heights over `point` along
                `normal`, towards the body. The coordinates have their origin at `point` and are measured along the axes
                of space other than the one nearest to the normal, projected onto the plane across the normal [L].
            bounds: (low, high) of the coordinate, or a pair of such pairs [L].
            point: origin of coordinates and heights, (2) or (3) [L].
            normal: direction out of the obstacle, towards the body, of any length, (2) or (3) [1].
            tolerance: largest difference of spline and function; None: 1e-7 of the longest side of the bounds [L].

        Returns:
            The obstacle.

        Raises:
            TypeError: `height` is not a function of arrays, or an argument is not made of numbers.
            ValueError: heights that are not finite, bounds of a wrong shape or order, or a function with jumps or
                kinks, which no grid of the largest size resolves.
        """
        if not callable(height):
            raise TypeError(f"height must be a function of arrays of coordinates, found {type(height).__name__}")
        origin, size = _vector("point", point), len(np.ravel(point))
        limits = np.array(bounds, dtype=float).reshape(-1, 2)
        if len(limits) != size - 1 or not np.all(np.isfinite(limits)) or np.any(limits[:, 0] >= limits[:, 1]):
            wanted = "(low, high)" if size == 2 else "two pairs (low, high)"
            raise ValueError(f"bounds are {limits.tolist()}: give {wanted}, low below high")
        lengths = limits[:, 1] - limits[:, 0]
        tolerance = 1e-7 * lengths.max() if tolerance is None else number("tolerance", tolerance, 0.0, " [L]")
        cells: IntArray = np.full(size - 1, FIRST)
        while True:
            coefficients, errors = _spline(height, limits, cells)
            if np.all(errors <= tolerance):
                break
            if np.all(cells[errors > tolerance] >= MOST[size]):
                raise ValueError(
                    f"the height differs from its spline on {cells.tolist()} cells by {errors.max():.3e}, tolerance "
                    f"{tolerance:.3e}: round kinks and jumps off, shorten the bounds, or give a larger tolerance"
                )
            cells = np.where(errors > tolerance, np.minimum(2 * cells, MOST[size]), cells)
        pad = 3 - size
        shape = _cpp.gap.HeightField(
            size, [*map(float, origin)], [[*map(float, axis)] for axis in _axes(_unit("normal", normal)[:size])],
            [*limits[:, 0], *[0.0] * pad], [*(lengths / cells), *[0.0] * pad], [*map(int, cells), *[0] * pad],
            np.ascontiguousarray(coefficients).ravel(),
        )  # fmt: skip
        hint = "turn the surface's normal round, it must point out of the obstacle"
        return cls(shape, size, hint, (limits, origin, np.asarray(normal), coefficients))

    @classmethod
    def from_facets(cls, points: ArrayLike, facets: ArrayLike) -> "RigidSurface":
        """Surface of straight facets, for example the triangles of an STL file.

        Normals are discontinuous at edges; a fine surface keeps the jumps small.

        Args:
            points: points of the facets, (n, 2) or (n, 3) [L].
            facets: numbers of the points of each facet: segments with the obstacle on their left, (m, 2), or triangles
                that are counter-clockwise seen from outside, (m, 3). Points outside the boundary of an open surface
                have no contact with it.

        Returns:
            The obstacle.

        Raises:
            ValueError: shapes or numbers that do not fit, facets without size, or neighbours of opposite orientation.
        """
        x, numbers = np.array(points, dtype=float), np.array(facets)
        if x.ndim != 2 or x.shape[1] not in (2, 3) or numbers.ndim != 2 or numbers.shape[1] != x.shape[1]:
            raise ValueError(
                f"points have shape {x.shape}, facets {numbers.shape}: (n, 2) and (m, 2), or (n, 3) and (m, 3)"
            )
        if not np.issubdtype(numbers.dtype, np.integer) or not np.all(np.isfinite(x)):
            raise ValueError("facets must be whole numbers of points, points finite numbers")
        gdim = x.shape[1]
        shape = _cpp.gap.FacetShape(gdim, x.ravel(), np.ascontiguousarray(numbers, dtype=np.int32).ravel())
        hint = "turn the order of the facets' points round: their normals must point out of the obstacle"
        return cls(shape, gdim, hint, (x, numbers))

    @classmethod
    def from_mesh(cls, mesh: Mesh, facet_tags: MeshTags, tag: int) -> "RigidSurface":
        """Surface of the boundary facets of a mesh, straight between their corners. Collective over the mesh.

        Args:
            mesh: mesh of the obstacle's volume.
            facet_tags: tags of its facets.
            tag: tag of the surface.

        Returns:
            The obstacle.

        Raises:
            ValueError: no facet of the boundary has the tag, or the mesh is a surface in space; on all ranks.
        """
        gdim, tdim = mesh.geometry.dim, mesh.topology.dim
        if gdim != tdim:
            raise ValueError("the mesh of an obstacle has cells of its own dimension, not a surface in space")
        check_tag(facet_tags, tag, mesh, "RigidSurface")
        mesh.topology.create_connectivity(tdim - 1, tdim)
        mesh.topology.create_connectivity(tdim, tdim - 1)
        links = mesh.topology.connectivity(tdim - 1, tdim)
        facets = facet_tags.find(tag)
        facets = facets[facets < mesh.topology.index_map(tdim - 1).size_local]
        facets = np.array([f for f in facets if len(links.links(f)) == 1], dtype=np.int32)
        cells = np.array([links.links(f)[0] for f in facets], dtype=np.int64)
        corners = np.zeros((0, 4 if mesh.topology.cell_name() == "hexahedron" else gdim), dtype=np.int32)
        if len(facets):
            corners = entities_to_geometry(mesh, tdim - 1, facets).reshape(len(facets), -1)
        x = mesh.geometry.x[:, :gdim]
        middle = x[compat.geometry_dofmap(mesh)[cells]].mean(axis=1) if len(cells) else np.zeros((0, gdim))
        parts = [corners] if corners.shape[1] < 4 else [corners[:, [0, 1, 3]], corners[:, [0, 3, 2]]]
        found = []
        for nodes in parts:
            p = x[nodes]
            d = p[:, 1:] - p[:, :1]
            normal = np.stack([d[:, 0, 1], -d[:, 0, 0]], 1) if gdim == 2 else np.cross(d[:, 0], d[:, 1])
            inwards = np.einsum("fc,fc->f", normal, p.mean(axis=1) - middle) < 0.0
            nodes = nodes.copy()
            nodes[inwards, :2] = nodes[inwards, 1::-1]
            found.append(nodes)
        nodes = np.vstack(found)
        numbers = mesh.geometry.index_map().local_to_global(nodes.ravel().astype(np.int32)).reshape(nodes.shape)
        everything = mesh.comm.allgather((numbers, x[nodes]))
        numbers, points = (np.concatenate(part) for part in zip(*everything))
        _, first, facets = np.unique(numbers, return_index=True, return_inverse=True)
        return cls.from_facets(points.reshape(-1, gdim)[first], facets.reshape(numbers.shape))

    def vertices(self) -> tuple[FloatArray, FloatArray] | None:
        """Points of facets and areas that belong to them (lengths in the plane); None: it is no surface of facets.

        Returns:
            Points that belong to facets, (n, gdim) [L], and a share of the facets around each, (n) [L^2].
        """
        if not isinstance(self._shape, _cpp.gap.FacetShape):
            return None
        points, facets = self._given
        sides = points[facets][:, 1:] - points[facets][:, :1]
        if self._gdim == 2:
            sizes = np.linalg.norm(sides[:, 0], axis=1)
        else:
            sizes = 0.5 * np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
        areas = np.bincount(facets.ravel(), np.repeat(sizes / self._gdim, self._gdim), len(points))
        return points[areas > 0.0], areas[areas > 0.0]

    def orientation_hint(self) -> str:
        return self._hint

    def obstacle(self, gdim: int) -> _cpp.gap.Rigid:
        if gdim != self._gdim:
            raise ValueError(f"the rigid surface has {self._gdim} dimensions, the mesh {gdim}")
        return self._turning(_cpp.gap.Rigid(self._shape), gdim)


def _axes(normal: FloatArray) -> FloatArray:
    """Directions of the coordinates and of the height as rows, (3, 3)."""
    gdim, out = len(normal), np.zeros((3, 3))
    others = [k for k in range(gdim) if k != np.argmax(np.abs(normal))]
    done = [normal]
    for row, k in enumerate(others):
        axis = np.eye(gdim)[k]
        for d in done:
            axis = axis - (axis @ d) * d
        done.append(axis / np.linalg.norm(axis))
        out[row, :gdim] = done[-1]
    out[gdim - 1, :gdim] = normal
    return out


def _sample(height: Callable[..., ArrayLike], coordinates: Sequence[FloatArray]) -> FloatArray:
    """Heights at all combinations of coordinates."""
    grid = np.meshgrid(*coordinates, indexing="ij")
    try:
        values = np.array(height(*grid), dtype=float)
    except (TypeError, ValueError) as e:
        raise TypeError(f"height must take arrays of {len(grid)} coordinates and return as many heights: {e}") from e
    values = np.broadcast_to(values, grid[0].shape) if values.ndim == 0 else values
    if values.shape != grid[0].shape:
        raise ValueError(f"height returns shape {values.shape} for coordinates of shape {grid[0].shape}")
    bad = np.argwhere(~np.isfinite(values))
    if len(bad):
        raise ValueError(f"height is {values[tuple(bad[0])]} at {[float(g[tuple(bad[0])]) for g in grid]}")
    return values


def _spline(height: Callable[..., ArrayLike], bounds: FloatArray, cells: IntArray) -> tuple[FloatArray, FloatArray]:
    """Coefficients of the cubic spline through the heights on a grid, and its largest difference from the function
    between the nodes of each direction.

    The conditions at the ends are not-a-knot: the third derivative is continuous at the first and last inner node
    (de Boor 1978).
    """
    nodes = [np.linspace(bounds[k, 0], bounds[k, 1], int(n) + 1) for k, n in enumerate(cells)]
    coefficients = _sample(height, nodes)
    for axis, n in enumerate(cells):
        coefficients = np.moveaxis(_through(np.moveaxis(coefficients, axis, 0), int(n)), 0, axis)
    errors = []
    for axis, n in enumerate(cells):
        error = 0.0
        for t in PLACES:
            places = list(nodes)
            places[axis] = nodes[axis][:-1] + t * (nodes[axis][1] - nodes[axis][0])
            values = coefficients
            for k in range(len(cells)):
                at = t if k == axis else 0.0
                s = 1.0 - at
                weights = s**3 / 6, (4 - 6 * at**2 + 3 * at**3) / 6, (4 - 6 * s**2 + 3 * s**3) / 6, at**3 / 6
                count = len(places[k])
                terms = [w * np.take(values, np.arange(j, j + count), axis=k) for j, w in enumerate(weights) if w]
                values = sum(terms[1:], terms[0])
            error = max(error, float(np.abs(values - _sample(height, places)).max()))
        errors.append(error)
    return coefficients, np.array(errors)


def _through(values: FloatArray, n: int) -> FloatArray:
    """Coefficients of the splines through n + 1 values, (n + 3, ...)."""
    bands = np.zeros((9, n + 3))  # the entry (row, column) of the matrix is in row 4 + row - column

    def put(row: int, column: int, value: float) -> None:
        bands[4 + row - column, column] = value

    for k, value in enumerate((1.0, -4.0, 6.0, -4.0, 1.0)):
        put(0, k, value)
        put(n + 2, n - 2 + k, value)
    row = np.arange(1, n + 2)
    for k, value in enumerate((1 / 6, 4 / 6, 1 / 6)):
        bands[4 + row - (row - 1 + k), row - 1 + k] = value
    flat = values.reshape(n + 1, -1)
    right = np.zeros((n + 3, flat.shape[1]))
    right[1:-1] = flat
    return scipy.linalg.solve_banded((4, 4), bands, right).reshape(n + 3, *values.shape[1:])
