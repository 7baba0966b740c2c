# SPDX-License-Identifier: MIT
"""Contact that finds itself, on the ranks of COMM_WORLD: what one rank gives, others give to round-off."""

import tempfile
from pathlib import Path

import numpy as np
from dolfinx import fem, mesh
from flying_bodies import Flying, box, rotation
from mpi4py import MPI

import dolfinx_impact as di

COMM = MPI.COMM_WORLD


def stack(comm=COMM):
    """Turned blocks that fall on each other: nodes on facets and crossed edges.

    Each is a little aside of the last one: where a node meets an edge between two facets, round-off would decide.
    """
    bodies = []
    for k in range(4):
        low = np.array([0.07 * (-1) ** k, 0.03 * k, 1.02 * k])
        turn = rotation((0, 0, 1), 0.3 * k)
        bodies.append(((2, 2, 2), box(low, low + 1.0, turn), (0.1 * k, 0.0, -0.3 * k)))
    return Flying(bodies, "tetrahedron", comm=comm)


def plate(comm=COMM):
    """A plate one cell thick, hit from both sides."""
    return Flying(
        [
            ((20, 1), box((-1.0, -0.03), (1.0, 0.03)), (0.0, 0.0)),
            ((4, 4), box((-0.2, 0.04), (0.2, 0.44)), (0.2, -1.0)),
            ((4, 4), box((-0.15, -0.44), (0.25, -0.04)), (0.0, 1.0)),
        ],
        "quadrilateral",
        comm=comm,
    )


def notch(comm=COMM, cell="triangle", speed=1.0):
    """A block that falls with an edge into the notch between two others; mirrored about the plane x = 0.

    In the plane the two are a little apart: where their corners had the same place, round-off would decide whether they
    touch.
    """
    dim = 2 if cell in ("triangle", "quadrilateral") else 3
    half = np.sqrt(0.5)

    def turned(low, high, lift=0.0, aside=0.0):
        def place(p):
            q = low + p * (np.asarray(high) - low)
            x = q.copy()
            x[:, 0], x[:, -1] = half * (q[:, 0] - q[:, -1]) + aside, half * (q[:, 0] + q[:, -1]) + lift
            return x

        return place

    def mirrored(place):
        # Both axes of the grid change their places, so that cells keep their orientation.
        return lambda p: place(p[:, ::-1] if dim == 2 else p[:, [2, 1, 0]]) * ([-1.0] + [1.0] * (dim - 1))

    wide = [0.0], [1.0], [0.8]
    low, high, deep = (np.array([0.0, *(w if dim == 3 else []), 0.0]) for w in wide)
    low[-1], high[0], high[-1] = -1.0, 1.0, 0.0
    deep[0] = deep[-1] = 0.7
    if dim == 3:
        low[1], high[1] = 0.0, 1.0
    right = turned(low, high, aside=0.002 if dim == 2 else 0.0)
    start = np.array([0.0, *([0.1] if dim == 3 else []), 0.0])
    block = turned(start, start + deep, 0.005)
    counts = (4, 4) if dim == 2 else (3, 2, 3)
    still, fall = np.zeros(dim), np.array([0.0] * (dim - 1) + [-speed])
    return Flying([(counts, right, still), (counts, mirrored(right), still), (counts, block, fall)], cell, comm=comm)


def _same(make, until):
    """A run on all ranks and the same one on each rank alone: centres, momenta, energies."""
    results = []
    for comm in (COMM, MPI.COMM_SELF):
        bodies = make(comm)
        problem = bodies.problem(friction=0.3)
        problem.advance(until=until, progress=False)
        centres = [bodies.centre(problem, b) for b in range(int(comm.allreduce(bodies.body.max(), MPI.MAX)) + 1)]
        energies = [problem.energy[name] for name in ("kinetic", "internal", "contact", "friction", "impact")]
        results.append(np.concatenate([*centres, energies]))
        assert problem.energy["friction"] > 1e-5  # they have touched
    # Sums in another order, and what a hundred steps make of it.
    np.testing.assert_allclose(results[0], results[1], rtol=0.0, atol=1e-11 * np.abs(results[1]).max())


def check_blocks_and_edges_on_ranks():
    _same(stack, 0.3)


def check_both_sides_of_a_plate_on_ranks():
    _same(plate, 0.15)


def check_several_springs_of_a_node_on_ranks():
    _same(notch, 0.1)


def coaxial(comm=COMM, cell="quadrilateral"):
    """A cylinder that falls on a wider one, both with their axis in the mesh."""
    law = di.NeoHookean(1000.0, 0.3, density=1.0, hypothesis="axisymmetric")
    lower, upper = box((0.0, 0.0), (1.0, 1.0)), box((0.0, 1.01), (0.8, 1.81))
    return Flying([((6, 6), lower, (0.0, 0.0)), ((5, 5), upper, (0.0, -1.0))], cell, law, comm)


def on_the_axis(bodies):
    V, m = bodies.V, bodies.mesh
    facets = mesh.locate_entities_boundary(m, 1, lambda x: np.abs(x[0]) < 1e-9)
    return fem.dirichletbc(0.0, fem.locate_dofs_topological(V.sub(0), 1, facets), V.sub(0))


def check_bodies_of_revolution():
    """Axial momentum and energies stay; nodes on the axis bear as their neighbours do."""
    bodies = coaxial()
    problem = bodies.problem(0.2, bcs=[on_the_axis(bodies)])
    before = bodies.momentum(problem)[1]
    problem.advance(until=0.04, dt=0.5 * problem.stable_step(), progress=False)
    contact = problem.contact[0]
    lower_face = (bodies.body[contact.nodes] == 1) & (bodies.X[contact.nodes, 1] < 1.02)
    inner = lower_face & (bodies.X[contact.nodes, 0] < 0.5)
    gaps = np.concatenate(COMM.allgather(contact.gap[inner]))
    assert len(gaps) == 4 and np.all(gaps < -0.005) and np.ptp(gaps) < 0.05 * np.abs(gaps).max()
    problem.advance(until=0.12, dt=0.5 * problem.stable_step(), progress=False)
    assert abs(bodies.momentum(problem)[1] - before) < 1e-13
    assert abs(problem.energy["drift"]) < 1e-4  # steps change once
    assert bodies.mean_velocity(problem, 1)[1] > 0.1  # they part


def check_momentum_on_ranks():
    bodies = stack()
    problem = bodies.problem(friction=0.3)
    before = bodies.momentum(problem), bodies.angular_momentum(problem)
    problem.advance(until=0.3, progress=False)
    after = bodies.momentum(problem), bodies.angular_momentum(problem)
    for a, b in zip(before, after):
        np.testing.assert_allclose(a, b, rtol=0.0, atol=1e-13 * np.abs(before[1]).max())


def check_restart_in_contact():
    """Saved while springs of nodes and edges are closed."""
    assert min(_restart(stack, 0.25, 0.4).num_springs) > 0


def check_restart_with_several_springs_of_a_node():
    contact = _restart(notch, 0.05, 0.1)
    assert contact.num_springs[0] > COMM.allreduce(int(np.sum(contact.status > 0)), MPI.SUM)


def _restart(make, middle, end):
    """A run that is saved, and one that goes on from the file.

    Returns:
        The contact at the time of the file.
    """
    with tempfile.TemporaryDirectory() as folder:
        path = COMM.bcast(str(Path(folder) / "state.h5"), 0)
        problem = make().problem(friction=0.3)
        problem.advance(until=middle, progress=False)
        contact = problem.contact[0]
        problem.save(path)
        kept = {name: getattr(contact, name).copy() for name in ("traction", "pressure", "status", "slip", "points")}
        problem.advance(until=end, progress=False)
        other = make().problem(friction=0.3)
        other.restore(path)
        begun = make().problem(friction=0.3)
        begun.restore(path)
        for name, values in kept.items():
            np.testing.assert_array_equal(getattr(other.contact[0], name), values, err_msg=name)
        other.advance(until=end, progress=False)
        np.testing.assert_array_equal(other.u.x.array, problem.u.x.array)
        assert other.energy == problem.energy
        COMM.barrier()
        return begun.contact[0]


def check_force_on_tags():
    """Forces on the two bodies are opposite, and are the rates of their momenta."""
    bodies = Flying(
        [((3, 3), box((0.0, 0.0), (1.0, 1.0)), (0.0, 0.0)), ((2, 2), box((0.2, 1.001), (1.2, 2.001)), (0.0, -1.0))],
        "triangle",
    )
    problem = bodies.problem()
    problem.advance(until=0.03, progress=False)
    contact = problem.contact[0]
    first, second = contact.force_on(1), contact.force_on(2)
    np.testing.assert_allclose(first, -second, rtol=0.0, atol=1e-12 * np.abs(first).max())
    assert first[1] < 0.0
    np.testing.assert_allclose(contact.force, 0.0, atol=1e-12 * np.abs(first).max())
    before = bodies.momentum(problem, 1), problem.time
    problem.advance(until=problem.time + problem.stable_step() * 0.5, progress=False)
    rate = (bodies.momentum(problem, 1) - before[0]) / (problem.time - before[1])
    # Nothing else acts on the body; the force changes within the half step by some of the spring's forces.
    np.testing.assert_allclose(rate, second, rtol=0.3, atol=0.05 * np.abs(second).max())


def check_refusals_on_all_ranks():
    bodies = plate()
    for given, error, text in (
        (dict(tags=[]), ValueError, "tags is empty"),
        (dict(tags=[1, 1]), ValueError, "twice"),
        (dict(tags="all"), TypeError, "a tag must be an integer"),
        (dict(friction=-0.1), ValueError, "friction is -0.1"),
    ):
        try:
            di.GeneralContact(bodies.tags, **given)
        except error as e:
            assert text in str(e), e
        else:
            raise AssertionError(f"{given} was not refused")
    try:
        bodies.problem(contact=[di.GeneralContact(bodies.tags, tags=9)])
    except ValueError as e:
        assert "no facet carries the tag 9" in str(e)
    else:
        raise AssertionError("a tag without facets was not refused")


def check_beside_rigid_bodies_ties_and_laws():
    """One problem with all of them: two blocks that are tied, one that is thrown at their side and that nobody names, a
    rigid ball and a law of the interface."""
    still = (0.0, 0.0)
    bodies = Flying(
        [
            ((4, 4), box((0.0, 0.0), (1.0, 1.0)), still),  # 1, tied below 2
            ((3, 3), box((0.0, 1.0), (1.0, 2.0)), still),
            ((4, 4), box((1.01, 0.3), (2.01, 1.3)), (-1.0, 0.0)),  # 3, finds 1 and 2
            ((3, 3), box((0.1, -1.005), (0.9, -0.005)), (0.0, 0.8)),  # 4, against the underside of 1 by a law
        ],
        "quadrilateral",
    )
    places = {11: (1, 1, 1.0), 12: (2, 1, 1.0), 13: (2, 1, 2.0), 14: (1, 1, 0.0), 15: (4, 1, -0.005)}
    middle = mesh.compute_midpoints(bodies.mesh, 1, bodies.tags.indices)
    values = bodies.tags.values.copy()
    for tag, (body, axis, place) in places.items():
        values[(bodies.tags.values == body) & (np.abs(middle[:, axis] - place) < 1e-9)] = tag
    tags = mesh.meshtags(bodies.mesh, 1, bodies.tags.indices, values)
    ball = di.RigidBody(
        di.RigidCylinder((0.5, 2.505), 0.5), mass=0.5, inertia=0.06, centre=(0.5, 2.505), velocity=(0.0, -0.7)
    )
    law = di.interface.linear_pressure(2e3)
    problem = bodies.problem(
        contact=[
            di.Tie(di.ContactPair(tags, 12, 11)),
            di.Penalty(di.ContactPair(tags, 13, ball)),
            di.Penalty(di.ContactPair(tags, 15, 14), law=law),
            di.GeneralContact(tags, friction=0.2),
        ]
    )
    tie, named, by_law, general = problem.contact
    before = bodies.momentum(problem) + 0.5 * np.array([0.0, -0.7])
    most = np.zeros(3)

    def look(_):
        general_force = np.abs(general.traction).max(initial=0.0)
        most[:] = np.maximum(most, [np.abs(named.force).max(), np.abs(by_law.force).max(), general_force])

    problem.advance(until=0.12, dt=0.5 * problem.stable_step(), callback=look, progress=False)
    COMM.Allreduce(MPI.IN_PLACE, most, MPI.MAX)
    assert np.all(most > 1.0), most
    assert COMM.allreduce(np.abs(tie.traction).max(initial=0.0), MPI.MAX) > 0.1
    after = bodies.momentum(problem) + 0.5 * np.array(ball.velocity)[:2]
    np.testing.assert_allclose(after, before, rtol=0.0, atol=1e-12)
    assert bodies.mean_velocity(problem, 2)[0] > -0.9 and ball.velocity[1] > -0.6
    # Springs without a law are exact; the law's moment corrections and last half steps are not.
    assert abs(problem.energy["drift"]) < 1e-3
    # The tied surfaces, and those of the other pairs, are left out.
    inner = np.abs(general.points[:, 1] - 1.0) < 0.02
    inside = inner & (general.points[:, 0] > 0.2) & (general.points[:, 0] < 0.8)
    assert not np.any(general.traction[inside])
