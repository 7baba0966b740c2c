# SPDX-License-Identifier: MIT
"""Parts of a residual in UFL: dead loads, its rule, and its strong form."""

from __future__ import annotations

from typing import Any

import ufl
from ufl.algorithms import expand_derivatives, expand_indices, extract_coefficients
from ufl.algorithms.apply_algebra_lowering import apply_algebra_lowering
from ufl.algorithms.map_integrands import map_integrand_dags
from ufl.classes import Argument, FixedIndex, Grad, ListTensor, Sum, Zero
from ufl.corealg.multifunction import MultiFunction
from ufl.corealg.traversal import unique_pre_traversal


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


class _Test(MultiFunction):  # type: ignore[misc]  # UFL has no types
    """Replaces the test function and its gradients by constant tensors; one of them is not zero."""

    def __init__(self, order: int, value: Any) -> None:
        super().__init__()
        self.order, self.value = order, value

    def expr(self, o: Any, *operands: Any) -> Any:
        return self.reuse_if_untouched(o, *operands)

    def terminal(self, o: Any) -> Any:
        return o

    def argument(self, o: Any) -> Any:
        return self.value if self.order == 0 else ufl.zero(o.ufl_shape)

    def indexed(self, o: Any, operand: Any, index: Any) -> Any:
        if isinstance(operand, ListTensor) and all(isinstance(i, FixedIndex) for i in index):  # known, and often zero
            for i in index:
                operand = operand[int(i)]
            return operand
        return self.reuse_if_untouched(o, operand, index)

    def grad(self, o: Any, *_: Any) -> Any:
        depth, inner = 0, o
        while isinstance(inner, Grad):
            depth, inner = depth + 1, inner.ufl_operands[0]
        if not isinstance(inner, Argument):
            return o
        return self.value if self.order == depth else ufl.zero(o.ufl_shape)


def _unit(shape: tuple[int, ...], at: tuple[int, ...]) -> Any:
    if not shape:
        return ufl.as_ufl(1.0)
    rows = [_unit(shape[1:], at[1:]) if i == at[0] else ufl.zero(shape[1:]) for i in range(shape[0])]
    return ufl.as_tensor(rows)


def _places(shape: tuple[int, ...]) -> list[tuple[int, ...]]:
    out: list[tuple[int, ...]] = [()]
    for n in shape:
        out = [(*p, i) for p in out for i in range(n)]
    return out


def gradient_order(form: ufl.Form) -> int:
    """Highest gradient of the test function in a form, 0 to 3 [1]."""
    order = 0
    for integral in form.integrals():
        for node in unique_pre_traversal(integral.integrand()):
            depth, inner = 0, node
            while isinstance(inner, Grad):
                depth, inner = depth + 1, inner.ufl_operands[0]
            if isinstance(inner, Argument):
                order = max(order, depth)
    return order


def has_gradient(form: ufl.Form, component: int) -> bool:
    """Whether the gradient of one component of the test function occurs in the integrals over cells.

    Args:
        form: residual.
        component: component of the test function, a vector or a scalar.
    """
    cells = [i for i in form.integrals() if i.integral_type() == "cell"]
    plain = expand_indices(expand_derivatives(apply_algebra_lowering(ufl.Form(cells))))
    argument = form.arguments()[0]
    shape, gdim = argument.ufl_shape, argument.ufl_function_space().ufl_domain().geometric_dimension()
    for axis in range(gdim):
        at = (component, axis) if shape else (axis,)
        test = _Test(1, _unit((*shape, gdim), at))
        for integral in plain.integrals():
            if not isinstance(map_integrand_dags(test, integral.integrand()), Zero):
                return True
    return False


def strong_form(form: ufl.Form, u: Any, exact: Any) -> Any:
    """Left-hand side of the differential equations that belong to a weak form, at given functions of the place.

    A residual int(s.v + P : grad v + M :. grad grad v) belongs to s - div P + div div M. The parts follow from
    the form itself, which is linear in its test function: P is its value where grad v is a unit tensor and v is zero.

    Args:
        form: residual, of which only the integrals over cells are read.
        u: its unknown.
        exact: expression of the place, of u's shape.

    Returns:
        Expression of u's shape.

    Raises:
        ValueError: a higher gradient of the test function than the second.
    """
    cells = [i for i in form.integrals() if i.integral_type() == "cell"]
    plain = expand_derivatives(apply_algebra_lowering(ufl.replace(ufl.Form(cells), {u: exact})))
    order = gradient_order(plain)
    if order > 2:
        raise ValueError(f"the form has gradients of the test function of order {order}")
    shape = u.ufl_shape
    gdim = u.ufl_function_space().ufl_domain().geometric_dimension()

    def part(depth: int, at: tuple[int, ...]) -> Any:
        """Sum over the integrals of the factor of one component of the test function's gradient."""
        test = _Test(depth, _unit(shape + (gdim,) * depth, at))
        return sum((map_integrand_dags(test, i.integrand()) for i in plain.integrals()), ufl.as_ufl(0.0))

    values = []
    for c in _places(shape):
        value = part(0, c)
        if order >= 1:
            value -= sum(ufl.Dx(part(1, (*c, j)), j) for j in range(gdim))
        if order >= 2:
            value += sum(ufl.Dx(ufl.Dx(part(2, (*c, j, k)), j), k) for j in range(gdim) for k in range(gdim))
        values.append(value)
    if not shape:
        return values[0]
    if len(shape) == 1:
        return ufl.as_vector(values)
    return ufl.as_tensor([values[i * shape[1] : (i + 1) * shape[1]] for i in range(shape[0])])
