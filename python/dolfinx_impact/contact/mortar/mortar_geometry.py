# SPDX-License-Identifier: MIT
"""Nodal gaps, normals and weights between two deformable surfaces, by mortar integrals."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np
from petsc4py import PETSc

from ... import _cpp
from ...common.types import BoolArray, FloatArray, IntArray
from ..crossing import through_master
from .geometry import SurfaceGeometry, quadrature_rule

# Sine of the largest angle by which facets may tilt a normal at a plane of symmetry: 5 degrees, docs/contact.md.
SYMMETRY = np.sin(np.deg2rad(5.0))


class MortarGeometry(SurfaceGeometry):
    """Weighted gaps between two deformable surfaces, and the matrices D and M of docs/contact.md.

    Args:
        spec, V, axisymmetric, fixed: as in SurfaceGeometry.
        basis: "dual", "standard", "linear". With the dual basis D is diagonal among the nodes with a multiplier.

    Attributes:
        search: PairSearch. integrals: MortarIntegrals of the present state.
    """

    def __init__(self, spec: Any, V: Any, axisymmetric: bool, fixed: BoolArray, basis: str = "dual") -> None:
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

    def elsewhere(self) -> MortarGeometry:
        """A copy with integrals of its own; see SurfaceGeometry."""
        there = copy.copy(self)
        there.integrals = self._ahead
        return there

    def forget(self) -> None:
        """Forget candidates of the search."""
        self.search.forget()
        if self.joined is not None:
            self.joined.forget()

    def update_cover(self, u: FloatArray) -> None:
        """Search, segments and cover; see SurfaceGeometry. Collective."""
        self._move(u)
        self.integrals.update_cover(self.u, self.start)
        self.around, self.area, self.aside = self.integrals.around, self.integrals.area, self.integrals.aside

    def covered(self) -> BoolArray:
        """Nodes of which enough is covered, mask (n)."""
        return self.integrals.covered()

    def normal_sums(self) -> FloatArray:
        """Sums of facet normals; see SurfaceGeometry."""
        return self.integrals.sums_at_nodes().reshape(-1, self.gdim)

    def edge_angles(self) -> FloatArray:
        """From the sum of unit normals over their number; see SurfaceGeometry. Collective."""
        counting = np.zeros(self.sum.num_nodes)
        np.add.at(counting, self.slave.nodes[~np.isin(self.slave.id, self.aside)], 1.0)
        counting = self.sum(counting).ravel()[self.nodes]
        lengths = np.linalg.norm(self.normal_sums(), axis=1)
        cosines = np.clip(lengths / np.where(counting > 0, counting, np.inf), 0.0, 1.0)
        return np.asarray(np.where(counting > 0, 2 * np.degrees(np.arccos(cosines)), 0.0))

    def integrate(self, carriers: BoolArray) -> None:
        """Mortar integrals and locked components; see SurfaceGeometry. Collective."""
        made = self.integrals
        made.integrate(carriers)
        self.map, self.participates, self.own_weight, self.own_cover = made.map, carriers, made.weight, made.cover
        self.own_locked = self._locked()

    def update_own_gap(self, locked: BoolArray, sums: FloatArray | None = None) -> None:
        """Gaps and normals; see SurfaceGeometry. Collective."""
        made = self.integrals
        if sums is not None:
            made.set_sums(np.ascontiguousarray(sums))
        made.update_gap(locked, SYMMETRY)
        self.normal = made.normal.reshape(-1, self.gdim)
        self.weighted_gap = made.weighted_gap + np.where(self.participates, self.offset * self.own_cover, 0.0)

    @property
    def mortar(self) -> Any:
        """Mortar integrals by entries, rows and columns numbered as the facets' nodes."""
        return self.integrals.entries

    def jump_matrix(self) -> PETSc.Mat:
        """D - M: weighted displacements of the slave against the master, (nodes, nodes), rows of nodes with a
        multiplier; kept by the integrals [L^2]. Collective."""
        return self.integrals.jump_matrix()

    def _locked(self) -> BoolArray:
        """Prescribed components, mask (n, gdim), along which the master is prescribed to move as the slave's node does:
        at one of the nodes it faces that lies on one plane with it, or at all of them. Collective."""
        if not self._any_fixed:
            return self.fixed
        return _cpp.multipliers.locked_components(
            self.prescribed, self.driven, self.gdim, self.integrals, self.rest.ravel() + self.u, self.size,
            self.tolerance,
        )  # fmt: skip

    def passed_through(self, had_master: BoolArray) -> BoolArray:
        """Nodes that have lost their master deep inside it; see SurfaceGeometry. Collective."""
        here, suspects = self.u, had_master & ~self.participates
        if not self.comm.allreduce(int(np.any(suspects))):
            return suspects

        def gap_at(part: float) -> FloatArray:
            there = self.elsewhere()
            there.joined = None  # the gaps against this pair's own master
            there.update_gap(self.start + part * (here - self.start))
            return np.where(there.participates, there.gap, np.inf)

        passed = through_master(self.comm, suspects, self.facet_sizes(), gap_at)
        self.slave.move(here)
        if self.joined is not None:
            self.joined.forget()  # its states elsewhere have these integrals, too
        return passed

    def over_master(self, values: FloatArray) -> FloatArray:
        """M times values; see SurfaceGeometry. Collective."""
        return self.integrals.over_master(values, 1).ravel()

    def weighted_jump(self, moved: FloatArray) -> FloatArray:
        """Jumps times the cover; see SurfaceGeometry. Collective."""
        return self.integrals.weighted_jump(np.ascontiguousarray(moved)).reshape(-1, self.gdim)

    def weighted_rows(self, rows: IntArray, weights: FloatArray) -> tuple[IntArray, IntArray, FloatArray]:
        """Rows of M over weights; see SurfaceGeometry."""
        return self.integrals.master_rows(np.ascontiguousarray(rows, dtype=np.int32), np.ascontiguousarray(weights))

    def stiffness(self, multiplier: FloatArray, traction: FloatArray, active: BoolArray) -> PETSc.Mat | None:
        """Points slide over the master, normals turn: derivative of minus the contact force, a matrix that the
        integrals keep, or None. Collective."""
        return self.integrals.tangent(multiplier, np.ascontiguousarray(traction), active)

    def forces(self, traction: FloatArray) -> FloatArray:
        """Nodal forces on slave and master; see SurfaceGeometry. Collective."""
        return self.integrals.contact_forces(np.ascontiguousarray(traction))
