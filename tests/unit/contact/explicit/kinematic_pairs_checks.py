# SPDX-License-Identifier: MIT
"""Kinematic contact of several pairs whose surfaces share nodes, on the ranks of COMM_WORLD."""

import numpy as np
from mpi4py import MPI
from partitioned_bodies import scattered
from several_boxes import Boxes, momentum, own_energy

import dolfinx_impact as di


COMM = MPI.COMM_WORLD


def boxes_of(case, dim, comm=MPI.COMM_SELF, **more):
    """Boxes, surfaces of `Boxes.tags`, and pairs (slave, master) of tags; bodies of revolution are rings."""
    inner = 0.7 if more.get("hypothesis") == "axisymmetric" else 0.0
    up = dim - 1
    top, bottom = 2 * up + 1, 2 * up

    def box(x, y, z, nx, ny, vx, vy):
        """From intervals along x and the vertical axis; in space z is the third."""
        pick = (lambda a, b, c: (a, b)) if dim == 2 else (lambda a, b, c: (a, c, b))
        x = [a + inner for a in x]
        return (pick(x[0], y[0], z[0]), pick(x[1], y[1], z[1]), pick(nx, ny, 2), pick(vx, vy, 0.0))

    deep, narrow = (0.0, 0.8), (0.13, 0.65)  # no slave node over an edge between facets of a master, where sides tie
    base = box((0.0, 2.0), (0.0, 0.6), deep, 7, 2, 0.0, 0.0)
    if case == "tee":  # two boxes fall on a base and meet each other
        boxes = (
            base,
            box((0.1, 0.95), (0.62, 1.4), narrow, 3, 3, 0.3, -1.0),
            box((1.0, 1.9), (0.62, 1.4), narrow, 3, 2, -0.3, -1.0),
        )
        surfaces = {1: (0, top), 2: [(1, bottom)], 3: (2, bottom), 4: (1, 1), 5: (2, 0)}
        pairs = [(2, 1), (3, 1), (4, 5)]
    elif case == "stack":
        boxes = (base, box((0.2, 1.8), (0.62, 0.8), narrow, 5, 1, 0.0, -0.5),
                 box((0.5, 1.5), (0.82, 1.5), narrow, 3, 2, 0.1, -1.0))  # fmt: skip
        surfaces = {1: (0, top), 2: [(1, bottom), (1, 0), (1, 1)], 3: [(1, top)], 4: (2, bottom)}
        pairs = [(2, 1), (4, 3)]
    elif case == "both ways":
        boxes = base, box((0.3, 1.7), (0.62, 1.5), narrow, 4, 2, 0.2, -1.0)
        surfaces, pairs = {1: (0, top), 2: (1, bottom)}, [(2, 1), (1, 2)]
    else:  # "shared master": two boxes fall on neighbouring parts of one facet of a base
        boxes = (
            base,
            box((0.1, 0.95), (0.62, 1.4), narrow, 3, 3, 0.0, -1.0),
            box((1.0, 1.9), (0.62, 1.4), narrow, 3, 2, 0.0, -1.0),
        )
        surfaces, pairs = {1: (0, top), 2: (1, bottom), 3: (2, bottom)}, [(2, 1), (3, 1)]
    made = Boxes(*boxes, comm=comm, **more)
    return made, made.tags(surfaces), pairs


def problem_of(case, dim, friction=0.0, comm=MPI.COMM_SELF, **more):
    boxes, tags, pairs = boxes_of(case, dim, comm, **more)
    return boxes.problem([di.Kinematic(di.ContactPair(tags, *pair, friction=friction)) for pair in pairs])


CASES = ("tee", "stack", "both ways", "shared master")


def assert_conserves(problem, until=0.5):
    """Momentum to round-off; no energy from nothing, and the balance closes."""
    before = momentum(problem)
    problem.advance(until, progress=False)
    mass = problem.comm.allreduce(problem.mass.array[: problem.num_owned].sum())
    kept = slice(1, None) if problem.axisymmetric else slice(None)  # hoop stresses have a radial resultant
    assert np.max(np.abs(momentum(problem) - before)[kept]) < 1e-12 * mass
    energy = own_energy(problem)
    assert np.max(energy) <= energy[0] * (1 + 1e-3)  # the kinetic energy is that of two half steps
    assert abs(problem.energy["drift"]) < 1e-3 and problem.energy["impact"] >= -1e-3 * energy[0]
    return energy


def assert_same_on_ranks(case, dim, friction, **options):
    """Pairs that are scattered over the ranks act as on one: energies and forces of all steps."""
    here = problem_of(case, dim, friction, **options)
    more = {} if COMM.size == 1 else {"partitioner": scattered(3)}
    there = problem_of(case, dim, friction, COMM, **options, **more)
    for run in (here, there):
        run.advance(40 * here.stable_step(), dt=0.8 * here.stable_step(), progress=False)
    rows = here.energy_history, there.energy_history
    size = np.abs(rows[0][:, 1:]).sum(axis=1).max()
    assert np.max(np.abs(rows[0] - rows[1])) < 1e-9 * size, (case, dim, options)
    assert np.any(rows[0][:, 5]) or not friction
    forces = [np.array(run.force_history) for run in (here, there)]
    assert np.max(np.abs(forces[0] - forces[1])) < 1e-8 * np.abs(forces[0]).max(), (case, dim, options)
    assert np.all(np.abs(forces[0]).max(axis=(1, 2)) > 0.0) or case == "tee", (case, dim, options)


def check_pairs_on_ranks():
    for case, dims in (("tee", (2,)), ("stack", (3,)), ("both ways", (2,)), ("shared master", (2, 3))):
        for dim in dims:
            assert_same_on_ranks(case, dim, 0.3 if dim == 2 else 0.0)


def check_other_cells_on_ranks():
    """Triangles, degree 2, bodies of revolution and tetrahedra."""
    assert_same_on_ranks("tee", 2, 0.3, cell="triangle", degree=2)
    assert_same_on_ranks("both ways", 2, 0.3, cell="triangle", degree=2, hypothesis="axisymmetric")
    assert_same_on_ranks("shared master", 2, 0.3, degree=2)
    assert_same_on_ranks("tee", 3, 0.3, cell="tetrahedron")
