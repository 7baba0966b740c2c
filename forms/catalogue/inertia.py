# SPDX-License-Identifier: MIT
"""Mass matrix, its action, and lumped masses."""

from typing import Any

from .. import inertia, quadrature
from ..registration import SCALAR, Setting, registered

DENSITY = {"density": SCALAR}


@registered("mass", quadrature=quadrature.mass_degree, constants=DENSITY)
def mass(on: Setting, density: Any) -> Any:
    return inertia.mass(on.trial, on.test, density, on.hypothesis, on.dx)


@registered("mass_action", quadrature=quadrature.mass_degree, constants=DENSITY, coefficients=("u",))
def mass_action(on: Setting, density: Any, u: Any) -> Any:
    return inertia.mass(u, on.test, density, on.hypothesis, on.dx)


@registered("row_sum", quadrature=quadrature.mass_degree, constants=DENSITY)
def row_sum(on: Setting, density: Any) -> Any:
    return inertia.row_sum(on.test, density, on.hypothesis, on.dx)


@registered(
    "nodal_mass",
    quadrature=quadrature.nodal_degree,
    constants=DENSITY,
    rule="GLL",
    cells=("quadrilateral", "hexahedron"),
    cells_reason="simplices have no positive rule at the nodes of degree 2; use HRZ lumping",
)
def nodal_mass(on: Setting, density: Any) -> Any:
    return inertia.row_sum(on.test, density, on.hypothesis, on.dx)
