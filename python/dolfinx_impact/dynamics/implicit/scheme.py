# SPDX-License-Identifier: MIT
"""Newmark's method and its generalisations by four parameters; seed (3.81), corrected, docs/implicit/scheme.md."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...common.arguments import number
from ...common.types import FloatArray

SMALLEST_HHT = -1.0 / 3.0  # alpha of Hilber, Hughes and Taylor


@dataclass(frozen=True)
class ImplicitScheme:
    """Parameters of the generalised-alpha method in the form of Arnold and Bruels (2007).

    Equilibrium M a + C v + F(u) = 0 holds at the end of a step. Displacement and velocity follow from Newmark's
    formulas with an acceleration A of their own,

        u_1 = u_0 + h v_0 + h^2 ((1/2 - beta) A_0 + beta A_1),    v_1 = v_0 + h ((1 - gamma) A_0 + gamma A_1),
        (1 - alpha_m) A_1 + alpha_m A_0 = (1 - alpha_f) a_1 + alpha_f a_0.

    With alpha_m = alpha_f = 0 it is A = a, Newmark's method. On linear problems without damping the displacements are
    those of Chung and Hulbert (1993).

    Attributes:
        beta: weight of the new acceleration in the displacement [1].
        gamma: weight of the new acceleration in the velocity [1].
        alpha_m: weight of the old A [1].
        alpha_f: weight of the old a [1].
    """

    beta: float = 0.25
    gamma: float = 0.5
    alpha_m: float = 0.0
    alpha_f: float = 0.0

    @classmethod
    def of_arguments(
        cls, beta: float | None, gamma: float | None, rho_inf: float | None, hht: float | None
    ) -> ImplicitScheme:
        """Scheme of the arguments of a problem; each may be None.

        Args:
            beta: Newmark's beta [1].
            gamma: Newmark's gamma [1].
            rho_inf: spectral radius at infinite frequency [1].
            hht: alpha of Hilber, Hughes and Taylor [1].

        Returns:
            Scheme.

        Raises:
            TypeError: an argument is no number.
            ValueError: arguments exclude each other, or are out of their ranges.
        """
        families = {"beta, gamma": (beta, gamma), "rho_inf": (rho_inf,), "hht": (hht,)}
        given = [name for name, values in families.items() if any(v is not None for v in values)]
        if len(given) > 1:
            raise ValueError(f"{' and '.join(given)} are given: each of them determines all parameters, give one")
        if rho_inf is not None:
            return cls.generalised_alpha(number("rho_inf", rho_inf))
        if hht is not None:
            return cls.hht(number("hht", hht))
        gamma = 0.5 if gamma is None else number("gamma", gamma)
        beta = 0.25 if beta is None else number("beta", beta)
        return cls.newmark(beta, gamma)

    @classmethod
    def newmark(cls, beta: float, gamma: float) -> ImplicitScheme:
        """Newmark's method (1959).

        Args:
            beta: weight of the new acceleration in the displacement, positive [1].
            gamma: weight of the new acceleration in the velocity, at least 1/2 [1].

        Returns:
            Scheme.

        Raises:
            ValueError: `beta` is not positive, or `gamma` less than 1/2.
        """
        if not beta > 0.0:
            raise ValueError(f"beta is {beta}: an implicit scheme needs a positive one, for example 1/4")
        if gamma < 0.5:
            raise ValueError(f"gamma is {gamma}: below 1/2 every motion grows; give at least 1/2")
        return cls(beta, gamma)

    @classmethod
    def generalised_alpha(cls, rho_inf: float) -> ImplicitScheme:
        """Parameters of Chung and Hulbert (1993): of second order, with the least damping of low frequencies.

        Args:
            rho_inf: spectral radius at infinite frequency, 0 to 1 [1].

        Returns:
            Scheme.

        Raises:
            ValueError: `rho_inf` is not in that range.
        """
        if not 0.0 <= rho_inf <= 1.0:
            raise ValueError(f"rho_inf is {rho_inf}: the spectral radius at infinite frequency is from 0 to 1")
        alpha_m, alpha_f = (2.0 * rho_inf - 1.0) / (rho_inf + 1.0), rho_inf / (rho_inf + 1.0)
        return cls(0.25 * (1.0 - alpha_m + alpha_f) ** 2, 0.5 - alpha_m + alpha_f, alpha_m, alpha_f)

    @classmethod
    def hht(cls, alpha: float) -> ImplicitScheme:
        """Parameters of Hilber, Hughes and Taylor (1977).

        Args:
            alpha: -1/3 to 0; 0 is the trapezoidal rule [1].

        Returns:
            Scheme.

        Raises:
            ValueError: `alpha` is not in that range.
        """
        if not SMALLEST_HHT <= alpha <= 0.0:
            raise ValueError(f"hht is {alpha}: alpha of Hilber, Hughes and Taylor is from -1/3 to 0")
        return cls(0.25 * (1.0 - alpha) ** 2, 0.5 - alpha, 0.0, -alpha)

    @property
    def second_order(self) -> bool:
        """Whether the error is of the second power of the step."""
        return math.isclose(self.gamma, 0.5 - self.alpha_m + self.alpha_f, abs_tol=1e-14)

    @property
    def error_constant(self) -> float:
        """Factor of h^3 times the third derivative of u in the error of one step's displacement [1]; Zienkiewicz and
        Xie (1991) for Newmark's method."""
        return self.beta - 1.0 / 6.0 - 0.5 * (self.alpha_f - self.alpha_m)

    def stable_frequency(self) -> float:
        """Largest product of angular frequency and step at which a motion without damping does not grow.

        Returns:
            The product; infinite for schemes that are stable with any step [1].
        """
        if self.alpha_m != 0.0 or self.alpha_f != 0.0:  # both families are stable with any step
            return math.inf
        conditional = 0.5 * self.gamma - self.beta
        return 1.0 / math.sqrt(conditional) if conditional > 1e-15 else math.inf

    def spectral_radius(self, product: float, damping: float = 0.0) -> float:
        """Largest absolute eigenvalue of a step of the oscillator u'' + 2 damping w u' + w^2 u = 0.

        Args:
            product: angular frequency times step, w h [1].
            damping: fraction of critical damping [1].

        Returns:
            Spectral radius; at most one where the scheme is stable [1].
        """
        return float(np.max(np.abs(np.linalg.eigvals(self.amplification(product, damping)))))

    def amplification(self, product: float, damping: float = 0.0) -> FloatArray:
        """Matrix of a step of the oscillator u'' + 2 damping w u' + w^2 u = 0.

        Args:
            product: angular frequency times step, w h [1].
            damping: fraction of critical damping [1].

        Returns:
            Matrix (3, 3) that maps (u, h v, h^2 A) at the start of a step to that at its end.
        """
        w2, c = product**2, 2.0 * damping * product
        m, f = self.alpha_m, self.alpha_f
        # Rows: the two formulas of Newmark, then the mean of the accelerations with a = -c v - w2 u.
        left = np.array([[1.0, 0.0, -self.beta], [0.0, 1.0, -self.gamma], [(1.0 - f) * w2, (1.0 - f) * c, 1.0 - m]])
        right = np.array([[1.0, 1.0, 0.5 - self.beta], [0.0, 1.0, 1.0 - self.gamma], [-f * w2, -f * c, -m]])
        return np.linalg.solve(left, right)

    def __str__(self) -> str:
        text = f"beta={self.beta:.10g}, gamma={self.gamma:.10g}"
        if self.alpha_m or self.alpha_f:
            text += f", alpha_m={self.alpha_m:.10g}, alpha_f={self.alpha_f:.10g}"
        return text
