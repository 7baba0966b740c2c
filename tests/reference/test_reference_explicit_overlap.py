# SPDX-License-Identifier: MIT
"""The overlap of a step in explicit penalty contact of the hand-written solver: closing between two steps, the rim."""

from fractions import Fraction

import impact_reference as ir
import numpy as np
import pytest
from contact_tip import Tip
from spring_energy_balance import SpringEnergyBalance
from test_reference_explicit_contact import single_mass, wall


def flight(kappa, start, num_steps):
    """A mass 1 with the speed 1, steps of 1, `start` before a wall with the spring kappa: displacements and forces."""
    model, free, right = single_mass()
    v0 = np.zeros(8)
    v0[free] = 1.0
    contact = ir.NodalPenalty(right, wall(1.0 + start), penalty=2 * kappa)  # the node's area is 1/2
    return (
        model,
        free,
        model.run_explicit(1.0, num_steps, v0=v0, fixed_dofs=np.delete(np.arange(8), free), contacts=[contact]),
    )


def test_mass_on_a_spring_step_by_step():
    """In fractions: the spring is the half of the one that a step of 1 can bear twice over, kappa = 1/2."""
    _, free, run = flight(0.5, 1.25, 9)
    u, v, forces, places, overlaps, spring = Fraction(0), Fraction(1), [], [], [], SpringEnergyBalance(0.5)
    before, g_before = u, None
    for n in range(10):
        g, r = Fraction(5, 4) - u, before - u  # out of the wall
        half = abs(r) / 2
        # Integral of <-g>, by areas of triangles.
        low, high = g - half, g + half
        area = (low**2 if low < 0 else 0) / Fraction(2) - (high**2 if high < 0 else 0) / Fraction(2)
        overlap = area / abs(r) if r else max(-g, Fraction(0))
        force = overlap / 2
        # By hand: the force that would leave the wall with more than it has taken is the one before the last.
        bounded = spring.normal_force(float(g), float(g - g_before if spring.closed else r), float(overlap))
        if bounded < float(force):
            force = Fraction(bounded)
        g_before = g
        places.append(u)
        overlaps.append(overlap)
        forces.append(force)
        v -= (1 if n else Fraction(1, 2)) * force
        before, u = u, u + v
    assert sum(2 * f < d for f, d in zip(forces, overlaps)) == 1
    # The cell's own stiffness is 1e-9.
    assert np.allclose(run.u[:, free], np.array(places, dtype=float), rtol=0, atol=1e-7)
    assert np.allclose(-run.contacts[0].total[:, 0], np.array(forces, dtype=float), rtol=0, atol=1e-7)
    assert (run.contacts[0].status[:, -1] > 0).tolist() == [x > 0 for x in overlaps]
    stored = np.array([f * f for f in forces], dtype=float)
    assert np.allclose(run.energies["contact"], stored, rtol=0, atol=1e-7)


@pytest.mark.parametrize(
    "kappa, lowest, highest, rms, num_steps", [(0.5, -1.2, 0.4, 0.8, 12), (0.1, -0.06, 0.0, None, 20)]
)
def test_energy_of_closing_between_two_steps(kappa, lowest, highest, rms, num_steps):
    """docs/explicit/accuracy.md, "What closing between two steps costs", in per cent."""
    change = []
    for k in range(400):
        _, free, run = flight(kappa, 1 + (k + 0.5) / 400, num_steps)
        assert run.contacts[0].status[-1].max() == 0 and run.v_half[-1, free] < 0
        change.append(100 * (run.v_half[-1, free] ** 2 - 1))
    change = np.array(change)
    digit = 0.05 if kappa == 0.5 else 0.005  # the table is rounded
    assert abs(change.min() - lowest) <= digit and abs(change.max() - highest) <= digit
    assert rms is None or abs(np.sqrt(np.mean(change**2)) - rms) <= digit


def overlap(g, r):
    """By an antiderivative of <-g>."""
    low, high = min(g - abs(r) / 2, 0), min(g + abs(r) / 2, 0)
    return (low**2 - high**2) / (2 * abs(r)) if r else max(-g, 0.0)


@pytest.mark.parametrize("cell", ["quadrilateral", "triangle", "hexahedron", "tetrahedron"])
@pytest.mark.parametrize("x", [0.9, 1.0, 1.005, 1.045, 1.06, 1.08, 1.2])
def test_who_passes_beside_an_edge_is_not_pushed(cell, x):
    """Over the facet and on its edge; beside it by less than a twentieth of the facet (1, or the diagonal), where gap
    and normal are the facet's, above and below; beyond."""
    heights = np.array([0.1, 0.02, -0.02, -0.025, 0.01, 0.1, 0.1])
    d = 2 if cell in ("triangle", "quadrilateral") else 3
    path = np.tile([x, 0.4, 0.0][: d - 1] + [0.0], (7, 1))
    path[:, -1] = heights
    tip = Tip(cell, path)
    run = tip.run(ir.NodalPenalty(tip.slave, tip.master, penalty=3.0))
    force = run.contacts[0].force.reshape(6, -1, d)[:, tip.node]
    expected = np.array([overlap(g, r) for g, r in zip(heights[:6], np.diff(heights, prepend=0.1))])
    assert (expected > 0).tolist() == [False, True, True, True, True, False]
    beyond = x - 1 > 0.05 * (d - 1) ** 0.5
    gap = run.contacts[0].gap[:, tip.row(run)]
    if beyond:
        expected[:] = 0
        lever = 1.0
        assert np.isinf(gap[2:4]).all() and np.allclose(gap[heights[:6] > 0], np.hypot(heights[[0, 1, 4, 5]], x - 1))
    else:
        lever = force[2, -1] / expected[2]
        assert np.allclose(gap, heights[:6], rtol=0, atol=1e-14)
    assert lever > 0
    assert np.allclose(force[:, -1], lever * expected, rtol=0, atol=1e-14)
    assert np.abs(force[:, :-1]).max() < 1e-14
    assert (run.contacts[0].status[:, tip.row(run)] > 0).tolist() == (expected > 0).tolist()


@pytest.mark.parametrize("cell", ["quadrilateral", "triangle", "hexahedron", "tetrahedron"])
def test_edges_inside_the_master_are_no_rim(cell):
    """Over the ridge of a roof: along the way to the ridge, before it is reached."""
    d = 2 if cell in ("triangle", "quadrilateral") else 3
    path = np.tile([0.502, 0.4, 0.0][: d - 1] + [0.0], (3, 1))
    path[:, -1] = [0.1, 0.02, 0.02]
    tip = Tip(cell, path, roof=0.5)
    run = tip.run(ir.NodalPenalty(tip.slave, tip.master, penalty=3.0))
    force = run.contacts[0].force.reshape(2, -1, d)[1, tip.node]
    gap = np.hypot(0.002, 0.02)
    n = np.zeros(d)
    n[0], n[-1] = 0.002 / gap, 0.02 / gap
    size = {"quadrilateral": 0.2, "triangle": 0.2, "hexahedron": 0.2**2, "tetrahedron": 0.2**2 / 2}[cell]
    k = 3.0 * np.sum(tip.slave == tip.node) * size / tip.slave.shape[1]  # equal shares of the facets at the tip
    expected = overlap(gap, -0.08 * n[-1])
    assert expected > 0
    assert np.isclose(run.contacts[0].gap[1, tip.row(run)], gap, rtol=1e-12)
    assert np.allclose(force, k * expected * n, rtol=0, atol=1e-14)
