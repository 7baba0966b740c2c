# SPDX-License-Identifier: MIT
"""Forms on meshes of gmsh and XDMF, whose nodes have another name than those of DOLFINx's own and are the same."""

import basix
import basix.ufl
import numpy as np
import pytest
import ufl

from dolfinx_impact.forms import elasticity
from dolfinx_impact.forms.compiler import frontend
from dolfinx_impact.forms.compiler.standard_mesh import MeshWithCell, StandardMesh, standard_element
from dolfinx_impact.forms.materials import LinearElastic

CELLS = {"triangle": 2, "quadrilateral": 2, "tetrahedron": 3, "hexahedron": 3}


def coordinate_element(cell, degree, variant):
    return basix.ufl.element("Lagrange", cell, degree, basix.LagrangeVariant[variant], shape=(CELLS[cell],))


def forms(cell, degree, variant):
    """Forms with everything that knows its mesh: functions, constants, geometry, cells and facets, a point law."""
    domain = ufl.Mesh(coordinate_element(cell, degree, variant))
    V = ufl.FunctionSpace(domain, basix.ufl.element("Lagrange", cell, 1, shape=(CELLS[cell],)))
    u, v, du = ufl.Coefficient(V), ufl.TestFunction(V), ufl.TrialFunction(V)
    E, nu, p = (ufl.Constant(domain) for _ in range(3))
    law = LinearElastic(E, nu, "3d" if CELLS[cell] == 3 else "plane_strain")
    x, n = ufl.SpatialCoordinate(domain), ufl.FacetNormal(domain)
    force, stress = elasticity.internal_force_with_stress(u, v, law, ufl.dx(domain=domain))
    yield force, None
    yield force, stress
    yield elasticity.tangent(u, du, v, law, ufl.dx(domain=domain)), None
    yield p * ufl.inner(n, v) * x[0] * ufl.ds(3, domain=domain) + force, None
    yield elasticity.internal_energy(u, law, ufl.dx(domain=domain)), None


def signatures(cell, degree, variant):
    return [frontend.form_signature(form, law) for form, law in forms(cell, degree, variant)]


@pytest.mark.parametrize("variant", ["equispaced", "gll_isaac", "gll_centroid"])
@pytest.mark.parametrize("degree", [1, 2])
@pytest.mark.parametrize("cell", CELLS)
def test_the_same_nodes_are_the_same_form(cell, degree, variant):
    found, own = (coordinate_element(cell, degree, v)._sub_element._element.points for v in (variant, "gll_warped"))
    np.testing.assert_array_equal(found, own)  # why they may be taken for each other
    assert signatures(cell, degree, variant) == signatures(cell, degree, "gll_warped")


@pytest.mark.parametrize("cell, degree, variant", [("triangle", 3, "equispaced"), ("triangle", 2, "bernstein")])
def test_other_nodes_are_another_form(cell, degree, variant):
    ours, theirs = signatures(cell, degree, variant), signatures(cell, degree, "gll_warped")
    assert not set(ours) & set(theirs)


def test_forms_of_other_degrees_and_cells_differ():
    all_of_them = [s for cell in CELLS for degree in (1, 2) for s in signatures(cell, degree, "equispaced")]
    assert len(set(all_of_them)) == len(all_of_them)


def test_what_is_standard_stays_as_it_is():
    element = coordinate_element("triangle", 1, "gll_warped")
    assert standard_element(element) is element
    single = basix.ufl.element("Lagrange", "triangle", 1, shape=(2,), dtype=np.float32)
    assert standard_element(single) is single
    ((form, _), *_) = forms("triangle", 1, "gll_warped")
    assert StandardMesh(form.ufl_domains()).form(form) is form


def test_a_standard_mesh_keeps_its_cell():
    element = coordinate_element("hexahedron", 1, "gll_warped")
    mesh = MeshWithCell(element, 7)
    assert mesh.ufl_cell() is mesh.ufl_cell() and mesh.ufl_cell() == element.cell
    other = ufl.Mesh(element, ufl_id=7)
    first, second = ((ufl.SpatialCoordinate(m)[0] * ufl.dx(domain=m)).signature() for m in (mesh, other))
    assert first == second
