# SPDX-License-Identifier: MIT
"""Consistent tangent of bodies with internal variables.

The kernels of the internal force solve the local equations r(x; strain, history) = 0 and keep x. Here x and the history
are coefficients, and the implicit function theorem gives the derivative of x by the displacement:

    K = dF/du + dF/dx dx/du,    dx/du = -(dr/dx)^-1 dr/du.

Where the dilatation is averaged, the mean dilatation theta of a cell is a field of its own, constant in each cell (or
linear, see projected_dilatation.py), and is then eliminated: with theta = D u linearised,

    K = F_u + F_theta D + D' (G_u + G_theta D),

where F and G are the parts of the virtual work that go with v and with the virtual mean dilatation. In finite strain
the second derivative of theta is a term of its own. D is diag(1/V) B with the cells' volumes V.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import dolfinx.fem.petsc as petsc
import ufl
from dolfinx import fem
from dolfinx.fem import Function
from petsc4py import PETSc
from ufl.algorithms import expand_derivatives

from .ffcx_form import ffcx_form
from ..common.described import Described
from ..forms.cell_maximum import has_maximum
from ..forms.materials import weight
from .inelastic_part import HistoryFunctions, InelasticPart
from .projected_dilatation import ProjectedDilatation

LARGEST_INVERSE = 3  # UFL has closed forms of the inverse up to this size


def solve(A: Any, b: Sequence[Any]) -> list[Any]:
    """Solution of a small linear system of UFL expressions.

    Args:
        A: matrix, (n, n); for n > 3 its leading minors must not be zero, there are no row exchanges.
        b: right-hand side, (n).
    """
    n = len(b)
    if n <= LARGEST_INVERSE:
        inverse = ufl.inv(A)
        return [sum(inverse[i, j] * b[j] for j in range(n)) for i in range(n)]
    rows, right = [[A[i, j] for j in range(n)] for i in range(n)], list(b)
    for k in range(n):
        for i in range(k + 1, n):
            factor = rows[i][k] / rows[k][k]
            rows[i] = [rows[i][j] - factor * rows[k][j] if j > k else 0 for j in range(n)]
            right[i] = right[i] - factor * right[k]
    x: list[Any] = [0] * n
    for i in reversed(range(n)):
        x[i] = (right[i] - sum(rows[i][j] * x[j] for j in range(i + 1, n))) / rows[i][i]
    return x


def unknown_derivative(residual: Any, x: Function, u: Function, du: Any) -> Any:
    """Derivative of the local unknowns by the displacement, in the direction du.

    Args:
        residual: residual of the local equations, a UFL expression of x and u.
        x: local unknowns.
        u: displacement [L].
        du: trial function.
    """
    variable = ufl.variable(x)
    matrix = expand_derivatives(ufl.diff(ufl.replace(residual, {x: variable}), variable))
    change = expand_derivatives(ufl.derivative(residual, u, du))
    if not x.ufl_shape:
        return -change / matrix
    return -ufl.as_vector(solve(matrix, [change[i] for i in range(x.ufl_shape[0])]))


class _PartForms:
    """UFL forms of one part; `dilatation` has the values of the function theta, None: there is none."""

    def __init__(
        self,
        part: InelasticPart,
        functions: HistoryFunctions,
        dilatation: ProjectedDilatation | None,
        theta: Function | None,
    ) -> None:
        self.part, self.functions, self.dilatation, self.theta = part, functions, dilatation, theta
        mesh, kinematics = part.mesh, part.kinematics
        self.weight = weight(mesh, kinematics.hypothesis)
        self.mean = self.value(theta) if kinematics.average else None
        strain = kinematics.strain(part.u, self.mean)
        self.update = part.response.respond(strain, dict(functions.history), functions.unknown)
        if any(has_maximum(e) for e in (self.update.stress, self.update.residual) if e is not None):
            raise ValueError(
                "the stress of a law has a maximum over a cell, which has no derivative: static problems need one. "
                "Take ufl.cell_avg, or use the maximum of the committed history, or an ExplicitProblem"
            )

    def value(self, coefficients: Any) -> Any:
        """Projected dilatation of these coefficients."""
        assert self.dilatation is not None
        return self.dilatation.value(self.part, coefficients)

    def force(self, v: Any) -> Any:
        """Virtual work that goes with the virtual displacement v, at a fixed mean dilatation."""
        part, theta = self.part, self.mean
        virtual = part.kinematics.virtual_strain(part.u, v, theta, ufl.as_ufl(0) if theta is not None else None)
        return ufl.inner(self.update.stress, virtual) * self.weight * part.dx

    def mean_force(self, q: Any) -> Any:
        """Virtual work that goes with the virtual mean dilatation q."""
        virtual = self.part.kinematics.mean_derivative(self.part.u, self.mean, self.value(q))
        return ufl.inner(self.update.stress, virtual) * self.weight * self.part.dx

    def by_displacement(self, form: Any, du: Any) -> Any:
        """Derivative of a form by the displacement, the local unknowns following it."""
        u, x = self.part.u, self.functions.unknown
        derivative = ufl.derivative(form, u, du)
        if x is None:
            return derivative
        return derivative + ufl.derivative(form, x, unknown_derivative(self.update.residual, x, u, du))

    def by_mean(self, form: Any, p: Any) -> Any:
        """Derivative of a form by the mean dilatation, the local unknowns following it."""
        x = self.functions.unknown
        derivative = ufl.derivative(form, self.theta, p)
        if x is None:
            return derivative
        assert self.theta is not None  # of cells that are averaged
        return derivative + ufl.derivative(form, x, unknown_derivative(self.update.residual, x, self.theta, p))


class InelasticTangent(Described):
    """Derivative of the internal forces of a body with inelastic parts, less that of loads that follow it.

    Args:
        u: displacement function [L].
        parts: inelastic parts.
        functions: history and unknowns of the parts, in the state at which the tangent is wanted.
        other: UFL form of rank 2 of the rest: elastic parts, loads; None: there is none.

    Attributes:
        matrix: the matrix [F/L]; every call of `assemble` overwrites it.
    """

    def __init__(
        self, u: Function, parts: Sequence[InelasticPart], functions: Sequence[HistoryFunctions], other: Any = None
    ) -> None:
        V = u.function_space
        self.u, self.mesh = u, V.mesh
        v, du = ufl.TestFunction(V), ufl.TrialFunction(V)
        self.averaged = any(part.kinematics.average for part in parts)
        averaged = [part for part in parts if part.kinematics.average]
        projected = ProjectedDilatation(averaged) if averaged else None
        Q = None if projected is None else projected.space
        self.theta = None if Q is None else Function(Q, name="mean_dilatation")
        self.lift = None if Q is None else Function(Q, name="mean_stress")
        forms = [_PartForms(part, f, projected, self.theta) for part, f in zip(parts, functions)]
        form = sum(p.by_displacement(p.force(v), du) for p in forms)
        if other is not None:
            form = form + other
        means = [p for p in forms if p.part.kinematics.average]
        if projected is not None:
            self._volumes = projected.volumes
            q, p = ufl.TestFunction(Q), ufl.TrialFunction(Q)
            self._define_means(means, v, du, q, p)
            form = form + self._second_derivative(means, v, du)
        self.form = ffcx_form(form)
        self.matrix = petsc.create_matrix(self.form)

    def _define_means(self, means: Sequence[_PartForms], v: Any, du: Any, q: Any, p: Any) -> None:
        """Forms of the mean dilatation: test and trial functions q and p are coefficients in each cell."""

        def total(term: Any) -> Any:
            return ffcx_form(sum(term(part) for part in means))

        def change(m: _PartForms) -> Any:
            return m.part.kinematics.dilatation_derivative(m.part.u, du)

        self._dilatation = total(lambda m: m.weight * m.part.kinematics.dilatation(m.part.u) * m.value(q) * m.part.dx)
        self._B = total(lambda m: m.weight * change(m) * m.value(q) * m.part.dx)
        self._stress = total(lambda m: m.mean_force(q))
        self._F_theta = total(lambda m: m.by_mean(m.force(v), p))
        self._G_u = total(lambda m: m.by_displacement(m.mean_force(q), du))
        self._G_theta = total(lambda m: m.by_mean(m.mean_force(q), p))
        self._rectangular = petsc.create_matrix(self._B)
        self._columns, self._rows = petsc.create_matrix(self._F_theta), petsc.create_matrix(self._G_u)
        self._diagonal = petsc.create_matrix(self._G_theta)

    def _second_derivative(self, means: Sequence[_PartForms], v: Any, du: Any) -> Any:
        """Virtual work of the second derivative of the mean dilatation, which is zero in small strain."""
        finite = [m for m in means if m.part.kinematics.finite_strain]
        zero = ufl.as_ufl(0)
        return sum(
            (
                ufl.derivative(
                    m.value(self.lift) * m.weight * m.part.kinematics.dilatation_derivative(m.part.u, v) * m.part.dx,
                    m.part.u, du,
                )
                for m in finite
            ),
            zero,
        ) if finite else zero * ufl.inner(du, v) * means[0].part.dx  # fmt: skip

    def _update_means(self) -> None:
        """Mean dilatation and the stress that goes with it, at the present displacement. Collective."""
        assert self.theta is not None and self.lift is not None
        for form, f in ((self._dilatation, self.theta), (self._stress, self.lift)):
            values = fem.assemble_vector(form)
            f.x.array[:] = values.array / self._volumes
            f.x.scatter_forward()

    def assemble(self) -> PETSc.Mat:
        """Assemble the tangent at the present displacement, history and unknowns. Collective.

        Returns:
            The matrix of this object; the next call overwrites it.
        """
        if self.averaged:
            self._update_means()
        self._fill(self.matrix, self.form)
        if self.averaged:
            B, F, G, diagonal = self._rectangular, self._columns, self._rows, self._diagonal
            for matrix, form in ((B, self._B), (F, self._F_theta), (G, self._G_u), (diagonal, self._G_theta)):
                self._fill(matrix, form)
            inverse = B.createVecLeft()
            inverse.array[:] = 1.0 / self._volumes[: len(inverse.array)]
            B.diagonalScale(L=inverse)
            inner = diagonal.matMult(B)
            inner.axpy(1.0, G, structure=PETSc.Mat.Structure.SAME_NONZERO_PATTERN)
            products = [F.matMult(B), B.transposeMatMult(inner)]
            for product in products:
                self.matrix.axpy(1.0, product, structure=PETSc.Mat.Structure.SUBSET_NONZERO_PATTERN)
            for thing in (inverse, inner, *products):
                thing.destroy()
        return self.matrix

    @staticmethod
    def _fill(matrix: PETSc.Mat, form: fem.Form) -> None:
        matrix.zeroEntries()
        petsc.assemble_matrix(matrix, form)  # type: ignore[arg-type]  # annotated for the overload with `bcs`
        matrix.assemble()
