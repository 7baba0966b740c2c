# SPDX-License-Identifier: MIT
"""Residuals written by the gradient of their test function, as a stress times it.

The derivative of an energy in the direction v has grad(v) at many places, within derivatives of invariants. What is
linear in grad(v) is

    I(grad v) = P : grad v,    P = dI / d(grad v),

and in this form the kernel multiplies a stress by the inverse Jacobian once, instead of each of the places.
"""

import ufl
from ufl.algorithms.apply_algebra_lowering import apply_algebra_lowering
from ufl.algorithms.apply_derivatives import apply_derivatives
from ufl.corealg.map_dag import map_expr_dag
from ufl.corealg.multifunction import MultiFunction
from ufl.corealg.traversal import unique_pre_traversal

from ..quadrature import with_rules


class _Replaced(MultiFunction):
    """Gradient of the test function replaced by an expression."""

    expr = MultiFunction.reuse_if_untouched

    def __init__(self, expression):
        super().__init__()
        self.expression = expression

    def grad(self, o):
        return self.expression if _is_test_gradient(o) else o


def by_test_gradient(form, wanted=lambda integral: True):
    """A form of rank 1 of the same value, with the same quadrature rules, whose integrals over cells are a stress times
    the gradient of the test function, where they are wanted; or the form itself where this is nothing new."""
    if len(form.arguments()) != 1:
        return form
    integrals, found = [], False
    for integral in with_rules(form).integrals():  # the rules belong to the integrand as it was written
        is_cell = integral.integral_type() == "cell"
        stress = _stress(integral.integrand()) if is_cell and wanted(integral) else None
        if stress is not None:
            integral, found = integral.reconstruct(integrand=stress), True
        integrals.append(integral)
    written = ufl.Form(integrals)
    same = written.coefficients() == form.coefficients() and written.constants() == form.constants()
    return written if found and same else form


def _is_test_gradient(o):
    return isinstance(o, ufl.classes.Grad) and isinstance(o.ufl_operands[0], ufl.Argument)


def _terms(expression):
    """Terms of a sum."""
    if isinstance(expression, ufl.classes.Sum):
        return [term for o in expression.ufl_operands for term in _terms(o)]
    return [expression]


def _stress(integrand):
    """Sum of the terms without grad v and of P : grad v, or None where this is nothing new."""
    own, others = [], []
    for term in _terms(integrand):
        nodes = list(unique_pre_traversal(term))
        gradients = [o for o in nodes if _is_test_gradient(o)]
        arguments = [o for n in nodes for o in n.ufl_operands if isinstance(o, ufl.Argument)]
        of_gradients = [o for n in nodes for o in n.ufl_operands if o in gradients]
        higher = any(isinstance(o, ufl.classes.Grad) and o.ufl_operands[0] in gradients for o in nodes)
        if len(gradients) == 1 == len(arguments) and len(of_gradients) > 1 and not higher:
            own.append(term)
        else:
            others.append(term)
    if not own:
        return None
    (gradient,) = {o for term in own for o in unique_pre_traversal(term) if _is_test_gradient(o)}
    direction = ufl.Constant(ufl.domain.extract_unique_domain(gradient), shape=gradient.ufl_shape)
    variable = ufl.variable(direction)
    replaced = map_expr_dag(_Replaced(variable), sum(own[1:], own[0]))
    stress = apply_derivatives(apply_algebra_lowering(ufl.diff(replaced, variable)))
    if any(o == direction for o in unique_pre_traversal(stress)):
        return None
    return sum(others, ufl.inner(stress, gradient))
