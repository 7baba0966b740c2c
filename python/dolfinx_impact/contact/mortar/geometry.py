# SPDX-License-Identifier: MIT
"""Nodal gaps, normals and weights of a contact by multipliers, and those against rigid obstacles."""

from __future__ import annotations

import abc
import copy
from typing import TYPE_CHECKING, Any

import basix
import numpy as np
from petsc4py import PETSc

from ... import _cpp
from ...common.types import BoolArray, FloatArray, IntArray
from ..nodal_sum import NodalSum
from ..body_size import body_size
from ..crossing import through_obstacle
from ..initial_penetration import InitialPenetration, check_side, nearly_touching

if TYPE_CHECKING:
    from .joined_nodes import JoinedNodes

# Part of a rim node's length that is in contact, by the ratio r of pressures: polynomial, highest power first, and the
# most it can be, where the next node begins to touch. Measured on Hertz's line contact between elastic bodies, the edge
# everywhere between the nodes (13 loads; quadrilaterals, and triangles of degree 2); left is 0.04 of a facet at most.
# On surfaces in space: nodal means of a pressure that falls like the root of the distance from the edge give r = 0.07,
# 0.28, 0.58 for the edge half a facet before, at, and half a facet behind the node.
RIM = {(1, "corner"): (0.72, 1.0, 0.25), (1, "middle"): (1.0,), (2, "corner"): (1.65, 0.4), (2, "middle"): (1.15, 0.3)}
RIM_MOST = {(1, "corner"): 1.25, (1, "middle"): 1.0, (2, "corner"): 1.6, (2, "middle"): 1.2}


def quadrature_rule(shape: str, degree: int) -> tuple[FloatArray, FloatArray]:
    """A rule on a reference facet.

    Args:
        shape: "interval", "triangle" or "quadrilateral".
        degree: of polynomials that are integrated exactly.

    Returns:
        points (flat) [1], weights [1].
    """
    points, weights = basix.make_quadrature(getattr(basix.CellType, shape), degree)
    return np.ascontiguousarray(points).ravel(), np.ascontiguousarray(weights)


class SurfaceGeometry(abc.ABC):
    """Common part: the slave's nodes on this rank and what belongs to each.

    Args:
        spec: Lagrange.
        V: displacement space.
        axisymmetric: x is the radius.
        fixed: mask of prescribed dofs, owned and ghosts.
        basis: "dual", "standard" or "linear".

    Attributes:
        basis: Multipliers. nodes: (n) owned nodes of the slave surface that a multiplier may live at.
        numbers: (n) their global numbers. participates: (n) mask of those where one does.
        weight: (n) diagonal of D: force on the node per multiplier [L^2]. cover: (n) integral of the multiplier's
        function over the part of the surface that faces a master [L^2]; gaps and slips are means over it. At nodes that
        pairs have in common both are sums over the pairs (joined_nodes.py); own_weight, own_cover are of this pair.
        around: (n) as cover, with nodes that carry no multiplier [L^2]. area: (n) of the facets around a node [L^2].
        Both are without facets that lie round a sharp edge, whose numbers are `aside`.
        part: (n) mask of nodes that this pair has a force at. carrier: (n) mask, false where another pair has the
        multiplier of a common node.
        gap: (n) [L]. normal: (n, gdim). fixed: (n, gdim) prescribed components. locked: (n, gdim) those along which the
        motion against the master is prescribed to be zero in this increment.
        tolerance: gaps below it are none [L]. start: displacements at the beginning of the increment, all dofs [L].
    """

    around: FloatArray
    area: FloatArray
    aside: IntArray
    participates: BoolArray
    own_locked: BoolArray
    part: BoolArray
    carrier: BoolArray
    weight: FloatArray
    cover: FloatArray
    own_weight: FloatArray
    own_cover: FloatArray
    weighted_gap: FloatArray
    gap: FloatArray
    normal: FloatArray
    locked: BoolArray
    driven: FloatArray
    start: FloatArray
    displacement: FloatArray
    start_displacement: FloatArray
    offset: FloatArray
    initial: InitialPenetration

    def __init__(self, spec: Any, V: Any, axisymmetric: bool, fixed: BoolArray, basis: str) -> None:
        self.prescribed, self.driven = fixed, np.zeros(len(fixed))
        self.pair, self.V, self.axisymmetric = spec.pair, V, axisymmetric
        self.joined: JoinedNodes | None = None
        self.member = 0
        self.basis = getattr(_cpp.gap.Multipliers, basis)
        self.comm, self.gdim = V.mesh.comm, V.mesh.geometry.dim
        self.slave, self.master = self.pair.surfaces(V)
        self.index_map = V.dofmap.index_map
        self.sum = NodalSum(self.index_map, 1)
        self.start = np.zeros(self.gdim * self.sum.num_nodes)
        self.start_displacement = np.zeros(3)
        self.displacement = np.zeros(3)
        element = self.slave.displacement
        # Exact for the shape functions on flat, affine facets, with the radius as weight.
        self._rule = quadrature_rule(element.shape, 2 * element.degree + 2)
        self._nodes = _cpp.multipliers.MultiplierNodes(V._cpp_object, self.slave, *self._rule, self.basis, axisymmetric)
        self.nodes, self.share, self.area = self._nodes.nodes, self._nodes.share, self._nodes.area
        self.numbers = self.index_map.local_to_global(self.nodes)
        self.fixed = fixed.reshape(-1, self.gdim)[self.nodes]
        self.rest = V.tabulate_dof_coordinates()[:, : self.gdim].copy()
        self.size = body_size(V.mesh)
        self.tolerance = 1e-12 * self.size
        self.offset = np.zeros(len(self.nodes))

    # --- what the two kinds of masters differ in -------------------------------------------------------------------

    @abc.abstractmethod
    def update_cover(self, u: FloatArray) -> None:
        """What of each node faces the master, `around`, and sums of facet normals. Collective.

        Args:
            u: displacements, owned and ghost dofs [L].
        """

    @abc.abstractmethod
    def covered(self) -> BoolArray:
        """Nodes of which enough is covered, mask (n)."""

    @abc.abstractmethod
    def normal_sums(self) -> FloatArray:
        """Sums of facet normals out of the master, (n, gdim)."""

    @abc.abstractmethod
    def integrate(self, carriers: BoolArray) -> None:
        """Weights of the nodes, and locked components, `own_locked`. Collective.

        Args:
            carriers: mask of the nodes that carry a multiplier, (n).
        """

    @abc.abstractmethod
    def update_own_gap(self, locked: BoolArray, sums: FloatArray | None = None) -> None:
        """Normals, and gaps of this pair times its cover, `weighted_gap`. Collective.

        Args:
            locked: as the attribute.
            sums: of facet normals, where other surfaces continue this one, (n, gdim); None: its own.
        """

    @abc.abstractmethod
    def weighted_jump(self, moved: FloatArray) -> FloatArray:
        """Displacements of slave against master times this pair's cover, (n, gdim). Collective.

        Args:
            moved: increments, owned dofs [L].
        """

    @abc.abstractmethod
    def weighted_rows(self, rows: IntArray, weights: FloatArray) -> tuple[IntArray, IntArray, FloatArray]:
        """Rows of this pair's M over weights; see master_rows.

        Args:
            rows: index of the nodes.
            weights: of all nodes, (n) [L^2].
        """

    @abc.abstractmethod
    def over_master(self, values: FloatArray) -> FloatArray:
        """M times values over the owned nodes of V, (n). Collective."""

    @abc.abstractmethod
    def stiffness(self, multiplier: FloatArray, traction: FloatArray, active: BoolArray) -> PETSc.Mat | None:
        """Derivative of minus the contact force at given multipliers [F/L]; None: it is zero. Collective.

        Args:
            multiplier: (n) [F/L^2].
            traction: (n, gdim) [F/L^2].
            active: mask (n).
        """

    @abc.abstractmethod
    def forces(self, traction: FloatArray) -> FloatArray:
        """Nodal forces on slave and master, owned dofs [F]. Collective.

        Args:
            traction: (n, gdim) [F/L^2].
        """

    def edge_angles(self) -> FloatArray:
        """Angle between facets that meet at each node and count for its normal, (n) [degrees]: twice that between them
        and their mean. Zero where normals are the master's. Collective."""
        return np.zeros(len(self.nodes))

    @abc.abstractmethod
    def passed_through(self, had_master: BoolArray) -> BoolArray:
        """Nodes that have passed through the master in this increment, mask (n). Collective.

        Args:
            had_master: mask of nodes that had a master at the start of the increment, (n).
        """

    # --- common ----------------------------------------------------------------------------------------------------

    def update_gap(self, u: FloatArray) -> None:
        """Gaps, normals and locked components. Collective.

        Args:
            u: displacements, owned and ghost dofs [L].
        """
        if self.joined is not None:
            self.joined.update(u)
            return
        self.update_cover(u)
        self.integrate(self.covered())
        self.locked = self.own_locked
        self.update_own_gap(self.locked)
        self.part, self.carrier = self.participates, np.ones(len(self.nodes), dtype=bool)
        self.weight, self.cover = self.own_weight, self.own_cover
        self.gap = np.full(len(self.nodes), np.inf)
        self.gap[self.part] = self.weighted_gap[self.part] / self.cover[self.part]

    def jump(self, moved: FloatArray) -> FloatArray:
        """Means over the cover of the displacement of slave against master, (n, gdim) [L]. Collective.

        Args:
            moved: increments, owned dofs [L].
        """
        if self.joined is not None:
            return self.joined.jump(self.member, moved)
        jump = self.weighted_jump(moved)
        return np.where(self.part[:, None], jump, 0.0) / np.where(self.part, self.cover, 1.0)[:, None]

    def master_rows(self, rows: IntArray) -> tuple[IntArray, IntArray, FloatArray]:
        """Rows of D^-1 M of some of the nodes, D the diagonal.

        Args:
            rows: index of the nodes.

        Returns:
            pointers, global nodes (the master's, and slave nodes without a multiplier), values.
        """
        if self.joined is not None:
            return self.joined.master_rows(self.member, rows)
        return self.weighted_rows(np.ascontiguousarray(rows, dtype=np.int32), self.weight)

    def joined_forces(self, traction: FloatArray) -> FloatArray:
        """Nodal forces of tractions at carriers, of all pairs that share them, owned dofs [F]. Collective.

        Args:
            traction: (n, gdim), of carriers [F/L^2].
        """
        return self.forces(traction) if self.joined is None else self.joined.forces(self.member, traction)

    @property
    def surfaces(self) -> list[Any]:
        """Facets of the bodies that the nodes of this pair may touch."""
        members = [self] if self.joined is None else self.joined.geometries
        return [s for g in members for s in (g.slave, g.master) if s is not None]

    def _set_initial_penetration(self) -> None:
        """The state before anything is loaded, and the offsets of gaps that follow from it. Collective."""
        self.update_gap(self.start)
        self.initial = InitialPenetration(self.pair, self.V, self.slave, self.master, self.points, self.gap)
        self.offset = self.initial.offset

    def begin_step(self, u: FloatArray, displacement: Any, target: FloatArray | None = None) -> None:
        """An increment starts.

        Args:
            u: displacements, owned and ghost dofs [L].
            displacement: of a rigid master at its end, (3); None for deformable masters [L].
            target: prescribed values at its end, over all dofs; None: they stay [L].
        """
        self.start = np.array(u)
        self.driven = np.zeros_like(self.start) if target is None else np.where(self.prescribed, target - u, 0.0)
        if displacement is not None:
            self.start_displacement, self.displacement = self.displacement, np.array(displacement, dtype=float)

    def forget(self) -> None:
        """Forget candidates of the search; of obstacles there are none."""

    def save_state(self) -> dict[str, FloatArray]:
        """Where the increment starts, as a dict of copies."""
        return {name: getattr(self, name).copy() for name in ("start", "start_displacement", "displacement")}

    def restore_state(self, state: dict[str, FloatArray]) -> None:
        """Back to a saved state.

        Args:
            state: of save_state.
        """
        for name, value in state.items():
            setattr(self, name, value.copy())

    def _move(self, u: FloatArray) -> None:
        u = np.ascontiguousarray(u)
        self.u = u
        self.slave.move(u)
        self.points = (self.rest + u.reshape(-1, self.gdim))[self.nodes]

    def ahead(self) -> FloatArray:
        """What prescribed components of the slave's nodes have yet to move in this increment, (n, gdim) [L]."""
        return _cpp.multipliers.remaining_motion(
            self.prescribed, self.driven, self.gdim, self.nodes, self.u, self.start
        )

    def evaluate_at(self, u: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Gap and slip at other displacements; this state stays. Collective.

        Args:
            u: owned and ghost dofs [L].

        Returns:
            gap (n) [L], slip (n, gdim) [L].
        """
        if self.joined is not None:
            return self.joined.evaluate_at(self.member, u)
        there = self.elsewhere()
        there.update_gap(u)
        return there.gap, there.slip()

    def elsewhere(self) -> SurfaceGeometry:
        """A copy that another state may be evaluated with."""
        return copy.copy(self)

    def slip(self) -> FloatArray:
        """Tangential displacement of slave against master in this increment, (n, gdim) [L]. Collective."""
        return self.slip_of(self.jump(self.moved))

    @property
    def moved(self) -> FloatArray:
        """Displacements in this increment, owned dofs [L]."""
        return (self.u - self.start)[: self.gdim * self.index_map.size_local]

    def slip_of(self, jump: FloatArray) -> FloatArray:
        """Tangential part of a displacement against the master as it moves, (n, gdim) [L].

        Args:
            jump: displacement against a master at rest, (n, gdim) [L].
        """
        rigid = (self.displacement - self.start_displacement)[: self.gdim]
        return _cpp.multipliers.tangential(self.normal, jump - rigid)

    def nearest(self) -> BoolArray | None:
        """Nodes to be closed where nothing touches but the bodies nearly do, mask (n), or None: they are apart.
        Collective."""
        gap = nearly_touching(self.comm, self.gap, self.facet_sizes())
        return None if gap is None else self.gap < gap

    def facet_sizes(self) -> FloatArray:
        """Mean size of the facets around each node, (n) [L]. Collective."""
        size = np.repeat(np.linalg.norm(np.ptp(self.slave.X, axis=1), axis=1)[:, None], self.slave.nodes.shape[1], 1)
        sums, counts = (np.zeros(self.sum.num_nodes) for _ in range(2))
        np.add.at(sums, self.slave.nodes, size)
        np.add.at(counts, self.slave.nodes, 1.0)
        sums, counts = (self.sum(a).ravel()[self.nodes] for a in (sums, counts))
        return np.asarray(sums / counts)

    def springs(self, rows: IntArray, blocks: FloatArray) -> PETSc.Mat:
        """Matrix of springs between nodes and what they face on the master [F/L]. Collective.

        Args:
            rows: index of the nodes.
            blocks: (len(rows), gdim, gdim) stiffness [F/L].
        """
        return _cpp.multipliers.springs(
            self.index_map, self.gdim, self.nodes[rows], self.master_rows(rows), np.ascontiguousarray(blocks)
        )

    def part_in_contact(self, pressure: FloatArray, active: BoolArray) -> FloatArray:
        """Part of each node's area that is in contact, (n) [1]. Collective.

        Args:
            pressure: (n) [F/L^2].
            active: mask (n).

        Inside the contact it is 1. At its rim the edge of the contact lies somewhere between the nodes, and the
        pressure tells where: r is the node's pressure over that of its neighbours further inside; RIM says what of the
        area belongs to it. More than 1: the contact reaches into the area of an open node beyond.
        """
        size = self.sum.num_nodes
        p, touching, known = np.zeros(size), np.zeros(size), np.zeros(size)
        p[self.nodes], touching[self.nodes], known[self.nodes] = pressure, active, 1.0
        p, touching, known = (self.sum.forward(a).ravel() for a in (p, touching, known))
        nodes = self.slave.nodes[~np.isin(self.slave.id, self.aside)]
        rim = np.any((known[nodes] > 0) & (touching[nodes] == 0), axis=1) if len(nodes) else np.zeros(0, dtype=bool)
        outermost = np.repeat(rim[:, None], nodes.shape[1], 1)
        if self.gdim == 2:  # an end of a facet whose midpoint touches lies further inside
            outermost[:, :2] &= np.all(touching[nodes[:, 2:]] == 0, axis=1)[:, None]
        larger = p[nodes][:, None, :] > p[nodes][:, :, None]  # [facet, node, neighbour]
        sums = [
            outermost,
            larger.sum(axis=2),
            (larger * p[nodes][:, None, :]).sum(axis=2),
        ]
        on_rim, count, total = (
            self.sum(np.bincount(nodes.ravel(), weights=np.ravel(v), minlength=size)).ravel()[self.nodes] for v in sums
        )
        ratio = pressure * count / np.where(total > 0, total, 1.0)
        part = self._rim_part(ratio)
        return np.where((on_rim > 0) & (total > 0), part, 1.0) * active

    def _rim_part(self, ratio: FloatArray) -> FloatArray:
        """Part of the area of nodes at the rim that is in contact, from the ratio of their pressures."""
        if self.gdim == 3:
            return np.clip((ratio - 0.07) / 0.51, 0.0, 1.0)
        degree = self.slave.displacement.degree
        middle = np.zeros(self.sum.num_nodes)
        np.add.at(middle, self.slave.nodes[:, 2:], 1.0)
        middle = self.sum(middle).ravel()[self.nodes] > 0.0
        corners, middles = (
            np.minimum(np.polyval(RIM[degree, at], ratio), RIM_MOST[degree, at]) for at in ("corner", "middle")
        )
        return np.where(middle, middles, corners)

    def rigid_body_jumps(self, motions: Any, held: IntArray) -> FloatArray:
        """Displacements against the master of some nodes in all rigid motions, (gdim, held nodes, motions). Collective.

        Args:
            motions: RigidBodyModes.
            held: index of the nodes.
        """
        rows = np.zeros((self.gdim, len(held), motions.num_modes))
        touched = np.zeros(motions.count, dtype=np.int32)
        touched[np.concatenate([motions.body[s.nodes.ravel()] for s in self.surfaces])] = 1
        touched = np.sum(self.comm.allgather(touched), axis=0) > 0
        for number in np.flatnonzero(np.repeat(touched, len(motions.names))):
            rows[:, :, number] = self.jump(motions.everywhere(number).ravel())[held].T
        return rows

    def diagonal_stiffness(self, K: PETSc.Mat) -> tuple[FloatArray, FloatArray]:
        """Mean diagonal entries of the nodes' blocks. Collective.

        Args:
            K: tangent of the bodies [F/L].

        Returns:
            of the slave's nodes, (n), and of the blocks opposite to them (zero: rigid), (n) [F/L].
        """
        diagonal = K.getDiagonal()
        values = np.abs(diagonal.array.reshape(-1, self.gdim)).mean(axis=1)
        diagonal.destroy()
        if self.joined is not None:
            opposite = self.joined.over_master(self.member, values)
        else:
            opposite = np.where(self.part, self.over_master(values), 0.0)
        return values[self.nodes], np.abs(opposite / np.where(self.participates, self.weight, 1.0))


class RigidGeometry(SurfaceGeometry):
    """The slave's nodes against an obstacle whose gap is known in closed form.

    Args:
        spec, V, axisymmetric, fixed: as in SurfaceGeometry.
    """

    def __init__(self, spec: Any, V: Any, axisymmetric: bool, fixed: BoolArray) -> None:
        super().__init__(spec, V, axisymmetric, fixed, "dual")
        self.obstacle = self.pair.rigid_master.obstacle(self.gdim)
        self._shares = _cpp.multipliers.FacingShares(
            V._cpp_object, self.slave, self._nodes, *self._rule, self.basis, axisymmetric
        )
        check_side(self.pair, V, self.slave, self.obstacle)
        self._set_initial_penetration()

    def update_cover(self, u: FloatArray) -> None:
        """Gaps, and areas that face the obstacle; see SurfaceGeometry. Collective."""
        self._move(u)
        self.obstacle.displacement = self.displacement.tolist()
        self.around = self.area = self._shares.evaluate(self.slave, self.obstacle)
        self.aside = self._shares.aside
        self._nodal = self.obstacle.evaluate(np.ascontiguousarray(self.points).ravel())

    def covered(self) -> BoolArray:
        """All nodes: gaps are those of the nodes themselves."""
        return np.ones(len(self.nodes), dtype=bool)

    def normal_sums(self) -> FloatArray:
        """Normals of the obstacle; see SurfaceGeometry."""
        return self._nodal[1]

    def integrate(self, carriers: BoolArray) -> None:
        """Weights and locked components; see SurfaceGeometry."""
        self.participates, self.own_weight, self.own_cover = carriers, self.around, self.around
        motion = (self.displacement - self.start_displacement).tolist()
        self.own_locked = _cpp.multipliers.locked_components(
            self.prescribed, self.driven, self.gdim, self.nodes, motion, self.tolerance
        )

    def passed_through(self, had_master: BoolArray) -> BoolArray:
        """Nodes on the far side of the obstacle; see SurfaceGeometry. Collective."""
        moved = (self.u - self.start).reshape(-1, self.gdim)[self.nodes]
        moved = moved - (self.displacement - self.start_displacement)[: self.gdim]
        return through_obstacle(self.obstacle, self.points - moved, self.points, self.offset, self.tolerance)

    def update_own_gap(self, locked: BoolArray, sums: FloatArray | None = None) -> None:
        """Gaps and normals, which are the obstacle's; see SurfaceGeometry."""
        gap, self.normal, self.hessian = self._nodal
        self.weighted_gap = self.own_cover * (gap + self.offset)

    def weighted_jump(self, moved: FloatArray) -> FloatArray:
        """Displacements of the nodes against an obstacle at rest; see SurfaceGeometry."""
        return self.own_cover[:, None] * moved.reshape(-1, self.gdim)[self.nodes]

    def weighted_rows(self, rows: IntArray, weights: FloatArray) -> tuple[IntArray, IntArray, FloatArray]:
        """No master nodes."""
        return np.zeros(len(rows) + 1, dtype=np.int64), np.empty(0, dtype=np.int64), np.empty(0)

    def over_master(self, values: FloatArray) -> FloatArray:
        """No master nodes: zeros."""
        return np.zeros(len(self.nodes))

    def stiffness(self, multiplier: FloatArray, traction: FloatArray, active: BoolArray) -> PETSc.Mat | None:
        """The normal turns where a node slides over a curved obstacle: matrix of - D lambda d n/dx, or None.
        Collective."""
        rows = np.flatnonzero(active & (multiplier != 0.0))
        blocks = -(self.own_weight * multiplier)[rows, None, None] * self.hessian[rows]
        if not self.comm.allreduce(int(np.any(blocks))):
            return None
        alone = self.weighted_rows(rows, self.own_weight)
        return _cpp.multipliers.springs(
            self.index_map, self.gdim, self.nodes[rows], alone, np.ascontiguousarray(blocks)
        )

    def forces(self, traction: FloatArray) -> FloatArray:
        """Nodal forces on the slave; see SurfaceGeometry."""
        out = np.zeros((self.index_map.size_local, self.gdim))
        out[self.nodes] = self.own_weight[:, None] * traction
        return out.ravel()
