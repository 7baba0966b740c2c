# SPDX-License-Identifier: MIT
"""Sum factorisation: 1D factors are verified against the tables, and columns are reduced without changing them."""

import basix
import basix.ufl
import numpy as np
import pytest

from dolfinx_impact.forms.compiler import tensor

CELLS = {"quadrilateral": 2, "hexahedron": 3}


def tabulated(element, points, derivatives):
    """Table (points, dofs) of a scalar element for given derivative counts."""
    order = sum(derivatives)
    return element.tabulate(order, points)[basix.index(*derivatives)]


@pytest.mark.parametrize("degree", [1, 2, 3])
@pytest.mark.parametrize("cell, dim", CELLS.items())
@pytest.mark.parametrize("rule_degree", [2, 3, 5])
def test_factors_reproduce_the_tables(cell, dim, degree, rule_degree):
    element = basix.ufl.element("Lagrange", cell, degree)
    points, _ = basix.make_quadrature(getattr(basix.CellType, cell), rule_degree)
    factor = tensor.factors(element, points)
    assert factor is not None and factor.num_nodes == degree + 1 and factor.num_points**dim == len(points)
    for derivatives in np.ndindex(*[2] * dim):
        if sum(derivatives) > 1:
            continue
        table = tabulated(element, points, derivatives)
        assert tensor.matches(factor, derivatives, table)
        wrong = table.copy()
        wrong[-1, 0] += 1e-9
        assert not tensor.matches(factor, derivatives, wrong)


def test_derivatives_of_linear_functions_are_constant():
    points, _ = basix.make_quadrature(basix.CellType.hexahedron, 3)
    factor = tensor.factors(basix.ufl.element("Lagrange", "hexahedron", 1), points)
    assert factor.constant(1) and not factor.constant(0)


@pytest.mark.parametrize("cell", ["triangle", "tetrahedron"])
def test_simplices_have_no_factors(cell):
    points, _ = basix.make_quadrature(getattr(basix.CellType, cell), 3)
    assert tensor.factors(basix.ufl.element("Lagrange", cell, 1), points) is None


def test_other_elements_have_no_factors():
    cell = "quadrilateral"
    points, _ = basix.make_quadrature(basix.CellType.quadrilateral, 3)
    P1 = basix.ufl.element("Lagrange", cell, 1)
    for element in (
        basix.ufl.element("DG", cell, 0),
        basix.ufl.element("RTCF", cell, 1),
        basix.ufl.mixed_element([P1, basix.ufl.element("Lagrange", cell, 2)]),
        basix.ufl.quadrature_element(cell, degree=3),
    ):
        assert tensor.factors(element, points) is None


def test_points_out_of_order_are_no_grid(rng):
    points, _ = basix.make_quadrature(basix.CellType.quadrilateral, 3)
    assert len(tensor.grid_of_points(points)) == 2
    assert tensor.grid_of_points(points[[1, 0, 2, 3]]) is None
    assert tensor.grid_of_points(points[:3]) is None
    assert tensor.grid_of_points(points + 1e-3 * rng.uniform(size=points.shape)) is None


@pytest.mark.parametrize("cell", ["triangle", "tetrahedron", "quadrilateral", "hexahedron"])
@pytest.mark.parametrize("degree", [1, 2, 3])
def test_reduced_columns_reproduce_the_table(cell, degree):
    element = basix.ufl.element("Lagrange", cell, degree)
    points, _ = basix.make_quadrature(getattr(basix.CellType, cell), 2 * degree)
    for table in element.tabulate(1, points):
        basis, reduction = tensor.reduce_columns(table)
        assert np.all(np.isin(reduction, (-1.0, 0.0, 1.0)))
        assert basis.shape == (len(points), reduction.shape[0]) and reduction.shape[1] == table.shape[1]
        # A column is replaced when it differs by less than tensor.TOLERANCE.
        assert np.max(np.abs(basis @ reduction - table)) < tensor.TOLERANCE


def test_reduction_is_smaller_where_it_can_be():
    points, _ = basix.make_quadrature(basix.CellType.triangle, 4)
    derivative = basix.ufl.element("Lagrange", "triangle", 2).tabulate(1, points)[1]
    basis, _ = tensor.reduce_columns(derivative)
    assert basis.shape[1] == 3  # N0' and N1', y; N4' = -4y; N5' = -(N0' + N1'); N2' = 0


def test_nothing_is_left_of_a_zero_table():
    basis, reduction = tensor.reduce_columns(np.zeros((4, 3)))
    assert basis.shape == (4, 0) and reduction.shape == (0, 3)


def test_factors_of_a_square_on_two_points():
    """1 - x and x at Gauss's points (1 -+ 1/sqrt(3))/2; nodes of the lattice, the last direction the fastest."""
    points, _ = basix.make_quadrature(basix.CellType.quadrilateral, 3)
    factor = tensor.factors(basix.ufl.element("Lagrange", "quadrilateral", 1), points)
    x = (1 + np.array([-1, 1]) / np.sqrt(3)) / 2
    assert isinstance(factor, tensor.Factors) and (factor.num_points, factor.num_nodes) == (2, 2)
    np.testing.assert_allclose(factor.table(0), np.column_stack([1 - x, x]), atol=1e-15)
    np.testing.assert_allclose(factor.table(1), [[-1, 1], [-1, 1]], atol=1e-15)
    corners = basix.geometry(basix.CellType.quadrilateral)[list(factor.node)]
    assert corners.tolist() == [[0, 0], [0, 1], [1, 0], [1, 1]]
