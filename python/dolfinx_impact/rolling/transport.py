# SPDX-License-Identifier: MIT
"""Internal variables that flow with the material along straight streamlines of quadrature points; docs/rolling.md."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from dolfinx.mesh import exterior_facet_indices
from mpi4py import MPI

from ..common.types import FloatArray, IntArray
from ..statics.inelastic_body import InelasticBody
from ..statics.problem import Report, StaticProblem
from .flow import Flow
from .motions import Translation

SAME = 1e-6  # of a cell: distance across the flow at which points are on one streamline
APART = 0.75  # of the longer of two cells along the flow: largest distance of neighbours on a streamline
STILL = 1e-12  # change of internal variables, relative to the largest, at which they are carried to the end
MOST_ROUNDS = 200


class Transport:
    """Carries internal variables with straight flows: each point starts from what its neighbour upstream has found.

    The steady state of a material point's path is that of the points along its streamline, taken as its places at
    successive times: the law's update at a point starts from the history at the point before. What enters the mesh is
    as the material was at the beginning.

    Args:
        problem: static problem with internal variables.
        flow: flow of its bodies.

    Raises:
        ValueError: no streamlines of points, or bodies that spin; on all ranks.
    """

    def __init__(self, problem: StaticProblem, flow: Flow) -> None:
        assert isinstance(problem.body, InelasticBody)
        self._problem, self._flow, self._body = problem, flow, problem.body
        self._comm = problem.space.mesh.comm
        self._points = self._body.force.history
        self._names = self._points.state_names
        self._virgin = {name: self._points.values(name).copy() for name in self._names}
        self._upstream: IntArray = np.zeros(0, dtype=np.int64)
        self._mine: IntArray = np.zeros(0, dtype=np.int64)
        self._longest = 0
        self._velocity: FloatArray | None = None
        self.update()

    def update(self) -> None:
        """Find the neighbours upstream for the present directions of flow. Collective.

        Raises:
            ValueError: the points make no streamlines; on all ranks.
        """
        velocities = np.array([m.velocity for m in self._flow.motions.values() if isinstance(m, Translation)])
        if self._velocity is not None and np.array_equal(velocities, self._velocity):
            return
        field = next(iter(self._body.history.values()))
        space = field.function().function_space
        mesh = space.mesh
        num = len(self._virgin[self._names[0]])
        where = space.tabulate_dof_coordinates()[:, : mesh.geometry.dim][space.dofmap.list[:num]]
        rows = []
        for tag, motion in self._flow.motions.items():
            cells = self._cells(tag)
            if isinstance(motion, Translation):
                rows.append(self._rows(cells, where, motion))
        table = np.vstack([np.zeros((0, 5 + mesh.geometry.dim)), *rows])
        gathered = self._comm.allgather((table, num * where.shape[1]))
        counts = [count for _, count in gathered]
        first = np.concatenate([[0], np.cumsum(counts)])
        for rank, (part, _) in enumerate(gathered):
            part[:, 0] += first[rank]
        everything = np.vstack([part for part, _ in gathered])
        self._mine = np.arange(first[self._comm.rank], first[self._comm.rank + 1])
        self._upstream, self._longest, fault = _neighbours(everything, int(first[-1]))
        if fault:
            raise ValueError(fault)
        self._velocity = velocities

    def _cells(self, tag: int) -> IntArray:
        """Owned cells of a motion that have internal variables."""
        cells = self._flow.cells_of(tag)
        num = len(self._virgin[self._names[0]])
        cells = cells[cells < num]
        tags = self._problem.material.cell_tags
        found = [cells if p.tag is None else np.intersect1d(cells, tags.find(p.tag)) for p in self._body.parts]
        return np.unique(np.concatenate([cells[:0], *found]))

    def _rows(self, cells: IntArray, where: FloatArray, motion: Translation) -> FloatArray:
        """Of each point: number, place along the flow, length of its cell along the flow, global number of the cell,
        whether the cell is at the boundary, and the place across the flow."""
        mesh = self._problem.space.mesh
        tdim, gdim = mesh.topology.dim, mesh.geometry.dim
        speed = float(np.linalg.norm(motion.velocity))
        if speed == 0.0 or not len(cells):
            return np.zeros((0, 5 + gdim))
        along = motion.velocity / speed
        corners = mesh.geometry.x[:, :gdim][mesh.geometry.dofmap[cells]]
        length = np.ptp(corners @ along, axis=1)
        x = where[cells]
        s = x @ along
        across = x - s[..., None] * along
        mesh.topology.create_connectivity(tdim - 1, tdim)
        mesh.topology.create_connectivity(tdim, tdim - 1)
        outer = np.zeros(mesh.topology.index_map(tdim - 1).size_local + mesh.topology.index_map(tdim - 1).num_ghosts)
        outer[exterior_facet_indices(mesh.topology)] = 1.0
        facets = mesh.topology.connectivity(tdim, tdim - 1)
        rim = np.array([outer[facets.links(c)].any() for c in cells], dtype=float)
        original = mesh.topology.original_cell_index[cells].astype(float)
        per = x.shape[1]
        number = (cells[:, None] * per + np.arange(per)).ravel().astype(float)
        columns = [number, s.ravel(), np.repeat(length, per), np.repeat(original, per), np.repeat(rim, per)]
        return np.column_stack([*columns, across.reshape(-1, gdim)])

    def state(self) -> dict[str, FloatArray]:
        """Copy of the internal variables."""
        return {name: self._points.values(name).copy() for name in self._names}

    def restore(self, state: dict[str, FloatArray]) -> None:
        """Bring internal variables back.

        Args:
            state: as `state` returned it.
        """
        for name, values in state.items():
            self._points.set_values(name, values)

    def solve(self, equilibrium: Callable[[bool], Report]) -> Report:
        """Find displacement and history together. Collective.

        Rounds of equilibrium with the history upstream of each point frozen, by Newton's method with the exact tangent
        of that problem, and of history carried along the streamlines at the displacements found.

        Args:
            equilibrium: solves for the displacement; the argument says whether it is the first round.

        Returns:
            Report of the first round, with the iterations of the others.

        Raises:
            RuntimeError: history and displacement do not settle; on all ranks.
        """
        report: Report | None = None
        for _ in range(MOST_ROUNDS):
            self._carry()
            found = equilibrium(report is None)
            if report is None:
                report = found
                settled = False
            else:
                settled = sum(found.iterations) == 0
                report.iterations.extend(found.iterations)
                report.residual_norms.extend(found.residual_norms)
            if settled:
                return report
        raise RuntimeError(
            f"displacements and history of the flow did not settle in {MOST_ROUNDS} rounds: is the load more than the "
            "body can bear in steady flow?"
        )

    def _carry(self) -> None:
        """History along the streamlines at the present displacements, from the inlet to the outlet. Collective."""
        state = self.state()
        for _ in range(self._longest + 1):
            self.restore(self._shifted(state))
            self._problem.assemble_residual()
            after = {name: self._points.values(name, trial=True).copy() for name in self._names}
            change = self._difference(after, state)
            state = after
            if change < STILL:
                break

    def _difference(self, new: dict[str, FloatArray], old: dict[str, FloatArray]) -> float:
        """Largest change of a variable over its largest value, of all ranks. Collective."""
        largest = 0.0
        for name in self._names:
            here = (np.abs(new[name] - old[name]), np.abs(new[name]))
            change, size = (self._comm.allreduce(float(values.max(initial=0.0)), MPI.MAX) for values in here)
            largest = max(largest, change / size if size > 0.0 else 0.0)
        return largest

    def _shifted(self, state: dict[str, FloatArray]) -> dict[str, FloatArray]:
        """What each point starts from: the state of the point upstream, at the inlet that of the beginning."""
        out = {}
        source = self._upstream[self._mine]
        inner = source >= 0
        for name, values in state.items():
            width = values.shape[-1] if values.ndim == 3 else 1
            flat = values.reshape(-1, width)
            everywhere = np.vstack(self._comm.allgather(flat))
            virgin = self._virgin[name].reshape(-1, width)
            out[name] = np.where(inner[:, None], everywhere[source], virgin).reshape(values.shape)
        return out


def _neighbours(points: FloatArray, count: int) -> tuple[IntArray, int, str]:
    """Number of the neighbour upstream of each point, -1 at the inlet; the most points on a streamline; what is wrong.

    Args:
        points: rows of Transport._rows of all ranks, the same on all.
        count: number of points of all ranks.
    """
    upstream = np.full(count, -1, dtype=np.int64)
    if not len(points):
        return upstream, 0, ""
    length = points[:, 2]
    grid = np.rint(points[:, 5:] / (SAME * length.max()) / 4.0).astype(np.int64)
    order = np.lexsort([points[:, 1], *grid.T])
    lines = np.cumsum(np.concatenate([[0], np.any(np.diff(grid[order], axis=0) != 0, axis=1)]))
    same = np.diff(lines) == 0
    sorted_points = points[order]
    distance = np.diff(sorted_points[:, 1])
    far = same & (distance > APART * np.maximum(sorted_points[1:, 2], sorted_points[:-1, 2]))
    begins = np.concatenate([[True], ~same])
    inside = begins & (sorted_points[:, 4] == 0.0)
    ends = np.concatenate([~same, [True]]) & (sorted_points[:, 4] == 0.0)
    broken = inside | ends | np.concatenate([[False], far])
    if np.any(broken):
        k = int(np.flatnonzero(broken)[0])
        place = np.round(sorted_points[k, 5:], 9)
        fault = (
            f"cell {int(sorted_points[k, 3])} (at {place.tolist()} across the flow): no streamline of quadrature "
            "points goes through it from one end of the body to the other, along which internal variables could flow; "
            "make the mesh by extrusion along the flow"
        )
        return upstream, 0, fault
    number = sorted_points[:, 0].astype(np.int64)
    upstream[number[1:][same]] = number[:-1][same]
    return upstream, int(np.bincount(lines).max()), ""
