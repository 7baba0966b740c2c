# SPDX-License-Identifier: MIT
"""Foundations on any number of ranks; see on_ranks.py."""

import tempfile
from pathlib import Path

import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI
from on_ranks import on_rank_0

import dolfinx_impact as di

COMM = MPI.COMM_WORLD
BOTTOM, TOP, LEFT = 1, 2, 3
WIDTH, HEIGHT = 2.0, 1.0
DENSITY = 2.0


def block(comm=COMM, n=(8, 24), degree=1, cell="quadrilateral"):
    """Displacement of a block of 2 x 1, and tags of its lower and upper side."""
    domain = mesh.create_rectangle(comm, [(0, 0), (WIDTH, HEIGHT)], n, getattr(mesh.CellType, cell))
    sides = {
        BOTTOM: lambda x: np.isclose(x[1], 0.0),
        TOP: lambda x: np.isclose(x[1], HEIGHT),
        LEFT: lambda x: np.isclose(x[0], 0.0),
    }
    found = {tag: mesh.locate_entities_boundary(domain, 1, at) for tag, at in sides.items()}
    facets = np.concatenate(list(found.values()))
    values = np.repeat(list(found), [len(f) for f in found.values()]).astype(np.int32)
    order = np.argsort(facets)
    tags = mesh.meshtags(domain, 1, facets[order], values[order])
    return fem.Function(fem.functionspace(domain, ("Lagrange", degree, (2,))), name="u"), tags


def steel(E=100.0, **options):
    return di.LinearElastic(E, 0.3, DENSITY, "plane_strain", **options)


def uniform(u, velocity):
    """Function with one value in all nodes."""
    v = fem.Function(u.function_space)
    v.x.array.reshape(-1, 2)[:] = velocity
    return v


def check_unit_forces_are_those_of_the_present_constants():
    """Their operators are kept, while constants, stiffness and space stay the same objects."""
    u, tags = block()
    V = u.function_space
    springs = di.Foundation(tags, BOTTOM, (2.0, 5.0), damping=0.5)

    def sums():
        return [COMM.allreduce(values.sum(axis=0), MPI.SUM) for values in springs.unit_forces(V)]

    np.testing.assert_allclose(sums(), [[2.0 * WIDTH, 5.0 * WIDTH], [0.0, 0.5 * WIDTH]], atol=1e-13)
    kept = springs._unit[1]
    springs.constant.value[:] = (3.0, 7.0)
    springs.damping_constant.value = 1.5
    np.testing.assert_allclose(sums(), [[3.0 * WIDTH, 7.0 * WIDTH], [0.0, 1.5 * WIDTH]], atol=1e-13)
    assert springs._unit[1] is kept
    V = fem.functionspace(V.mesh, ("Lagrange", 2, (2,)))
    np.testing.assert_allclose(sums(), [[3.0 * WIDTH, 7.0 * WIDTH], [0.0, 1.5 * WIDTH]], atol=1e-13)
    assert springs._unit[1] is not kept


def check_force_and_energy_under_translations():
    """Each component by itself; the normal of the lower side is vertical. Round-off of some hundred additions."""
    u, tags = block(degree=2)
    for shift in ((0.1, 0.0), (0.0, -0.2), (0.3, 0.4)):
        u.x.array.reshape(-1, 2)[:] = shift
        for stiffness, k in ((3.0, (0.0, 3.0)), ((2.0, 5.0), (2.0, 5.0))):
            springs = di.Foundation(tags, BOTTOM, stiffness, damping=0.5)
            force = -WIDTH * np.multiply(k, shift)
            np.testing.assert_allclose(springs.force(u), force, atol=1e-13)
            energy = di.Energy(springs.energy_form(u, steel())).value()
            assert energy == pytest.approx(-0.5 * np.dot(force, shift), abs=1e-14)
            total = springs.force(u, velocity=uniform(u, (1.0, 2.0)))
            np.testing.assert_allclose(total, force - (0.0, 2.0 * 0.5 * WIDTH), atol=1e-13)


def check_stiffness_that_varies():
    """Pads as a condition on the place, a polynomial, and functions; constant.value is a factor of them."""
    u, tags = block()
    domain = u.function_space.mesh
    x = ufl.SpatialCoordinate(domain)
    u.x.array.reshape(-1, 2)[:] = (1.0, 1.0)
    pads = ufl.conditional(ufl.lt(x[0], 0.5), 4.0, 0.0)  # two cells of eight
    by_cell = fem.Function(fem.functionspace(domain, ("DG", 0)), name="pads")
    by_cell.interpolate(lambda x: np.where(x[0] < 1.0, 2.0, 6.0))
    for stiffness, total in ((pads, (0.0, 2.0)), (x[0] ** 2, (0.0, 8 / 3)), (by_cell, (0.0, 8.0)),
                             (ufl.as_vector([x[0], 2 * by_cell]), (2.0, 16.0))):  # fmt: skip
        springs = di.Foundation(tags, BOTTOM, stiffness)
        np.testing.assert_allclose(springs.force(u), np.negative(total), atol=1e-13)
        springs.constant.value = 0.5
        np.testing.assert_allclose(springs.force(u), -0.5 * np.array(total), atol=1e-13)


def check_static_problem_without_other_supports():
    """A load on springs: the mean settlement is load over stiffness, whatever the body does. Two load steps: springs
    are there from the first. The residual of Newton's method on 1e-10 of the forces."""
    u, tags = block()
    springs = di.Foundation(tags, BOTTOM, (20.0, 50.0))
    problem = di.StaticProblem(u, steel(), loads=[springs, di.Traction(tags, TOP, (0.1, -1.0))])
    problem.solve(steps=2)
    np.testing.assert_allclose(springs.force(u), (-0.1 * WIDTH, WIDTH), rtol=1e-9)
    settlement = springs.force(u)[1] / (50.0 * WIDTH)
    assert settlement == pytest.approx(0.02, rel=1e-9)
    # In the same problem with other springs the settlement is another.
    springs.constant.value = (20.0, 100.0)
    problem.solve()
    np.testing.assert_allclose(springs.force(u), (-0.1 * WIDTH, WIDTH), rtol=1e-9)


def check_contact_finds_that_springs_hold_a_body():
    """A block on springs under a rigid plane that comes down: nothing else holds it."""
    u, tags = block(n=(4, 3))
    plane = di.RigidPlane(point=(0.0, HEIGHT), normal=(0.0, -1.0))
    pair = di.ContactPair(tags, slave=TOP, master=plane)
    springs = di.Foundation(tags, BOTTOM, (20.0, 50.0))
    problem = di.StaticProblem(u, steel(), loads=[springs], contact=[di.Lagrange(pair)])
    plane.displacement = (0.0, -0.01)
    problem.solve()
    force = problem.contact[0].force
    np.testing.assert_allclose(springs.force(u), np.negative(force), atol=1e-10)
    assert -WIDTH * 50.0 * 0.01 < force[1] < -0.5 * WIDTH * 50.0 * 0.01  # the block gives way a little
    free = di.StaticProblem(fem.Function(u.function_space), steel(), contact=[di.Lagrange(pair)])
    with pytest.raises(RuntimeError, match="not held against rigid motion"):
        free.solve()


def moving(kind, u, tags, law=None, velocity=(0.0, -0.1), **options):
    return kind(
        u, law or steel(), velocity=uniform(u, velocity), loads=[di.Foundation(tags, BOTTOM, 4.0, 0.2)], **options
    )


def check_energies_of_all_kinds_of_bodies():
    """The total is constant: linear bodies, others, and bodies that could yield: what the springs store does not
    count as plastic. Steps that are equal: round-off of 400 of them."""
    laws = {
        "linear": steel(),
        "work": di.NeoHookean(100.0, 0.3, DENSITY, "plane_strain"),
        "elastic": di.J2Plasticity(100.0, 0.3, DENSITY, yield_stress=1e3, hypothesis="plane_strain"),
    }
    found = {}
    for name, law in laws.items():
        u, tags = block()
        problem = moving(di.ExplicitProblem, u, tags, law)
        dt = 2e-3
        assert problem.stable_step() > dt
        problem.advance(400 * dt, dt=dt, progress=False)
        found[name] = energy = problem.energy
        assert energy["damping"] > 1e-3 * energy["kinetic"] > 0.0
        assert abs(energy["drift"]) < 1e-11, name
        assert abs(energy["plastic"]) < 1e-12 and energy["external"] == 0.0
    for name in ("kinetic", "internal", "damping"):
        # Strains of a few percent; the plastic body has the mean dilatation of its cells.
        for other in ("elastic", "work"):
            assert found[other][name] == pytest.approx(found["linear"][name], rel=0.05), (other, name)


def check_a_residual_of_ones_own():
    """Springs and dashpots written into a residual do what those among the loads do, to round-off."""
    states = []
    first, tags = block()  # of another mesh the nodes may lie on other ranks: partitions depend on the messages' order
    for own in (False, True):
        u = fem.Function(first.function_space)
        springs = di.Foundation(tags, BOTTOM, 4.0, 0.2)
        velocity = uniform(u, (0.05, -0.1))
        if own:
            v = ufl.TestFunction(u.function_space)
            residual = di.operators.internal_force_form(u, v, steel())
            residual += springs.springs(u, v) + springs.dashpots(velocity, v)
            problem = di.ExplicitProblem(u, residual=residual, density=DENSITY, velocity=velocity)
        else:
            problem = di.ExplicitProblem(u, steel(), velocity=velocity, loads=[springs])
        states.append((problem.stable_step(), problem.stable_step("eigenvalue")))
        problem.advance(0.4, dt=2e-3, progress=False)
        states[-1] += (u.x.array.copy(), problem.velocity.x.array.copy(), problem.energy["damping"])
    for a, b in zip(*states):
        np.testing.assert_allclose(a, b, rtol=1e-6 if np.ndim(a) == 0 else 1e-9, atol=1e-11)


def check_ranks_agree():
    """An explicit and an implicit run on these ranks and on one."""
    for kind, dt in ((di.ExplicitProblem, 2e-3), (di.NewmarkProblem, 0.02)):
        u, tags = block(n=(6, 30))
        problem = moving(kind, u, tags, velocity=(0.03, -0.1))
        problem.advance(0.2, dt=dt, progress=False)
        force = problem.loads[0].force(u, problem.velocity)

        def alone(kind=kind, dt=dt):
            w, own = block(MPI.COMM_SELF, n=(6, 30))
            one = moving(kind, w, own, velocity=(0.03, -0.1))
            one.advance(0.2, dt=dt, progress=False)
            return one.energy, one.loads[0].force(w, one.velocity), one.stable_step()

        energy, expected, step = on_rank_0(COMM, alone)
        np.testing.assert_allclose(force, expected, rtol=1e-9, atol=1e-12)
        assert problem.stable_step() == pytest.approx(step, rel=1e-9)
        for name in ("kinetic", "internal", "damping", "total"):
            assert problem.energy[name] == pytest.approx(energy[name], rel=1e-9), name


def check_added_mass():
    """On any degree and hypothesis the sum of the masses grows by the mass along each coordinate, evenly by length;
    momentum and kinetic energy of a translation follow. Bodies swing slower by it; both problems agree with a mass on a
    spring, to what the block gives way, k H/E = 4e-4, over a turn."""
    for degree, hypothesis in ((1, "plane_strain"), (2, "plane_stress"), (1, "axisymmetric")):
        u, tags = block(degree=degree)
        V = u.function_space
        nodal = di.AddedMass(tags, BOTTOM, 3.0).nodal(V, hypothesis)
        own = V.dofmap.index_map.size_local
        sums = COMM.allreduce(nodal[: 2 * own].reshape(-1, 2).sum(axis=0))
        np.testing.assert_allclose(sums, 3.0, rtol=1e-13)
        x = V.tabulate_dof_coordinates()[:own]
        assert not np.any(nodal[: 2 * own].reshape(-1, 2)[~np.isclose(x[:, 1], 0.0)])
        centre = COMM.allreduce(nodal[: 2 * own : 2] @ x[:, 0]) / 3.0
        # Of a ring between the axis and the width its mean radius is at 2/3.
        assert centre == pytest.approx(2 / 3 * WIDTH if hypothesis == "axisymmetric" else WIDTH / 2, rel=1e-12)
    E, k, speed, added = 5e4, 20.0, -0.1, 5.0
    mass = DENSITY * WIDTH * HEIGHT
    omega = np.sqrt(k * WIDTH / (mass + added))
    for kind, options in ((di.ExplicitProblem, {}), (di.NewmarkProblem, {}), (di.NewmarkProblem, {"lumping": "auto"})):
        u, tags = block(n=(4, 2))
        loads = [di.Foundation(tags, BOTTOM, k), di.AddedMass(tags, TOP, added)]
        problem = kind(u, steel(E), velocity=uniform(u, (0.0, speed)), loads=loads, **options)
        assert problem.energy["kinetic"] == pytest.approx(0.5 * (mass + added) * speed**2, rel=1e-12)
        time = 2.25 * np.pi / omega  # a turn and an eighth
        problem.advance(time, dt=0.5 * problem.stable_step() if kind is di.ExplicitProblem else 5e-3, progress=False)
        weights = problem.mass.array[1 : problem.num_owned : 2]
        mean = COMM.allreduce(weights @ u.x.array[1 : problem.num_owned : 2]) / (mass + added)
        swing = speed / omega * np.sin(omega * time)
        assert mean == pytest.approx(swing, abs=4e-3 * abs(speed) / omega)
        assert problem.energy["kinetic"] / (
            0.5 * (mass + added) * (speed * np.cos(omega * time)) ** 2
        ) == pytest.approx(1.0, abs=0.02)


def check_checkpoints():
    """A run goes on from its file as if it had not stopped; other springs or dashpots are refused."""
    made = tempfile.TemporaryDirectory() if COMM.rank == 0 else None
    path = Path(COMM.bcast(made.name if made else None, root=0)) / "run.h5"
    u, tags = block(n=(6, 30))
    problem = moving(di.ExplicitProblem, u, tags)
    problem.advance(0.1, dt=2e-3, progress=False)
    problem.save(path)
    problem.advance(0.2, dt=2e-3, progress=False)
    w = fem.Function(u.function_space, name="u")
    again = moving(di.ExplicitProblem, w, tags)
    again.restore(path)
    again.advance(0.2, dt=2e-3, progress=False)
    np.testing.assert_allclose(w.x.array, u.x.array, rtol=0, atol=1e-15)
    assert again.energy == pytest.approx(problem.energy, rel=1e-12, abs=1e-15)
    for stiffness, damping in ((4.1, 0.2), (4.0, 0.3), ((0.0, 4.0), 0.2)):
        other = di.ExplicitProblem(
            fem.Function(u.function_space, name="u"), steel(), velocity=uniform(u, 0.0),
            loads=[di.Foundation(tags, BOTTOM, stiffness, damping)],
        )  # fmt: skip
        if np.ndim(stiffness):
            continue  # springs along the coordinates that do what those along the normal do
        with pytest.raises(ValueError, match="foundation|loads"):
            other.restore(path)
    COMM.barrier()
    if made:
        made.cleanup()


def check_values_that_change_in_a_run():
    """A callback makes the pressed springs stiffer, which brings energy: it is stored, and forces and the stable step
    follow."""
    u, tags = block()
    problem = moving(di.ExplicitProblem, u, tags)
    springs, before = problem.loads[0], problem.stable_step()

    def callback(p):
        springs.constant.value = 4.0 if p.step < 10 else 4e3

    problem.advance(20e-3, dt=1e-3, callback=callback, progress=False, energy_limits=None)
    assert problem.stable_step() < 0.9 * before
    left, tags = block()
    fixed = moving(di.ExplicitProblem, left, tags)
    fixed.advance(10e-3, dt=1e-3, progress=False)

    def momentum(p):
        own = slice(1, p.num_owned, 2)
        return COMM.allreduce(p.mass.array[own] @ p.velocity.x.array[own])

    assert momentum(problem) > 0.9 * momentum(fixed)  # they move downwards
    # What is stored is that of the new springs under the present displacement.
    stored = di.Energy(springs.energy_form(u, steel())).value()
    assert stored > 100 * di.Energy(fixed.loads[0].energy_form(left, steel())).value()
    assert problem.energy["internal"] == pytest.approx(
        stored + di.Energy(di.operators.strain_energy_form(u, steel())).value(), rel=1e-12
    )
