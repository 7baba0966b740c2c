# SPDX-License-Identifier: MIT
"""Internal virtual work, tangent, strain energy and Cauchy stress of every law: "linear_elastic.force" and so on."""

from typing import Any

from .. import elasticity, quadrature
from ..materials import LAWS, Law
from ..registration import SCALAR, Setting, registered

ELASTIC = {"E": SCALAR, "nu": SCALAR}
STRESSES = tuple(f"{law}.stress" for law in LAWS)


def _register(law: type[Law]) -> None:
    rule = quadrature.stiffness_degree

    @registered(f"{law.name}.force", quadrature=rule, constants=ELASTIC, coefficients=("u",))
    def force(on: Setting, E: Any, nu: Any, u: Any) -> Any:
        return elasticity.internal_force(u, on.test, law(E, nu, on.hypothesis), on.dx)

    # The tangent of a linear law does not depend on the displacement.
    @registered(f"{law.name}.tangent", quadrature=rule, constants=ELASTIC, coefficients=() if law.linear else ("u",))
    def tangent(on: Setting, E: Any, nu: Any, u: Any = None) -> Any:
        return elasticity.tangent(u, on.trial, on.test, law(E, nu, on.hypothesis), on.dx)

    @registered(f"{law.name}.energy", quadrature=rule, constants=ELASTIC, coefficients=("u",))
    def energy(on: Setting, E: Any, nu: Any, u: Any) -> Any:
        return elasticity.internal_energy(u, law(E, nu, on.hypothesis), on.dx)

    # The internal force again, which writes the stress at the points on the way.
    @registered(f"{law.name}.stress", quadrature=rule, constants=ELASTIC, coefficients=("u",))
    def stress(on: Setting, E: Any, nu: Any, u: Any) -> Any:
        return elasticity.internal_force_with_stress(u, on.test, law(E, nu, on.hypothesis), on.dx)


for _law in LAWS.values():
    _register(_law)
