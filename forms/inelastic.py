# SPDX-License-Identifier: MIT
"""Bodies with internal variables in UFL: which strain a law sees, and the virtual work of its stress.

A law with internal variables is an object with the members of `PointResponse`. It gets the strain of a point, the
history that was committed there and the unknowns of its local equations, and returns an `Update`. The strain is

- small: eps = sym grad u, 3 x 3, with zero rows across the plane in two dimensions (eps_rr, eps_zz, hoop strain last in
  axisymmetric bodies);
- finite: the deformation gradient F = I + grad u, 3 x 3.

Linear quadrilaterals and hexahedra lock where plastic flow keeps the volume, because every point of a cell asks for it.
With `average` a law sees the mean dilatation of the cell instead: B-bar (Hughes 1980), eps - tr(eps)/3 I + theta/3 I
with theta the mean of tr(eps), and F-bar, (theta/J)^(1/3) F with theta the mean of J = det F. The virtual strain is the
derivative of the same expression, so that the internal forces are those of a potential where the law has one.
"""

from dataclasses import dataclass, field
from typing import Any, Protocol

import ufl

from .materials import gradient, weight


@dataclass
class Update:
    """What a law computes at a point from strain, committed history and unknowns.

    Attributes:
        stress: Cauchy stress (small strain) or first Piola-Kirchhoff stress (finite strain), 3 x 3 [F/L^2].
        outputs: new history by name, each a UFL expression of the shape of that history.
        stored: elastic energy per volume; what is left of the work of the stress is dissipated [F L/L^3].
        residual: residual of the local equations, of the shape of the unknown; None without unknowns.
        start: where Newton's method begins, of the shape of the unknown; None without unknowns.
        scale: size of the terms of the residual.
        mean: mean stress tr(stress)/3 of small strain, where the law has it in terms of `trace` of the strain alone. It
            makes kernels of averaged cells cheaper, and no result different; None: it is taken from `stress`.
    """

    stress: Any
    outputs: dict[str, Any]
    stored: Any
    residual: Any = None
    start: Any = None
    scale: Any = field(default=1.0)
    mean: Any = None


def trace(strain: Any) -> Any:
    """Trace of a strain; of an averaged one the mean dilatation itself, without the terms that cancel in it."""
    if isinstance(strain, ufl.classes.Sum):
        return sum(trace(term) for term in strain.ufl_operands)
    return ufl.zero() if isinstance(strain, ufl.classes.Deviatoric) else ufl.tr(strain)


def deviator(strain: Any) -> Any:
    """Deviator of a strain; of an averaged one that of the displacement gradient, in which no mean occurs."""
    if isinstance(strain, ufl.classes.Sum):
        return sum(deviator(term) for term in strain.ufl_operands)
    whole = strain.ufl_operands[0] if isinstance(strain, ufl.classes.Deviatoric) else strain
    # As ufl.dev, but with the trace as a term of its own, which kernels compute once.
    return whole - ufl.tr(whole) / 3 * ufl.Identity(3)


def same_in_cell(expression: Any) -> bool:
    """Is an expression made of constants and averages alone, so that all points of a cell have the same value?"""
    if isinstance(expression, (ufl.classes.CellAvg, ufl.classes.Constant, ufl.classes.ConstantValue)):
        return True
    if isinstance(expression, ufl.classes.MultiIndex):
        return True
    return bool(expression.ufl_operands) and all(same_in_cell(o) for o in expression.ufl_operands)


class PointResponse(Protocol):
    """What a body asks of a law with internal variables.

    Attributes:
        history: shape of every internal variable by name; all are zero in the virgin state.
        unknown: shape of the unknown of the local equations, () or (n,); None for a law in closed form.
    """

    history: dict[str, tuple[int, ...]]
    unknown: tuple[int, ...] | None

    def respond(self, strain: Any, history: dict[str, Any], unknown: Any) -> Update:
        """Stress and new history at a point.

        Args:
            strain: small strain or deformation gradient, 3 x 3 [1].
            history: committed values by the names of `history`.
            unknown: unknown of the local equations; None for a law in closed form.
        """
        ...


class Kinematics:
    """Strains of a displacement under a hypothesis of forms/materials.py.

    Args:
        hypothesis: one of materials.HYPOTHESES.
        finite_strain: whether the law sees the deformation gradient instead of the small strain.
        average: whether the dilatation is averaged over each cell. Plane stress has no constraint on the dilatation, so
            that nothing locks: there it is not averaged.
    """

    def __init__(self, hypothesis: str, finite_strain: bool = False, average: bool = False) -> None:
        self.hypothesis, self.finite_strain = hypothesis, finite_strain
        self.average = average and hypothesis != "plane_stress"

    def gradient(self, u: Any) -> Any:
        """Displacement gradient, 3 x 3; in plane stress with zeros across the plane."""
        g = gradient(u, self.hypothesis)
        if self.hypothesis != "plane_stress":
            return g
        return ufl.as_tensor([[g[0, 0], g[0, 1], 0], [g[1, 0], g[1, 1], 0], [0, 0, 0]])

    def _mean(self, e: Any) -> Any:
        """Mean of a scalar over the volume of a cell."""
        if self.hypothesis != "axisymmetric":
            return ufl.cell_avg(e)
        r = ufl.SpatialCoordinate(ufl.domain.extract_unique_domain(e))[0]
        return ufl.cell_avg(r * e) / ufl.cell_avg(r)

    def dilatation(self, u: Any) -> Any:
        """What is averaged: tr(eps), or J."""
        g = self.gradient(u)
        return ufl.det(ufl.Identity(3) + g) if self.finite_strain else ufl.tr(g)

    def dilatation_derivative(self, u: Any, v: Any) -> Any:
        """Derivative of `dilatation` in the direction v."""
        if not self.finite_strain:
            return ufl.tr(self.gradient(v))
        F = ufl.Identity(3) + self.gradient(u)
        return ufl.det(F) * ufl.inner(ufl.inv(F).T, self.gradient(v))

    def strain(self, u: Any, theta: Any = None) -> Any:
        """Strain that the law sees.

        Args:
            u: displacement [L].
            theta: mean dilatation of the cell, where it is given as a field of its own; None: it follows from u.
        """
        g = self.gradient(u)
        if self.average and theta is None:
            theta = self._mean(self.dilatation(u))
        if not self.finite_strain:
            return ufl.dev(ufl.sym(g)) + theta / 3 * ufl.Identity(3) if self.average else ufl.sym(g)
        F = ufl.Identity(3) + g
        return (theta / ufl.det(F)) ** (1 / 3) * F if self.average else F

    def virtual_strain(self, u: Any, v: Any, theta: Any = None, theta_v: Any = None) -> Any:
        """Derivative of `strain` in the direction v.

        Args:
            u: displacement [L].
            v: virtual displacement [L].
            theta: as in `strain`.
            theta_v: its derivative; None: it follows from u and v.
        """
        g = self.gradient(v)
        if self.average and theta is None:
            theta = self._mean(self.dilatation(u))
            theta_v = self._mean(self.dilatation_derivative(u, v))
        if not self.finite_strain:
            return ufl.dev(ufl.sym(g)) + theta_v / 3 * ufl.Identity(3) if self.average else ufl.sym(g)
        if not self.average:
            return g
        F = ufl.Identity(3) + self.gradient(u)
        local = ufl.inner(ufl.inv(F).T, g)
        return (theta / ufl.det(F)) ** (1 / 3) * (g + (theta_v / theta - local) / 3 * F)

    def mean_derivative(self, u: Any, theta: Any, theta_v: Any) -> Any:
        """Derivative of `strain` by the mean dilatation, in the direction theta_v."""
        if not self.finite_strain:
            return theta_v / 3 * ufl.Identity(3)
        F = ufl.Identity(3) + self.gradient(u)
        return (theta / ufl.det(F)) ** (1 / 3) * theta_v / (3 * theta) * F


def internal_force(u: Any, v: Any, kinematics: Kinematics, update: Update, dx: Any) -> Any:
    """Internal virtual work, integral of stress : virtual strain."""
    mesh = ufl.domain.extract_unique_domain(u)
    virtual = kinematics.virtual_strain(u, v)
    if kinematics.average and not kinematics.finite_strain and update.mean is not None and same_in_cell(update.mean):
        # The work of a mean stress that does not vary in the cell is the same with and without the average.
        virtual = ufl.sym(kinematics.gradient(v))
    return ufl.inner(update.stress, virtual) * weight(mesh, kinematics.hypothesis) * dx


def elastic_tangent(u: Any, du: Any, v: Any, lmbda: Any, mu: Any, kinematics: Kinematics, dx: Any) -> Any:
    """Stiffness of the elastic solid in the deformed shape, an upper bound of that of the inelastic one.

    In finite strain the gradients are those with respect to the deformed position, and the volume is the deformed one:
    cells that have been flattened by plastic flow have higher frequencies.
    """
    mesh = ufl.domain.extract_unique_domain(v)
    a, b, volume = kinematics.gradient(du), kinematics.gradient(v), 1
    if kinematics.finite_strain:
        F = ufl.Identity(3) + kinematics.gradient(u)
        inverse = ufl.inv(F)
        a, b, volume = a * inverse, b * inverse, ufl.det(F)
    a, b = ufl.sym(a), ufl.sym(b)
    if kinematics.hypothesis == "plane_stress":
        lmbda = 2 * lmbda * mu / (lmbda + 2 * mu)
    work = lmbda * ufl.tr(a) * ufl.tr(b) + 2 * mu * ufl.inner(a, b)
    return work * volume * weight(mesh, kinematics.hypothesis) * dx
