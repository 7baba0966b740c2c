# SPDX-License-Identifier: MIT
"""What cells with one point and hourglass control are for; docs/one_point.md."""

from __future__ import annotations

from typing import Any

from dolfinx.fem import Function

from .. import compat
from ..forms.one_point import CELLS
from ..inelastic import InelasticMaterial
from ..materials import NOT_AXISYMMETRIC, REDUCED, Material


def check_integration(u: Function, material: Material) -> None:
    """Refuse one point with hourglass control where it is not for, on this rank.

    Args:
        u: displacement function.
        material: material of the bodies.

    Raises:
        ValueError: other cells than quadrilaterals and hexahedra, a displacement or geometry of another degree than 1,
            or axisymmetric bodies.
    """
    if material.integration != REDUCED:
        return
    V, mesh = u.function_space, u.function_space.mesh
    cell, element = mesh.topology.cell_name(), V.element.basix_element
    degrees: tuple[Any, ...] = (element.degree, compat.coordinate_element(mesh).degree)
    if cell not in CELLS or degrees != (1, 1):
        raise ValueError(
            "integration='reduced' is for quadrilaterals and hexahedra of degree 1 with straight edges, found "
            f"{cell} cells, a displacement of degree {degrees[0]} and a geometry of degree {degrees[1]}: take "
            "integration='full'"
        )
    if material.hypothesis_on(mesh) == "axisymmetric":
        raise ValueError(NOT_AXISYMMETRIC)


def check_explicit(material: Material) -> None:
    """Refuse hourglass modes that flow in problems that are not explicit, on this rank.

    Args:
        material: material of the bodies.

    Raises:
        ValueError: a material with internal variables has one point.
    """
    if material.integration == REDUCED and any(isinstance(m, InelasticMaterial) for _, m in material.parts()):
        raise ValueError(
            "integration='reduced' of materials with internal variables is for ExplicitProblem: where hourglass modes "
            "begin and cease to flow Newton's method does not converge. Take integration='full' for static and "
            "implicit problems"
        )
