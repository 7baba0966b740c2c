# SPDX-License-Identifier: MIT
"""NodalMean, AveragedKinematics, AverageTerm: uniform strain, rotations, softer than plain cells, what is refused."""

import warnings

import averaged_pressure_checks
import numpy as np
import pytest
import ufl
from averaged_pressure_checks import bent, cube, owned_product
from dolfinx import fem, mesh
from mpi4py import MPI
from on_ranks import rank_tests

import dolfinx_impact as di
from dolfinx_impact.assembly import operators
from dolfinx_impact.assembly.locking import Locking

test_one_rank, test_several_ranks = rank_tests(averaged_pressure_checks)


def force(u, material):
    form = operators.internal_force_form(u, ufl.TestFunction(u.function_space), material)
    return operators.InternalForce(form).apply().array


def neo_hooke(integration, nu=0.4):
    return di.NeoHookean(1.0, nu, 1.0, integration=integration)


def test_uniform_strain_and_rotation():
    """Each node's mean is the value of its cells: the forces are those of plain cells; after a rotation there are
    none. Limits are round-off of forces of strains of 1."""
    V = cube()
    u = fem.Function(V, name="u")
    u.interpolate(lambda x: np.array([0.2 * x[0] + 0.1 * x[1], 0.1 * x[2], 0.3 * x[0] - 0.1 * x[2]]))
    plain, averaged = force(u, neo_hooke("full")), force(u, neo_hooke("averaged_pressure"))
    assert np.abs(plain - averaged).max() < 1e-13 and np.abs(plain).max() > 1e-3
    c, s = np.cos(1.0), np.sin(1.0)
    u.interpolate(lambda x: np.array([c * x[0] - s * x[1] - x[0], s * x[0] + c * x[1] - x[1], 0 * x[0]]))
    assert np.abs(force(u, neo_hooke("averaged_pressure"))).max() < 1e-13


def test_it_is_softer_than_plain_cells():
    """By Jensen's inequality, in every direction: the stable step of plain cells is a bound. Nearly incompressible."""
    V = cube()
    d = bent(V, 1e-3)
    linear = {how: di.LinearElastic(1.0, 0.499, 1.0, integration=how) for how in ("full", "averaged_pressure")}
    plain, averaged = (owned_product(force(d, material), d.x.array, V) for material in linear.values())
    assert 0 < averaged < plain


def problem_of(cell, degree=1, material=None, hypothesis=None):
    if cell in (mesh.CellType.tetrahedron, mesh.CellType.hexahedron):
        domain = mesh.create_unit_cube(MPI.COMM_SELF, 1, 1, 1, cell)
    else:
        domain = mesh.create_unit_square(MPI.COMM_SELF, 1, 1, cell)
    u = fem.Function(fem.functionspace(domain, ("Lagrange", degree, (domain.geometry.dim,))), name="u")
    averaged = "averaged_pressure"
    return di.StaticProblem(u, material or di.NeoHookean(1.0, 0.3, hypothesis=hypothesis, integration=averaged))


def test_refused():
    with pytest.raises(ValueError, match="integration 'reducd' is unknown: use one of full"):
        di.NeoHookean(1.0, 0.3, integration="reducd")
    with pytest.raises(ValueError, match="hexahedron cells of degree 1"):
        problem_of(mesh.CellType.hexahedron)
    with pytest.raises(ValueError, match="tetrahedron cells of degree 2"):
        problem_of(mesh.CellType.tetrahedron, 2)
    for hypothesis in ("plane_stress", "axisymmetric"):
        with pytest.raises(ValueError, match=f"the hypothesis is '{hypothesis}'"):
            problem_of(mesh.CellType.triangle, hypothesis=hypothesis)
    with pytest.raises(ValueError, match="st_venant_kirchhoff has no volumetric part"):
        problem_of(mesh.CellType.tetrahedron, material=di.StVenantKirchhoff(1.0, 0.3, integration="averaged_pressure"))
    u = fem.Function(cube())
    with pytest.raises(TypeError, match="needs averages over the cells around nodes"):
        neo_hooke("averaged_pressure").stress(u)
    assert "averaged_pressure" in repr(neo_hooke("averaged_pressure"))
    assert "integration" not in repr(neo_hooke("full"))


def test_no_warning_of_locking():
    """Plain cells warn, and say what to do; averaged ones do not."""

    def steel(how):
        return di.J2Plasticity(1.0, 0.3, 1.0, yield_stress=0.01, integration=how)

    with pytest.warns(Locking, match='integration="averaged_pressure"'):
        problem_of(mesh.CellType.tetrahedron, material=steel("full"))
    with warnings.catch_warnings():
        warnings.simplefilter("error", Locking)
        problem_of(mesh.CellType.tetrahedron, material=steel("averaged_pressure"))


def test_stress_of_a_problem_has_the_pressure_of_the_nodes():
    """Its work on a virtual displacement is that of the internal force."""
    u = bent(cube())
    problem = di.StaticProblem(u, neo_hooke("averaged_pressure", 0.49))
    stress = problem.stress.values
    F = ufl.Identity(3) + ufl.grad(u)
    points = di.PointValues(ufl.det(F), [[0.25, 0.25, 0.25]]).values()
    assert stress.shape[-1] == 6 and len(points) == len(stress)
    plain = di.StaticProblem(bent(u.function_space), neo_hooke("full", 0.49)).stress.values
    pressure, other = (s[..., :3].mean(axis=-1) for s in (stress, plain))
    assert np.std(pressure) < 0.8 * np.std(other)  # cells' own pressures oscillate
