# SPDX-License-Identifier: MIT
"""J2 plasticity in UFL: von Mises' yield condition, associated flow, isotropic and kinematic hardening.

Small strain (Simo & Hughes 1998, chapter 3): strain splits into an elastic and a plastic part,

    sigma = kappa tr(eps) I + 2 mu dev(eps - eps_p),    f = q(dev sigma - beta) - Y(alpha) <= 0,   q(s) = sqrt(3/2 s:s).

Finite strain (Simo & Hughes 1998, box 9.1): the deformation gradient splits into an elastic and a plastic factor; the
elastic left Cauchy-Green tensor follows from F and the inverse of the plastic right Cauchy-Green tensor, which is kept
in the reference configuration, so that the law is exact under rotations of any size. With kinematic hardening the same
return is made in the frame of the rotation R of F = R U, in which the back stress is kept: its rate is that of Green
and Naghdi (Dienes 1979; Johnson & Bammann 1984), and a rotation of the body leaves the history alone.

In plane stress the stretch across the plane is a local unknown, with the equation that the stress across vanishes.

Both are integrated by the backward Euler method with a radial return: the flow direction is that of the trial stress,
and what is left is one scalar equation for the increment of the equivalent plastic strain. It is solved in closed form
for linear hardening, and by Newton's method at each quadrature point otherwise (forms/point_law.py).

Tensors of the history are kept as vectors: of a symmetric deviatoric tensor (xx, yy, xy, yz, xz) in space and (xx, yy,
xy) in the plane, of another symmetric tensor (xx, yy, zz, xy, yz, xz) and (xx, yy, zz, xy). The history is zero in the
virgin state.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import ufl

from .hardening import KinematicHardening, VoceHardening, first_increment, first_increment_error
from .inelastic import Flow, Kirchhoff, Update, cofactor, deviator, gradient_and_dilatation, gradient_determinant, trace
from .materials import lame

PLASTIC_STRAIN = "plastic_strain"  # equivalent plastic strain, a number [1]
PLASTIC_TENSOR = "plastic_strain_tensor"  # deviatoric tensor; in finite strain the inverse of C_p minus I [1]
BACK_STRESS = "back_stress"  # deviatoric tensor; in finite strain R^T beta R with the rotation R of F [F/L^2]
THICKNESS_STRAIN = "thickness_strain"  # plane stress of finite strain: logarithm of the stretch across the plane [1]
SMALL_DEVIATOR = 1e-3  # half of its square, of an elastic strain whose series is exact to round-off [1]
ROUND_OFF = 1e-14  # of the trial stress against the yield stress: keeps the direction of a zero stress finite


def pack_deviator(t: Any, gdim: int) -> list[Any]:
    """Independent components of a symmetric deviatoric 3 x 3 tensor."""
    return [t[0, 0], t[1, 1], t[0, 1], t[1, 2], t[0, 2]] if gdim == 3 else [t[0, 0], t[1, 1], t[0, 1]]


def unpack_deviator(v: Any, gdim: int) -> Any:
    """The 3 x 3 tensor of `pack_deviator`."""
    yz, xz = (v[3], v[4]) if gdim == 3 else (0, 0)
    return ufl.as_tensor([[v[0], v[2], xz], [v[2], v[1], yz], [xz, yz, -v[0] - v[1]]])


def pack_symmetric(t: Any, gdim: int) -> list[Any]:
    """Independent components of a symmetric 3 x 3 tensor."""
    normal = [t[0, 0], t[1, 1], t[2, 2], t[0, 1]]
    return normal + [t[1, 2], t[0, 2]] if gdim == 3 else normal


def unpack_symmetric(v: Any, gdim: int) -> Any:
    """The 3 x 3 tensor of `pack_symmetric`."""
    yz, xz = (v[4], v[5]) if gdim == 3 else (0, 0)
    return ufl.as_tensor([[v[0], v[3], xz], [v[3], v[1], yz], [xz, yz, v[2]]])


def equivalent(s: Any, floor: Any) -> Any:
    """Von Mises' equivalent of a deviatoric stress, sqrt(3/2 s:s); not below `floor`, so that it divides."""
    return ufl.sqrt(1.5 * ufl.inner(s, s) + floor**2)


def unimodular_mean(d: Any) -> Any:
    """The number x for which det(d + x I) = 1, for a small deviatoric 3 x 3 tensor d: plastic flow keeps the volume.

    x^3 - (d:d / 2) x + det d = 1 by Cardano's formula. It has one root while d is an elastic strain: a stretch of 1.7
    along an axis is the first with three. Near 1, as of metals, by the series of the inverse function: with x = 1 + z,
    (3 - d:d / 2) z + 3 z^2 + z^3 = d:d / 2 - det d. Its coefficients, powers of 1/(1 - d:d / 6), are series themselves,
    without a division that what follows would wait for. What is left out is 1e-17 at most there.
    """
    half, determinant = ufl.inner(d, d) / 2, ufl.det(d)
    third = 1 - determinant
    root = ((third + ufl.sqrt(third**2 - 4 / 27 * half**3)) / 2) ** (-1 / 3)
    cardano = (third + ufl.sqrt(third**2 - 4 / 27 * half**3)) / 2 * root**2 + half / 3 * root
    g = half / 3
    b = (1 + g) * (1 + g**2)
    y = (half - determinant) / 3 * b
    near = 1 + y * (1 - y * (b - y * (5 / 3 + 11 / 3 * g - 10 / 3 * y)))
    return ufl.conditional(ufl.gt(half, SMALL_DEVIATOR), cardano, near)


def symmetric(t: Any) -> Any:
    """A 3 x 3 tensor that is known to be symmetric, of its upper triangle, so that kernels compute no entry twice."""
    return ufl.as_tensor([[t[min(i, j), max(i, j)] for j in range(3)] for i in range(3)])


# --- polar decomposition F = R U of a deformation gradient with det F = 1 ---------------------------------------------


def plane_stretch(F: Any) -> Any:
    """U where the rotation is about the normal of the plane, 3 x 3 [1]."""
    c, s = F[0, 0] + F[1, 1], F[1, 0] - F[0, 1]
    size = ufl.sqrt(c**2 + s**2)
    c, s = c / size, s / size
    shear = c * F[0, 1] + s * F[1, 1]
    return ufl.as_tensor(
        [[c * F[0, 0] + s * F[1, 0], shear, 0], [shear, c * F[1, 1] - s * F[0, 1], 0], [0, 0, F[2, 2]]]
    )


def next_trace(C: Any, x: Any = None) -> Any:
    """Fixed point at tr U, of C = U^2; without x an upper bound of it [1].

    The invariants of U follow from those of C by I_U^2 = I_C + 2 II_U and II_U^2 = II_C + 2 I_U (Franca 1989), without
    a case of equal stretches. The slope at the fixed point is 1/(I_U II_U), 1/9 at most. The bound is II_U^2 <= 3 II_C.
    """
    first = ufl.tr(C)
    second = (first**2 - ufl.tr(C * C)) / 2
    return ufl.sqrt(first + 2 * ufl.sqrt(3 * second if x is None else second + 2 * x))


def stretch(C: Any, x: Any) -> tuple[Any, Any]:
    """U and its inverse from C = U^2 and x = tr U by Cayley and Hamilton (Hoger & Carlson 1984) [1]."""
    one = ufl.Identity(3)
    second = (x**2 - ufl.tr(C)) / 2
    U = (x * one + (x**2 - second) * C - C * C) / (x * second - 1)
    return U, C - x * U + second * one


def _where(condition: Any, new: Any, old: Any) -> Any:
    """Vector whose components are those of one vector where a condition holds, otherwise those of another."""
    return ufl.as_vector([ufl.conditional(condition, new[i], old[i]) for i in range(new.ufl_shape[0])])


# --- the law ---------------------------------------------------------------------------------------------------------


def thickened(F: Any, across: Any) -> Any:
    """A deformation gradient of the plane with the logarithm of the stretch across the plane, 3 x 3 [1]."""
    return ufl.as_tensor([[F[0, 0], F[0, 1], 0], [F[1, 0], F[1, 1], 0], [0, 0, ufl.exp(across)]])


@dataclass(frozen=True)
class _Trial:
    """Trial state of a step of finite strain.

    Attributes:
        J: det F [1].
        root: J^(-1/3), or 1 where U is in the place of F [1].
        turned: inverse of F or U [1].
        deviator: deviatoric Kirchhoff stress [F/L^2].
        stiff: mu tr(be_bar), 3 mu in small strain [F/L^2].
        unimodular: J^(-1/3) F with kinematic hardening, or None [1].
        square: C of it, or None [1].
    """

    J: Any
    root: Any
    turned: Any
    deviator: Any
    stiff: Any
    unimodular: Any
    square: Any


class J2:
    """J2 plasticity (forms/inelastic.py: PointResponse).

    The unknown is the increment of the equivalent plastic strain. In plane stress it is a vector of it and the strain
    across the plane, in finite strain the logarithmic one; in finite strain in space with kinematic hardening of it,
    the trace of the stretch U and the mean of the elastic left Cauchy-Green tensor, whose expressions would be large.
    Otherwise linear hardening has none.

    Args:
        E: Young's modulus [F/L^2].
        nu: Poisson's ratio [1].
        gdim: dimension of the space, 2 or 3.
        isotropic: LinearHardening, VoceHardening or TableHardening.
        kinematic: KinematicHardening, or None.
        finite_strain: whether the strain is the deformation gradient.
        plane_stress: whether the stress across the plane is zero.
    """

    def __init__(
        self,
        E: Any,
        nu: Any,
        gdim: int,
        isotropic: Any,
        kinematic: KinematicHardening | None = None,
        finite_strain: bool = False,
        plane_stress: bool = False,
    ) -> None:
        self.isotropic, self.kinematic, self.gdim = isotropic, kinematic, gdim
        self.finite_strain, self.plane_stress = finite_strain, plane_stress
        self.nu = nu
        lmbda, self.mu = lame(E, nu)
        self.kappa = lmbda + 2 * self.mu / 3
        deviator, symmetric = ((5,), (6,)) if gdim == 3 else ((3,), (4,))
        self.history: dict[str, tuple[int, ...]] = {
            PLASTIC_STRAIN: (),
            PLASTIC_TENSOR: symmetric if finite_strain else deviator,
        }
        if kinematic is not None:
            self.history[BACK_STRESS] = deviator
        if finite_strain and plane_stress:
            self.history[THICKNESS_STRAIN] = ()
        closed = isotropic.linear and (kinematic is None or kinematic.linear)
        self._turns = finite_strain and kinematic is not None and gdim == 3
        vector = 2 if plane_stress else 3 if self._turns else 0
        self.unknown: tuple[int, ...] | None = (vector,) if vector else None if closed else ()
        # In finite strain, of det(F)^(-1/3) F and the dilatation alone (forms/inelastic.py: DeformedCell).
        self.scale_free = finite_strain and kinematic is None and not plane_stress

    def respond(self, strain: Any, history: dict[str, Any], unknown: Any = None) -> Update:
        return (self._finite if self.finite_strain else self._small)(strain, history, unknown)

    def volume_energy(self, values: Sequence[Any]) -> Any:
        """Mean over some changes of volume of what they store (forms/averaged_pressure.py: VolumetricResponse).

        Args:
            values: tr(eps), in finite strain J [1].
        """
        n = len(values)
        squares = sum(value**2 for value in values) / n
        if not self.finite_strain:
            return self.kappa / 2 * squares
        return self.kappa / 2 * ((squares - 1) / 2 - ufl.ln(math.prod(values)) / n)

    def volume_pressure(self, values: Sequence[Any]) -> Any:
        """Mean over some changes of volume of the mean stress, in finite strain Cauchy's.

        Args:
            values: tr(eps), in finite strain J [1].
        """
        n = len(values)
        mean = sum(values) / n
        if not self.finite_strain:
            return self.kappa * mean
        # One division: the sum of reciprocals over the product.
        others = sum(math.prod(values[:i] + values[i + 1 :]) for i in range(n))
        return self.kappa / 2 * (mean - others / math.prod(values) / n)

    def _start_error(self, excess: Any, stiffness: Any, alpha: Any, yields: Any) -> Any:
        """Error of the start of the one equation of isotropic hardening, where its series tells it, or None. A yield
        stress that falls must be looked at: nothing of it may be left."""
        iso = self.isotropic
        scalar = self.kinematic is None and not self.plane_stress
        if not scalar or not isinstance(iso, VoceHardening) or iso.falls_to_zero:
            return None
        return ufl.conditional(yields, first_increment_error(excess, stiffness, iso, alpha), 0)

    def _with_strength(self, residual: Any, alpha: Any) -> Any:
        """A residual that has no root where the yield stress has fallen to zero: kernels then report the point."""
        if not self.isotropic.falls_to_zero:
            return residual
        return ufl.conditional(ufl.gt(self.isotropic.stress(alpha), 0), residual, 1 + residual**2)

    def _small(self, eps: Any, history: dict[str, Any], unknown: Any) -> Update:
        iso, kin, mu = self.isotropic, self.kinematic, self.mu
        multiplier = unknown[0] if self.plane_stress else unknown
        given = trace(eps)
        if self.plane_stress:
            eps = eps + unknown[1] * ufl.as_tensor([[0, 0, 0], [0, 0, 0], [0, 0, 1]])
        alpha = history[PLASTIC_STRAIN]
        # Stresses are over 2 mu, as elastic strains: kernels then multiply numbers that are constant before the loops.
        plastic = history[PLASTIC_TENSOR]
        trial = unpack_deviator(ufl.as_vector(pack_deviator(deviator(eps), self.gdim)) - plastic, self.gdim)
        floor = ROUND_OFF * iso.yield_stress / (2 * mu)
        back = None if kin is None else unpack_deviator(history[BACK_STRESS], self.gdim) / (2 * mu)
        C = 0 if kin is None else kin.modulus
        first = trial if back is None else trial - back  # relative stress of an elastic step
        size = equivalent(first, floor)
        excess = 2 * mu * size - iso.stress(alpha)
        yields = ufl.gt(excess, 0)
        start = ufl.conditional(yields, first_increment(excess, 3 * mu + C, iso, alpha), 0)
        residual: Any = None
        start_error = self._start_error(excess, 3 * mu + C, alpha, yields)
        if multiplier is None:
            multiplier, fading, relative = start, 1, first
        else:
            fading = 1 if kin is None else kin.fading(multiplier)
            relative = first
            if back is not None:
                relative = trial - fading * back
                size = equivalent(relative, floor)
            flow = (3 * mu + C * fading) * multiplier + iso.stress(alpha + multiplier)
            excess = self._with_strength((2 * mu * size - flow) / (3 * mu), alpha + multiplier)
            residual = ufl.conditional(yields, excess, multiplier)
        # Of the relative stress over 2 mu the share that becomes plastic strain.
        share = ufl.conditional(yields, 1.5 * multiplier / size, 0)
        step = share * relative
        elastic = (1 - share) * trial if back is None else trial - step
        mean = self.kappa * trace(eps)
        stress = 2 * mu * elastic + mean * ufl.Identity(3)
        outputs: dict[str, Any] = {
            PLASTIC_STRAIN: alpha + multiplier,
            PLASTIC_TENSOR: plastic + ufl.as_vector(pack_deviator(step, self.gdim)),
        }
        if back is not None:
            outputs[BACK_STRESS] = ufl.as_vector(pack_deviator(fading * (2 * mu * back + 2 / 3 * C * step), self.gdim))
        square = (1 - share) ** 2 * ufl.inner(trial, trial) if back is None else ufl.inner(elastic, elastic)
        stored = self.kappa / 2 * trace(eps) ** 2 + mu * square
        if self.plane_stress:
            across = stress[2, 2] / (self.kappa + 4 / 3 * mu)
            residual = ufl.as_vector([residual, across])
            start = ufl.as_vector([0, -self.nu / (1 - self.nu) * given])
        scale = iso.yield_stress / (3 * mu)
        start = None if residual is None else start
        slope = iso.slope(alpha) + C
        flow = Flow(iso.stress(alpha), multiplier, slope, 1.5 / size * relative, 1 - share, yields)
        return Update(stress, outputs, stored, residual, start, scale, mean, start_error=start_error, flow=flow)

    def _trial(self, F: Any, J: Any, history: dict[str, Any], trace: Any) -> "_Trial":
        """Trial state of finite strain, at the trace of the stretch where that is an unknown; of any multiple of F,
        whose determinant is J."""
        inverse = ufl.Identity(3) + unpack_symmetric(history[PLASTIC_TENSOR], self.gdim)
        # Without back stress the return is made in space. With it, in the frame that R turns: U is in the place of F.
        unimodular, square = None, None
        if self.kinematic is None:
            # Powers of the root in the place of divisions by J.
            root, G = J ** (-1 / 3), F
            turned = root**3 * cofactor(F).T
        else:
            root, unimodular = ufl.as_ufl(1), J ** (-1 / 3) * F
            square = unimodular.T * unimodular
            G, turned = stretch(square, trace) if self._turns else (plane_stretch(unimodular), None)
            turned = ufl.inv(G) if turned is None else turned
        elastic = root**2 * symmetric(G * inverse * G.T)  # trial left Cauchy-Green tensor, without its volume change
        stress, stiff = self.mu * deviator(elastic), self.mu * ufl.tr(elastic)
        return _Trial(J, root, turned, stress, stiff, unimodular, square)

    def _first(self, trial: "_Trial", history: dict[str, Any], back: Any) -> tuple[Any, Any]:
        """Relative stress of an elastic step, and the increment of alpha that linear hardening would have."""
        iso, alpha = self.isotropic, history[PLASTIC_STRAIN]
        relative = trial.deviator if back is None else trial.deviator - back
        excess = equivalent(relative, ROUND_OFF * iso.yield_stress) - iso.stress(alpha)
        C = 0 if self.kinematic is None else self.kinematic.modulus
        step = first_increment(excess, trial.stiff + C, iso, alpha)
        return relative, ufl.conditional(ufl.gt(excess, 0), step, 0)

    def _finite(self, F: Any, history: dict[str, Any], unknown: Any) -> Update:
        iso, kin, mu, alpha = self.isotropic, self.kinematic, self.mu, history[PLASTIC_STRAIN]
        multiplier, trace, mean, across = unknown, None, None, None
        if self._turns:
            multiplier, trace, mean = unknown[0], unknown[1], unknown[2]
        elif self.plane_stress:
            multiplier, across = unknown[0], unknown[1]
        back = None if kin is None else unpack_deviator(history[BACK_STRESS], self.gdim)
        C = 0 if kin is None else kin.modulus
        if across is not None:
            # Plastic flow keeps the volume, and what elasticity changes of it is small: Newton's method begins without.
            closed = -ufl.ln(F[0, 0] * F[1, 1] - F[0, 1] * F[1, 0])
            flat = thickened(F, closed)
            _, begin = self._first(self._trial(flat, ufl.det(flat), history, None), history, back)
            F = thickened(F, across)
        # Of an averaged F all but the dilatation is that of the F that it is a multiple of.
        determinant = gradient_determinant(F)
        F, J = gradient_and_dilatation(F)
        at = self._trial(F, determinant, history, trace)
        trial, stiff, turned = at.deviator, at.stiff, at.turned
        relative, start = self._first(at, history, back)
        q = equivalent(relative, ROUND_OFF * iso.yield_stress)
        yields = ufl.gt(q - iso.stress(alpha), 0)
        start_error = self._start_error(q - iso.stress(alpha), stiff, alpha, yields)
        residual: Any = None
        fading: Any = 1
        if multiplier is None:
            multiplier = start
        else:
            if back is not None:
                fading = kin.fading(multiplier)
                relative = trial - fading * back
                q = equivalent(relative, ROUND_OFF * iso.yield_stress)
            flow = (stiff + C * fading) * multiplier + iso.stress(alpha + multiplier)
            excess = self._with_strength((q - flow) / (3 * mu), alpha + multiplier)
            residual = ufl.conditional(yields, excess, multiplier)
        share = ufl.conditional(yields, 1 - stiff * multiplier / q, 1)
        s = share * trial if back is None else trial - stiff * multiplier / q * relative
        pressure = self.kappa / 2 * (J**2 - 1)
        tau = pressure * ufl.Identity(3) + s
        deviator = s / mu
        scale = iso.yield_stress / (3 * mu)
        # Of the order of 1: they are solved to 1e-14, where round-off of the terms of the first is a part of scale.
        others: list[Any] = []
        if self._turns:
            half, third = ufl.inner(deviator, deviator) / 2, ufl.det(deviator)
            determinant = mean - 1 - (half * mean - third) / (mean**2 + mean + 1)  # (det be_bar - 1)/(mean^2 + ...)
            others = [trace - next_trace(at.square, trace), determinant]
            start = ufl.as_vector([0, next_trace(at.square, next_trace(at.square, next_trace(at.square))), 1])
        else:
            mean = unimodular_mean(deviator)
        if across is not None:
            others = [tau[2, 2] / (self.kappa + 4 / 3 * mu)]
            start = ufl.as_vector([begin, closed])
        if others:
            residual = ufl.as_vector([residual, *(100 * scale * other for other in others)])
        old = history[PLASTIC_TENSOR]
        if back is None:
            # Of the deviator the returned share is left, whose C_p^-1 is known without products with F^-1: the trial's.
            volume = (mean - share * stiff / (3 * mu)) * at.root**4
            new = share * (ufl.Identity(3) + unpack_symmetric(old, self.gdim))
            new += volume * symmetric(cofactor(F).T * cofactor(F)) - ufl.Identity(3)
        else:
            new = turned * (deviator + mean * ufl.Identity(3)) * turned.T - ufl.Identity(3)
        packed = ufl.as_vector(pack_symmetric(new, self.gdim))
        outputs = {
            PLASTIC_STRAIN: ufl.conditional(yields, alpha + multiplier, alpha),
            PLASTIC_TENSOR: packed if back is not None else _where(yields, packed, old),
        }
        piola = tau * turned.T
        if back is not None:
            outputs[BACK_STRESS] = ufl.as_vector(
                pack_deviator(fading * (back + C * multiplier / q * relative), self.gdim)
            )
            piola = at.J ** (-1 / 3) * at.unimodular * (turned * piola)  # R tau U^-1 with R = F U^-1
        if across is not None:
            outputs[THICKNESS_STRAIN] = across
        if back is None:
            mean = ufl.conditional(yields, mean, stiff / (3 * mu))  # the same of an elastic step, which knows it
        stored = self.kappa / 2 * ((J**2 - 1) / 2 - ufl.ln(J)) + mu / 2 * (3 * mean - 3)
        stress = piola if J == at.J else (at.J / J) ** (1 / 3) * piola
        start = None if residual is None else start
        full = None if across is None else F
        parts = Kirchhoff(piola, s, turned) if back is None else None
        direction = 1.5 / q * relative
        if back is not None:  # of the frame that R = F U^-1 turns
            R = at.unimodular * turned
            direction = R * direction * R.T
        flow = Flow(iso.stress(alpha), multiplier, iso.slope(alpha) + C, direction, share, yields)
        return Update(stress, outputs, stored, residual, start, scale, pressure, piola, full, parts, start_error, flow)
