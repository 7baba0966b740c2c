# SPDX-License-Identifier: MIT
"""Methods that do not converge stop; the error says what did not converge and what to do."""

import numpy as np
import pytest
from dolfinx import fem
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact import meshes
from dolfinx_impact.contact.penalty.facets import MARGIN, WIDEST, FacetKeeper
from dolfinx_impact.contact.mortar.lagrange import LagrangeContact
from dolfinx_impact.statics.active_set_iteration import RepeatedStates
from dolfinx_impact.statics.load_steps import Increment
from dolfinx_impact.statics.snes import Solver


class Blocks:
    """A block pressed on another one by 1/100 of its height."""

    def __init__(self, method, friction=0.0):
        m = meshes.make("two_blocks", MPI.COMM_SELF, lower_cells=(4, 2), upper_cells=(5, 2))
        V = fem.functionspace(m.mesh, ("Lagrange", 1, (2,)))
        self.u = fem.Function(V)
        ends = [fem.locate_dofs_topological(V, 1, m.facet_tags.find(m.tags[n])) for n in ("bottom", "top")]
        bcs = [fem.dirichletbc(np.array([0.0, d]), dofs, V) for d, dofs in zip((0.0, -0.005), ends)]
        pair = di.ContactPair(m.facet_tags, m.tags["slave_surface"], m.tags["master_surface"], friction=friction)
        law = di.LinearElastic(1e3, 0.3, 1.0, "plane_strain")
        self.problem = di.StaticProblem(self.u, law, bcs=bcs, contact=[method(pair)])


@pytest.mark.timeout(60)
def test_uzawa_with_a_small_penalty_ends():
    """A penalty of 1/100 of the stiffness per area takes a hundredth of the penetration away at a time."""
    blocks = Blocks(lambda pair: di.Penalty(pair, penalty=20.0, augmented=True, max_augmentations=12))
    with pytest.raises(RuntimeError) as error:
        blocks.problem.solve()
    text = str(error.value)
    for part in (
        "after 12 augmentations the penetration is",
        "more are needed",
        "penalty is 2.000e+01",
        "penalty='auto'",
    ):
        assert part in text
    assert "smaller parts" not in text, "the load is not what is too large"
    assert np.all(blocks.u.x.array == 0.0)


def test_uzawa_converges_with_as_many_rounds_as_were_said():
    """It is a forecast from the first rounds, in which pressures still move: twice as many are enough."""
    few = Blocks(lambda pair: di.Penalty(pair, penalty=2e4, augmented=True, max_augmentations=3))
    with pytest.raises(RuntimeError, match="some [0-9]+ more are needed") as error:
        few.problem.solve()
    more = int(str(error.value).split("some ")[1].split()[0])
    enough = Blocks(lambda pair: di.Penalty(pair, penalty=2e4, augmented=True, max_augmentations=3 + 2 * more))
    assert enough.problem.solve().converged
    assert 3 < enough.problem.contact[0].uzawa.rounds <= 3 + 2 * more


@pytest.mark.parametrize("value", (-1, 1.5, "2", True))
def test_cut_backs_and_augmentations_are_whole_numbers(value):
    blocks = Blocks(di.Lagrange)
    with pytest.raises((TypeError, ValueError), match="cut_backs"):
        blocks.problem.solve(cut_backs=value)
    pair = blocks.problem.contact[0].pair
    with pytest.raises((TypeError, ValueError), match="max_augmentations"):
        di.Penalty(pair, augmented=True, max_augmentations=value)


def test_increments_of_round_off_are_refused(monkeypatch):
    """Cut back for ever, an increment gets no smaller than what can be added to the way."""
    blocks = Blocks(di.Lagrange)
    monkeypatch.setattr("dolfinx_impact.statics.newton.Newton.run", lambda *args: Increment().failed("no"))
    with pytest.raises(RuntimeError, match="round-off: ask for fewer cut_backs"):
        blocks.problem.solve(cut_backs=10000)


def test_a_condition_that_stays_violated_is_named(monkeypatch):
    """Nothing changes any more, but a gap stays: the error says which, and cutting back is not tried."""
    blocks = Blocks(di.Lagrange)
    monkeypatch.setattr(LagrangeContact, "violation", lambda self: 1e-3)
    with pytest.raises(RuntimeError) as error:
        blocks.problem.solve(max_iterations=5)
    text = str(error.value)
    assert "a gap of an active node, number " in text and " at (" in text
    assert "smaller parts" not in text and "the residual is" not in text


def test_too_few_iterations_say_what_is_left():
    blocks = Blocks(lambda pair: di.Penalty(pair, penalty=1e5))
    with pytest.raises(RuntimeError, match="the residual is .*smaller parts"):
        blocks.problem.solve(max_iterations=1, cut_backs=1)


def test_a_report_counts_rejected_iterations(monkeypatch):
    blocks = Blocks(lambda pair: di.Penalty(pair, penalty=1e5))
    run, count = Solver.run, []

    def fail_once(self, *args):
        result = run(self, *args)
        count.append(result.iterations)
        return result.failed("once") if len(count) == 1 else result

    monkeypatch.setattr(Solver, "run", fail_once)
    report = blocks.problem.solve()
    assert report.rejected_iterations == count[:1] and report.iterations == count[1:]
    assert f"after {count[0]} iterations" in report.table()


def test_cycles_of_two_and_three_are_seen():
    """Twice the same states, to 1e-3 of the residual; not: a residual that rests or falls."""

    def increment(norms, sizes=None):
        made = Increment()
        for k, norm in enumerate(norms):
            made.add(norm, 8 if sizes is None else sizes[k], 0)
        return made.cycle()

    assert increment([5.0, 0.18, 0.22, 0.18, 0.22]) == 2
    assert increment([0.3, 0.1, 0.2] * 2) == 3
    assert increment([0.18, 0.22, 0.18]) == 0
    assert increment([0.2] * 9) == 0
    assert increment(list(0.5 ** np.arange(9))) == 0
    assert increment([0.18, 0.22] * 2, [8, 9, 8, 8]) == 0


class Points:
    """Two points; the facets they are on."""

    size, margin = 2, None

    def __init__(self):
        self.master = np.array([16, 3])


class Search:
    kept = True


def test_points_that_come_back_stay_farther():
    """A point to and fro between facets 16 and 17 may stay farther beside each time, up to the widest; others not."""
    points = Points()
    keeper = FacetKeeper(MPI.COMM_SELF, points, Search())
    closed = np.array([True, True])
    moved = []
    for k in range(12):
        points.master = np.array([16 + k % 2, 3])
        moved.append(keeper.watch(closed))
    assert moved == [0] + 11 * [1]
    assert points.margin.tolist() == [WIDEST, MARGIN]
    keeper.begin()
    assert points.margin.tolist() == [MARGIN, MARGIN]


def test_a_return_ends_the_iterations_without_staying():
    points = Points()
    keeper = FacetKeeper(MPI.COMM_SELF, points, Search())
    assert keeper.leave() and not keeper.stay and not keeper.leave()
    for facet in (16, 17, 16):
        assert not keeper.stay
        points.master = np.array([facet, 3])
        keeper.watch(np.array([True, True]))
    assert keeper.stay


def test_linearised_problems_without_an_active_set_are_seen_after_three():
    """Left with wrong nodes three times at one residual, or at the two of a cycle; not while the residual falls."""

    def stalled(norms, unsettled):
        made = Increment(unsettled_in_succession=unsettled)
        for norm in norms:
            made.add(norm, 8, 1)
        return made.stalled()

    assert stalled([1e-15, 6e-2, 2.4e-2, 2.4e-2, 2.4e-2], 4)
    assert stalled([1e-15, 2.4e-2, 6e-2, 2.4e-2], 3)
    assert not stalled([1e-15, 6e-2, 2.4e-2], 2)
    assert not stalled([1e-15, 6e-2, 2.4e-2, 2.4e-2], 3)
    assert not stalled([2.4e-2] * 9, 0)


class Flipping:
    """A contact whose second node sticks and slips by turns, as the first one finds its pressure, or goes on to."""

    def __init__(self, drift=0.0):
        self.active, self.sliding = np.array([True, True]), np.array([False, False])
        self.multiplier, self._drift = np.array([3.0, 1.0]), drift

    def change(self):
        self.sliding[1] = not self.sliding[1]
        self.multiplier = self.multiplier * (1.0 + self._drift)


@pytest.mark.parametrize("later", (0, 1, 2, 3))
def test_updates_that_go_round_end_at_one_state_and_the_next_time_at_the_other(later):
    contact, repeated = Flipping(), RepeatedStates(MPI.COMM_SELF, later)
    for count in range(1, 20):
        contact.change()
        if repeated.stops([contact]):
            break
    assert count == 3 + later % 2 and contact.sliding[1] == (later % 2 == 0)


def test_updates_that_still_change_the_pressures_go_on():
    contact, repeated = Flipping(drift=1e-3), RepeatedStates(MPI.COMM_SELF)
    for _ in range(20):
        contact.change()
        assert not repeated.stops([contact])
