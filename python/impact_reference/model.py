# SPDX-License-Identifier: MIT
"""Whole models: assembly, statics, natural frequencies."""

from dataclasses import dataclass

import numpy as np

from . import _reference, rules
from .sparse import Csr


@dataclass
class StaticSolution:
    """Result of `Model.solve_static`; unpacks as `u, reactions`."""

    u: np.ndarray  # displacements (num_dofs) [L]
    reactions: np.ndarray  # internal force minus load on fixed dofs, zero elsewhere (num_dofs) [F]
    iterations: list  # Newton iterations of every load step
    residuals: list  # relative residual at the end of every load step

    def __iter__(self):
        return iter((self.u, self.reactions))


def _floats(values):
    return np.ascontiguousarray(values, dtype=float)


def _vector(values):
    return np.atleast_1d(_floats(values)).reshape(-1)


def _integers(values, what, ndim):
    array = np.asarray(values)
    if array.size and not np.issubdtype(array.dtype, np.integer):
        raise TypeError(f"{what} must hold integers, found {array.dtype}")
    if array.ndim != ndim:
        raise ValueError(f"{what} must have {ndim} axes, found shape {array.shape}")
    return np.ascontiguousarray(array, dtype=np.int64)


class Model:
    """Body of hand-written elements, seed (3.17)-(3.30).

    points: (num_points, gdim) [L]; cells: (num_cells, nodes per cell of geometry_degree) in own node order (see
    `reference_nodes`). `degree` of the displacement field defaults to the geometry's. If they differ, the model numbers
    its own field nodes: `field_points` (num_nodes, gdim), `field_cells`. Degree of freedom = gdim * node + component.
    Several materials: cell_tags (num_cells) and materials={tag: Material}; `material` may then be None.
    `rule` is used for every integral over cells, `facet_rule` over facets; None takes the default of each purpose, and
    so do purposes that a dict {purpose: rule} leaves out ("stiffness", "finite_strain", "mass", "load").
    Raises ValueError for data out of range, connectivity that does not fit, unused points, inverted or empty cells.
    """

    def __init__(
        self,
        points,
        cells,
        cell_type,
        material=None,
        *,
        degree=None,
        geometry_degree=1,
        rule=None,
        facet_rule=None,
        cell_tags=None,
        materials=None,
    ):
        if (material is None) == (materials is None):
            raise ValueError("give either one material or materials={tag: Material}")
        if materials is not None and cell_tags is None:
            raise ValueError("materials={tag: Material} needs cell_tags, one tag per cell")
        points = _floats(points)
        if points.ndim != 2:
            raise ValueError(f"points must have shape (num_points, gdim), found {points.shape}")
        if materials is None:
            materials, tags = {0: material}, []
        else:
            tags = [int(tag) for tag in _integers(cell_tags, "cell_tags", 1)]
        materials = {int(tag): law for tag, law in materials.items()}
        self.degree = geometry_degree if degree is None else degree
        self.geometry_degree = geometry_degree
        self.cell_type = cell_type
        self.materials = materials
        self.rule = rule
        self.facet_rule = facet_rule
        self.axisymmetric = next(iter(materials.values())).hypothesis == "axisymmetric"
        self.linear = all(law.law == "linear_elastic" for law in materials.values())
        self._model = _reference.Model(
            points, _integers(cells, "cells", 2), cell_type, materials, tags, self.degree, geometry_degree
        )
        self.points = points
        self.cells = np.asarray(cells)
        self.field_points = self._model.field_points
        self.field_cells = self._model.field_cells
        self.num_dofs = self.field_points.size

    def _rule(self, purpose):
        facet = purpose == "facet"
        cell = rules.facet_type(self.cell_type) if facet else self.cell_type
        rule = self.facet_rule if facet else self.rule
        if isinstance(rule, dict):
            rule = rule.get(purpose)
        return rules.points_and_weights(cell, rule, purpose, self.degree, self.geometry_degree, self.axisymmetric)

    def _strain_rule(self):
        return self._rule("stiffness" if self.linear else "finite_strain")

    def _matrix(self, matrix):
        return Csr(*matrix.arrays)

    def stiffness(self):
        """K of linear elasticity, whatever the law, seed (3.26); Csr [F/L]."""
        return self._matrix(self._model.stiffness(*self._rule("stiffness")))

    def mass(self, lumped=False, scheme="auto"):
        """Consistent mass, Csr [M]; or with lumped=True the diagonal, shape (num_dofs) [M], see element_lumped_mass."""
        if lumped:
            return self._model.lumped_mass(*self._rule("mass"), scheme)
        return self._matrix(self._model.mass(*self._rule("mass")))

    def damping(self, alpha, beta):
        """Rayleigh damping alpha M + beta K of (3.67), alpha [1/T], beta [T]; Csr [F T/L]."""
        strain, mass = self._rule("stiffness"), self._rule("mass")
        return self._matrix(self._model.damping(*strain, *mass, float(alpha), float(beta)))

    def energy(self, u):
        """Strain energy of u (num_dofs) [L]; a float [F L]."""
        return self._model.energy(*self._strain_rule(), _vector(u))

    def internal_force(self, u):
        """Internal force of u (num_dofs) [L]; shape (num_dofs) [F]."""
        return self._model.internal_force(*self._strain_rule(), _vector(u))

    def tangent(self, u):
        """Derivative of the internal force at u (num_dofs) [L]; Csr [F/L]."""
        return self._matrix(self._model.tangent(*self._strain_rule(), _vector(u)))

    def stress(self, u, rule=None):
        """Stress (num_cells, num_points, num_strains) [F/L^2] and position (..., gdim) [L] at the points of a rule."""
        if rule is None:
            points, weights = self._rule("stiffness")
        else:
            points, weights = rules.points_and_weights(self.cell_type, rule, None, None, None, None)
        values, places = self._model.stress(points, weights, _vector(u))
        shape = (len(self.cells), len(weights), -1)
        return values.reshape(shape), places.reshape(shape)

    def body_force(self, f):
        """Load of a constant force per volume f (gdim) [F/L^3]; shape (num_dofs) [F]."""
        return self._model.body_force(*self._rule("load"), _vector(f))

    def traction(self, facets, t):
        """Load of a constant traction t (gdim) [F/L^2] on facets (m, nodes): geometry nodes, vertices suffice; [F]."""
        return self._model.traction(*self._rule("facet"), _integers(facets, "facets", 2), _vector(t))

    def follower_pressure(self, u, facets, p):
        """Force (num_dofs) [F] and df/du (Csr) [F/L] of a pressure p [F/L^2] pushing on deformed boundary facets."""
        facets = _integers(facets, "facets", 2)
        force, tangent = self._model.follower_pressure(*self._rule("facet"), facets, _vector(u), float(p))
        return force, self._matrix(tangent)

    def gyroscopic(self, spin, centre):
        """G of seed (3.56) for a frame rotating with spin [1/T] about centre (gdim) [L]; Csr [M/T]."""
        return self._matrix(self._model.gyroscopic(*self._rule("mass"), _vector(spin), _vector(centre)))

    def ale_inertia(self, spin, centre):
        """W of seed (3.57); Csr [M/T^2]."""
        return self._matrix(self._model.ale_inertia(*self._rule("mass"), _vector(spin), _vector(centre)))

    def ale_load(self, spin, centre):
        """int rho A^T w dV, seed (3.57); shape (num_dofs) [F]."""
        return self._model.ale_load(*self._rule("mass"), _vector(spin), _vector(centre))

    def poisson(self, k=1.0):
        """int k grad N_i . grad N_j dV for a scalar field on the field nodes; Csr."""
        return self._matrix(self._model.poisson(*self._rule("stiffness"), float(k)))

    def scalar_load(self, f):
        """int f N_i dV of the scalar field for a constant source f; shape (num_nodes)."""
        return self._model.scalar_load(*self._rule("load"), float(f))

    def flux_load(self, facets, q):
        """int q N_i dS of the scalar field for a constant flux q on facets (m, nodes); shape (num_nodes)."""
        return self._model.flux_load(*self._rule("facet"), _integers(facets, "facets", 2), float(q))

    def rigid_modes(self):
        """Rigid motions as columns, shape (num_dofs, 3 | 6 | 1): translations, then rotations about the mean node."""
        return self._model.rigid_modes()

    def solve_static(self, fixed_dofs, values=0.0, load=None, steps=1, tolerance=1e-10, max_iterations=25):
        """Solves internal_force(u) = load with u[fixed_dofs] = values; returns a StaticSolution.

        values: one number or one per fixed dof [L]; load (num_dofs) [F], None for zero. Linear laws: one sparse L D L^T
        solution. Finite strain: Newton's method in `steps` load steps (halved on failure) until the free residual is
        below `tolerance` times |internal force| + |load|. RuntimeError if singular (naming the rigid motions left free)
        or not convergent.
        """
        fixed = _integers(fixed_dofs, "fixed_dofs", 1)
        values = np.broadcast_to(_floats(values), fixed.shape).copy()
        load = np.zeros(self.num_dofs) if load is None else _vector(load)
        points, weights = self._strain_rule()
        result = self._model.solve_static(points, weights, fixed, values, load, steps, tolerance, max_iterations)
        return StaticSolution(*result)

    def frequencies(self, n, fixed_dofs=(), lumped=False, scheme="auto"):
        """Lowest n angular frequencies [1/T], increasing, and mass-orthonormal modes (num_dofs, n).

        Rigid modes of free bodies come first with frequency 0 up to rounding. Subspace iteration, Bathe ch. 11.6.
        RuntimeError if it does not converge.
        """
        fixed = _integers(fixed_dofs, "fixed_dofs", 1)
        matrices = [self._model.stiffness(*self._rule("stiffness"))]
        diagonal = np.zeros(0)
        if lumped:
            diagonal = self._model.lumped_mass(*self._rule("mass"), scheme)
        else:
            matrices.append(self._model.mass(*self._rule("mass")))
        return self._model.frequencies(matrices, diagonal, n, fixed)

    def run_explicit(self, dt, num_steps=None, **options):
        """Central differences by docs/explicit/scheme.md; returns an `explicit.ExplicitResult`.

        dt: a step [T] with num_steps, or an array of steps. Options, all by keyword:
        u0, v0 (num_dofs) [L], [L/T]: initial state, None for zero. fixed_dofs, values: prescribed dofs and their
        displacements [L]: a number, one per dof, a function of t, or a table (times, values per time), linear between
        its times; known one step beyond the end it gives the last state its velocity. loads [F]: a vector (num_dofs) or
        a list of vectors and pairs (vector, amplitude), amplitudes as `values` [1]. alpha [1/T], beta [T]: Rayleigh
        damping, with the lumped mass. scheme: "half_step" or "classical" (equal steps, beta 0). viscosity: (b1, b2) [1]
        or None. contacts: NodalPenalty and NodalKinematic. lumping: scheme of the mass. every: keep each state of that
        number; the last is always kept. ValueError for data that do not fit, RuntimeError if the run overflows.
        """
        from . import explicit

        return explicit.run_explicit(self, dt, num_steps, **options)

    def stable_step(self, method="element", **options):
        """Longest stable step [T] at rest: "length" (edge over wave speed), "element" (a bound) or "eigenvalue".

        Options: alpha [1/T], beta [T] and scheme as in run_explicit; fixed_dofs, which "eigenvalue" holds; contacts at
        u (num_dofs) [L], of which those with a penalty of their own shorten the step; lumping.
        """
        from . import explicit

        return explicit.stable_step(self, method, **options)
