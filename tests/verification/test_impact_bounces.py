# SPDX-License-Identifier: MIT
"""A bar that falls on a rigid floor and bounces: what repeated impacts cost. `python test_impact_bounces.py` prints the
table of docs/explicit/accuracy.md, "What an impact costs".

Wave solution of the first impact, with the speed V and the weight small (g L < V c/2): contact lasts 2 L/c, its impulse
turns the velocity of the mass centre round to V; the bar comes back after 2 V/g.
"""

import numpy as np
import pytest
from impact_model import BOTH, Impact, enforce

import dolfinx_impact as di

SPEED = 0.1  # V/c: all is proportional to it
GRAVITY, BOUNCES = 0.05, 10  # the former of V c/L
PERIOD = 2 / GRAVITY + 2  # of the wave solution [L/c]


class Bar(Impact):
    """A bar of n cells in a row, of length, density and wave speed 1, that falls along x.

    Args:
        gap: time until its lower end reaches the floor, in times that a wave takes through a cell.
    """

    def __init__(self, n, gap=5.513, gravity=GRAVITY, height=None):
        self.n, self.gap = n, gap / n
        self.height = height or 1 / n
        super().__init__(
            "block", di.LinearElastic(1.0, 0.0, 1.0, "plane_strain"), size=(1.0, self.height), cells=(n, 1)
        )
        self.throw(np.arange(len(self.X)), (-SPEED, 0.0))
        if gravity:
            self.loads = [di.BodyForce((-gravity * SPEED, 0.0))]
        self.floor = di.RigidPlane((-self.gap * SPEED, 0.0), (1.0, 0.0))

    def problem(self, method):
        return self.explicit(enforce(method, self.pair("left", self.floor)))

    def bounce(self, method, bounces=BOUNCES, release=True):
        """Run until shortly before the next impact.

        Args:
            release: whether opening nodes get the absorbed energy back.
        """
        problem = self.problem(method)

        def take_it_all(p):
            side = p.contact[0].sides()[0]
            state = side.saved_state()
            state.array("absorbed_energy")[:] = 0.0
            side.resume(state)

        until = self.gap + bounces * PERIOD - 0.8 / GRAVITY
        problem.advance(until, callback=None if release else take_it_all, progress=False)
        return problem


def impacts(problem, area):
    """Dict of arrays by impact: begin, duration [of 2 L/c], impulse [of 2 M V], plateau (mean force over the middle)
    and largest force [of rho c V A]."""
    force, t = problem.force_history[0][:, 0] / (area * SPEED), problem.energy_history[:, 0]
    on = np.flatnonzero(force > 0)
    first = on[np.flatnonzero(np.diff(t[on], prepend=-9.0) > 1.0)]
    last = np.append(on[np.flatnonzero(np.diff(t[on]) > 1.0)], on[-1])
    out = {name: [] for name in ("begin", "duration", "impulse", "plateau", "largest")}
    for a, z in zip(first, last):
        middle = (t > t[a] + 0.2 * (t[z] - t[a])) & (t < t[z] - 0.2 * (t[z] - t[a]))
        values = t[a], (t[z] - t[a]) / 2, np.trapezoid(force[a : z + 1], t[a : z + 1]) / 2, force[middle].mean()
        for name, value in zip(out, (*values, force[a : z + 1].max())):
            out[name].append(value)
    return {name: np.array(values) for name, values in out.items()}


def test_ten_bounces():
    """Kinematic contact stops half a cell of 200 at every impact: 1/400 of the energy, 2.5 % in ten. The releases give
    back more than half of it. Contacts last 2 L/c within 1 %. The bar is back on time within 1 % for the first five, a
    third more for all ten: waves that the mesh disperses keep some of the energy as vibration."""
    bar = Bar(200)
    problem = bar.bounce("Kinematic")
    found, energies = impacts(problem, bar.height), problem.energy_history[:, 1:]
    start = energies[0, 0]
    lost = energies[:, 4] / start
    assert len(found["begin"]) == BOUNCES
    assert problem.energy["impact"] / start == pytest.approx(lost[-1], abs=1e-12)
    assert lost.min() > -1e-12 and lost[-1] < 0.5 * BOUNCES / 400
    assert lost.max() > 1 / 400 * 0.9, "what is taken shows while the contact lasts"
    assert not energies[:, 2].any(), "kinematic contact stores nothing"
    assert np.abs(found["duration"] - 1).max() < 0.01
    late = np.abs(found["begin"] - bar.gap - PERIOD * np.arange(BOUNCES)) / PERIOD
    assert np.all(late[:6] < 0.01 * np.arange(6) + bar.gap / PERIOD) and late[-1] < 0.0134 * (BOUNCES - 1)
    # Of the first impact: the mean speed of a wall that falls towards the bar is 1 + g L/c.
    assert found["plateau"][0] == pytest.approx(1 + GRAVITY, rel=0.01)
    assert found["impulse"][0] == pytest.approx(1 + GRAVITY, rel=0.002)
    # Round-off of 91,000 steps.
    total = energies[:, :-1].sum(axis=1) - energies[:, -1]
    assert np.abs(total - total[0]).max() < 1e-11 * start


def test_without_release_half_a_cell_is_lost_at_every_impact():
    bar = Bar(50)
    lost = {}
    for release in (True, False):
        energies = bar.bounce("Kinematic", 2, release).energy_history[:, 1:]
        lost[release] = energies[-1, 4] / energies[0, 0]
    assert lost[False] > 0.8 * 2 / 100 and lost[True] < 0.5 * lost[False]


def test_wave_solution_at_courant_number_one():
    """With steps of h/c, in which nothing disperses, and a floor reached at the end of a step, nodes move as the wave
    solution does: afterwards all with the speed that they came with."""
    n = 20
    bar = Bar(n, gap=3 * (1 - 1e-9), gravity=0.0, height=10.0)  # tall: no mode across is faster than h/c allows
    problem = bar.problem("Kinematic")
    dt = 1 / n
    assert problem.stable_step() == pytest.approx(dt, rel=0.01)
    with pytest.warns(UserWarning, match="beyond the stable step"):
        problem.advance((3 + 2 * n + 5) * dt, dt=dt, progress=False, unsafe=True)
    v = problem.velocity.x.array.reshape(-1, 2)
    # The step over the limit, on account of shear, lets errors of 1e-16 grow over 48 steps.
    np.testing.assert_allclose(v[:, 0], SPEED, rtol=1e-7)
    history = problem.energy_history
    assert history[:, 5].max() == pytest.approx(
        0.5 * bar.height / n / 2 * SPEED**2, rel=1e-6
    )  # half a cell's, while it lasts
    assert abs(problem.energy["impact"]) < 1e-7 * history[0, 1]
    np.testing.assert_allclose(problem.force_history[0][5 : 3 + 2 * n - 2, 0], bar.height * SPEED, rtol=1e-6)


def rows(n=100):
    """Figures of the table, by enforcement: dict."""
    out = {}
    for name, method, release in (("penalty", *BOTH[:1], True), ("kinematic", BOTH[1], True), ("none", BOTH[1], False)):
        bar = Bar(n)
        problem = bar.bounce(method, release=release)
        found, energies = impacts(problem, bar.height), problem.energy_history[:, 1:]
        found = {name: values[:BOUNCES] for name, values in found.items()}
        total = energies[:, :-1].sum(axis=1) - energies[:, -1]
        out[name] = {
            "lost per bounce [%]": 100 * (energies[-1, 4] + total[0] - total[-1]) / energies[0, 0] / BOUNCES,
            "contact time, first": found["duration"][0],
            "contact time, all": (found["duration"].min(), found["duration"].max()),
            "impulse, first": found["impulse"][0] / (1 + GRAVITY),
            "impulse, last": found["impulse"][-1] / (1 + GRAVITY),
            "tenth impact": (found["begin"][9] - bar.gap) / (9 * PERIOD),
            "plateau, first": found["plateau"][0] / (1 + GRAVITY),
            "largest force, first": found["largest"][0] / (1 + GRAVITY),
        }
    return out


if __name__ == "__main__":
    for cells in (100, 200):
        table = rows(cells)
        print(f"{cells} cells")
        for figure in table["penalty"]:
            values = (np.round(np.atleast_1d(table[name][figure]), 4).tolist() for name in table)
            print(f"  {figure:24s}", *(f"{str(v):20s}" for v in values))
