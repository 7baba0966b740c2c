# SPDX-License-Identifier: MIT
"""Laws on cells with one point and hourglass control: "linear_elastic.reduced.force" and so on, of J2 plasticity
"j2.small.linear.reduced.force", and the stiffness that bounds its frequencies in finite strain.

The order of the constants must be the one in which J2Plasticity makes them.
"""

from typing import Any

from .. import elasticity, inelastic, one_point, one_point_flow, quadrature
from ..materials import LAWS, Law, LinearElastic
from ..plasticity import J2
from ..registration import CELLS, SCALAR, Setting, registered
from .plasticity import ISOTROPIC

ELASTIC = {"E": SCALAR, "nu": SCALAR}
KINDS = ("force", "tangent", "energy", "stress", "hourglass_energy")
PLASTIC = tuple(f"j2.{strain}.{name}.reduced.force" for strain in ("small", "finite") for name in ISOTROPIC)
STIFFNESS = "elastic_stiffness.finite.reduced"
NAMES = (*(f"{law}.reduced.{kind}" for law in LAWS for kind in KINDS), *PLASTIC, STIFFNESS)
ABOUT: dict[str, Any] = {
    "quadrature": quadrature.one_point_degree,
    "constants": ELASTIC,
    "cells": one_point.CELLS,
    "cells_reason": "one point with hourglass control is for quadrilaterals and hexahedra",
    "excluded": {"axisymmetric": "one point with hourglass control is not for axisymmetric bodies"},
}


def _check_degrees(on: Setting) -> None:
    if on.degree != 1 or on.geometry_degree != 1:
        raise ValueError(
            f"one point with hourglass control is for displacement and geometry of degree 1, found {on.degree} and "
            f"{on.geometry_degree}"
        )


def _register(law: type[Law]) -> None:
    def on_cell(on: Setting, E: Any, nu: Any) -> Law:
        _check_degrees(on)
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


def _kinematics(on: Setting, E: Any, nu: Any, finite: bool) -> one_point_flow.OnePointKinematics:
    _check_degrees(on)
    return one_point_flow.OnePointKinematics(on.mesh, LinearElastic(E, nu, on.hypothesis, "reduced"), finite)


def _register_plastic(finite: bool, name: str) -> None:
    hardening, parameters = ISOTROPIC[name]
    about = {**ABOUT, "constants": {**ELASTIC, **dict.fromkeys(parameters, SCALAR)}}

    @registered(f"j2.{'finite' if finite else 'small'}.{name}.reduced.force", coefficients=("u",), **about)
    def force(on: Setting, E: Any, nu: Any, u: Any, **given: Any) -> Any:
        kinematics, dim = _kinematics(on, E, nu, finite), CELLS[on.cell]
        law = J2(E, nu, dim, hardening(**given), finite_strain=finite, plane_stress=on.hypothesis == "plane_stress")
        response = one_point_flow.OnePointResponse(law, dim)
        symbols = inelastic.Symbols(response, on.mesh, on.quadrature_degree)
        return inelastic.force_and_law(u, on.test, response, kinematics, symbols, on.dx)


for _law in LAWS.values():
    _register(_law)
for _finite in (False, True):
    for _name in ISOTROPIC:
        _register_plastic(_finite, _name)


@registered(STIFFNESS, coefficients=("u",), **ABOUT)
def _stiffness(on: Setting, E: Any, nu: Any, u: Any) -> Any:
    """In small strain it is the tangent of the linear elastic law."""
    kinematics = _kinematics(on, E, nu, True)
    return inelastic.elastic_tangent(u, on.trial, on.test, kinematics.elastic, kinematics, on.dx)
