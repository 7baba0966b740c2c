# SPDX-License-Identifier: MIT
"""Rolling in the ALE frame: gyroscopic matrix, inertia, centrifugal load and the balance of momentum."""

from collections.abc import Callable
from typing import Any

from .. import ale, quadrature
from ..materials import LinearElastic
from ..registration import AXIAL, SCALAR, VECTOR, Setting, registered

SPIN = {"spin": AXIAL, "centre": VECTOR, "density": SCALAR}


def _spinning(name: str, **more: Any) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    reason = "a body that spins about z is not axisymmetric in the (r, z) plane"
    options = {"constants": SPIN, **more}
    return registered(name, quadrature=quadrature.mass_degree, excluded={"axisymmetric": reason}, **options)


@_spinning("gyroscopic")
def gyroscopic(on: Setting, spin: Any, centre: Any, density: Any) -> Any:
    return ale.gyroscopic(on.trial, on.test, density, ale.convection(on.mesh, spin, centre), on.dx)


@_spinning("ale_inertia")
def ale_inertia(on: Setting, spin: Any, centre: Any, density: Any) -> Any:
    return ale.ale_inertia(on.trial, on.test, density, ale.convection(on.mesh, spin, centre), on.dx)


@_spinning("centrifugal_load")
def centrifugal_load(on: Setting, spin: Any, centre: Any, density: Any) -> Any:
    return ale.centrifugal_load(on.test, density, ale.convection(on.mesh, spin, centre), on.dx)


@_spinning(
    "momentum_balance",
    constants=SPIN | {"E": SCALAR, "nu": SCALAR, "f": VECTOR},
    coefficients=("u", "velocity", "acceleration"),
)
def momentum_balance(
    on: Setting,
    spin: Any,
    centre: Any,
    density: Any,
    E: Any,
    nu: Any,
    f: Any,
    u: Any,
    velocity: Any,
    acceleration: Any,
) -> Any:
    law, w = LinearElastic(E, nu, on.hypothesis), ale.convection(on.mesh, spin, centre)
    return ale.momentum_balance(u, velocity, acceleration, on.test, law, density, w, f, on.dx)
