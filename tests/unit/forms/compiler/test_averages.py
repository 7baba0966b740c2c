# SPDX-License-Identifier: MIT
"""Averages and maxima over a cell replaced by coefficients, and the sizes of cells that are written by them."""

import basix.ufl
import pytest
import ufl
from ufl.corealg.map_dag import map_expr_dag
from ufl.corealg.traversal import unique_pre_traversal

from dolfinx_impact.forms.cell_maximum import CellMax, cell_max, has_maximum
from dolfinx_impact.forms.compiler.averages import Average, Averages, WithoutVariables, _Replace, _ReplaceMaxima
from dolfinx_impact.forms.compiler.frontend import _Renumber
from dolfinx_impact.forms.compiler.geometry import _FacetAreas, _Sizes
from dolfinx_impact.forms.compiler.stress_form import _Replaced


def mesh_of(cell):
    dim = {"triangle": 2, "quadrilateral": 2, "hexahedron": 3}[cell]
    return ufl.Mesh(basix.ufl.element("Lagrange", cell, 1, shape=(dim,)))


TRIANGLE = mesh_of("triangle")
V = ufl.FunctionSpace(TRIANGLE, basix.ufl.element("Lagrange", "triangle", 1))
f, g, v = ufl.Coefficient(V), ufl.Coefficient(V), ufl.TestFunction(V)


def kinds(expression):
    return {type(o) for o in unique_pre_traversal(expression)}


def test_maxima_of_constants_are_these():
    assert float(cell_max(3.0)) == 3.0 and not has_maximum(cell_max(3.0))
    maximum = CellMax(ufl.grad(f))
    assert maximum.ufl_shape == (2,) and str(maximum) == f"cell_max({ufl.grad(f)})" and has_maximum(1 + maximum[0])


def test_variables_are_what_they_stand_for():
    variable = ufl.variable(f * g)
    assert map_expr_dag(WithoutVariables(), variable + f) == f * g + f


def test_equal_averages_are_one_and_inner_ones_come_first():
    averages = Averages(TRIANGLE)
    mean = ufl.cell_avg(f)
    found = map_expr_dag(_Replace(averages), mean * ufl.cell_avg(f) + ufl.cell_avg(g * mean) + cell_max(f))
    assert not kinds(found) & {ufl.classes.CellAvg, CellMax}
    values = list(averages.found.values())
    assert all(isinstance(a, Average) for a in values) and len(values) == 3
    inner = next(a for a in values if a.operand == f and not a.maximum)
    outer = next(a for a in values if inner.coefficient in ufl.algorithms.extract_coefficients(a.operand))
    assert (inner.loop, outer.loop) == (0, 1)
    assert [a.maximum for a in values if a.operand == f] in ([False, True], [True, False])


def test_averages_of_the_test_function_are_kept_apart():
    replace = _Replace(Averages(TRIANGLE))
    map_expr_dag(replace, f * ufl.cell_avg(v))
    assert list(replace.arguments) == [v] and not replace.averages.found


@pytest.mark.parametrize("replace", [_Replace, _ReplaceMaxima])
def test_a_maximum_of_a_test_function_is_refused(replace):
    with pytest.raises(ValueError, match="not linear in it"):
        map_expr_dag(replace(Averages(TRIANGLE)), CellMax(v))


def test_areas_and_volumes_where_cells_are_not_affine():
    for mapping in (_FacetAreas(), _Sizes()):
        for size in (ufl.FacetArea(TRIANGLE), ufl.CellVolume(TRIANGLE)):  # affine: UFL knows them
            assert map_expr_dag(mapping, size) is size
    quadrilateral = mesh_of("quadrilateral")
    area, volume = ufl.FacetArea(quadrilateral), ufl.CellVolume(quadrilateral)
    assert ufl.classes.FacetJacobianDeterminant in kinds(map_expr_dag(_FacetAreas(), area))
    assert map_expr_dag(_FacetAreas(), volume) is volume
    assert {ufl.classes.CellAvg, ufl.classes.JacobianDeterminant} <= kinds(map_expr_dag(_Sizes(), volume))
    face = ufl.FacetArea(mesh_of("hexahedron"))  # its faces are no straight edges
    assert map_expr_dag(_FacetAreas(), face) is face


def test_the_gradient_of_the_test_function_alone_is_replaced():
    tensor = ufl.as_vector((1.0, 2.0))
    found = map_expr_dag(_Replaced(tensor), ufl.inner(ufl.grad(v), ufl.grad(f)))
    assert found == ufl.inner(tensor, ufl.grad(f))


def test_operands_are_sorted_anew_where_constants_change():
    """A product that was made of constants in one order is the product of the new ones in theirs."""
    a, b, first, second = (ufl.Constant(TRIANGLE) for _ in range(4))
    found = map_expr_dag(_Renumber({a: second, b: first}), a * b)
    assert repr(found) == repr(first * second) != repr(a * b)
