# SPDX-License-Identifier: MIT
"""Kinematic contact: gaps closed, momentum kept, forces that only press."""

import numpy as np
import pytest
from mpi4py import MPI
from nodal_model import Nodal, moved_obstacle, partitioned_bodies, smooth, two_bodies

from dolfinx_impact import _cpp

FLAT = dict(lower=(1.0, 1.0, 0.5), upper=(1.0, 1.0, 0.5), lower_cells=(3, 3, 1), gap=0.0)

WIDE = FLAT | dict(lower=(5 / 3, 5 / 3, 0.5), lower_cells=(5, 5, 1))  # nodes match, the master reaches farther


def flat(model):
    """Straightens the bent surfaces of the pair: displacements that make x_2 what the recipe says."""
    u = np.zeros_like(model.x)
    bend = 0.05 * np.sin(3 * model.x[:, 0] + model.x[:, 1])
    u[:, 2] = -model.x[:, 2] * bend / (1 + bend)
    return u


def pressed(model, depth=0.01, slide=0.0):
    """Predicted state in which the slave has come down by `depth` and sideways by `slide`; its increments."""
    start, slave = flat(model), model.slave_body
    du = np.zeros_like(start)
    du[slave, 2] = -depth
    du[slave, 0] = slide
    return start + du, du


def test_matching_nodes_close_in_one_sweep():
    model = two_bodies("hexahedron", upper_cells=(3, 3, 1), kinematic=True, sweeps=1, **FLAT)
    u, du = pressed(model)
    new, f = model.correct(u, du)
    moved = new - u
    assert np.allclose(moved[:, :2], 0, atol=1e-15)
    x = model.x + new
    slave = model.contact.nodes
    assert len(slave) == 16
    for i in slave:
        near = np.linalg.norm(x[:, :2] - x[i, :2], axis=1) < 1e-9
        heights = x[near, 2]
        pair = heights[np.argsort(abs(heights - x[i, 2]))[:2]]
        assert abs(pair[0] - pair[1]) < 1e-14
    assert np.allclose(moved, model.dt**2 * f / model.mass_owned[:, None], atol=1e-16)
    assert np.abs(model.contact.results()["gap"]).max() < 1e-14


@pytest.mark.parametrize("friction", (0.0, 0.3))
@pytest.mark.parametrize(
    "cell,degree", [("hexahedron", 1), ("tetrahedron", 1), ("quadrilateral", 2), ("hexahedron", 2)]
)
def test_momentum_is_kept_and_nothing_adheres(cell, degree, friction):
    """Arbitrary states: forces add up to nothing, press only, stay in the cone; gaps shrink with every sweep."""
    left = []
    for sweeps in (1, 3, 30):
        model = two_bodies(cell, degree, kinematic=True, sweeps=sweeps, friction=friction)
        before, u = smooth(model.x, 0.01), smooth(model.x, 0.012, 0.4)
        new, f = model.correct(u, u - before)
        total = np.abs(f).sum()
        assert total > 0 and np.abs(f.sum(axis=0)).max() < 1e-14 * total
        x = np.pad(model.x + before, ((0, 0), (0, 3 - f.shape[1])))  # forces act where the step begins
        moment = np.cross(x, np.pad(f, ((0, 0), (0, 3 - f.shape[1])))).sum(axis=0)
        assert np.abs(moment).max() < 1e-13 * np.abs(x).max() * total
        assert np.allclose(new - u, model.dt**2 * f / model.mass_owned[:, None], rtol=1e-12, atol=1e-16)
        r = model.contact.results()
        assert np.all(r["pressure"] >= 0) and np.any(r["pressure"] > 0)
        force = f[model.contact.nodes]
        normal = np.sum(force * r["normal"], axis=1)
        tangential = np.linalg.norm(force - normal[:, None] * r["normal"], axis=1)
        assert np.all(normal >= -1e-13 * total)
        assert np.all(tangential <= friction * normal * (1 + 1e-12) + 1e-13 * total)
        assert np.allclose(f[model.contact.nodes].sum(axis=0), model.contact.force, atol=1e-13 * total)
        closed = r["status"] > 0
        left.append(np.abs(r["gap"][closed]).max())
    assert left[2] < 0.1 * left[0]


def test_friction_sticks_where_it_can():
    """With a large coefficient the bodies move together; with a small one the forces are at the limit."""
    for friction, status in ((5.0, 1), (0.1, 2)):
        model = two_bodies("hexahedron", upper_cells=(3, 3, 1), kinematic=True, friction=friction, **WIDE)
        u, du = pressed(model, slide=0.005)
        new, f = model.correct(u, du)
        r = model.contact.results()
        assert np.all(r["status"] == status)
        moved = du + new - u
        slave, x = model.contact.nodes, model.x + flat(model)
        others = ~model.slave_body
        for i in slave:
            j = np.flatnonzero(others)[np.argmin(np.linalg.norm(x[others] - x[i], axis=1))]
            relative = moved[i] - moved[j]
            assert abs(relative[2]) < 1e-2 * 0.01
            if status == 1:
                assert abs(relative[0]) < 1e-2 * 0.005
            else:
                assert np.isclose(-f[i, 0], friction * f[i, 2], rtol=1e-9)


def test_rigid_obstacle():
    """Nodes come to lie on it in one sweep, whatever their mass; prescribed components stay."""
    model = moved_obstacle("hexahedron", kinematic=True, sweeps=1)
    model.renumber(np.zeros_like(model.x))
    fixed = model.contact.nodes[0]
    model.inverse[3 * fixed + 2] = 0.0
    u = np.zeros_like(model.x)
    u[:, 2] = -0.1
    new, f = model.correct(u, u, search=False)
    r = model.contact.results()
    closed = r["status"] > 0
    assert closed.any()
    gap = (model.x + new)[model.contact.nodes, 2] - model.height
    assert np.abs(gap[closed][1:]).max() < 1e-14
    assert new[fixed, 2] == -0.1
    assert isinstance(model, Nodal) and np.all(f[:, :2] == 0)


def heavy(cell, heavier, sweeps, upper_cells, friction=0.3):
    """Largest gap left of a slave that has come down by 5e-3, 4e-3 of it into a lighter master; nodes do not match."""
    dim = 2 if cell == "quadrilateral" else 3
    model = two_bodies(
        cell, kinematic=True, sweeps=sweeps, mass=lambda x: np.where(x[:, dim - 1] > 1.0 - 1e-9, heavier, 1.0),
        lower=(1.2,) * (dim - 1) + (0.999,), lower_cells=(7,) * (dim - 1) + (2,), gap=0.001,
        upper_cells=(upper_cells,) * dim, friction=friction, offset=(0.017,) * (dim - 1),
    )  # fmt: skip
    u = np.zeros_like(model.x)
    u[model.slave_body, -1] = -0.005
    model.correct(u, u)
    r = model.contact.results()
    assert np.any(r["pressure"] > 0)
    return np.abs(r["gap"][r["status"] > 0]).max()


@pytest.mark.parametrize("cell", ("quadrilateral", "hexahedron", "tetrahedron"))
@pytest.mark.parametrize("heavier", (1.0, 16.0, 1e4))
def test_slaves_that_share_no_masters_need_one_sweep(cell, heavier):
    """What a sweep leaves is what turning the facets back into line with the forces undoes, some 1e-2 of the gap."""
    left = [heavy(cell, heavier, sweeps, 2) for sweeps in (1, 11, 41)]
    assert left[0] < 0.05 * 0.004 and left[1] < 1e-10 and left[2] < 1e-15


@pytest.mark.parametrize("cell", ("quadrilateral", "hexahedron", "tetrahedron"))
@pytest.mark.parametrize("heavier", (1.0, 16.0, 1e4))
def test_sweeps_converge_however_heavy_slaves_that_share_masters(cell, heavier):
    """Asked for the slaves' whole mass, light masters would be thrown off, and the next sweep grow."""
    left = [heavy(cell, heavier, sweeps, 5) for sweeps in (1, 3, 11, 101)]
    assert 0.004 > left[0] > left[1] > left[2] > left[3] and left[3] < 1e-4 * 0.004
    if heavier == 1.0:
        assert left[1] < 0.01 * 0.004  # the default's three sweeps


def against_a_wall(normal, friction, sweeps):
    """A square whose nodes cannot move along y, 0.01 deep in a plane; forces and gaps."""
    V, slave, _ = partitioned_bodies.two_bodies(MPI.COMM_SELF, 2, "quadrilateral")
    plane = _cpp.gap.Rigid("plane", 2, [0.5, 1.0, 0.0], [*(np.array(normal) / np.linalg.norm(normal)), 0.0], 0.0)
    model = Nodal(V, slave, plane, kinematic=True, sweeps=sweeps, friction=friction)
    start = np.zeros_like(model.x)
    model.renumber(start)
    model.inverse[1::2] = 0.0
    u = np.tile([-0.02, -0.01], (len(start), 1))
    f = model.correct(u, u, search=False)[1]
    return np.abs(f).max() * model.dt**2, model.contact.results()


def test_rollers_oblique_to_a_wall():
    """Normal and tangential forces move the nodes the same way, as a wedge that slides in: at 45 degrees the gap closes
    where friction is below one, and sweeps do not drive each other up."""
    for friction in (0.3, 0.9):
        size, results = against_a_wall((1.0, 1.0), friction, 300)
        free, _ = against_a_wall((1.0, 1.0), 0.0, 300)
        closed = results["status"] > 0
        assert np.count_nonzero(closed) == 1 and np.abs(results["gap"][closed]).max() < 1e-12
        assert size == pytest.approx(free * (1 + friction) / (1 - friction), rel=1e-9)


@pytest.mark.parametrize("friction", (0.0, 0.5))
def test_a_wall_that_nodes_cannot_move_along(friction):
    """The normal is along what is prescribed, but for round-off: no force can close the gap."""
    size, results = against_a_wall((1e-16, 1.0), friction, 3)
    assert size < 1e-15 and np.any(results["gap"] < -0.005)
