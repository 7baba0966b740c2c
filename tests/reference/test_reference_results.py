# SPDX-License-Identifier: MIT
"""What the calls of the hand-written solver return: balances that hold between the fields of each class of results."""

import dataclasses

import impact_reference as ir
import numpy as np
import pytest
from impact_reference import explicit, newmark, streamlines
from impact_reference.discretisation import Discretisation
from plastic_laws import E, G, NU, Y0, law
from reference_meshes import box, facets_where
from rolling_bodies import Wheel

CHI = 50.0


def block(load=0.0):
    """A square on a rigid floor into which it is pressed a little: model, dofs that are held, floor, contact."""
    points, cells = box("quadrilateral", (3, 2))
    model = ir.Model(points, cells, "quadrilateral", ir.Material(2.0, 0.3, 1.5, "plane_strain"))
    bottom = facets_where(points, cells, "quadrilateral", lambda x: x[1] == 0)
    held = np.flatnonzero(np.repeat(points[:, 1] == 1, 2))
    return model, held, bottom, ir.RigidPlane([0.0, 0.0], [0.0, 1.0], [0.0, 0.01])


def test_states_of_an_explicit_run():
    """Central differences between the states, and the totals of the contact are the sums of its nodal forces."""
    model, held, bottom, floor = block()
    dt = 1e-2
    contact = ir.NodalPenalty(bottom, floor, penalty=CHI)
    run = model.run_explicit(dt, 20, fixed_dofs=held, contacts=[contact])
    (of_contact,) = run.contacts
    assert isinstance(run, ir.ExplicitResult) and isinstance(of_contact, explicit.ContactHistory)
    assert isinstance(contact, explicit._Nodal) and contact.rigid
    np.testing.assert_allclose(np.diff(run.u, axis=0), dt * run.v_half[:-1], atol=1e-15)
    np.testing.assert_allclose(np.diff(run.v_half, axis=0), dt * run.a[1:], atol=1e-13)
    np.testing.assert_allclose(of_contact.force.reshape(21, -1, 2).sum(axis=1), of_contact.total, atol=1e-14)
    assert of_contact.total[0, 1] > 0.0 and run.plastic_strain.shape == (21, 0)
    assert np.array_equal(np.sort(of_contact.nodes), np.unique(bottom))


@pytest.mark.parametrize("given", [{"motion": np.zeros((3, 2))}, {"normals": {"slave": np.zeros((1, 2, 2))}}])
def test_what_only_one_kind_of_master_has(given):
    _, _, bottom, floor = block()
    master = bottom if "motion" in given else floor
    with pytest.raises(ValueError, match="motion is for rigid masters|normals are for smooth surfaces"):
        explicit._Nodal(bottom, master, 0.0, None, given.get("motion"), given.get("normals", {}))
    with pytest.raises(NotImplementedError):
        explicit._Nodal(bottom, floor, 0.0, None, None, {})._bind(None, None, "none", None)


@pytest.mark.parametrize("chi", [CHI, None], ids=["penalty", "multipliers"])
def test_levels_of_an_implicit_run_are_in_equilibrium(chi):
    """Inertia, damping and internal force are what load, contact and supports give, at each time level."""
    model, held, bottom, floor = block()
    contact = ir.ImplicitContact(ir.Contact(model, bottom, floor, prescribed=held), chi)
    loads = np.zeros(model.num_dofs)
    loads[::2] = 0.01
    times = 0.05 * np.arange(4)
    given = times, newmark.NewmarkScheme(), held, None, loads, (0.1, 0.02), "auto", contact, False, 1e-10, 30, None
    run = newmark._Run(model, *given)
    level, state = run.start(np.zeros(model.num_dofs), np.zeros(model.num_dofs))
    levels = [level]
    for number in range(1, 4):
        level, state, iterations = run.step(number, level, state)
        levels.append(level)
        assert iterations > 0
    for level in levels:
        assert isinstance(level, newmark._Level)
        assert not np.delete(level.support, held).any()
        np.testing.assert_allclose(
            level.inertia + level.damping + level.internal, level.load + level.contact_force + level.support, atol=1e-11
        )
        assert run.on_slave(level.contact_force) == pytest.approx(level.total, abs=1e-14)
    assert max(level.total[1] for level in levels) > 0.0


def test_histories_of_an_implicit_run():
    model, held, bottom, floor = block()
    contact = ir.ImplicitContact(ir.Contact(model, bottom, floor, prescribed=held), CHI)
    run = model.run_newmark(0.05, 3, fixed_dofs=held, contact=contact, redistribute=False)
    assert isinstance(run, ir.NewmarkResult) and isinstance(run.contact, ir.NewmarkContactHistory)
    c = run.contact
    assert len(run.time) == 4 == len(run.iterations) + 1 == len(c.total)
    np.testing.assert_allclose(c.force.reshape(4, -1, 2).sum(axis=1), c.total, atol=1e-14)
    np.testing.assert_allclose(c.pressure, CHI * np.maximum(-c.gap, 0.0), atol=1e-13)
    assert np.array_equal(c.status > 0, c.gap < 0.0)
    # Newmark's rule with beta 1/4 and gamma 1/2: means of velocity and acceleration.
    np.testing.assert_allclose(np.diff(run.u, axis=0), 0.025 * (run.v[1:] + run.v[:-1]), atol=1e-14)
    np.testing.assert_allclose(np.diff(run.v, axis=0), 0.025 * (run.a[1:] + run.a[:-1]), atol=1e-13)


def test_a_static_solution_with_contact():
    model, held, bottom, floor = block()
    found = ir.Contact(model, bottom, floor, prescribed=held).solve_penalty(held, chi=CHI)
    assert isinstance(found, ir.ContactSolution)
    both = found.reactions + found.contact_force
    assert both.reshape(-1, 2).sum(axis=0) == pytest.approx([0.0, 0.0], abs=1e-12)
    assert found.contact_force.reshape(-1, 2)[:, 1].sum() == pytest.approx(
        found.points.weight @ found.pressure, rel=1e-12
    )


def test_a_discretisation_of_a_square_without_time():
    """Rigid modes have no force, uniform strain has its energy, and masses are those of the square."""
    points, cells = box("quadrilateral", (3, 2), distort=0.2)
    body = Discretisation(points, cells, "quadrilateral", ir.Material(2.0, 0.3, 1.5, "plane_strain"))
    assert issubclass(ir.Model, Discretisation) and body.linear and not body.axisymmetric
    assert np.abs([body.internal_force(mode) for mode in body.rigid_modes().T]).max() < 1e-13
    stretch = np.column_stack([points[:, 0], 0 * points[:, 0]]).ravel()
    modulus = 2.0 * 0.7 / (1.3 * 0.4)  # lambda + 2 mu
    assert body.energy(stretch) == pytest.approx(modulus / 2, rel=1e-12)
    assert stretch @ body.stiffness().dot(stretch) == pytest.approx(modulus, rel=1e-12)
    assert body.mass(lumped=True).sum() == pytest.approx(2 * 1.5, rel=1e-13)
    bottom = facets_where(points, cells, "quadrilateral", lambda x: x[1] == 0)
    load = body.traction(bottom, [0.0, -4.0]).reshape(-1, 2).sum(axis=0)
    assert load == pytest.approx([0.0, -4.0], abs=1e-13)
    fixed = np.arange(body.num_dofs)
    u, reactions = body.solve_static(fixed, stretch)
    assert np.array_equal(u, stretch) and reactions == pytest.approx(body.internal_force(u), abs=1e-13)
    with pytest.raises(ValueError, match="either one material or"):
        Discretisation(points, cells, "quadrilateral")


def test_answers_of_points_and_elements_that_yield():
    """Simple shear beyond yield with linear hardening: closed form of the radial return."""
    H, shear = 5e3, 8 * Y0 / E
    strain = np.zeros((3, 3))
    strain[0, 1] = strain[1, 0] = shear / 2
    answer = ir.J2Point(law("linear")).evaluate(strain)
    plastic = (np.sqrt(3) * G * shear - Y0) / (3 * G + H)
    assert isinstance(answer, ir.J2Answer)
    assert answer.history.plastic_strain == pytest.approx(plastic, rel=1e-12)
    assert answer.stress[0, 0, 1] == pytest.approx((Y0 + H * plastic) / np.sqrt(3), rel=1e-12)
    assert answer.dissipation == pytest.approx((Y0 + H * plastic) * plastic, rel=1e-12)
    X = (1 + ir.reference_nodes("quadrilateral", 1)) / 2  # a unit square
    u = np.column_stack([shear * X[:, 1], 0 * X[:, 1]]).ravel()
    cell = ir.element_plastic("quadrilateral", X, law("linear"), u, hypothesis="plane_strain")
    assert isinstance(cell, ir.PlasticElement) and cell.dissipation == pytest.approx(answer.dissipation[0], rel=1e-12)
    assert cell.force @ u == pytest.approx(answer.stress[0, 0, 1] * shear, rel=1e-12)
    assert cell.energy == pytest.approx(answer.energy[0], rel=1e-12)


def test_states_of_a_plastic_body():
    """Energies of steps: the work of the supports is stored or plastic, to the rule of the midpoint."""
    points, cells = box("quadrilateral", (2, 2))
    model = ir.Model(points, cells, "quadrilateral", ir.Material(E, NU, 1.0, "plane_strain"))
    body = ir.PlasticBody(model, law("linear"))
    every = np.arange(model.num_dofs)
    sheared = np.column_stack([points[:, 1], 0 * points[:, 1]]).ravel()
    steps = np.linspace(0.0, 8 * Y0 / E, 401)[1:]
    found = body.solve_static(every, steps[:, None] * sheared)
    assert isinstance(found, ir.PlasticStates) and found.u == pytest.approx(steps[:, None] * sheared)
    power = found.reactions @ sheared  # shear force on a unit square
    work = np.trapezoid(np.append(0.0, power), np.append(0.0, steps))
    assert found.energy[-1] + found.work[-1] == pytest.approx(work, rel=1e-3)


@pytest.mark.parametrize("creep", [0.0, 0.02])
def test_a_steady_state_obeys_coulomb(creep):
    wheel = Wheel("quadrilateral", 12, friction=0.3)
    found = wheel.solve(creep)
    assert isinstance(found, ir.RollingSolution)
    size = np.linalg.norm(found.traction, axis=1)
    stick, slip = found.status == 1, found.status == 2
    assert found.pressure.max() > 0.0 and not size[found.status == 0].any()
    assert np.all(size[stick] <= 0.3 * found.pressure[stick] * (1 + 1e-9))
    np.testing.assert_allclose(size[slip], 0.3 * found.pressure[slip], rtol=1e-8)
    assert found.friction_power >= -1e-15 and np.isfinite(found.torque)
    assert not np.delete(found.reactions, wheel.fixed).any()


def test_the_way_back_over_a_facet():
    """An edge: once along it. A triangle: to the point of the far side that the flow comes from."""
    along = streamlines.way_over_facet(0, [1], None, np.array([-2.0]))
    assert along == streamlines.Backward({1: -2.0, 0: 2.0}, {1: 1.0}, 0.5)
    across = streamlines.way_over_facet(0, [1, 2], None, np.array([-1.0, -3.0]))
    assert across.origin == pytest.approx({1: 0.25, 2: 0.75}) and across.duration == pytest.approx(0.25)
    square = streamlines.way_over_facet(0, [1, 2], 3, np.array([-1.0, -4.0]))
    assert square.origin == pytest.approx({2: 0.75, 3: 0.25}) and square.duration == pytest.approx(0.25)
    # The rate of a linear function over the way is its change over the duration.
    values = {0: 1.0, 1: 5.0, 2: -2.0}
    rate = sum(c * values[n] for n, c in across.slope.items())
    change = values[0] - sum(w * values[n] for n, w in across.origin.items())
    assert rate == pytest.approx(change / across.duration)
    away = streamlines.way_over_facet(0, [1, 2], None, np.array([1.0, 3.0]))
    assert away.duration == 0.0 and away.origin == {}
    assert dataclasses.is_dataclass(away)
