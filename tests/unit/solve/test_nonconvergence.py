# SPDX-License-Identifier: MIT
"""Methods that do not converge stop; the error says what did not converge and what to do."""

from types import SimpleNamespace

import numpy as np
import pytest
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact import _cpp, meshes
from dolfinx_impact._cpp.penalty import FacetKeeper
from dolfinx_impact.common.interrupts import Interrupts
from dolfinx_impact.contact.mortar.lagrange import LagrangeContact
from dolfinx_impact.statics.load_steps import Limits, run_steps
from dolfinx_impact.statics.progress import SolveProgress


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


class FailingSolver:
    """Solves increments as the problem's own solver does, and calls the first `failures` of them failed.

    Attributes:
        count: iterations of each increment.
    """

    def __init__(self, problem, failures):
        self._problem = problem
        self._solver = _cpp.solve.IncrementSolver(problem.equilibrium, 1e-10, 0.0, 25, None, None, None)
        self.count, self._failures = [], failures

    def run(self, cut_backs):
        """Report of one load step."""
        limits = Limits(1, cut_backs, 1e-10, 0.0, 25)
        with Interrupts(MPI.COMM_SELF) as interrupts:
            return run_steps(self._problem, self._solve, limits, interrupts, False)

    def _solve(self, steps, rtol, atol, max_iterations, cut_backs, log, begins, accepted, **told):
        return self._problem._cpp_object.solve_by(self._increment, steps, cut_backs, log, begins, accepted)

    def _increment(self, goal):
        result = self._solver.run(goal)
        self.count.append(result.iterations)
        return result.failed("no") if len(self.count) <= self._failures else result


def test_increments_of_round_off_are_refused():
    """Cut back for ever, an increment gets no smaller than what can be added to the way."""
    problem = Blocks(di.Lagrange).problem
    with pytest.raises(RuntimeError, match="round-off: ask for fewer cut_backs"):
        FailingSolver(problem, 10000).run(10000)


def test_a_condition_that_stays_violated_is_named(monkeypatch, contacts_in_python):
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


def test_a_report_counts_rejected_iterations():
    problem = Blocks(lambda pair: di.Penalty(pair, penalty=1e5)).problem
    solver = FailingSolver(problem, 1)
    report = solver.run(8)
    assert report.rejected_iterations == solver.count[:1] and report.iterations == solver.count[1:]
    assert f"after {solver.count[0]} iterations" in report.table()


def test_cycles_of_two_and_three_are_seen():
    """Twice the same states, to 1e-3 of the residual; not: a residual that rests or falls."""

    def increment(norms, sizes=None):
        made = _cpp.solve.Increment()
        for k, norm in enumerate(norms):
            made.add(norm, 8 if sizes is None else sizes[k], 0)
        return made.cycle()

    assert increment([5.0, 0.18, 0.22, 0.18, 0.22]) == 2
    assert increment([0.3, 0.1, 0.2] * 2) == 3
    assert increment([0.18, 0.22, 0.18]) == 0
    assert increment([0.2] * 9) == 0
    assert increment(list(0.5 ** np.arange(9))) == 0
    assert increment([0.18, 0.22] * 2, [8, 9, 8, 8]) == 0


def test_points_that_come_back_stay_farther():
    """A point to and fro between facets 16 and 17 may stay farther beside each time, up to the widest; others not."""
    keeper, margins = FacetKeeper(MPI.COMM_SELF), np.zeros(2)
    keeper.begin(margins)
    moved = [keeper.watch(np.array([16 + k % 2, 3], dtype=np.int32), True, margins) for k in range(12)]
    assert moved == [0] + 11 * [1]
    assert margins.tolist() == [FacetKeeper.widest, FacetKeeper.margin]
    keeper.begin(margins)
    assert margins.tolist() == [FacetKeeper.margin, FacetKeeper.margin]


def test_a_return_ends_the_iterations_without_staying():
    keeper, margins = FacetKeeper(MPI.COMM_SELF), np.zeros(2)
    keeper.begin(margins)
    assert keeper.leave() and not keeper.stay and not keeper.leave()
    for facet in (16, 17, 16):
        assert not keeper.stay
        keeper.watch(np.array([facet, 3], dtype=np.int32), True, margins)
    assert keeper.stay


def test_linearised_problems_without_an_active_set_are_seen_after_three():
    """Left with wrong nodes three times at one residual, or at the two of a cycle; not while the residual falls."""

    def stalled(norms, unsettled):
        made = _cpp.solve.Increment(unsettled_in_succession=unsettled)
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

    pair, has_multipliers = SimpleNamespace(name="flipping", friction=0.3), True

    def __init__(self, drift=0.0):
        self.active, self.sliding = np.array([True, True]), np.array([False, False])
        self.multiplier, self._drift = np.array([3.0, 1.0]), drift

    def change(self):
        self.sliding[1] = not self.sliding[1]
        self.multiplier = self.multiplier * (1.0 + self._drift)


@pytest.mark.parametrize("later", (0, 1, 2, 3))
def test_updates_that_go_round_end_at_one_state_and_the_next_time_at_the_other(later):
    contact, repeated = Flipping(), _cpp.solve.RepeatedStates(MPI.COMM_SELF, later)
    seen = _cpp.solve.PythonContact(contact)
    for count in range(1, 20):
        contact.change()
        if repeated.stops([seen]):
            break
    assert count == 3 + later % 2 and contact.sliding[1] == (later % 2 == 0)


def test_updates_that_still_change_the_pressures_go_on():
    contact, repeated = Flipping(drift=1e-3), _cpp.solve.RepeatedStates(MPI.COMM_SELF)
    seen = _cpp.solve.PythonContact(contact)
    for _ in range(20):
        contact.change()
        assert not repeated.stops([seen])


@pytest.mark.parametrize("friction", (0.0, 0.3))
@pytest.mark.parametrize("method", (di.Lagrange, di.Penalty))
def test_a_body_above_the_floor_is_named_with_and_without_friction(method, friction):
    """Closer to the floor than a hundredth of a facet, it lands; along the floor nothing holds it until it has."""
    m = mesh.create_rectangle(MPI.COMM_SELF, [(0, 1e-3), (1, 1.001)], (5, 5), mesh.CellType.quadrilateral)
    V = fem.functionspace(m, ("Lagrange", 1, (2,)))
    facets = np.sort(mesh.locate_entities_boundary(m, 1, lambda x: np.isclose(x[1], 1e-3)))
    tags = mesh.meshtags(m, 1, facets, np.full(len(facets), 3, dtype=np.int32))
    pair = di.ContactPair(tags, 3, di.RigidPlane((0, 0), (0, 1)), friction=friction)
    law = di.LinearElastic(1e6, 0.3, 1000.0, "plane_strain")
    u, weight = fem.Function(V), di.BodyForce((0.0, -9.81))
    problem = di.StaticProblem(u, law, loads=[weight], contact=[method(pair)])
    with pytest.raises(RuntimeError, match=r"\(0.5, 0.501\) is free to move along x .*smallest gap 1.000e-03") as error:
        problem.solve()
    assert "pivots" not in str(error.value)


def test_tolerances_below_round_off():
    """Of a residual: the round-off counts, in a few iterations. Of errors and penetrations: refused."""
    blocks = Blocks(di.Lagrange)
    report = blocks.problem.solve(rtol=1e-30)
    assert max(report.iterations) < 10 and report.cut_backs == 0
    pair = blocks.problem.contact[0].pair
    with pytest.raises(ValueError, match="tolerance is 1e-30: penetrations below 1e-15"):
        di.Penalty(pair, augmented=True, tolerance=1e-30)
    V = blocks.u.function_space
    law = di.LinearElastic(1e3, 0.3, 1.0, "plane_strain")
    problem = di.NewmarkProblem(fem.Function(V), law, velocity=fem.Function(V))
    with pytest.raises(ValueError, match="tolerance is 1e-30: local errors below 1e-12"):
        problem.advance(1.0, dt=0.1, tolerance=1e-30, progress=False)


class Clock:
    """A clock that is set by hand."""

    time = 0.0

    def __call__(self):
        return self.time


def test_long_solves_say_how_far_they_are(capsys):
    """The first line after five seconds, then less and less often; none on other ranks or where it is not wanted."""
    clock, lines = Clock(), []
    progress = SolveProgress(MPI.COMM_SELF, True, clock)
    progress.begin(3, 0.5, 0.75)
    for second in range(3600):
        clock.time = float(second)
        progress.show(f"iteration {second}")
    lines = capsys.readouterr().err.splitlines()
    assert lines[0] == "static solve, 5 s: 50% of the way, increment 3 to 75%, iteration 5"
    assert 50 < len(lines) < 80
    silent = SolveProgress(MPI.COMM_SELF, False, clock)
    silent.begin(1, 0.0, 1.0)
    clock.time = 1e4
    silent.show("iteration")
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize("wanted", (True, False))
def test_solve_writes_its_progress(wanted, monkeypatch, capsys):
    monkeypatch.setattr("dolfinx_impact.common.progress_lines.FIRST", 0.0)
    monkeypatch.setattr("dolfinx_impact.common.progress_lines.LATER", 0.0)
    Blocks(di.Lagrange).problem.solve(steps=2, progress=wanted)
    text = capsys.readouterr().err
    assert ("50% of the way, increment 2 to 100%, iteration 1: residual" in text) == wanted
    assert wanted or text == ""
