# SPDX-License-Identifier: MIT
"""What happens at the ends of surfaces, in fast and in unlikely motions; checkpoints."""

import numpy as np
import pytest
from dolfinx import fem
from mpi4py import MPI
from nodal_model import Driver, Nodal, moved_obstacle, partitioned_bodies, two_bodies

from dolfinx_impact import _cpp, meshes

DT = 1e-3


def straight(cell="hexahedron", **more):
    """Bodies with straight faces: displacements that undo the recipe's bending, and the model."""
    model = two_bodies(cell, dt=DT, **more)
    u, dim = np.zeros_like(model.x), model.dim
    bend = 0.05 * np.sin(3 * model.x[:, 0] + model.x[:, 1] * (dim - 2))
    if dim == 3:
        u[:, 2] = -model.x[:, 2] * bend / (1 + bend)
    else:
        u[:, 1] = -model.x[:, 1] * bend / (1 + bend)
    return model, u


@pytest.mark.parametrize("cell", ("quadrilateral", "hexahedron", "tetrahedron"))
def test_sliding_off_an_edge(cell):
    """A node is in contact as long as it is over the master, and open, with a positive gap, beside it."""
    model, start = straight(cell, gap=-0.001, friction=0.2)
    before = None
    for step in range(60):
        u = start.copy()
        u[model.slave_body, 0] += 0.0199 * step
        model.forces(u, None if before is None else u - before, search=step == 0 or model.again())
        before = u
        r = model.contact.results()
        x = (model.x + u)[model.contact.nodes, 0]
        beside = np.maximum(x - 1.0, -x)  # by less than a twentieth of the facet counts as over it; none is 0.5 wide
        over, off = beside < -1e-9, beside > 0.025
        assert np.all(r["status"][over] > 0) and np.all(r["status"][off] == 0)
        assert np.all(r["gap"][off] > 0)
        assert np.allclose(r["gap"][over], -0.001, atol=1e-12)
    assert not over.any()


def test_impact_on_a_vertex():
    """A node on a vertex of the master: forces on that vertex alone, the same from all sides."""
    model, start = straight(
        "hexahedron", gap=-0.002, lower_cells=(4, 4, 1), lower=(1.2, 1.2, 1.0), upper=(0.6, 0.6, 0.9)
    )
    f = model.forces(start)
    assert np.all(model.contact.results()["status"] > 0)
    x = model.x + start
    for i in model.contact.nodes:
        near = np.flatnonzero(np.linalg.norm(x[:, :2] - x[i, :2], axis=1) < 1e-9)
        vertex = [j for j in near if abs(x[j, 2] - 1.0) < 1e-9][0]
        assert np.allclose(f[vertex], -f[i], atol=1e-7 * np.abs(f).max()) and f[i, 2] > 0
    # A pyramid: the vertex in the middle of the master is lifted, a node comes down beside its tip.
    tip = np.flatnonzero(np.linalg.norm(x - [0.6, 0.6, 1.0], axis=1) < 1e-9)[0]
    assert tip not in model.contact.nodes
    u = start.copy()
    u[tip, 2] += 0.1
    u[model.slave_body, 2] += 0.101  # the tip is 1e-3 into the slave's middle node
    for side in ((0.0, 0.0), (1e-4, 0.0), (0.0, -1e-4), (-1e-4, 1e-4)):
        moved = u.copy()
        moved[model.slave_body, :2] += side
        f = model.forces(moved)
        closed = model.contact.results()["status"] > 0
        assert np.count_nonzero(closed) == 1
        assert np.abs(f.sum(axis=0)).max() < 1e-13 * np.abs(f).max()
        i = model.contact.nodes[np.flatnonzero(closed)[0]]
        assert f[i, 2] > 0.5 * np.linalg.norm(f[i])


def test_chatter_ends():
    """Impacts again and again, with damping: the node's force finds its load, energy of the spring stays bounded."""
    model, _ = straight("hexahedron", gap=0.003, friction=0.3)
    driver = Driver(model, speed=0.2)
    opened, last = 0, np.zeros(len(model.contact.nodes), dtype=bool)
    for _ in range(1500):
        driver.run(1)
        closed = model.contact.results()["status"] > 0
        opened += np.count_nonzero(last & ~closed)
        last = closed
    assert opened > 10
    assert np.abs(driver.v).max() < 1.0 and model.contact.energy()["friction"] >= 0


@pytest.mark.parametrize("depth", (0.1, 0.3, 0.46))
def test_fast_approach(depth):
    """A step that leads deep into the master, or through it, closes the nodes that came from outside."""
    model, f, status = fast_approach(depth)
    assert np.all(status > 0) and np.all(f[model.contact.nodes, 2] > 0)
    assert model.contact.passage == (-1, 0.0)


@pytest.mark.parametrize("depth", (0.6, 2.5))
def test_too_fast_approach(depth):
    """A step of more than a facet, 0.47 corner to corner, is told: by how many facets the node came through."""
    model, f, status = fast_approach(depth)
    assert np.all(status == 0) and not f.any()
    node, facets = model.contact.passage
    assert node in model.contact.nodes and np.isclose(facets, depth / np.hypot(1 / 3, 1 / 3), rtol=1e-3)


def fast_approach(depth):
    """Two steps at rest, then one in which the slave falls by `depth`: model, forces, status."""
    model, start = straight("hexahedron", gap=0.05, lower=(1.0, 1.0, 0.4), upper=(0.9, 0.9, 0.4))
    u = start.copy()
    for step, fall in enumerate((0.0, 0.0, depth)):
        du = np.zeros_like(u)
        du[model.slave_body, 2] = -fall
        u = u + du
        f = model.forces(u, du, search=step == 0 or model.again())
        status = model.contact.results()["status"]
        assert np.all(status == 0) or step == 2
    assert model.contact.counters()["implausible"] == 0
    return model, f, status


def test_first_seen_deep_inside():
    """Is left open, and counted; a small overlap of the start is contact."""
    model, start = straight("hexahedron", gap=-0.3, search_distance=0.5)
    assert np.all(model.forces(start) == 0)  # 0.3: more than half of a facet of 0.33, corner to corner 0.47
    assert model.contact.counters()["implausible"] == len(model.contact.nodes)
    assert np.all(model.contact.results()["gap"] < 0)
    model, start = straight("hexahedron", gap=-0.1)
    assert np.all(model.forces(start)[model.contact.nodes, 2] > 0)


def test_thin_bodies():
    """The slave sees the side of a thin master that faces it, not the other one, which is nearer."""
    parameters = dict(lower=(1.0, 1.0, 0.012), upper=(0.9, 0.9, 0.2), lower_cells=(3, 3, 1), upper_cells=(2, 2, 2))
    m = meshes.make("two_blocks", MPI.COMM_SELF, cell="hexahedron", gap=-0.01, **parameters)
    V = fem.functionspace(m.mesh, ("Lagrange", 1, (3,)))
    m.mesh.topology.create_connectivity(2, 3), m.mesh.topology.create_connectivity(3, 2)
    slave = _cpp.surface.make_surface(V._cpp_object, m.facet_tags.find(m.tags["slave_surface"]))
    both = np.concatenate([m.facet_tags.find(m.tags[name]) for name in ("master_surface", "bottom")])
    master = _cpp.surface.make_surface(V._cpp_object, both.astype(np.int32))
    model = Nodal(V, slave, master, DT)
    f = model.forces(np.zeros_like(model.x))
    assert np.all(f[model.contact.nodes, 2] > 0)
    assert np.allclose(model.contact.results()["gap"], -0.01, atol=1e-12)


def test_slave_between_two_masters():
    """One slave surface, two obstacles: forces of both add up; on a wedge's faces each in its own direction."""
    V, slave, _ = partitioned_bodies.two_bodies(MPI.COMM_SELF, 3)
    total = None
    models = []
    for normal in ([0.6, 0.0, 0.8], [-0.6, 0.0, 0.8]):
        wedge = _cpp.gap.Rigid("plane", 3, [0.5, 0.5, 1.0], normal, 0.0)
        models.append(Nodal(V, slave, wedge, DT))
    for model in models:
        f = model.forces(np.zeros_like(model.x))
        total = f if total is None else total + f
        r = model.contact.results()
        closed = r["status"] > 0
        force = f[model.contact.nodes]
        assert np.allclose(np.cross(force, r["normal"]), 0, atol=1e-9 * np.abs(force).max()) and closed.any()
    assert np.any(total != 0)


def test_rigid_forces():
    """k = kappa m / dt^2 whatever the obstacle; friction counts the obstacle's own motion."""
    for kind in ("plane", "sphere", "cylinder"):
        model = moved_obstacle("hexahedron", 1, kind, friction=0.3, dt=DT)
        u = np.zeros_like(model.x)
        u[:, 2] = -0.06
        model.forces(u)
        r = model.contact.results()
        closed = r["status"] > 0
        assert closed.any()
        m = model.mass_owned[model.contact.nodes]
        assert np.allclose(r["stiffness"][closed], 0.5 * m[closed] / DT**2)
        assert np.allclose((r["pressure"] * model.contact.areas)[closed], (-r["stiffness"] * r["gap"])[closed])
        # The obstacle goes sideways with the body: sticks without force; alone: friction drags the body along.
        model.contact.set_obstacle([1e-4, 0, 0], [1e-4, 0, 0])
        moved = u + [1e-4, 0, 0]
        model.forces(moved, moved - u, search=False)
        tangential = model.contact.saved_state().array("tangential")
        assert np.abs(tangential).max() < 1e-9 * np.abs(model.contact.force).max()
        model.contact.set_obstacle([2e-4, 0, 0], [1e-4, 0, 0])
        model.forces(moved, 0 * u, search=False)
        assert np.all(model.contact.saved_state().array("tangential")[closed, 0] > 0)


@pytest.mark.parametrize("options", ({"friction": 0.3}, {"kinematic": True, "friction": 0.3}))
def test_checkpoint(options):
    """A run that is stopped and goes on from its history is the same, bit for bit."""
    runs = []
    for stop in (False, True):
        model, _ = straight("hexahedron", gap=0.003, **options)
        driver = Driver(model, speed=0.2)
        driver.run(150)
        if stop:
            kept = model.contact.saved_state()
            model, _ = straight("hexahedron", gap=0.003, **options)
            again = Driver(model)
            again.u, again.v = driver.u, driver.v
            model.contact.resume(kept)
            driver = again
        driver.run(150)
        runs.append((driver.u, driver.v, model.contact.results()["slip"], model.contact.energy()["friction"]))
    for a, b in list(zip(*runs))[:3]:
        assert np.array_equal(a, b)
    if "kinematic" not in options:
        assert runs[0][3] == runs[1][3]
    else:  # half of a step's motion belongs to the work of the step before, which is not kept
        assert np.isclose(runs[0][3], runs[1][3], rtol=1e-2)
