# SPDX-License-Identifier: MIT
"""Precision of the element forces of explicit problems; docs/mixed_precision.md."""

from __future__ import annotations

from dolfinx import fem

from .. import compat
from ..materials import FULL, REDUCED, LinearElastic, Material, NeoHookean

DOUBLE, MIXED = "double", "mixed"
PRECISIONS = (DOUBLE, MIXED)

# The pressure of a cell has the round-off of float, times Lame's constant lambda. In shear stresses, which are as
# 1 - 2 nu smaller, it is up to 2 nu/(1 - 2 nu) of it: 99 at this limit, times 6e-8.
LARGEST_POISSON = 0.495


def check_precision(precision: str, u: fem.Function, material: Material | None) -> None:
    """Refuse what cannot be computed in mixed precision.

    Args:
        precision: of PRECISIONS.
        u: displacement function.
        material: material; None for a residual of one's own.

    Raises:
        ValueError: an unknown precision, or a problem that float is not for.
    """
    if precision not in PRECISIONS:
        raise ValueError(f"precision {precision!r} is unknown: use {DOUBLE!r} or {MIXED!r}")
    if precision == DOUBLE:
        return
    instead = f"; take precision={DOUBLE!r}"
    if material is None:
        raise ValueError(
            f"precision={MIXED!r} is for materials: nobody knows whether a residual of your own is a difference of "
            f"large numbers{instead}"
        )
    mesh = u.function_space.mesh
    cell, degree = mesh.topology.cell_name(), int(compat.coordinate_element(mesh).degree)
    if cell not in ("hexahedron", "tetrahedron") or degree != 1:
        raise ValueError(
            f"precision={MIXED!r} is for hexahedra and tetrahedra with straight edges, found {cell} cells of geometry "
            f"degree {degree}{instead}"
        )
    for _, m in material.parts():
        if type(m) not in (LinearElastic, NeoHookean):
            raise ValueError(
                f"precision={MIXED!r} is for LinearElastic and NeoHookean, found {type(m).__name__}: sums of small "
                f"increments, as of plastic strain, would be lost in float{instead}"
            )
        if m.integration not in (FULL, REDUCED):
            raise ValueError(
                f"precision={MIXED!r} is for integration={FULL!r} and {REDUCED!r}, found {m.integration!r}{instead}"
            )
        if m.nu > LARGEST_POISSON:
            raise ValueError(
                f"precision={MIXED!r} is for nu up to {LARGEST_POISSON}, found {m.nu:g}: the pressure of a body that "
                f"hardly changes its volume is a large number times a small one, whose round-off in float shears the "
                f"cells{instead}"
            )
