# SPDX-License-Identifier: MIT
"""Averages and maxima over a cell, ufl.cell_avg and cell_max of forms/cell_maximum.py, which FFCx does not know.

    cell_avg(e) = sum_q w_q |det J_q| e(x_q) / sum_q w_q |det J_q|,    cell_max(e) = max_q e(x_q),

with the points and weights of the form's own rule. With it, averaging is self-adjoint in every cell,

    sum_q w_q |det J_q| a cell_avg(b(v)) = sum_q w_q |det J_q| cell_avg(a) b(v),

so that an average of the test function becomes an average of its factor. What is left are averages of values; each is
replaced by a coefficient that stands for it, and a kernel computes them in loops over the points before its last one.
Maxima are of values only, and take part as averages do: "average" in names means both.
"""

from dataclasses import dataclass, field

import basix.ufl
import ufl
from ufl.algorithms.apply_algebra_lowering import apply_algebra_lowering
from ufl.algorithms.apply_derivatives import apply_derivatives
from ufl.corealg.map_dag import map_expr_dag
from ufl.corealg.multifunction import MultiFunction
from ufl.corealg.traversal import unique_pre_traversal

from ..cell_maximum import CellMax, check_derivatives


class WithoutVariables(MultiFunction):
    """Variables replaced by what they stand for, once derivatives have been taken."""

    expr = MultiFunction.reuse_if_untouched

    def variable(self, o, expression, label):
        return expression


def shared(expression):
    """The same expression, in which equal parts are one object.

    UFL's algorithms look parts up in sets. Parts that are equal but not one object are compared as trees, whose size
    doubles with every level that uses a part twice: derivatives of averages in a return mapping took minutes.
    """
    one, known, waiting = {}, {}, [expression]  # by id: the object that stands for an equal one; objects by their parts
    while waiting:
        o = waiting[-1]
        if id(o) in one:
            waiting.pop()
            continue
        missing = [op for op in o.ufl_operands if id(op) not in one]
        if missing:
            waiting.extend(missing)
            continue
        waiting.pop()
        operands = tuple(one[id(op)] for op in o.ufl_operands)
        if any(a is not b for a, b in zip(operands, o.ufl_operands)):
            o.ufl_operands = operands  # as UFL itself does when it finds two expressions equal
        key = o if o._ufl_is_terminal_ else (type(o), tuple(id(op) for op in operands))
        one[id(o)] = known.setdefault(key, o)
    return one[id(expression)]


def lowered(expression):
    """Without derivatives by variables or functions."""
    expression = apply_derivatives(shared(apply_algebra_lowering(shared(expression))))
    return map_expr_dag(WithoutVariables(), shared(expression))


def _nodes(expression):
    return unique_pre_traversal(expression)


def has_averages(expression):
    """Does an expression have an average or a maximum over a cell?"""
    return any(isinstance(o, (ufl.classes.CellAvg, CellMax)) for o in _nodes(expression))


@dataclass
class Average:
    """A value that is the same at all points of a cell.

    Attributes:
        coefficient: stands for it in expressions.
        operand: what is averaged, without averages.
        maximum: is it the maximum instead?
        loop: number of the loop over the points that sums it up.
        solved: does it depend on the solution of the local equations?
    """

    coefficient: ufl.Coefficient
    operand: ufl.core.expr.Expr
    maximum: bool
    loop: int
    solved: bool


@dataclass
class Averages:
    """The averages of one integral.

    Args:
        mesh: UFL mesh.
        unknown: coefficient of the local unknowns, or None.
    """

    mesh: object
    unknown: object = None
    found: dict = field(default_factory=dict)  # (operand, is it a maximum?) -> Average

    def __bool__(self):
        return bool(self.found)

    @property
    def coefficients(self):
        """Number of each coefficient that stands for an average."""
        return {a.coefficient: i for i, a in enumerate(self.found.values())}

    def placeholder(self, shape):
        """A new coefficient that is constant in a cell."""
        element = basix.ufl.element("DG", str(self.mesh.ufl_cell()), 0, shape=shape)
        return ufl.Coefficient(ufl.FunctionSpace(self.mesh, element))

    def of(self, operand, maximum=False):
        """The coefficient that stands for the average, or the maximum, of an expression without averages."""
        if (operand, maximum) not in self.found:
            inner = self.needed([operand])
            solved = self.unknown in ufl.algorithms.extract_coefficients(operand) or any(a.solved for a in inner)
            loop = 1 + max((a.loop for a in inner), default=-1)
            coefficient = self.placeholder(operand.ufl_shape)
            self.found[operand, maximum] = Average(coefficient, operand, maximum, loop, solved)
        return self.found[operand, maximum].coefficient

    def needed(self, expressions):
        """Averages that expressions contain."""
        present = {c for e in expressions for c in ufl.algorithms.extract_coefficients(e)}
        return [a for a in self.found.values() if a.coefficient in present]

    def select(self, coefficients):
        """The averages that stand among some coefficients, and those that they are made of."""
        chosen, wanted = {}, set(coefficients)
        for key, average in reversed(self.found.items()):  # an average is found after those it is made of
            if average.coefficient in wanted:
                chosen[key] = average
                wanted |= set(ufl.algorithms.extract_coefficients(average.operand))
        return Averages(self.mesh, self.unknown, dict(reversed(chosen.items())))

    def read(self):
        """Coefficients that the averages are made of."""
        found = {c for a in self.found.values() for c in ufl.algorithms.extract_coefficients(a.operand)}
        return found - set(self.coefficients) - {self.unknown}

    def replaced(self, expression):
        """An expression with its averages replaced by coefficients; it must have no test function."""
        check_derivatives(expression)
        return map_expr_dag(_Replace(self), expression)

    def of_integrand(self, integrand):
        """An integrand of rank 0 or 1 without averages: those of the test function moved to their factors."""
        check_derivatives(integrand)
        if any(isinstance(o, ufl.classes.CoefficientDerivative) for o in _nodes(integrand)):
            integrand = lowered(map_expr_dag(_ReplaceMaxima(self), integrand))
        separate = _Replace(self)
        integrand = map_expr_dag(separate, integrand)
        if not separate.arguments:
            return integrand
        (v,) = ufl.algorithms.extract_arguments(next(iter(separate.arguments)))
        nothing = {b: ufl.zero(b.ufl_shape) for b in separate.arguments.values()}
        result = ufl.replace(integrand, nothing)
        for operand, b in separate.arguments.items():
            # The integrand is linear in test function and averages together: its derivative by one is the factor.
            x = ufl.variable(b)
            factor = ufl.replace(integrand, nothing | {b: x, v: ufl.zero(v.ufl_shape)})
            result += ufl.inner(self.of(lowered(ufl.diff(factor, x))), operand)
        return result


class _ReplaceMaxima(MultiFunction):
    """Maxima -> coefficients."""

    expr = MultiFunction.reuse_if_untouched

    def __init__(self, averages):
        super().__init__()
        self.averages = averages

    def cell_max(self, o, operand):
        if operand.ufl_free_indices:
            raise ValueError(f"cell_max of an expression with free indices is not supported: {o}")
        if ufl.algorithms.extract_arguments(operand):
            raise ValueError(f"cell_max of a test function is not linear in it: {o}")
        if any(isinstance(n, ufl.classes.CellAvg) for n in _nodes(operand)):
            operand = self.averages.replaced(operand)
        return self.averages.of(operand, maximum=True)


class _Replace(_ReplaceMaxima):
    """Averages -> coefficients, inner ones first. Those of a test function are kept apart, in `arguments`."""

    def __init__(self, averages):
        super().__init__(averages)
        self.arguments = {}

    def cell_avg(self, o, operand):
        if operand.ufl_free_indices:
            raise ValueError(f"cell_avg of an expression with free indices is not supported: {o}")
        if set(ufl.algorithms.extract_coefficients(operand)) & set(self.arguments.values()):
            raise ValueError(f"cell_avg of an average of the test function is not supported: {o}")
        if not ufl.algorithms.extract_arguments(operand):
            return self.averages.of(operand)
        if operand not in self.arguments:
            self.arguments[operand] = self.averages.placeholder(operand.ufl_shape)
        return self.arguments[operand]
