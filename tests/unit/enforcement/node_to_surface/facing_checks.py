# SPDX-License-Identifier: MIT
"""Bodies that tumble over each other, so that nodes lose and find their masters. See on_ranks.py."""

import numpy as np
from mpi4py import MPI
from nodal_model import Driver, smooth, two_bodies

CASES = (
    ("quadrilateral", 1, {}),
    ("triangle", 2, {}),
    ("hexahedron", 1, {}),
    ("tetrahedron", 1, {"balanced": True}),
    ("hexahedron", 1, {"kinematic": True}),
)
STEPS = 160


def tumbling(model, step):
    """Displacements: the slave's body rocks by up to 2.2 about its lower end, goes to and fro and trembles. A facet
    that it comes down on is met from the side, from above and from below."""
    t = step / STEPS
    u = smooth(model.x, 0.01, 30 * t)
    body, dim = model.slave_body, model.dim
    angle = 2.2 * np.sin(7 * t)
    R = np.eye(dim)
    R[np.ix_([0, -1], [0, -1])] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    pivot = np.full(dim, 0.5)
    pivot[-1] = 1.0
    u[body] += (model.x[body] - pivot) @ (R - np.eye(dim)).T
    u[body, 0] += 0.35 * np.sin(9 * t)
    u[body, -1] += 0.05 * np.sin(17 * t)
    return u


def follow(comm, cell, degree, options, always, keep=False):
    """Forces and states of all steps.

    Args:
        always: search for candidates in every step. keep: facing is judged by the normals of the last search.
    """
    model = two_bodies(cell, degree, comm, seed=3, gap=0.01, **options)
    for side in model.sides:
        side.keep_normals(keep)
    rows, before = [], tumbling(model, 0)
    for step in range(STEPS):
        u = tumbling(model, step)
        search = always or model.halo is None or model.again()
        if options.get("kinematic"):
            _, f = model.correct(u.copy(), u - before, search=search)
        else:
            f = model.forces(u, u - before, search=search)
        before = u
        rows.append((f.copy(), model.contact.saved_state().array("closed").copy()))
    return model, rows


def searched_or_not(comm, cell, degree, options, keep=False):
    """Largest difference of forces, relative to the largest force; how many nodes change their state otherwise."""
    model, lazy = follow(comm, cell, degree, options, False, keep)
    again, always = follow(comm, cell, degree, options, True)
    assert model.contact.counters()["searches"] < again.contact.counters()["searches"] == STEPS
    largest = comm.allreduce(max((np.abs(f).max(initial=0.0) for f, _ in always)), MPI.MAX)
    error = max(np.abs(a - b).max(initial=0.0) for (a, _), (b, _) in zip(lazy, always))
    changed = sum(np.count_nonzero(a != b) for (_, a), (_, b) in zip(lazy, always))
    closed = comm.allreduce(sum(np.count_nonzero(c == 1) for _, c in always))
    marked = comm.allreduce(sum(np.count_nonzero(c == -1) for _, c in always))
    assert closed > 20 and marked > 20, f"{cell}: {closed} closed, {marked} marked: too little happens"
    return comm.allreduce(error, MPI.MAX) / largest, comm.allreduce(changed), model


def check_forces_do_not_depend_on_searches():
    """Candidates searched in every step, where all is evaluated anew, or when they are due."""
    failures = []
    for cell, degree, options in CASES:
        error, changed, _ = searched_or_not(MPI.COMM_WORLD, cell, degree, options)
        if not (error < 1e-10 and changed == 0):  # round-off of places, times the slope of the overlap
            failures.append(f"{cell} {degree} {options}: forces differ by {error:.1e}, {changed} states")
    assert not failures, "\n".join(failures)


def driven(comm, cell, always, **options):
    """Displacements after a run in which contact decides what happens."""
    model = two_bodies(cell, comm=comm, seed=1, **options)
    driver = Driver(model)
    if always:
        model.again = lambda: True
    driver.run(250)
    assert comm.allreduce(driver.contacts) > 100
    return driver.u
