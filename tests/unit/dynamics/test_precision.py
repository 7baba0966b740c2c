# SPDX-License-Identifier: MIT
"""Element forces in float: round-off relative to what cells deform, and problems that float is not for."""

import numpy as np
import precision_checks
import pytest
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI
from on_ranks import rank_tests

import dolfinx_impact as di
from dolfinx_impact.assembly import operators

test_one_rank, test_several_ranks = rank_tests(precision_checks)

# Half a unit in the last place of float, times the roundings that one force sees: 24 numbers of positions and
# displacement, products of Jacobians, sums over 8 points. The largest force is the measure.
ROUNDINGS = 40
ROUND_OFF = ROUNDINGS * 2.0**-24

LAWS = {"linear": di.LinearElastic, "neo-Hooke": di.NeoHookean}
CELLS = {"hexahedron": mesh.CellType.hexahedron, "tetrahedron": mesh.CellType.tetrahedron}


def block(cell="hexahedron", n=(3, 2, 3), moved=0.0, size=1.0):
    domain = mesh.create_box(MPI.COMM_SELF, [[0.0, 0.0, 0.0], [size, size, size]], n, CELLS[cell])
    x = domain.geometry.x
    x[:] += 0.03 * size * np.sin(7.0 * x[:, [1, 2, 0]] / size) + moved
    return domain


def deformed(domain, degree=1, translation=0.0, strain=0.05):
    u = fem.Function(fem.functionspace(domain, ("Lagrange", degree, (3,))), name="u")
    low, size = domain.geometry.x.min(axis=0), np.ptp(domain.geometry.x[:, 0])
    u.interpolate(lambda x: translation + strain * size * np.sin(3.0 * (x[[2, 0, 1]] - low[:, None]) / size))
    return u


def force(u, law, mixed, width=0, nu=0.3, integration="full"):
    material = law(1e3, nu, 1.0, integration=integration)
    f = operators.InternalForce(operators.internal_force_form(u, ufl.TestFunction(u.function_space), material), width)
    if mixed:
        f._cpp_object.set_mixed()
    return f.apply().array.copy()


def difference(u, law, width=0, integration="full"):
    exact = force(u, law, False, width, integration=integration)
    return np.abs(force(u, law, True, width, integration=integration) - exact).max() / np.abs(exact).max()


@pytest.mark.parametrize("width", [0, 1])
@pytest.mark.parametrize("degree", [1, 2])
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("cell", CELLS)
def test_force_is_that_of_double_to_round_off(cell, law, degree, width):
    """The numbers of cells, 18 and 108, fill no batch of 4, 8 or 16. neo-Hooke's stress is of the deformation gradient,
    whose round-off is a part of one, not of the strain."""
    strain = 0.05
    u = deformed(block(cell), degree, strain=strain)
    allowed = ROUND_OFF * (1.0 if law == "linear" else 1.0 / strain)
    assert 0.0 < difference(u, LAWS[law], width) < allowed


@pytest.mark.parametrize("width", [0, 1])
@pytest.mark.parametrize("law", LAWS)
def test_force_of_one_point_is_that_of_double_to_round_off(law, width):
    """Hourglass modes are what is left of second differences without the mean gradient's part in them: as the stress,
    their forces have the round-off of the gradient."""
    strain = 0.05
    u = deformed(block(), strain=strain)
    allowed = ROUND_OFF * (1.0 if law == "linear" else 1.0 / strain)
    assert 0.0 < difference(u, LAWS[law], width, "reduced") < allowed


@pytest.mark.parametrize("integration", ["full", "reduced"])
@pytest.mark.parametrize("size", [1e-6, 1.0, 1e4])
def test_no_unit_of_length_leaves_the_range_of_float(size, integration):
    assert difference(deformed(block(size=size)), di.LinearElastic, integration=integration) < ROUND_OFF


def test_cells_that_are_numbered_the_other_way_round():
    """The sign of the volume, which one point takes from its positions, is chosen lane by lane."""
    domain = block()
    domain.geometry.x[:, 0] *= -1.0
    assert difference(deformed(domain), di.LinearElastic, integration="reduced") < ROUND_OFF


def test_flat_cells_with_one_point_do_not_leave_the_range_of_float():
    """Factors of hourglass modes are of the fourth power of the length of an axis, here a thousandth of the others."""
    domain = block()
    domain.geometry.x[:, 2] *= 1e-3
    u = deformed(domain)
    u.x.array[2::3] *= 1e-3
    assert difference(u, di.LinearElastic, integration="reduced") < ROUND_OFF


def test_round_off_is_that_of_a_cell_wherever_it_is():
    """1e4 bodies' lengths from the origin, and moved 1e3 of them: positions in float are wrong by a part in a thousand
    of a cell there."""
    far = deformed(block(moved=1e4), translation=1e3)
    assert difference(far, di.LinearElastic) < ROUND_OFF
    exact = force(far, di.LinearElastic, False)
    far.x.array[:] = far.x.array.astype(np.float32)  # what this test would see of a gather in float
    assert np.abs(force(far, di.LinearElastic, False) - exact).max() > 100 * ROUND_OFF * np.abs(exact).max()


@pytest.mark.parametrize("integration", ["full", "reduced"])
@pytest.mark.parametrize("law", LAWS)
def test_forces_are_in_equilibrium_in_double(law, integration):
    f = force(deformed(block()), LAWS[law], True, integration=integration).reshape(-1, 3)
    # of 144 numbers at the most, each with half a unit in the last place of double
    assert np.abs(f.sum(axis=0)).max() < 144 * 2.0**-53 * np.abs(f).sum()


@pytest.mark.parametrize("integration", ["full", "reduced"])
def test_a_translation_has_no_force(integration):
    u = deformed(block(), translation=0.3, strain=0.0)
    assert np.all(force(u, di.LinearElastic, True, integration=integration) == 0.0)


def test_turned_inside_out_is_not_a_number():
    u = deformed(block(n=(1, 1, 1)), strain=0.0)
    u.interpolate(lambda x: np.array([-2.0 * x[0], 0.0 * x[1], 0.0 * x[2]]))
    assert np.isnan(force(u, di.NeoHookean, True)).any()


def run(precision, steps=50, integration="full"):
    domain = block()
    u = deformed(domain, strain=0.02)
    material = di.LinearElastic(1e3, 0.3, 1.0, integration=integration)
    problem = di.ExplicitProblem(u, material, precision=precision)
    dt = 0.8 * problem.stable_step()
    problem.advance(steps * dt, dt=dt, progress=False)
    return problem


@pytest.mark.filterwarnings("ignore:hourglass modes have")
@pytest.mark.parametrize("integration", ["full", "reduced"])
def test_run_is_that_of_double(integration):
    """Errors of the forces of 50 steps add up to those of 50 at the most."""
    double, mixed = run("double", integration=integration), run("mixed", integration=integration)
    assert mixed.precision == "mixed" and double.precision == "double"
    error = np.abs(mixed.u.x.array - double.u.x.array).max() / np.abs(double.u.x.array).max()
    assert 0.0 < error < 50 * ROUND_OFF
    for name in ("kinetic", "internal"):
        assert mixed.energy[name] == pytest.approx(double.energy[name], rel=100 * ROUND_OFF)


def test_positions_of_a_mesh_that_was_moved_are_read_again():
    u = deformed(block())
    material = di.LinearElastic(1e3, 0.3, 1.0)
    f = operators.InternalForce(operators.internal_force_form(u, ufl.TestFunction(u.function_space), material))
    f._cpp_object.set_mixed()
    before = f.apply().array.copy()
    u.function_space.mesh.geometry.x[:] *= 1.25
    after = f.apply().array.copy()
    assert np.abs(after - before).max() > 0.1 * np.abs(before).max()
    assert np.array_equal(after, force(u, di.LinearElastic, True))


def test_materials_of_tags_have_kernels_in_float():
    domain = block()
    cells = np.arange(18, dtype=np.int32)
    tags = mesh.meshtags(domain, 3, cells, np.where(cells < 7, 1, 2).astype(np.int32))
    u = deformed(domain)
    materials = di.MaterialMap(tags, {1: di.LinearElastic(1e3, 0.3, 1.0), 2: di.NeoHookean(5e2, 0.4, 1.0)})
    problem = di.ExplicitProblem(u, materials, precision="mixed")
    problem.advance(problem.stable_step(), progress=False)
    assert np.isfinite(problem.energy["internal"])


def test_checkpoints_are_of_one_precision(tmp_path):
    run("mixed", 2).save(tmp_path / "state.h5")
    with pytest.raises(ValueError, match="scheme is 'half_step', mixed precision, here 'half_step'$"):
        run("double", 2).restore(tmp_path / "state.h5")
    run("mixed", 3).restore(tmp_path / "state.h5")


PLASTIC = di.J2Plasticity(1e3, 0.3, density=1.0, yield_stress=1.0)
REFUSED = [
    ({"precision": "float"}, "'float' is unknown"),
    ({"material": PLASTIC}, "found J2Plasticity"),
    ({"material": di.StVenantKirchhoff(1e3, 0.3, 1.0)}, "found StVenantKirchhoff"),
    ({"material": di.LinearElastic(1e3, 0.3, 1.0, integration="averaged_strain")}, "found 'averaged_strain'"),
    ({"material": di.LinearElastic(1e3, 0.499, 1.0)}, "nu up to 0.495, found 0.499"),
]


@pytest.mark.parametrize("given, words", REFUSED, ids=[words for _, words in REFUSED])
def test_what_float_is_not_for_is_refused(given, words):
    u = deformed(block())
    given = {"material": di.LinearElastic(1e3, 0.3, 1.0), "precision": "mixed", **given}
    with pytest.raises(ValueError, match=words):
        di.ExplicitProblem(u, **given)


def test_residuals_of_ones_own_and_plane_cells_are_refused():
    u = deformed(block())
    residual = ufl.inner(ufl.grad(u), ufl.grad(ufl.TestFunction(u.function_space))) * ufl.dx
    with pytest.raises(ValueError, match="a residual of your own"):
        di.ExplicitProblem(u, residual=residual, density=1.0, precision="mixed")
    plane = mesh.create_unit_square(MPI.COMM_SELF, 2, 2, mesh.CellType.quadrilateral)
    u = fem.Function(fem.functionspace(plane, ("Lagrange", 1, (2,))))
    with pytest.raises(ValueError, match="found quadrilateral"):
        di.ExplicitProblem(u, di.LinearElastic(1.0, 0.3, 1.0, "plane_strain"), precision="mixed")
