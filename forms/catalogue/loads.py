# SPDX-License-Identifier: MIT
"""Body force, gravity, traction and pressure that follows the surface."""

from typing import Any

from .. import loads, quadrature
from ..registration import SCALAR, VECTOR, Setting, registered


@registered("body_force", quadrature=quadrature.mass_degree, constants={"f": VECTOR})
def body_force(on: Setting, f: Any) -> Any:
    return loads.body_force(f, on.test, on.hypothesis, on.dx)


@registered("gravity", quadrature=quadrature.mass_degree, constants={"density": SCALAR, "g": VECTOR})
def gravity(on: Setting, density: Any, g: Any) -> Any:
    return loads.body_force(density * g, on.test, on.hypothesis, on.dx)


@registered("traction", quadrature=quadrature.facet_degree, constants={"t": VECTOR})
def traction(on: Setting, t: Any) -> Any:
    return loads.traction(t, on.test, on.hypothesis, on.ds)


@registered("follower_pressure", quadrature=quadrature.follower_degree, constants={"p": SCALAR}, coefficients=("u",))
def follower_pressure(on: Setting, p: Any, u: Any) -> Any:
    return loads.follower_pressure(p, u, on.test, on.hypothesis, on.ds)


@registered(
    "follower_pressure_tangent", quadrature=quadrature.follower_degree, constants={"p": SCALAR}, coefficients=("u",)
)
def follower_pressure_tangent(on: Setting, p: Any, u: Any) -> Any:
    return loads.follower_pressure_tangent(p, u, on.trial, on.test, on.hypothesis, on.ds)
