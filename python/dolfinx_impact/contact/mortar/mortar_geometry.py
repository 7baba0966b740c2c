# SPDX-License-Identifier: MIT
"""Nodal gaps, normals and weights between two deformable surfaces, by mortar integrals."""

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

    def _elsewhere(self) -> "MortarGeometry":
        there = copy.copy(self)
        there.integrals = self._ahead
        return there

    def forget(self) -> None:
        """Forget candidates of the search."""
        self.search.forget()

    def update_gap(self, u: FloatArray) -> None:
        """Search, segments, mortar integrals, gaps and normals; see SurfaceGeometry. Collective."""
        self._move(u)
        made = self.integrals
        made.update(self.u, self.start)
        self.map, self.participates, self.weight, self.cover = made.map, made.participates, made.weight, made.cover
        self.locked = self._locked()
        made.update_gap(self.locked, SYMMETRY)
        self.normal = made.normal.reshape(-1, self.gdim)
        self.gap = made.gap + np.where(self.participates, self.offset, 0.0)

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
            there = self._elsewhere()
            there.update_gap(self.start + part * (here - self.start))
            return np.where(there.participates, there.gap, np.inf)

        passed = through_master(self.comm, suspects, self.facet_sizes(), gap_at)
        self.slave.move(here)
        return passed

    def _facing(self, values: FloatArray) -> FloatArray:
        over = self.integrals.over_master(values, 1).ravel()
        return np.abs(np.where(self.participates, over / np.where(self.participates, self.weight, 1.0), 0.0))

    def jump(self, moved: FloatArray) -> FloatArray:
        """Means over the cover of the displacement of slave against master; see SurfaceGeometry. Collective."""
        return self.integrals.jump(np.ascontiguousarray(moved)).reshape(-1, self.gdim)

    def master_rows(self, rows: IntArray) -> tuple[IntArray, IntArray, FloatArray]:
        """Rows of D^-1 M of some of the nodes; see SurfaceGeometry."""
        return self.integrals.master_rows(np.ascontiguousarray(rows, dtype=np.int32))

    def stiffness(self, multiplier: FloatArray, traction: FloatArray, active: BoolArray) -> PETSc.Mat | None:
        """Points slide over the master, normals turn: derivative of minus the contact force, a matrix that the
        integrals keep, or None. Collective."""
        return self.integrals.tangent(multiplier, np.ascontiguousarray(traction), active)

    def forces(self, traction: FloatArray) -> FloatArray:
        """Nodal forces on slave and master; see SurfaceGeometry. Collective."""
        return self.integrals.contact_forces(np.ascontiguousarray(traction))
