# SPDX-License-Identifier: MIT
"""Fields that a user gives as UFL expressions: the stress of a residual of one's own, a temperature, ..."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import ufl
from dolfinx.fem import FunctionSpace

from ..assembly.cauchy_stress import VON_MISES, von_mises
from ..forms.elasticity import STRESS
from ..forms.materials import stress_components
from ..assembly.fields import is_mixed
from ..assembly.history_field import HistoryField
from ..assembly.inelastic_part import quadrature_element
from ..assembly.operators import PointValues


def check_expressions(given: Any) -> dict[str, Any]:
    """Check expressions by name, on this rank.

    Args:
        given: the argument `expressions` of `record`; None: none.

    Returns:
        Expressions by name.

    Raises:
        TypeError: it is no dict from names to UFL expressions.
        ValueError: "von_mises", which follows from "stress"; or a stress that is no 3 x 3 tensor.
    """
    if given is None:
        return {}
    if not isinstance(given, Mapping):
        raise TypeError(f"expressions must be a dict, name -> UFL expression, found {type(given).__name__}")
    for name, expression in given.items():
        if not isinstance(name, str) or not name:
            raise TypeError(f"expressions: a name must be a text, found {name!r:.60}")
        if not isinstance(expression, ufl.core.expr.Expr):
            raise TypeError(f"expressions: {name} must be a UFL expression, found {type(expression).__name__}")
        if len(expression.ufl_shape) > 2:
            raise ValueError(f"expressions: {name} has the shape {expression.ufl_shape}: give a number, vector, tensor")
    if VON_MISES in given:
        raise ValueError('expressions: von_mises follows from the stress: give "stress", the Cauchy stress')
    if STRESS in given and given[STRESS].ufl_shape != (3, 3):
        raise ValueError(
            f"expressions: stress has the shape {given[STRESS].ufl_shape}: give the Cauchy stress as a 3 x 3 tensor, "
            "with the stress across the plane at [2, 2]"
        )
    return dict(given)


def known_names(expressions: Mapping[str, Any]) -> list[str]:
    """Names of the fields that expressions give.

    Args:
        expressions: expressions by name.
    """
    return [*expressions, VON_MISES] if STRESS in expressions else list(expressions)


def expression_field(name: str, expressions: Mapping[str, Any], V: FunctionSpace) -> HistoryField:
    """Field of an expression. Collective.

    Args:
        name: name of the field, one of `known_names`.
        expressions: expressions by name.
        V: space of the displacement, whose mesh and degree count.

    Returns:
        The field; a stress has the components of those of materials.
    """
    # Two for each degree of the displacement, as the stiffness has; fields of a mixed space are seldom above degree 2.
    mesh, degree = V.mesh, 2 * max(1, 2 if is_mixed(V) else V.element.basix_element.degree)
    if name == VON_MISES:
        stress = expression_field(STRESS, expressions, V)
        return HistoryField(name, (), degree, mesh, lambda: von_mises(stress.values)[..., None])
    expression = expressions[name]
    shape = expression.ufl_shape
    if name == STRESS:
        expression = ufl.as_vector([expression[i, j] for i, j in stress_components(mesh.geometry.dim)])
        shape = expression.ufl_shape
    size = math.prod(shape)
    points, _ = quadrature_element(mesh, (), degree).custom_quadrature()
    return HistoryField(name, (size,) if shape else (), degree, mesh, PointValues(expression, points).values)
