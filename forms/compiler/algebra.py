# SPDX-License-Identifier: MIT
"""Second stage: scalar algebra on FFCx's factorised graph.

Every scalar is a pair (number, node): number times node, node None standing for 1. Nodes are shared (hash-consed), sums
and products are kept in one canonical order, like terms are collected and common factors taken out. So the cofactors of
the Jacobian, a symmetric stress computed twice, or a reciprocal used nine times appear once in the kernel.
"""

from collections import Counter

import numpy as np
import ufl

from .words import in_words

# What a value depends on: constants only, the cell, averages over it, the quadrature point, the solution of the local
# equations there, or their iterate. A value is computed before the loops over what it does not depend on: a logarithm
# of an average before the loop over the points, what does not depend on the iterate before the iteration.
CONSTANT, CELL, AVERAGED, POINT, SOLVED, ITERATE = range(6)
# Integer powers up to this are products; their error grows with the number of factors, that of a logarithm does not.
LARGEST_POWER = 16


class Node:
    """A shared scalar expression: kind "symbol", "sum", "product", "call" or "select".

    Attributes:
        unknowns: symbols it depends on that are no geometry: values of coefficients and constants.
    """

    __slots__ = ("kind", "data", "level", "number", "unknowns")

    def __init__(self, kind, data, level, number):
        self.kind, self.data, self.level, self.number = kind, data, level, number
        if kind == "symbol":
            self.unknowns = frozenset() if _is_geometry(data) else frozenset((data,))
        else:
            self.unknowns = frozenset().union(*(child.unknowns for child in children(self)))


def _is_geometry(key):
    """Is a symbol of the kernel (KernelWriter) a table, a number of the rule, or made of the cell's coordinates?"""
    return key[0] in ("table", "weight", "facet") or "x" in key


class Algebra:
    """Factory of shared nodes.

    Args:
        take_out_reciprocals: whether a reciprocal of the geometry (1 / det J) that all terms of a sum have is taken out
            of it. Where values are linear in the sum, one product is left of several; otherwise each power of it has a
            power of the reciprocal.
    """

    def __init__(self, take_out_reciprocals=True):
        self._nodes = {}
        self._fractions = {}  # value -> powers of it between -1 and 1
        self._numbers = {}  # rounded -> number
        self._take_out_reciprocals = take_out_reciprocals

    def _intern(self, kind, data, level):
        key = (kind, data)
        node = self._nodes.get(key)
        if node is None:
            node = self._nodes[key] = Node(kind, data, level, len(self._nodes))
        return node

    def symbol(self, key, level):
        """A value the kernel reads or computes elsewhere, named by `key`."""
        return (1.0, self._intern("symbol", key, level))

    @staticmethod
    def number(x):
        return (float(x), None)

    # -- products ---------------------------------------------------------------------------------------------------
    @staticmethod
    def _powers(node):
        if node is None:
            return {}
        return dict(node.data) if node.kind == "product" else {node: 1}

    def powers(self, value):
        """Exponents of the factors that a value is the product of, its number aside."""
        return self._powers(value[1])

    def _product(self, powers):
        items = tuple(sorted(((n, p) for n, p in powers.items() if p), key=lambda t: t[0].number))
        if not items:
            return None
        if len(items) == 1 and items[0][1] == 1:
            return items[0][0]
        return self._intern("product", items, max(n.level for n, _ in items))

    def multiply(self, a, b):
        if a[0] == 0.0 or b[0] == 0.0:
            return (0.0, None)
        powers = self._powers(a[1])
        for n, p in self._powers(b[1]).items():
            powers[n] = powers.get(n, 0) + p
        return (a[0] * b[0], self._product(powers))

    def power(self, a, exponent):
        """a to the power of a number.

        An integer power of the same sign is taken out, what is left is a root where it can be one: so x^(-2/3),
        x^(-5/3) and x^(-8/3) share a root, and x^1.7 has the same x^0.7 as its derivative. Of the same sign, so that 0
        has the power it should have, and no factor overflows where the product does not.
        """
        number, node = a
        if node is None and number <= 0.0 and not float(exponent).is_integer():
            return self.call("power", a, self.number(exponent))
        if node is None:
            return self.number(number**exponent)
        if abs(exponent) > LARGEST_POWER:
            if exponent % 2.0 == 1.0:
                return self.multiply(a, self.power(a, exponent - 1.0))
            return self.call("power", self.call("abs", a) if exponent % 2.0 == 0.0 else a, self.number(exponent))
        if float(exponent).is_integer():
            n = int(exponent)
            return (number**n, self._product({m: p * n for m, p in self._powers(node).items()}))
        if 2 * exponent == int(2 * exponent):  # halves: a square root and an integer power
            return self.power(self.call("sqrt", a), int(2 * exponent))
        if abs(number) != 1.0:
            sign = float(np.sign(number))
            return self.multiply(self.number(abs(number) ** exponent), self.power((sign, node), exponent))
        whole = int(exponent)
        return self.multiply(self.power(a, whole), self._root(a, exponent - whole, 4 * np.spacing(abs(exponent))))

    def _root(self, a, fraction, rounding):
        """a to a power between -1 and 1 that is known up to its rounding."""
        for denominator in (3, 4, 6):
            numerator = round(denominator * fraction)
            if abs(fraction - numerator / denominator) > rounding:
                continue
            if denominator == 3:
                return self.call("power", a, self.number(numerator / 3))
            return self.power(self.call("sqrt", self.power(a, 2 / denominator)), numerator)
        known = self._fractions.setdefault(a, [])
        found = next((f for f in known if abs(f - fraction) <= rounding), None)
        if found is None:
            known.append(fraction)
        return self.call("power", a, self.number(fraction if found is None else found))

    # -- sums -------------------------------------------------------------------------------------------------------
    def open_sum(self, *values):
        """Terms {node: number} of a sum that may still grow."""
        terms = {}
        for v in values:
            for node, c in v.items() if isinstance(v, dict) else ((v[1], v[0]),):
                terms[node] = terms.get(node, 0.0) + c
        return terms

    def close_sum(self, terms):
        """Canonical value of a sum: common monomial and common number taken out."""
        terms = {n: c for n, c in terms.items() if c != 0.0}
        if not terms:
            return (0.0, None)
        if len(terms) == 1:
            ((node, c),) = terms.items()
            return (c, node)
        monomials = {n: self._powers(n) for n in terms}
        first, *others = monomials.values()
        common = {}
        for base, p in first.items():
            ps = [p] + [m.get(base, 0) for m in others]
            if all(q > 0 for q in ps):
                common[base] = min(ps)
            elif all(q < 0 for q in ps) and (self._take_out_reciprocals or base.unknowns):
                common[base] = max(ps)
        if common:
            reduced = {}
            for n, c in terms.items():
                powers = monomials[n]
                for base, p in common.items():
                    powers[base] -= p
                m = self._product(powers)
                reduced[m] = reduced.get(m, 0.0) + c
            terms = {n: c for n, c in reduced.items() if c != 0.0}
            if len(terms) < 2:
                return self.multiply((1.0, self._product(common)), self.close_sum(terms))
        items = sorted(terms.items(), key=lambda t: -1 if t[0] is None else t[0].number)
        # The number most terms share goes outside, with the sign that makes the first term positive.
        magnitude = Counter(abs(c) for _, c in items).most_common(1)[0][0]
        scale = float(np.copysign(magnitude, items[0][1]))
        data = tuple((self._same(_near_one(c / scale)), n) for n, c in items)
        node = self._intern("sum", data, max(n.level for _, n in data if n is not None))
        return self.multiply((scale, node), (1.0, self._product(common)))

    def _same(self, number):
        """The number that has been found before and differs by roundings alone, or this one."""
        found = self._numbers.setdefault(f"{number:.13e}", number)
        return found if abs(found - number) <= 8 * np.spacing(abs(number)) else number

    def add(self, *values):
        return self.close_sum(self.open_sum(*values))

    # -- functions --------------------------------------------------------------------------------------------------
    def call(self, name, *args):
        if all(a[1] is None for a in args) and name in _FOLD:
            return self.number(_FOLD[name](*(a[0] for a in args)))
        if name in ("cos", "sin"):
            (number, node), constant = self._without_constant(args[0])
            args = ((self._same(number), node),)
            if constant:
                return self._of_angle_sum(name, *args, constant)
        level = max((a[1].level for a in args if a[1] is not None), default=CONSTANT)
        return (1.0, self._intern("call", (name, args), level))

    def _without_constant(self, a):
        """A sum without its number, and this number."""
        number, node = a
        if node is None or node.kind != "sum" or node.data[0][1] is not None:
            return a, 0.0
        (constant, _), *others = node.data
        return self.close_sum({n: number * c for c, n in others}), number * constant

    def _of_angle_sum(self, name, angle, constant):
        """Cosine or sine of angle + constant, by those of the angle: for the roots of a cubic, and derivatives of them,
        one of each is computed. Beside a zero, the error is that which the rounded sum has."""
        cosine, sine = self.call("cos", angle), self.call("sin", angle)
        c, s = float(np.cos(constant)), float(np.sin(constant))
        a, b = ((c, cosine), (-s, sine)) if name == "cos" else ((c, sine), (s, cosine))
        return self.add(*((number * v[0], v[1]) for number, v in (a, b)))

    def select(self, condition, a, b):
        """Conditional; condition is a nested tuple (operator, value or condition, ...). Beside zero, a number is a
        factor of all: conditionals of components that differ by it are then the same."""
        if (0.0, None) in (a, b) and a != b:
            number = a[0] or b[0]
            a, b = ((v[0] / number, v[1]) for v in (a, b))
            return self.multiply(self.number(number), self._select(condition, a, b))
        return self._select(condition, a, b)

    def _select(self, condition, a, b):
        level = max([condition_level(condition)] + [v[1].level for v in (a, b) if v[1] is not None])
        return (1.0, self._intern("select", (condition, a, b), level))


def _near_one(ratio):
    """A ratio of numbers of the same meaning, which two roundings may have left beside 1."""
    return float(np.copysign(1.0, ratio)) if abs(abs(ratio) - 1.0) < 4e-16 else ratio


_FOLD = {"sqrt": np.sqrt, "abs": abs, "cos": np.cos, "sin": np.sin, "ln": np.log, "exp": np.exp}


def condition_level(c):
    """Level of a condition."""
    level = CONSTANT
    for x in c[1:]:
        if isinstance(x[0], str):
            level = max(level, condition_level(x))
        elif x[1] is not None:
            level = max(level, x[1].level)
    return level


_COMPARE = {"GT": ">", "GE": ">=", "LT": "<", "LE": "<=", "EQ": "==", "NE": "!="}


class GraphReader:
    """Turns the nodes of FFCx's factorised graph into values of an Algebra.

    Args:
        algebra: the Algebra that owns the values.
        graph: FFCx ExpressionGraph of one integrand.
        terminal: function (modified terminal, table reference) -> value.
    """

    def __init__(self, algebra, graph, terminal):
        self.algebra, self.graph, self.terminal = algebra, graph, terminal
        self.values = {}

    def read(self):
        """Values of all active nodes by node number."""
        nodes, graph = self.graph.nodes, self.graph
        number = {}
        for i, attributes in nodes.items():
            number[attributes["expression"]] = i
            if attributes["status"] == "inactive":
                continue
            parents = [j for j in graph.in_edges.get(i, ()) if nodes[j]["status"] != "inactive"]
            grows = len(parents) == 1 and isinstance(nodes[parents[0]]["expression"], ufl.classes.Sum)
            value = self._value(attributes, number)
            if isinstance(value, dict) and not (grows and not attributes.get("target")):
                value = self.algebra.close_sum(value)
            self.values[i] = value
        return self.values

    def _operand(self, expression, number):
        if expression._ufl_is_literal_:
            return self.algebra.number(float(expression))
        return self.values[number[expression]]

    def _closed(self, value):
        return self.algebra.close_sum(value) if isinstance(value, dict) else value

    def _value(self, attributes, number):
        algebra, v = self.algebra, attributes["expression"]
        if v._ufl_is_literal_:
            return algebra.number(float(v))
        if attributes.get("mt") is not None:
            return self.terminal(attributes["mt"], attributes.get("tr"))
        name = type(v).__name__
        if name in _COMPARE or name in ("AndCondition", "OrCondition", "NotCondition"):
            operands = [self._operand(o, number) for o in v.ufl_operands]
            operands = [self._closed(o) for o in operands]
            operator = _COMPARE.get(name) or {"AndCondition": "&&", "OrCondition": "||", "NotCondition": "!"}[name]
            return (operator, *operands)
        ops = [self._operand(o, number) for o in v.ufl_operands]
        if name == "Sum":
            return algebra.open_sum(*ops)
        ops = [self._closed(o) for o in ops]
        if name == "Product":
            return algebra.multiply(*ops)
        if name == "Division":
            return algebra.multiply(ops[0], algebra.power(ops[1], -1))
        if name == "Power":
            if ops[1][1] is None:
                return algebra.power(ops[0], ops[1][0])
            return algebra.call("power", *ops)
        if name == "Conditional":
            return algebra.select(*ops)
        if name in ("Abs", "MinValue", "MaxValue") or isinstance(
            v, (ufl.mathfunctions.MathFunction, ufl.classes.Atan2)
        ):
            return algebra.call(_CALL.get(name, name.lower()), *ops)
        raise ValueError(f"{in_words(v)} is not supported in kernels")


_CALL = {"Abs": "abs", "MinValue": "min_value", "MaxValue": "max_value", "Atan2": "atan_2", "Ln": "ln"}


def uses(roots):
    """How many times each node is used by the expressions reachable from `roots` (a list of nodes)."""
    count, seen, stack = Counter(), set(), [r for r in roots if r is not None]
    count.update(stack)
    while stack:
        node = stack.pop()
        if node in seen:
            continue
        seen.add(node)
        for child in children(node):
            count[child] += 1
            stack.append(child)
    return count


def children(node):
    """Nodes that `node` is computed from."""
    if node.kind == "sum":
        return [n for _, n in node.data if n is not None]
    if node.kind == "product":
        return [n for n, _ in node.data]
    if node.kind == "call":
        return [v[1] for v in node.data[1] if v[1] is not None]
    if node.kind == "select":
        condition, a, b = node.data
        return condition_nodes(condition) + [v[1] for v in (a, b) if v[1] is not None]
    return []


def condition_nodes(c):
    """Nodes that a condition compares."""
    found = []
    for x in c[1:]:
        if isinstance(x[0], str):
            found += condition_nodes(x)
        elif x[1] is not None:
            found.append(x[1])
    return found
