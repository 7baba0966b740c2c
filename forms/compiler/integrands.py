# SPDX-License-Identifier: MIT
"""Quadrature rules and integrands in the representation of FFCx's releases."""

from __future__ import annotations

from typing import Any


def integrands(ir: Any) -> list[tuple[Any, Any]]:
    """Quadrature rules of FFCx's representation of an integral or expression, each with the graph of its integrand.

    From 0.10 on FFCx keys them by the type of cell as well, which differs between rules only where the facets of one
    cell are of several types.
    """
    return [(key[1] if isinstance(key, tuple) else key, graph) for key, graph in ir.integrand.items()]
