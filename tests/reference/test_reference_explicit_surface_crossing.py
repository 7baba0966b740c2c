# SPDX-License-Identifier: MIT
"""Who closes in explicit contact of the hand-written solver: through the surface only."""

import impact_reference as ir
import numpy as np
import pytest
from contact_tip import Tip
from reference_meshes import CELLS, box, facets_where
from test_reference_explicit_contact import single_mass

KINDS = [ir.NodalPenalty, ir.NodalKinematic]
SOFT = 1e-18  # Young's modulus of bodies that loads alone move

# Places of the tip (along the first and the last axis) over the facet from 0 to 1, and whether it is closed there. Half
# of a facet is 0.5 or 0.71, a twentieth 0.05 or 0.07. Kinematic contact has them as predictions.
WAYS = {
    "from above": ([(0.5, 0.1), (0.5, -0.1), (0.5, -0.2), (0.5, -0.2)], [0, 1, 1, 1]),
    "overlapping from the start": ([(0.5, -0.1), (0.5, -0.1), (0.5, -0.1)], [1, 1, 1]),
    "from above, and deep": ([(0.5, 0.1), (0.5, -0.8), (0.5, -0.9), (0.5, -0.9)], [0, 1, 1, 1]),
    "deep from the start, until it has been above": (
        [(0.5, -0.9), (0.5, -0.8), (0.5, -0.4), (0.5, -0.4), (0.5, 0.5), (0.5, -0.1), (0.5, -0.1)],
        [0, 0, 0, 0, 0, 1, 1],
    ),
    "from beside, below, until it has been above": (
        [(1.4, -0.1), (0.5, -0.1), (0.5, -0.2), (0.5, 0.5), (0.5, -0.1), (0.5, -0.1)],
        [0, 0, 0, 0, 1, 1],
    ),
    "from beside, below, until it has been beside and above": (
        [(1.4, -0.1), (0.9, -0.1), (0.9, -0.1), (1.4, 0.3), (0.9, -0.1), (0.9, -0.1)],
        [0, 0, 0, 0, 1, 1],
    ),
    "from beside, deep": ([(1.4, -0.9), (0.5, -0.9), (0.5, -0.9), (0.5, -0.9)], [0, 0, 0, 0]),
    "from beside, above": ([(1.4, 0.1), (0.5, -0.1), (0.5, -0.1), (0.5, -0.1)], [0, 1, 1, 1]),
    "beside by less than a twentieth": (
        [(1.4, 0.1), (1.04, 0.1), (1.04, -0.1), (0.9, -0.1), (0.9, -0.1)],
        [0, 0, 1, 1, 1],
    ),
    "closed, off the rim and back": (
        [(0.5, 0.1), (0.9, -0.1), (1.2, -0.1), (0.9, -0.1), (0.9, -0.1)],
        [0, 1, 0, 0, 0],
    ),
    "closed, and deep after it": ([(0.5, 0.1), (0.5, -0.1), (0.5, -0.9), (0.5, -0.9)], [0, 1, 1, 1]),
    "beside and below it in the last place only": ([(0.5, 0.1), (0.9, 0.1), (1.2, -0.1)], [0, 0, 0]),
    "from where there is no master, by less than a twentieth": ([(2.5, -0.04), (0.5, -0.04), (0.5, -0.04)], [0, 1, 1]),
    "from where there is no master, not deep": ([(2.5, -0.3), (0.5, -0.3), (0.5, 0.5), (0.5, -0.1)], [0, 0, 0, 1]),
    # Half of the way or more is a facet's: it is followed.
    "fast, past the rim from above": ([(0.5, 0.1), (1.3, -0.3), (1.3, -0.3)], [0, 1, 0]),
    "fast, closed before, past the rim": ([(0.5, 0.1), (0.5, -0.1), (1.4, -0.4), (1.4, -0.4)], [0, 1, 1, 0]),
    "fast, beside the rim all the way": ([(1.2, 0.4), (1.2, -0.5), (1.2, -0.5)], [0, 0, 0]),
    "fast, from beside, through the surface": ([(1.4, 0.3), (0.5, -0.1), (0.5, -0.1)], [0, 1, 1]),
    "closed, and so deep that there is no master for others": (
        [(0.5, 0.1), (0.5, -0.1), (0.5, -1.0), (0.5, -1.9)],
        [0, 1, 1, 1],
    ),
    "deep from where there is no master": ([(2.5, -0.9), (0.5, -0.9), (0.5, -0.9), (0.5, -0.9)], [0, 0, 0, 0]),
}


@pytest.mark.parametrize("cell", CELLS)
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("way", WAYS)
def test_nodes_close_through_the_surface(cell, kind, way):
    places, closed = WAYS[way]
    d = 2 if cell in ("triangle", "quadrilateral") else 3
    path = np.array([[x, 0.4, z][: d - 1] + [z] for x, z in [places[0], *places, places[-1]]])
    if kind is ir.NodalPenalty:
        tip = Tip(cell, path)
        run, seen = tip.run(kind(tip.slave, tip.master, friction=0.5, search_distance=1.2)), slice(1, None)
    else:
        tip, seen = Tip(cell, path, E=SOFT), slice(None, -1)
        contact = kind(tip.slave, tip.master, friction=0.5, search_distance=1.2)
        run, ends = tip.press(contact, closed + closed[-1:])
        z = run.u.reshape(len(run.time), -1, d)[:, tip.node, -1] + path[0, -1]
        # Sums of a few steps of round-off; the closest point is settled to 1e-11 of a facet along, not across it.
        assert np.allclose(z, ends[:-1, -1], rtol=0, atol=1e-12)
    row, closed = tip.row(run), np.array(closed) > 0
    contact = run.contacts[0]
    assert (contact.status[seen, row] > 0).tolist() == closed.tolist()
    force = contact.force.reshape(len(run.time), -1, d)[seen, tip.node]
    assert (force[:, -1] > 0).tolist() == closed.tolist() and (force[~closed] == 0).all()
    assert (contact.traction[seen][~closed, row] == 0).all()


@pytest.mark.parametrize("cell", CELLS)
@pytest.mark.parametrize("kind", KINDS)
def test_steps_longer_than_a_facet_are_refused(cell, kind):
    d = 2 if cell in ("triangle", "quadrilateral") else 3
    path = np.array([[0.5, 0.4, z][: d - 1] + [z] for z in (0.5, 0.5, -1.0, -1.0)])
    step = 0.9 / 1.5 * (1 if d == 2 else 2**0.5)
    with pytest.raises(RuntimeError, match=rf"take steps of {step:.4}"):
        if kind is ir.NodalPenalty:
            tip = Tip(cell, path)
            tip.run(kind(tip.slave, tip.master))
        else:
            tip = Tip(cell, path, E=SOFT)
            tip.press(kind(tip.slave, tip.master), [0, 0, 0])


@pytest.mark.parametrize("shift, held", [(0.0, True), (0.1, False)])
def test_who_is_past_a_thin_plate_is_held_by_it(shift, held):
    """From 0.1 above a plate to 0.03 below the top of another one, or 0.13 below it: the depth below the first one is
    1.05, its facet is 2 wide."""
    plates = [
        box("quadrilateral", (1, 1), mapping=lambda x, z=z: [2 * x[0] - 1, 0.1 * x[1] + z]) for z in (-0.1, -1.12)
    ]
    plates[1][0][:, 1] += shift
    turn = np.array([[1, -1], [1, 1.0]]) / 2**0.5
    p, c = box("quadrilateral", (1, 1))
    p = 0.2 * p @ turn.T + [0.05, 0.1]
    points = np.vstack([plates[0][0], plates[1][0], p])
    cells = np.vstack([plates[0][1], plates[1][1] + 4, c + 8])
    model = ir.Model(points, cells, "quadrilateral", ir.Material(1.0, 0.3, 1.0, "plane_strain"))
    slave = np.vstack([facets_where(p, c, "quadrilateral", lambda x, s=s: abs(s * (x[0] - 0.05) - x[1] + 0.1) < 1e-9)
                       for s in (1, -1)]) + 8  # fmt: skip
    tops = [facets_where(q, e, "quadrilateral", lambda x, q=q: x[1] == q[:, 1].max()) for q, e in plates]
    master = np.vstack([tops[0], tops[1] + 4])
    motion = np.zeros((3, 12, 2))
    motion[1:, 8:, 1] = -1.15
    run = model.run_explicit(
        1.0,
        1,
        fixed_dofs=np.arange(24),
        values=(np.arange(3.0), motion.reshape(3, -1)),
        contacts=[ir.NodalPenalty(slave, master, penalty=3.0)],
    )
    tip = int(np.argmin(p[:, 1])) + 8
    f = run.contacts[0].force[1].reshape(-1, 2)
    # Overlaps: gaps of -1.05, of -0.13 (less than the half of 1.15 below), the node's area is 0.2.
    overlap = 1.05 if held else (1.15 / 2 + 0.13) ** 2 / (2 * 1.15)
    assert np.allclose(f[tip], [0, 0.6 * overlap], rtol=1e-12)
    # The cube's other nodes come to rest above the second plate and are held by the first.
    assert np.allclose(f[4:8].sum(0), 0 if held else -f[tip]) and np.allclose(f.sum(0), 0)


@pytest.mark.parametrize("kind", KINDS)
def test_a_small_ball_is_not_passed_through(kind):
    """A mass in whose way a ball of radius 0.2 lies, 0.05 beside its middle, is behind it after a step of 0.9: the gap
    is that half way plus the other half along the normal there."""
    model, free, right = single_mass()
    v0 = np.zeros(8)
    v0[free] = 0.9
    spring = {"penalty": 1.0} if kind is ir.NodalPenalty else {}  # times the area 1/2
    contact = kind(right, ir.RigidCylinder([1.5, 0.95], 0.2), **spring)
    run = model.run_explicit(1.0, 2, v0=v0, fixed_dofs=np.delete(np.arange(8), free), contacts=[contact])
    depth = 0.2 - 0.05 * 2**0.5 + 0.45 / 2**0.5
    if kind is ir.NodalPenalty:
        # k = 1/2 of a mass of 1.
        assert np.allclose(run.contacts[0].total[1], np.array([-1, 1]) / 2**0.5 * depth / 2, rtol=1e-8)
    else:
        # It moves along the first axis only.
        assert np.isclose(run.u[1, free], 0.9 - depth * 2**0.5, rtol=1e-8)
    assert run.contacts[0].status[1 if kind is ir.NodalPenalty else 0, -1] == 2


@pytest.mark.parametrize("kind", KINDS)
def test_a_rigid_master_takes_who_is_deep(kind):
    tip = Tip("quadrilateral", np.array([(1.4, -0.9), (0.5, -0.9), (0.5, -0.9)]), E=SOFT)
    contact = kind(tip.slave, ir.RigidPlane([0, 0], [0, 1.0]))
    run = tip.run(contact) if kind is ir.NodalPenalty else tip.press(contact, [1, 1])[0]
    assert (run.contacts[0].status[:, tip.row(run)] > 0).all()


def over_a_corner(cell, speed, spin, down):
    """A block over the rim of a larger one, which sinks, turns its outer half down and passes inwards: model, slave,
    master, v0."""
    d = 2 if cell in ("triangle", "quadrilateral") else 3
    p, c = box(
        cell, (8, 4) if d == 2 else (6, 2, 2), mapping=lambda x: ([2, 1, 1][:d] * x - np.eye(d)[-1] - 2 * np.eye(d)[0])
    )
    q, e = box(
        cell, (6, 3) if d == 2 else (4, 2, 2), mapping=lambda x: [0.8, 0.4, 0.4][:d] * x + [-0.3, 0.3, 0.01][3 - d :]
    )
    if d == 2:
        q[:, 0] -= 0.6
    points, cells = np.vstack([p, q]), np.vstack([c, e + len(p)])
    law = ir.Material(1e3, 0.3, 2.0, "plane_strain" if d == 2 else "3d", law="st_venant_kirchhoff")
    model = ir.Model(points, cells, cell, law)
    slave = facets_where(q, e, cell, lambda x: abs(x[-1] - 0.01) < 1e-9) + len(p)
    master = facets_where(p, c, cell, lambda x: abs(x[-1]) < 1e-9)
    v, arm = np.zeros_like(points), q - q.mean(0)
    v[len(p) :, 0] = spin * arm[:, -1] - speed
    v[len(p) :, -1] = -spin * arm[:, 0] - down
    return model, slave, master, v.reshape(-1)


@pytest.mark.covering(1)
@pytest.mark.parametrize("cell", CELLS)
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("touches", [False, True])
def test_who_comes_in_below_the_rim_brings_no_energy(cell, kind, touches):
    """touches: some nodes close through the surface before others come in from beside it."""
    model, slave, master, v0 = over_a_corner(cell, *((2.0, 0.5, 0.2) if touches else (1.0, 2.0, 0.3)))
    d = model.points.shape[1]
    dt = 0.8 * model.stable_step()
    run = model.run_explicit(dt, int(0.5 / dt), v0=v0, contacts=[kind(slave, master)])
    contact, e = run.contacts[0], run.energies
    start, mass = e["kinetic"][0], model.mass(lumped=True)[::d]
    # Nodes that are below the master and have been beside it.
    inside = (contact.gap < -0.02) & (contact.status == 0)
    assert inside.any(0).sum() >= (1 if d == 2 else 3)
    closed = contact.nodes[(contact.status > 0).any(0)]
    if not touches:
        assert (contact.force == 0).all()
        # Round-off of some 200 steps.
        assert np.abs(e["total"] - start).max() < 1e-13 * start
        return
    assert closed.size > 0
    # A node that closes as it passes the rim may lose or gain what its approach has.
    cost = np.sum(mass[closed] * v0.reshape(-1, d)[closed, -1] ** 2) / 2
    assert cost < 0.01 * start
    moving = e["kinetic"] + e["internal"]
    assert np.abs(e["total"] - start).max() < (cost if kind is ir.NodalPenalty else 1e-13 * start)
    assert moving.max() < start + cost
