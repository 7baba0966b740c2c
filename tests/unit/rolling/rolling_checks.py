# SPDX-License-Identifier: MIT
"""Rolling problems on any number of ranks: a ring of quadrilaterals about the origin, and blocks that flow straight."""


import basix
import basix.ufl
import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI
from over_ranks import largest, smallest
from shared_folder import shared_folder

import dolfinx_impact as di
from dolfinx_impact import compat
from dolfinx_impact.rolling.power_balance import PowerBalance
from dolfinx_impact.rolling.rolling_contact import RollingLagrange
from dolfinx_impact.rolling.sweep_state import SweepState
from dolfinx_impact.rolling.transport import Transport

COMM = MPI.COMM_WORLD
INNER, OUTER = 1.0, 2.0


def tagged(domain, tag=1):
    """All cells with one tag."""
    index_map = domain.topology.index_map(domain.topology.dim)
    count = index_map.size_local + index_map.num_ghosts
    return mesh.meshtags(domain, domain.topology.dim, np.arange(count, dtype=np.int32), np.full(count, tag, np.int32))


def quarter_ring():
    """A quarter of a ring, bent from a rectangle; the ends at x = 0 and y = 0 are not of revolution."""
    domain = mesh.create_rectangle(COMM, [(INNER, 0.0), (OUTER, 1.0)], (4, 16), mesh.CellType.quadrilateral)
    r, angle = domain.geometry.x[:, 0].copy(), domain.geometry.x[:, 1] * np.pi / 2
    domain.geometry.x[:, 0], domain.geometry.x[:, 1] = r * np.cos(angle), r * np.sin(angle)
    return domain


def ring(cells=32):
    """A whole ring with 4 cells across."""
    x, quads = np.zeros((0, 2)), np.zeros((0, 4), dtype=np.int64)
    if COMM.rank == 0:
        r, angle = np.linspace(INNER, OUTER, 5), 2 * np.pi * np.arange(cells) / cells
        x = np.array([[a * np.cos(t), a * np.sin(t)] for t in angle for a in r])
        node = 5 * np.arange(cells)
        after = np.roll(node, -1)
        quads = np.array([[n + i, n + i + 1, m + i, m + i + 1] for n, m in zip(node, after) for i in range(4)])
    element = basix.ufl.element("Lagrange", "quadrilateral", 1, shape=(2,))
    return mesh.create_mesh(COMM, quads, x=x, e=element)


def bound(V):
    """Hold the inner surface."""
    return [fem.dirichletbc(np.zeros(2), fem.locate_dofs_geometrical(V, lambda x: np.hypot(x[0], x[1]) < 1.001), V)]


def spinning(law=di.LinearElastic, omega=0.1, domain=None, **given):
    domain = domain or ring()
    V = fem.functionspace(domain, ("Lagrange", 1, (2,)))
    material = law(1.0, 0.3, density=1.0, hypothesis="plane_strain")
    motions = {1: di.Spin((0.0, 0.0), (0.0, 0.0, 2.0), omega)}
    return di.RollingProblem(fem.Function(V), material, tagged(domain), motions, bcs=bound(V), **given)


def norm(problem):
    u = problem.u
    owned = u.x.array[: u.function_space.dofmap.index_map.size_local * 2]
    return np.sqrt(COMM.allreduce(float(owned @ owned)))


def check_solution_does_not_depend_on_ranks():
    found = {}
    for law in (di.LinearElastic, di.StVenantKirchhoff, di.NeoHookean):
        problem = spinning(law, omega=0.2)
        assert problem.solve(steps=2).converged
        found[law.__name__] = norm(problem)
        assert abs(problem.torque) < 1e-8  # nothing turns the ring; forces at its supports are of order 0.1
    # Finite strain differs by the order of the strain, 0.1; a wrong law would be off by more.
    assert all(0.5 < value / found["LinearElastic"] < 2.0 for value in found.values())
    alone = spinning(omega=0.2)
    alone.solve()
    assert norm(alone) == pytest.approx(found["LinearElastic"], rel=1e-9)  # two steps or one: linear


def check_beyond_the_critical_speed():
    problem = spinning(omega=0.1)
    problem.solve()
    before = problem.u.x.array.copy()
    problem.motions[1].omega = 3.0  # the ring's shear waves travel at 0.62
    with pytest.raises(RuntimeError, match="critical"):
        problem.solve()
    assert np.array_equal(problem.u.x.array, before)
    problem.motions[1].omega = 0.1
    assert problem.solve().converged
    assert np.allclose(problem.u.x.array, before, atol=1e-10)


def check_critical_factor():
    """A straight flow through a bar that is held at its ends is critical at the speed of plane longitudinal waves:
    of displacements along the flow stiffness and W are multiples of each other, also of finite elements."""
    domain = mesh.create_rectangle(COMM, [(0.0, 0.0), (4.0, 1.0)], (16, 4))
    V = fem.functionspace(domain, ("Lagrange", 1, (2,)))
    ends = fem.locate_dofs_geometrical(V, lambda x: np.isclose(x[0], 0.0) | np.isclose(x[0], 4.0))
    across, _ = V.sub(1).collapse()
    sides = fem.locate_dofs_geometrical((V.sub(1), across), lambda x: np.full(x.shape[1], True))
    bcs = [fem.dirichletbc(np.zeros(2), ends, V), fem.dirichletbc(fem.Function(across), sides, V.sub(1))]
    E, nu, density = 2.0, 0.3, 0.7
    material = di.LinearElastic(E, nu, density=density, hypothesis="plane_strain")
    waves = np.sqrt(E * (1 - nu) / ((1 + nu) * (1 - 2 * nu)) / density)
    motion = di.Translation((0.25, 0.0))
    problem = di.RollingProblem(fem.Function(V), material, tagged(domain), {1: motion}, bcs=bcs)
    assert problem.critical_factor() == pytest.approx(waves / 0.25, rel=1e-9)
    motion.velocity = (0.0, 0.0)
    assert problem.critical_factor() == np.inf
    # Just below it and beyond it.
    for factor, stable in ((0.999, True), (1.001, False)):
        motion.velocity = (factor * waves, 0.0)
        if stable:
            assert problem.solve().converged
        else:
            with pytest.raises(RuntimeError, match="critical"):
                problem.solve()
    loose = di.RollingProblem(fem.Function(V), material, tagged(domain), {1: motion})
    with pytest.raises(ValueError, match="nothing resists rigid motion"):
        loose.critical_factor()


def check_campbell():
    """Frequencies against spin; a backward wave stands at the critical spin, where its frequency is zero."""
    problem = spinning(omega=0.1)
    critical = 0.1 * problem.critical_factor()
    found = problem.campbell([0.0, 0.05, 0.9 * critical, 0.99 * critical], 3, progress=False)
    assert found["frequencies"].shape == (4, 3) and problem.omega == pytest.approx(0.99 * critical)
    assert np.all(found["frequencies"][0] > 0.0)  # still: no direction
    lowest = found["frequencies"][2:, 0]
    assert np.all(lowest < 0.0)
    # Near the critical spin the frequency goes to zero as the wave's number times the missing spin.
    assert lowest[1] / lowest[0] == pytest.approx(0.1, abs=0.03)
    with pytest.raises(ValueError, match="omegas is empty"):
        problem.campbell([], 3)
    with pytest.raises(TypeError, match="omegas"):
        problem.campbell(["fast"], 3)


def check_frequencies_come_in_waves():
    still, turning = (spinning(omega=omega).frequencies(5) for omega in (0.0, 0.02))
    assert np.all(still > 0)
    assert np.all(np.diff(np.abs(turning)) >= -1e-9)
    assert np.any(turning < 0) and np.any(turning > 0)
    other = spinning(omega=-0.02).frequencies(5)
    assert np.allclose(turning, other, rtol=1e-6)  # signs count along the spin


def check_contact_with_a_plane():
    domain = ring()
    facets = mesh.locate_entities_boundary(domain, 1, lambda x: np.hypot(x[0], x[1]) > 1.99)
    tags = mesh.meshtags(domain, 1, np.sort(facets), np.full(len(facets), 7, np.int32))
    forces = []
    for kind in (di.Lagrange, di.Penalty):
        pair = di.ContactPair(tags, 7, di.RigidPlane((0.0, -1.97), (0.0, 1.0)))
        problem = spinning(omega=0.01, domain=domain, contact=[kind(pair)])
        assert problem.solve().converged
        force = problem.contact[0].force
        assert force[1] > 1e-3 and abs(force[0]) < 1e-8 * force[1]
        assert abs(problem.torque) < 1e-7 * force[1] * OUTER
        forces.append(force[1])
    assert forces[1] == pytest.approx(forces[0], rel=0.2)  # penalty lets the ring in


def check_frequencies_before_anything_is_solved():
    """With a contact that is open they are those without it; the deeper the ring is pressed in, the higher."""
    domain = ring()
    facets = mesh.locate_entities_boundary(domain, 1, lambda x: np.hypot(x[0], x[1]) > 1.99)
    tags = mesh.meshtags(domain, 1, np.sort(facets), np.full(len(facets), 7, np.int32))

    def lowest(*heights, **options):
        pairs = [di.ContactPair(tags, 7, di.RigidPlane((0.0, y), (0.0, 1.0))) for y in heights]
        problem = spinning(omega=0.01, domain=domain, contact=[di.Penalty(p, **options) for p in pairs])
        return abs(problem.frequencies(1)[0]), problem.critical_factor()

    free = lowest()
    for options in ({}, {"penalty": 1.0}):
        np.testing.assert_allclose(lowest(-2.1, **options), free, rtol=1e-9)
        assert np.all(np.array(lowest(-1.97, **options)) > np.array(free) * (1 + 1e-6))


def check_straight_flow():
    domain = mesh.create_rectangle(COMM, [(0.0, 0.0), (4.0, 1.0)], (16, 4))
    V = fem.functionspace(domain, ("Lagrange", 1, (2,)))
    bcs = [fem.dirichletbc(np.zeros(2), fem.locate_dofs_geometrical(V, lambda x: np.isclose(x[1], 0.0)), V)]
    material = di.LinearElastic(1.0, 0.3, density=1.0, hypothesis="plane_strain")
    sizes = []
    for load, speed in ((0.0, 0.3), (1e-3, 0.0), (1e-3, 0.3)):
        motions = {1: di.Translation((speed, 0.0))}
        given = {"bcs": bcs, "loads": [di.BodyForce((0.0, load))]}
        problem = di.RollingProblem(fem.Function(V), material, tagged(domain), motions, **given)
        problem.solve()
        sizes.append(norm(problem))
    assert sizes[0] < 1e-14  # a straight flow has no acceleration
    assert sizes[2] > sizes[1] * (1 + 1e-4)  # W softens


def check_bad_bodies():
    with pytest.raises(ValueError, match=r"not one of revolution.*cell \d+ .* at \("):
        spinning(domain=quarter_ring())
    domain = ring()
    V = fem.functionspace(domain, ("Lagrange", 1, (2,)))
    material = di.LinearElastic(1.0, 0.3, density=1.0, hypothesis="plane_strain")
    turn = di.Spin((0.0, 0.0), (0.0, 0.0, 1.0), 0.1)

    def make(motions):
        return di.RollingProblem(fem.Function(V), material, tagged(domain), motions, bcs=bound(V))

    with pytest.raises(ValueError, match=r"not one of revolution"):
        make({1: di.Spin((0.5, 0.0), (0.0, 0.0, 1.0), 0.1)})
    with pytest.raises(ValueError, match=r"tags \[1\], which have no motion"):
        make({2: turn})
    with pytest.raises(ValueError, match=r"tags \[2\], which no cell carries"):
        make({1: turn, 2: turn})
    with pytest.raises(ValueError, match="along z"):
        make({1: di.Spin((0.0, 0.0), (1.0, 0.0, 0.0), 0.1)})
    with pytest.raises(ValueError, match="components"):
        make({1: di.Translation((1.0, 0.0, 0.0))})
    with pytest.raises(TypeError, match="Spin or a Translation"):
        make({1: 3.0})


def wheel_cells(around=48, through=3, across=4, width=0.2):
    """Nodes and hexahedra of a ring about the z axis, radii 0.5 and 1."""
    angle = np.arange(around) * 2 * np.pi / around - np.pi / 2
    r, z = np.linspace(0.5, 1.0, through + 1), np.linspace(-width, width, across + 1)
    A, R, Z = np.meshgrid(angle, r, z, indexing="ij")
    x = np.stack([R * np.cos(A), R * np.sin(A), Z], axis=-1).reshape(-1, 3)
    i, j, k = (n.ravel() for n in np.meshgrid(*(np.arange(n) for n in (around, through, across)), indexing="ij"))

    def node(di, dj, dk):
        return (((i + di) % around) * (through + 1) + j + dj) * (across + 1) + k + dk

    corners = [(0, 0, 0), (0, 1, 0), (1, 0, 0), (1, 1, 0), (0, 0, 1), (0, 1, 1), (1, 0, 1), (1, 1, 1)]
    return x, np.column_stack([node(*corner) for corner in corners]).astype(np.int64)


def hexahedra(x, cells):
    """A mesh of them, which rank 0 alone hands over."""
    if COMM.rank > 0:
        cells, x = cells[:0], x[:0]
    element = basix.ufl.element("Lagrange", "hexahedron", 1, shape=(3,))
    return mesh.create_mesh(
        COMM, cells, x=x, e=element, partitioner=compat.create_cell_partitioner(mesh.GhostMode.shared_facet)
    )


def is_tread(x):
    return np.isclose(np.hypot(x[0], x[1]), 1.0)


def wheel_mesh():
    """The ring with the tag 7 on its tread."""
    domain = hexahedra(*wheel_cells())
    tread = mesh.locate_entities_boundary(domain, 2, is_tread)
    return domain, mesh.meshtags(domain, 2, np.sort(tread), np.full(len(tread), 7, np.int32))


def wheel_on_rail(wheel_is_slave, rates):
    """Forces on a wheel that rolls towards +x on a block, which flows towards -x with unit speed."""
    wheel, tyres = wheel_cells(through=2)
    block = mesh.create_box(MPI.COMM_SELF, [(-0.5, -1.2, -0.3), (0.5, -1.0, 0.3)], (10, 2, 6), mesh.CellType.hexahedron)
    domain = hexahedra(
        np.concatenate([wheel, block.geometry.x]), np.concatenate([tyres, compat.geometry_dofmap(block) + len(wheel)])
    )
    tread = mesh.locate_entities_boundary(domain, 2, is_tread)
    rail = mesh.locate_entities_boundary(domain, 2, lambda x: np.isclose(x[1], -1.0) & (np.abs(x[0]) < 0.51))
    rail = np.setdiff1d(rail, tread)
    facets, tags = np.concatenate([tread, rail]), np.repeat(np.array([7, 8], np.int32), [len(tread), len(rail)])
    order = np.argsort(facets)
    surfaces = mesh.meshtags(domain, 2, facets[order], tags[order])
    count = domain.topology.index_map(3).size_local + domain.topology.index_map(3).num_ghosts
    middles = mesh.compute_midpoints(domain, 3, np.arange(count, dtype=np.int32))
    bodies = mesh.meshtags(
        domain, 3, np.arange(count, dtype=np.int32), np.where(middles[:, 1] < -1.0, 2, 1).astype(np.int32)
    )
    V = fem.functionspace(domain, ("Lagrange", 1, (3,)))
    pressed, held = fem.Function(V), []
    for where, approach in ((lambda x: np.isclose(np.hypot(x[0], x[1]), 0.5), 0.01), (lambda x: x[1] < -1.199, 0.0)):
        held.append(fem.locate_dofs_geometrical(V, where))
        pressed.x.array.reshape(-1, 3)[held[-1]] = (0.0, -approach, 0.0)
    pair = di.ContactPair(surfaces, *((7, 8) if wheel_is_slave else (8, 7)), friction=0.3)
    problem = di.RollingProblem(
        fem.Function(V), di.LinearElastic(100.0, 0.3, density=1e-3), bodies,
        {1: di.Spin((0, 0, 0), (0, 0, 1), -1.0), 2: di.Translation((-1.0, 0.0, 0.0))},
        contact=[di.Lagrange(pair)], bcs=[fem.dirichletbc(pressed, dofs) for dofs in held],
    )  # fmt: skip
    curve = problem.sweep(**{name: [value] for name, value in rates.items()}, progress=False)
    return np.array(curve["force"][0]) * (1.0 if wheel_is_slave else -1.0)


def check_creepages_are_those_of_the_wheel_whichever_body_is_slave():
    """Under full slip the force on the wheel is friction against its motion on the rail, whichever surface carries the
    multipliers; spin creep, with the contact's centre in the plane of symmetry, turns it to the same side.
    """
    for rates in ({"lateral": 0.1}, {"lateral": -0.1}, {"lateral": 0.0, "spin": 0.5}):
        ours, other = (wheel_on_rail(slave, rates) for slave in (True, False))
        assert ours[1] > 0.1 and other[1] == pytest.approx(ours[1], rel=0.2)  # coarse meshes that do not fit
        if rates["lateral"]:
            for force in (ours, other):
                assert force[2] == pytest.approx(-np.sign(rates["lateral"]) * 0.3 * force[1], rel=0.02)
        else:
            assert ours[2] > 0.01 * ours[1] and 1 / 3 < other[2] / ours[2] < 3.0  # two cells in the contact


def wheel_on_plane(
    friction=0.3, speed=1.0, omega=-1.0, contact=di.Lagrange, approach=0.01, law=di.LinearElastic, scale=1.0, **more
):
    """A wheel that rolls towards +x on a rigid plane; `scale` stretches it after it was tagged."""
    domain, tags = wheel_mesh()
    domain.geometry.x[:, :] *= scale
    V = fem.functionspace(domain, ("Lagrange", 1, (3,)))
    hub, values = mesh.locate_entities_boundary(
        domain, 2, lambda x: np.isclose(np.hypot(x[0], x[1]), 0.5 * scale)
    ), fem.Function(V)
    axle = fem.locate_dofs_topological(V, 2, hub)
    values.x.array.reshape(-1, 3)[axle] = (0.0, -approach, 0.0)
    plane = di.RigidPlane((0.0, -1.0, 0.0), (0.0, 1.0, 0.0))
    plane.velocity = (-speed, 0.0, 0.0)
    pair = di.ContactPair(tags, 7, plane, friction=friction)
    rubber = law(100.0, 0.3, density=1e-3)
    return di.RollingProblem(
        fem.Function(V), rubber, tagged(domain), {1: di.Spin((0, 0, 0), (0, 0, 1), omega)},
        contact=[contact(pair)], bcs=[fem.dirichletbc(values, axle)], **more,
    )  # fmt: skip


# Solutions on one rank: force by creep, lateral creep and spin creep.
CURVE = {"creep": [2e-3, 8e-3, 0.04], "lateral": [0.0, 2e-3, 0.0], "spin": [0.0, 0.0, 0.05]}
FORCES = [
    [-2.3283819448043e-02, 2.2187752694720e-01, 0.0],
    [8.6920017125771e-03, 2.2117202814341e-01, -4.3132878436828e-03],
    None,
]


def check_creep_forces_do_not_depend_on_ranks():
    problem = wheel_on_plane()
    curve = problem.sweep(**CURVE, progress=False)
    np.testing.assert_allclose(curve["force"][:2], FORCES[:2], atol=1e-9 * 0.222)
    x, y, z = curve["force"].T
    assert np.all(np.hypot(x, z) <= 0.3 * y * (1 + 1e-9))
    # Full slip at the largest creep, against the motion of the surface; spin creep turns the force sideways.
    assert np.hypot(x, z)[2] > 0.9 * 0.3 * y[2] and x[2] > 0.0 and abs(z[2]) > 1e-4 * y[2]
    assert curve["torque"][1] == pytest.approx(problem_torque(problem, CURVE, 1), rel=1e-9)
    np.testing.assert_allclose(curve["omega"], -1.0 * (1.0 + np.array(CURVE["creep"])), rtol=1e-15)


def problem_torque(problem, curve, k):
    """Torque of one point of a curve, solved once more from another state."""
    problem.motions[1].omega = -1.0
    problem.sweep(**{name: [values[k]] for name, values in curve.items()}, progress=False)
    contact = problem.contact[0]
    forces, u = contact.contact_forces().reshape(-1, 3), problem.u
    num = len(forces)
    places = u.function_space.tabulate_dof_coordinates()[:num] + u.x.array[: 3 * num].reshape(-1, 3)
    axle = np.array([0.0, -0.01, 0.0])  # as the hub is displaced
    moment = COMM.allreduce(np.cross(places - axle, forces).sum(axis=0))
    assert problem.torque == pytest.approx(-moment[2], rel=1e-12)
    return problem.torque


def check_free_rolling():
    problem = wheel_on_plane()
    problem.solve(torque=0.0)
    assert abs(problem.torque) < 1e-9 and abs(problem.contact[0].force[0]) < 1e-3 * problem.contact[0].force[1]
    assert -1.05 < problem.omega < -1.0  # the pressed wheel has a smaller radius, and turns faster
    status = problem.contact[0].status
    assert COMM.allreduce(np.count_nonzero(status == di.ContactStatus.stick)) > 0


def check_power_balance():
    """What drives is what friction and deformation take, to the solver's tolerance; with all creepages."""
    for law in (di.LinearElastic, di.NeoHookean):
        problem = wheel_on_plane(law=law)
        problem.sweep(creep=[0.04], lateral=[2e-3], spin=[0.05], progress=False)
        balance, contact = problem.power_balance(), problem.contact[0]
        assert isinstance(balance, PowerBalance)
        # The plane moves with -1 along x. Spin creep drives as well: all of it is more than torque and traction.
        driven = problem.torque * problem.omega - contact.force[0] * 1.0
        assert balance.driving > driven > 0.0
        assert balance.friction == pytest.approx(contact.friction_power, rel=1e-12)
        assert balance.friction + balance.rolling == pytest.approx(balance.driving, rel=1e-9)
    with pytest.raises(ValueError, match="no contact has friction"):
        wheel_on_plane(friction=0.0).power_balance()


def check_a_sweep_goes_on_where_it_was_stopped():
    with shared_folder() as path:
        file, whole = path / "curve.h5", wheel_on_plane().sweep(creep=[0.0, 2e-3, 4e-3], progress=False)
        wheel_on_plane().sweep(creep=[0.0, 2e-3], file=file, progress=False)
        again = wheel_on_plane()
        with pytest.raises(ValueError, match="other creepages"):
            again.sweep(creep=[1e-3, 2e-3, 4e-3], file=file, progress=False)
        with pytest.raises(ValueError, match="another problem"):
            wheel_on_plane(approach=0.011).sweep(creep=[0.0, 2e-3, 4e-3], file=file, progress=False)
        with pytest.raises(ValueError, match="another problem"):
            wheel_on_plane(friction=0.2).sweep(creep=[0.0, 2e-3, 4e-3], file=file, progress=False)
        continued = again.sweep(creep=[0.0, 2e-3, 4e-3], file=file, progress=False)
        np.testing.assert_allclose(continued["force"], whole["force"], atol=1e-9)
        assert again.omega == pytest.approx(-1.004)
        complete = wheel_on_plane()
        found = complete.sweep(creep=[0.0, 2e-3, 4e-3], file=file, progress=False)
        np.testing.assert_array_equal(found["force"], continued["force"])
        # DOLFINx may number two meshes of the same cells in different ways on several ranks, and sums are then taken in
        # another order.
        for one, other in zip(states_of(complete), states_of(again), strict=True):
            np.testing.assert_allclose(one, other, rtol=0.0, atol=1e-12 * np.abs(other).max())


def state_of(problem):
    """Displacement, and what is told of the contact."""
    c = problem.contact[0]
    parts = [problem.u.x.array, c.force, c.moment, [c.area, c.friction_power, problem.torque, problem.omega], c.gap]
    parts += [c.normal, c.pressure, c.traction, c.slip_velocity, c.status]
    return np.concatenate([np.ravel(part) for part in parts])


def states_of(problem):
    """The same at the nodes of all ranks, by their place at rest, and totals."""
    c, V = problem.contact[0], problem.u.function_space
    g = V.mesh.geometry.dim
    places = np.round(V.tabulate_dof_coordinates()[:, :g], 9)
    owned = np.arange(V.dofmap.index_map.size_local)
    fields = [(owned, problem.u.x.array.reshape(-1, g)[owned])]
    fields += [(c.nodes, values) for values in (c.gap, c.normal, c.pressure, c.traction, c.slip_velocity, c.status)]
    for nodes, values in fields:
        rows = np.vstack(COMM.allgather(np.column_stack([places[nodes], np.nan_to_num(values, posinf=-1.0)])))
        yield rows[np.lexsort(rows[:, :g].T)]
    yield np.concatenate([c.force, c.moment, [c.area, c.friction_power, problem.torque, problem.omega]])


def check_files_of_other_sweeps_are_refused():
    """Another geometry, material, support, obstacle, friction, or option of the solution."""
    curve = {"creep": [0.0, 2e-3], "progress": False}
    others = {
        "mesh": {"scale": 1.01}, "material": {"law": di.NeoHookean}, "bcs": {"approach": 0.0101},
        "contact.0..pair.friction": {"friction": 0.31}, "contact.0..pair.master.velocity": {"speed": 1.01},
        "motions": {"omega": -1.01},
    }  # fmt: skip
    with shared_folder() as path:
        wheel_on_plane().sweep(file=path / "a.h5", **curve)
        for words, change in others.items():
            problem = wheel_on_plane(**change)
            with pytest.raises(ValueError, match=f"another problem, {words}"):
                problem.sweep(file=path / "a.h5", **curve)
        with pytest.raises(ValueError, match="another problem, options"):
            wheel_on_plane().sweep(file=path / "a.h5", steps=2, **curve)


def check_damaged_files_of_sweeps_are_refused():
    """One sentence on all ranks, wherever a byte was changed; a table that is missing or short; an end that is cut."""
    import h5py

    def edited(change):
        def edit(file):
            with h5py.File(file, "a") as data:
                change(data)

        return edit

    def short(data):
        rows = data["torque"][:-1]
        del data["torque"]
        data["torque"] = rows

    def flipped(place):
        def flip(file):
            content = bytearray(file.read_bytes())
            content[int(place * (len(content) - 1))] ^= 4
            file.write_bytes(content)

        return flip

    damages = [flipped(place) for place in np.linspace(0.0, 1.0, 23)]
    damages += [lambda file: file.write_bytes(file.read_bytes()[:3000]), lambda file: file.write_bytes(b"")]
    damages += [edited(short), edited(lambda data: data.__delitem__("force"))]
    damages += [edited(lambda data: data["force"].__setitem__(1, np.nan))]
    damages += [edited(lambda data: data["force"].__setitem__(1, 7.0 * data["force"][1]))]
    with shared_folder() as path:
        good, bad = path / "good.h5", path / "bad.h5"
        problem = wheel_on_plane()
        problem.sweep(creep=[0.0, 2e-3], file=good, progress=False)
        before = state_of(problem)
        for k, damage in enumerate(damages):
            problem.motions[1].omega = -1.0
            if COMM.rank == 0:
                bad.write_bytes(good.read_bytes())
                damage(bad)
            COMM.barrier()
            with pytest.raises(RuntimeError, match="bad.h5 cannot be read .*remove it") as error:
                problem.sweep(creep=[0.0, 2e-3], file=bad, progress=False)
            assert len(set(COMM.allgather(str(error.value).split(": ", 1)[-1]))) == 1, k
        problem.motions[1].omega = -1.002
        np.testing.assert_array_equal(state_of(problem), before)


def rolling_on_planes(surfaces, planes, friction, law=di.LinearElastic, contact=di.Lagrange):
    """A wheel in the plane that is pressed on frictionless or rough planes and turns.

    Args:
        surfaces: {tag: condition on the angle of the middle of a facet of the rim, from the lowest point}.
        planes: list of (slave tag, direction to the plane); friction: of each.
    """
    domain = ring()
    V = fem.functionspace(domain, ("Lagrange", 1, (2,)))
    rim = mesh.locate_entities_boundary(domain, 1, lambda x: np.hypot(x[0], x[1]) > OUTER - 1e-3)
    x = mesh.compute_midpoints(domain, 1, rim)
    angle, values = np.arctan2(x[:, 0], -x[:, 1]), np.zeros(len(rim), np.int32)
    for tag, where in surfaces.items():
        values[where(angle)] = tag
    tags = mesh.meshtags(domain, 1, rim, values)
    hub = fem.Function(V)
    hub.x.array.reshape(-1, 2)[:] = 0.02 * np.sum([direction for _, direction in planes], axis=0) / len(planes)
    inner = fem.locate_dofs_geometrical(V, lambda x: np.hypot(x[0], x[1]) < INNER + 1e-3)
    pairs = []
    for (tag, direction), mu in zip(planes, friction):
        plane = di.RigidPlane(OUTER * np.array(direction), -np.array(direction))
        plane.velocity = 0.2 * np.array([direction[1], -direction[0]])  # along with the rim
        pairs.append(contact(di.ContactPair(tags, tag, plane, friction=mu)))
    material = law(100.0, 0.3, density=1e-3, hypothesis="plane_strain")
    motions = {1: di.Spin((0.0, 0.0), (0.0, 0.0, 1.0), -0.1)}
    bcs = [fem.dirichletbc(hub, inner)]
    return di.RollingProblem(fem.Function(V), material, tagged(domain), motions, contact=pairs, bcs=bcs)


DOWN, ASIDE = (0.0, -1.0), (1.0, 0.0)
WHOLE, PARTS = {7: lambda a: a < 9.0}, {7: lambda a: a < 0.0, 8: lambda a: a > 0.0}


def check_nodes_that_pairs_share():
    """Without friction a rim in two tags rolls as in one, and one rim on two planes as with a tag for each of them;
    with friction in any of the pairs shared nodes are refused, whether pairs agree in their normals or not."""
    apart = {7: lambda a: np.abs(a) < 0.6, 8: lambda a: np.abs(a - np.pi / 2) < 0.6}
    one_plane, both = [(7, DOWN)], [(7, DOWN), (8, ASIDE)]
    for law in (di.LinearElastic, di.StVenantKirchhoff):
        for first, second in (
            ((WHOLE, one_plane), (PARTS, [(7, DOWN), (8, DOWN)])),
            ((apart, both), (WHOLE, [(7, DOWN), (7, ASIDE)])),
        ):
            runs = [rolling_on_planes(*given, [0.0] * 2, law) for given in (first, second)]
            assert all(run.solve().converged for run in runs)
            ours, theirs = (sum(np.array(c.force) for c in run.contact) for run in runs)
            assert ours[1] > 0.05
            assert np.abs(ours - theirs).max() < 1e-9 * np.abs(ours).max(), law
            assert abs(norm(runs[0]) - norm(runs[1])) < 1e-9 * norm(runs[0]), law
    for surfaces, planes in ((PARTS, [(7, DOWN), (8, DOWN)]), (WHOLE, [(7, DOWN), (7, ASIDE)])):
        for friction in ((0.3, 0.3), (0.3, 0.0), (0.0, 0.3)):
            with pytest.raises(ValueError, match="shares nodes with another contact.*rolling with friction solves for"):
                rolling_on_planes(surfaces, planes, friction)
    rough = rolling_on_planes(apart, both, (0.3, 0.3))
    assert rough.solve().converged
    for c in rough.contact:
        assert np.linalg.norm(c.force) > 0.05


def check_linear_bodies_have_one_tangent():
    """Points of a rising creep curve need no further factors to tell that they are below the critical speed; bodies of
    finite strain need them at each."""
    for law in (di.LinearElastic, di.StVenantKirchhoff):
        problem = wheel_on_plane(law=law)
        first = problem.omega
        problem.sweep(creep=[0.0, 1e-3, 2e-3], progress=False)
        reached = np.abs(first) * (1.1 if law is di.LinearElastic else 1.002)
        assert np.abs(problem._cpp_object.stable_rates).max() == pytest.approx(reached, rel=1e-12)


def check_bad_friction():
    with pytest.raises(ValueError, match="opposite sense"):
        wheel_on_plane(omega=1.0).solve()
    with pytest.raises(ValueError, match="friction has no direction"):
        wheel_on_plane(omega=0.0, speed=0.0).solve()
    with pytest.raises(ValueError, match="needs Lagrange"):
        wheel_on_plane(contact=di.Penalty)
    with pytest.raises(ValueError, match="no contact has friction"):
        wheel_on_plane(friction=0.0).solve(torque=0.0)
    with pytest.raises(ValueError, match="no contact has friction"):
        wheel_on_plane(friction=0.0).sweep(creep=[0.0])
    with pytest.raises(ValueError, match="omega is zero"):
        wheel_on_plane(omega=0.0).solve(torque=0.0)
    with pytest.raises(ValueError, match="omega is zero"):
        wheel_on_plane(omega=0.0).sweep(creep=[0.0])
    problem = wheel_on_plane()
    with pytest.raises(ValueError, match="different lengths"):
        problem.sweep(creep=[0.0, 1e-3], lateral=[0.0, 1e-3, 2e-3])
    with pytest.raises(ValueError, match="at least one"):
        problem.sweep()
    with pytest.raises(TypeError, match="creep must be numbers"):
        problem.sweep(creep="much")
    with pytest.raises(ValueError, match="no body has a Spin"):
        problem.motions[1] = di.Translation((1.0, 0.0, 0.0))
        problem.sweep(creep=[0.0])


def check_a_steady_state_is_the_start_of_a_motion():
    """A ring that spins keeps its radius when its material is let go; from the undeformed shape it would swing."""
    domain = ring()
    V = fem.functionspace(domain, ("Lagrange", 1, (2,)))
    rubber = di.NeoHookean(1.0, 0.3, density=1.0, hypothesis="plane_strain")
    held = []  # three components, which are zero by symmetry: no support bears a force
    for component, at in ((1, (OUTER, 0.0)), (1, (-OUTER, 0.0)), (0, (0.0, OUTER))):
        V0, _ = V.sub(component).collapse()
        near = fem.locate_dofs_geometrical(
            (V.sub(component), V0), lambda x: np.hypot(x[0] - at[0], x[1] - at[1]) < 1e-6
        )
        held.append(fem.dirichletbc(fem.Function(V0), near, V.sub(component)))
    spin = di.Spin((0.0, 0.0), (0.0, 0.0, 1.0), 0.2)
    changes = {}
    for start in ("undeformed", "steady"):
        rolling = di.RollingProblem(fem.Function(V), rubber, tagged(domain), {1: spin}, bcs=held)
        if start == "steady":
            rolling.solve()
        u = rolling.u.copy()
        run = di.ExplicitProblem(u, rubber, velocity=rolling.velocity())
        radii = [mean_radius(u)]
        for k in range(1, 9):
            run.advance(1.0 * k, progress=False)
            radii.append(mean_radius(u))
        changes[start] = np.ptp(radii) / OUTER
    # The lumped mass of the run differs from the consistent one of the steady state by the order of the cells' size.
    assert changes["undeformed"] > 1e-2 and changes["steady"] < 0.05 * changes["undeformed"]


def mean_radius(u):
    """Mean deformed distance of the outer nodes from the origin."""
    num = u.function_space.dofmap.index_map.size_local
    X = u.function_space.tabulate_dof_coordinates()[:num, :2]
    outer = np.hypot(*X.T) > OUTER * (1 - 1e-6)
    r = np.linalg.norm(X + u.x.array[: 2 * num].reshape(-1, 2), axis=1)[outer]
    return COMM.allreduce(float(r.sum())) / COMM.allreduce(len(r))


def check_an_explicit_run_goes_on_with_the_contact_forces():
    problem = wheel_on_plane(law=di.StVenantKirchhoff)
    problem.sweep(creep=[8e-3], lateral=[2e-3], progress=False)
    problem.sweep(creep=[0.0], progress=False)  # the axle of a run in time does not move sideways
    steady = problem.contact[0].force
    run = di.ExplicitProblem.from_rolling(problem)
    # Normals of the two contacts differ by the angle between facets and plane: none; stored to the accuracy of the
    # approach, 1e-6.
    np.testing.assert_allclose(run.contact[0].force, steady, atol=1e-5 * steady[1])
    moved = run.u.x.array - problem.u.x.array
    ends = [(largest(column), smallest(column)) for column in moved.reshape(-1, 3).T]
    assert np.max(np.subtract(*np.transpose(ends))) < 1e-15  # the whole wheel, without deformation
    run.advance(0.01, progress=False)  # a fifth of the facets' length
    # Facets of a coarse wheel close and open one by one; without the friction the run would begin at zero.
    assert abs(run.contact[0].force[1] / steady[1] - 1.0) < 0.1
    assert run.contact[0].force[0] > 0.5 * steady[0] > 0.0
    # The hub, of radius 0.5, which is held 0.01 lower, turns with omega = -1.01 or so.
    axle = run.supports[0][0][:1]
    assert COMM.allreduce(len(axle)) >= 1 and np.abs(run.velocity.x.array[axle]).max(initial=0.0) < 0.53


def check_bad_starts():
    with pytest.raises(TypeError, match="RollingProblem"):
        di.ExplicitProblem.from_rolling(3.0)
    with pytest.raises(ValueError, match="turn of a body for a strain"):
        di.ExplicitProblem.from_rolling(wheel_on_plane())
    with pytest.raises(TypeError, match="velocity: given by the RollingProblem"):
        di.ExplicitProblem.from_rolling(wheel_on_plane(law=di.StVenantKirchhoff), velocity=None)
    loaded = wheel_on_plane(law=di.StVenantKirchhoff, loads=[di.BodyForce((0.0, 0.0, 0.0))])
    with pytest.raises(ValueError, match="has loads"):
        di.ExplicitProblem.from_rolling(loaded)
    domain = ring()
    V = fem.functionspace(domain, ("Lagrange", 1, (2,)))
    V0, _ = V.sub(0).collapse()
    near = fem.locate_dofs_geometrical((V.sub(0), V0), lambda x: np.hypot(x[0], x[1]) < 1.001)
    rubber = di.StVenantKirchhoff(1.0, 0.3, density=1.0, hypothesis="plane_strain")
    spin = di.Spin((0.0, 0.0), (0.0, 0.0, 1.0), 0.2)
    held = [fem.dirichletbc(fem.Function(V0), near, V.sub(0))]
    rolling = di.RollingProblem(fem.Function(V), rubber, tagged(domain), {1: spin}, bcs=held)
    with pytest.raises(ValueError, match="held in some directions only"):
        di.ExplicitProblem.from_rolling(rolling)


def flowing_steel(domain, motion=None, contact=False):
    """All displacements are prescribed: shear and stretch that grow, turn and fall along the flow, towards -x."""
    V = fem.functionspace(domain, ("Lagrange", 1, (2,)))
    whole = fem.Function(V)
    whole.interpolate(
        lambda x: [4e-3 * np.sin(x[0]) * x[1], 2e-3 * np.cos(1.3 * x[0]) * x[1] + 1e-3 * np.sin(2 * x[0])]
    )
    every = np.arange(V.dofmap.index_map.size_local + V.dofmap.index_map.num_ghosts, dtype=np.int32)
    steel = di.J2Plasticity(
        200e3, 0.3, yield_stress=300.0, hardening=5e3, density=1e-9, hypothesis="plane_strain", average=False
    )
    motions = {1: motion or di.Translation((-1.0, 0.0))}
    u = fem.Function(V)
    facets = mesh.locate_entities_boundary(domain, 1, lambda x: np.isclose(x[1], 0.0))
    bottom = mesh.meshtags(domain, 1, np.sort(facets), np.full(len(facets), 7, np.int32))
    pair = di.ContactPair(bottom, 7, di.RigidPlane((0.0, -1.0), (0.0, 1.0)), friction=0.3)
    rubbing = [di.Lagrange(pair)] if contact else []
    return di.RollingProblem(u, steel, tagged(domain), motions, contact=rubbing, bcs=[fem.dirichletbc(whole, every)])


def radial_return(strains, E=200e3, nu=0.3, yield_stress=300.0, hardening=5e3):
    """Equivalent plastic strain along a path of plane strains (n, 2, 2) from the virgin state; Simo and Hughes 3.3."""
    G, plastic, total, out = E / 2 / (1 + nu), np.zeros((3, 3)), 0.0, []
    for strain in strains:
        e = np.zeros((3, 3))
        e[:2, :2] = strain
        trial = 2 * G * (e - np.eye(3) * np.trace(e) / 3 - plastic)
        size = np.linalg.norm(trial)
        excess = size - np.sqrt(2 / 3) * (yield_stress + hardening * total)
        if excess > 0.0:
            step = excess / (2 * G + 2 / 3 * hardening)
            plastic, total = plastic + step * trial / size, total + np.sqrt(2 / 3) * step
        out.append(total)
    return np.array(out)


def check_internal_variables_flow_with_the_material():
    """The steady state of a given motion is, on each streamline, the law along the path of strains; 1e-10."""
    domain = mesh.create_rectangle(COMM, [(0.0, 0.0), (6.0, 1.0)], (24, 3), mesh.CellType.quadrilateral)
    problem = flowing_steel(domain)
    problem.solve()
    field = problem.history["plastic_strain"]
    space, num = field.function().function_space, len(field.values)
    rule, _ = basix.make_quadrature(basix.CellType.quadrilateral, field.degree)
    gradient = fem.Expression(ufl.sym(ufl.grad(problem.u)), rule)
    strain = gradient.eval(domain, np.arange(num, dtype=np.int32)).reshape(-1, 2, 2)
    x = space.tabulate_dof_coordinates()[space.dofmap.list[:num]].reshape(-1, 3)
    parts = COMM.allgather((x, strain, field.values.ravel()))
    x, strain, found = (np.concatenate(column) for column in zip(*parts))
    lines = np.round(x[:, 1], 6)
    assert len(np.unique(lines)) == 6
    for y in np.unique(lines):
        at = np.flatnonzero(lines == y)
        at = at[np.argsort(-x[at, 0])]
        expected = radial_return(strain[at])
        assert expected[-1] > 1e-3
        np.testing.assert_allclose(found[at], expected, atol=1e-10 * expected[-1])
    again = problem.history["plastic_strain"].values.copy()
    problem.solve()  # it is a steady state
    np.testing.assert_allclose(problem.history["plastic_strain"].values, again, atol=1e-12)


def check_bad_flows_of_internal_variables():
    domain = mesh.create_rectangle(COMM, [(0.0, 0.0), (6.0, 1.0)], (24, 3), mesh.CellType.quadrilateral)
    x = domain.geometry.x
    inner = (x[:, 1] > 0.1) & (x[:, 1] < 0.9) & (x[:, 0] > 0.1) & (x[:, 0] < 5.9)
    x[inner, 1] += 0.03 * np.sin(7.0 * x[inner, 0])
    with pytest.raises(ValueError, match=r"cell \d+ .*streamline of quadrature points"):
        flowing_steel(domain)
    with pytest.raises(ValueError, match=r"cell \d+ .*streamline of quadrature points"):
        flowing_steel(disc(), motion=di.Spin((0.0, 0.0), (0.0, 0.0, 1.0), 0.1))
    with pytest.raises(ValueError, match="turns is for a whole ring"):
        flowing_steel(mesh.create_unit_square(COMM, 4, 4, mesh.CellType.quadrilateral)).solve(turns=2)
    with pytest.raises(ValueError, match="comes later"):
        flowing_steel(mesh.create_unit_square(COMM, 4, 4), contact=True)
    for still in (di.Translation((0.0, 0.0)), di.Spin((0.0, 0.0), (0.0, 0.0, 1.0), 0.0)):
        with pytest.raises(ValueError, match="must move"):
            flowing_steel(ring(), motion=still)
    spin = di.Spin((0.0, 0.0), (0.0, 0.0, 1.0), 0.1)
    with pytest.raises(ValueError, match="does not know how they turn"):
        u = fem.Function(fem.functionspace(ring(), ("Lagrange", 1, (2,))))
        di.RollingProblem(
            u, Creeping(1.0, 0.3, density=1.0, hypothesis="plane_strain"), tagged(u.function_space.mesh), {1: spin}
        )


class Creeping(di.InelasticMaterial):
    """A law with a vector of which nobody knows how it turns."""

    history = {"something": (2,)}


def disc():
    """A disc from a square: lines of constant maximum norm become circles, lines of cells near the middle do not."""
    domain = mesh.create_rectangle(COMM, [(-1.0, -1.0), (1.0, 1.0)], (8, 8), mesh.CellType.quadrilateral)
    x = domain.geometry.x
    longest, length = np.max(np.abs(x), axis=1), np.linalg.norm(x, axis=1)
    x *= np.divide(longest, length, out=np.ones_like(length), where=length > 0)[:, None]
    return domain


def check_the_state_of_a_sweep_is_read_and_set():
    """Displacement and contact of a solution, after another one, are those of before."""
    problem = wheel_on_plane()
    problem.solve()
    state = SweepState(problem._equilibrium, problem._cpp_object.mark_reached)
    table = COMM.bcast(state.read(), root=0)
    assert table[0].shape == state.shape and len(table[1]) == state.num_totals
    u, force = problem.u.x.array.copy(), problem.contact[0].force
    problem.contact[0].pair.master.velocity = (-1.01, 0.0, 0.0)
    problem.solve()
    assert COMM.allreduce(float(np.abs(problem.u.x.array - u).max(initial=0.0)), MPI.MAX) > 1e-6
    state.set(*table)
    np.testing.assert_allclose(problem.u.x.array, u, atol=1e-15)
    np.testing.assert_allclose(problem.contact[0].force, force, atol=1e-14)
    again = COMM.bcast(state.read(), root=0)
    for one, other in zip(again, table, strict=True):
        np.testing.assert_allclose(one, other, atol=1e-15)


def check_contacts_of_a_rolling_problem_are_bound_to_its_flow():
    problem = wheel_on_plane()
    spec = problem.contact[0].spec
    assert isinstance(spec, RollingLagrange) and isinstance(spec, di.Lagrange)
    given = di.Lagrange(spec.pair, quadrature_degree=4)
    bound = RollingLagrange(given, spec.flow)
    assert (bound.pair, bound.quadrature_degree, bound.basis) == (given.pair, 4, given.basis)
    assert type(bound._bind(problem._equilibrium)) is type(problem.contact[0])


def check_transport_follows_the_sense_of_the_flow():
    """Streamlines are found anew where the flow turns round, and only there; what is carried is the state at points."""
    domain = mesh.create_rectangle(COMM, [(0.0, 0.0), (6.0, 1.0)], (12, 2), mesh.CellType.quadrilateral)
    motion = di.Translation((-1.0, 0.0))
    problem = flowing_steel(domain, motion)
    transport = problem._transport
    assert isinstance(transport, Transport) and not transport.closes and transport.turn_changes == []
    lines = transport._lines
    motion.velocity = (-2.0, 0.0)
    transport.update()
    assert transport._lines is lines
    motion.velocity = (2.0, 0.0)
    transport.update()
    assert transport._lines is not lines and transport._lines.count == lines.count
    motion.velocity = (-1.0, 0.0)
    problem.solve()
    found = problem.history["plastic_strain"].values
    assert COMM.allreduce(float(found.max(initial=0.0)), MPI.MAX) > 1e-3
    kept = transport.state()
    problem.history["plastic_strain"].values = 0.0 * found
    transport.restore(kept)
    np.testing.assert_allclose(problem.history["plastic_strain"].values, found, atol=1e-15)
