# SPDX-License-Identifier: MIT
"""Stresses of materials and of maps of them against formulas of the finite-strain literature, in NumPy. See
on_ranks.py."""

import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI
from scipy.optimize import brentq

import dolfinx_impact as di

COMM = MPI.COMM_WORLD
E, NU = 2.5, 0.3
LAMBDA, MU = E * NU / ((1 + NU) * (1 - 2 * NU)), E / (2 * (1 + NU))
# Gradient of a displacement; with two rows and columns it is that of a plane body.
GRADIENT = np.array([[0.2, 0.1, 0.05], [-0.15, 0.1, 0.0], [0.0, 0.1, -0.1]])
HYPOTHESES = ("3d", "plane_strain", "plane_stress", "axisymmetric")


def linear(F):
    strain = (F + F.T) / 2 - np.eye(3)
    return LAMBDA * np.trace(strain) * np.eye(3) + 2 * MU * strain


def neo_hooke(F):
    J = np.linalg.det(F)
    return (MU * (F @ F.T - np.eye(3)) + LAMBDA * np.log(J) * np.eye(3)) / J


def st_venant_kirchhoff(F):
    strain = (F.T @ F - np.eye(3)) / 2
    return F @ (LAMBDA * np.trace(strain) * np.eye(3) + 2 * MU * strain) @ F.T / np.linalg.det(F)


LAWS = {di.LinearElastic: linear, di.NeoHookean: neo_hooke, di.StVenantKirchhoff: st_venant_kirchhoff}


def body(hypothesis):
    if hypothesis == "3d":
        return mesh.create_unit_cube(COMM, 2, 1, 1)
    return mesh.create_rectangle(COMM, [(1.0, 0.0), (2.0, 1.0)], [2, 2])


def expected(cauchy, hypothesis, hoop=0.0):
    """Cauchy stress of GRADIENT; that of the stretch without stress across the plane in plane stress."""
    H = np.zeros((3, 3))
    size = 3 if hypothesis == "3d" else 2
    H[:size, :size] = GRADIENT[:size, :size]
    H[2, 2] += hoop

    def at(stretch):
        return cauchy(np.eye(3) + H + np.diag([0, 0, stretch - 1]))

    return at(brentq(lambda s: at(s)[2, 2], 0.3, 2.0, xtol=1e-15) if hypothesis == "plane_stress" else 1.0)


def displacement(domain):
    gdim = domain.geometry.dim
    u = fem.Function(fem.functionspace(domain, ("Lagrange", 1, (gdim,))))
    u.interpolate(lambda x: GRADIENT[:gdim, :gdim] @ x[:gdim])
    return u


def at_middle(expression, domain):
    """Values in the middle of every owned cell."""
    dim = domain.topology.dim
    return di.PointValues(expression, np.full((1, dim), 1 / (dim + 1))).values()[:, 0]


def check_cauchy_stresses():
    for hypothesis in HYPOTHESES:
        domain = body(hypothesis)
        u = displacement(domain)
        for law, cauchy in LAWS.items():
            steel = law(E, NU, hypothesis=hypothesis)
            found = at_middle(steel.cauchy_stress(u), domain).reshape(-1, 3, 3)
            x = mesh.compute_midpoints(domain, domain.topology.dim, np.arange(len(found), dtype=np.int32))
            for middle, stress in zip(x, found):
                radial = GRADIENT[0, :2] @ middle[:2] / middle[0] if hypothesis == "axisymmetric" else 0.0
                # brentq's root is good to 1e-15, twice differentiated by nothing.
                np.testing.assert_allclose(stress, expected(cauchy, hypothesis, radial), rtol=0, atol=1e-12)
            if law is not di.LinearElastic:
                continue
            deviator = found - np.trace(found, axis1=1, axis2=2)[:, None, None] * np.eye(3) / 3
            mises = at_middle(steel.von_mises(u), domain)[:, 0]
            np.testing.assert_allclose(mises, np.sqrt(1.5 * np.sum(deviator**2, axis=(1, 2))), rtol=1e-13)


def check_maps():
    """In each cell the stress of its material; 2 x 2 in sheets."""
    for hypothesis, name in (("plane_stress", "stress"), ("3d", "cauchy_stress"), ("axisymmetric", "von_mises")):
        domain = body(hypothesis)
        dim, u = domain.topology.dim, displacement(domain)
        num_cells = domain.topology.index_map(dim).size_local
        number = np.arange(num_cells, dtype=np.int32)
        middles = mesh.compute_midpoints(domain, dim, number)[:, 0]
        values = np.where(middles > np.median(middles), 9, np.where(middles > 0.8 * np.median(middles), 4, 2))
        values = np.asarray(values, dtype=np.int32)
        values[: min(3, num_cells)] = [9, 4, 2][: min(3, num_cells)]
        tags = mesh.meshtags(domain, dim, number, values)
        materials = {t: law(E * t, NU, hypothesis=hypothesis) for t, law in zip((9, 4, 2), LAWS)}
        several = di.MaterialMap(tags, materials)
        found = at_middle(getattr(several, name)(u), domain)
        for tag, material in materials.items():
            alone = at_middle(getattr(material, name)(u), domain)
            np.testing.assert_allclose(found[values == tag], alone[values == tag], rtol=1e-14, atol=1e-15)
        assert several.stress(u).ufl_shape == ((2, 2) if hypothesis == "plane_stress" else (3, 3))


def check_a_branch_that_is_no_number():
    """Cells that are turned inside out have no logarithm of their volume: those of another material have a stress."""
    domain = body("plane_strain")
    number = np.arange(domain.topology.index_map(2).size_local, dtype=np.int32)
    tags = mesh.meshtags(domain, 2, number, np.where(number % 2, 5, 6).astype(np.int32))
    materials = {
        5: di.LinearElastic(E, NU, hypothesis="plane_strain"),
        6: di.NeoHookean(E, NU, hypothesis="plane_strain"),
    }
    u = displacement(domain)
    u.interpolate(lambda x: np.array([-2.0 * x[0], 0.0 * x[0]]))
    found = at_middle(di.MaterialMap(tags, materials).stress(u), domain)
    assert np.all(np.isfinite(found[number % 2 == 1])) and not np.any(np.isfinite(found[number % 2 == 0, 0]))


def check_expressions_of_displacements():
    domain = body("plane_strain")
    u, v = displacement(domain), ufl.TestFunction(displacement(domain).function_space)
    steel = di.LinearElastic(E, NU, hypothesis="plane_strain")
    twice, once = (at_middle(steel.stress(w), domain) for w in (2 * u, u))
    np.testing.assert_allclose(twice, 2 * once, rtol=1e-14, atol=1e-15)
    assert steel.stress(v).ufl_shape == (3, 3)
    with pytest.raises(TypeError, match="a displacement is a Function"):
        steel.stress(3.0)
    with pytest.raises(TypeError, match="a displacement is a Function"):
        steel.stress(ufl.SpatialCoordinate(domain))


def check_what_maps_refuse():
    domain, other = body("plane_strain"), body("plane_strain")
    number = np.arange(domain.topology.index_map(2).size_local, dtype=np.int32)
    tags = mesh.meshtags(domain, 2, number, np.full(len(number), 1, dtype=np.int32))
    with pytest.raises(ValueError, match="another mesh than u"):
        di.MaterialMap(tags, {1: di.LinearElastic(E, NU, hypothesis="plane_strain")}).stress(displacement(other))
    with pytest.raises(TypeError, match="problem.stress"):
        di.MaterialMap(tags, {1: di.J2Plasticity(E, NU, yield_stress=1.0, hypothesis="plane_strain")}).von_mises(
            displacement(domain)
        )
