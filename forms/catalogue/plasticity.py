# SPDX-License-Identifier: MIT
"""J2 plasticity with isotropic hardening: "j2.small.linear" and so on, and the stiffness that bounds its frequencies.

The forms are those of J2Plasticity with its defaults, mean dilatation included, so that its kernels are found among
those that come with the package. The order of the constants must be the one in which J2Plasticity makes them.
"""

from typing import Any

from .. import inelastic, quadrature
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
NAMES = (*(f"j2.{strain}.{name}" for strain in ("small", "finite") for name in ISOTROPIC), STIFFNESS)


def _kinematics(on: Setting, finite: bool) -> inelastic.Kinematics:
    return inelastic.Kinematics(on.hypothesis, finite, inelastic.default_average(on.cell, on.degree))


def _register(finite: bool, name: str) -> None:
    hardening, parameters = ISOTROPIC[name]

    @registered(
        f"j2.{'finite' if finite else 'small'}.{name}",
        quadrature=quadrature.stiffness_degree,
        constants={**ELASTIC, **dict.fromkeys(parameters, SCALAR)},
        coefficients=("u",),
    )
    def force(on: Setting, E: Any, nu: Any, u: Any, **given: Any) -> Any:
        isotropic, plane_stress = hardening(**given), on.hypothesis == "plane_stress"
        response = J2(E, nu, CELLS[on.cell], isotropic, finite_strain=finite, plane_stress=plane_stress)
        symbols = inelastic.Symbols(response, on.mesh, on.quadrature_degree)
        return inelastic.force_and_law(u, on.test, response, _kinematics(on, finite), symbols, on.dx)


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
