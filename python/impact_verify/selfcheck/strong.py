# SPDX-License-Identifier: MIT
"""From a weak form to its differential equations: loads with which a given function is the solution."""

from __future__ import annotations

from typing import Any

import ufl
from ufl.algorithms import expand_derivatives, expand_indices
from ufl.algorithms.apply_algebra_lowering import apply_algebra_lowering
from ufl.algorithms.map_integrands import map_integrand_dags
from ufl.classes import Argument, FixedIndex, Grad, ListTensor, Zero
from ufl.corealg.multifunction import MultiFunction
from ufl.corealg.traversal import unique_pre_traversal

from dolfinx_impact import compat


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
    shape, gdim = argument.ufl_shape, compat.geometric_dimension(argument.ufl_function_space().ufl_domain())
    for axis in range(gdim):
        at = (component, axis) if shape else (axis,)
        test = _Test(1, _unit((*shape, gdim), at))
        for integral in plain.integrals():
            if not isinstance(map_integrand_dags(test, integral.integrand()), Zero):
                return True
    return False


def _slope(expression: Any, axis: int) -> Any:
    """Derivative by a coordinate; zero of constants, which UFL does not know on which mesh they are."""
    return ufl.Dx(expression, axis) if ufl.domain.extract_domains(expression) else ufl.as_ufl(0.0)


def load_of(form: ufl.Form, u: Any, exact: Any, degree: int, boundary: bool) -> ufl.Form:
    """Virtual work of the loads with which a given function is the solution of a weak form.

    A residual int(s.v + P : grad v + M :. grad grad v) belongs to the equations s - div P + div div M = f. The factors
    follow from the form itself, which is linear in its test function: P is its value where grad v is a unit tensor and
    v is zero. Integrals between cells vanish for a smooth function, if the form is consistent.

    Args:
        form: residual.
        u: its unknown.
        exact: expression of the place, of u's shape.
        degree: degree of the rules of the loads [1].
        boundary: whether test functions do not vanish on the boundary, or their slopes matter there.

    Returns:
        Form of rank 1: loads in cells; on the boundary tractions, and the form's own integrals there.

    Raises:
        ValueError: a higher gradient of the test function than the second.
    """
    mesh, v = u.function_space.mesh, ufl.TestFunction(u.function_space)
    cells = [i for i in form.integrals() if i.integral_type() == "cell"]
    plain = expand_derivatives(apply_algebra_lowering(ufl.replace(ufl.Form(cells), {u: exact})))
    order = gradient_order(plain)
    if order > 2:
        raise ValueError(f"the form has gradients of the test function of order {order}")
    shape, gdim = u.ufl_shape, mesh.geometry.dim

    def factor(depth: int, at: tuple[int, ...]) -> Any:
        """Factor of one component of a gradient of the test function."""
        test = _Test(depth, _unit(shape + (gdim,) * depth, at))
        return sum((map_integrand_dags(test, i.integrand()) for i in plain.integrals()), ufl.as_ufl(0.0))

    n, axes = ufl.FacetNormal(mesh), range(gdim)
    inside, outside = ufl.as_ufl(0.0), ufl.as_ufl(0.0)
    for c in _places(shape):
        w = v[c] if shape else v
        inside += factor(0, c) * w
        for j in axes if order >= 1 else ():
            P = factor(1, (*c, j))
            inside -= _slope(P, j) * w
            outside += P * n[j] * w
            for k in axes if order >= 2 else ():
                M = factor(2, (*c, j, k))
                inside += _slope(_slope(M, k), j) * w
                outside += M * n[k] * ufl.Dx(w, j) - _slope(M, k) * n[j] * w
    metadata = {"quadrature_degree": degree}
    load = inside * ufl.Measure("dx", domain=mesh, metadata=metadata)
    if boundary:
        load += outside * ufl.Measure("ds", domain=mesh, metadata=metadata)
        own = [i for i in form.integrals() if i.integral_type() == "exterior_facet"]
        load += ufl.replace(ufl.Form(own), {u: exact})
    return load
