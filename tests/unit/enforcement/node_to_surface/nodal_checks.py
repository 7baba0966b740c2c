# SPDX-License-Identifier: MIT
"""Explicit contact of pairs whose cells are spread over the ranks at random, against one rank that has everything.
See on_ranks.py."""

import numpy as np
from mpi4py import MPI
from nodal_model import Driver, moved_obstacle, smooth, two_bodies

COMM = MPI.COMM_WORLD
KINDS = [("quadrilateral", 1, {}), ("triangle", 2, {}), ("hexahedron", 1, {}), ("tetrahedron", 2, {})]
SAME = 1e-12  # sums in other orders, Newton's method to 1e-13; relative to the largest
AFTER_STEPS = 1e-9  # of the displacements: bouncing lets rounding errors grow (tenfold in 60 steps)


def in_order(comm, x, *values):
    """Rows of all ranks in the order of their places."""
    x, *values = [np.concatenate(comm.allgather(v)) for v in (x, *values)]
    order = np.lexsort(np.round(x, 9).T)
    return [v[order] for v in (x, *values)]


def both(make):
    """The same model on all ranks and on each alone."""
    return make(COMM, 3), make(MPI.COMM_SELF, None)


def compare(models, results, tolerance, least=0.0):
    """Relative to the largest entry, `least` at least."""
    found, expected = (in_order(m.comm, m.x, *r) for m, r in zip(models, results))
    for a, b in zip(found, expected):
        size = max(np.abs(b).max(), least)
        assert a.shape == b.shape and np.abs(a - b).max() <= tolerance * size, (np.abs(a - b).max(), size)


def check_forces():
    """One configuration: the same forces, equal and opposite."""
    for cell, degree, more in KINDS:
        for options in ({}, {"friction": 0.3}, {"balanced": True}, {"kinematic": True, "friction": 0.3}):
            models = both(lambda comm, seed: two_bodies(cell, degree, comm, seed, **options, **more))
            results = []
            for model in models:
                u, du = smooth(model.x, 0.02), smooth(model.x, 0.02) - smooth(model.x, 0.02, -0.2)
                if model.kinematic:
                    results.append(model.correct(u, du))
                else:
                    results.append((model.forces(u, du), u))
                f = results[-1][1 if model.kinematic else 0]
                total = model.comm.allreduce(f.sum(axis=0))
                size = model.comm.allreduce(np.abs(f).sum())
                assert size > 0 and np.abs(total).max() < 1e-13 * size
                force = model.comm.allreduce(model.pair.force)
                assert np.any(np.abs(force) > 1e-3 * size)
            compare(models, results, SAME)


def check_nodes_that_cross_rank_boundaries():
    """The slave slides over the whole master in 120 steps; searches happen when motion asks for them."""
    for cell, degree, more in KINDS[:3]:
        models = both(lambda comm, seed: two_bodies(cell, degree, comm, seed, friction=0.2, **more))
        before = [0 * m.x for m in models]
        for step in range(120):
            forces = []
            for k, model in enumerate(models):
                u = smooth(model.x, 0.01, 0.05 * step)
                u[model.slave_body, 0] += 0.02 * (step - 60)
                forces.append((model.forces(u, u - before[k] if step else None, search=step == 0 or model.again()),))
                before[k] = u
            # Round-off of positions is the same when little is in contact: relative to overlaps of the amplitude.
            compare(models, forces, 10 * SAME, 0.01 * models[1].contact.results()["stiffness"].max())
        assert 1 <= models[0].contact.counters()["searches"] < 40


def check_runs():
    """Bodies of springs hit each other again and again, 250 steps."""
    for cell, degree, more in (KINDS[0], KINDS[2]):
        for options in ({"friction": 0.3}, {"kinematic": True, "friction": 0.3}, {"balanced": True}):
            models = both(lambda comm, seed: two_bodies(cell, degree, comm, seed, gap=0.005, **options, **more))
            ends = []
            for model in models:
                driver = Driver(model)
                driver.run(250)
                assert model.comm.allreduce(driver.contacts) > 50
                ends.append((driver.u,))
            compare(models, ends, AFTER_STEPS)


def check_rigid():
    """Obstacles need no neighbours; ghosts are right after a correction."""
    for kind in ("plane", "sphere"):
        for options in ({"friction": 0.3}, {"kinematic": True, "friction": 0.3}):
            models = both(lambda comm, seed: moved_obstacle("hexahedron", 1, kind, comm, seed, **options))
            ends = []
            for model in models:
                assert len(model.contact.remote_nodes) == 0
                driver = Driver(model)
                driver.run(100)
                assert model.comm.allreduce(driver.contacts) > 1
                ends.append((driver.u,))
            compare(models, ends, AFTER_STEPS)
