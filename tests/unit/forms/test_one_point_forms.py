# SPDX-License-Identifier: MIT
"""What the forms of cells with one point are made of."""

import basix.ufl
import pytest
import ufl

from dolfinx_impact.forms import one_point, registry
from dolfinx_impact.forms.materials import LinearElastic
from dolfinx_impact.forms.reference_derivatives import (
    PulledBack,
    has_reference_derivatives,
    reference_derivatives,
)


def space(cell, dim):
    element = basix.ufl.element("Lagrange", cell, 1, shape=(dim,))
    return ufl.FunctionSpace(ufl.Mesh(element), element)


def test_a_function_is_pulled_back_once():
    """UFL's own step finds it and leaves the value on the reference cell; sums are taken apart."""
    u, v = (ufl.Coefficient(space("hexahedron", 3)) for _ in range(2))
    pulled = PulledBack(u)
    assert type(pulled._ufl_expr_reconstruct_(ufl.classes.ReferenceValue(u))) is ufl.classes.ReferenceValue
    assert pulled._ufl_expr_reconstruct_(v) == PulledBack(v)
    assert reference_derivatives(u, 2).ufl_shape == (3, 3, 3)
    assert reference_derivatives(u + u, 1) == reference_derivatives(u, 1) + reference_derivatives(u, 1)
    assert has_reference_derivatives(reference_derivatives(u, 1)) and not has_reference_derivatives(ufl.grad(u))


@pytest.mark.parametrize("cell, dim, num_modes", [("quadrilateral", 2, 1), ("hexahedron", 3, 4)])
def test_shapes(cell, dim, num_modes):
    V = space(cell, dim)
    u, cell_of = ufl.Coefficient(V), one_point.OnePointCell(V.ufl_domain())
    assert cell_of.mean_gradient(u).ufl_shape == (dim, dim) and cell_of.volume.ufl_shape == ()
    assert len(cell_of.modes_of(u)) == num_modes == len(cell_of.position_modes())


def test_what_is_refused():
    with pytest.raises(ValueError, match="quadrilateral and hexahedron cells"):
        one_point.OnePointBody(space("tetrahedron", 3).ufl_domain(), LinearElastic(1.0, 0.3))
    with pytest.raises(ValueError, match="axisymmetric"):
        one_point.OnePointBody(space("quadrilateral", 2).ufl_domain(), LinearElastic(1.0, 0.3, "axisymmetric"))
    with pytest.raises(ValueError, match="degree 1, found 2"):
        registry.build("linear_elastic.reduced.force", "hexahedron", 2)
    with pytest.raises(ValueError, match="for quadrilaterals and hexahedra"):
        registry.build("linear_elastic.reduced.force", "triangle", 1)
