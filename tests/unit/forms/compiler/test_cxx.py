# SPDX-License-Identifier: MIT
"""Statements that FFCx does not know, as text of C++."""

import ffcx.codegeneration.lnodes as L

from dolfinx_impact.forms.compiler.cxx import AnyLane, Apart, CxxFormatter, LocalSolve, StoreHistory, Text, Unrolled

X, INDEX = L.Symbol("x", L.DataType.SCALAR), L.Symbol("i", L.DataType.INT)
ADD = L.AssignAdd(X, L.LiteralFloat(1.0))


def lines(node):
    return [line.strip() for line in CxxFormatter()(node).splitlines()]


def test_a_short_loop_is_unrolled_and_else_as_any_loop():
    loop = lines(Unrolled(INDEX, 0, 3, [ADD]))
    assert loop[0].startswith("#pragma") and "unroll" in loop[0]
    assert loop[1:] == lines(L.ForRange(INDEX, 0, 3, [ADD]))


def test_what_any_lane_needs_is_a_block():
    found = lines(AnyLane(L.GT(X, L.LiteralFloat(0.0)), [Text("first();"), Text("second();")]))
    assert found[0].startswith("if (any_lane(x > ")
    assert found[1:] == ["{", "first();", "second();", "}"]


def test_local_equations_have_a_start_a_scale_and_a_block():
    plain = LocalSolve("z", [L.LiteralFloat(0.0), X], X, [Text("equations();")])
    text = "\n".join(lines(plain))
    assert "const T z_start[2] = {" in text and "local_newton<T, 2>(z_start, " in text
    assert "const T (&z_x)[2] = z.x;" in text and text.count("equations();") == 1 and "any_lane" not in text
    guarded = LocalSolve("z", [X], X, [Text("equations();")], L.GT(X, L.LiteralFloat(0.0)), [Text("other();")])
    text = "\n".join(lines(guarded))
    assert text.index("not any_lane(x > ") < text.index("other();") < text.index("equations();")


def test_internal_variables_are_written_in_place_where_they_change():
    old, new, place = (L.Symbol(name, L.DataType.SCALAR) for name in ("old", "new", "place"))
    found = lines(StoreHistory([(new, old, place), (X, old, place)]))
    assert found[1:4] == ["if constexpr (in_place)", "changed = any_lane((new != old) |", "(x != old));"]
    assert found[4:] == ["if (changed)", "{", "place = new;", "place = x;", "}"]
    assert lines(Apart([ADD])) == ["if constexpr (not in_place)", "{", "x += 1.0;", "}"]
