# SPDX-License-Identifier: MIT
"""Pointwise algebra: canonical sums, common factors, shared reciprocals; and the schedule that writes them."""

from types import SimpleNamespace

import basix.ufl
import ffcx.codegeneration.lnodes as L
import numpy as np
import pytest
import ufl
from ufl.corealg.traversal import unique_post_traversal

from dolfinx_impact.forms.compiler import algebra as alg
from dolfinx_impact.forms.compiler.cxx import CxxFormatter
from dolfinx_impact.forms.compiler.schedule import Schedule


@pytest.fixture
def algebra():
    return alg.Algebra()


def symbols(algebra, names, level=alg.POINT):
    return [algebra.symbol((n,), level) for n in names]


def minus(value):
    return (-value[0], value[1])


def evaluate(value, scope):
    """Value of the text that a schedule writes, with pairs of factors shared."""
    schedule, scope = Schedule(lambda key: L.Symbol(key[0], L.DataType.SCALAR), share_pairs=True), dict(scope)
    schedule.prepare([value])
    for statement in schedule.declare([value], alg.POINT):
        exec(CxxFormatter()(statement).replace("const T ", "").replace("math::", "").rstrip(";\n"), scope)
    return eval(CxxFormatter()(schedule.expression(value)).replace("math::", ""), scope)


def test_sums_are_canonical(algebra):
    a, b, c = symbols(algebra, "abc")
    assert algebra.add(a, b, c) == algebra.add(c, a, b)
    assert algebra.add(a, algebra.multiply(algebra.number(2), b)) == algebra.add(
        algebra.multiply(b, algebra.number(2)), a
    )


def test_products_are_canonical(algebra):
    a, b, c = symbols(algebra, "abc")
    assert algebra.multiply(a, algebra.multiply(b, c)) == algebra.multiply(algebra.multiply(c, a), b)


def test_like_terms_are_collected(algebra):
    a, b = symbols(algebra, "ab")
    assert algebra.add(a, b, a, minus(b)) == (2.0, a[1])
    assert algebra.add(a, minus(a)) == (0.0, None)


def test_common_factor_is_taken_out(algebra):
    a, b, c = symbols(algebra, "abc")
    value = algebra.add(algebra.multiply(a, b), algebra.multiply(a, c))
    assert value == algebra.multiply(a, algebra.add(b, c))


def test_common_reciprocal_is_taken_out(algebra):
    a, b, j = symbols(algebra, "abj")
    inverse = algebra.power(j, -1)
    value = algebra.add(algebra.multiply(a, inverse), algebra.multiply(b, inverse))
    assert value == algebra.multiply(algebra.add(a, b), inverse)


def test_reciprocals_of_the_geometry_may_stay():
    """They are then factors of the terms, which have them in common with other sums."""
    algebra = alg.Algebra(take_out_reciprocals=False)
    a, b = (algebra.symbol(("field", 0, "w0", k, (0,)), alg.POINT) for k in range(2))
    det, value = algebra.symbol(("field", 0, "x", 0, (1,)), alg.POINT), algebra.symbol(("constant", 0), alg.CONSTANT)
    for factor, taken in ((det, False), (value, True)):
        inverse = algebra.power(factor, -1)
        total = algebra.add(algebra.multiply(a, inverse), algebra.multiply(b, inverse))
        assert (total == algebra.multiply(algebra.add(a, b), inverse)) == taken


def test_common_number_and_sign_are_taken_out(algebra):
    a, b = symbols(algebra, "ab")
    difference = algebra.add(a, minus(b))
    opposite = algebra.add(b, minus(a))
    assert opposite == minus(difference)  # one node serves both
    halves = algebra.add(algebra.multiply(algebra.number(0.5), a), algebra.multiply(algebra.number(-0.5), b))
    assert halves == (0.5, difference[1])


def test_ratios_that_two_roundings_left_apart_are_one(algebra):
    """1.1 and 3.3 over 3, which is 1.0999999999999999: sums of several components are then the same."""
    a, b = symbols(algebra, "ab")
    one = algebra.add(a, (1.1, b[1]))
    three = algebra.add((3.0, a[1]), (1.1 * 3.0 * (1 - 2**-52), b[1]), (0.0, None))
    assert one == (1.0, three[1]) and three[0] == pytest.approx(3.0, rel=1e-15)
    other = algebra.add(a, (1.1 * (1 + 1e-13), b[1]))  # another number
    assert other[1] != one[1]


def test_factor_and_reciprocal_cancel(algebra):
    a, b = symbols(algebra, "ab")
    assert algebra.multiply(algebra.multiply(a, b), algebra.power(a, -1)) == b


@pytest.mark.parametrize("exponent", [0.5, -0.5, 1.5, -1.5])
def test_half_powers_share_one_root(algebra, exponent):
    (a,) = symbols(algebra, "a")
    assert algebra.power(a, exponent) == algebra.power(algebra.call("sqrt", a), int(2 * exponent))


@pytest.mark.parametrize("exponent", [-2 / 3, 1 / 3, -0.3, 0.7, 0.25, -1 / 6])
def test_powers_share_a_root_with_their_derivatives(algebra, exponent):
    """An exponent less one, as UFL's derivative leaves it: the same root times an integer power."""
    (a,) = symbols(algebra, "a")
    value = algebra.power(a, exponent)
    less = np.sign(exponent)  # away from zero
    assert algebra.power(a, exponent + less) == algebra.multiply(algebra.power(a, less), value)
    assert algebra.power(a, exponent + less + less) == algebra.multiply(algebra.power(a, 2 * less), value)


def test_roots_of_a_scaled_value(algebra):
    (a,) = symbols(algebra, "a")
    assert algebra.power((8.0, a[1]), -2 / 3) == (pytest.approx(0.25), algebra.power(a, -2 / 3)[1])
    negative = algebra.power((-8.0, a[1]), 1 / 3)  # not a number, as it should be: no sign is taken out
    assert negative == (pytest.approx(2.0), algebra.power((-1.0, a[1]), 1 / 3)[1])
    assert negative[1] != algebra.power(a, 1 / 3)[1]


def test_large_integer_powers_are_those_of_the_size(algebra):
    (a,) = symbols(algebra, "a")
    size = algebra.call("abs", a)
    assert algebra.power(a, 40) == algebra.call("power", size, algebra.number(40.0))
    assert algebra.power(a, 41) == algebra.multiply(a, algebra.power(a, 40))


def test_power_of_a_scaled_value(algebra):
    (a,) = symbols(algebra, "a")
    assert algebra.power((-2.0, a[1]), 3) == (-8.0, algebra.power(a, 3)[1])
    assert algebra.power((-2.0, a[1]), -2) == (0.25, algebra.power(a, -2)[1])


def test_angles_that_differ_by_a_number_share_cosine_and_sine(algebra, rng):
    """Roots of a cubic: cosines of phi, phi + 2 pi/3 and phi + 4 pi/3, and sines, of their derivatives."""
    (phi,) = symbols(algebra, "p")
    third = 2 * np.pi / 3
    angles = [algebra.add((0.4, phi[1]), algebra.number(k * third)) for k in range(3)]
    values = [algebra.call(name, angle) for angle in angles for name in ("cos", "sin")]
    calls = {n for v in values for n in [v[1], *alg.children(v[1])] if n.kind == "call"}
    assert calls == {algebra.call(name, (0.4, phi[1]))[1] for name in ("cos", "sin")}
    for x in rng.uniform(-4.0, 4.0, size=20):
        exact = [f(0.4 * x + k * third) for k in range(3) for f in (np.cos, np.sin)]
        scope = {"p": x, "cos": np.cos, "sin": np.sin}
        # Roundings of the angle, which is below 6, and of the sum of two products.
        assert [evaluate(v, scope) for v in values] == pytest.approx(exact, rel=0, abs=3e-15)
    assert algebra.call("cos", algebra.number(third)) == (np.cos(third), None)


def test_literals_are_folded(algebra):
    assert algebra.call("sqrt", algebra.number(9.0)) == (3.0, None)
    assert algebra.multiply(algebra.number(0.0), symbols(algebra, "a")[0]) == (0.0, None)


def test_levels_are_the_deepest_of_the_operands(algebra):
    c, x, q = (algebra.symbol((n,), level) for n, level in zip("cxq", (alg.CONSTANT, alg.CELL, alg.POINT)))
    assert algebra.multiply(c, x)[1].level == alg.CELL
    assert algebra.add(c, algebra.multiply(x, q))[1].level == alg.POINT
    assert algebra.select((">", c, q), c, x)[1].level == alg.POINT
    assert algebra.select(("&&", (">", c, c), ("<", c, x)), c, c)[1].level == alg.CELL


def written(values):
    """C++ text of the declarations and of the values, with symbols by their names."""
    schedule = Schedule(lambda key: L.Symbol(key[0], L.DataType.SCALAR))
    schedule.prepare(values)
    lines = [
        CxxFormatter()(d) for level in (alg.CONSTANT, alg.CELL, alg.POINT) for d in schedule.declare(values, level)
    ]
    return lines, [CxxFormatter()(schedule.expression(v)) for v in values]


def test_reciprocal_is_computed_once(algebra):
    a, b, j = symbols(algebra, "abj")
    inverse = algebra.power(j, -1)
    values = [algebra.multiply(a, inverse), algebra.multiply(b, inverse), algebra.multiply(b, algebra.power(j, -2))]
    lines, texts = written(values)
    assert sum(line.count("1.0 / j") for line in lines) + sum(t.count("/ j") for t in texts) == 1


def test_integer_powers_are_repeated_squares(algebra, rng):
    (a,) = symbols(algebra, "a")
    for exponent, multiplications in ((2, 1), (3, 2), (4, 2), (5, 3), (8, 3), (15, 6), (16, 4)):
        lines, (text,) = written([algebra.power(a, exponent)])
        assert sum(line.count("*") for line in lines) + text.count("*") == multiplications
        scope = {"a": rng.uniform(0.5, 1.5)}
        for line in lines:
            exec(line.replace("const T ", "").rstrip(";\n"), scope)
        assert eval(text, scope) == pytest.approx(scope["a"] ** exponent, rel=1e-14)  # some twenty roundings


def test_values_used_at_a_deeper_level_are_hoisted(algebra):
    (x,), (q,) = symbols(algebra, "x", alg.CELL), symbols(algebra, "q")
    lines, texts = written([algebra.multiply(algebra.call("exp", x), q)])
    assert lines == ["const T t0 = math::exp(x);\n"] and "t0" in texts[0] and "exp" not in texts[0]


def test_written_text_computes_the_value(algebra, rng):
    """Evaluate the C++ text as Python: sums, products, powers and signs survive algebra, schedule and formatter."""
    a, b, c, j = symbols(algebra, "abcj")
    p, m = algebra.add(a, minus(b)), algebra.add(algebra.multiply((3.0, a[1]), c), algebra.number(-2.0))
    wanted = [
        algebra.add(algebra.multiply(p, m), minus(algebra.multiply(p, algebra.power(j, -2)))),
        minus(algebra.multiply(algebra.power(m, 2), algebra.power(p, -1))),
        algebra.add(algebra.multiply((-0.5, b[1]), c), minus(a), algebra.number(1.25)),
    ]
    scope = dict(zip("abcj", rng.uniform(0.5, 1.5, size=4)))
    A, B, C, J = (scope[n] for n in "abcj")
    lines, texts = written(wanted)
    for line in lines:
        exec(line.replace("const T ", "").rstrip(";\n"), scope)
    P, M = A - B, 3 * A * C - 2
    expected = [P * M - P / J**2, -(M**2) / P, -0.5 * B * C - A + 1.25]
    # A handful of roundings, each relative to values of order one to ten.
    assert [eval(t, scope) for t in texts] == pytest.approx(expected, rel=1e-12)


def test_numbers_of_terms_are_factors_that_terms_share(algebra):
    """a - 3 s x, b - 3 s y: 3 s is computed once."""
    a, b, s, x, y = symbols(algebra, "absxy")
    values = [algebra.add(u, (-3.0, algebra.multiply(s, v)[1])) for u, v in ((a, x), (b, y))]
    schedule = Schedule(lambda key: L.Symbol(key[0], L.DataType.SCALAR), share_pairs=True)
    schedule.prepare(values)
    (declared,) = schedule.declare(values, alg.POINT)
    assert CxxFormatter()(declared) == "const T t0 = 3.0 * s;\n"
    assert [CxxFormatter()(schedule.expression(v)) for v in values] == ["a - x * t0", "b - y * t0"]


def test_uses_are_counted(algebra):
    a, b = symbols(algebra, "ab")
    product = algebra.multiply(a, b)
    total = algebra.add(product, a)
    assert alg.uses([total[1], a[1]])[a[1]] >= 2


def test_a_graph_of_ffcx_becomes_values(algebra, rng):
    """Sums, products, quotients, powers and functions of UFL, in the order of the graph."""
    space = ufl.FunctionSpace(
        ufl.Mesh(basix.ufl.element("Lagrange", "triangle", 1, shape=(2,))), basix.ufl.element("Lagrange", "triangle", 1)
    )
    f, g = ufl.Coefficient(space), ufl.Coefficient(space)
    expression = ufl.sqrt(f) * ufl.max_value(f, g) + (f + g - 2) * f / g - abs(g) ** 3
    order = list(dict.fromkeys(unique_post_traversal(expression)))
    nodes = {i: {"expression": e, "status": "active", "mt": e if e in (f, g) else None} for i, e in enumerate(order)}
    nodes[len(order) - 1]["target"] = [0]
    number = {e: i for i, e in enumerate(order)}
    parents = {i: [number[p] for p in order if e in p.ufl_operands] for i, e in enumerate(order)}
    graph = SimpleNamespace(nodes=nodes, in_edges=parents)
    symbol = {f: "f", g: "g"}
    values = alg.GraphReader(algebra, graph, lambda mt, tr: algebra.symbol((symbol[mt],), alg.POINT)).read()
    for a, b in rng.uniform(0.5, 2.0, (5, 2)):
        scope = {"sqrt": np.sqrt, "max_value": max, "abs": abs, "f": a, "g": b}
        expected = np.sqrt(a) * max(a, b) + (a + b - 2) * a / b - b**3
        assert evaluate(values[len(order) - 1], scope) == pytest.approx(expected, rel=1e-14)
