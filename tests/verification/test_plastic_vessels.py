# SPDX-License-Identifier: MIT
"""Thick sphere and thick cylinder of a perfectly plastic material under internal pressure: benchmarks J-1 and J-2 (Hill
1950, chapter V; Souza Neto, Peric, Owen 2008, section 7.5.1). Lengths in mm, stresses in GPa.

Found, relative to the closed form, for the front at 100, 120, 150 and 180 mm:

    sphere, linear with B-bar, 32 by 32    u_b -.04, -.12, -.11, -.36 %    limit +.09 % (16 by 16)
    sphere, degree 2, 8 by 8               u_b -.00, +.11, -.00, -.17 %    limit -.07 %
    cylinder, linear with B-bar, 16 by 16  u_b       -.12, +.04 %          limit +.08 %
    cylinder, degree 2, 8 by 8             u_b       +.10, +.27 %          limit -.01 %
"""

import numpy as np
import pytest
import ufl
from dolfinx import fem
from meshes_and_supports import clamp, rectangle, tagged, value_at, with_quadratic_geometry

import dolfinx_impact as di
from dolfinx_impact.theory import plasticity as theory

A, B, E, NU, Y = 100.0, 200.0, 210.0, 0.3, 0.24


class Vessel:
    """A quarter of a ring from A to B: section of a sphere ("axisymmetric") or of a cylinder ("plane_strain").

    Args:
        hypothesis: hypothesis of the material.
        degree: degree of displacement and geometry [1].
        n: number of cells along the radius and along the quarter of the circle [1].
        average: of J2Plasticity.
    """

    def __init__(self, hypothesis, degree=1, n=(16, 16), average="auto"):
        domain = rectangle("quadrilateral", (0.0, 0.0), (1.0, 1.0), n)
        if degree == 2:
            domain = with_quadratic_geometry(domain)
        x = domain.geometry.x
        x[:, 0] = A + (B - A) * x[:, 0]
        r, angle = x[:, 0].copy(), np.pi / 2 * x[:, 1]
        places = dict(
            inner=lambda x: np.isclose(x[0], A),
            bottom=lambda x: np.isclose(x[1], 0),
            side=lambda x: np.isclose(x[1], 1),
        )
        tags = tagged(domain, **places)
        x[:, 0], x[:, 1] = r * np.cos(angle), r * np.sin(angle)
        self.V = V = fem.functionspace(domain, ("Lagrange", degree, (2,)))
        self.u = fem.Function(V, name="u")
        self.load = di.Traction(tags, 1, -ufl.FacetNormal(domain))  # its constant is the pressure
        steel = di.J2Plasticity(E, NU, yield_stress=Y, hypothesis=hypothesis, average=average)
        bcs = [clamp(V, tags, 2, 1), clamp(V, tags, 3, 0)]
        self.problem = di.StaticProblem(self.u, steel, bcs=bcs, loads=[self.load])

    def press(self, pressure, steps=2):
        """Load up to a pressure [F/L^2]; returns the report."""
        self.load.constant.value = pressure
        return self.problem.solve(steps=steps)

    def limit(self, beyond):
        """Largest pressure with an equilibrium, found by cutting back on the way to one beyond the limit [F/L^2]."""
        self.load.constant.value = beyond
        with pytest.raises(RuntimeError):
            self.problem.solve(steps=10, cut_backs=7)
        ((_, reached),) = self.load.ramps()
        return float(reached)

    def widening(self, radius):
        """Radial displacement of the node on the x axis [L]."""
        return value_at(self.u, (radius, 0.0))[0]


def displacements(vessel, theory_of, fronts):
    """Errors of the displacements of the inner and the outer surface, one row per front, relative to the theory."""
    errors = []
    for front in fronts:
        exact = theory_of(A, B, E, NU, Y, front=front)
        vessel.press(exact.pressure)
        found = np.array([vessel.widening(A), vessel.widening(B)])
        errors.append(found / [exact.inner_displacement, exact.outer_displacement] - 1)
        print(f"front {front}: u_a {errors[-1][0]:+.2%}, u_b {errors[-1][1]:+.2%}")
    return np.array(errors)


@pytest.mark.parametrize("degree, n", [(1, (32, 32)), (2, (8, 8))], ids=["B-bar", "degree 2"])
def test_thick_sphere(degree, n):
    """J-1: the displacement of the outer surface for four fronts, 0.5 %."""
    sphere = Vessel("axisymmetric", degree, n)
    errors = displacements(sphere, theory.plastic_sphere, (100.0, 120.0, 150.0, 180.0))
    assert np.abs(errors[:, 1]).max() < 0.005


@pytest.mark.parametrize("degree, n", [(1, (16, 16)), (2, (8, 8))], ids=["B-bar", "degree 2"])
def test_limit_of_the_thick_sphere(degree, n):
    """J-1: the limit pressure, 0.5 %."""
    sphere = Vessel("axisymmetric", degree, n)
    limit = sphere.limit(1.02 * 0.332711)
    print(f"limit {limit / 0.332711 - 1:+.2%}")
    assert limit == pytest.approx(0.332711, rel=0.005)
    assert theory.plastic_sphere(A, B, E, NU, Y, front=A).limit == pytest.approx(0.332711, rel=1e-5)


@pytest.mark.parametrize("degree, n", [(1, (12, 12)), (2, (8, 8))])
def test_without_the_mean_dilatation_there_is_no_limit(degree, n):
    """The check above must see cells that lock: they bear more than the limit pressure."""
    sphere = Vessel("axisymmetric", degree, n, average=False)
    sphere.press(1.02 * 0.332711, steps=4)


@pytest.mark.parametrize("degree, n", [(1, (16, 16)), (2, (8, 8))], ids=["B-bar", "degree 2"])
def test_thick_cylinder(degree, n):
    """J-2: the limit pressure, 0.5 %; the widening, 1 % (its closed form is that of nu = 1/2 beyond the front)."""
    cylinder = Vessel("plane_strain", degree, n)
    errors = displacements(cylinder, theory.plastic_cylinder, (120.0, 150.0))
    assert np.abs(errors[:, 1]).max() < 0.01
    limit = cylinder.limit(1.02 * 0.192091)
    print(f"limit {limit / 0.192091 - 1:+.2%}")
    assert limit == pytest.approx(0.192091, rel=0.005)
    assert theory.plastic_cylinder(A, B, E, NU, Y, front=A).limit == pytest.approx(0.192091, rel=1e-5)
