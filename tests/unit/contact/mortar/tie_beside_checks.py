# SPDX-License-Identifier: MIT
"""Ties beside contacts of other kinds, also at common nodes; docs/tie.md. See on_ranks.py."""

import numpy as np
import ufl
from box_bodies import Boxes
from dolfinx import fem
from mpi4py import MPI
from recorded_fields_checks import at_points, read
from shared_folder import shared_folder
from tied_boxes import SLAVE, boxes, tie

import dolfinx_impact as di

COMM = MPI.COMM_WORLD
BELOW, ABOVE, LEFT, RIGHT, UPPER, FLOOR = 3, 4, 5, 6, 7, 8
GAP = 1e-4  # [L]
ROUND_OFF = 1e-13  # sums of some hundred terms of order one over some hundred steps


def halves(dim=2, floor=True):
    """A block of two halves side by side, of cells that do not match at the joint, above a wider block."""
    cells = {2: ((3, 5), (4, 7)), 3: ((2, 2, 2), (3, 3, 3))}[dim]
    flat = (lambda x, z: (x, z)) if dim == 2 else (lambda x, z: (x, 0.0, z))
    deep = (lambda x, z: (x, z)) if dim == 2 else (lambda x, z: (x, 1.0, z))
    parts = [(flat(k, 0.0), deep(k + 1.0, 1.0), n) for k, n in enumerate(cells)]
    if floor:
        parts.append((flat(-0.3, -0.6), deep(2.3, -GAP), (7, 2) if dim == 2 else (5, 2, 2)))
    m = Boxes(parts, "quadrilateral" if dim == 2 else "hexahedron", poisson=0.3)
    up = dim - 1
    surfaces = {BELOW: [(0, up, 0.0), (1, up, 0.0)], LEFT: (0, 0, 1.0), RIGHT: (1, 0, 1.0)}
    surfaces |= {UPPER: [(0, up, 1.0), (1, up, 1.0)]}
    m.tag = m.tags(surfaces | ({ABOVE: (2, up, -GAP), FLOOR: (2, up, -0.6)} if floor else {}))
    m.tie = di.Tie(di.ContactPair(m.tag, slave=RIGHT, master=LEFT))
    m.pair = di.ContactPair(m.tag, slave=BELOW, master=ABOVE)
    return m


def falling(m):
    """Velocity of the two halves, downwards."""
    v, up = fem.Function(m.V), m.dim - 1
    v.interpolate(lambda x: np.vstack([np.zeros((up, x.shape[1])), -1.0 * (x[up] > -0.5 * GAP)]))
    return v


def momentum(m, problem):
    n = m.V.dofmap.index_map.size_local * m.dim
    products = (problem.mass.array[:n] * problem.velocity.x.array[:n]).reshape(-1, m.dim)
    return m.sum(products.sum(axis=0))


def most(m, values):
    return m.mesh.comm.allreduce(float(np.abs(values).max(initial=0.0)), MPI.MAX)


def check_kinematic_contact_at_nodes_of_a_tie():
    """The lower ends of the joint are slave nodes of the tie, or its master's, and slave nodes of the contact."""
    for dim in (2, 3) if COMM.size == 1 else (2,):
        found = []
        for contact in (di.Kinematic, di.Penalty):
            m = halves(dim)
            problem = di.ExplicitProblem(m.u, m.law, velocity=falling(m), contact=[contact(m.pair), m.tie])
            before, step = momentum(m, problem), 4e-3
            for k in range(1, 16):
                problem.advance(until=k * step, progress=False)
                jump = problem.contact[1].tie.conditions.jump(m.u.x.array[: m.V.dofmap.index_map.size_local * dim])
                assert most(m, jump) < 1e-14
            assert np.abs(momentum(m, problem) - before).max() < ROUND_OFF * np.abs(before).max(), (dim, contact)
            found.append(problem.velocity.x.array.copy())
            halved = m.V.tabulate_dof_coordinates()[:, m.dim - 1] > -0.5 * GAP
            mass = problem.mass.array.reshape(-1, dim)[:, 0]
            n = m.V.dofmap.index_map.size_local
            upper = (mass * problem.velocity.x.array.reshape(-1, dim)[:, dim - 1] * halved)[:n].sum()
            found[-1] = float(m.sum(upper)) / float(m.sum((mass * halved)[:n].sum()))
        # What the floor has taken from the block so far; springs are not rigid: no more than the penalty's compliance.
        assert -0.9 < found[0] < 0.0 and abs(found[0] - found[1]) < 0.15, (dim, found)


def check_general_contact_leaves_the_joint_alone():
    """A spinning and vibrating block of two halves: general contact of all surfaces finds none at the joint."""
    for dim in (2, 3) if COMM.size == 1 else (2,):
        ends = []
        for general in (False, True):
            m = halves(dim, floor=False)
            law = di.NeoHookean(1000.0, 0.3, density=1.0, hypothesis="plane_strain" if dim == 2 else "3d")
            v = fem.Function(m.V)
            v.interpolate(lambda x: np.vstack([-3.0 * x[1] - 2.0 * (x[0] - 1.0) ** 3, 3.0 * x[0], x[2]])[: m.dim])
            contact = [m.tie, di.GeneralContact(m.tag)] if general else [m.tie]
            problem = di.ExplicitProblem(m.u, law, velocity=v, contact=contact)
            problem.advance(until=0.1, progress=False)
            ends.append(m.u.x.array.copy())
        assert problem.contact[1].num_springs == (0, 0)
        # Springs shorten the stable step: of none they may not.
        assert most(m, ends[0] - ends[1]) < 1e-12 * most(m, ends[0])
    m = halves()
    problem = di.ExplicitProblem(
        m.u, m.law, velocity=falling(m), contact=[m.tie, di.GeneralContact(m.tag, tags=[BELOW, ABOVE])]
    )
    before, energy = momentum(m, problem), problem.energy["total"]
    problem.advance(until=0.04, progress=False)
    assert problem.contact[1].num_springs[0] > 0
    assert np.abs(momentum(m, problem) - before).max() < ROUND_OFF * np.abs(before).max()
    assert abs(problem.energy["total"] - energy) < ROUND_OFF * energy


def check_laws_of_the_interface_at_nodes_of_a_tie():
    """Static: pressed on the floor, whose springs meet the tie's nodes. Explicit: energy and momentum."""
    law = di.interface.linear_pressure(1e5)
    m = halves()
    bcs = m.hold(2, 1, -0.6, 0, 1) + m.hold(0, 0, 0.0, 0)
    load = di.Traction(m.tag, UPPER, (0.0, -2.0))
    m.u.interpolate(lambda x: np.vstack([0.0 * x[0], -1.2 * GAP * (x[1] > -0.5 * GAP)]))
    problem = di.StaticProblem(m.u, m.law, bcs=bcs, loads=[load], contact=[di.Penalty(m.pair, law=law), m.tie])
    problem.solve(progress=False)
    assert abs(problem.contact[0].force[1] - 4.0) < 1e-6 and m.imbalance(problem) < 1e-7
    m = halves()
    problem = di.ExplicitProblem(m.u, m.law, velocity=falling(m), contact=[di.Penalty(m.pair, law=law), m.tie])
    before, energy = momentum(m, problem), problem.energy["total"]
    problem.advance(until=0.04, progress=False)
    assert problem.contact[0].force[1] > 1.0
    assert np.abs(momentum(m, problem) - before).max() < ROUND_OFF * np.abs(before).max()
    # A law's energy is that of its nodes at the ends of the steps, the tie adds none: as without a tie.
    assert abs(problem.energy["total"] - energy) < 1e-3 * energy


def check_fields_of_ties():
    """Functions and recorded fields are the results at the nodes; the pressure's integral is the force."""
    m = boxes("quadrilateral")
    top = di.Traction(m.tag, 5, (0.0, 1.0))
    static = di.StaticProblem(m.u, m.law, bcs=m.hold(0, 1, 0.0, 0, 1), loads=[top], contact=[tie(m)])
    with shared_folder() as path:
        recorder = static.record(path / "static", ["pressure", "traction", "gap", "status"], ending=".xdmf")
        static.solve(progress=False)
        recorder.close()
        c = static.contact[0]
        pressure = c.function("pressure")
        np.testing.assert_array_equal(pressure.x.array[c.nodes], c.pressure)
        ds = ufl.Measure("ds", domain=m.mesh, subdomain_data=m.tag)(SLAVE)
        total = COMM.allreduce(fem.assemble_scalar(fem.form(c.function("traction")[1] * ds)), MPI.SUM)
        assert abs(total + 1.0) < 1e-9 and pressure.x.array.min(initial=0.0) <= 0.0  # negative: the tie pulls
        points, found = read(path / "static", "contact")
        slave = found["status"] == 1
        assert np.count_nonzero(slave) == 4 and found["pressure"][slave].max() < 0.0
        np.testing.assert_array_equal(found["pressure"][slave], at_points(c, c.pressure, points)[slave])
        m = boxes("quadrilateral")
        v = fem.Function(m.V)
        v.interpolate(lambda x: np.vstack([0.0 * x[0], 0.1 * np.cos(np.pi * x[1] / 2.0)]))
        problem = di.ExplicitProblem(m.u, m.law, velocity=v, contact=[tie(m)])
        recorder = problem.record(path / "run", ["pressure", "traction"], every=2, ending=".xdmf")
        problem.advance(until=4 * problem.stable_step(), progress=False)
        recorder.close()
        c = problem.contact[0]
        c.refresh()
        points, found = read(path / "run", "contact")
        at = at_points(c, c.traction[:, 1], points)
        there = np.isfinite(at)
        if problem.step % 2 == 0:
            np.testing.assert_array_equal(found["traction_y"][there], at[there])
        np.testing.assert_array_equal(c.function("traction").x.array.reshape(-1, 2)[c.nodes], c.traction)
        assert np.abs(found["traction_y"]).max() > 1e-3
