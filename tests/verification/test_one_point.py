# SPDX-License-Identifier: MIT
"""Cells with one point and hourglass control: patch, rotation, bending, Cook's membrane, stable step, energy."""

import warnings

import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from meshes_and_supports import block, every_boundary_dof, rectangle, tagged, value_at
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact.assembly import operators
from dolfinx_impact.dynamics.hourglass import Hourglassing

GRADIENT = np.array([[0.03, 0.02, -0.01], [-0.015, 0.02, 0.01], [0.01, -0.02, 0.025]])
CASES = [
    ("hexahedron", "3d", di.LinearElastic),
    ("hexahedron", "3d", di.NeoHookean),
    ("quadrilateral", "plane_strain", di.StVenantKirchhoff),
    ("quadrilateral", "plane_stress", di.LinearElastic),
]


def reduced(law, hypothesis, E=1.0, nu=0.3, density=1.0):
    return law(E, nu, density, hypothesis, integration="reduced")


def vector_space(domain, degree=1):
    return fem.functionspace(domain, ("Lagrange", degree, (domain.geometry.dim,)))


def internal_force(u, material):
    form = operators.internal_force_form(u, ufl.TestFunction(u.function_space), material)
    return operators.InternalForce(form).apply().array


@pytest.mark.parametrize("cell, hypothesis, law", CASES)
def test_patch(cell, hypothesis, law):
    """A linear displacement is in equilibrium on distorted cells, and its forces are those of full integration."""
    domain = block(cell, 3, distortion=0.1)
    V, dim = vector_space(domain), domain.geometry.dim
    target, u = fem.Function(V), fem.Function(V, name="u")
    target.interpolate(lambda x: GRADIENT[:dim, :dim] @ x[:dim])
    bcs = [fem.dirichletbc(target, every_boundary_dof(V))]
    di.StaticProblem(u, reduced(law, hypothesis), bcs=bcs).solve(rtol=1e-13)
    # Round-off times the condition number of these small meshes, at most 1e3.
    np.testing.assert_allclose(u.x.array, target.x.array, atol=1e-12 * np.abs(target.x.array).max())
    full = internal_force(target, law(1.0, 0.3, 1.0, hypothesis))
    np.testing.assert_allclose(internal_force(target, reduced(law, hypothesis)), full, atol=1e-13)


@pytest.mark.parametrize("cell, hypothesis, law", CASES[1:3])
def test_no_force_under_rotation(cell, hypothesis, law):
    domain = block(cell, 2, distortion=0.1)
    u, dim = fem.Function(vector_space(domain)), domain.geometry.dim
    turn, _ = np.linalg.qr(np.random.default_rng(1).standard_normal((dim, dim)))
    turn[:, 0] *= np.sign(np.linalg.det(turn))
    u.interpolate(lambda x: turn @ x[:dim] - x[:dim])
    assert np.abs(internal_force(u, reduced(law, hypothesis))).max() < 1e-14  # round-off of forces of the size E h
    moved = fem.Function(u.function_space)
    bend = np.random.default_rng(2).uniform(-0.02, 0.02, len(u.x.array)).reshape(-1, dim)
    moved.x.array[:] = u.x.array + (bend @ turn.T).ravel()
    u.x.array[:] = bend.ravel()
    own = internal_force(u, reduced(law, hypothesis)).reshape(-1, dim)
    turned = internal_force(moved, reduced(law, hypothesis)).reshape(-1, dim)
    np.testing.assert_allclose(turned, own @ turn.T, atol=1e-14)


def bent(cells_through, law):
    """Deflection over the exact one of a bar in space under moments at its ends (Saint-Venant), 5 by 1 by 0.5."""
    L, H, B, nu, curvature = 5.0, 1.0, 0.5, 0.3, 1e-3
    n = (5 * cells_through, cells_through, cells_through)
    low, high = (0.0, -H / 2, -B / 2), (L, H / 2, B / 2)
    domain = mesh.create_box(MPI.COMM_SELF, [low, high], n, mesh.CellType.hexahedron)
    V = vector_space(domain)
    exact = fem.Function(V)
    exact.interpolate(lambda x: curvature * np.array(
        [x[0] * x[1], -(x[0] ** 2 + nu * (x[1] ** 2 - x[2] ** 2)) / 2, -nu * x[1] * x[2]]))  # fmt: skip
    tags = tagged(domain, end=lambda x: np.isclose(x[0], L), clamp=lambda x: np.isclose(x[0], 0))
    held = fem.dirichletbc(exact, fem.locate_dofs_topological(V, 2, tags.find(2)))
    traction = di.Traction(tags, 1, ufl.as_vector([curvature * ufl.SpatialCoordinate(domain)[1], 0.0, 0.0]))
    u = fem.Function(V, name="u")
    di.StaticProblem(u, law, bcs=[held], loads=[traction]).solve()
    end = (L, -H / 2, -B / 2)
    return value_at(u, end)[1] / value_at(exact, end)[1]


def test_bending_of_a_bar():
    """Rectangular cells bend exactly, however few; two with full integration are 11 % too stiff."""
    for n in (1, 2):
        assert bent(n, reduced(di.LinearElastic, "3d")) == pytest.approx(1.0, rel=1e-8)  # the linear solver's accuracy
    assert bent(2, di.LinearElastic(1.0, 0.3)) < 0.9


def cook(law, n, degree=1):
    """Vertical displacement of the upper corner of Cook's membrane under a shear load."""
    domain = rectangle("quadrilateral", (0, 0), (1, 1), (n, n))
    s, t = domain.geometry.x[:, 0].copy(), domain.geometry.x[:, 1].copy()
    domain.geometry.x[:, 0] = 48 * s
    domain.geometry.x[:, 1] = 44 * s + t * (44 - 28 * s)
    tags = tagged(domain, end=lambda x: np.isclose(x[0], 48), clamp=lambda x: np.isclose(x[0], 0))
    V = vector_space(domain, degree)
    clamp = fem.dirichletbc(np.zeros(2), fem.locate_dofs_topological(V, 1, tags.find(2)), V)
    u = fem.Function(V, name="u")
    di.StaticProblem(u, law, bcs=[clamp], loads=[di.Traction(tags, 1, (0.0, 1e-4 / 16))]).solve()
    return value_at(u, (48.0, 60.0))[1]


def test_cooks_membrane_nearly_incompressible():
    """nu = 0.4999 in plane strain: 2 % off with 16 cells a side, where full integration is half as soft.

    The reference are cells of degree 2, 24 a side; 32 a side give the same to 0.2 %.
    """
    fine = cook(di.LinearElastic(1.0, 0.4999, hypothesis="plane_strain"), 24, degree=2)
    assert cook(reduced(di.LinearElastic, "plane_strain", nu=0.4999), 16) == pytest.approx(fine, rel=0.02)
    assert cook(di.LinearElastic(1.0, 0.4999, hypothesis="plane_strain"), 16) < 0.7 * fine


def test_stable_step_of_a_cube():
    """Benchmark T-6, in units of h/c: a single cell as with full integration, whose highest mode is a uniform strain;
    6^3 cells assembled between those of full integration and of one point without control of its modes."""
    found = {}
    for n, method in ((1, "element"), (6, "eigenvalue")):
        domain = mesh.create_unit_cube(MPI.COMM_SELF, n, n, n, mesh.CellType.hexahedron)
        steel = reduced(di.LinearElastic, "3d")
        problem = di.ExplicitProblem(fem.Function(vector_space(domain)), steel)
        found[n] = problem.stable_step(method=method) * n * steel.wave_speed
    assert found[1] == pytest.approx(0.733799, rel=2e-6)
    assert 0.962431 < found[6] < 0.978489


def struck(law, **arguments):
    """A cube whose corner node, or a whole face, moves at the start."""
    domain = mesh.create_unit_cube(MPI.COMM_SELF, 4, 4, 4, mesh.CellType.hexahedron)
    V = vector_space(domain)
    velocity = fem.Function(V)
    velocity.interpolate(lambda x: 0.01 * np.array([arguments["where"](x), 0 * x[0], 0 * x[0]]))
    problem = di.ExplicitProblem(fem.Function(V), law, velocity=velocity)
    problem.advance(0.3, progress=False)
    return problem


def test_hourglass_energy():
    """It is a part of the internal energy, the balance holds without adding it, and much of it is warned of."""
    with pytest.warns(Hourglassing, match="hourglass modes have .* % of the largest internal energy"):
        corner = struck(reduced(di.LinearElastic, "3d"), where=lambda x: np.isclose(x.sum(axis=0), 0.0))
    energy = corner.energy
    assert 0.05 * energy["internal"] < energy["hourglass"] < energy["internal"]
    total = energy["kinetic"] + energy["internal"]
    assert energy["total"] == pytest.approx(total, rel=1e-12) and abs(energy["drift"]) < 1e-12
    with warnings.catch_warnings():
        warnings.simplefilter("error", Hourglassing)
        face = struck(reduced(di.LinearElastic, "3d", nu=0.0), where=lambda x: x[0])
    # Plane waves deform no hourglass mode: round-off of the strain energy.
    assert abs(face.energy["hourglass"]) < 1e-14 * face.energy["internal"]
    full = struck(di.LinearElastic(1.0, 0.3, 1.0), where=lambda x: x[0])
    assert "hourglass" not in full.energy


def test_implicit_steps_have_the_entry():
    domain = block("quadrilateral", 3)
    V = vector_space(domain)
    velocity = fem.Function(V)
    velocity.interpolate(lambda x: 1e-3 * np.array([x[1] ** 2, np.sin(3 * x[0])]))
    problem = di.NewmarkProblem(fem.Function(V), reduced(di.NeoHookean, "plane_strain"), velocity=velocity)
    problem.advance(0.2, dt=0.1, progress=False)
    assert 0.0 < problem.energy["hourglass"] < problem.energy["internal"]


PLASTIC = di.J2Plasticity(1.0, 0.3, 1.0, yield_stress=0.01, integration="reduced")


def problem_on(cell, degree=1, geometry_degree=1, hypothesis=None, kind=di.ExplicitProblem, law=None, **more):
    domain = block(cell, 2, geometry_degree)
    law = law or di.LinearElastic(1.0, 0.3, 1.0, hypothesis, integration="reduced")
    return kind(fem.Function(vector_space(domain, degree)), law, **more)


@pytest.mark.parametrize(
    "make, words",
    [
        (lambda: problem_on("tetrahedron"), "quadrilaterals and hexahedra of degree 1 .*found tetrahedron"),
        (lambda: problem_on("triangle", hypothesis="plane_strain"), "found triangle"),
        (lambda: problem_on("hexahedron", 2), "displacement of degree 2"),
        (lambda: problem_on("hexahedron", 1, 2), "geometry of degree 2"),
        (lambda: reduced(di.LinearElastic, "axisymmetric"), "not for axisymmetric"),
        (lambda: di.LinearElastic(1.0, 0.3, integration="one"), "use one of .*full.*reduced"),
        (lambda: problem_on("tetrahedron", law=PLASTIC), "found tetrahedron"),
        (lambda: problem_on("hexahedron", kind=di.StaticProblem, law=PLASTIC), "is for ExplicitProblem"),
        (lambda: problem_on("hexahedron", kind=di.NewmarkProblem, law=PLASTIC), "is for ExplicitProblem"),
    ],
)
def test_what_is_refused(make, words):
    with pytest.raises(ValueError, match=words):
        make()


@pytest.mark.parametrize("integration", ["reduced", "averaged_pressure"])
def test_rolling_is_refused(integration):
    domain = block("quadrilateral", 2)
    tags = mesh.meshtags(domain, 2, np.arange(4, dtype=np.int32), np.full(4, 1, dtype=np.int32))
    u, motions = fem.Function(vector_space(domain)), {1: di.Translation((1.0, 0.0))}
    material = di.LinearElastic(1.0, 0.3, 1.0, "plane_strain", integration)
    with pytest.raises(ValueError, match=f"'{integration}' is not for rolling"):
        di.RollingProblem(u, material, cell_tags=tags, motions=motions)


def test_a_checkpoint_of_full_integration_is_refused(tmp_path):
    """And one of reduced integration goes on where it was."""

    def made(integration):
        law = di.LinearElastic(1.0, 0.3, 1.0, integration=integration)
        problem = di.ExplicitProblem(fem.Function(vector_space(block("hexahedron", 2))), law)
        problem.advance(0.1, progress=False)
        return problem

    for integration in ("full", "reduced"):
        made(integration).save(tmp_path / f"{integration}.h5")
    made("reduced").restore(tmp_path / "reduced.h5")
    for other, integration in (("full", "reduced"), ("reduced", "full")):
        with pytest.raises(ValueError, match="material"):
            made(integration).restore(tmp_path / f"{other}.h5")


def test_materials_of_one_mesh_share_the_integration():
    domain = block("hexahedron", 2)
    tags = mesh.meshtags(domain, 3, np.arange(8, dtype=np.int32), np.repeat([1, 2], 4).astype(np.int32))
    laws = [reduced(di.LinearElastic, None), di.LinearElastic(1.0, 0.3, 1.0)]
    with pytest.raises(ValueError, match="share one integration"):
        di.MaterialMap(tags, dict(zip((1, 2), laws)))
    two = di.MaterialMap(tags, {1: laws[0], 2: reduced(di.NeoHookean, None)})
    u = fem.Function(vector_space(domain))
    u.interpolate(lambda x: GRADIENT @ x)
    problem = di.ExplicitProblem(u, two)
    assert problem.energy["hourglass"] == pytest.approx(0.0, abs=1e-17)
    assert np.shape(problem.stress.values)[1] == 1  # one point
