# SPDX-License-Identifier: MIT
"""Expressions with averages: equal parts are one object before UFL's algorithms look at them."""

import basix.ufl
import ufl
from ufl.corealg.traversal import unique_pre_traversal

from dolfinx_impact.forms.compiler.averages import lowered, shared

MESH = ufl.Mesh(basix.ufl.element("Lagrange", "quadrilateral", 1, shape=(2,)))
LEVELS = 60  # a comparison of trees would look at 2^60 parts


def copies(f, levels, count=3):
    """Vector of expressions that are equal, but objects of their own, on each level. (Two of a kind UFL finds.)"""
    parts = [ufl.sin(f) for _ in range(count)]
    for _ in range(levels):
        parts = [ufl.sin(parts[k]) * ufl.cos(parts[(k + 1) % count]) for k in range(count)]
    return ufl.as_vector(parts)


def test_equal_parts_are_one_object():
    f = ufl.Coefficient(ufl.FunctionSpace(MESH, basix.ufl.element("Lagrange", "quadrilateral", 1)))
    before = copies(f, 3)
    text = str(before)
    after = shared(before)
    assert str(after) == text and shared(after) is after
    parts = [o for o in unique_pre_traversal(after) if not o._ufl_is_terminal_]
    assert len({id(o) for o in parts}) == len({str(o) for o in parts})


def test_lowering_takes_no_time_that_grows_with_the_tree():
    f = ufl.Coefficient(ufl.FunctionSpace(MESH, basix.ufl.element("Lagrange", "quadrilateral", 1)))
    found = lowered(copies(f, LEVELS))
    assert len({id(o) for o in unique_pre_traversal(found)}) < 10 * LEVELS
