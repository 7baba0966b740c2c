# SPDX-License-Identifier: MIT
"""Equal steps between two times: numbers, lengths and ends in closed form, and those of a run."""

import numpy as np
import pytest
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact.dynamics.step_schedule import StepSchedule


@pytest.mark.parametrize("begin, until, first, count", [(0.0, 1.0, 0, 3), (0.7, 0.8, 41, 7), (1e-3, 2.0, 10**6, 11)])
def test_steps_are_equal_and_end_exactly_there(begin, until, first, count):
    schedule = StepSchedule(begin, until, first, first + count)
    times = np.array([schedule.time(first + k) for k in range(count + 1)])
    assert times[0] == begin and times[-1] == until
    assert schedule.dt == pytest.approx((until - begin) / count, rel=1e-14)
    np.testing.assert_allclose(np.diff(times), schedule.dt, rtol=1e-9)


def test_schedules_are_the_same_if_all_of_them_is():
    one = StepSchedule(begin=0.0, until=1.0, first=0, last=4, auto=True)
    assert (one.begin, one.until, one.first, one.last, one.auto) == (0.0, 1.0, 0, 4, True)
    assert one == StepSchedule(0.0, 1.0, 0, 4, True)
    for other in ((0.1, 1.0, 0, 4, True), (0.0, 2.0, 0, 4, True), (0.0, 1.0, 1, 4, True), (0.0, 1.0, 0, 5, True)):
        assert one != StepSchedule(*other)
    assert one != StepSchedule(0.0, 1.0, 0, 4)


def test_a_run_takes_as_many_equal_steps_as_its_length_asks_for():
    """Ten lengths of 0.3 are three steps more than nine tenths; the step is shortened, and never longer than asked."""
    domain = mesh.create_unit_square(MPI.COMM_SELF, 2, 2, mesh.CellType.quadrilateral)
    V = fem.functionspace(domain, ("Lagrange", 1, (2,)))
    law = di.LinearElastic(1.0, 0.3, 1.0, "plane_strain")
    run = di.ExplicitProblem(fem.Function(V), law, velocity=fem.Function(V))
    times, dt = [], 0.9 * run.stable_step()
    until = 9.5 * dt
    run.advance(until, dt=dt, callback=lambda problem: times.append(problem.time), progress=False)
    schedule = StepSchedule(0.0, until, 0, 10)
    assert times == [schedule.time(k) for k in range(11)]
    assert schedule.dt <= dt
