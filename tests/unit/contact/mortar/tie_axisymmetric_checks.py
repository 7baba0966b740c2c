# SPDX-License-Identifier: MIT
"""Ties of axisymmetric bodies; docs/tie.md. See on_ranks.py: cells are scattered over the ranks."""

import itertools

import numpy as np
from box_bodies import Boxes
from dolfinx import fem
from mpi4py import MPI
from tied_boxes import MASTER, SLAVE, largest_error, prescribe, tie

import dolfinx_impact as di

COMM = MPI.COMM_WORLD
INNER, OUTER = 7, 8
# Uniform states are in the spaces of displacements and tractions: what is left is round-off of a direct solution.
PATCH = 1e-12


def rings(cell, joint, degree=1, inner=1.0, fine=3):
    """Two rings of rectangular section, one on the other ("plate") or one around the other ("sleeve")."""
    middle = inner + 0.5
    parts = {
        "plate": [((inner, 0.0), (inner + 1.0, 1.0), (2, 2)), ((inner, 1.0), (inner + 1.0, 2.0), (fine, 2))],
        "sleeve": [((inner, 0.0), (middle, 1.0), (2, 2)), ((middle, 0.0), (inner + 1.0, 1.0), (2, fine))],
    }[joint]
    m = Boxes(parts, cell, degree)
    axis, at = (1, 1.0) if joint == "plate" else (0, middle)
    sides = {INNER: (0, 0, inner), OUTER: (1, 0, inner + 1.0)}
    m.tag = m.tags({SLAVE: (1, axis, at), MASTER: (0, axis, at), **(sides if joint == "sleeve" else {})})
    m.law = di.LinearElastic(1000.0, 0.3, density=1.0, hypothesis="axisymmetric")
    return m


def check_uniform_states_pass():
    """Patch test u = (a r, b z), where all stresses are uniform; the outer boundary moves so."""
    rows = list(itertools.product(("triangle", "quadrilateral"), ("plate", "sleeve"), (1, 2), (1.0, 0.0)))
    for cell, joint, degree, inner in rows if COMM.size == 1 else rows[2:12:9]:
        m = rings(cell, joint, degree, inner)

        def field(x):
            return np.vstack([2e-3 * x[0], -1e-3 * x[1]])

        problem = di.StaticProblem(m.u, m.law, bcs=prescribe(m, field), contact=[tie(m)])
        problem.solve(progress=False)
        assert largest_error(m, field) < PATCH, (cell, joint, degree, inner)


def lame(m, contact):
    """Error of the displacement of a thick cylinder of two rings under a pressure inside, over the largest one."""
    a, b, p, E, nu = 1.0, 2.0, 1.0, 1000.0, 0.3
    bcs = [bc for body in range(1 + bool(contact)) for at in (0.0, 1.0) for bc in m.hold(body, 1, at, 1)]
    problem = di.StaticProblem(m.u, m.law, bcs=bcs, loads=[di.Traction(m.tag, INNER, (p, 0.0))], contact=contact)
    problem.solve(progress=False)
    r = m.V.tabulate_dof_coordinates()[:, 0]

    def exact(r):
        return (1 + nu) / E * p * a**2 / (b**2 - a**2) * ((1 - 2 * nu) * r + b**2 / r)

    off = np.abs(m.u.x.array.reshape(-1, 2)[:, 0] - exact(r)).max(initial=0.0)
    return problem, COMM.allreduce(float(off), MPI.MAX) / exact(a)


def check_a_shrunk_ring_is_one_cylinder():
    """Lame's thick cylinder of two rings: displacement and radial stress at the joint."""
    one = Boxes([((1.0, 0.0), (2.0, 1.0), (4, 2))], "quadrilateral", 2)
    one.tag, one.law = one.tags({INNER: (0, 0, 1.0)}), rings("quadrilateral", "sleeve").law
    _, error = lame(one, [])
    for fine in (3, 6):
        m = rings("quadrilateral", "sleeve", degree=2, fine=fine)
        problem, tied = lame(m, [tie(m)])
        # The displacement depends on the radius alone, and has no jump then: the error is that of one mesh.
        assert abs(tied - error) < 1e-6 * error < 1e-10
        c = problem.contact[0]
        # sigma_r = p a^2/(b^2 - a^2) (1 - b^2/r^2) is -p there; within the error of four cells of degree 2.
        pressure = (4.0 / 1.5**2 - 1.0) / 3.0
        assert COMM.allreduce(float(np.abs(c.pressure - pressure).max(initial=0.0)), MPI.MAX) < 1e-4 * pressure
        assert abs(c.area - 2.0 * np.pi * 1.5) < 1e-12


def vibrating(problem_of, joint):
    m = rings("quadrilateral", joint)
    v = fem.Function(m.V)
    v.interpolate(lambda x: np.vstack([0.01 * np.sin(2.0 * x[0]), 0.02 + 0.01 * np.cos(1.5 * x[1])]))
    return m, problem_of(m.u, m.law, velocity=v, contact=[tie(m)])


def check_energy_and_momentum_in_time():
    """Free rings vibrate: energy, and the momentum along the axis; conditions hold in both."""
    for joint in ("plate", "sleeve") if COMM.size == 1 else ("sleeve",):
        m, problem = vibrating(di.ExplicitProblem, joint)
        owned = m.V.dofmap.index_map.size_local * 2
        mass = problem.mass.array[:owned].reshape(-1, 2)

        def momentum():
            return float(m.sum((mass * problem.velocity.x.array[:owned].reshape(-1, 2))[:, 1].sum()))

        before, energy = momentum(), problem.energy["total"]
        problem.advance(until=200 * problem.stable_step(), progress=False)
        # Sums of some hundred terms of order one over two hundred steps.
        assert abs(momentum() - before) < 1e-13 * abs(before)
        assert abs(problem.energy["total"] - energy) < 1e-13 * energy
        jump = problem.contact[0].tie.conditions.jump(m.u.x.array[:owned])
        assert COMM.allreduce(float(np.abs(jump).max(initial=0.0)), MPI.MAX) < 1e-14
        m, problem = vibrating(di.NewmarkProblem, joint)
        energy = problem.energy["total"]
        problem.advance(until=0.2, dt=0.01, progress=False)
        assert abs(problem.energy["total"] - energy) < 1e-11 * energy
        assert np.linalg.norm(problem.contact[0].force) > 1e-6


def check_states_at_rest_go_on():
    """The cylinder under pressure stays at rest in time."""
    m = rings("quadrilateral", "sleeve")
    static, _ = lame(m, [tie(m)])
    problem = di.ExplicitProblem.from_static(static, bcs=static.bcs, loads=static.loads, contact=[tie(m)])
    problem.advance(until=50 * problem.stable_step(), progress=False)
    assert COMM.allreduce(float(np.abs(problem.velocity.x.array).max(initial=0.0)), MPI.MAX) < 1e-9
