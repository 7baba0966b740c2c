# SPDX-License-Identifier: MIT
"""Sums multiplied out and collected: the same values, fewer operations, nothing that is no number gets out of a
conditional."""

import math

import ffcx.codegeneration.lnodes as L
import pytest

from dolfinx_impact.forms.compiler import algebra as alg
from dolfinx_impact.forms.compiler.collect import _Collector, collect
from dolfinx_impact.forms.compiler.cxx import CxxFormatter
from dolfinx_impact.forms.compiler.emit import flops
from dolfinx_impact.forms.compiler.schedule import Schedule


@pytest.fixture
def algebra():
    return alg.Algebra()


def value_of(value, numbers):
    """Value of a pair (number, node), whose symbols have the names of `numbers`."""
    factor, node = value
    if node is None:
        return factor
    if node.kind == "symbol":
        return factor * numbers[node.data]
    if node.kind == "sum":
        return factor * math.fsum(c * value_of((1.0, n), numbers) for c, n in node.data)
    if node.kind == "product":
        return factor * math.prod(value_of((1.0, n), numbers) ** p for n, p in node.data)
    if node.kind == "call":
        functions = {"exp": math.exp, "ln": lambda x: math.log(x) if x > 0 else math.nan}
        return factor * functions[node.data[0]](*(value_of(a, numbers) for a in node.data[1]))
    (operator, left, right), a, b = node.data
    assert operator == ">"
    return factor * value_of(a if value_of(left, numbers) > value_of(right, numbers) else b, numbers)


def operations(values):
    schedule = Schedule(lambda key: L.Symbol(key[0], L.DataType.SCALAR), share_pairs=True)
    schedule.prepare(values)
    statements = schedule.declare(values, alg.POINT)
    return sum(flops(s) for s in statements) + sum(flops(schedule.expression(v)) for v in values)


def symbols(algebra, names):
    return {n: algebra.symbol((n,), alg.POINT) for n in names.split()}


def stress(algebra, size):
    """Components s k (p f_i + q g_i) + r (f_i - 3 s g_i) with invariants p, q, r, s of all f and g."""
    names = [f"{n}{i}" for n in "fg" for i in range(size)]
    fields = symbols(algebra, " ".join(names))
    total = algebra.add(*fields.values())
    p, q, r, s = (algebra.call("exp", algebra.multiply((0.1 * (k + 1), None), total)) for k in range(4))
    minus = algebra.multiply((-3.0, None), s)
    return names, [
        algebra.add(
            algebra.multiply(s, algebra.add(algebra.multiply(p, f), algebra.multiply(q, g))),
            algebra.multiply(r, algebra.add(f, algebra.multiply(minus, g))),
        )
        for f, g in ((fields[f"f{i}"], fields[f"g{i}"]) for i in range(size))
    ]


def test_components_are_collected_by_what_is_their_own(algebra, rng):
    names, values = stress(algebra, 6)
    found = collect(algebra, values)
    numbers = {(n,): x for n, x in zip(names, rng.uniform(0.2, 0.8, size=len(names)))}
    for a, b in zip(found, values):
        assert value_of(a, numbers) == pytest.approx(value_of(b, numbers), rel=1e-14)  # some ten roundings
    # Two invariants, and two products and a sum a component, instead of seven operations a component.
    assert operations(found) <= operations(values) - 3 * 6
    assert collect(algebra, found) == found


def test_texts_compute_the_values(algebra, rng):
    names, values = stress(algebra, 3)
    found = collect(algebra, values)
    schedule = Schedule(lambda key: L.Symbol(key[0], L.DataType.SCALAR), share_pairs=True)
    schedule.prepare(found)
    scope = {n: rng.uniform(0.2, 0.8) for n in names} | {"exp": math.exp}
    for statement in schedule.declare(found, alg.POINT):
        exec(CxxFormatter()(statement).replace("const T ", "").replace("math::", "").rstrip(";\n"), scope)
    numbers = {(n,): scope[n] for n in names}
    for a, b in zip(found, values):
        text = CxxFormatter()(schedule.expression(a)).replace("math::", "")
        assert eval(text, scope) == pytest.approx(value_of(b, numbers), rel=1e-14)


def test_a_difference_from_a_number_is_not_multiplied_out(algebra):
    """a (J - 1) is small where J is near 1; a J - a is what rounding leaves."""
    s = symbols(algebra, "a b c J")
    difference = algebra.add(s["J"], algebra.number(-1.0))
    value = algebra.add(algebra.multiply(s["a"], difference), algebra.multiply(s["b"], s["c"]))
    assert collect(algebra, [value]) == [value]
    numbers = {("a",): 1.0, ("b",): 0.0, ("c",): 0.0, ("J",): 1.0 + 2**-52}
    assert value_of(collect(algebra, [value])[0], numbers) == 2**-52


def test_conditionals_of_components_become_one(algebra, rng):
    """select(c, h f_i, 0) + k f_i with one h: f_i (select(c, h, 0) + k)."""
    s = symbols(algebra, "f0 f1 f2 h k e")
    inside = algebra.call("ln", s["h"])
    condition = (">", s["e"], algebra.number(0.0))
    values = [
        algebra.add(
            algebra.select(condition, algebra.multiply(inside, s[f"f{i}"]), algebra.number(0.0)),
            algebra.multiply(s["k"], s[f"f{i}"]),
        )
        for i in range(3)
    ]
    found = collect(algebra, values)
    guarded = algebra.select(condition, inside, algebra.number(0.0))
    assert found == [algebra.multiply(s[f"f{i}"], algebra.add(guarded, s["k"])) for i in range(3)]
    numbers = {(n,): x for n, x in zip(s, rng.uniform(0.5, 1.5, size=6))}
    for more in ({}, {("e",): -1.0, ("h",): -2.0}):  # the logarithm of a negative number is left out
        for a, b in zip(found, values):
            expected = value_of(b, numbers | more)
            assert math.isfinite(expected) and value_of(a, numbers | more) == pytest.approx(expected, rel=1e-14)


def test_what_a_condition_guards_stays_inside(algebra):
    """ln(h) g, where g is not a number either without the condition: neither factor is taken out."""
    s = symbols(algebra, "h e k")
    g = algebra.call("ln", algebra.add(s["h"], s["e"]))
    inside = algebra.multiply(algebra.call("ln", s["h"]), g)
    guarded = algebra.select((">", s["e"], algebra.number(0.0)), inside, algebra.number(0.0))
    (found,) = collect(algebra, [algebra.add(guarded, s["k"])])
    numbers = {("h",): -2.0, ("e",): -1.0, ("k",): 3.0}
    assert value_of(found, numbers) == 3.0


def test_quotients_stay_inside(algebra):
    """k / e where e > 0: its factor k goes out, the quotient 1 / e does not."""
    s = symbols(algebra, "e k f")
    quotient = algebra.multiply(s["k"], algebra.power(s["e"], -1))
    guarded = algebra.select((">", s["e"], algebra.number(0.0)), quotient, algebra.number(0.0))
    (found,) = collect(algebra, [algebra.add(guarded, algebra.multiply(s["f"], s["k"]))])
    inside = algebra.select((">", s["e"], algebra.number(0.0)), algebra.power(s["e"], -1), algebra.number(0.0))
    assert found == algebra.multiply(s["k"], algebra.add(inside, s["f"]))


def test_quotients_that_are_computed_anyway_go_out(algebra):
    """h / J where e > 0, beside k / J and h where e > 0: one conditional for both."""
    s = symbols(algebra, "h e k J")
    inverse, zero = algebra.power(s["J"], -1), algebra.number(0.0)
    condition, inside = (">", s["e"], zero), algebra.call("ln", s["h"])
    values = [
        algebra.add(
            algebra.multiply(s["k"], inverse), algebra.select(condition, algebra.multiply(inside, inverse), zero)
        ),
        algebra.add(s["k"], algebra.select(condition, inside, zero)),
    ]
    found = collect(algebra, values)
    total = algebra.add(s["k"], algebra.select(condition, inside, zero))
    assert found == [algebra.multiply(total, inverse), total]


def test_what_is_put_together_is_multiplied_out_the_second_time(algebra, rng):
    """Two invariants with gradients f_i + r d_i and f_i + s d_i, each in two terms of a component i: the first time
    puts each one's terms together, the second time f_i and d_i are what is collected."""
    by_name = symbols(algebra, "f0 f1 f2 d0 d1 d2")
    total = algebra.add(*by_name.values())
    r, s, t, x = (algebra.call("exp", algebra.multiply((0.1 * (k + 1), None), total)) for k in range(4))
    values = []
    for i in range(3):
        f, d = by_name[f"f{i}"], by_name[f"d{i}"]
        first, second = (algebra.add(f, algebra.multiply(g, d)) for g in (r, s))
        terms = [(t, first, second), (x, second, first)]
        inner = [algebra.multiply(c, algebra.add(algebra.multiply(r, a), algebra.multiply(s, b))) for c, a, b in terms]
        values.append(algebra.add(*inner))
    found = collect(algebra, values, times=2)
    assert operations(found) < operations(collect(algebra, values))
    numbers = {(n,): y for n, y in zip(by_name, rng.uniform(0.2, 0.8, size=len(by_name)))}
    for a, b in zip(found, values):
        assert value_of(a, numbers) == pytest.approx(value_of(b, numbers), rel=1e-14)


def test_what_a_collector_has_rewritten_it_keeps(algebra, rng):
    """x a + x b + y c as x (a + b) + y c, once, and any multiple of it."""
    x, y, a, b, c = symbols(algebra, "x y a b c").values()
    value = algebra.add(algebra.multiply(x, a), algebra.multiply(x, b), algebra.multiply(y, c))
    collector = _Collector(algebra, [value[1]])
    found = collector.scaled(3.0, value[1])
    assert found[1] is collector.scaled(-1.0, value[1])[1] and found[0] == 3.0 * value[0]
    assert operations([found]) <= operations([value])
    numbers = dict(zip(((n,) for n in "xyabc"), rng.random(5)))
    assert value_of(found, numbers) == pytest.approx(3.0 * value_of(value, numbers), rel=1e-14)
