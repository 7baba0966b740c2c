# SPDX-License-Identifier: MIT
"""Nodal gaps, normals and weights between two deformable surfaces, by mortar integrals."""

import copy

import numpy as np

from ... import _cpp
from .geometry import SurfaceGeometry, quadrature_rule
from ..matrices import NodalSum

# Sine of the largest angle by which facets may tilt a normal at a plane of symmetry: 5 degrees, docs/contact.md.
SYMMETRY = np.sin(np.deg2rad(5.0))
# Nodes lie on one plane of symmetry where they are apart across it by less than this part of the bodies' size.
PLANE = 1e-6


class MortarGeometry(SurfaceGeometry):
    """Weighted gaps between two deformable surfaces, and the matrices D and M of docs/contact.md.

    Args:
        basis: "dual", "standard", "linear". With the dual basis D is diagonal among the nodes with a multiplier.

    Attributes:
        search: PairSearch. integrals: MortarIntegrals of the present state.
    """

    def __init__(self, spec, V, axisymmetric, fixed, basis="dual"):
        super().__init__(spec, V, axisymmetric, fixed, basis)
        self._any_fixed = self.comm.allreduce(int(np.any(self.fixed))) > 0
        element, other = self.slave.displacement, self.master.displacement
        degree = spec.quadrature_degree
        if degree is None:
            flat = element.shape != "quadrilateral" and self.slave.geometry.degree == 1
            degree = 2 * element.degree + other.degree + (2 if flat else 4)
        rule = quadrature_rule("interval" if self.gdim == 2 else "triangle", degree)
        space = V._cpp_object
        self.search = _cpp.search.PairSearch(space, self.slave, self.master, self.pair.search_distance or 0.0)
        # The second for evaluate_at.
        self.integrals, self._ahead = (
            _cpp.multipliers.MortarIntegrals(space, self.search, self._nodes, *rule, self.basis, axisymmetric)
            for _ in range(2)
        )
        self._set_initial_penetration()

    def _elsewhere(self):
        there = copy.copy(self)
        there.integrals = self._ahead
        return there

    def update_gap(self, u):
        """Search, segments, mortar integrals, gaps and normals at u. Collective."""
        self._move(u)
        made = self.integrals
        made.update(self.u, self.start)
        self.map, self.participates, self.weight, self.cover = made.map, made.participates, made.weight, made.cover
        self.locked = self._locked()
        made.update_gap(self.locked, SYMMETRY)
        self.normal = made.normal.reshape(-1, self.gdim)
        self.gap = made.gap + np.where(self.participates, self.offset, 0.0)

    @property
    def mortar(self):
        """Mortar integrals by entries, rows and columns numbered as the facets' nodes."""
        return self.integrals.entries

    def jump_matrix(self):
        """D - M: weighted displacements of the slave against the master, (nodes, nodes), rows of nodes with a
        multiplier; kept by the integrals [L^2]. Collective."""
        return self.integrals.jump_matrix()

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
        over = self.integrals.over_master(values, 1).ravel()
        return np.abs(np.where(self.participates, over / np.where(self.participates, self.weight, 1.0), 0.0))

    def jump(self, moved):
        """Weighted displacements of slave against master, (n, gdim), of increments over owned dofs. Collective."""
        return self.integrals.jump(np.ascontiguousarray(moved)).reshape(-1, self.gdim)

    def master_rows(self, rows):
        """Rows of D^-1 M of some of the nodes, D the diagonal: pointers, global nodes (the master's, and slave nodes
        without a multiplier), values."""
        return self.integrals.master_rows(np.ascontiguousarray(rows, dtype=np.int32))

    def stiffness(self, multiplier, traction, active):
        """Points slide over the master, normals turn: derivative of minus the contact force, a matrix that the
        integrals keep, or None. Collective."""
        return self.integrals.tangent(multiplier, np.ascontiguousarray(traction), active)

    def forces(self, traction):
        """Nodal forces on slave and master, array over owned dofs [F]. Collective."""
        return self.integrals.contact_forces(np.ascontiguousarray(traction))
