# SPDX-License-Identifier: MIT
"""Derivatives by the reference coordinates in forms, which UFL has below the forms that people write.

UFL pulls functions back to the reference cell late, after it has taken derivatives, and refuses a form that has been
pulled back already. `PulledBack` stands for a pulled back function until then, and becomes one at that step. FFCx and
our compiler see nothing but UFL's own types.
"""

from typing import Any

import ufl
from ufl.algorithms.transformer import Transformer
from ufl.classes import ReferenceGrad, ReferenceValue
from ufl.core.ufl_type import ufl_type
from ufl.corealg.multifunction import MultiFunction
from ufl.corealg.traversal import unique_pre_traversal

# UFL numbers types in the order in which they are made, and signatures of forms have the numbers: CellMax comes first.
from . import cell_maximum  # noqa: F401


@ufl_type()
class PulledBack(ReferenceValue):
    """A function, or a test or trial function, on the reference cell, of an element that is mapped by identity."""

    __slots__ = ()

    def _ufl_expr_reconstruct_(self, operand: Any) -> Any:
        return operand if isinstance(operand, ReferenceValue) else PulledBack(operand)


# UFL's algorithms keep a list of handlers by type, which they make once: those made before this type are too short.
for _algorithms in (MultiFunction, Transformer):
    _algorithms._handlers_cache.clear()


def has_reference_derivatives(expression: Any) -> bool:
    """Does an expression have derivatives by the reference coordinates that `reference_derivatives` made?"""
    return any(isinstance(o, PulledBack) for o in unique_pre_traversal(expression))


def reference_derivatives(field: Any, order: int) -> Any:
    """Derivatives of a field by the reference coordinates.

    Args:
        field: function of a Lagrange space, test or trial function, sum of such with factors, or SpatialCoordinate.
        order: order of the derivatives, at least 1.

    Returns:
        UFL tensor: indices of the field's components first, then one for each derivative.
    """
    if isinstance(field, ufl.classes.Sum):
        first, second = (reference_derivatives(o, order) for o in field.ufl_operands)
        return first + second
    value = field if isinstance(field, ufl.SpatialCoordinate) else PulledBack(field)
    for _ in range(order):
        value = ReferenceGrad(value)
    return value


def constants_for_positions(expression: Any) -> dict[Any, ufl.Constant]:
    """Constants in the place of derivatives of the position by the reference coordinates, which UFL's derivative by a
    variable refuses. `ufl.replace` puts them in, and after the derivative has been taken the other way round.

    Args:
        expression: UFL expression.

    Returns:
        Constant of each derivative, of those of higher orders, too.
    """
    found: dict[Any, ufl.Constant] = {}
    for o in unique_pre_traversal(expression):
        if not isinstance(o, ReferenceGrad):
            continue
        root = o
        while isinstance(root, ReferenceGrad):
            (root,) = root.ufl_operands
        if isinstance(root, ufl.SpatialCoordinate):
            found[o] = ufl.Constant(ufl.domain.extract_unique_domain(o), shape=o.ufl_shape)
    return found
