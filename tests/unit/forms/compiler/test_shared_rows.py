# SPDX-License-Identifier: MIT
"""Tables of symmetric rules as a shared row plus one entry per point (forms/compiler/tensor.py: split_rows)."""

import basix
import basix.ufl
import numpy as np
import pytest

from dolfinx_impact.forms.compiler import tensor


def _derivative(cell, degree, rule_degree, axis):
    kind = getattr(basix.CellType, cell)
    points, _ = basix.make_quadrature(kind, rule_degree)
    table = basix.ufl.element("Lagrange", cell, degree).tabulate(1, points)
    return table[1 + axis]


@pytest.mark.parametrize("cell", ["triangle", "tetrahedron"])
@pytest.mark.parametrize("axis", [0, 1])
def test_degree_two_on_the_symmetric_rule(cell, axis):
    table = _derivative(cell, 2, 2, axis)
    basis, reduction = tensor.reduce_columns(table)
    shared, columns, own = tensor.split_rows(basis)
    rebuilt = np.tile(shared, (len(table), 1))
    rebuilt[np.arange(len(table)), columns] += own
    # Round-off of table entries of order one.
    assert np.abs(rebuilt @ reduction - table).max() < 1e-14
    assert len(set(columns)) == len(table)


def test_other_rules_keep_their_tables():
    basis, _ = tensor.reduce_columns(_derivative("triangle", 2, 4, 0))
    assert tensor.split_rows(basis) is None
    assert tensor.split_rows(np.array([[1.0, 2.0], [3.0, 4.0]])) is None
    assert tensor.split_rows(np.ones((4, 3))) is None
