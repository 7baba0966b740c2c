# SPDX-License-Identifier: MIT
"""Poisson's problem: stiffness and weighted residual."""

from typing import Any

from .. import galerkin, quadrature
from ..registration import SCALAR, Setting, registered


@registered("poisson", quadrature=quadrature.stiffness_degree, constants={"k": SCALAR}, scalar=True)
def poisson(on: Setting, k: Any) -> Any:
    return galerkin.flux(on.trial, on.test, k, on.dx)


@registered(
    "poisson_residual",
    quadrature=quadrature.mass_degree,
    constants={"k": SCALAR, "f": SCALAR, "q": SCALAR},
    coefficients=("u",),
    scalar=True,
)
def poisson_residual(on: Setting, k: Any, f: Any, q: Any, u: Any) -> Any:
    return galerkin.weighted_residual(u, on.test, k, f, q, on.dx, on.ds)
