# SPDX-License-Identifier: MIT
"""Streamlines of quadrature points: along straight flows, and on circles about the axis of a body that spins."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from dolfinx import fem
from dolfinx.mesh import exterior_facet_indices

from .. import compat
from ..common.cell_numbers import input_cell_numbers
from ..common.types import BoolArray, FloatArray, IntArray
from .motions import Spin, Translation

SAME = 1e-6  # of the body's extent across the flow: distance at which points are on one streamline
ROUND_OFF = 1e-12  # of coordinates
APART = 0.75  # of the longer of two cells along the flow: largest distance of neighbours on a streamline
TIE = 1e-6  # turn of the seam that decides between two cells at the same distance [rad]

# Columns of a point's row: its number, its body, its place along the flow and the length of its cell along it (an angle
# for a Spin), number of the cell, whether the cell is at the boundary, angle of its place about the axis, and its place
# across the flow: two or three components.
NUMBER, BODY, ALONG, LENGTH, CELL, RIM, ANGLE, ACROSS = range(8)


class PointLines:
    """Streamlines of the quadrature points of all ranks; the same on all ranks.

    Places are those in the coordinates in which the flow is straight: along it and across it, for a Spin the angle, and
    radius and place along the axis. Nodes are placed there, and points between them by the geometry of their cell, so
    that facets of any length along a circle have their points on the same streamlines.

    A streamline that closes begins and ends at its seam.

    Args:
        space: function space of a quadrature element, whose points they are.
        bodies: owned cells with internal variables, and motion, of each body.

    Attributes:
        fault: why the points make no streamlines; an empty text if they do.
        count: number of points of all ranks.
        mine: numbers of this rank's points.
        longest: most points on a streamline.
        angle: of the places of the points about the axis of their body, zero for straight flows, (count) [rad].
        axis: unit vector of that axis, (count, 3).
    """

    def __init__(self, space: fem.FunctionSpace, bodies: Sequence[tuple[IntArray, Spin | Translation]]) -> None:
        self._motions = [motion for _, motion in bodies]
        comm = space.mesh.comm
        per = space.dofmap.list.shape[1]
        topology = space.mesh.topology
        here = topology.index_map(topology.dim).size_local * per
        parts = comm.allgather((here, [_rows(space, k, *body) for k, body in enumerate(bodies)]))
        first = np.concatenate([[0], np.cumsum([n for n, _ in parts])]).astype(np.int64)
        self.count, self.mine = int(first[-1]), np.arange(first[comm.rank], first[comm.rank + 1])
        for start, (_, rows) in zip(first, parts):
            for body in rows:
                body[:, NUMBER] += start
        self.angle: FloatArray = np.zeros(self.count)
        self.axis: FloatArray = np.tile([0.0, 0.0, 1.0], (self.count, 1))
        self.fault = ""
        lines: list[IntArray] = []
        closed: list[bool] = []
        self._spinning: list[int] = []  # body of each line that closes, -1 of others
        for k, motion in enumerate(self._motions):
            table = np.vstack([rows[k] for _, rows in parts])
            numbers = table[:, NUMBER].astype(np.int64)
            self.angle[numbers] = table[:, ANGLE]
            if isinstance(motion, Spin):
                self.axis[numbers] = motion.axis
            for line in _split(table):
                order, closes, fault = _ordered(table[line], 2.0 * np.pi if isinstance(motion, Spin) else np.inf)
                self.fault = self.fault or fault
                lines.append(numbers[line][order])
                closed.append(closes)
                self._spinning.append(k if closes else -1)
        self.longest = max((len(line) for line in lines), default=0)
        self._lines, self._closed = lines, closed
        self._arrange()

    @property
    def closes(self) -> bool:
        """Does a streamline end where it begins?"""
        return any(self._closed)

    @property
    def exits(self) -> IntArray:
        """Last points of the streamlines that close."""
        return np.array([line[-1] for line, closed in zip(self._lines, self._closed) if closed], dtype=np.int64)

    def place_seams(self, flowing: FloatArray) -> None:
        """Put the seams of closed streamlines opposite to the middle of what flows.

        Args:
            flowing: how much each point flows, (count).
        """
        for body in sorted(set(self._spinning) - {-1}):
            own = [k for k, b in enumerate(self._spinning) if b == body]
            points = np.concatenate([self._lines[k] for k in own])
            weight = flowing[points]
            middle = np.sum(weight * np.exp(1j * self.angle[points]))
            if abs(middle) <= SAME * np.sum(weight):
                continue  # nothing flows, or the same everywhere
            seam = float(np.angle(-middle)) + TIE
            sense = 1.0 if self._motions[body].omega > 0.0 else -1.0  # type: ignore[union-attr]
            for k in own:
                line = self._lines[k]
                ahead = (sense * (self.angle[line] - seam)) % (2.0 * np.pi)
                self._lines[k] = np.roll(line, -int(np.argmin(ahead)))
        self._arrange()

    def _arrange(self) -> None:
        """Points one streamline after the other, and where each streamline begins and what enters it."""
        sizes = [len(line) for line in self._lines]
        self._order = np.concatenate([np.zeros(0, dtype=np.int64), *self._lines])
        starts = np.cumsum([0, *sizes])[:-1].astype(np.int64)
        self._start = np.repeat(starts, sizes)
        last = [int(line[-1]) if closed else -1 for line, closed in zip(self._lines, self._closed)]
        self._last = np.repeat(np.array(last, dtype=np.int64), sizes)

    def sources(self, changes: BoolArray) -> tuple[IntArray, BoolArray]:
        """Where each point takes its history from: from the nearest point upstream that changes it, or the inlet.

        Args:
            changes: points at which the history changes, (count).

        Returns:
            Numbers of points, (count), and whether it is their history of the turn before, as where a closed
            streamline begins, (count). -1: what enters is as at the beginning.
        """
        at = np.where(changes[self._order], np.arange(len(self._order)), -1)
        before = np.concatenate([[-1], np.maximum.accumulate(at)[:-1]]) if len(at) else at
        inside = before >= self._start
        source: IntArray = np.full(self.count, -1, dtype=np.int64)
        source[self._order] = np.where(inside, self._order[np.where(inside, before, 0)], self._last)
        earlier: BoolArray = np.zeros(self.count, dtype=bool)
        earlier[self._order] = ~inside & (self._last >= 0)
        return source, earlier


def _rows(space: fem.FunctionSpace, body: int, cells: IntArray, motion: Spin | Translation) -> FloatArray:
    """Rows of the points of this rank's cells of a body."""
    mesh = space.mesh
    gdim, tdim = mesh.geometry.dim, mesh.topology.dim
    width = ACROSS + (2 if isinstance(motion, Spin) else gdim)
    if not len(cells):
        return np.zeros((0, width))
    nodes = mesh.geometry.x[compat.geometry_dofmap(mesh)[cells]]
    points = space.tabulate_dof_coordinates()[space.dofmap.list[cells]]
    per = points.shape[1]
    if isinstance(motion, Spin):
        along, across = _cylindrical(nodes, motion)
        functions = (
            mesh.ufl_domain().ufl_coordinate_element().basix_element.tabulate(0, compat.interpolation_points(space))[0]
        )
        functions = functions[..., 0] if functions.ndim == 3 else functions
        functions = functions[:, : nodes.shape[1]]
        place, beside = (np.einsum("pn,cn...->cp...", functions, v) for v in (along, across))
        angle = _cylindrical(points, motion, unwrapped=False)[0]
        sense = 1.0 if motion.omega > 0.0 else -1.0
        place, length = sense * place, np.ptp(along, axis=1)
    else:
        direction = motion.velocity / np.linalg.norm(motion.velocity)
        x = points[..., :gdim]
        place = x @ direction
        beside, angle = x - place[..., None] * direction, np.zeros(points.shape[:2])
        length = np.ptp(nodes[..., :gdim] @ direction, axis=1)
    out = np.zeros((len(cells) * per, width))
    number = (cells[:, None] * per + np.arange(per)).ravel()
    for column, value in ((NUMBER, number), (BODY, body), (ALONG, place.ravel()), (ANGLE, angle.ravel())):
        out[:, column] = value
    for column, of_cell in ((LENGTH, length), (CELL, input_cell_numbers(mesh.topology)[cells])):
        out[:, column] = np.repeat(of_cell, per)
    mesh.topology.create_connectivity(tdim - 1, tdim)
    mesh.topology.create_connectivity(tdim, tdim - 1)
    facet_map = mesh.topology.index_map(tdim - 1)
    outer = np.zeros(facet_map.size_local + facet_map.num_ghosts, dtype=bool)
    outer[exterior_facet_indices(mesh.topology)] = True
    facets = mesh.topology.connectivity(tdim, tdim - 1)
    of_cells = facets.array.reshape(facets.num_nodes, -1)[cells]
    out[:, RIM] = np.repeat(outer[of_cells].any(axis=1), per)
    out[:, ACROSS:] = beside.reshape(len(out), -1)
    return out


def _cylindrical(x: FloatArray, spin: Spin, unwrapped: bool = True) -> tuple[FloatArray, FloatArray]:
    """Angle about the axis of a Spin, (...) [rad], without jumps within a cell; radius and place along it, (..., 2).

    Args:
        x: places in three components, (cells, n, 3) [L].
        spin: motion.
        unwrapped: whether angles of a cell are near that of its first place.
    """
    a = spin.axis
    first = np.cross(a, np.eye(3)[int(np.argmin(np.abs(a)))])
    first /= np.linalg.norm(first)
    arm = x - np.pad(spin.point, (0, 3 - len(spin.point)))
    p, q = arm @ first, arm @ np.cross(a, first)
    angle = np.arctan2(q, p)
    if unwrapped:
        angle = angle[:, :1] + np.mod(angle - angle[:, :1] + np.pi, 2.0 * np.pi) - np.pi
    return angle, np.stack([np.hypot(p, q), arm @ a], axis=-1)


def _split(table: FloatArray) -> list[IntArray]:
    """Rows of each streamline: those with the same place across the flow."""
    if not len(table):
        return []
    keys = []
    for column in table[:, ACROSS:].T:
        tolerance = SAME * float(np.ptp(table[:, ACROSS:], axis=0).max()) + ROUND_OFF * float(np.abs(column).max())
        order = np.argsort(column, kind="stable")
        key = np.zeros(len(column), dtype=np.int64)
        key[order] = np.concatenate([[0], np.cumsum(np.diff(column[order]) > tolerance)])
        keys.append(key)
    order = np.lexsort(keys)
    different = np.any([np.diff(key[order]) != 0 for key in keys], axis=0)
    return list(np.split(order, np.flatnonzero(different) + 1))


def _ordered(rows: FloatArray, period: float) -> tuple[IntArray, bool, str]:
    """Order of the points of a streamline along the flow; whether it closes; what is wrong.

    Args:
        rows: of the points.
        period: after which the flow is where it was, infinite for a straight one.
    """
    place = rows[:, ALONG] % period if np.isfinite(period) else rows[:, ALONG]
    order = np.argsort(place, kind="stable")
    at, length = place[order], rows[order, LENGTH]
    steps = np.append(np.diff(at), at[0] + period - at[-1])
    far = steps > APART * np.maximum(length, np.roll(length, -1))
    if not far.any() and np.isfinite(period):
        return order, True, ""
    breaks = np.flatnonzero(far)
    rim = rows[order, RIM] > 0.0
    # The streamline begins after its largest gap. Points before and after another one, or in an inner cell, are ends
    # inside the body.
    last = int(breaks[np.argmax(steps[breaks])])
    first = (last + 1) % len(order)
    inner = [k for k in breaks if k != last] + [k for k in (first, last) if not rim[k]]
    fault = ""
    if inner:
        worst = rows[order[int(inner[0])]]
        fault = (
            f"cell {int(worst[CELL])} (at {np.round(worst[ACROSS:], 9).tolist()} across the flow): no streamline of "
            "quadrature points goes through it from one end of the body to the other or round the axis, along which "
            "internal variables could flow; make the mesh by extrusion along the flow, of a body that spins by "
            "revolution about its axis"
        )
    return np.roll(order, -first), False, fault
