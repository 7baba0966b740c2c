# SPDX-License-Identifier: MIT
"""Calls of UFL and FFCx that are spelled otherwise in one of the releases of FEniCSx that this package knows: 0.9, 0.10, 0.11.

This file stands beside the forms because the form compiler runs before the package is installed; DOLFINx's own calls are
in dolfinx_impact.compat.
"""

from __future__ import annotations

from typing import Any


def _value(member: Any) -> Any:
    """Value of what is a method in one release and a property in another."""
    return member() if callable(member) else member


def cell_name(cell: Any) -> str:
    """Name of a UFL cell, for instance "triangle"."""
    return str(_value(cell.cellname))


def topological_dimension(domain: Any) -> int:
    """Topological dimension of a UFL cell or mesh."""
    return int(_value(domain.topological_dimension))


def geometric_dimension(domain: Any) -> int:
    """Number of coordinates of a point of a UFL mesh."""
    return int(_value(domain.geometric_dimension))


def integrands(ir: Any) -> list[tuple[Any, Any]]:
    """Quadrature rules of FFCx's representation of an integral or expression, each with the graph of its integrand.

    From 0.10 on the rules are keyed by the type of cell as well, which only differs between rules where the facets of
    one cell are of several types.
    """
    return [(key[1] if isinstance(key, tuple) else key, graph) for key, graph in ir.integrand.items()]
