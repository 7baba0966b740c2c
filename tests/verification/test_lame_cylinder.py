# SPDX-License-Identifier: MIT
"""Thick cylinder under internal pressure (Lame; Timoshenko & Goodier, Theory of Elasticity, art. 28), plane strain."""

import numpy as np
import pytest
import ufl
from meshes_and_supports import block, clamp, rectangle, tagged, with_quadratic_geometry
from dolfinx import fem

from dolfinx_impact import LinearElastic, StaticProblem, Traction

A, B, P, E, NU = 1.0, 2.0, 0.3, 10.0, 0.3


def exact(r):
    """Radial displacement."""
    return (1 + NU) / E * P * A**2 / (B**2 - A**2) * ((1 - 2 * NU) * r + B**2 / r)


def quarter(n, cell, degree):
    """Quarter of a ring; with degree 2 the geometry is curved. The angle runs along y of the square."""
    domain = block(cell, n, distortion=0.0)
    if degree == 2:
        domain = with_quadratic_geometry(domain)
    domain.geometry.x[:, 0] = A + (B - A) * domain.geometry.x[:, 0]
    r, angle = domain.geometry.x[:, 0].copy(), np.pi / 2 * domain.geometry.x[:, 1]
    tags = tagged(
        domain,
        inner=lambda x: np.isclose(x[0], A),
        bottom=lambda x: np.isclose(x[1], 0),
        side=lambda x: np.isclose(x[1], 1),
    )
    domain.geometry.x[:, 0], domain.geometry.x[:, 1] = r * np.cos(angle), r * np.sin(angle)
    return domain, tags


def ring_error(n, cell, degree):
    domain, tags = quarter(n, cell, degree)
    V = fem.functionspace(domain, ("Lagrange", degree, (2,)))
    u = fem.Function(V, name="u")
    load = Traction(tags, 1, -P * ufl.FacetNormal(domain))
    bcs = [clamp(V, tags, 2, 1), clamp(V, tags, 3, 0)]
    StaticProblem(u, LinearElastic(E, NU, hypothesis="plane_strain"), bcs=bcs, loads=[load]).solve()
    x = V.tabulate_dof_coordinates()[:, :2]
    r = np.linalg.norm(x, axis=1)
    error = u.x.array.reshape(-1, 2) - (exact(r) / r)[:, None] * x
    return size(error)


def size(error):
    """Root mean square over the nodes: an L2 norm; pointwise, linear elements lose a logarithm of h."""
    return np.sqrt(np.mean(error**2)) / exact(A)


@pytest.mark.parametrize("cell", ["triangle", "quadrilateral"])
@pytest.mark.parametrize("degree", [1, 2])
def test_quarter_ring_in_plane_strain(cell, degree):
    coarse, fine = ring_error(8, cell, degree), ring_error(16, cell, degree)
    # Degree p converges with h^(p+1) in the displacement, the approximation of the circle included.
    assert np.log2(coarse / fine) > degree + 1 - 0.2
    assert fine < {1: 1e-2, 2: 2e-4}[degree]


@pytest.mark.parametrize("cell", ["triangle", "quadrilateral"])
@pytest.mark.parametrize("degree", [1, 2])
def test_section_in_axisymmetry(cell, degree):
    """The same cylinder as a section in (r, z), held between rigid plates: nodal values, and the plates' force."""
    errors = []
    for n in (8, 16):
        domain = rectangle(cell, (A, 0), (B, 0.5), (n, n // 2))
        tags = tagged(
            domain,
            inner=lambda x: np.isclose(x[0], A),
            bottom=lambda x: np.isclose(x[1], 0),
            top=lambda x: np.isclose(x[1], 0.5),
        )
        V = fem.functionspace(domain, ("Lagrange", degree, (2,)))
        u = fem.Function(V, name="u")
        bcs = [clamp(V, tags, 2, 1), clamp(V, tags, 3, 1)]
        steel = LinearElastic(E, NU, hypothesis="axisymmetric")
        problem = StaticProblem(u, steel, bcs=bcs, loads=[Traction(tags, 1, (P, 0.0))])
        problem.solve()
        r = V.tabulate_dof_coordinates()[:, 0]
        errors.append(size(u.x.array.reshape(-1, 2) - np.column_stack([exact(r), 0 * r])))
        top = fem.locate_dofs_topological(V, 1, tags.find(3))
        force = problem.reactions().x.array.reshape(-1, 2)[top, 1].sum()
    assert np.log2(errors[0] / errors[1]) > degree + 1 - 0.2
    assert errors[1] < {1: 1e-2, 2: 2e-4}[degree]
    # sigma_zz = 2 nu P A^2 / (B^2 - A^2) is constant; its resultant over the ring converges with h^(2p).
    assert force == pytest.approx(2 * NU * P * A**2 * np.pi, rel={1: 2e-2, 2: 1e-4}[degree])
