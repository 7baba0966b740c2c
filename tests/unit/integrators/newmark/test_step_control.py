# SPDX-License-Identifier: MIT
"""Lengths of implicit steps."""

import pytest

from dolfinx_impact._cpp.integrators import StepControl

FEW, MANY = StepControl.few, StepControl.many


def take(control, goal, iterations=3, error=None, limit=1000):
    """Lengths and ends of the steps to a time, all of which converge at once."""
    time, steps = 0.0, []
    while time < goal:
        assert len(steps) < limit
        step, time = control.next(time, goal)
        steps.append(step)
        control.choose_next_step(step, iterations, error(step) if error else None)
    assert time == goal  # exactly
    return steps


def test_equal_steps_are_the_same_number():
    """Round-off must not make a new matrix in every step."""
    steps = take(StepControl(0.1, 1e-4), 0.7)
    assert len(steps) == 7 and len(set(steps)) == 1


def test_a_goal_between_two_steps_divides_the_way():
    steps = take(StepControl(0.1, 1e-4), 0.25)
    assert len(steps) == 3 and steps == [pytest.approx(0.25 / 3)] * 3


def test_failed_steps_are_halved_and_grow_again():
    control = StepControl(0.1, 0.02)
    assert control.failed(0.1) and control.length == 0.05
    assert control.failed(0.05) and not control.failed(0.025)
    control.length = 0.025
    control.choose_next_step(0.025, FEW, None)
    assert control.length == 0.05
    control.choose_next_step(0.05, FEW + 1, None)  # neither easy nor hard: as it was
    assert control.length == 0.05
    control.choose_next_step(0.05, FEW, None)
    control.choose_next_step(0.1, FEW, None)
    assert control.length == 0.1  # never more than the largest


def test_many_iterations_shorten_the_next_step():
    control = StepControl(0.1, 0.02)
    control.choose_next_step(0.1, MANY + 1, None)
    assert control.length == 0.05


def test_steps_settle_where_the_error_is_the_tolerance():
    """An error of 8 h^3 is 1e-3 at h = 0.05; the safety factor keeps it below."""
    control = StepControl(1.0, 1e-6, tolerance=1e-3)
    steps = take(control, 10.0, error=lambda step: 8.0 * step**3)
    assert steps[-1] == pytest.approx(0.9 * 0.05, rel=0.05)


def test_large_errors_repeat_the_step():
    control = StepControl(1.0, 1e-6, tolerance=1e-3)
    assert control.accepts(0.05, 1e-3) and control.accepts(0.05, 1.9e-3)
    assert not control.accepts(0.1, 8e-3)
    assert control.length == pytest.approx(0.9 * 0.05)
    assert control.accepts(1e-6, 1.0)  # the smallest step is taken as it is
    assert StepControl(1.0, 1e-6).accepts(1.0, 1e9)  # without a tolerance there is nothing to judge by
