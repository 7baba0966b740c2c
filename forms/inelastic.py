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

On quadrilaterals and hexahedra of degree 2 the mean would be too coarse. There theta is the L2 projection on the linear
functions of each cell, as in the mixed element of displacements of degree 2 and discontinuous linear pressures (Boffi,
Brezzi, Fortin 2013, chapter 8).
"""

from dataclasses import dataclass, field
from typing import Any, Protocol

import basix.ufl
import ufl

from . import elasticity
from .materials import Law, gradient, weight
from .point_law import PointLaw
from .reference_derivatives import reference_derivatives

UNKNOWN = "local_unknown"  # output of the kernels: solution of the local equations
ELASTIC_ENERGY = "elastic"  # sum of the kernels; cpp/dolfinx_impact/integrators reads it by this name


@dataclass(frozen=True)
class Kirchhoff:
    """What a first Piola-Kirchhoff stress tau F^-T is made of: kernels add to the mean stress before they multiply.

    Attributes:
        piola: that stress, 3 x 3 [F/L^2].
        rest: tau less its mean stress, 3 x 3 [F/L^2].
        inverse: inverse of F, 3 x 3 [1].
    """

    piola: Any
    rest: Any
    inverse: Any


@dataclass(frozen=True)
class Flow:
    """Plastic flow of a law in a step: what hourglass modes of cells with one point give way by (one_point_flow.py).

    Attributes:
        stress: von Mises' equivalent of the stress at which the law flows, positive; it may be that at the beginning of
            the step [F/L^2].
        increment: increment of the equivalent plastic strain in the step, zero where it is elastic [1].
        slope: derivative of the flow stress by the equivalent plastic strain, negative where it falls; kinematic
            hardening counts [F/L^2].
        direction: direction of the flow in space, deviatoric, of the equivalent 1: 3/2 s/q(s), 3 x 3; None: along the
            deviator of the stress [1].
        left: share of the trial stress's deviator that a radial return leaves, 1 where the step is elastic; None:
            stress/(stress + 3 mu increment) [1].
        yields: UFL condition whether the step is plastic; None: it is not known. Where it is that of a conditional in
            the stress, kernels skip what only flow needs.
    """

    stress: Any
    increment: Any
    slope: Any = 0
    direction: Any = None
    left: Any = None
    yields: Any = None


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
        start_error: bound of the distance of `start` from the solution, or None (forms/point_law.py: PointLaw).
        mean: mean stress tr(stress)/3 of small strain, where the law has it in terms of `trace` of the strain alone; in
            finite strain that of the Kirchhoff stress in terms of the dilatation of `gradient_and_dilatation`. It makes
            kernels of averaged cells cheaper, and no result different; None: it is taken from `stress`.
        piola: Kirchhoff stress times the inverse transpose of the F of `gradient_and_dilatation`, 3 x 3; in finite
            strain it goes with `mean` [F/L^2].
        strain: deformation gradient of finite strain where the law finds a part of it, as the stretch across the plane
            in plane stress, 3 x 3; None: the one that it was given [1].
        kirchhoff: what `piola` is made of, or None. It does not count where it is of another `piola`.
        flow: what cells with one point ask for (integration="reduced"); None: the law is not for them.
    """

    stress: Any
    outputs: dict[str, Any]
    stored: Any
    residual: Any = None
    start: Any = None
    scale: Any = field(default=1.0)
    mean: Any = None
    piola: Any = None
    strain: Any = None
    kirchhoff: Kirchhoff | None = None
    start_error: Any = None
    flow: Flow | None = None


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


def gradient_and_dilatation(strain: Any) -> tuple[Any, Any]:
    """Deformation gradient F of which a strain of finite strain is a multiple, and the determinant of the strain.

    Of an averaged strain, (theta/J)^(1/3) F, they are F itself and theta, without the root. What does not depend on a
    change of volume, as det(F)^(-1/3) F, is the same of both.
    """
    return _factors(strain)[:2]


def gradient_determinant(strain: Any) -> Any:
    """Determinant of the first of `gradient_and_dilatation`."""
    return _factors(strain)[2]


def _factors(strain: Any) -> tuple[Any, Any, Any]:
    """What `gradient_and_dilatation` and `gradient_determinant` find."""
    if isinstance(strain, ufl.classes.ComponentTensor) and isinstance(strain.ufl_operands[0], ufl.classes.Product):
        entry, root = sorted(strain.ufl_operands[0].ufl_operands, key=lambda o: isinstance(o, ufl.classes.Power))
        F = _tensor_of(entry, strain.ufl_operands[1])
        if isinstance(root, ufl.classes.Power) and F is not None:
            ratio = root.ufl_operands[0]
            if isinstance(ratio, ufl.classes.Division):
                return (F, *ratio.ufl_operands)
    return strain, ufl.det(strain), ufl.det(strain)


def cofactor(F: Any) -> Any:
    """Cofactors of a 3 x 3 tensor, det(F) F^-T."""

    def minor(i: int, j: int) -> Any:
        a, b, c, d = (i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3
        return F[a, c] * F[b, d] - F[a, d] * F[b, c]

    return ufl.as_tensor([[minor(i, j) for j in range(3)] for i in range(3)])


def _tensor_of(entry: Any, index: Any) -> Any:
    """Tensor that an expression is the entry of; None if it is none. UFL writes entries of sums as sums of entries from
    2025 on."""
    if isinstance(entry, ufl.classes.Indexed) and entry.ufl_operands[1] == index:
        return entry.ufl_operands[0]
    if isinstance(entry, ufl.classes.Sum):
        terms = [_tensor_of(o, index) for o in entry.ufl_operands]
        return None if any(term is None for term in terms) else sum(terms[1:], terms[0])
    return None


def same_in_cell(expression: Any) -> bool:
    """Is an expression made of constants and averages alone, so that all points of a cell have the same value?"""
    if isinstance(expression, (ufl.classes.CellAvg, ufl.classes.Constant, ufl.classes.ConstantValue)):
        return True
    if isinstance(expression, ufl.classes.MultiIndex):
        return True
    return bool(expression.ufl_operands) and all(same_in_cell(o) for o in expression.ufl_operands)


def in_span(expression: Any, theta: Any) -> bool:
    """Is an expression a sum of multiples of theta and of 1, whose factors are the same at all points of a cell?"""
    if same_in_cell(expression) or expression == theta:
        return True
    operands = expression.ufl_operands
    if isinstance(expression, ufl.classes.Sum):
        return all(in_span(o, theta) for o in operands)
    if isinstance(expression, ufl.classes.Product):
        a, b = operands
        return (same_in_cell(a) and in_span(b, theta)) or (same_in_cell(b) and in_span(a, theta))
    if isinstance(expression, ufl.classes.Division):
        return in_span(operands[0], theta) and same_in_cell(operands[1])
    if isinstance(expression, (ufl.classes.Trace, ufl.classes.ComponentTensor, ufl.classes.Indexed)):
        return in_span(operands[0], theta)
    return False


def default_average(cell: str, degree: int) -> bool | str:
    """Projection of the dilatation of an inelastic body unless told otherwise: `average` of Kinematics.

    Args:
        cell: name of the cell.
        degree: degree of the displacement [1].
    """
    if cell not in ("quadrilateral", "hexahedron"):
        return False
    return {1: True, 2: "linear"}.get(degree, False)


class PointResponse(Protocol):
    """What a body asks of a law with internal variables.

    Attributes:
        history: shape of every internal variable by name; all are zero in the virgin state.
        unknown: shape of the unknown of the local equations, () or (n,); None for a law in closed form.
    """

    history: dict[str, tuple[int, ...]]
    unknown: tuple[int, ...] | None

    def respond(self, strain: Any, history: dict[str, Any], unknown: Any) -> Update:
        """See dolfinx_impact.InelasticMaterial.respond, which users write."""
        ...


class Kinematics:
    """Strains of a displacement under a hypothesis of forms/materials.py.

    Args:
        hypothesis: one of materials.HYPOTHESES.
        finite_strain: whether the law sees the deformation gradient instead of the small strain.
        average: whether the dilatation is averaged over each cell; "linear": projected on the linear functions of each
            cell. Plane stress has no constraint on the dilatation, so that nothing locks: there it is left alone.

    Attributes:
        average: whether the law sees a projection of the dilatation.
        linear: whether it is that on linear functions.
    """

    def __init__(self, hypothesis: str, finite_strain: bool = False, average: bool | str = False) -> None:
        self.hypothesis, self.finite_strain = hypothesis, finite_strain
        self.average = bool(average) and hypothesis != "plane_stress"
        self.linear = self.average and average == "linear"

    def gradient(self, u: Any) -> Any:
        """Displacement gradient, 3 x 3; in plane stress with zeros across the plane."""
        g = gradient(u, self.hypothesis)
        if self.hypothesis != "plane_stress":
            return g
        return ufl.as_tensor([[g[0, 0], g[0, 1], 0], [g[1, 0], g[1, 1], 0], [0, 0, 0]])

    def _mean(self, e: Any) -> Any:
        """Mean over the volume of a cell."""
        if self.hypothesis != "axisymmetric":
            return ufl.cell_avg(e)
        r = ufl.SpatialCoordinate(ufl.domain.extract_unique_domain(e))[0]
        return ufl.cell_avg(r * e) / ufl.cell_avg(r)

    def _projected(self, e: Any) -> Any:
        """Mean of a scalar over a cell, or its L2 projection on the linear functions of the cell, which are orthogonal
        to the mean when their origin is the centre."""
        if not self.linear:
            return self._mean(e)
        x = ufl.SpatialCoordinate(ufl.domain.extract_unique_domain(e))
        y = x - self._mean(x)
        slope = ufl.inv(self._mean(ufl.outer(y, y))) * self._mean(e * y)
        return self._mean(e) + ufl.dot(y, slope)

    def projection(self, u: Any) -> Any:
        """What the law sees of `dilatation`."""
        return self._projected(self.dilatation(u))

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
            theta: projected dilatation, where it is given as a field of its own; None: it follows from u.
        """
        g = self.gradient(u)
        if self.average and theta is None:
            theta = self.projection(u)
        if not self.finite_strain:
            return ufl.dev(ufl.sym(g)) + theta / 3 * ufl.Identity(3) if self.average else ufl.sym(g)
        F = ufl.Identity(3) + g
        return (theta / ufl.det(F)) ** (1 / 3) * F if self.average else F

    def respond(self, response: "PointResponse", u: Any, symbols: "Symbols") -> Update:
        """What a law computes of a displacement.

        Args:
            response: the law.
            u: displacement [L].
            symbols: its history and unknowns.
        """
        return response.respond(self.strain(u), dict(symbols.history), symbols.unknown)

    def virtual_work(self, u: Any, v: Any, update: Update) -> Any:
        """Virtual work per volume of the reference cell's measure, of kinematics that have an expression of their own;
        None: it is that of the stress and `virtual_strain`."""
        return None

    def elastic_tangent(self, u: Any, du: Any, v: Any) -> Any:
        """As `virtual_work`, of the elastic solid's stiffness; None: it is that of `elastic_work`."""
        return None

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
            theta = self.projection(u)
            theta_v = self._projected(self.dilatation_derivative(u, v))
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


class DeformedCell(Kinematics):
    """Averaged cells in space, by the derivatives of positions with respect to the reference coordinates.

    With j = d(x + u)/dxi and X = dx/dxi, F = j X^-1. A law that depends on det(F)^(-1/3) F and the mean dilatation gets
    j cof(X)^T, which is det(X) F, in the place of F, and its virtual work is that of the Kirchhoff stress with
    gradients by the deformed position, grad v = dv/dxi cof(j)^T/det(j): half of the products that F, F^-T and gradients
    by the position need, and no division by det(X). Results are the same but for round-off. UFL does not differentiate
    it by the displacement: consistent tangents are made of Kinematics.

    Args:
        mesh: UFL mesh.
    """

    def __init__(self, mesh: Any) -> None:
        super().__init__("3d", True, True)
        self.X, self.volume = ufl.Jacobian(mesh), ufl.JacobianDeterminant(mesh)

    @staticmethod
    def serves(response: PointResponse, kinematics: Kinematics) -> bool:
        """May it stand for the kinematics of a law? Attribute `scale_free` of a law says what it depends on."""
        plain = type(kinematics) is Kinematics and kinematics.hypothesis == "3d" and kinematics.finite_strain
        return plain and kinematics.average and not kinematics.linear and getattr(response, "scale_free", False)

    def _deformed(self, u: Any) -> tuple[Any, Any, Any]:
        """j, its cofactors and its determinant."""
        j = self.X + reference_derivatives(u, 1)
        cofactors = cofactor(j)
        return j, cofactors, sum(j[0, k] * cofactors[0, k] for k in range(3))

    def dilatation(self, u: Any) -> Any:
        return self._deformed(u)[2] / self.volume

    def strain(self, u: Any, theta: Any = None) -> Any:
        j, _, determinant = self._deformed(u)
        G = j * cofactor(self.X).T
        return (self.projection(u) / (determinant * self.volume**2)) ** (1 / 3) * G

    def takes(self, update: Update, u: Any) -> bool:
        """Has an update the mean stress and the Kirchhoff stress that `work` is made of?"""
        parts = update.kirchhoff
        known = update.mean is not None and parts is not None and parts.piola is update.piola
        return known and same_in_cell(update.mean / self.projection(u))

    def work(self, u: Any, v: Any, update: Update) -> Any:
        """Virtual work per volume of a law whose update it `takes`.

        Args:
            u: displacement [L].
            v: test function.
            update: what the law computes.
        """
        assert update.kirchhoff is not None
        _, cofactors, determinant = self._deformed(u)
        # 1/det(j) by the root that the law has, and 1/|det X| as a factor of all, which the measure cancels.
        root = (determinant * self.volume**2) ** (-1 / 3)
        size = abs(self.volume)
        side = ufl.conditional(ufl.gt(self.volume, 0), 1, -1)
        mean = side * update.mean / self.projection(u)
        stress = root**3 * self.volume**2 * size * update.kirchhoff.rest + mean * ufl.Identity(3)
        return ufl.inner(stress * cofactors, reference_derivatives(v, 1)) / size


def internal_force(u: Any, v: Any, kinematics: Kinematics, update: Update, dx: Any) -> Any:
    """Internal virtual work, integral of stress : virtual strain."""
    own = kinematics.virtual_work(u, v, update)
    if own is not None:
        return own * dx
    mesh = ufl.domain.extract_unique_domain(u)
    virtual = kinematics.virtual_strain(u, v)
    small = kinematics.average and not kinematics.finite_strain
    if small and update.mean is not None and in_span(update.mean, kinematics.projection(u)):
        # The work of a mean stress that is among the functions projected on is the same with and without projection.
        virtual = ufl.sym(kinematics.gradient(v))
    finite = kinematics.average and kinematics.finite_strain
    if finite and update.mean is not None and same_in_cell(update.mean / kinematics.projection(u)):
        # With tau : d(F_bar) F_bar^-1 = dev tau : grad(v) F^-1 + mean dtheta/theta, and the mean of dJ in the place of
        # dtheta, whose factor mean/theta is the same everywhere in the cell.
        F = ufl.Identity(3) + kinematics.gradient(u)
        ratio = ufl.det(F) / kinematics.projection(u)
        parts = update.kirchhoff
        if parts is None or parts.piola is not update.piola:
            piola = update.piola + (ratio - 1) * update.mean * ufl.inv(F).T
        else:
            piola = (parts.rest + ratio * update.mean * ufl.Identity(3)) * parts.inverse.T
        work = ufl.inner(piola, kinematics.gradient(v))
        return work * weight(mesh, kinematics.hypothesis) * dx
    return ufl.inner(update.stress, virtual) * weight(mesh, kinematics.hypothesis) * dx


def quadrature_element(cell: Any, shape: tuple[int, ...], degree: int) -> Any:
    """Element with values at the points of the rule that forms of a quadrature degree have.

    Args:
        cell: name of the cell, or Basix's type.
        shape: shape of a value, () or (n,).
        degree: quadrature degree [1].
    """
    return basix.ufl.quadrature_element(cell, value_shape=shape, degree=degree, scheme="default")


class Symbols:
    """What stands for history and unknowns of a law in forms; kernels keep the values themselves.

    Args:
        response: the law.
        mesh: UFL mesh.
        degree: quadrature degree [1].

    Attributes:
        history: coefficients by name.
        unknown: coefficient of the local unknowns, or None.
    """

    def __init__(self, response: PointResponse, mesh: Any, degree: int) -> None:
        cell = str(mesh.ufl_cell())

        def symbol(shape: tuple[int, ...]) -> ufl.Coefficient:
            return ufl.Coefficient(ufl.FunctionSpace(mesh, quadrature_element(cell, shape, degree)))

        self.history = {name: symbol(shape) for name, shape in response.history.items()}
        self.unknown = None if response.unknown is None else symbol(response.unknown)


def force_and_law(
    u: Any,
    v: Any,
    response: PointResponse,
    kinematics: Kinematics,
    symbols: Symbols,
    dx: Any,
    with_stress: bool = False,
) -> tuple[ufl.Form, PointLaw]:
    """Internal virtual work of a law with internal variables, and the point law of its kernel.

    Args:
        u: displacement [L].
        v: test function.
        response: the law.
        kinematics: strains that the law sees.
        symbols: its history and unknowns.
        dx: measure of the cells, of the symbols' quadrature degree.
        with_stress: whether the Cauchy stress is an output, "stress".
    """
    mesh = ufl.domain.extract_unique_domain(u)
    update = kinematics.respond(response, u, symbols)
    if DeformedCell.serves(response, kinematics):
        cell = DeformedCell(mesh)
        faster = cell.respond(response, u, symbols)
        if cell.takes(faster, u):
            kinematics, update = cell, faster
    strain = kinematics.strain(u)
    outputs = {name: ufl.as_ufl(update.outputs[name]) for name in symbols.history}
    if symbols.unknown is not None:
        outputs[UNKNOWN] = symbols.unknown
    if with_stress:
        F = strain if update.strain is None else update.strain
        stress = update.stress * F.T / ufl.det(F) if kinematics.finite_strain else update.stress
        space = u.ufl_shape[0] == 3
        axes = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))[: 6 if space else 4]
        outputs["stress"] = ufl.as_vector([stress[i, j] for i, j in axes])
    law = PointLaw(
        outputs=outputs,
        history=symbols.history,
        unknown=symbols.unknown,
        residual=update.residual,
        start=update.start,
        scale=update.scale,
        start_error=update.start_error,
        sums={ELASTIC_ENERGY: update.stored * weight(mesh, kinematics.hypothesis)},
    )
    if isinstance(kinematics, DeformedCell):
        return kinematics.work(u, v, update) * dx, law
    return internal_force(u, v, kinematics, update, dx), law


def elastic_tangent(u: Any, du: Any, v: Any, law: Law, kinematics: Kinematics, dx: Any) -> Any:
    """Stiffness of the elastic solid in the deformed shape, an upper bound of that of the inelastic one.

    In finite strain the gradients are those with respect to the deformed position, and the volume is the deformed one:
    cells that have been flattened by plastic flow have higher frequencies. In plane stress the stretch across the plane
    is not known here. The volume is bounded by the larger one of the area and 1: a sheet that is stretched in its plane
    becomes thinner, and one that is compressed loses volume.

    Args:
        u: displacement [L].
        du: trial function.
        v: test function.
        law: linear elastic law of the hypothesis.
        kinematics: strains that the inelastic law sees.
        dx: measure of the cells.
    """
    own = kinematics.elastic_tangent(u, du, v)
    if own is not None:
        return own * dx
    if not kinematics.finite_strain:
        return elasticity.tangent(u, du, v, law, dx)
    mesh = ufl.domain.extract_unique_domain(v)
    return elastic_work(u, du, v, law, kinematics) * weight(mesh, kinematics.hypothesis) * dx


def elastic_work(u: Any, du: Any, v: Any, law: Law, kinematics: Kinematics) -> Any:
    """Virtual work per volume of `elastic_tangent`.

    Args:
        u: displacement [L].
        du: trial function.
        v: test function.
        law: linear elastic law of the hypothesis.
        kinematics: strains that the inelastic law sees.
    """
    plane_stress = kinematics.hypothesis == "plane_stress"
    lmbda = law.lmbda_plane if plane_stress else law.lmbda
    if not kinematics.finite_strain:
        a, b = (ufl.sym(kinematics.gradient(w)) for w in (du, v))
        return lmbda * ufl.tr(a) * ufl.tr(b) + 2 * law.mu * ufl.inner(a, b)
    F = ufl.Identity(3) + kinematics.gradient(u)
    inverse = ufl.inv(F)
    a, b = (ufl.sym(kinematics.gradient(w) * inverse) for w in (du, v))
    J = ufl.det(F)
    if plane_stress:
        J = ufl.max_value(J, 1)
    return (lmbda * ufl.tr(a) * ufl.tr(b) + 2 * law.mu * ufl.inner(a, b)) * J
