# SPDX-License-Identifier: MIT
"""Rigid bodies moved by contact, in explicit problems. See on_ranks.py."""

import numpy as np
from dolfinx import fem, mesh
from mpi4py import MPI
from shared_folder import shared_folder

import dolfinx_impact as di
from dolfinx_impact import interface

COMM = MPI.COMM_WORLD


def block(comm, dim, cells=None):
    """Unit square or cube; space and facet tags: 1 above, 2 below."""
    n = cells or (8 if dim == 2 else 4)
    if dim == 2:
        domain = mesh.create_unit_square(comm, n, n, mesh.CellType.quadrilateral)
    else:
        domain = mesh.create_unit_cube(comm, n, n, n, mesh.CellType.hexahedron)
    places = [mesh.locate_entities_boundary(domain, dim - 1, lambda x, h=h: np.isclose(x[dim - 1], h)) for h in (1, 0)]
    facets, tags = np.concatenate(places), np.repeat(np.arange(1, 3, dtype=np.int32), [len(p) for p in places])
    order = np.argsort(facets)
    V = fem.functionspace(domain, ("Lagrange", 1, (dim,)))
    return V, mesh.meshtags(domain, dim - 1, facets[order], tags[order])


def ball(dim, mass=0.5, gap=0.001, radius=0.7, **given):
    """A ball, in the plane a disc, above the block; it falls obliquely with spin."""
    center = np.array([0.45, 0.55, 1.0 + radius + gap][3 - dim :] if dim == 3 else [0.45, 1.0 + radius + gap])
    shape = (di.RigidSphere if dim == 3 else di.RigidCylinder)(center, radius)
    given = {"velocity": [0.3] + [0.0] * (dim - 2) + [-0.5], "spin": (0.2, 0.4, -1.0) if dim == 3 else -1.0} | given
    return di.RigidBody(shape, mass=mass, inertia=0.4 * mass * radius**2, **given)


def thrown(comm, dim, body, friction=0.3, law=di.NeoHookean, bcs=False, cells=None, **options):
    """The problem of a body that falls on a block, which is free or stands on its lower face."""
    V, tags = block(comm, dim, cells)
    material = law(100.0, 0.3, 1.0, "plane_strain" if dim == 2 else "3d")
    pair = di.ContactPair(tags, 1, body, friction=friction)
    facets = tags.find(2)
    held = [fem.dirichletbc(np.zeros(dim), fem.locate_dofs_topological(V, dim - 1, facets), V)] if bcs else []
    return di.ExplicitProblem(fem.Function(V), material, bcs=held, contact=[di.Penalty(pair, **options)])


def momenta(problem, body):
    """Momentum, and angular momentum about the origin, of block and body together."""
    dim = problem.u.function_space.mesh.geometry.dim
    owned = problem.num_owned
    m = problem.mass.array[:owned].reshape(-1, dim)
    x = problem.space.tabulate_dof_coordinates()[: owned // dim].copy()
    x[:, :dim] += problem.u.x.array[:owned].reshape(-1, dim)
    p = np.zeros_like(x)
    p[:, :dim] = m * problem.velocity.x.array[:owned].reshape(-1, dim)
    here = np.concatenate([p.sum(axis=0), np.cross(x, p).sum(axis=0)])
    there = problem.u.function_space.mesh.comm.allreduce(here, MPI.SUM)
    return there + np.concatenate([body.momentum, np.cross(body.position, body.momentum) + body.angular_momentum])


def check_a_free_block_and_a_ball():
    """Momentum and angular momentum are those of the start to round-off, the energy nearly; ranks have one ball."""
    for dim in (2, 3):
        body = ball(dim)
        problem = thrown(COMM, dim, body)
        before = momenta(problem, body)
        start = problem.energy["kinetic"]
        problem.advance(0.3, progress=False)
        assert np.abs(problem.force_history[0][:, -1]).max() > 0.1, dim
        assert problem.energy["friction"] > 0.0 and body.velocity[dim - 1] > -0.4, dim
        # Sums of some hundred steps and nodes.
        np.testing.assert_allclose(momenta(problem, body), before, rtol=0, atol=1e-12 * np.abs(before).max())
        assert abs(problem.energy["drift"]) < 2e-3, (dim, problem.energy)  # of central differences, as with obstacles
        assert start == problem.energy_history[0, 1]
        state = np.concatenate([body.position, body.rotation.ravel(), body.velocity, body.spin, body.force])
        for other in COMM.allgather(state):
            np.testing.assert_array_equal(other, state)
        one = ball(dim)
        alone = thrown(MPI.COMM_SELF, dim, one)
        alone.advance(0.3, progress=False)
        np.testing.assert_allclose(body.position, one.position, rtol=1e-10)
        np.testing.assert_allclose(body.spin, one.spin, rtol=1e-8)


def check_a_driven_body_is_an_obstacle():
    """Fixed components with a velocity: the same forces and work as with an obstacle that moves as a function of
    time."""
    for dim in (2, 3):
        down = np.append(np.zeros(3 - 1), 0.0)
        down[dim - 1] = -0.05
        body = ball(dim, velocity=down[:dim], spin=np.zeros(3), fixed=("x", "y", "z", "rx", "ry", "rz"))
        one = thrown(COMM, dim, body, bcs=True)
        dt = 0.8 * one.stable_step()
        one.advance(60 * dt, dt=dt, progress=False)
        V, tags = block(COMM, dim)
        shape = body.surface
        shape.motion = lambda t: down * t  # noqa: B023
        held = fem.dirichletbc(np.zeros(dim), fem.locate_dofs_topological(V, dim - 1, tags.find(2)), V)
        law = di.NeoHookean(100.0, 0.3, 1.0, "plane_strain" if dim == 2 else "3d")
        contact = di.Penalty(di.ContactPair(tags, 1, shape, friction=0.3))
        other = di.ExplicitProblem(fem.Function(V), law, bcs=[held], contact=[contact])
        other.advance(60 * dt, dt=dt, progress=False)
        force = other.force_history[0]
        assert np.abs(force).max() > 0.0
        np.testing.assert_allclose(one.force_history[0], force, rtol=0, atol=1e-10 * np.abs(force).max())
        moving = 0.5 * 0.5 * 0.05**2  # constant kinetic energy of the body
        np.testing.assert_allclose(one.energy["kinetic"] - moving, other.energy["kinetic"], rtol=1e-8)
        np.testing.assert_allclose(one.energy["external"], other.energy["external"], rtol=1e-8)


def groove():
    """A block with a groove between walls of 45 degrees: space, tags of the walls (1: left, 2: right), support."""
    n = 8
    domain = mesh.create_rectangle(COMM, [[-1.0, 0.0], [1.0, 1.0]], [2 * n, n], mesh.CellType.quadrilateral)
    x = domain.geometry.x
    x[:, 1] += x[:, 1] * np.abs(x[:, 0])  # the top is 1 + |x|
    V = fem.functionspace(domain, ("Lagrange", 1, (2,)))
    sides = [
        mesh.locate_entities_boundary(
            domain, 1, lambda p, s=s: np.isclose(p[1], 1.0 + np.abs(p[0])) & (s * p[0] >= -1e-12)
        )
        for s in (-1, 1)
    ]
    facets, tags = np.concatenate(sides), np.repeat(np.arange(1, 3, dtype=np.int32), [len(s) for s in sides])
    order = np.argsort(facets)
    tagged = mesh.meshtags(domain, 1, facets[order], tags[order])
    bottom = mesh.locate_entities_boundary(domain, 1, lambda p: np.isclose(p[1], 0.0))
    held = fem.dirichletbc(np.zeros(2), fem.locate_dofs_topological(V, 1, bottom), V)
    return V, tagged, held


def check_a_disc_in_a_groove():
    """Two contacts of one body: a disc falls into a groove with walls of 45 degrees, without friction."""
    V, tagged, held = groove()
    radius, mass, weight = 0.6, 1.5, 3.0
    center = (0.0, 1.0 + np.sqrt(2.0) * radius + 1e-4)
    body = di.RigidBody(
        di.RigidCylinder(center, radius), mass=mass, inertia=0.5 * mass * radius**2, force=(0.0, -weight)
    )
    law = di.LinearElastic(500.0, 0.2, 1.0, "plane_strain")
    pairs = [di.ContactPair(tagged, k, body) for k in (1, 2)]
    problem = di.ExplicitProblem(fem.Function(V), law, bcs=[held], contact=[di.Penalty(p) for p in pairs])
    problem.advance(0.3, progress=False)
    left, right = problem.force_history
    assert np.abs(left[:, 1]).max() > 0.5 * weight
    # Both walls bear alike, along their normals, nearly: nodes lie up to half a facet, 0.09 of 0.6, beside the foot of
    # the disc's radius. Nothing moves the disc to the side or turns it.
    np.testing.assert_allclose(left[:, 1], right[:, 1], rtol=0, atol=1e-8 * np.abs(left).max())
    np.testing.assert_allclose(left[:, 0], left[:, 1], rtol=0, atol=0.3 * np.abs(left).max())
    np.testing.assert_allclose(left[:, 0], -right[:, 0], rtol=0, atol=1e-8 * np.abs(left).max())
    assert abs(body.position[0]) < 1e-10 and abs(body.spin[2]) < 1e-8
    # Momentum: the impulse of walls and weight. The first step is half a step for the velocity.
    up = -(left + right)[:, 1] - weight
    time = problem.energy_history[:, 0]
    impulse = np.sum(0.5 * (up[1:] + up[:-1]) * np.diff(time))
    impulse += 0.5 * (up[-1] + body.force[1] - weight) * (problem.time - time[-1])
    np.testing.assert_allclose(mass * body.velocity[1], impulse, rtol=1e-9)


def check_a_checkpoint_of_all_ranks():
    """Written by all ranks, read by each alone and by all: the body is where it was, and goes on."""

    def make(comm):
        body = ball(2)
        return thrown(comm, 2, body), body

    whole, body = make(COMM)
    dt = 0.5 * whole.stable_step()
    whole.advance(30 * dt, dt=dt, progress=False)
    with shared_folder() as path:
        whole.save(path / "half.h5")
        COMM.barrier()
        whole.advance(60 * dt, dt=dt, progress=False)
        for comm in (COMM, MPI.COMM_SELF):
            again, other = make(comm)
            again.restore(path / "half.h5")
            again.advance(60 * dt, dt=dt, progress=False)
            # Sums of other ranks in another order, over thirty steps.
            np.testing.assert_allclose(other.position, body.position, rtol=1e-11)
            np.testing.assert_allclose(other.rotation, body.rotation, rtol=0, atol=1e-11)
            np.testing.assert_allclose(other.velocity, body.velocity, rtol=0, atol=1e-10)
            np.testing.assert_allclose(again.energy["kinetic"], whole.energy["kinetic"], rtol=1e-10)
            np.testing.assert_allclose(again.energy["external"], whole.energy["external"], rtol=0, atol=1e-12)


def check_a_light_body():
    """A body lighter than the cells that it meets: the step bears the springs, which give way with it."""
    body = ball(2, mass=0.002, velocity=(0.05, -0.5))
    problem = thrown(COMM, 2, body, bcs=True)
    problem.advance(0.1, progress=False)
    assert body.velocity[1] > 0.3, "it has bounced"
    assert abs(problem.energy["drift"]) < 0.02, problem.energy


def pressed(comm, dim, method, body, friction=0.0):
    """The static problem of a body on a block that stands on its lower face."""
    V, tags = block(comm, dim)
    law = di.LinearElastic(100.0, 0.3, 1.0, "plane_strain" if dim == 2 else "3d")
    held = fem.dirichletbc(np.zeros(dim), fem.locate_dofs_topological(V, dim - 1, tags.find(2)), V)
    return di.StaticProblem(
        fem.Function(V), law, bcs=[held], contact=[method(di.ContactPair(tags, 1, body, friction=friction))]
    )


def round_body(dim, gap=0.0, **given):
    """A ball, in the plane a disc, above the block."""
    center = [0.45] + [0.55] * (dim - 2) + [1.7 + gap]
    shape = (di.RigidSphere if dim == 3 else di.RigidCylinder)(center, 0.7)
    return di.RigidBody(shape, fixed=("x", "y")[: dim - 1], **given)


def check_a_body_under_a_force():
    """Force control finds what displacement control has: the same place, the same force; in two load steps, too."""
    for dim, method, gap in ((2, di.Lagrange, 0.03), (2, di.Penalty, 0.0), (3, di.Lagrange, 0.0)):
        force = np.append(np.zeros(dim - 1), -4.0)
        body = round_body(dim, gap, force=force)
        problem = pressed(COMM, dim, method, body)
        problem.solve()
        up = dim - 1
        # RigidEquilibrium::tolerance, twice: its norm is relative to the largest force.
        np.testing.assert_allclose(body.force[up], 4.0, rtol=2e-8)
        np.testing.assert_allclose(problem.contact[0].force[up], -4.0, rtol=2e-8)
        shape = round_body(dim, gap).surface
        shape.displacement = body.position - body.centre
        other = pressed(COMM, dim, method, shape)
        other.solve()
        np.testing.assert_allclose(other.contact[0].force[up], -4.0, rtol=1e-6)
        if dim == 3:
            continue
        body.external_force = 2.0 * force
        report = problem.solve(steps=2)
        np.testing.assert_allclose(body.force[up], 8.0, rtol=2e-8)
        assert len(report.fractions) == 2 and report.cut_backs == 0
        body.external_force = 0.5 * force  # unloading
        problem.solve()
        np.testing.assert_allclose(body.force[up], 2.0, rtol=2e-8)


def check_a_body_pulled_along_by_friction():
    """Two free components: pressed down, then pulled to the side by less than friction bears."""
    body = di.RigidBody(round_body(2).surface, force=(0.0, -4.0))
    problem = pressed(COMM, 2, di.Penalty, body, friction=0.5)
    body.external_force = (0.4, -4.0)
    problem.solve(steps=2)
    np.testing.assert_allclose(body.force, (-0.4, 4.0, 0.0), rtol=0, atol=1e-7)
    assert body.position[0] > 0.45


def check_nothing_bears_a_body():
    """A force that pulls the body away: a sentence on all ranks, and the body is where it was."""
    lifted = round_body(2, 0.01, force=(0.0, 4.0))
    try:
        pressed(COMM, 2, di.Lagrange, lifted).solve(cut_backs=0)
    except RuntimeError as e:
        assert "finds nothing that bears it" in str(e), e
    else:
        raise AssertionError("a force that pulls the body away has found its equilibrium")
    assert np.array_equal(lifted.position, lifted.centre), "it is back where it was"


def check_a_law_of_the_interface():
    """A law in the place of the penalty, with friction: momentum and angular momentum stay, too."""
    body = ball(2)
    V, tags = block(COMM, 2)
    law = interface.linear_pressure(300.0, friction=0.3)
    contact = di.Penalty(di.ContactPair(tags, 1, body), law=law)
    problem = di.ExplicitProblem(fem.Function(V), di.NeoHookean(100.0, 0.3, 1.0, "plane_strain"), contact=[contact])
    before = momenta(problem, body)
    problem.advance(0.3, progress=False)
    assert np.abs(problem.force_history[0][:, 1]).max() > 0.1 and problem.energy["friction"] > 0.0
    np.testing.assert_allclose(momenta(problem, body), before, rtol=0, atol=1e-12 * np.abs(before).max())
    assert abs(problem.energy["drift"]) < 5e-3, problem.energy
