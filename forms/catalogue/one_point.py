# SPDX-License-Identifier: MIT
"""The elastic laws on cells with one point and hourglass control: "linear_elastic.reduced.force" and so on."""

from typing import Any

from .. import elasticity, one_point, quadrature
from ..materials import LAWS, Law
from ..registration import SCALAR, Setting, registered

ELASTIC = {"E": SCALAR, "nu": SCALAR}
KINDS = ("force", "tangent", "energy", "stress", "hourglass_energy")
NAMES = tuple(f"{law}.reduced.{kind}" for law in LAWS for kind in KINDS)
ABOUT: dict[str, Any] = {
    "quadrature": quadrature.one_point_degree,
    "constants": ELASTIC,
    "cells": one_point.CELLS,
    "cells_reason": "one point with hourglass control is for quadrilaterals and hexahedra",
    "excluded": {"axisymmetric": "one point with hourglass control is not for axisymmetric bodies"},
}


def _register(law: type[Law]) -> None:
    def on_cell(on: Setting, E: Any, nu: Any) -> Law:
        if on.degree != 1 or on.geometry_degree != 1:
            raise ValueError(
                f"one point with hourglass control is for displacement and geometry of degree 1, found {on.degree} "
                f"and {on.geometry_degree}"
            )
        return law(E, nu, on.hypothesis, "reduced")

    @registered(f"{law.name}.reduced.force", coefficients=("u",), **ABOUT)
    def force(on: Setting, E: Any, nu: Any, u: Any) -> Any:
        return elasticity.internal_force(u, on.test, on_cell(on, E, nu), on.dx)

    @registered(f"{law.name}.reduced.tangent", coefficients=() if law.linear else ("u",), **ABOUT)
    def tangent(on: Setting, E: Any, nu: Any, u: Any = None) -> Any:
        return elasticity.tangent(u, on.trial, on.test, on_cell(on, E, nu), on.dx)

    @registered(f"{law.name}.reduced.energy", coefficients=("u",), **ABOUT)
    def energy(on: Setting, E: Any, nu: Any, u: Any) -> Any:
        return elasticity.internal_energy(u, on_cell(on, E, nu), on.dx)

    @registered(f"{law.name}.reduced.stress", coefficients=("u",), **ABOUT)
    def stress(on: Setting, E: Any, nu: Any, u: Any) -> Any:
        return elasticity.internal_force_with_stress(u, on.test, on_cell(on, E, nu), on.dx)

    @registered(f"{law.name}.reduced.hourglass_energy", coefficients=("u",), **ABOUT)
    def hourglass_energy(on: Setting, E: Any, nu: Any, u: Any) -> Any:
        return one_point.hourglass_energy(u, on_cell(on, E, nu), on.dx)


for _law in LAWS.values():
    _register(_law)
