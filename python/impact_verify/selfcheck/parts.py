# SPDX-License-Identifier: MIT
"""Parts of a residual in UFL: dead loads, and its rule."""

from __future__ import annotations

from typing import Any

import ufl
from ufl.algorithms import extract_coefficients
from ufl.classes import Sum


def _summands(expression: Any) -> list[Any]:
    if isinstance(expression, Sum):
        return [s for o in expression.ufl_operands for s in _summands(o)]
    return [expression]


def split_dead_loads(form: ufl.Form, u: Any) -> tuple[ufl.Form, ufl.Form | None]:
    """Split a residual into what depends on u and the summands that do not: loads of fixed direction.

    Args:
        form: residual.
        u: its unknown.

    Returns:
        Internal part and dead loads; None without any.
    """
    inner: list[Any] = []
    dead: list[Any] = []
    for integral in form.integrals():
        for summand in _summands(integral.integrand()):
            (inner if u in extract_coefficients(summand) else dead).append(integral.reconstruct(summand))
    return ufl.Form(inner), ufl.Form(dead) if dead else None


def estimated_degree(form: ufl.Form) -> int | None:
    """Degree of the rule over cells, as written or as UFL estimates it; the largest of several [1].

    Args:
        form: residual.

    Returns:
        Degree; None where the rule is not that of a degree (points of functions, vertices).
    """
    data = ufl.algorithms.compute_form_data(form)
    degrees = []
    for part in data.integral_data:
        if part.integral_type != "cell":
            continue
        for integral in part.integrals:
            metadata = integral.metadata()
            if metadata.get("quadrature_rule", "default") not in ("default", "Gauss-Jacobi", "GLL"):
                return None
            degree = metadata.get("quadrature_degree", metadata.get("estimated_polynomial_degree"))
            if degree in (None, -1):
                degree = metadata.get("estimated_polynomial_degree")
            degrees.append(max(degree) if isinstance(degree, tuple) else int(degree))
    for c in form.coefficients():
        if getattr(c.ufl_function_space().ufl_element(), "has_custom_quadrature", False):
            return None
    return max(degrees) if degrees else None


def with_degree(form: ufl.Form, degree: int) -> ufl.Form:
    """The form with another rule over cells.

    Args:
        form: form.
        degree: degree of the rule [1].
    """
    integrals = []
    for i in form.integrals():
        if i.integral_type() == "cell":
            i = i.reconstruct(metadata={**i.metadata(), "quadrature_degree": degree})
        integrals.append(i)
    return ufl.Form(integrals)
