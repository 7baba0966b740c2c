# SPDX-License-Identifier: MIT
"""Closest points followed over many steps against a full search in each; how rarely anything is searched."""

import numpy as np
import pytest
from mpi4py import MPI
from nodal_model import Nodal, partitioned_bodies, smooth, two_bodies
from nodal_oracle import closest, mean_overlap, node_normals

CELLS = [("quadrilateral", 1), ("hexahedron", 1), ("tetrahedron", 1), ("hexahedron", 2), ("triangle", 2)]


def overlaps(master, nodes, p, du):
    """Of each node, by the motion of the step."""
    out = np.zeros(len(nodes))
    for q, (i, f) in enumerate(zip(nodes, p["facet"])):
        if f >= 0:
            motion = du[i] - master.displacement.tabulate(*p["xi"][q])[0] @ du[master.nodes[f]]
            out[q] = mean_overlap(p["gap"][q], p["normal"][q] @ motion, p["beside"][q])
    return out


def full_search(V, slave, master, model, u):
    """Facets that face the nodes by their normals in this configuration."""
    slave.move(u.reshape(-1)), master.move(u.reshape(-1))
    normals = node_normals(slave, model.num, model.dim)[model.contact.nodes]
    x = np.ascontiguousarray((model.x + u)[model.contact.nodes])
    return closest(master, model.x, x, normals, model.contact.search_distance)


@pytest.mark.parametrize("cell,degree", CELLS)
def test_closest_points_are_those_of_a_full_search(cell, degree):
    """Bodies that slide, rock and vibrate: every gap, normal and force direction in every step."""
    dim = 2 if cell in ("triangle", "quadrilateral") else 3
    V, slave, master = partitioned_bodies.two_bodies(
        MPI.COMM_SELF, dim, cell, 1, degree, gap=0.0, lower_cells=(5,) * dim, upper_cells=(4,) * dim
    )
    model = Nodal(V, slave, master)
    body, middle = model.slave_body, np.array([0.5] * (dim - 1) + [1.0])
    steps, searches, before, closed = 400, 0, None, 0
    for step in range(steps):
        t = step / steps
        u = smooth(model.x, 0.004, 30 * t)
        turn = 0.05 * np.sin(9 * t)
        y = model.x[body] - middle
        u[body, 0] += 0.3 * np.sin(4 * t) - turn * y[:, -1]
        u[body, -1] += 0.01 * np.sin(50 * t) + turn * y[:, 0]
        if step == 0 or model.again():
            model.renumber(u)
            searches += 1
        du = np.zeros_like(u) if before is None else u - before
        model.forces(u, du, search=False)
        before = u
        r = model.contact.results()
        expected = full_search(V, slave, master, model, u)
        overlap = overlaps(master, model.contact.nodes, expected, du)
        deep = (overlap > 0) & (r["stiffness"] == 0)  # first seen too deep: left open
        assert np.count_nonzero(deep) <= model.contact.counters()["implausible"]
        touching = r["stiffness"] > 0
        assert np.array_equal(touching, (overlap > 0) & ~deep)
        assert np.allclose(r["gap"][touching], expected["gap"][touching], atol=1e-13)
        # At a kink there may be two nearest points, but for that normals are the same.
        differ = np.abs(r["normal"] - expected["normal"])[touching].max(axis=1) > 1e-9
        assert np.count_nonzero(differ) == 0
        closed += np.count_nonzero(touching)
    counters = model.contact.counters()
    num = len(model.contact.nodes)
    assert closed > 0.1 * steps * num
    assert searches < 0.05 * steps and counters["searches"] == searches
    assert counters["queries"] < 0.25 * counters["nodes"]
    assert counters["normals"] < 0.5 * counters["nodes"]


def test_bodies_that_fly_together_are_not_searched():
    """Whatever the common translation; and far apart nobody is looked at."""
    model = two_bodies("hexahedron", gap=0.2)
    u = np.zeros_like(model.x)
    searches = 0
    for step in range(300):
        du = np.zeros_like(u) + [0.05, 0.02, -0.03] if step else np.zeros_like(u)
        u = u + du
        search = step == 0 or model.again()
        searches += search
        model.forces(u, du, search=search)
    counters = model.contact.counters()
    assert searches <= 4
    assert counters["nodes"] <= 2 * searches * len(model.contact.nodes)


@pytest.mark.parametrize("cell", ("quadrilateral", "hexahedron", "tetrahedron"))
def test_gaps_of_sleeping_nodes_on_request(cell):
    """Where nobody looked in the steps: as if all had been looked at there, and without effect on later steps."""
    model, other = (two_bodies(cell, gap=0.05) for _ in range(2))
    u = np.zeros_like(model.x)
    for m in (model, other):
        m.forces(u)
    first = model.contact.results()["gap"]
    u[model.slave_body, -1] -= 0.01
    u[model.slave_body, 0] += 0.003 * model.x[model.slave_body, 0]
    for m in (model, other):
        m.forces(u, search=False)
    assert np.array_equal(model.contact.results()["gap"], first)  # nobody looked
    for moved in (u, u + 1e-3 * np.sin(3 * model.x)):  # the second: nodes moved since, as kinematic contact does
        fresh = two_bodies(cell, gap=0.05)
        fresh.forces(moved)
        model.contact.update_gaps(model.halo, model.spread(moved).reshape(-1))
        for name in ("gap", "normal"):
            expected, found = fresh.contact.results()[name], model.contact.results()[name]
            np.testing.assert_allclose(found, expected, rtol=0, atol=1e-14)  # round-off of places of size one
    assert np.all(model.contact.results()["gap"] < first)
    u[model.slave_body, -1] -= model.contact.results()["gap"].max()
    counters = []
    for m in (model, other):
        f = m.forces(u, search=False)
        assert np.abs(f).max() > 0.0
        counters.append((m.contact.counters()["nodes"], f))
    assert counters[0][0] == counters[1][0] and np.array_equal(counters[0][1], counters[1][1])
