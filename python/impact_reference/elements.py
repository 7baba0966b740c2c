# SPDX-License-Identifier: MIT
"""Matrices and vectors of one element.

n is the number of nodes of the field. Degrees of freedom are node-major: u0x u0y (u0z) u1x ... Plane problems have
thickness 1; axisymmetric ones are integrated over the full circumference. Every function raises ValueError for bad
material data, wrong shapes, NaN, and cells that are inverted or without volume.
"""

from collections.abc import Sequence
from typing import TypeAlias, Union

import numpy as np

from . import _reference, rules
from ._reference import Material
from .array_types import ArrayLike, FloatArray, Rule, floats, vector

Facet: TypeAlias = Union[int, Sequence[int]]


def _cell(
    cell_type: str, degree: int, geometry_degree: int, rule: Rule, purpose: str, hypothesis: str | None = None
) -> _reference.Cell:
    axisymmetric = hypothesis == "axisymmetric"
    integrated = rules.facet_type(cell_type) if purpose == "facet" else cell_type
    points, weights = rules.points_and_weights(integrated, rule, purpose, degree, geometry_degree, axisymmetric)
    return _reference.Cell(cell_type, degree, geometry_degree, axisymmetric, points, weights)


def _facet(cell_type: str, facet: Facet) -> int:
    nodes = np.asarray(facet)
    if nodes.ndim == 0:
        return int(nodes)
    return _reference.find_facet(cell_type, [int(node) for node in nodes])


def _strain_purpose(material: Material) -> str:
    return "stiffness" if material.law == "linear_elastic" else "finite_strain"


def element_stiffness(
    cell_type: str, X: ArrayLike, material: Material, degree: int = 1, geometry_degree: int = 1, rule: Rule = None
) -> FloatArray:
    """Stiffness matrix k_e = int B^T D B dV, seed (3.25).

    Args:
        cell_type: cell, "triangle", "quadrilateral", "tetrahedron" or "hexahedron".
        X: geometry nodes in the order of `reference_nodes`, shape (num_geometry_nodes, gdim) [L].
        material: material data and hypothesis.
        degree: degree of the field, 1 or 2.
        geometry_degree: degree of the geometry, 1 or 2.
        rule: None (default), a name for `quadrature`, or a pair (points, weights).

    Returns:
        k_e, shape (gdim n, gdim n) [F/L].
    """
    cell = _cell(cell_type, degree, geometry_degree, rule, "stiffness", material.hypothesis)
    return _reference.element_stiffness(cell, floats(X), material)


def element_b_matrix(
    cell_type: str, X: ArrayLike, point: ArrayLike, hypothesis: str, degree: int = 1, geometry_degree: int = 1
) -> FloatArray:
    """Strain-displacement matrix B of eps = B u at one point, seed (3.18).

    Rows: 3d xx yy zz xy yz xz, plane xx yy xy, axisymmetric rr zz tt rz, with engineering shears.

    Args:
        cell_type: cell, "triangle", "quadrilateral", "tetrahedron" or "hexahedron".
        X: geometry nodes in the order of `reference_nodes`, shape (num_geometry_nodes, gdim) [L].
        point: reference coordinates, shape (tdim) [1].
        hypothesis: "3d", "plane_strain", "plane_stress" or "axisymmetric".
        degree: degree of the field, 1 or 2.
        geometry_degree: degree of the geometry, 1 or 2.

    Returns:
        B, shape (num_strains, gdim n) [1/L].
    """
    cell = _cell(cell_type, degree, geometry_degree, (floats(point).reshape(1, -1), [1.0]), "stiffness", hypothesis)
    return _reference.element_b_matrix(cell, floats(X), hypothesis)


def _internal(
    cell_type: str,
    X: ArrayLike,
    material: Material,
    u: ArrayLike,
    degree: int,
    geometry_degree: int,
    rule: Rule,
    with_tangent: bool,
) -> tuple[float, FloatArray, FloatArray]:
    cell = _cell(cell_type, degree, geometry_degree, rule, _strain_purpose(material), material.hypothesis)
    return _reference.element_internal(cell, floats(X), material, vector(u), with_tangent)


def element_energy(
    cell_type: str,
    X: ArrayLike,
    material: Material,
    u: ArrayLike,
    degree: int = 1,
    geometry_degree: int = 1,
    rule: Rule = None,
) -> float:
    """Strain energy of given displacements.

    Args:
        cell_type: cell, "triangle", "quadrilateral", "tetrahedron" or "hexahedron".
        X: geometry nodes in the order of `reference_nodes`, shape (num_geometry_nodes, gdim) [L].
        material: material data and hypothesis.
        u: displacements of the nodes, shape (gdim n) or (n, gdim) [L].
        degree: degree of the field, 1 or 2.
        geometry_degree: degree of the geometry, 1 or 2.
        rule: None (default), a name for `quadrature`, or a pair (points, weights).

    Returns:
        Energy [F L].
    """
    return _internal(cell_type, X, material, u, degree, geometry_degree, rule, False)[0]


def element_internal_force(
    cell_type: str,
    X: ArrayLike,
    material: Material,
    u: ArrayLike,
    degree: int = 1,
    geometry_degree: int = 1,
    rule: Rule = None,
) -> FloatArray:
    """Internal force int B_L^T S dV, total Lagrangian (Bathe ch. 6.4); k_e u for a linear law.

    Args:
        cell_type: cell, "triangle", "quadrilateral", "tetrahedron" or "hexahedron".
        X: geometry nodes in the order of `reference_nodes`, shape (num_geometry_nodes, gdim) [L].
        material: material data and hypothesis.
        u: displacements of the nodes, shape (gdim n) or (n, gdim) [L].
        degree: degree of the field, 1 or 2.
        geometry_degree: degree of the geometry, 1 or 2.
        rule: None (default), a name for `quadrature`, or a pair (points, weights).

    Returns:
        Force, shape (gdim n) [F].
    """
    return _internal(cell_type, X, material, u, degree, geometry_degree, rule, False)[1]


def element_tangent(
    cell_type: str,
    X: ArrayLike,
    material: Material,
    u: ArrayLike,
    degree: int = 1,
    geometry_degree: int = 1,
    rule: Rule = None,
) -> FloatArray:
    """Derivative of the internal force: material and geometric stiffness.

    Args:
        cell_type: cell, "triangle", "quadrilateral", "tetrahedron" or "hexahedron".
        X: geometry nodes in the order of `reference_nodes`, shape (num_geometry_nodes, gdim) [L].
        material: material data and hypothesis.
        u: displacements of the nodes, shape (gdim n) or (n, gdim) [L].
        degree: degree of the field, 1 or 2.
        geometry_degree: degree of the geometry, 1 or 2.
        rule: None (default), a name for `quadrature`, or a pair (points, weights).

    Returns:
        Tangent, shape (gdim n, gdim n) [F/L].
    """
    return _internal(cell_type, X, material, u, degree, geometry_degree, rule, True)[2]


def element_stress(
    cell_type: str,
    X: ArrayLike,
    material: Material,
    u: ArrayLike,
    degree: int = 1,
    geometry_degree: int = 1,
    rule: Rule = None,
) -> FloatArray:
    """Stress at the points of a rule: Cauchy for a linear law, 2nd Piola-Kirchhoff otherwise.

    Args:
        cell_type: cell, "triangle", "quadrilateral", "tetrahedron" or "hexahedron".
        X: geometry nodes in the order of `reference_nodes`, shape (num_geometry_nodes, gdim) [L].
        material: material data and hypothesis.
        u: displacements of the nodes, shape (gdim n) or (n, gdim) [L].
        degree: degree of the field, 1 or 2.
        geometry_degree: degree of the geometry, 1 or 2.
        rule: None (default), a name for `quadrature`, or a pair (points, weights).

    Returns:
        Stress, shape (num_points, num_strains) [F/L^2].
    """
    cell = _cell(cell_type, degree, geometry_degree, rule, "stiffness", material.hypothesis)
    return _reference.element_stress(cell, floats(X), material, vector(u))


def second_piola(material: Material, F: ArrayLike) -> tuple[FloatArray, FloatArray, float]:
    """Stress, material tangent and energy of a law at a deformation gradient; Bonet & Wood ch. 5, 6.

    Args:
        material: material data and hypothesis.
        F: deformation gradient, shape (3, 3); F[2, 2] is not read in plane stress [1].

    Returns:
        S, shape (num_strains) [F/L^2]; dS/dE for engineering shears, shape (num_strains, num_strains) [F/L^2]; energy
        per reference volume [F/L^2]. For a linear law: sigma, D and the energy of small strain.

    Raises:
        ValueError: a neo-Hookean material with det F <= 0.
    """
    return _reference.second_piola(material, floats(F))


def element_mass(
    cell_type: str, X: ArrayLike, material: Material, degree: int = 1, geometry_degree: int = 1, rule: Rule = None
) -> FloatArray:
    """Consistent mass matrix int rho N^T N dV (Hughes ch. 7).

    Args:
        cell_type: cell, "triangle", "quadrilateral", "tetrahedron" or "hexahedron".
        X: geometry nodes in the order of `reference_nodes`, shape (num_geometry_nodes, gdim) [L].
        material: material data and hypothesis.
        degree: degree of the field, 1 or 2.
        geometry_degree: degree of the geometry, 1 or 2.
        rule: None (default), a name for `quadrature`, or a pair (points, weights).

    Returns:
        Mass, shape (gdim n, gdim n) [M].

    Raises:
        ValueError: the density is 0.
    """
    cell = _cell(cell_type, degree, geometry_degree, rule, "mass", material.hypothesis)
    return _reference.element_mass(cell, floats(X), material)


def element_lumped_mass(
    cell_type: str,
    X: ArrayLike,
    material: Material,
    scheme: str = "auto",
    degree: int = 1,
    geometry_degree: int = 1,
    rule: Rule = None,
) -> FloatArray:
    """Diagonal mass matrix. Its sum per direction is the mass of the cell.

    Args:
        cell_type: cell, "triangle", "quadrilateral", "tetrahedron" or "hexahedron".
        X: geometry nodes in the order of `reference_nodes`, shape (num_geometry_nodes, gdim) [L].
        material: material data and hypothesis.
        scheme: "row_sum", "hrz" (scaled diagonal, Hinton, Rock & Zienkiewicz 1976), "nodal" (quadrature at the nodes),
            or "auto": row_sum for degree 1, hrz for simplices and axisymmetric cells of degree 2, nodal for others.
        degree: degree of the field, 1 or 2.
        geometry_degree: degree of the geometry, 1 or 2.
        rule: None (default), a name for `quadrature`, or a pair (points, weights).

    Returns:
        Diagonal, shape (gdim n) [M].

    Raises:
        ValueError: the density is 0, or the scheme is unknown.
    """
    cell = _cell(cell_type, degree, geometry_degree, rule, "mass", material.hypothesis)
    return _reference.element_lumped_mass(cell, floats(X), material, scheme)


def element_damping(
    cell_type: str,
    X: ArrayLike,
    material: Material,
    alpha: float,
    beta: float,
    degree: int = 1,
    geometry_degree: int = 1,
    rule: Rule = None,
) -> FloatArray:
    """Rayleigh damping matrix alpha M + beta K, seed (3.67).

    Args:
        cell_type: cell, "triangle", "quadrilateral", "tetrahedron" or "hexahedron".
        X: geometry nodes in the order of `reference_nodes`, shape (num_geometry_nodes, gdim) [L].
        material: material data and hypothesis.
        alpha: factor of the mass [1/T].
        beta: factor of the stiffness [T].
        degree: degree of the field, 1 or 2.
        geometry_degree: degree of the geometry, 1 or 2.
        rule: None (default), a name for `quadrature`, or a pair (points, weights).

    Returns:
        Damping, shape (gdim n, gdim n) [F T/L].
    """
    K = element_stiffness(cell_type, X, material, degree, geometry_degree, rule)
    return (
        beta * K
        if alpha == 0
        else alpha * element_mass(cell_type, X, material, degree, geometry_degree, rule) + beta * K
    )


def element_body_force(
    cell_type: str,
    X: ArrayLike,
    f: ArrayLike,
    hypothesis: str | None = None,
    degree: int = 1,
    geometry_degree: int = 1,
    rule: Rule = None,
) -> FloatArray:
    """Load int N^T f dV of a constant force per volume.

    Args:
        cell_type: cell, "triangle", "quadrilateral", "tetrahedron" or "hexahedron".
        X: geometry nodes in the order of `reference_nodes`, shape (num_geometry_nodes, gdim) [L].
        f: force per volume, shape (gdim) [F/L^3].
        hypothesis: "axisymmetric" integrates over the full circumference; None: plane or space.
        degree: degree of the field, 1 or 2.
        geometry_degree: degree of the geometry, 1 or 2.
        rule: None (default), a name for `quadrature`, or a pair (points, weights).

    Returns:
        Load, shape (gdim n) [F].
    """
    cell = _cell(cell_type, degree, geometry_degree, rule, "load", hypothesis)
    return _reference.element_body_force(cell, floats(X), vector(f))


def element_traction(
    cell_type: str,
    X: ArrayLike,
    facet: Facet,
    t: ArrayLike,
    hypothesis: str | None = None,
    degree: int = 1,
    geometry_degree: int = 1,
    rule: Rule = None,
) -> FloatArray:
    """Load int N^T t dS of a constant traction on a facet.

    Args:
        cell_type: cell, "triangle", "quadrilateral", "tetrahedron" or "hexahedron".
        X: geometry nodes in the order of `reference_nodes`, shape (num_geometry_nodes, gdim) [L].
        facet: local number of the facet, or a list of its local nodes.
        t: traction, shape (gdim) [F/L^2].
        hypothesis: "axisymmetric" integrates over the full circumference; None: plane or space.
        degree: degree of the field, 1 or 2.
        geometry_degree: degree of the geometry, 1 or 2.
        rule: None (default), a name, or a pair (points, weights), on the facet's cell type.

    Returns:
        Load, shape (gdim n) [F].
    """
    cell = _cell(cell_type, degree, geometry_degree, rule, "facet", hypothesis)
    return _reference.element_traction(cell, floats(X), _facet(cell_type, facet), vector(t))


def element_foundation(
    cell_type: str,
    X: ArrayLike,
    facet: Facet,
    k: ArrayLike,
    hypothesis: str | None = None,
    degree: int = 1,
    geometry_degree: int = 1,
    rule: Rule = None,
) -> FloatArray:
    """Matrix int N^T D N dS of springs, or dashpots, between a facet and the ground.

    Args:
        cell_type: cell, "triangle", "quadrilateral", "tetrahedron" or "hexahedron".
        X: geometry nodes in the order of `reference_nodes`, shape (num_geometry_nodes, gdim) [L].
        facet: local number of the facet, or a list of its local nodes.
        k: one number, D = k n n^T with the normal n of the facet; or gdim numbers, D = diag(k) [F/L^3].
        hypothesis: "axisymmetric" integrates over the full circumference; None: plane or space.
        degree: degree of the field, 1 or 2.
        geometry_degree: degree of the geometry, 1 or 2.
        rule: None (default), a name, or a pair (points, weights), on the facet's cell type.

    Returns:
        Matrix, shape (gdim n, gdim n) [F/L].
    """
    cell = _cell(cell_type, degree, geometry_degree, rule, "facet", hypothesis)
    return _reference.element_foundation(cell, floats(X), _facet(cell_type, facet), vector(k))


def element_follower_pressure(
    cell_type: str,
    X: ArrayLike,
    u: ArrayLike,
    facet: Facet,
    p: float,
    hypothesis: str | None = None,
    degree: int = 1,
    geometry_degree: int = 1,
    rule: Rule = None,
) -> tuple[FloatArray, FloatArray]:
    """External force of a pressure that stays normal to the deformed facet, and its tangent.

    f_i = - int p N_i J F^-T n0 dA0 (Bonet & Wood ch. 8.5). Plane problems keep thickness 1 (plane stress too);
    axisymmetric ones use the current radius.

    Args:
        cell_type: cell, "triangle", "quadrilateral", "tetrahedron" or "hexahedron".
        X: geometry nodes in the order of `reference_nodes`, shape (num_geometry_nodes, gdim) [L].
        u: displacements of the nodes, shape (gdim n) or (n, gdim) [L].
        facet: local number of the facet, or a list of its local nodes.
        p: pressure, positive where it pushes on the surface [F/L^2].
        hypothesis: "axisymmetric" integrates over the full circumference; None: plane or space.
        degree: degree of the field, 1 or 2.
        geometry_degree: degree of the geometry, 1 or 2.
        rule: None (default), a name, or a pair (points, weights), on the facet's cell type.

    Returns:
        f, shape (gdim n) [F], and df/du, shape (gdim n, gdim n) [F/L].
    """
    cell = _cell(cell_type, degree, geometry_degree, rule, "facet", hypothesis)
    return _reference.element_follower_pressure(cell, floats(X), vector(u), _facet(cell_type, facet), float(p))


def _ale(
    cell_type: str,
    X: ArrayLike,
    material: Material,
    spin: ArrayLike,
    centre: ArrayLike,
    degree: int,
    geometry_degree: int,
    rule: Rule,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    cell = _cell(cell_type, degree, geometry_degree, rule, "mass", material.hypothesis)
    return _reference.element_ale(cell, floats(X), material, vector(spin), vector(centre))


def element_gyroscopic(
    cell_type: str,
    X: ArrayLike,
    material: Material,
    spin: ArrayLike,
    centre: ArrayLike,
    degree: int = 1,
    geometry_degree: int = 1,
    rule: Rule = None,
) -> FloatArray:
    """Gyroscopic matrix G = int rho (N^T A - A^T N) dV, seed (3.56).

    A = grad N . w with w = spin x (X - centre).

    Args:
        cell_type: cell, "triangle", "quadrilateral", "tetrahedron" or "hexahedron".
        X: geometry nodes in the order of `reference_nodes`, shape (num_geometry_nodes, gdim) [L].
        material: material data and hypothesis.
        spin: angular velocity: one number in the plane, shape (3) in space [1/T].
        centre: point on the axis of rotation, shape (gdim) [L].
        degree: degree of the field, 1 or 2.
        geometry_degree: degree of the geometry, 1 or 2.
        rule: None (default), a name for `quadrature`, or a pair (points, weights).

    Returns:
        G, shape (gdim n, gdim n) [M/T].

    Raises:
        ValueError: an axisymmetric material.
    """
    return _ale(cell_type, X, material, spin, centre, degree, geometry_degree, rule)[0]


def element_ale_inertia(
    cell_type: str,
    X: ArrayLike,
    material: Material,
    spin: ArrayLike,
    centre: ArrayLike,
    degree: int = 1,
    geometry_degree: int = 1,
    rule: Rule = None,
) -> FloatArray:
    """Inertia matrix W = int rho A^T A dV of a rotating frame, seed (3.57); A as in `element_gyroscopic`.

    Args:
        cell_type: cell, "triangle", "quadrilateral", "tetrahedron" or "hexahedron".
        X: geometry nodes in the order of `reference_nodes`, shape (num_geometry_nodes, gdim) [L].
        material: material data and hypothesis.
        spin: angular velocity: one number in the plane, shape (3) in space [1/T].
        centre: point on the axis of rotation, shape (gdim) [L].
        degree: degree of the field, 1 or 2.
        geometry_degree: degree of the geometry, 1 or 2.
        rule: None (default), a name for `quadrature`, or a pair (points, weights).

    Returns:
        W, shape (gdim n, gdim n) [M/T^2].

    Raises:
        ValueError: an axisymmetric material.
    """
    return _ale(cell_type, X, material, spin, centre, degree, geometry_degree, rule)[1]


def element_ale_load(
    cell_type: str,
    X: ArrayLike,
    material: Material,
    spin: ArrayLike,
    centre: ArrayLike,
    degree: int = 1,
    geometry_degree: int = 1,
    rule: Rule = None,
) -> FloatArray:
    """Load int rho A^T w dV of a rotating frame: the right-hand side of (K - W) u, seed (3.57).

    Args:
        cell_type: cell, "triangle", "quadrilateral", "tetrahedron" or "hexahedron".
        X: geometry nodes in the order of `reference_nodes`, shape (num_geometry_nodes, gdim) [L].
        material: material data and hypothesis.
        spin: angular velocity: one number in the plane, shape (3) in space [1/T].
        centre: point on the axis of rotation, shape (gdim) [L].
        degree: degree of the field, 1 or 2.
        geometry_degree: degree of the geometry, 1 or 2.
        rule: None (default), a name for `quadrature`, or a pair (points, weights).

    Returns:
        Load, shape (gdim n) [F].

    Raises:
        ValueError: an axisymmetric material.
    """
    return _ale(cell_type, X, material, spin, centre, degree, geometry_degree, rule)[2]


def element_poisson(
    cell_type: str,
    X: ArrayLike,
    k: float = 1.0,
    degree: int = 1,
    geometry_degree: int = 1,
    rule: Rule = None,
    hypothesis: str | None = None,
) -> FloatArray:
    """Matrix int k grad N_i . grad N_j dV of a scalar field.

    Args:
        cell_type: cell, "triangle", "quadrilateral", "tetrahedron" or "hexahedron".
        X: geometry nodes in the order of `reference_nodes`, shape (num_geometry_nodes, gdim) [L].
        k: diffusivity [1].
        degree: degree of the field, 1 or 2.
        geometry_degree: degree of the geometry, 1 or 2.
        rule: None (default), a name for `quadrature`, or a pair (points, weights).
        hypothesis: "axisymmetric" integrates over the full circumference; None: plane or space.

    Returns:
        Matrix, shape (n, n) [L^(gdim - 2)].
    """
    cell = _cell(cell_type, degree, geometry_degree, rule, "stiffness", hypothesis)
    return _reference.element_poisson(cell, floats(X), float(k))


def element_scalar_load(
    cell_type: str,
    X: ArrayLike,
    f: float,
    degree: int = 1,
    geometry_degree: int = 1,
    rule: Rule = None,
    hypothesis: str | None = None,
) -> FloatArray:
    """Load int f N_i dV of a scalar field for a constant source.

    Args:
        cell_type: cell, "triangle", "quadrilateral", "tetrahedron" or "hexahedron".
        X: geometry nodes in the order of `reference_nodes`, shape (num_geometry_nodes, gdim) [L].
        f: source per volume [1].
        degree: degree of the field, 1 or 2.
        geometry_degree: degree of the geometry, 1 or 2.
        rule: None (default), a name for `quadrature`, or a pair (points, weights).
        hypothesis: "axisymmetric" integrates over the full circumference; None: plane or space.

    Returns:
        Load, shape (n) [L^gdim].
    """
    cell = _cell(cell_type, degree, geometry_degree, rule, "load", hypothesis)
    return _reference.element_scalar_load(cell, floats(X), float(f))


def element_flux_load(
    cell_type: str,
    X: ArrayLike,
    facet: Facet,
    q: float,
    degree: int = 1,
    geometry_degree: int = 1,
    rule: Rule = None,
    hypothesis: str | None = None,
) -> FloatArray:
    """Load int q N_i dS of a scalar field for a constant flux through a facet.

    Args:
        cell_type: cell, "triangle", "quadrilateral", "tetrahedron" or "hexahedron".
        X: geometry nodes in the order of `reference_nodes`, shape (num_geometry_nodes, gdim) [L].
        facet: local number of the facet, or a list of its local nodes.
        q: flux per area [1].
        degree: degree of the field, 1 or 2.
        geometry_degree: degree of the geometry, 1 or 2.
        rule: None (default), a name, or a pair (points, weights), on the facet's cell type.
        hypothesis: "axisymmetric" integrates over the full circumference; None: plane or space.

    Returns:
        Load, shape (n) [L^(gdim - 1)].
    """
    cell = _cell(cell_type, degree, geometry_degree, rule, "facet", hypothesis)
    return _reference.element_flux_load(cell, floats(X), _facet(cell_type, facet), float(q))
