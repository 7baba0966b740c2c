# SPDX-License-Identifier: MIT
"""Restart of bodies that yield in contact, cells of degree 2, collapse; on the ranks of COMM_WORLD, see on_ranks.py."""

import numpy as np
from dolfinx import fem, mesh
from inelastic_checks import (
    COMM,
    Y,
    all_points,
    assert_same,
    everywhere,
    pulled,
    raises,
    space,
    square,
    state,
    steel,
)
from mpi4py import MPI
from on_ranks import on_rank_0
from shared_folder import shared_folder

import dolfinx_impact as di

LENGTH, RADIUS, SPEED = 32.4e-3, 3.2e-3, 227.0


SAVED = 100  # step in which the foot presses on the wall


def taylor_bar(domain, make):
    """A small bar of copper that hits a rigid plane."""
    foot = mesh.locate_entities_boundary(domain, 1, lambda x: np.isclose(x[1], 0.0))
    tags = mesh.meshtags(domain, 1, np.sort(foot), np.ones(len(foot), dtype=np.int32))
    V = space(domain)
    u, v = fem.Function(V, name="u"), fem.Function(V, name="v")
    v.interpolate(lambda x: np.vstack([0.0 * x[0], 0.0 * x[0] - SPEED]))
    axis = fem.locate_dofs_geometrical((V.sub(0), V.sub(0).collapse()[0]), lambda x: np.isclose(x[0], 0.0))
    zero = fem.Function(V.sub(0).collapse()[0])
    copper = di.J2Plasticity(
        117e9, 0.35, 8930.0, yield_stress=400e6, hardening=100e6, finite_strain=True, hypothesis="axisymmetric"
    )
    wall = di.ContactPair(tags, 1, di.RigidPlane((0.0, 0.0), (0.0, 1.0)))
    hold = fem.dirichletbc(zero, axis, V.sub(0))
    return di.ExplicitProblem(u, copper, velocity=v, bcs=[hold], contact=[make(wall)])


def bar_mesh():
    return mesh.create_rectangle(COMM, [(0.0, 0.0), (RADIUS, LENGTH)], [2, 16], mesh.CellType.quadrilateral)


def check_a_restart_of_a_bar_that_yields_on_a_wall_is_bit_exact():
    """Saved while the foot is in contact and yields; the restored run goes on with the same state and force."""
    for make in (di.Kinematic, di.Penalty):
        with shared_folder() as path:
            domain = bar_mesh()
            whole, kept = taylor_bar(domain, make), {}

            def keep(problem):
                if problem.step == SAVED:
                    problem.save(path / "middle.h5")
                    kept["state"], kept["plastic"] = state(problem), problem.energy["plastic"]

            whole.advance(20e-6, callback=keep, progress=False)
            assert whole.step > 120 and 0.0 < kept["plastic"] < 0.9 * whole.energy["plastic"]
            force = whole.force_history[0][:, 1]
            assert np.abs(force[SAVED - 4 : SAVED + 5]).min() > 0.0, "in contact when it was saved"
            again = taylor_bar(domain, make)
            again.restore(path / "middle.h5")
            np.testing.assert_array_equal(state(again), kept["state"])
            again.advance(20e-6, progress=False)
            assert again.step == whole.step
            np.testing.assert_array_equal(state(again), state(whole))
            np.testing.assert_allclose(again.force_history[0][-20:, 1], force[-20:], rtol=1e-12)  # sums over ranks
            assert abs(again.energy["plastic"] / whole.energy["plastic"] - 1) < 1e-12


def degree_2_results(comm):
    """A square of degree 2 with an elastic part and two that yield, whose dilatation is linear in each cell."""
    problem, u, pull = pulled(comm, n=3, degree=2)
    parts = []
    for x in (0.01, 0.03, 0.02):
        pull.value[:] = (x, 0.5 * x)
        report = problem.solve(rtol=1e-12)
        assert max(report.iterations) <= 12
        parts += [everywhere(u), everywhere(problem.reactions())]
        parts.append(all_points(comm, problem.history["plastic_strain"].values))
    return parts


def check_cells_of_degree_2_are_those_of_one_rank():
    expected = on_rank_0(COMM, lambda: degree_2_results(MPI.COMM_SELF))
    for a, b in zip(degree_2_results(COMM), expected):
        assert_same(a, b)


def drawn(hardening):
    """A square that is held at the left and drawn at the right by a traction."""
    domain = square(n=4)
    V = space(domain)
    right = mesh.locate_entities_boundary(domain, 1, lambda x: np.isclose(x[0], 1.0))
    tags = mesh.meshtags(domain, 1, np.sort(right), np.ones(len(right), dtype=np.int32))
    left = fem.locate_dofs_geometrical(V, lambda x: np.isclose(x[0], 0.0))
    load = di.Traction(tags, 1, np.array([0.0, 0.0]))
    u = fem.Function(V, name="u")
    hold = fem.dirichletbc(np.zeros(2), left, V)
    return di.StaticProblem(u, steel(hardening), bcs=[hold], loads=[load]), u, load


def check_newton_that_diverges_beyond_collapse_says_so():
    """More than the body can bear: displacements run away. The state before it is kept, smaller loads still work."""
    problem, u, load = drawn(1e-12)  # nothing to speak of, so that no pivot vanishes
    load.constant.value[:] = (0.9 * Y, 0.0)
    problem.solve()
    before, plastic = u.x.array.copy(), problem.history["plastic_strain"].values.copy()
    for factor in (1.5, 2.0, 3.0):
        load.constant.value[:] = (factor * Y, 0.0)
        raises(
            RuntimeError, "Newton's method diverged: in iteration .* the residual is round-off.*smaller parts",
            lambda: problem.solve(),
        )  # fmt: skip
        np.testing.assert_array_equal(u.x.array, before)
        np.testing.assert_array_equal(problem.history["plastic_strain"].values, plastic)
    load.constant.value[:] = (Y, 0.0)
    assert problem.solve().converged
    problem, u, load = drawn(0.1)
    load.constant.value[:] = (1.5 * Y, 0.0)
    assert problem.solve().converged, "a body that hardens bears it"


def check_a_load_that_a_body_cannot_bear_is_named():
    """Without hardening the tangent is singular at collapse."""
    problem, _, load = drawn(0.0)
    load.constant.value[:] = (3.0 * Y, 0.0)
    raises(RuntimeError, "linear solver failed.*Is the load more than the body can bear", lambda: problem.solve())


def check_a_projection_on_linear_functions_needs_degree_2():
    for kind, degree in (("quadrilateral", 1), ("triangle", 2)):
        raises(
            ValueError, f'average="linear" is for quadrilaterals and hexahedra of degree 2, these are {kind}.*{degree}',
            lambda: pulled(kind=kind, degree=degree, material=steel(average="linear")),
        )  # fmt: skip
