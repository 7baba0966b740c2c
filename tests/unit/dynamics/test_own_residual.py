# SPDX-License-Identifier: MIT
"""Residuals of a user's own in explicit runs: what follows the run, and what is refused."""

import numpy as np
import own_residual_checks
import pytest
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI
from on_ranks import rank_tests
from own_residual_checks import SAME, Body

import dolfinx_impact as di

test_one_rank, test_several_ranks = rank_tests(own_residual_checks, ranks=(2, 3), timeout=300)
COMM = MPI.COMM_SELF


def ends(b):
    """Facet tags: 1 at x = 2."""
    b.mesh.topology.create_connectivity(1, 2)
    facets = np.sort(mesh.locate_entities_boundary(b.mesh, 1, lambda x: np.isclose(x[0], 2.0)))
    return mesh.meshtags(b.mesh, 1, facets, np.full(len(facets), 1, dtype=np.int32))


def test_what_is_changed_between_two_calls_holds_at_once():
    """Forces at the present time are those of the new value: as if it had been changed in a callback."""
    runs = []
    for inside in (True, False):
        b = Body(COMM).shake()
        g = fem.Constant(b.mesh, 0.0)
        problem = b.problem(b.elastic() - g * b.w[0] * b.dx)
        dt = 0.5 * problem.stable_step()

        def callback(p, g=g):
            g.value = 5.0 if p.step >= 10 else 0.0

        problem.advance(10 * dt, dt=dt, callback=callback if inside else None, progress=False)
        g.value = 5.0
        problem.advance(20 * dt, dt=dt, progress=False)
        runs.append(b.u.x.array.copy())
    np.testing.assert_allclose(runs[0], runs[1], rtol=0, atol=SAME * np.abs(runs[0]).max())


def test_viscosity_that_is_not_linear():
    """Stress with the square of the rate, mixed with the strain: dissipation is its own, energies close."""
    b = Body(COMM).shake()
    rate = ufl.sym(ufl.grad(b.v))
    size = ufl.sqrt(1.0 + ufl.inner(rate, rate))
    F = ufl.Identity(2) + ufl.grad(b.u)
    viscous = 0.5 * size * ufl.det(F) * ufl.inner(rate, ufl.grad(b.w)) * b.dx
    problem = b.problem(b.elastic() + viscous - 0.1 * b.w[1] * b.dx)
    problem.advance(100 * problem.stable_step(), progress=False)
    energy = problem.energy
    assert energy["damping"] > 0.02 * energy["total"] and energy["kinetic"] > 0.0
    assert abs(energy["drift"]) < 1e-12


def test_the_drift_does_not_depend_on_who_looks():
    """With and without callback, in one call and in several: the same number."""
    drifts = []
    for case in range(3):
        b = Body(COMM).shake()
        pair = di.ContactPair(ends(b), 1, di.RigidPlane((2.0001, 0.0), (-1.0, 0.0)), friction=0.2)
        problem = b.problem(b.elastic(), contact=[di.Penalty(pair)])
        dt = 0.5 * problem.stable_step()
        if case == 2:
            problem.advance(150 * dt, dt=dt, progress=False)
            problem.advance(300 * dt, dt=dt, progress=False)
        else:
            problem.advance(300 * dt, dt=dt, callback=(lambda p: None) if case else None, progress=False)
        assert np.abs(problem.force_history[0]).max() > 0.0
        drifts.append(problem.energy["drift"])
    assert drifts[0] == drifts[1] and drifts[0] == drifts[2] and drifts[0] != 0.0


def axisymmetric(weight=True, hoop=True, **options):
    """A linear law in the half plane of r and z, with or without its parts; a problem."""
    b = Body(COMM)
    r, u, w = ufl.SpatialCoordinate(b.mesh)[0], b.u, b.w
    around = [f[0] / r if hoop else 0.0 for f in (u, w)]
    strain, test = (
        ufl.as_tensor([[f[0].dx(0), f[0].dx(1), 0], [f[1].dx(0), f[1].dx(1), 0], [0, 0, h]])
        for f, h in zip((u, w), around)
    )
    stress = 2 * own_residual_checks.MU * ufl.sym(strain)
    return b.problem(ufl.inner(stress, ufl.sym(test)) * (2 * ufl.pi * r if weight else 1.0) * b.dx, **options)


def test_residuals_of_bodies_of_revolution():
    """With the hypothesis their mass is that of the whole body; forgotten, or given to a plane residual, it is told."""
    problem = axisymmetric(hypothesis="axisymmetric")
    # 2 pi r over 2 by 1
    assert problem.mass.array[::2].sum() == pytest.approx(4 * np.pi, rel=1e-12) and problem.axisymmetric
    with pytest.raises(ValueError, match="looks axisymmetric.*hypothesis='axisymmetric'"):
        axisymmetric()
    assert axisymmetric(hypothesis="plane_strain").mass.array[::2].sum() == pytest.approx(2.0, rel=1e-12)
    with pytest.raises(ValueError, match="hoop strain"):
        axisymmetric(weight=False, hoop=False, hypothesis="axisymmetric")
    # Graded stiffness in the plane is none of it; nor is a bed of springs.
    b = Body(COMM)
    x = ufl.SpatialCoordinate(b.mesh)
    b.problem(b.elastic(1.0 + x[0]))
    b.problem(b.elastic() + 10.0 * ufl.inner(b.u, b.w) * b.dx)
    with pytest.raises(ValueError, match="unknown"):
        b.problem(b.elastic(), hypothesis="axisym")
    with pytest.raises(ValueError, match="does not fit"):
        b.problem(b.elastic(), hypothesis="3d")


def test_what_is_no_residual_is_refused():
    b, other = Body(COMM), Body(COMM, n=4)
    V2 = fem.functionspace(b.mesh, ("Lagrange", 2, (2,)))
    du = ufl.TrialFunction(b.V)
    inner, grad = ufl.inner, ufl.grad
    foreign = fem.Function(fem.functionspace(other.mesh, ("DG", 0)), name="foreign")
    several = inner(grad(b.u), grad(b.w)) * b.dx + inner(grad(b.u), grad(ufl.TestFunction(V2))) * b.dx
    for text, error, form in (
        ("UFL form of rank 1, found list", TypeError, [b.elastic()]),
        ("UFL form of rank 1, found", TypeError, inner(grad(b.u), grad(b.w))),
        ("ufl.derivative", ValueError, inner(grad(b.u), grad(b.u)) * b.dx),
        ("TrialFunction", ValueError, inner(grad(du), grad(b.w)) * b.dx),
        ("TrialFunction", ValueError, b.elastic() + inner(grad(du), grad(b.w)) * b.dx),
        ("does not contain the displacement", ValueError, inner(grad(b.v), grad(b.w)) * b.dx),
        ("another mesh", ValueError, other.elastic()),
        ("another mesh", ValueError, foreign * inner(grad(b.u), grad(b.w)) * b.dx),
        ("test function.*another space", ValueError, inner(grad(b.u), grad(ufl.TestFunction(V2))) * b.dx),
        ("several spaces", ValueError, several),
        ("is the residual internal minus external", ValueError, -b.elastic()),
        ("feeds energy in.*internal minus external", ValueError, b.elastic() - b.viscous(0.1)),
        ("not a number", ValueError, b.elastic(fem.Constant(b.mesh, np.nan))),
    ):  # fmt: skip
        with pytest.raises(error, match=text):
            b.problem(form)
    with pytest.raises(ValueError, match="one function"):
        b.problem(b.elastic(), velocity=b.u)
    with pytest.raises(ValueError, match="'classical' takes mass-proportional"):
        b.problem(b.elastic() + b.viscous(0.1), scheme="classical")
    with pytest.raises(ValueError, match="those of the material"):
        steel = di.LinearElastic(1.0, 0.3, 1.0, "plane_strain")
        di.ExplicitProblem(b.u, steel, velocity=b.v, density=2.0)
    with pytest.warns(UserWarning, match="not symmetric"):
        turned = ufl.as_vector((b.v[1], -b.v[0]))
        b.problem(b.elastic() + 2.0 * inner(turned, b.w) * b.dx)


def test_a_cell_of_the_wrong_sign_is_found():
    """One of 128 cells whose modulus is negative is named."""
    b = Body(COMM)
    E = fem.Function(fem.functionspace(b.mesh, ("DG", 0)), name="E")
    E.x.array[:] = 1.0
    E.x.array[17] = -0.5
    number = b.mesh.topology.original_cell_index[17]
    with pytest.raises(ValueError, match=f"negative.*Found in cell {number} "):
        b.problem(b.elastic(E))


@pytest.mark.parametrize("eta", (0.02, 1.0, 30.0))
@pytest.mark.filterwarnings("ignore:dt =")
def test_the_stable_step_has_the_viscosity(eta):
    """Little, critical, overdamped, and a dashpot on a side: 99 % of the true limit run on, 101 % do not; the cells'
    step is below it. Without the viscosity the step would be too long."""

    def make():
        b = Body(COMM, n=3)
        b.v.x.array[:] = np.random.default_rng(1).uniform(-1e-3, 1e-3, len(b.v.x.array))
        dashpot = 0.5 * eta * ufl.inner(b.v, b.w) * ufl.ds(domain=b.mesh)
        return b.problem(b.elastic() + b.viscous(eta) + dashpot, damping=di.Rayleigh(0.3)), b

    problem, b = make()
    limit = problem.stable_step("eigenvalue")
    assert 0.4 * limit < problem.stable_step() < limit
    if eta > 0.1:
        assert limit < 0.9 * b.problem(b.elastic()).stable_step("eigenvalue")
    problem.advance(1000 * 0.99 * limit, dt=0.99 * limit, progress=False, unsafe=True)
    assert problem.energy["kinetic"] < 1e-6 and abs(problem.energy["drift"]) < 1e-9
    with pytest.raises(RuntimeError, match="unstable"):
        make()[0].advance(4000 * 1.01 * limit, dt=1.01 * limit, progress=False, unsafe=True)


def test_springs_on_a_side_are_in_the_stable_step():
    b = Body(COMM, n=3)
    stiff = b.problem(b.elastic() + 1e5 * ufl.inner(b.u, b.w) * ufl.ds(domain=b.mesh))
    limit = stiff.stable_step("eigenvalue")
    assert 0.4 * limit < stiff.stable_step() < limit < 0.5 * b.problem(b.elastic()).stable_step()


def test_mass_scaling_reaches_its_step_with_viscosity():
    b = Body(COMM, n=3)
    form = b.elastic() + b.viscous(1.0)
    wanted = 2 * b.problem(form).stable_step()
    assert b.problem(form, mass_scaling=wanted).stable_step() == pytest.approx(wanted, rel=1e-9)


def test_a_stiffness_that_grows_shortens_the_step():
    """A modulus that a callback or its owner multiplies by a hundred: steps follow, the run stays stable."""
    for inside in (True, False):
        b = Body(COMM, n=3).shake()
        E = fem.Constant(b.mesh, 1.0)
        problem = b.problem(b.elastic(E))
        first = problem.stable_step()

        def callback(p, E=E):
            E.value = 100.0 if p.step >= 495 else 1.0

        problem.advance(495 * 0.5 * first, dt=0.5 * first, callback=callback if inside else None, progress=False)
        E.value = 100.0
        before = problem.step
        # Whoever multiplies it does work on the body, which nobody counts.
        problem.advance(problem.time + 50 * first, progress=False, energy_limits=None)
        rows = problem.energy_history[before + 1 :, 1:]  # where the step changes energy is not exact
        total = rows[:, :-1].sum(axis=1) - rows[:, -1]
        assert problem.step - before > 400 and np.ptp(total) < 1e-9 * total[0]


def test_two_spaces_of_one_kind_are_one():
    """A test function of a second space with the same element and numbers."""
    b = Body(COMM)
    w = ufl.TestFunction(fem.functionspace(b.mesh, ("Lagrange", 1, (2,))))
    assert b.problem(ufl.inner(ufl.grad(b.u), ufl.grad(w)) * b.dx).stable_step() > 0.0


def test_operators_and_names_that_are_not_there():
    """What the C++ library says to forces without an operator, or with a coefficient that no kernel has."""
    from dolfinx_impact import _cpp
    from dolfinx_impact.assembly import operators

    b = Body(COMM)
    parts = [operators.InternalForce(b.elastic(), part=p)._cpp_object for p in ("early", "outer", "late")]
    mass = np.ones(len(b.u.x.array))

    def make(*arguments):
        forces = _cpp.integrators.FormForces(*arguments)
        scheme = _cpp.integrators.Scheme.half_step
        return _cpp.integrators.CentralDifference(b.V._cpp_object, forces, False, mass, 0.0, scheme)

    solver = make(*parts, "u", "")
    for text, arguments in (
        ("early cells is null", (None, *parts[1:], "u", "")),
        ("outer cells is null", (parts[0], None, parts[2], "u", "")),
        ("late cells is null", (*parts[:2], None, "u", "")),
        ("coefficient named 'w'", (*parts, "w", "")),
        ("coefficient named 'v'", (*parts, "u", "v")),
    ):
        with pytest.raises(ValueError, match=text):
            make(*arguments)
        with pytest.raises(ValueError, match=text):
            solver.add_term(_cpp.integrators.FormForces(*arguments), _cpp.integrators.WorkKind.damping)


def test_contact_without_its_step_is_told():
    """C++: set_contact_step was forgotten, or is no step."""
    from dolfinx_impact import _cpp
    from dolfinx_impact.assembly import operators

    b = Body(COMM)
    parts = [operators.InternalForce(b.elastic(), part=p)._cpp_object for p in ("early", "outer", "late")]
    forces = _cpp.integrators.FormForces(*parts, "u", "")
    scheme = _cpp.integrators.Scheme.half_step
    solver = _cpp.integrators.CentralDifference(b.V._cpp_object, forces, False, np.ones(len(b.u.x.array)), 0.0, scheme)
    b.mesh.topology.create_connectivity(1, 2)
    facets = mesh.locate_entities_boundary(b.mesh, 1, lambda x: np.isclose(x[1], 0.0))
    slave = _cpp.surface.make_surface(b.V._cpp_object, facets)
    plane = _cpp.gap.Rigid("plane", 2, [0.0, -0.1, 0.0], [0.0, 1.0, 0.0], 0.0)
    solver.add_contact(_cpp.nodal.NodalPair([_cpp.nodal.NodePenalty(b.V._cpp_object, slave, plane)]), [-1] * 3)
    solver.start(np.zeros(len(b.u.x.array)), np.zeros(len(b.u.x.array)))
    for call in (lambda: solver.run(np.array([1e-3]), np.zeros(0), 0, np.zeros(0)), solver.energies):
        with pytest.raises(ValueError, match="set_contact_step"):
            call()
    for bad in (0.0, -1.0, np.nan):
        with pytest.raises(ValueError, match="must be positive"):
            solver.set_contact_step(bad)
    solver.set_contact_step(1e-3)
    assert solver.run(np.array([1e-3]), np.zeros(0), 0, np.zeros(0)) == 1
