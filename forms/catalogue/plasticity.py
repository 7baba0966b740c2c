# SPDX-License-Identifier: MIT
"""J2 plasticity with isotropic hardening: "j2.small.linear.force", its consistent tangent and so on, and the stiffness
that bounds its frequencies.

The forms are those of J2Plasticity with its defaults, mean dilatation included, so that its kernels are found among
those that come with the package. The order of the constants must be the one in which J2Plasticity makes them.
"""

from typing import Any

import ufl

from .. import consistent_tangent, inelastic, quadrature
from ..hardening import LinearHardening, VoceHardening
from ..materials import LinearElastic
from ..plasticity import J2
from ..registration import CELLS, SCALAR, Setting, registered

ELASTIC = {"E": SCALAR, "nu": SCALAR}
ISOTROPIC: dict[str, tuple[type, tuple[str, ...]]] = {
    "linear": (LinearHardening, ("yield_stress", "modulus")),
    "voce": (VoceHardening, ("yield_stress", "saturation", "rate", "modulus")),
}
STIFFNESS = "elastic_stiffness.finite"
LAWS = tuple(f"j2.{strain}.{name}" for strain in ("small", "finite") for name in ISOTROPIC)
NAMES = (*(f"{law}.{kind}" for law in LAWS for kind in ("force", "tangent")), STIFFNESS)


def _kinematics(on: Setting, finite: bool) -> inelastic.Kinematics:
    return inelastic.Kinematics(on.hypothesis, finite, inelastic.default_average(on.cell, on.degree))


def _register(finite: bool, name: str) -> None:
    hardening, parameters = ISOTROPIC[name]
    law = f"j2.{'finite' if finite else 'small'}.{name}"
    constants = {**ELASTIC, **dict.fromkeys(parameters, SCALAR)}

    def response_on(on: Setting, E: Any, nu: Any, given: dict[str, Any]) -> tuple[J2, inelastic.Symbols]:
        isotropic, plane_stress = hardening(**given), on.hypothesis == "plane_stress"
        response = J2(E, nu, CELLS[on.cell], isotropic, finite_strain=finite, plane_stress=plane_stress)
        return response, inelastic.Symbols(response, on.mesh, on.quadrature_degree)

    @registered(f"{law}.force", quadrature=quadrature.stiffness_degree, constants=constants, coefficients=("u",))
    def force(on: Setting, E: Any, nu: Any, u: Any, **given: Any) -> Any:
        response, symbols = response_on(on, E, nu, given)
        return inelastic.force_and_law(u, on.test, response, _kinematics(on, finite), symbols, on.dx)

    @registered(f"{law}.tangent", quadrature=quadrature.stiffness_degree, constants=constants, coefficients=("u",))
    def tangent(on: Setting, E: Any, nu: Any, u: Any, **given: Any) -> Any:
        response, symbols = response_on(on, E, nu, given)
        du, kinematics = ufl.Coefficient(on.space), _kinematics(on, finite)
        form = consistent_tangent.consistent_tangent(u, du, on.test, response, kinematics, symbols, on.dx)
        return form, consistent_tangent.names_of(symbols, du)


for _finite in (False, True):
    for _name in ISOTROPIC:
        _register(_finite, _name)


@registered(
    STIFFNESS,
    quadrature=quadrature.stiffness_degree,
    constants=ELASTIC,
    coefficients=("u",),
)
def _stiffness(on: Setting, E: Any, nu: Any, u: Any) -> Any:
    """In small strain it is the tangent of the linear elastic law."""
    law = LinearElastic(E, nu, on.hypothesis)
    return inelastic.elastic_tangent(u, on.trial, on.test, law, _kinematics(on, True), on.dx)
