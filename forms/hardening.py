# SPDX-License-Identifier: MIT
"""Hardening of J2 plasticity in UFL: yield stress, back stress, and the start of the local equations."""

from dataclasses import dataclass
from typing import Any

import ufl

SMALL_TERM = 0.1  # of a series, relative to its first term: the rest of the series is smaller than its last term


@dataclass(frozen=True)
class LinearHardening:
    """Yield stress Y(alpha) = Y0 + H alpha.

    Attributes:
        yield_stress: Y0 [F/L^2].
        modulus: H [F/L^2].
        falls_to_zero: whether H is negative, so that the yield stress ends at zero.
    """

    yield_stress: Any
    modulus: Any
    falls_to_zero: bool = False

    @property
    def linear(self) -> bool:
        """Does a step have a closed form? Not if it must be refused because nothing of the yield stress is left."""
        return not self.falls_to_zero

    def stress(self, alpha: Any) -> Any:
        """Yield stress at the equivalent plastic strain alpha [1]."""
        return self.yield_stress + self.modulus * alpha

    def slope(self, alpha: Any) -> Any:
        """Derivative of `stress`."""
        return self.modulus


@dataclass(frozen=True)
class VoceHardening:
    """Yield stress Y(alpha) = Y0 + H alpha + (Y_s - Y0) (1 - exp(-rate alpha)).

    Attributes:
        yield_stress: Y0 [F/L^2].
        saturation: Y_s [F/L^2].
        rate: rate [1].
        modulus: H [F/L^2].
        falls_to_zero: whether H is negative, so that the yield stress ends at zero.
    """

    yield_stress: Any
    saturation: Any
    rate: Any
    modulus: Any
    falls_to_zero: bool = False

    linear = False

    def stress(self, alpha: Any) -> Any:
        """Yield stress at the equivalent plastic strain alpha [1]."""
        rise = (self.saturation - self.yield_stress) * (1 - ufl.exp(-self.rate * alpha))
        return self.yield_stress + self.modulus * alpha + rise

    def slope(self, alpha: Any) -> Any:
        """Derivative of `stress`."""
        return self.modulus + self.fading_slope(alpha)

    def fading_slope(self, alpha: Any) -> Any:
        """The part of `slope` that fades with alpha: each further derivative is -rate times the one before."""
        return self.rate * (self.saturation - self.yield_stress) * ufl.exp(-self.rate * alpha)


@dataclass(frozen=True)
class TableHardening:
    """Yield stress interpolated linearly between given points, constant beyond the last one.

    Attributes:
        strains: equivalent plastic strains, the first is 0, ascending [1].
        stresses: yield stresses at them [F/L^2].
    """

    strains: Any
    stresses: Any

    linear = False
    falls_to_zero = False  # stresses are positive

    @property
    def yield_stress(self) -> Any:
        """Yield stress of the virgin state [F/L^2]."""
        return self.stresses[0]

    def _segments(self) -> list[tuple[Any, Any]]:
        """Start and slope of every segment."""
        n = self.strains.ufl_shape[0]
        return [
            (self.strains[i], (self.stresses[i + 1] - self.stresses[i]) / (self.strains[i + 1] - self.strains[i]))
            for i in range(n - 1)
        ]

    def stress(self, alpha: Any) -> Any:
        """Yield stress at the equivalent plastic strain alpha [1]."""
        # A sum of ramps, each as long as its segment: without nested conditions, and continuous to round-off.
        value = self.stresses[0]
        for i, (start, slope) in enumerate(self._segments()):
            value += slope * ufl.min_value(ufl.max_value(alpha - start, 0), self.strains[i + 1] - start)
        return value

    def slope(self, alpha: Any) -> Any:
        """Derivative of `stress`; at a corner that of the segment to the right."""
        value = 0
        for i, (start, slope) in enumerate(self._segments()):
            inside = ufl.And(ufl.ge(alpha, start), ufl.lt(alpha, self.strains[i + 1]))
            value += ufl.conditional(inside, slope, 0)
        return value


@dataclass(frozen=True)
class KinematicHardening:
    """Armstrong-Frederick's back stress: d beta = 2/3 C d eps_p - gamma beta d alpha; gamma = 0 is Prager's linear law.

    Attributes:
        modulus: C [F/L^2].
        recovery: gamma [1]; None: the linear law.
    """

    modulus: Any
    recovery: Any = None

    @property
    def linear(self) -> bool:
        return self.recovery is None

    def fading(self, multiplier: Any) -> Any:
        """Factor by which backward Euler's rule shortens the back stress in a step with this increment of alpha."""
        # Iterates of the local equations may be negative, where the factor would have a pole.
        return 1 if self.recovery is None else 1 / (1 + self.recovery * ufl.max_value(multiplier, 0))


def first_increment(excess: Any, stiffness: Any, hardening: Any, alpha: Any) -> Any:
    """Start of the local equations: root x of stiffness x + Y(alpha + x) - Y(alpha) = excess, by its Taylor series.

    Steps of explicit problems are so short that the third order is the root to round-off, and one evaluation of the
    equations tells. Where the terms beyond the first are not small, the first is taken alone.

    Args:
        excess: trial stress beyond the yield stress [F/L^2].
        stiffness: slope of the rest of the equation [F/L^2].
        hardening: LinearHardening, VoceHardening or TableHardening.
        alpha: equivalent plastic strain at the beginning of the step [1].
    """
    if not isinstance(hardening, VoceHardening):
        return excess / (stiffness + hardening.slope(alpha))
    x, r, a, small = _series(excess, stiffness, hardening, alpha)
    return x * ufl.conditional(small, 1 + a * r * (1 / 2 + r * (a / 2 - 1 / 6)), 1)


def _series(excess: Any, stiffness: Any, hardening: VoceHardening, alpha: Any) -> tuple[Any, Any, Any, Any]:
    """First term x of the series, r = rate x, the share a of Voce's exponential in the slope, of which all further
    terms are products, and whether these are small beside the first."""
    fading = hardening.fading_slope(alpha)
    slope = stiffness + hardening.modulus + fading
    x = excess / slope
    r, a = hardening.rate * x, fading / slope
    return x, r, a, ufl.lt(abs(a * r) * (1 + abs(r)), 2 * SMALL_TERM)


def first_increment_error(excess: Any, stiffness: Any, hardening: VoceHardening, alpha: Any) -> Any:
    """Twice the fourth term of the series of `first_increment`, which bounds the rest where it is as small as
    round-off; 1 where terms are not small, as an increment of a plastic strain [1].

    Args:
        excess: as of first_increment, positive.
        stiffness: likewise.
        hardening: VoceHardening.
        alpha: likewise.
    """
    x, r, a, small = _series(excess, stiffness, hardening, alpha)
    # x a r^3 (1/24 - 5/12 a + 5/8 a^2), of which all parts count as if they had one sign.
    size = abs(a)
    return ufl.conditional(small, x * abs(a * r) * r**2 * (1 / 12 + size * (5 / 6 + 5 / 4 * size)), 1)
