# SPDX-License-Identifier: MIT
"""Level b: assembled matrices and vectors on real meshes, matched node by node."""

import basix
import numpy as np
import ufl
from dolfinx import fem
from mpi4py import MPI

from ..assembly import lumped_mass, operators
from .. import materials
from ..forms import elasticity, inertia, loads, quadrature
from . import bodies

TOLERANCE = 1e-12
REASON = "round-off of sums over a cell and its neighbours"
LAWS = {
    "linear_elastic": materials.LinearElastic,
    "st_venant_kirchhoff": materials.StVenantKirchhoff,
    "neo_hookean": materials.NeoHookean,
}


def meshes(small=True):
    """(name, mesh on this rank, hypothesis, degrees) of the real meshes, gmsh's included."""
    from .. import meshes as recipes

    out = [
        ("block of distorted hexahedra", bodies.block("hexahedron", 4), "3d", (1, 2)),
        ("block of tetrahedra", bodies.block("tetrahedron", 3), "3d", (1, 2)),
        ("curved triangles", bodies.block("triangle", 5, 2), "plane_strain", (2,)),
        ("curved hexahedra", bodies.block("hexahedron", 2, 2), "3d", (2,)),
        ("axisymmetric block", bodies.block("quadrilateral", 6), "axisymmetric", (1, 2)),
        ("plane stress block", bodies.block("triangle", 6), "plane_stress", (1, 2)),
    ]
    wheel = recipes.make("wheel_on_rail_2d", comm=MPI.COMM_SELF, gap=1e-4)
    out.append(("wheel on rail", wheel.mesh, "plane_strain", (1,)))
    return out


def run(report, progress=True):
    """Add the rows of this level."""
    for name, domain, hypothesis, degrees in meshes():
        for degree in degrees:
            if not report.wants(domain.topology.cell_name(), degree):
                continue
            _linear(report, name, domain, hypothesis, degree)
            for law in ("st_venant_kirchhoff", "neo_hookean"):
                _finite(report, name, domain, hypothesis, degree, law)


def _rule(domain, degree, hypothesis, law):
    """Their rule for a stiffness; None, their own, where both sides are exact.

    Elsewhere both use one rule: Gauss-Legendre on quadrilaterals and hexahedra, and on simplices Basix's symmetric
    rule, handed over as points: a collapsed rule would depend on a cell's first vertex, which the two sides choose
    differently.
    """
    cell, g = domain.topology.cell_name(), domain.geometry.cmap.degree
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


def _measure(body, degree):
    return ufl.Measure("dx", domain=body.mesh, metadata=quadrature.metadata(degree))


def _row(report, body, form, name, ours, theirs):
    """Row of two numbers, vectors or matrices in our order."""
    element = (body.cell, body.degree, body.geometry_degree, body.hypothesis)
    if np.isscalar(ours):
        difference, note = abs(ours / theirs - 1), f"UFL {ours:.15g}, hand-written {theirs:.15g}"
    else:
        difference, note = bodies.parted(body, ours, theirs)
    report.add("operator", form, *element, difference, TOLERANCE, REASON, name, note)


def _linear(report, name, domain, hypothesis, degree):
    steel = materials.LinearElastic(2.0, 0.3, 1.5, hypothesis)
    theirs = _rule(domain, degree, hypothesis, "linear_elastic")
    body = bodies.Body(domain, degree, steel, "linear_elastic", theirs)
    V, u = body.V, _displacement(body)
    v, du = ufl.TestFunction(V), ufl.TrialFunction(V)
    g = body.geometry_degree
    dx = _measure(body, quadrature.stiffness_degree(body.cell, degree, g, hypothesis))
    law = steel.law(domain)
    K = bodies.petsc_to_scipy(operators.Tangent(elasticity.tangent(u, du, v, law, dx)).assemble())
    theirs_K = body.matrix_to_ours(body.model.stiffness())
    _row(report, body, "linear_elastic.tangent", f"K on {name}", K, theirs_K)
    f = operators.InternalForce(elasticity.internal_force(u, v, law, dx)).apply().array
    expected = body.to_ours(body.model.internal_force(body.to_theirs(u.x.array)))
    _row(report, body, "linear_elastic.force", f"f(u) on {name}", f, expected)
    energy = operators.Energy(elasticity.internal_energy(u, law, dx)).value()
    other = body.model.energy(body.to_theirs(u.x.array))
    _row(report, body, "linear_elastic.energy", f"energy on {name}", energy, other)
    _masses(report, name, body, steel)


def _masses(report, name, body, steel):
    # A model of its own: masses keep the default rule, which is exact, where the stiffness had to name one.
    domain, degree, hypothesis = body.mesh, body.degree, body.hypothesis
    body = bodies.Body(domain, degree, steel)
    V = body.V
    v, du = ufl.TestFunction(V), ufl.TrialFunction(V)
    used = quadrature.mass_degree(body.cell, degree, body.geometry_degree, hypothesis)
    dx = _measure(body, used)
    M = bodies.petsc_to_scipy(
        operators.Tangent(inertia.mass(du, v, steel.density_constant(domain), hypothesis, dx)).assemble()
    )
    _row(report, body, "mass", f"M on {name}", M, body.matrix_to_ours(body.model.mass()))
    diagonal = lumped_mass.lumped_mass(V, steel).array
    expected = body.to_ours(body.model.mass(lumped=True))
    _row(report, body, "lumped_mass", f"diagonal on {name}", diagonal, expected)
    f = np.arange(1.0, body.gdim + 1)
    b = operators.InternalForce(loads.body_force(fem.Constant(domain, f), v, hypothesis, dx)).apply().array
    _row(report, body, "body_force", f"load on {name}", b, body.to_ours(body.model.body_force(f)))


def _displacement(body):
    u = fem.Function(body.V, name="u")
    size = np.ptp(body.points, axis=0).max()
    dim = body.gdim
    u.interpolate(
        lambda x: 0.03 * size * np.array([np.sin(2 * x[i] / size + x[(i + 1) % dim] / size) for i in range(dim)])
    )
    return u


def _finite(report, name, domain, hypothesis, degree, law_name):
    rubber = LAWS[law_name](2.0, 0.3, 1.5, hypothesis)
    theirs = _rule(domain, degree, hypothesis, law_name)
    body = bodies.Body(domain, degree, rubber, law_name, theirs)
    u, V = _displacement(body), body.V
    v, du = ufl.TestFunction(V), ufl.TrialFunction(V)
    dx = _measure(body, quadrature.stiffness_degree(body.cell, degree, body.geometry_degree, hypothesis))
    law = rubber.law(domain)
    f = operators.InternalForce(elasticity.internal_force(u, v, law, dx)).apply().array
    at = body.to_theirs(u.x.array)
    expected = body.to_ours(body.model.internal_force(at))
    _row(report, body, f"{law_name}.force", f"f(u) on {name}", f, expected)
    K = bodies.petsc_to_scipy(operators.Tangent(elasticity.tangent(u, du, v, law, dx)).assemble())
    _row(report, body, f"{law_name}.tangent", f"K(u) on {name}", K, body.matrix_to_ours(body.model.tangent(at)))
