# SPDX-License-Identifier: MIT
"""Strains averaged at the nodes: rigid motions, uniform strain, softer than plain cells, what is refused.

Derivatives, ranks and checkpoints: averaged_pressure_checks.py. Bending: tests/verification/test_linear_tetrahedra.py.
"""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import ufl
from averaged_pressure_checks import LAWS, bent, cube, owned_product
from dolfinx import fem, mesh
from mpi4py import MPI
from test_averaged_pressure import force, problem_of

import dolfinx_impact as di
from dolfinx_impact.assembly import operators
from dolfinx_impact.forms import averaged_strain, elasticity

STRAIN = "averaged_strain"


def distorted():
    """Space on a cube whose inner node, and those of its faces but at their edges, are moved."""
    V = cube(MPI.COMM_SELF, 2)
    x = V.mesh.geometry.x
    inside = 16 * x * (1 - x) / 4  # 1 in the middle
    x += 0.1 * inside * np.roll(1 - 2 * x + 0.7 * inside, 1, axis=1)
    return V


@pytest.mark.parametrize("law", LAWS)
def test_uniform_strain(law):
    """The patch test: nodal forces of a uniform strain are those of plain cells, so that inner nodes have none. Round-
    off of stresses of some tenths."""
    V = distorted()
    u = fem.Function(V, name="u")
    u.interpolate(lambda x: np.array([0.2 * x[0] + 0.1 * x[1], 0.1 * x[2], 0.3 * x[0] - 0.1 * x[2]]))
    plain, averaged = (force(u, law(1.0, 0.4, 1.0, integration=how)) for how in ("full", STRAIN))
    assert np.abs(plain - averaged).max() < 1e-13 and np.abs(plain).max() > 1e-3


@pytest.mark.parametrize("law", LAWS)
def test_rigid_motions_have_no_forces(law):
    """Translations, and rotations of finite strain. Round-off of strains of 1."""
    V = distorted()
    u = fem.Function(V, name="u")
    u.interpolate(lambda x: np.array([1.0 + 0 * x[0], -2.0 + 0 * x[0], 3.0 + 0 * x[0]]))
    assert np.abs(force(u, law(1.0, 0.4, 1.0, integration=STRAIN))).max() < 1e-13
    if law is di.NeoHookean:
        c, s = np.cos(1.0), np.sin(1.0)
        u.interpolate(lambda x: np.array([c * x[0] - s * x[1] - x[0], s * x[0] + c * x[1] - x[1], 0 * x[0]]))
        assert np.abs(force(u, law(1.0, 0.4, 1.0, integration=STRAIN))).max() < 1e-13


def test_it_is_softer_than_averaged_pressure():
    """By Jensen's inequality, in every direction: the stable step of plain cells is a bound."""
    V = cube(MPI.COMM_SELF)
    d = bent(V, 1e-3)
    works = []
    for how in ("full", "averaged_pressure", STRAIN):
        works.append(owned_product(force(d, di.LinearElastic(1.0, 0.3, 1.0, integration=how)), d.x.array, V))
    assert works[0] > works[1] > works[2] > 0


def test_an_own_share_of_the_cells_bears_alternating_strains():
    """Displacements of one sign at every other node of a cube: of nodes alone some of these modes cost no energy."""
    V = cube(MPI.COMM_SELF, 4)
    u = fem.Function(V, name="u")
    u.interpolate(lambda x: np.array([np.cos(4 * np.pi * x.sum(axis=0)), 0 * x[0], 0 * x[0]]))
    full, averaged = (
        owned_product(force(u, di.LinearElastic(1.0, 0.3, 1.0, integration=how)), u.x.array, V)
        for how in ("full", STRAIN)
    )
    assert averaged > 0.1 * full > 0


def test_what_is_left_for_cells_and_nodes():
    """Without a volumetric part (nu = 0) CellsOfLinearElastic and CellsOfNeoHookean have their share of the plain laws'
    forces; NodesOfNeoHookean averages the nine components of the gradient, LinearElastic six strains. Round-off."""
    u = bent(distorted())
    V, v = u.function_space, ufl.TestFunction(u.function_space)
    parts = {
        di.LinearElastic: averaged_strain.CellsOfLinearElastic(1.0, 0.0, "3d"),
        di.NeoHookean: averaged_strain.CellsOfNeoHookean(1.0, 0.0, "3d", fem.Constant(V.mesh, 0.3)),
    }
    for law, cells in parts.items():
        own = operators.InternalForce(elasticity.internal_force(u, v, cells, ufl.dx(domain=V.mesh))).apply().array
        plain = force(u, law(1.0, 0.0, 1.0))
        assert np.abs(own - (1 - averaged_strain.SHARE) * plain).max() < 1e-15 < 1e-3 < np.abs(plain).max()
    assert set(averaged_strain.SPLIT) == set(averaged_strain.LAWS)
    nodes = averaged_strain.NodesOfNeoHookean(1.0, 0.0, "3d", None)
    assert nodes.linear and len(nodes.measure(u)) == nodes.num_means(3) == 9
    assert averaged_strain.SPLIT["linear_elastic"][1].num_means(3) == 6


@pytest.mark.parametrize("width", (1, 4))
def test_forces_of_all_widths(width):
    """Sweeps written by hand are for vectors: with a cell at a time kernels and LinearSums give the same forces. The
    width is read once in a process."""
    code = "import averaged_pressure_checks as checks; checks.check_explicit_force_is_that_of_the_operator()"
    paths = [str(Path(__file__).parent), *sys.path]
    given = os.environ | {"IMPACT_SIMD_WIDTH": str(width), "PYTHONPATH": os.pathsep.join(filter(None, paths))}
    done = subprocess.run([sys.executable, "-c", code], env=given, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr


def test_refused():
    with pytest.raises(ValueError, match="J2Plasticity has internal variables.*averaged_strain.*averaged_pressure"):
        di.J2Plasticity(1.0, 0.3, 1.0, yield_stress=0.01, integration=STRAIN)
    rubber = di.NeoHookean(1.0, 0.3, 1.0, integration=STRAIN)
    with pytest.raises(ValueError, match='"averaged_strain" is for tetrahedra.*hexahedron cells of degree 1'):
        problem_of(mesh.CellType.hexahedron, material=rubber)
    with pytest.raises(ValueError, match='"averaged_strain".*tetrahedron cells of degree 2'):
        problem_of(mesh.CellType.tetrahedron, 2, rubber)
    for hypothesis in ("plane_stress", "axisymmetric"):
        sheet = di.LinearElastic(1.0, 0.3, hypothesis=hypothesis, integration=STRAIN)
        with pytest.raises(ValueError, match=f'"averaged_strain".*the hypothesis is .{hypothesis}'):
            problem_of(mesh.CellType.triangle, material=sheet)
    with pytest.raises(ValueError, match='"averaged_strain".*st_venant_kirchhoff has no volumetric part'):
        problem_of(mesh.CellType.tetrahedron, material=di.StVenantKirchhoff(1.0, 0.3, integration=STRAIN))
    u = fem.Function(cube(MPI.COMM_SELF, 1), name="u")
    with pytest.raises(TypeError, match="needs averages over the cells around nodes"):
        rubber.stress(u)
    with pytest.raises(
        ValueError, match="precision='mixed' is for integration='full' and 'reduced', found 'averaged_strain'"
    ):
        di.ExplicitProblem(u, rubber, precision="mixed")
    assert STRAIN in repr(rubber)
