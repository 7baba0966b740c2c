# SPDX-License-Identifier: MIT
"""Uniaxial stretch of a bar with free sides: lateral stretch and force against the scalar closed form of the law."""

import numpy as np
import pytest
from meshes_and_supports import block, clamp, tagged
from dolfinx import fem
from scipy.optimize import brentq

from dolfinx_impact import NeoHookean, StaticProblem, StVenantKirchhoff

E, NU = 2.0, 0.35
LAMBDA, MU = E * NU / ((1 + NU) * (1 - 2 * NU)), E / (2 * (1 + NU))


def neo_hookean(stretch):
    """(lateral stretch, nominal stress) of psi = mu/2 (I1 - 3) - mu ln J + lambda/2 (ln J)^2 without lateral stress."""

    def lateral_stress(t):
        return MU * (t**2 - 1) + LAMBDA * np.log(stretch * t**2)

    t = brentq(lateral_stress, 0.3, 2.0, xtol=1e-15, rtol=1e-15)
    return t, MU * (stretch - 1 / stretch) + LAMBDA * np.log(stretch * t**2) / stretch


def st_venant_kirchhoff(stretch):
    """Hooke's law between S and Green's strain: lateral strain -nu E_xx, P = stretch E E_xx."""
    strain = (stretch**2 - 1) / 2
    return np.sqrt(1 - 2 * NU * strain), stretch * E * strain


@pytest.mark.parametrize("law, closed", [(NeoHookean, neo_hookean), (StVenantKirchhoff, st_venant_kirchhoff)])
@pytest.mark.parametrize("stretch", [0.85, 1.02, 1.4])
@pytest.mark.parametrize(
    "cell, degree, hypothesis",
    [
        ("triangle", 2, "plane_stress"),
        ("quadrilateral", 1, "plane_stress"),
        ("hexahedron", 1, "3d"),
        ("tetrahedron", 1, "3d"),
    ],
)
def test_stretch(law, closed, stretch, cell, degree, hypothesis):
    domain = block(cell, 2)
    dim = domain.geometry.dim
    places = [lambda x, i=i: np.isclose(x[i], 0) for i in range(dim)]
    tags = tagged(domain, end=lambda x: np.isclose(x[0], 1), **{f"low{i}": p for i, p in enumerate(places)})
    V = fem.functionspace(domain, ("Lagrange", degree, (dim,)))
    u = fem.Function(V, name="u")
    bcs = [clamp(V, tags, 1, 0, stretch - 1)] + [clamp(V, tags, 2 + i, i) for i in range(dim)]
    problem = StaticProblem(u, law(E, NU, hypothesis=hypothesis), bcs=bcs)
    problem.solve(rtol=1e-13)
    lateral, stress = closed(stretch)
    x = V.tabulate_dof_coordinates()[:, :dim]
    expected = x * ([stretch - 1] + [lateral - 1] * (dim - 1))
    # The deformation is uniform, so elements of any degree hold it exactly: round-off and Newton's last step remain.
    np.testing.assert_allclose(u.x.array.reshape(-1, dim), expected, atol=1e-11)
    end = fem.locate_dofs_topological(V, dim - 1, tags.find(1))
    force = problem.reactions().x.array.reshape(-1, dim)[end, 0].sum()  # on a face of area 1
    assert force == pytest.approx(stress, abs=1e-11)


def test_the_closed_forms_agree_at_small_strain():
    """Both have Young's modulus E and Poisson's ratio nu at the start, to first order in a strain of 1e-6."""
    for closed in (neo_hookean, st_venant_kirchhoff):
        lateral, stress = closed(1 + 1e-6)
        assert stress == pytest.approx(E * 1e-6, rel=1e-5) and 1 - lateral == pytest.approx(NU * 1e-6, rel=1e-5)
