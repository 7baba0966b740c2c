# SPDX-License-Identifier: MIT
"""Maximum over a cell, beside ufl.cell_avg: an operator of our own, which our compiler knows.

    cell_max(e) = max_q e(x_q)

over the points of the form's own rule, of each component by itself. It may stand wherever ufl.cell_avg may: in
integrals over cells of forms of rank 0 and 1, and in point laws. It is the same at all points of a cell. It has no
derivative (it has corners, where another point takes over): a form or law that would need one is refused. DOLFINx and
FFCx do not know it.
"""

from typing import Any

import ufl
from ufl.algorithms.transformer import Transformer
from ufl.constantvalue import ConstantValue
from ufl.core.operator import Operator
from ufl.core.ufl_type import ufl_type
from ufl.corealg.multifunction import MultiFunction
from ufl.corealg.traversal import unique_pre_traversal


@ufl_type(inherit_shape_from_operand=0, inherit_indices_from_operand=0, num_ops=1, is_evaluation=True)
class CellMax(Operator):
    """Maximum over a cell; see `cell_max`."""

    __slots__ = ()

    def __new__(cls, operand: Any) -> Any:
        return operand if isinstance(operand, ConstantValue) else Operator.__new__(cls)

    def __init__(self, operand: Any) -> None:
        Operator.__init__(self, (operand,))

    def __str__(self) -> str:
        return f"cell_max({self.ufl_operands[0]})"


# UFL's algorithms keep a list of handlers by type, which they make once: those made before this type are too short.
for _algorithms in (MultiFunction, Transformer):
    _algorithms._handlers_cache.clear()


def cell_max(expression: Any) -> Any:
    """Largest value of an expression at the points of a cell.

    Args:
        expression: UFL expression without test and trial functions and without free indices, of any shape.

    Returns:
        UFL expression of the same shape, the maximum of each component.
    """
    return CellMax(ufl.as_ufl(expression))


def has_maximum(expression: Any) -> bool:
    """Does an expression have a maximum over a cell?"""
    return any(isinstance(o, CellMax) for o in unique_pre_traversal(expression))


def check_derivatives(expression: Any) -> None:
    """Refuse derivatives of a maximum over a cell.

    Args:
        expression: UFL expression whose derivatives have not been taken yet.

    Raises:
        ValueError: an expression in a derivative has a maximum of what it is differentiated by.
    """
    for node in unique_pre_traversal(expression):
        if isinstance(node, ufl.classes.CoefficientDerivative):
            by = set(ufl.algorithms.extract_coefficients(node.ufl_operands[1]))
        elif isinstance(node, ufl.classes.VariableDerivative):
            by = {node.ufl_operands[1]}
        else:
            continue
        for inner in unique_pre_traversal(node.ufl_operands[0]):
            if isinstance(inner, CellMax) and any(o in by for o in unique_pre_traversal(inner)):
                raise ValueError(
                    f"{inner} has no derivative: a maximum over a cell has corners. Differentiate the rest, or take "
                    "ufl.cell_avg"
                )
