# SPDX-License-Identifier: MIT
"""Matrices and vectors of one element.

Common arguments: `cell_type` "triangle", "quadrilateral", "tetrahedron" or "hexahedron"; `X` the geometry nodes in own
order, shape (num_geometry_nodes, gdim) [L]; `degree` and `geometry_degree` 1 or 2, independent of each other; `rule`
None, a name for `quadrature`, or a pair (points, weights). Degrees of freedom: u0x u0y (u0z) u1x ...; a displacement
may also be given with shape (num_nodes, gdim). Plane problems have thickness 1, axisymmetric ones are integrated over
the full circumference. ValueError for bad material data, shapes, NaN and for cells that are inverted or without volume.
"""

import numpy as np

from . import _reference, rules


def _array(values):
    return np.ascontiguousarray(values, dtype=float)


def _vector(values):
    return np.atleast_1d(_array(values)).reshape(-1)


def _cell(cell_type, degree, geometry_degree, rule, purpose, hypothesis=None):
    axisymmetric = hypothesis == "axisymmetric"
    integrated = rules.facet_type(cell_type) if purpose == "facet" else cell_type
    points, weights = rules.points_and_weights(integrated, rule, purpose, degree, geometry_degree, axisymmetric)
    return _reference.Cell(cell_type, degree, geometry_degree, axisymmetric, points, weights)


def _facet(cell_type, facet):
    if np.ndim(facet) == 0:
        return int(facet)
    return _reference.find_facet(cell_type, [int(node) for node in facet])


def _strain_purpose(material):
    return "stiffness" if material.law == "linear_elastic" else "finite_strain"


def element_stiffness(cell_type, X, material, degree=1, geometry_degree=1, rule=None):
    """k_e = int B^T D B dV, seed (3.25); shape (gdim n, gdim n) [F/L]."""
    cell = _cell(cell_type, degree, geometry_degree, rule, "stiffness", material.hypothesis)
    return _reference.element_stiffness(cell, _array(X), material)


def element_b_matrix(cell_type, X, point, hypothesis, degree=1, geometry_degree=1):
    """B of eps = B u, seed (3.18), at one reference point; shape (num_strains, gdim n) [1/L].

    Rows: 3d xx yy zz xy yz xz, plane xx yy xy, axisymmetric rr zz tt rz, with engineering shears.
    """
    cell = _cell(cell_type, degree, geometry_degree, (_array(point).reshape(1, -1), [1.0]), "stiffness", hypothesis)
    return _reference.element_b_matrix(cell, _array(X), hypothesis)


def _internal(cell_type, X, material, u, degree, geometry_degree, rule, with_tangent):
    cell = _cell(cell_type, degree, geometry_degree, rule, _strain_purpose(material), material.hypothesis)
    return _reference.element_internal(cell, _array(X), material, _vector(u), with_tangent)


def element_energy(cell_type, X, material, u, degree=1, geometry_degree=1, rule=None):
    """Strain energy of the displacements u [L]; a float [F L]."""
    return _internal(cell_type, X, material, u, degree, geometry_degree, rule, False)[0]


def element_internal_force(cell_type, X, material, u, degree=1, geometry_degree=1, rule=None):
    """int B_L^T S dV, total Lagrangian (Bathe ch. 6.4), or k_e u for a linear law; shape (gdim n) [F]."""
    return _internal(cell_type, X, material, u, degree, geometry_degree, rule, False)[1]


def element_tangent(cell_type, X, material, u, degree=1, geometry_degree=1, rule=None):
    """Derivative of the internal force: material and geometric stiffness; shape (gdim n, gdim n) [F/L]."""
    return _internal(cell_type, X, material, u, degree, geometry_degree, rule, True)[2]


def element_stress(cell_type, X, material, u, degree=1, geometry_degree=1, rule=None):
    """Stress at the points of the rule, shape (num_points, num_strains) [F/L^2].

    Cauchy for a linear law, 2nd Piola-Kirchhoff otherwise.
    """
    cell = _cell(cell_type, degree, geometry_degree, rule, "stiffness", material.hypothesis)
    return _reference.element_stress(cell, _array(X), material, _vector(u))


def second_piola(material, F):
    """Answer of a law to a deformation gradient F (3, 3); F[2, 2] is not read in plane stress.

    Returns S (num_strains) [F/L^2], dS/dE (num_strains, num_strains) for engineering shears [F/L^2] and the energy per
    reference volume [F/L^2]; for a linear law sigma, D and the energy of small strain. Bonet & Wood ch. 5, 6.
    ValueError if a neo-Hookean material is turned inside out.
    """
    return _reference.second_piola(material, _array(F))


def element_mass(cell_type, X, material, degree=1, geometry_degree=1, rule=None):
    """Consistent mass int rho N^T N dV (Hughes ch. 7); shape (gdim n, gdim n) [M]. ValueError if density is 0."""
    cell = _cell(cell_type, degree, geometry_degree, rule, "mass", material.hypothesis)
    return _reference.element_mass(cell, _array(X), material)


def element_lumped_mass(cell_type, X, material, scheme="auto", degree=1, geometry_degree=1, rule=None):
    """Diagonal mass, shape (gdim n) [M]; its sum per direction is the mass of the cell.

    scheme "row_sum", "hrz" (scaled diagonal, Hinton, Rock & Zienkiewicz 1976), "nodal" (quadrature at the nodes), or
    "auto": row_sum for degree 1, hrz for simplices and anything axisymmetric of degree 2, nodal for other cells.
    """
    cell = _cell(cell_type, degree, geometry_degree, rule, "mass", material.hypothesis)
    return _reference.element_lumped_mass(cell, _array(X), material, scheme)


def element_damping(cell_type, X, material, alpha, beta, degree=1, geometry_degree=1, rule=None):
    """Rayleigh damping alpha M + beta K of (3.67), alpha [1/T], beta [T]; shape (gdim n, gdim n) [F T/L]."""
    K = element_stiffness(cell_type, X, material, degree, geometry_degree, rule)
    return (
        beta * K
        if alpha == 0
        else alpha * element_mass(cell_type, X, material, degree, geometry_degree, rule) + beta * K
    )


def element_body_force(cell_type, X, f, hypothesis=None, degree=1, geometry_degree=1, rule=None):
    """int N^T f dV for a constant force per volume f (gdim) [F/L^3]; shape (gdim n) [F]."""
    cell = _cell(cell_type, degree, geometry_degree, rule, "load", hypothesis)
    return _reference.element_body_force(cell, _array(X), _vector(f))


def element_traction(cell_type, X, facet, t, hypothesis=None, degree=1, geometry_degree=1, rule=None):
    """int N^T t dS over a facet for a constant traction t (gdim) [F/L^2]; shape (gdim n) [F].

    `facet` is an own facet number or a list of own local nodes; `rule` belongs to the facet's cell type.
    """
    cell = _cell(cell_type, degree, geometry_degree, rule, "facet", hypothesis)
    return _reference.element_traction(cell, _array(X), _facet(cell_type, facet), _vector(t))


def element_follower_pressure(cell_type, X, u, facet, p, hypothesis=None, degree=1, geometry_degree=1, rule=None):
    """External force of a pressure p [F/L^2] that stays normal to the deformed facet, and its tangent.

    f_i = - int p N_i J F^-T n0 dA0, p > 0 pushes on the surface (Bonet & Wood ch. 8.5). Returns f (gdim n) [F] and
    df/du (gdim n, gdim n) [F/L]. Plane problems keep thickness 1 (plane stress too); axisymmetric ones use the current
    radius.
    """
    cell = _cell(cell_type, degree, geometry_degree, rule, "facet", hypothesis)
    return _reference.element_follower_pressure(cell, _array(X), _vector(u), _facet(cell_type, facet), float(p))


def _ale(cell_type, X, material, spin, centre, degree, geometry_degree, rule):
    cell = _cell(cell_type, degree, geometry_degree, rule, "mass", material.hypothesis)
    return _reference.element_ale(cell, _array(X), material, _vector(spin), _vector(centre))


def element_gyroscopic(cell_type, X, material, spin, centre, degree=1, geometry_degree=1, rule=None):
    """G = int rho (N^T A - A^T N) dV, seed (3.56), A = grad N . w, w = spin x (X - centre); (gdim n, gdim n) [M/T].

    `spin` is one number about z in the plane, three in space [1/T]. ValueError if axisymmetric.
    """
    return _ale(cell_type, X, material, spin, centre, degree, geometry_degree, rule)[0]


def element_ale_inertia(cell_type, X, material, spin, centre, degree=1, geometry_degree=1, rule=None):
    """W = int rho A^T A dV, seed (3.57); shape (gdim n, gdim n) [M/T^2]."""
    return _ale(cell_type, X, material, spin, centre, degree, geometry_degree, rule)[1]


def element_ale_load(cell_type, X, material, spin, centre, degree=1, geometry_degree=1, rule=None):
    """int rho A^T w dV, the load of (K - W) u = int rho A^T w, seed (3.57); shape (gdim n) [F]."""
    return _ale(cell_type, X, material, spin, centre, degree, geometry_degree, rule)[2]


def element_poisson(cell_type, X, k=1.0, degree=1, geometry_degree=1, rule=None, hypothesis=None):
    """int k grad N_i . grad N_j dV for a scalar field; shape (n, n). hypothesis="axisymmetric" weighs with 2 pi r."""
    cell = _cell(cell_type, degree, geometry_degree, rule, "stiffness", hypothesis)
    return _reference.element_poisson(cell, _array(X), float(k))


def element_scalar_load(cell_type, X, f, degree=1, geometry_degree=1, rule=None, hypothesis=None):
    """int f N_i dV for a constant source f; shape (n)."""
    cell = _cell(cell_type, degree, geometry_degree, rule, "load", hypothesis)
    return _reference.element_scalar_load(cell, _array(X), float(f))


def element_flux_load(cell_type, X, facet, q, degree=1, geometry_degree=1, rule=None, hypothesis=None):
    """int q N_i dS over a facet for a constant flux q; shape (n)."""
    cell = _cell(cell_type, degree, geometry_degree, rule, "facet", hypothesis)
    return _reference.element_flux_load(cell, _array(X), _facet(cell_type, facet), float(q))
