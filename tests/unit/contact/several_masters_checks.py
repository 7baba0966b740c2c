# SPDX-License-Identifier: MIT
"""A slave that may touch several surfaces, and names that tell contacts apart, on any number of ranks. See
on_ranks.py."""

import numpy as np
import pytest
from box_bodies import Boxes
from dolfinx import fem, mesh
from mpi4py import MPI
from shared_folder import shared_folder

import dolfinx_impact as di

COMM = MPI.COMM_WORLD


def bodies(dim):
    """A plate over two blocks, a little apart from each other; tags 4 and 5 are their tops, 3 the plate's underside."""
    deep = [(0.0,) * (dim - 2), (1.0,) * (dim - 2)]
    up = dim - 1

    def box(x0, x1, y0, y1, n):
        return ((x0, *deep[0], y0), (x1, *deep[1], y1), (n, *(2,) * (dim - 2), 2))

    cell = "quadrilateral" if dim == 2 else "hexahedron"
    m = Boxes([box(0.0, 0.9, 0.0, 1.0, 3), box(1.1, 2.0, 0.0, 1.0, 2), box(0.0, 2.0, 1.0, 1.5, 5)], cell)
    return m, up, m.tags({4: (0, up, 1.0), 5: (1, up, 1.0), 3: (2, up, 1.0), 8: (2, up, 1.5)})


def as_one(m, tags):
    """The same tags with one for both masters."""
    values = np.where(tags.values == 5, 4, tags.values).astype(np.int32)
    return mesh.meshtags(m.mesh, m.dim - 1, tags.indices, values)


def problem(kind, dim, method, several):
    m, up, tags = bodies(dim)
    tags = tags if several else as_one(m, tags)
    contact = method(di.ContactPair(tags, slave=3, master=[4, 5] if several else 4))
    down = (0.0,) * (dim - 1) + (-30.0,)
    loads = [di.Traction(tags, 8, down)]
    bcs = m.hold(0, up, 0.0, *range(dim)) + m.hold(1, up, 0.0, *range(dim))
    if kind == "static":
        bcs += m.hold(2, 0, 0.0, *range(dim - 1))
        return m, di.StaticProblem(m.u, m.law, bcs=bcs, loads=loads, contact=[contact])
    make = di.ExplicitProblem if kind == "explicit" else di.NewmarkProblem
    return m, make(m.u, m.law, velocity=fem.Function(m.V), bcs=bcs, loads=loads, contact=[contact])


def go(kind, made):
    if kind == "static":
        return made.solve(progress=False)
    return made.advance(until=0.02, dt=2e-3 if kind == "implicit" else "auto", progress=False)


CASES = (
    ("static", 2, di.Lagrange),
    ("static", 3, di.Penalty),
    ("implicit", 2, di.Lagrange),
    ("explicit", 3, di.Penalty),
    ("explicit", 2, di.Kinematic),
)


def check_several_masters_are_one_surface():
    """The facets of a problem whose masters share one tag are the same: to the last bit on one rank; on several ranks
    PETSc adds what others send in the order of arrival, which is round-off in forces of up to a thousand times the
    displacements."""
    for kind, dim, method in CASES:
        found = []
        for several in (True, False):
            m, made = problem(kind, dim, method, several)
            go(kind, made)
            found.append((m.u.x.array.copy(), made.contact[0].force))
        (u, force), (v, other) = found
        within = 0.0 if COMM.size == 1 else 1e-11 * COMM.allreduce(np.abs(v).max(initial=0.0), MPI.MAX)
        assert np.abs(u - v).max(initial=0.0) <= within and np.abs(force - other).max() <= 1e3 * within, (kind, method)
        assert force[dim - 1] > 1.0, "the plate is borne"
        assert made.contact[0].pair.name == "3 on 4"


def check_both_surfaces_bear():
    """A plate that overlaps both blocks by 0.45 of its half: both bear half, 30 times 2 in all."""
    m, made = problem("static", 2, di.Lagrange, True)
    made.solve(progress=False)
    contact = made.contact[0]
    x, force = contact.points[:, 0], contact.weight * contact.traction[:, 1]
    left, right = (m.sum(force[side].sum()) for side in (x < 1.0, x > 1.0))
    assert abs(left + right - 60.0) < 1e-8 and left > 20.0 and right > 20.0
    assert contact.pair.name == "3 on 4 and 5" and contact.pair.masters == (4, 5)


def check_a_restart_knows_all_masters():
    for kind in ("static", "explicit"):
        _, first = problem(kind, 2, di.Penalty, True)
        go(kind, first)
        with shared_folder(COMM) as folder:
            first.save(folder / "state.h5")
            _, again = problem(kind, 2, di.Penalty, True)
            again.restore(folder / "state.h5")
            assert np.array_equal(again.u.x.array, first.u.x.array)
            _, other = problem(kind, 2, di.Penalty, False)
            with pytest.raises(ValueError, match="master"):
                other.restore(folder / "state.h5")


def check_no_two_contacts_have_the_same_name():
    for kind in ("static", "implicit", "explicit"):
        m, up, tags = bodies(2)
        floor = di.RigidPlane((0.0, -1.0), (0.0, 1.0))
        wall = di.RigidPlane((-1.0, 0.0), (1.0, 0.0))
        given = [(3, 4, None), (3, 5, None), (3, 4, None), (3, floor, None), (3, wall, None), (3, 5, "3 on 4 (1)")]
        contacts = [di.Penalty(di.ContactPair(tags, s, t, name=name)) for s, t, name in given]
        if kind == "static":
            made = di.StaticProblem(m.u, m.law, contact=contacts)
        else:
            made = (di.ExplicitProblem if kind == "explicit" else di.NewmarkProblem)(m.u, m.law, contact=contacts)
        names = [c.pair.name for c in made.contact]
        expected = ["3 on 4 (2)", "3 on 5", "3 on 4 (3)", "3 on RigidPlane (1)", "3 on RigidPlane (2)", "3 on 4 (1)"]
        assert names == expected, (kind, names)
        assert contacts[0].pair.name == "3 on 4", "what the user made stays as it is"
