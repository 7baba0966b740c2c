# SPDX-License-Identifier: MIT
"""Rigid obstacles of any form: heights over a plane, facets, the boundary of a mesh."""

import hashlib

import numpy as np
from dolfinx.mesh import entities_to_geometry
from scipy.linalg import solve_banded

from .. import _cpp
from ..loads import check_tag
from ..common.arguments import number
from .rigid import _Rigid, _unit, _vector

FIRST, MOST = 64, {2: 1 << 17, 3: 1 << 10}  # cells of a grid along one direction: at first, and at most by dimension
PLACES = (0.21, 0.5, 0.84)  # in each cell of a grid, where heights are compared with the spline


class RigidSurface(_Rigid):
    """Rigid obstacle of any form, made by `from_function`, `from_facets` or `from_mesh`. It may be moved as the other
    obstacles are (`displacement`, `motion`). Every rank has all of it.
    """

    def __init__(self, shape, gdim=0, turn="", numbers=()):
        if not isinstance(shape, _cpp.gap.Shape):
            raise TypeError("make a RigidSurface by from_function, from_facets or from_mesh")
        super().__init__("surface", np.zeros(3), np.array([0.0, 0.0, 1.0]), 0.0)
        self._shape, self._gdim, self._hint = shape, gdim, turn
        parts = b"".join(np.ascontiguousarray(n, dtype=float).tobytes() for n in numbers)
        self._checksum = hashlib.blake2b(parts, digest_size=16).hexdigest()

    def _made_of(self):
        return f"{self._gdim}D" if self._gdim else ""

    def same_on_all_ranks(self):
        """What stands for it where ranks are compared."""
        return [self._checksum, self.displacement, self.motion]

    @classmethod
    def from_function(cls, height, bounds, point, normal, tolerance=None):
        """Surface that a function gives over a line (in the plane) or a plane (in space), for example a rounded punch.

        The heights become a cubic spline on a grid that is refined until it is as near to the function as `tolerance`;
        gaps, normals and curvatures are those of the spline. Beyond the bounds the surface goes on straight.

        Args:
            height: function of arrays of one coordinate x, or two, x and y, that returns heights over `point` along
                `normal`, towards the body [L]. The coordinates count from `point`, along the axes of space without the
                one nearest to the normal; where the normal is oblique, along their parts across it.
            bounds: (low, high) of the coordinate, or a pair of such pairs [L].
            point: where coordinates and height are zero (2 or 3 components) [L].
            normal: out of the obstacle, towards the body; any length [1].
            tolerance: largest difference of spline and function; None: 1e-7 of the longest side of the bounds [L].

        Raises:
            TypeError, ValueError: a height that is no function or not finite, bounds that are none, a function that no
            grid of a reasonable size resolves: one with jumps or kinks.
        """
        if not callable(height):
            raise TypeError(f"height must be a function of arrays of coordinates, found {type(height).__name__}")
        origin, size = _vector("point", point), len(np.ravel(point))
        bounds = np.array(bounds, dtype=float).reshape(-1, 2)
        if len(bounds) != size - 1 or not np.all(np.isfinite(bounds)) or np.any(bounds[:, 0] >= bounds[:, 1]):
            wanted = "(low, high)" if size == 2 else "two pairs (low, high)"
            raise ValueError(f"bounds are {bounds.tolist()}: give {wanted}, low below high")
        lengths = bounds[:, 1] - bounds[:, 0]
        tolerance = 1e-7 * lengths.max() if tolerance is None else number("tolerance", tolerance, 0.0, " [L]")
        cells = np.full(size - 1, FIRST)
        while True:
            coefficients, errors = _spline(height, bounds, cells, tolerance)
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
            size, origin.tolist(), _axes(_unit("normal", normal)[:size]).tolist(),
            [*bounds[:, 0], *[0.0] * pad], [*(lengths / cells), *[0.0] * pad], [*cells.tolist(), *[0] * pad],
            np.ascontiguousarray(coefficients).ravel(),
        )  # fmt: skip
        turn = "turn the surface's normal round, it must point out of the obstacle"
        return cls(shape, size, turn, (bounds, origin, normal, coefficients))

    @classmethod
    def from_facets(cls, points, facets):
        """Surface of straight facets, as a file of triangles has them (STL). Normals jump at edges: take fine ones.

        Args:
            points: (n, 2) or (n, 3) [L].
            facets: (m, 2) segments with the obstacle on their left, or (m, 3) triangles, counter-clockwise seen from
                outside. A point beside the rim of an open surface does not touch it.

        Raises:
            ValueError: shapes or numbers that do not fit, facets without size, oriented differently from a neighbour.
        """
        points, facets = np.array(points, dtype=float), np.array(facets)
        if points.ndim != 2 or points.shape[1] not in (2, 3) or facets.ndim != 2 or facets.shape[1] != points.shape[1]:
            raise ValueError(
                f"points have shape {points.shape}, facets {facets.shape}: (n, 2) and (m, 2), or (n, 3) and (m, 3)"
            )
        if not np.issubdtype(facets.dtype, np.integer) or not np.all(np.isfinite(points)):
            raise ValueError("facets must be whole numbers of points, points finite numbers")
        gdim = points.shape[1]
        shape = _cpp.gap.FacetShape(gdim, points.ravel(), np.ascontiguousarray(facets, dtype=np.int32).ravel())
        turn = "turn the order of the facets' points round: their normals must point out of the obstacle"
        return cls(shape, gdim, turn, (points, facets))

    @classmethod
    def from_mesh(cls, mesh, facet_tags, tag):
        """Boundary facets of a mesh of the obstacle; between their corners they are straight. Collective over the
        mesh's ranks.

        Args:
            mesh: DOLFINx mesh, filled by the obstacle.
            facet_tags: MeshTags over its facets.
            tag: of the surface.

        Raises:
            ValueError: the tag does not exist, or not on the boundary; on all ranks.
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
        middle = x[mesh.geometry.dofmap[cells]].mean(axis=1) if len(cells) else np.zeros((0, gdim))
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

    def _turn(self):
        return self._hint

    def _obstacle(self, gdim):
        if gdim != self._gdim:
            raise ValueError(f"the rigid surface has {self._gdim} dimensions, the mesh {gdim}")
        return _cpp.gap.Rigid(self._shape)


def _axes(normal):
    """Directions of the coordinates and of the height: (3, 3), rows."""
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


def _sample(height, coordinates):
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


def _spline(height, bounds, cells, tolerance):
    """Coefficients of the cubic splines through the heights on a grid, and the largest difference between its nodes,
    along each direction.

    The ends have no knot of their own at the first and last inner node (de Boor 1978).
    """
    nodes = [np.linspace(*b, n + 1) for b, n in zip(bounds, cells)]
    coefficients = _sample(height, nodes)
    for axis, n in enumerate(cells):
        coefficients = np.moveaxis(_through(np.moveaxis(coefficients, axis, 0), n), 0, axis)
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
                values = sum(w * np.take(values, np.arange(j, j + count), axis=k) for j, w in enumerate(weights) if w)
            error = max(error, float(np.abs(values - _sample(height, places)).max()))
        errors.append(error)
    return coefficients, np.array(errors)


def _through(values, n):
    """Coefficients (n + 3, ...) of the splines through n + 1 values."""
    bands = np.zeros((9, n + 3))  # rows of the matrix: 4 + row - column

    def put(row, column, value):
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
    return solve_banded((4, 4), bands, right).reshape(n + 3, *values.shape[1:])
