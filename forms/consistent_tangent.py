# SPDX-License-Identifier: MIT
"""Consistent tangent of laws with internal variables: the derivative of the internal forces of forms/inelastic.py.

The kernels of the internal force solve the local equations r(x; strain, history) = 0 and keep x. Here x and the history
are coefficients, and the implicit function theorem gives the derivative of x by the displacement:

    K d = dF/du d + dF/dx x',    x' = -(dr/dx)^-1 dr/du d.

Averages over a cell are differentiated as they stand, ufl.cell_avg of the derivative: in the kernel of a matrix they
are those of one column at a time, so that d is a coefficient, too (cpp/dolfinx_impact/operators/CellMatrix.h).
"""

from collections.abc import Sequence
from typing import Any

import ufl
from ufl.algorithms import expand_derivatives

from .cell_maximum import has_maximum
from .inelastic import UNKNOWN, Kinematics, PointResponse, Symbols, internal_force

DIRECTION = "direction of the tangent"  # of operators/CellMatrix.h: coefficient in the place of the trial function
LARGEST_INVERSE = 3  # UFL has closed forms of the inverse up to this size


def solve(A: Any, b: Sequence[Any]) -> list[Any]:
    """Solution of a small linear system of UFL expressions.

    Args:
        A: matrix, (n, n); for n > 3 its leading minors must not be zero, there are no row exchanges.
        b: right-hand side, (n).
    """
    n = len(b)
    if n <= LARGEST_INVERSE:
        inverse = ufl.inv(A)
        return [sum(inverse[i, j] * b[j] for j in range(n)) for i in range(n)]
    rows, right = [[A[i, j] for j in range(n)] for i in range(n)], list(b)
    for k in range(n):
        for i in range(k + 1, n):
            factor = rows[i][k] / rows[k][k]
            rows[i] = [rows[i][j] - factor * rows[k][j] if j > k else 0 for j in range(n)]
            right[i] = right[i] - factor * right[k]
    x: list[Any] = [0] * n
    for i in reversed(range(n)):
        x[i] = (right[i] - sum(rows[i][j] * x[j] for j in range(i + 1, n))) / rows[i][i]
    return x


def unknown_derivative(residual: Any, x: Any, u: Any, du: Any) -> Any:
    """Derivative of the local unknowns by the displacement.

    Args:
        residual: residual of the local equations, a UFL expression of x and u.
        x: local unknowns.
        u: displacement [L].
        du: its direction.
    """
    variable = ufl.variable(x)
    matrix = expand_derivatives(ufl.diff(ufl.replace(residual, {x: variable}), variable))
    change = expand_derivatives(ufl.derivative(residual, u, du))
    if not x.ufl_shape:
        return -change / matrix
    return -ufl.as_vector(solve(matrix, [change[i] for i in range(x.ufl_shape[0])]))


def consistent_tangent(
    u: Any, du: Any, v: Any, response: PointResponse, kinematics: Kinematics, symbols: Symbols, dx: Any
) -> Any:
    """Derivative of the internal virtual work in the direction du, at the history of the last step and the local
    unknowns of the present displacement.

    Args:
        u: displacement [L].
        du: its direction, a coefficient of the name DIRECTION.
        v: test function.
        response: the law.
        kinematics: strains that the law sees.
        symbols: its history and unknowns.
        dx: measure of the cells, of the symbols' quadrature degree.

    Raises:
        ValueError: the stress has a maximum over a cell.
    """
    update = kinematics.respond(response, u, symbols)
    if any(has_maximum(e) for e in (update.stress, update.residual) if e is not None):
        raise ValueError(
            "the stress of a law has a maximum over a cell, which has no derivative: static problems need one. "
            "Take ufl.cell_avg, or use the maximum of the committed history, or an ExplicitProblem"
        )
    force, x = internal_force(u, v, kinematics, update, dx), symbols.unknown
    tangent = ufl.derivative(force, u, du)
    if x is not None:
        tangent += ufl.derivative(force, x, unknown_derivative(update.residual, x, u, du))
    return tangent


def names_of(symbols: Symbols, du: Any) -> dict[Any, str]:
    """Names by which kernels of the tangent know what stands for history, unknowns and direction.

    Args:
        symbols: history and unknowns of the law.
        du: the direction.
    """
    names = {du: DIRECTION} | {symbol: name for name, symbol in symbols.history.items()}
    return names if symbols.unknown is None else names | {symbols.unknown: UNKNOWN}
