# SPDX-License-Identifier: MIT
"""The elastic constants of two bodies in contact."""

from dataclasses import dataclass

from . import checks


@dataclass(frozen=True)
class Bodies:
    """Two isotropic elastic bodies; E = np.inf is a rigid one.

    Attributes:
        E1, E2: Young's moduli, positive, at most one of them infinite [F/L^2].
        nu1, nu2: Poisson's ratios, above -1, at most 0.5 [1].

    Raises:
        ValueError: a value outside its range, or two rigid bodies. TypeError: a value that is not a number.
    """

    E1: float
    nu1: float
    E2: float
    nu2: float

    def __post_init__(self) -> None:
        for name in ("E1", "E2"):
            value = checks.number(f"Young's modulus {name}", getattr(self, name), "[F/L^2]", infinite=True)
            object.__setattr__(self, name, value)
        for name in ("nu1", "nu2"):
            object.__setattr__(self, name, checks.poisson(f"Poisson's ratio {name}", getattr(self, name)))
        if self.E1 == self.E2 == float("inf"):
            raise ValueError("both bodies are rigid (E1 = E2 = inf): at least one must be elastic")

    def constants(self, body: int | None) -> tuple[float, float]:
        """(E, nu) of body 1 or 2 [F/L^2; 1]."""
        if body not in (1, 2):
            raise ValueError(f"body is {body!r}: the bodies are 1 and 2")
        return (self.E1, self.nu1) if body == 1 else (self.E2, self.nu2)

    def elastic_nu(self, body: int | None) -> float:
        """Poisson's ratio of a body that is not rigid [1].

        Raises:
            ValueError: the body is rigid: its stresses are not determined.
        """
        E, nu = self.constants(body)
        if E == float("inf"):
            raise ValueError(f"body {body} is rigid: its stresses are not determined")
        return nu

    def compliance(self, body: int | None) -> float:
        """(1 - nu^2)/E of a body [L^2/F]."""
        E, nu = self.constants(body)
        return (1.0 - nu**2) / E

    def shear_compliance(self, body: int | None) -> float:
        """1/G = 2 (1 + nu)/E of a body [L^2/F]."""
        E, nu = self.constants(body)
        return 2.0 * (1.0 + nu) / E

    @property
    def modulus(self) -> float:
        """E*, with 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2 [F/L^2]."""
        return 1.0 / (self.compliance(1) + self.compliance(2))

    @property
    def tangential_compliance(self) -> float:
        """(2 - nu1)/G1 + (2 - nu2)/G2: of point contacts under tangential load, Johnson 7.2 [L^2/F]."""
        return (2.0 - self.nu1) * self.shear_compliance(1) + (2.0 - self.nu2) * self.shear_compliance(2)

    def share(self, body: int | None = None) -> float:
        """Part that a body has in the normal displacement of both: 1 for None, 0 for a rigid body [1]."""
        return 1.0 if body is None else self.compliance(body) * self.modulus


def effective_modulus(E1: float, nu1: float, E2: float, nu2: float) -> float:
    """E* of two bodies, 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2 [F/L^2]; see Bodies for ranges and errors."""
    return Bodies(E1, nu1, E2, nu2).modulus
