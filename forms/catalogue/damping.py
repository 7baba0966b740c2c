# SPDX-License-Identifier: MIT
"""Rayleigh damping, and what resists in explicit steps: "linear_elastic.damping", "linear_elastic.viscosity", ..."""

from typing import Any

from .. import damping, elasticity, quadrature, viscosity
from ..materials import LAWS, Law, LinearElastic
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


def _register(law: type[Law]) -> None:
    # The stiffness of a linear law does not depend on the displacement.
    motion = ("velocity",) if law.linear else ("u", "velocity")

    @registered(
        f"{law.name}.damping",
        quadrature=quadrature.stiffness_degree,
        constants={"E": SCALAR, "nu": SCALAR, "beta": SCALAR},
        coefficients=motion,
    )
    def stiffness_damping(on: Setting, E: Any, nu: Any, beta: Any, velocity: Any, u: Any = None) -> Any:
        return beta * elasticity.tangent(u, velocity, on.test, law(E, nu, on.hypothesis), on.dx)

    @registered(
        f"{law.name}.viscosity",
        quadrature=quadrature.stiffness_degree,
        constants={"E": SCALAR, "nu": SCALAR, "density": SCALAR, "linear": SCALAR, "quadratic": SCALAR},
        coefficients=motion,
    )
    def bulk_viscosity(
        on: Setting, E: Any, nu: Any, density: Any, linear: Any, quadratic: Any, velocity: Any, u: Any = None
    ) -> Any:
        law_here = law(E, nu, on.hypothesis)
        return viscosity.bulk(u, velocity, on.test, law_here, density, linear, quadratic, on.dx)


for _law in LAWS.values():
    _register(_law)
# Of the whole step, and no part of what verify compares element by element: it compares runs.
OF_STEPS = tuple(f"{law}.{what}" for law in LAWS for what in ("damping", "viscosity"))
