# SPDX-License-Identifier: MIT
"""Nodal gaps, normals and weights between two deformable surfaces, by mortar integrals."""

import numpy as np
from petsc4py import PETSc

from ... import _cpp
from .geometry import LEAST, SurfaceGeometry, quadrature_rule
from ..matrices import NodalSum, matrix, owned_rows
from ..neighbours import Neighbours

# Sine of the largest angle by which facets may tilt a normal at a plane of symmetry: 5 degrees, docs/contact.md.
SYMMETRY = np.sin(np.deg2rad(5.0))
# Nodes lie on one plane of symmetry where they are apart across it by less than this part of the bodies' size.
PLANE = 1e-6


class MortarGeometry(SurfaceGeometry):
    """Weighted gaps between two deformable surfaces, and the matrices D and M of docs/contact.md.

    Args:
        basis: "dual", "standard", "linear". With the dual basis D is diagonal among the nodes with a multiplier.
    """

    def __init__(self, spec, V, axisymmetric, fixed, basis="dual"):
        super().__init__(spec, V, axisymmetric, fixed, basis)
        self._any_fixed = self.comm.allreduce(int(np.any(self.fixed))) > 0
        element, other = self.slave.displacement, self.master.displacement
        degree = spec.quadrature_degree
        if degree is None:
            flat = element.shape != "quadrilateral" and self.slave.geometry.degree == 1
            degree = 2 * element.degree + other.degree + (2 if flat else 4)
        self.points_of_rule, self.weights = quadrature_rule("interval" if self.gdim == 2 else "triangle", degree)
        self.neighbours = Neighbours(self.pair, V, self.slave, self.master)
        self._matrix = None
        self._set_initial_penetration()

    def update_gap(self, u):
        """Search, segments, mortar integrals, gaps and normals at u. Collective."""
        self._move(u)
        near = self.neighbours
        reach = near.update(self.u, self.start)
        self.map = near.map
        num_nodes = self.map.size_local + self.map.num_ghosts
        self.segments = _cpp.gap.segment(
            near.slave, near.master, self.points_of_rule, self.weights, reach, self.axisymmetric
        )
        scalars, vectors = NodalSum(self.map, 1), NodalSum(self.map, self.gdim)

        def nodal(nodes, values):
            return scalars(np.bincount(np.ravel(nodes), weights=np.ravel(values), minlength=num_nodes)).ravel()

        around = nodal(near.slave.nodes, _cpp.gap.cover(near.slave, self.segments, self.basis))[self.nodes]
        self.participates = around > LEAST * self.area
        carries = np.zeros(num_nodes)
        carries[self.nodes[self.participates]] = 1.0
        carries = scalars.forward(carries).ravel().astype(np.int8)
        self.mortar = _cpp.gap.mortar(near.slave, near.master, self.segments, self.basis, carries)
        rows, cols, values = self.mortar.D
        own = rows == cols
        self.weight = nodal(rows[own], values[own])[self.nodes]
        self.cover = nodal(rows, values)[self.nodes]  # the shape functions add up to one
        gamma = np.zeros((num_nodes, self.gdim))
        np.add.at(gamma, near.slave.nodes.ravel(), self.mortar.gamma.reshape(-1, self.gdim))
        gamma = vectors(gamma)[self.nodes]
        sums = np.zeros(num_nodes * self.gdim)
        _cpp.gap.add_normals(near.slave, sums)
        self.sums = vectors(sums)
        self.locked = self._locked()
        self.normal = self._nodal_normals(self.sums[self.nodes])
        self.gap = np.full(len(self.nodes), np.inf)
        on = self.participates
        self.gap[on] = np.einsum("na,na->n", self.normal[on], gamma[on]) / self.cover[on] + self.offset[on]
        if self._matrix is not None:
            self._matrix.destroy()
        # Slave nodes beside the diagonal of D, without a multiplier of their own, stand among the master's.
        self._matrix = self._nodal_matrix(self.mortar.M, (rows[~own], cols[~own], -values[~own]))

    def _nodal_matrix(self, *parts):
        """Matrix (nodes, nodes) from entries numbered as the facets' nodes. Collective."""
        rows, cols, values = (np.concatenate([p[i] for p in parts]) for i in range(3))
        rows, cols = (self.map.local_to_global(np.asarray(a, dtype=np.int32)) for a in (rows, cols))
        return matrix(self.comm, self.map.size_local, rows, cols, values)

    def jump_matrix(self):
        """D - M: weighted displacements of the slave against the master, (nodes, nodes), rows of nodes with a
        multiplier [L^2]. The caller destroys it. Collective."""
        rows, cols, values = self.mortar.M
        return self._nodal_matrix(self.mortar.D, (rows, cols, -values))

    def _nodal_normals(self, sums):
        """Unit normals; on planes of symmetry, which facets meet nearly at right angles, in them."""
        normals = sums / np.linalg.norm(sums, axis=1)[:, None]
        normals[self.locked & (np.abs(normals) < SYMMETRY)] = 0.0
        return normals / np.linalg.norm(normals, axis=1)[:, None]

    def _locked(self):
        """Prescribed components, mask (n, gdim), along which the master is prescribed to move as the slave's node does:
        at one of the nodes it faces that lies on one plane with it, or at all of them. Collective."""
        if not self._any_fixed:
            return self.fixed
        size = self.map.size_local + self.map.num_ghosts
        known = np.zeros((size, 3 * self.gdim))
        fields = self.prescribed, self.driven, self.rest.ravel() + self.u
        own = np.hstack([values.reshape(-1, self.gdim) for values in fields])
        known[: self.index_map.size_local] = own[: self.index_map.size_local]
        fixed, moved, x = np.split(NodalSum(self.map, 3 * self.gdim).forward(known), 3, axis=1)
        rows, cols, _ = self.mortar.M
        some = np.any(fixed[rows] > 0.0, axis=1)
        rows, cols = rows[some], cols[some]
        equal = (fixed[cols] > 0.0) & self.same(moved[rows], moved[cols])
        beside = equal & (np.abs(x[rows] - x[cols]) < PLANE * self.size)
        sums = np.zeros((size, 2 * self.gdim))
        np.add.at(sums, rows, np.hstack([beside, ~equal]))
        on_plane, other = np.split(NodalSum(self.map, 2 * self.gdim)(sums)[self.nodes], 2, axis=1)
        return self.fixed & ((on_plane > 0.0) | (other == 0.0))

    def _facing(self, values):
        over = self._over_master(values[:, None])[self.nodes, 0]
        return np.abs(np.where(self.participates, over / np.where(self.participates, self.weight, 1.0), 0.0))

    def _over_master(self, values):
        """M times nodal values (owned nodes, gdim)."""
        source, out = self._matrix.createVecRight(), self._matrix.createVecLeft()
        result = np.empty_like(values)
        for c in range(values.shape[1]):
            source.array[:] = values[:, c]
            self._matrix.mult(source, out)
            result[:, c] = out.array
        source.destroy()
        out.destroy()
        return result

    def jump(self, moved):
        """Weighted displacements of slave against master, (n, gdim), of increments over owned dofs. Collective."""
        moved = np.ascontiguousarray(moved.reshape(-1, self.gdim))
        over = self._over_master(moved)[self.nodes]
        weight, cover = (np.where(self.participates, w, 1.0)[:, None] for w in (self.weight, self.cover))
        return np.where(self.participates[:, None], (weight * moved[self.nodes] - over) / cover, 0.0)

    def master_rows(self, rows):
        """Rows of D^-1 M of some of the nodes, D the diagonal: pointers, global nodes (the master's, and slave nodes
        without a multiplier), values."""
        pointers, columns, values = owned_rows(self._matrix)
        nodes = self.nodes[rows]
        counts = (pointers[nodes + 1] - pointers[nodes]).astype(int)
        ends = np.concatenate([[0], np.cumsum(counts)])
        where = np.repeat(pointers[nodes] - ends[:-1], counts) + np.arange(ends[-1])
        return ends, columns[where], values[where] / np.repeat(self.weight[rows], counts)

    def stiffness(self, multiplier, traction, active):
        """Points slide over the master, normals turn: derivative of minus the contact force, or None. Collective."""
        if self.comm.allreduce(int(np.any(multiplier[active]))) == 0:
            return None
        size = self.map.size_local + self.map.num_ghosts
        z, force = np.zeros((size, self.gdim)), np.zeros(size)
        z[self.nodes[active]] = traction[active]
        force[self.nodes[active]] = (multiplier * self.weight)[active]
        z, force = NodalSum(self.map, self.gdim).forward(z), NodalSum(self.map, 1).forward(force)
        near = self.neighbours
        sliding, turning = (
            matrix(self.comm, self.gdim * self.map.size_local, self._global(rows), self._global(cols), values)
            for rows, cols, values in (
                _cpp.gap.sliding_tangent(near.slave, near.master, self.segments, self.mortar, z.ravel()),
                _cpp.gap.turning_tangent(near.slave, self.sums.ravel(), force.ravel()),
            )
        )
        # What turns on the slave turns on the master.
        jump = self._jumps(np.flatnonzero(active))
        both = jump.transposeMatMult(turning)
        both.axpy(1.0, sliding, PETSc.Mat.Structure.DIFFERENT_NONZERO_PATTERN)
        for part in (sliding, turning, jump):
            part.destroy()
        return both

    def _jumps(self, rows):
        """Matrix of displacements of nodes against what they face on the master, (dofs, dofs). Collective."""
        pointers, columns, values = self.master_rows(rows)
        nodes = self.map.local_to_global(self.nodes[rows].astype(np.int32))
        i = np.concatenate([nodes, np.repeat(nodes, np.diff(pointers))])
        j, values = np.concatenate([nodes, columns]), np.concatenate([np.ones(len(nodes)), -values])
        axes = np.arange(self.gdim)
        i, j = (self.gdim * k[:, None] + axes for k in (i, j))
        return matrix(self.comm, self.gdim * self.map.size_local, i, j, np.repeat(values, self.gdim))

    def _global(self, dofs):
        nodes = self.map.local_to_global((dofs // self.gdim).astype(np.int32))
        return self.gdim * nodes + dofs % self.gdim

    def forces(self, traction):
        """Nodal forces on slave and master, array over owned dofs [F]. Collective."""
        num_owned = self.index_map.size_local
        z = np.zeros((num_owned, self.gdim))
        on = self.participates
        z[self.nodes[on]] = traction[on]
        out = np.zeros((num_owned, self.gdim))
        out[self.nodes[on]] = self.weight[on, None] * traction[on]
        source, to = self._matrix.createVecLeft(), self._matrix.createVecRight()
        for c in range(self.gdim):
            source.array[:] = z[:, c]
            self._matrix.multTranspose(source, to)
            out[:, c] -= to.array
        source.destroy()
        to.destroy()
        return out.ravel()
