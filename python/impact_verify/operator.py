# SPDX-License-Identifier: MIT
"""Level b: assembled matrices and vectors on real meshes, matched node by node."""

from typing import TypeAlias, Union

import basix
import numpy as np
import ufl
from dolfinx import fem, mesh
from dolfinx.fem import Function
from dolfinx.mesh import Mesh, MeshTags
from mpi4py import MPI
from scipy.sparse import csr_matrix

from dolfinx_impact.own_forms import distorted_block
from dolfinx_impact import compat, materials
from dolfinx_impact.assembly import lumped_mass, operators
from dolfinx_impact.common.types import FloatArray
from dolfinx_impact.forms import elasticity, inertia, loads, quadrature
from dolfinx_impact.foundation import Foundation
from . import differences, matched_body
from .nodes import TheirRule
from .report import Report

# Name, mesh, hypothesis and degrees of the displacement.
NamedMesh: TypeAlias = tuple[str, Mesh, str, tuple[int, ...]]
Values: TypeAlias = Union[float, FloatArray, csr_matrix]

TOLERANCE = 1e-12
REASON = "round-off of sums over a cell and its neighbours"
LAWS: dict[str, type[matched_body.Material]] = {
    "linear_elastic": materials.LinearElastic,
    "st_venant_kirchhoff": materials.StVenantKirchhoff,
    "neo_hookean": materials.NeoHookean,
}


def meshes() -> list[NamedMesh]:
    """Meshes of this level, one made by gmsh included.

    Returns:
        Name, mesh on this rank, hypothesis and degrees of the displacement of each.
    """
    from dolfinx_impact import meshes as recipes  # type: ignore[attr-defined,unused-ignore]  # installed beside it

    out: list[NamedMesh] = [
        ("block of distorted hexahedra", distorted_block.block("hexahedron", 4), "3d", (1, 2)),
        ("block of tetrahedra", distorted_block.block("tetrahedron", 3), "3d", (1, 2)),
        ("curved triangles", distorted_block.block("triangle", 5, 2), "plane_strain", (2,)),
        ("curved hexahedra", distorted_block.block("hexahedron", 2, 2), "3d", (2,)),
        ("axisymmetric block", distorted_block.block("quadrilateral", 6), "axisymmetric", (1, 2)),
        ("plane stress block", distorted_block.block("triangle", 6), "plane_stress", (1, 2)),
    ]
    wheel = recipes.make("wheel_on_rail_2d", comm=MPI.COMM_SELF, gap=1e-4)
    out.append(("wheel on rail", wheel.mesh, "plane_strain", (1,)))
    return out


def run(report: Report, progress: bool = True) -> None:
    """Add the rows of this level.

    Args:
        report: report to add to.
        progress: not used; all levels share these arguments.
    """
    for name, domain, hypothesis, degrees in meshes():
        for degree in degrees:
            if not report.wants(domain.topology.cell_name(), degree):
                continue
            _linear(report, name, domain, hypothesis, degree)
            _foundation(report, name, domain, hypothesis, degree)
            for law in ("st_venant_kirchhoff", "neo_hookean"):
                _finite(report, name, domain, hypothesis, degree, law)


def stiffness_rule(domain: Mesh, degree: int, hypothesis: str, law: str) -> TheirRule:
    """Rule of the other side for a stiffness.

    Where the default rules of both sides are exact, each side keeps its own. Elsewhere both use one rule:
    Gauss-Legendre on quadrilaterals and hexahedra, and Basix's symmetric rule on simplices. A collapsed rule would
    depend on a cell's first vertex, which the two sides choose differently.

    Args:
        domain: mesh.
        degree: degree of the displacement, 1 or 2.
        hypothesis: hypothesis of the material.
        law: name of the law.

    Returns:
        Name of the rule, its points and weights, or None for the default.
    """
    cell, g = domain.topology.cell_name(), compat.coordinate_element(domain).degree
    if (
        cell in quadrature.SIMPLICES
        and g == 1
        and hypothesis != "axisymmetric"
        and (law == "linear_elastic" or degree == 1)
    ):
        return None
    used = quadrature.stiffness_degree(cell, degree, g, hypothesis)
    if cell in quadrature.SIMPLICES:
        return basix.make_quadrature(getattr(basix.CellType, cell), used)
    return f"gauss_jacobi:{used}"


def _measure(body: matched_body.Body, degree: int) -> ufl.Measure:
    return ufl.Measure("dx", domain=body.mesh, metadata=quadrature.metadata(degree))


def _row(report: Report, body: matched_body.Body, form: str, name: str, ours: Values, theirs: Values) -> None:
    """Add the row of two numbers, vectors or sparse matrices in our order."""
    element = (body.cell, body.degree, body.geometry_degree, body.hypothesis)
    if isinstance(ours, float):
        difference, note = abs(ours / theirs - 1), f"UFL {ours:.15g}, hand-written {theirs:.15g}"
    else:
        difference, note = differences.largest_difference(body, ours, theirs)
    report.add("operator", form, *element, difference, TOLERANCE, REASON, name, note)


def _linear(report: Report, name: str, domain: Mesh, hypothesis: str, degree: int) -> None:
    steel = materials.LinearElastic(2.0, 0.3, 1.5, hypothesis)
    theirs = stiffness_rule(domain, degree, hypothesis, "linear_elastic")
    body = matched_body.Body(domain, degree, steel, "linear_elastic", theirs)
    V, u = body.V, _displacement(body)
    v, du = ufl.TestFunction(V), ufl.TrialFunction(V)
    g = body.geometry_degree
    dx = _measure(body, quadrature.stiffness_degree(body.cell, degree, g, hypothesis))
    law = steel.law(domain)
    K = differences.petsc_to_scipy(operators.Tangent(elasticity.tangent(u, du, v, law, dx)).assemble())
    theirs_K = body.matrix_to_ours(body.model.stiffness())
    _row(report, body, "linear_elastic.tangent", f"K on {name}", K, theirs_K)
    f = operators.InternalForce(elasticity.internal_force(u, v, law, dx)).apply().array
    expected = body.to_ours(body.model.internal_force(body.to_theirs(u.x.array)))
    _row(report, body, "linear_elastic.force", f"f(u) on {name}", f, expected)
    energy = operators.Energy(elasticity.internal_energy(u, law, dx)).value()
    other = body.model.energy(body.to_theirs(u.x.array))
    _row(report, body, "linear_elastic.energy", f"energy on {name}", energy, other)
    _masses(report, name, body, steel)


def _foundation(report: Report, name: str, domain: Mesh, hypothesis: str, degree: int) -> None:
    """Springs under the whole boundary, along the normal and along the coordinates."""
    body = matched_body.Body(domain, degree, materials.LinearElastic(2.0, 0.3, 1.5, hypothesis))
    tags, V = _boundary(domain), body.V
    body.model.facet_rule = matched_body.foundation_rule(body)
    v, du = ufl.TestFunction(V), ufl.TrialFunction(V)
    for form, springs in (
        ("normal_foundation_tangent", 0.7),
        ("foundation_tangent", np.arange(1.0, body.gdim + 1)),
    ):
        foundation = Foundation(tags, 1, springs)
        K = differences.petsc_to_scipy(operators.Tangent(foundation.springs(du, v, hypothesis)).assemble())
        theirs = body.matrix_to_ours(body.model.foundation(body.their_facets(tags, 1), springs))
        _row(report, body, form, f"springs under {name}", K, theirs)


def _boundary(domain: Mesh) -> MeshTags:
    """All facets of the boundary, tag 1."""
    dim = domain.topology.dim - 1
    domain.topology.create_connectivity(dim, dim + 1)
    facets = mesh.exterior_facet_indices(domain.topology)
    return mesh.meshtags(domain, dim, facets, np.full(len(facets), 1, dtype=np.int32))


def _masses(report: Report, name: str, body: matched_body.Body, steel: materials.LinearElastic) -> None:
    # A second model, because masses keep the default rule, which is exact, where the stiffness has a named one.
    domain, degree, hypothesis = body.mesh, body.degree, body.hypothesis
    body = matched_body.Body(domain, degree, steel)
    V = body.V
    v, du = ufl.TestFunction(V), ufl.TrialFunction(V)
    used = quadrature.mass_degree(body.cell, degree, body.geometry_degree, hypothesis)
    dx = _measure(body, used)
    M = differences.petsc_to_scipy(
        operators.Tangent(inertia.mass(du, v, steel.density_constant(domain), hypothesis, dx)).assemble()
    )
    _row(report, body, "mass", f"M on {name}", M, body.matrix_to_ours(body.model.mass()))
    diagonal = lumped_mass.lumped_mass(V, steel).array
    expected = body.to_ours(body.model.mass(lumped=True))
    _row(report, body, "lumped_mass", f"diagonal on {name}", diagonal, expected)
    f = np.arange(1.0, body.gdim + 1)
    b = operators.InternalForce(loads.body_force(fem.Constant(domain, f), v, hypothesis, dx)).apply().array
    _row(report, body, "body_force", f"load on {name}", b, body.to_ours(body.model.body_force(f)))


def _displacement(body: matched_body.Body) -> Function:
    u = fem.Function(body.V, name="u")
    size = np.ptp(body.points, axis=0).max()
    dim = body.gdim
    u.interpolate(
        lambda x: 0.03 * size * np.array([np.sin(2 * x[i] / size + x[(i + 1) % dim] / size) for i in range(dim)])
    )
    return u


def _finite(report: Report, name: str, domain: Mesh, hypothesis: str, degree: int, law_name: str) -> None:
    rubber = LAWS[law_name](2.0, 0.3, 1.5, hypothesis)
    theirs = stiffness_rule(domain, degree, hypothesis, law_name)
    body = matched_body.Body(domain, degree, rubber, law_name, theirs)
    u, V = _displacement(body), body.V
    v, du = ufl.TestFunction(V), ufl.TrialFunction(V)
    dx = _measure(body, quadrature.stiffness_degree(body.cell, degree, body.geometry_degree, hypothesis))
    law = rubber.law(domain)
    f = operators.InternalForce(elasticity.internal_force(u, v, law, dx)).apply().array
    at = body.to_theirs(u.x.array)
    expected = body.to_ours(body.model.internal_force(at))
    _row(report, body, f"{law_name}.force", f"f(u) on {name}", f, expected)
    K = differences.petsc_to_scipy(operators.Tangent(elasticity.tangent(u, du, v, law, dx)).assemble())
    _row(report, body, f"{law_name}.tangent", f"K(u) on {name}", K, body.matrix_to_ours(body.model.tangent(at)))
