# SPDX-License-Identifier: MIT
"""Steady rolling of the hand-written solver by itself: matrices, the derivative upstream, friction, frequencies."""

import functools

import impact_reference as ir
import numpy as np
import pytest
from impact_reference import streamlines
from reference_meshes import CELLS, box, dofs, facets_where, nodes_where
from rolling_bodies import Carter, Wheel, disc

carter = functools.cache(Carter)


def material(dim, density=1.5):
    return ir.Material(2.0, 0.3, density, "plane_strain" if dim == 2 else "3d")


@pytest.mark.parametrize("cell", CELLS)
def test_matrices_of_a_spin_are_those_of_the_model(cell):
    """Assembly by bodies against the model's own, which has one spin for all cells."""
    points, cells = box(cell, (3, 2, 2)[: 2 if cell in CELLS[:2] else 3], distort=0.2)
    model = ir.Model(points, cells, cell, material(points.shape[1]))
    dim, centre = points.shape[1], np.array([0.3, -0.2, 0.1])[: points.shape[1]]
    spin = ir.Spinning(centre, 1.7, (0, 0, 1) if dim == 2 else (1.0, -2.0, 0.5))
    G, W, load = ir.RollingModel(model, {4: spin}).matrices()
    vector = spin.vector if dim == 3 else spin.vector[2:]
    for mine, whole in ((G, model.gyroscopic(vector, centre)), (W, model.ale_inertia(vector, centre))):
        assert np.abs(mine.toarray() - whole.toarray()).max() == 0.0
    assert np.array_equal(load, model.ale_load(vector, centre))


@pytest.mark.parametrize("cell", CELLS)
def test_inertia_of_a_translation(cell):
    """A linear displacement A X has int rho |A w|^2 dV; its body alone counts. G is skew, and there is no load."""
    dim = 2 if cell in CELLS[:2] else 3
    points, cells = box(cell, (4, 2, 2)[:dim])
    tags = np.where(points[cells].mean(axis=1)[:, 0] < 0.5, 7, 3)
    model = ir.Model(points, cells, cell, material(dim))
    w, A = np.array([0.8, -0.3, 0.4])[:dim], np.random.default_rng(3).uniform(-1, 1, (dim, dim))
    motions = {7: ir.Translating(w), 3: ir.Translating(2 * w)}
    G, W, load = ir.RollingModel(model, motions, tags).matrices()
    u = (points @ A.T).ravel()
    assert np.isclose(u @ W.dot(u), 1.5 * (0.5 + 0.5 * 4) * np.sum((A @ w) ** 2), rtol=1e-13, atol=0.0)
    assert not np.any(load)
    assert np.abs(G.toarray() + G.toarray().T).max() < 1e-15
    with pytest.raises(ValueError, match="no motion"):
        ir.RollingModel(model, {7: ir.Translating(w)}, tags)


@pytest.mark.parametrize("cell", CELLS)
def test_derivative_of_a_linear_displacement(cell):
    """On a plane face it is exact, whichever facet is upstream: only the tangential part of w counts."""
    dim = 2 if cell in CELLS[:2] else 3
    points, cells = box(cell, (5, 3, 2)[:dim])
    model = ir.Model(points, cells, cell, material(dim))
    top = facets_where(points, cells, cell, lambda x: x[-1] == 1.0)
    w = np.tile(np.array([0.9, 0.37, 0.0])[:dim], (len(points), 1))
    w[:, -1] = 0.2  # normal part
    u = points @ np.random.default_rng(1).uniform(-1, 1, (dim, dim))
    B = streamlines.derivative(model, top, w)
    found = np.column_stack([B.dot(u[:, c].copy()) for c in range(dim)])
    tangential = w * (np.arange(dim) < dim - 1)
    gradient = np.linalg.lstsq(points - points.mean(axis=0), u - u.mean(axis=0), rcond=None)[0]
    on = np.unique(top)
    assert np.abs(found[on] - (tangential @ gradient)[on]).max() < 1e-13
    assert not np.any(np.delete(found, on, axis=0))


@pytest.mark.parametrize("cell", ["quadrilateral", "hexahedron", "tetrahedron"])
@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_derivative_is_taken_upstream(cell, direction):
    """A kink at x = 1/2: the node on it sees what the material has behind it; at the inflow there is but one side."""
    dim = 2 if cell == "quadrilateral" else 3
    points, cells = box(cell, (4, 2, 2)[:dim])
    model = ir.Model(points, cells, cell, material(dim))
    top = facets_where(points, cells, cell, lambda x: x[-1] == 1.0)
    w = np.tile(direction * np.eye(dim)[0], (len(points), 1))
    kinked = np.abs(points[:, 0] - 0.5)
    found = streamlines.derivative(model, top, w).dot(kinked)
    on = points[:, -1] == 1.0
    middle, right = on & (points[:, 0] == 0.5), on & (points[:, 0] > 0.5)
    assert np.allclose(found[middle], -1.0)  # the distance falls on the way to the kink, whichever way
    # Three points of the streamline: one cell past the kink the third lies before it, slopes 1 and -1 with equal steps.
    past = right if direction > 0.0 else on & (points[:, 0] < 0.5)
    beside, beyond = past & np.isclose(abs(points[:, 0] - 0.5), 0.25), past & np.isclose(abs(points[:, 0] - 0.5), 0.5)
    assert np.allclose(found[beside], 2.0) and np.allclose(found[beyond], 1.0)
    assert np.allclose(found[on & ~past & ~middle], -1.0)


@pytest.mark.parametrize("cell", ["quadrilateral", "hexahedron"])
def test_derivative_is_of_second_order(cell):
    """A parabola is differentiated exactly, on cells of unequal lengths too; at the inlet it is the first slope."""
    dim = 2 if cell == "quadrilateral" else 3
    points, cells = box(cell, (5, 2, 2)[:dim])
    points[:, 0] = points[:, 0] ** 2 + 0.3 * points[:, 0]
    model = ir.Model(points, cells, cell, material(dim))
    top = facets_where(points, cells, cell, lambda x: x[-1] == 1.0)
    w = np.tile(0.7 * np.eye(dim)[0], (len(points), 1))
    x, on = points[:, 0], points[:, -1] == 1.0
    found = streamlines.derivative(model, top, w).dot(x**2)
    stations = np.unique(x)
    inlet, first = on & (x < 0.5 * stations[1]), on & np.isclose(x, stations[1])
    rest = on & ~inlet & ~first
    assert np.allclose(found[rest], 0.7 * 2.0 * x[rest], atol=1e-13)
    assert np.allclose(found[inlet | first], 0.7 * (stations[0] + stations[1]))


def test_tied_facets_share_the_derivative():
    """Along an edge both facets beside it count the same, and give the same; across a corner there is one."""
    points, cells = box("hexahedron", (4, 4, 1))
    model = ir.Model(points, cells, "hexahedron", material(3))
    top = facets_where(points, cells, "hexahedron", lambda x: x[-1] == 1.0)
    centre = nodes_where(points, lambda x: np.allclose(x, (0.5, 0.5, 1.0)))[0]
    one, two, across = {(0.25, 0.5)}, {(0.0, 0.5)}, {(0.25, 0.5), (0.25, 0.25)}
    # (1, 1/2) enters the facet in the middle of its side; the ends of that have slopes over facets of their own.
    further = {(0.0, 0.5), (0.0, 0.25), (0.0, 0.0)}
    for w, behind in (((1.0, 0.0, 0.0), one | two), ((1.0, 0.5, 0.0), across | further | {(0.5, 0.25), (0.25, 0.0)})):
        row = streamlines.derivative(model, top, np.tile(w, (len(points), 1))).toarray()[centre]
        others = {tuple(points[k, :2]) for k in np.flatnonzero(np.abs(row) > 1e-14)} - {(0.5, 0.5)}
        assert others <= behind and abs(row.sum()) < 1e-14
        assert (others == behind) == (w[1] == 0.0)


def test_velocities_of_an_undeformed_wheel():
    """Pure rolling: at the lowest node the material has the velocity of the plane. A wheel that has turned rigidly by a
    small angle, u = theta x X, moves as (I + theta x) w of the turned polygon does: by its facets, exactly."""
    wheel = Wheel("quadrilateral", 8)
    V = wheel.rolling.velocity(wheel.contact, np.zeros(wheel.model.num_dofs))
    lowest = np.argmin(wheel.points[:, 1])
    assert np.allclose(V[lowest], (0.1, 0.0), atol=1e-16)
    turn = np.array([[0.0, -1e-3], [1e-3, 0.0]])
    turned = wheel.rolling.velocity(wheel.contact, (wheel.points @ turn.T).ravel())
    B = streamlines.derivative(wheel.model, wheel.contact.slave_facets, wheel.rolling.flow())
    along = np.column_stack([B.dot(wheel.points[:, c].copy()) for c in range(2)])  # tangential part of w on a facet
    assert np.abs(turned - wheel.rolling.flow() - along @ turn.T).max() < 1e-16
    assert np.abs(along - wheel.rolling.flow())[wheel.tread].max() < 0.1 * 0.2  # half an angle of a facet, 2 pi / 32


@pytest.mark.covering(1)
@pytest.mark.parametrize("forward", [True, False])
@pytest.mark.parametrize("creep", [0.2, 0.5, 0.8])
def test_carter(creep, forward):
    """F-3: creep mu a / R (1 - sqrt(1 - Q / mu P)), the stick zone sqrt(1 - Q / mu P) of the contact and at its leading
    edge. A cell is 0.18 of the half-width: each end of the stick zone is known to a cell, which changes the root by
    0.09 at either."""
    case = carter(16, creep, forward=forward)
    solution, P, Q, a = case.solve()
    sign = -1.0 if forward else 1.0
    ratio = case.rigid_creep * case.radius / (case.friction * a)  # of mu a / R
    stick = 1.0 - ratio
    assert abs(sign * Q / (case.friction * P) - (1 - stick**2)) < 0.05
    x, status = case.points[case.slave, 0], solution.status[case.slave]
    sticking = x[status == ir.contact.STICK]
    cell = 3.0 / 16
    assert abs((np.ptp(sticking) + cell) / (2 * a) - stick) < 0.12
    leading = -1.0 if forward else 1.0  # material comes in there
    assert abs(sticking[np.argmax(leading * sticking)] - leading * a) < 2 * cell
    assert np.abs(solution.slip_velocity[status_nodes(solution, ir.contact.STICK)]).max() < 1e-12
    assert_coulomb(solution, case.friction)


def status_nodes(solution, status):
    return np.flatnonzero(solution.status == status)


def assert_coulomb(solution, friction):
    """The law at every node: bound, slip against the traction."""
    size = np.linalg.norm(solution.traction, axis=1)
    bound = friction * solution.pressure
    closed, slip = solution.status > 0, solution.status == ir.contact.SLIP
    top = bound.max()
    assert np.all(size[closed] <= bound[closed] + 1e-12 * top) and not np.any(size[~closed])
    assert np.abs(size - bound)[slip].max(initial=0.0) < 1e-12 * top
    s, t = solution.slip_velocity[slip], solution.traction[slip]
    assert np.all(np.sum(s * t, axis=1) <= 0.0)
    across = s * size[slip, None] + t * np.linalg.norm(s, axis=1)[:, None]
    assert np.abs(across).max(initial=0.0) < 1e-11 * top * max(np.abs(s).max(initial=0.0), 1e-300)
    assert np.all(solution.gap[closed] < 1e-12) and np.all(solution.pressure[closed] >= 0.0)


@pytest.mark.parametrize("cell", CELLS[:2])
def test_full_slip_carries_friction_times_pressure(cell):
    wheel = Wheel(cell)
    for creep, sign in ((0.2, -1.0), (-0.2, 1.0)):
        solution = wheel.solve(creep)
        force = solution.contact_force.reshape(-1, 2).sum(axis=0)
        assert np.isclose(force[0], sign * 0.3 * force[1], rtol=1e-12, atol=0.0)
        assert set(solution.status[solution.pressure > 0]) == {ir.contact.SLIP}
        assert_coulomb(solution, 0.3)
        # Torque: force times the distance of the deformed contact, and the pressure's, which is off the middle by half
        # a facet (pi / 96) at most; power: force times the slip, about creep times w R.
        off = np.pi / 96 / 0.3
        assert np.isclose(solution.torque, -sign * 0.3 * force[1] * 0.99, rtol=off, atol=0.0)
        assert np.isclose(solution.friction_power, 0.3 * force[1] * 0.2 * 0.1, rtol=0.1, atol=0.0)


def test_creep_of_both_signs_is_mirrored():
    """A wheel that turns the other way on a plane that moves the other way is its mirror image."""
    wheel, other = Wheel("quadrilateral"), Wheel("quadrilateral", omega=-0.1)
    a, b = wheel.solve(2e-3), other.solve(2e-3)
    assert np.isclose(a.torque, -b.torque, rtol=1e-10, atol=0.0)
    assert np.isclose(a.friction_power, b.friction_power, rtol=1e-8, atol=0.0)
    x = wheel.points
    mirror = [np.argmin(np.linalg.norm(x - (p * (-1, 1)), axis=1)) for p in x]
    u = b.u.reshape(-1, 2)[mirror] * (-1, 1)
    assert np.abs(a.u.reshape(-1, 2) - u).max() < 1e-10 * np.abs(a.u).max()


def test_free_rolling():
    """No torque: the wheel finds its angular velocity. What it takes beyond the speed over the radius is the creep of
    the compressed tread, of the order of the depth over the radius."""
    wheel = Wheel("quadrilateral", 16)
    velocity = np.array([0.1, 0.0])
    options = {"contact": wheel.contact, "master_velocity": velocity}
    solution = wheel.rolling.solve_torque(0.0, wheel.fixed, **options)
    driven = abs(wheel.solve(0.05).torque)
    assert abs(solution.torque) < 1e-9 * driven
    assert 0.0 < abs(solution.omega - 0.1) < 0.1 * 0.01 and solution.omega == wheel.spin.omega
    assert_coulomb(solution, 0.3)
    half = wheel.rolling.solve_torque(0.5 * driven, wheel.fixed, **options)
    assert np.isclose(half.torque, 0.5 * driven, rtol=1e-9, atol=0.0) and half.omega > solution.omega


@pytest.mark.parametrize("law", ["linear_elastic", "neo_hookean"])
def test_a_wheel_in_space_that_is_held_along_its_axis(law):
    """Plane strain in space is plane strain: the same numbers, times the width."""
    plane = Wheel("quadrilateral", 24, law=law)
    space = Wheel("hexahedron", 24, layers=1, width=0.5, held=True, law=law)
    a, b = plane.solve(-1e-3), space.solve(-1e-3)
    assert {ir.contact.STICK, ir.contact.SLIP} <= set(a.status)
    assert np.isclose(0.5 * a.torque, b.torque, rtol=1e-9, atol=0.0)
    assert np.isclose(0.5 * a.friction_power, b.friction_power, rtol=1e-7, atol=0.0)
    front = np.flatnonzero(space.points[:, 1] == 0.0)
    at = [np.argmin(np.linalg.norm(space.points[front][:, [0, 2]] - p, axis=1)) for p in plane.points]
    assert np.abs(b.u.reshape(-1, 3)[front][at][:, [0, 2]] - a.u.reshape(-1, 2)).max() < 1e-10 * np.abs(a.u).max()
    assert np.array_equal(b.status[front][at], a.status)


@pytest.mark.parametrize("cell", CELLS[2:])
def test_lateral_creep(cell):
    """A short cylinder: with much creep the force is against it, with lateral creep alone it has no torque to speak
    of."""
    wheel = Wheel(cell, 10, layers=2, width=0.6)
    slipping = wheel.solve(0.3, lateral=0.4)
    force = slipping.contact_force.reshape(-1, 3).sum(axis=0)
    assert np.allclose(force[:2] / (0.3 * force[2]), (-0.6, -0.8), atol=0.02)
    assert_coulomb(slipping, 0.3)
    rolling = wheel.solve(1e-3, lateral=2e-3)
    assert_coulomb(rolling, 0.3)
    lateral = rolling.contact_force.reshape(-1, 3).sum(axis=0)[1]
    assert -0.3 * force[2] < lateral < 0.0
    # The same creepage, given to the tread in place of the plane.
    again = wheel.solve(1e-3, creepage=(0.0, 2e-3 * 0.1, 0.0))
    assert np.abs(again.u - rolling.u).max() < 1e-10 * np.abs(rolling.u).max()


def test_frequencies_at_rest_are_those_of_the_model():
    points, cells = disc("triangle", 6)
    model = ir.Model(points, cells, "triangle", material(2))
    fixed = dofs(nodes_where(points, lambda x: np.hypot(*x) < 0.4), (0, 1), 2)
    rolling = ir.RollingModel(model, {1: ir.Spinning((0.0, 0.0), 0.0)})
    omega, _ = model.frequencies(6, fixed)
    assert np.allclose(np.abs(rolling.frequencies(6, fixed)), omega, rtol=1e-9)


def test_waves_of_a_turning_membrane():
    """Antiplane waves of a disc held at its rim, where the convective equation is exact: waves with one nodal diameter
    are at Omega +- omega_0, omega_0 = j_11 c / R. Squares of 1/16 for a wave of 3.83: 2 % in the frequency; the
    splitting by 2 Omega is that of a first derivative of the same waves, 3 %."""
    points, cells = disc("hexahedron", 16, 1, 0.05)
    model = ir.Model(points, cells, "hexahedron", material(3))
    radius = np.hypot(points[:, 0], points[:, 2])
    in_plane = dofs(np.arange(len(points)), (0, 2), 3)
    fixed = np.union1d(in_plane, 3 * np.flatnonzero(radius > 0.999) + 1)
    c = np.sqrt(2.0 / (2 * 1.3) / 1.5)
    turn = 0.1 * c
    frequencies = ir.RollingModel(model, {1: ir.Spinning(np.zeros(3), turn, (0, 1, 0))}).frequencies(3, fixed)
    expected = np.array([2.404826 * c, -(3.831706 * c - turn), 3.831706 * c + turn])
    assert np.abs(np.abs(frequencies) / np.abs(expected) - 1).max() < 0.02
    assert frequencies[1] < 0.0 < frequencies[2]
    assert np.isclose(frequencies[2] + frequencies[1], 2 * turn, rtol=0.03, atol=0.0)


def test_what_is_refused():
    points, cells = disc("quadrilateral", 4)
    model = ir.Model(points, cells, "quadrilateral", material(2), degree=2)
    with pytest.raises(ValueError, match="degree 1"):
        streamlines.corner_neighbours(model, np.zeros((0, 2), dtype=int))
    with pytest.raises(ValueError, match="z or -z"):
        ir.RollingModel(model, {1: ir.Spinning((0.0, 0.0), 1.0, (0.0, 1.0, 0.0))})
    with pytest.raises(ValueError, match="no body spins"):
        ir.RollingModel(model, {1: ir.Translating((1.0, 0.0))}).first_spin()
