# SPDX-License-Identifier: MIT
"""Discretised bodies: assembly, statics, natural frequencies."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Literal, overload

import numpy as np

from . import _reference, rules
from ._reference import Material
from .array_types import ArrayLike, FloatArray, IntArray, Rule, floats, integers, vector
from .sparse import Csr


@dataclass
class StaticSolution:
    """Result of `Model.solve_static`; unpacks as `u, reactions`."""

    u: FloatArray  # displacements (num_dofs) [L]
    reactions: FloatArray  # internal force minus load on fixed dofs, zero elsewhere (num_dofs) [F]
    iterations: list[int]  # Newton iterations of every load step
    residuals: list[float]  # relative residual at the end of every load step [1]

    def __iter__(self) -> Iterator[FloatArray]:
        return iter((self.u, self.reactions))


class Discretisation:
    """Body of hand-written elements, seed (3.17)-(3.30).

    If the degrees of field and geometry differ, the model numbers its own field nodes: `field_points`, shape
    (num_nodes, gdim) [L], and `field_cells`. The degree of freedom of a component is gdim * node + component.

    Args:
        points: points of the geometry, shape (num_points, gdim) [L].
        cells: points of every cell in the order of `reference_nodes`, shape (num_cells, nodes per cell).
        cell_type: "triangle", "quadrilateral", "tetrahedron" or "hexahedron".
        material: material of all cells; None where `materials` is given.
        degree: degree of the displacement field, 1 or 2; None takes the geometry's.
        geometry_degree: degree of the geometry, 1 or 2.
        rule: rule of all integrals over cells; or a dict from purposes ("stiffness", "finite_strain", "mass", "load")
            to rules. None, and purposes that the dict leaves out, take the default.
        facet_rule: rule of integrals over facets; None takes the default.
        cell_tags: tag of every cell, shape (num_cells); needed with `materials`.
        materials: material of every tag.
        averaged_pressure: average the volumetric part at the nodes in energy and internal force
            (docs/averaged_pressure.md): tetrahedra and triangles of degree 1; there is no tangent then.
        averaged_strain: the same, and 0.6 of the other part with strains averaged at the nodes.

    Raises:
        ValueError: data out of range, connectivity that does not fit, unused points, inverted or empty cells.
        TypeError: cells or tags that are not integers.
    """

    def __init__(
        self,
        points: ArrayLike,
        cells: ArrayLike,
        cell_type: str,
        material: Material | None = None,
        *,
        degree: int | None = None,
        geometry_degree: int = 1,
        rule: Rule | dict[str, Rule] = None,
        facet_rule: Rule = None,
        cell_tags: ArrayLike | None = None,
        materials: Mapping[int, Material] | None = None,
        averaged_pressure: bool = False,
        averaged_strain: bool = False,
    ) -> None:
        if (material is None) == (materials is None):
            raise ValueError("give either one material or materials={tag: Material}")
        if materials is not None and cell_tags is None:
            raise ValueError("materials={tag: Material} needs cell_tags, one tag per cell")
        points = floats(points)
        if points.ndim != 2:
            raise ValueError(f"points must have shape (num_points, gdim), found {points.shape}")
        tags: list[int] = []
        if materials is None:
            materials = {0: material}
        elif cell_tags is not None:
            tags = [int(tag) for tag in integers(cell_tags, "cell_tags", 1)]
        materials = {int(tag): law for tag, law in materials.items()}
        self.degree = geometry_degree if degree is None else degree
        self.geometry_degree = geometry_degree
        self.cell_type = cell_type
        self.materials = materials
        self.rule = rule
        self.facet_rule = facet_rule
        self.axisymmetric: bool = next(iter(materials.values())).hypothesis == "axisymmetric"
        self.linear = all(law.law == "linear_elastic" for law in materials.values())
        self._model = _reference.Model(
            points, integers(cells, "cells", 2), cell_type, materials, tags, self.degree, geometry_degree
        )
        if averaged_pressure:
            self._model.average_pressure()
        if averaged_strain:
            self._model.average_strain()
        self.points = points
        self.cells = np.asarray(cells)
        self.field_points: FloatArray = self._model.field_points
        self.field_cells: IntArray = self._model.field_cells
        self.num_dofs = self.field_points.size

    def _rule(self, purpose: str) -> tuple[FloatArray, FloatArray]:
        facet = purpose == "facet"
        cell = rules.facet_type(self.cell_type) if facet else self.cell_type
        rule = self.facet_rule if facet else self.rule
        if isinstance(rule, dict):
            rule = rule.get(purpose)
        return rules.points_and_weights(cell, rule, purpose, self.degree, self.geometry_degree, self.axisymmetric)

    def _strain_rule(self) -> tuple[FloatArray, FloatArray]:
        return self._rule("stiffness" if self.linear else "finite_strain")

    def _matrix(self, matrix: _reference.Csr) -> Csr:
        return Csr(*matrix.arrays)

    def stiffness(self) -> Csr:
        """Stiffness matrix K of linear elasticity, whatever the law, seed (3.26).

        Returns:
            K, shape (num_dofs, num_dofs) [F/L].
        """
        return self._matrix(self._model.stiffness(*self._rule("stiffness")))

    @overload
    def mass(self, lumped: Literal[False] = False, scheme: str = "auto") -> Csr: ...

    @overload
    def mass(self, lumped: Literal[True], scheme: str = "auto") -> FloatArray: ...

    def mass(self, lumped: bool = False, scheme: str = "auto") -> Csr | FloatArray:
        """Consistent or lumped mass matrix.

        Args:
            lumped: return the diagonal of the lumped mass.
            scheme: how the mass is lumped, as in `element_lumped_mass`.

        Returns:
            Consistent mass, shape (num_dofs, num_dofs) [M]; lumped: the diagonal, shape (num_dofs) [M].
        """
        if lumped:
            return self._model.lumped_mass(*self._rule("mass"), scheme)
        return self._matrix(self._model.mass(*self._rule("mass")))

    def damping(self, alpha: float, beta: float) -> Csr:
        """Rayleigh damping matrix alpha M + beta K, seed (3.67).

        Args:
            alpha: factor of the mass [1/T].
            beta: factor of the stiffness [T].

        Returns:
            Damping, shape (num_dofs, num_dofs) [F T/L].
        """
        strain, mass = self._rule("stiffness"), self._rule("mass")
        return self._matrix(self._model.damping(*strain, *mass, float(alpha), float(beta)))

    def energy(self, u: ArrayLike) -> float:
        """Strain energy.

        Args:
            u: displacements, shape (num_dofs) [L].

        Returns:
            Energy [F L].
        """
        return self._model.energy(*self._strain_rule(), vector(u))

    def internal_force(self, u: ArrayLike) -> FloatArray:
        """Internal force.

        Args:
            u: displacements, shape (num_dofs) [L].

        Returns:
            Force, shape (num_dofs) [F].
        """
        return self._model.internal_force(*self._strain_rule(), vector(u))

    def tangent(self, u: ArrayLike) -> Csr:
        """Derivative of the internal force.

        Args:
            u: displacements, shape (num_dofs) [L].

        Returns:
            Tangent, shape (num_dofs, num_dofs) [F/L].
        """
        return self._matrix(self._model.tangent(*self._strain_rule(), vector(u)))

    def stress(self, u: ArrayLike, rule: Rule = None) -> tuple[FloatArray, FloatArray]:
        """Stress at the points of a rule: Cauchy for a linear law, 2nd Piola-Kirchhoff otherwise.

        Args:
            u: displacements, shape (num_dofs) [L].
            rule: None (the rule of the stiffness), a name, or a pair (points, weights).

        Returns:
            Stress, shape (num_cells, num_points, num_strains) [F/L^2], and positions of the points in the reference
            configuration, shape (num_cells, num_points, gdim) [L].
        """
        if rule is None:
            points, weights = self._rule("stiffness")
        else:
            points, weights = rules.points_and_weights(self.cell_type, rule, None, None, None, None)
        values, positions = self._model.stress(points, weights, vector(u))
        shape = (len(self.cells), len(weights), -1)
        return values.reshape(shape), positions.reshape(shape)

    def body_force(self, f: ArrayLike) -> FloatArray:
        """Load of a constant force per volume.

        Args:
            f: force per volume, shape (gdim) [F/L^3].

        Returns:
            Load, shape (num_dofs) [F].
        """
        return self._model.body_force(*self._rule("load"), vector(f))

    def traction(self, facets: ArrayLike, t: ArrayLike) -> FloatArray:
        """Load of a constant traction on facets.

        Args:
            facets: points of every facet, shape (num_facets, nodes per facet); its vertices suffice.
            t: traction, shape (gdim) [F/L^2].

        Returns:
            Load, shape (num_dofs) [F].
        """
        return self._model.traction(*self._rule("facet"), integers(facets, "facets", 2), vector(t))

    def follower_pressure(self, u: ArrayLike, facets: ArrayLike, p: float) -> tuple[FloatArray, Csr]:
        """Load of a pressure that stays normal to deformed boundary facets, and its tangent.

        Args:
            u: displacements, shape (num_dofs) [L].
            facets: points of every facet, shape (num_facets, nodes per facet); its vertices suffice.
            p: pressure, positive where it pushes on the surface [F/L^2].

        Returns:
            Load f, shape (num_dofs) [F], and df/du, shape (num_dofs, num_dofs) [F/L].
        """
        facets = integers(facets, "facets", 2)
        force, tangent = self._model.follower_pressure(*self._rule("facet"), facets, vector(u), float(p))
        return force, self._matrix(tangent)

    def foundation(self, facets: ArrayLike, k: ArrayLike) -> Csr:
        """Matrix int N^T D N dS of springs, or dashpots, between boundary facets and the ground.

        Args:
            facets: points of every facet, shape (num_facets, nodes per facet); its vertices suffice.
            k: one number, D = k n n^T with the normal n of the undeformed facet; or gdim numbers, D = diag(k)
                [F/L^3], of dashpots [F T/L^3].

        Returns:
            Matrix, shape (num_dofs, num_dofs) [F/L], of dashpots [F T/L].
        """
        return self._matrix(self._foundation(facets, k))

    def add_foundation(self, facets: ArrayLike, stiffness: ArrayLike, damping: ArrayLike = 0.0) -> None:
        """Let facets stand on springs and dashpots to the ground from now on, in all analyses of this model: `energy`,
        `internal_force` and `tangent` have the springs; `stiffness` and Rayleigh's damping do not.

        Args:
            facets: points of every facet, shape (num_facets, nodes per facet); its vertices suffice.
            stiffness: of the springs, as in `foundation` [F/L^3].
            damping: of the dashpots, as in `foundation` [F T/L^3].
        """
        self._model.add_foundation(self._foundation(facets, stiffness), self._foundation(facets, damping))

    def add_mass(self, facets: ArrayLike, mass: float) -> None:
        """Spread mass evenly over facets from now on, in `mass` and all analyses of this model.

        Args:
            facets: points of every facet, shape (num_facets, nodes per facet); its vertices suffice.
            mass: total [M].
        """
        per_area = mass / self.flux_load(facets, 1.0).sum()
        gdim = self.field_points.shape[1]
        self._model.add_mass(self._foundation(facets, np.full(gdim, per_area)))

    def _foundation(self, facets: ArrayLike, k: ArrayLike) -> _reference.Csr:
        return self._model.foundation(*self._rule("facet"), integers(facets, "facets", 2), vector(k))

    def gyroscopic(self, spin: ArrayLike, centre: ArrayLike) -> Csr:
        """Gyroscopic matrix G of a rotating frame, seed (3.56).

        Args:
            spin: angular velocity: one number in the plane, shape (3) in space [1/T].
            centre: point on the axis, shape (gdim) [L].

        Returns:
            G, shape (num_dofs, num_dofs) [M/T].
        """
        return self._matrix(self._model.gyroscopic(*self._rule("mass"), vector(spin), vector(centre)))

    def ale_inertia(self, spin: ArrayLike, centre: ArrayLike) -> Csr:
        """Inertia matrix W of a rotating frame, seed (3.57).

        Args:
            spin: angular velocity: one number in the plane, shape (3) in space [1/T].
            centre: point on the axis, shape (gdim) [L].

        Returns:
            W, shape (num_dofs, num_dofs) [M/T^2].
        """
        return self._matrix(self._model.ale_inertia(*self._rule("mass"), vector(spin), vector(centre)))

    def ale_load(self, spin: ArrayLike, centre: ArrayLike) -> FloatArray:
        """Load int rho A^T w dV of a rotating frame, seed (3.57).

        Args:
            spin: angular velocity: one number in the plane, shape (3) in space [1/T].
            centre: point on the axis, shape (gdim) [L].

        Returns:
            Load, shape (num_dofs) [F].
        """
        return self._model.ale_load(*self._rule("mass"), vector(spin), vector(centre))

    def poisson(self, k: float = 1.0) -> Csr:
        """Matrix int k grad N_i . grad N_j dV of a scalar field on the field nodes.

        Args:
            k: diffusivity [1].

        Returns:
            Matrix, shape (num_nodes, num_nodes) [L^(gdim - 2)].
        """
        return self._matrix(self._model.poisson(*self._rule("stiffness"), float(k)))

    def scalar_load(self, f: float) -> FloatArray:
        """Load int f N_i dV of a scalar field for a constant source.

        Args:
            f: source per volume [1].

        Returns:
            Load, shape (num_nodes) [L^gdim].
        """
        return self._model.scalar_load(*self._rule("load"), float(f))

    def flux_load(self, facets: ArrayLike, q: float) -> FloatArray:
        """Load int q N_i dS of a scalar field for a constant flux through facets.

        Args:
            facets: points of every facet, shape (num_facets, nodes per facet); its vertices suffice.
            q: flux per area [1].

        Returns:
            Load, shape (num_nodes) [L^(gdim - 1)].
        """
        return self._model.flux_load(*self._rule("facet"), integers(facets, "facets", 2), float(q))

    def rigid_modes(self) -> FloatArray:
        """Rigid body modes: translations, then rotations about the mean of the nodes.

        Returns:
            Modes as columns, shape (num_dofs, n) [1 or L]: n is 6 in space, 3 in the plane, 1 if axisymmetric.
        """
        return self._model.rigid_modes()

    def solve_static(
        self,
        fixed_dofs: ArrayLike,
        values: ArrayLike = 0.0,
        load: ArrayLike | None = None,
        steps: int = 1,
        tolerance: float = 1e-10,
        max_iterations: int = 25,
    ) -> StaticSolution:
        """Solve internal_force(u) = load with u[fixed_dofs] = values.

        Linear laws: one sparse L D L^T solution. Finite strain: Newton's method in load steps, which are halved where
        it fails.

        Args:
            fixed_dofs: prescribed degrees of freedom, shape (num_fixed).
            values: their displacements: one number, or shape (num_fixed) [L].
            load: external force, shape (num_dofs); None for zero [F].
            steps: number of load steps.
            tolerance: bound on the free residual, relative to |internal force| + |load| [1].
            max_iterations: bound on Newton's iterations per load step.

        Returns:
            Displacements, reactions and the record of the iterations.

        Raises:
            RuntimeError: a singular system (the message names the rigid body modes left free), or no convergence.
            ValueError: arguments that do not fit.
        """
        fixed = integers(fixed_dofs, "fixed_dofs", 1)
        values = np.broadcast_to(floats(values), fixed.shape).copy()
        load = np.zeros(self.num_dofs) if load is None else vector(load)
        points, weights = self._strain_rule()
        result = self._model.solve_static(points, weights, fixed, values, load, steps, tolerance, max_iterations)
        return StaticSolution(*result)

    def frequencies(
        self, n: int, fixed_dofs: ArrayLike = (), lumped: bool = False, scheme: str = "auto"
    ) -> tuple[FloatArray, FloatArray]:
        """Lowest natural frequencies and their modes by subspace iteration, Bathe ch. 11.6.

        Rigid body modes of free bodies come first, with frequency 0 up to round-off.

        Args:
            n: number of frequencies.
            fixed_dofs: degrees of freedom without displacement, shape (num_fixed).
            lumped: use the lumped mass.
            scheme: how the mass is lumped, as in `element_lumped_mass`.

        Returns:
            Angular frequencies in increasing order, shape (n) [1/T], and mass-orthonormal modes, shape (num_dofs, n).

        Raises:
            RuntimeError: the iteration does not converge.
        """
        fixed = integers(fixed_dofs, "fixed_dofs", 1)
        matrices = [self._model.stiffness(*self._rule("stiffness"))]
        diagonal = np.zeros(0)
        if lumped:
            diagonal = self._model.lumped_mass(*self._rule("mass"), scheme)
        else:
            matrices.append(self._model.mass(*self._rule("mass")))
        return self._model.frequencies(matrices, diagonal, n, fixed)
