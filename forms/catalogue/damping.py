# SPDX-License-Identifier: MIT
"""Rayleigh damping."""

from typing import Any

from .. import damping, quadrature
from ..materials import LinearElastic
from ..registration import SCALAR, Setting, registered


@registered(
    "rayleigh",
    quadrature=quadrature.mass_degree,
    constants={"E": SCALAR, "nu": SCALAR, "density": SCALAR, "alpha": SCALAR, "beta": SCALAR},
)
def rayleigh(on: Setting, E: Any, nu: Any, density: Any, alpha: Any, beta: Any) -> Any:
    law = LinearElastic(E, nu, on.hypothesis)
    stiffness_dx = on.cells_measure(quadrature.stiffness_degree)
    return damping.rayleigh(on.trial, on.test, law, density, alpha, beta, on.dx, stiffness_dx)
