# SPDX-License-Identifier: MIT
"""What the steppers of explicit and implicit runs tell and refuse, on a bar of four cells."""

import io
import sys

import numpy as np
import pytest
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact.dynamics.implicit.restart import ImplicitRestart
from dolfinx_impact.dynamics.implicit.stepper import ImplicitStepper
from dolfinx_impact.dynamics.progress import StepProgress
from dolfinx_impact.dynamics.step_schedule import StepSchedule
from dolfinx_impact.dynamics.time_stepper import MANY, TimeStepper
from dolfinx_impact.dynamics.transient_problem import TransientProblem

LAW = di.LinearElastic(100.0, 0.3, 1.0, "plane_strain")
KINDS = {"explicit": di.ExplicitProblem, "implicit": di.NewmarkProblem}


def bar(kind, speed=0.1):
    """A bar that flies freely along x."""
    domain = mesh.create_rectangle(MPI.COMM_SELF, [(0, 0), (4, 1)], (4, 1), mesh.CellType.quadrilateral)
    V = fem.functionspace(domain, ("Lagrange", 1, (2,)))
    velocity = fem.Function(V)
    velocity.interpolate(lambda x: (speed + 0 * x[0], 0 * x[0]))
    return KINDS[kind](fem.Function(V), LAW, velocity=velocity)


def stepper_of(problem):
    return problem._stepper if isinstance(problem, di.ExplicitProblem) else problem.stepper


@pytest.mark.parametrize("kind", KINDS)
def test_time_steps_and_histories_of_free_flight(kind):
    problem = bar(kind)
    assert isinstance(problem, TransientProblem) and (problem.time, problem.step) == (0.0, 0)
    problem.advance(0.1, dt=0.01, progress=False)
    assert problem.time == pytest.approx(0.1, rel=1e-14) and problem.step == 10
    assert len(problem.energy_history) == 11 - (kind == "explicit") and problem.force_history == []
    np.testing.assert_allclose(problem.energy_history[:, 1], 0.5 * 4 * 0.1**2, rtol=1e-10)  # kinetic
    assert problem.u.x.array[::2] == pytest.approx(0.01, rel=1e-10)


@pytest.mark.parametrize("kind", KINDS)
def test_a_callback_that_writes_to_the_motion_is_refused_and_undone(kind):
    problem = bar(kind)
    assert isinstance(stepper_of(problem), TimeStepper if kind == "explicit" else ImplicitStepper)

    def write(p):
        p.u.x.array[:] = 5.0

    with pytest.raises(ValueError, match="has written to u: the motion is that of the integrator"):
        problem.advance(0.1, dt=0.01, callback=write, progress=False)
    assert np.abs(problem.u.x.array).max() < 0.1
    assert not stepper_of(problem).recorders
    problem.advance(0.2, dt=0.01, progress=False)  # it can go on
    assert problem.u.x.array[::2] == pytest.approx(0.02, rel=1e-9)


def test_what_an_explicit_stepper_says_and_asks():
    problem = bar("explicit")
    stepper = stepper_of(problem)
    assert stepper.room() == MANY and stepper.schedule is None and stepper.watch is None and not stepper.deformed
    assert not stepper.asked(None)  # nothing runs
    assert stepper.table(np.array([0.0, 1.0])).size == 0
    # Courant's condition of squares of side 1: below h over the wave speed.
    speed = np.sqrt(LAW.p_wave_modulus / LAW.density)
    assert 0.3 / speed < stepper.safe_step < 1.0 / speed
    for kind, error in (("value", ValueError), ("failure", RuntimeError)):
        with pytest.raises(error, match="thrown by all"):
            TimeStepper._raise((kind, "thrown by all"))
    TimeStepper._raise(None)
    stepper.check_unchanged()
    problem.u.function_space.mesh.geometry.x[0, 0] -= 0.1
    with pytest.raises(ValueError, match="the mesh was changed"):
        stepper.check_unchanged()


def test_an_implicit_problem_goes_on_from_a_file(tmp_path):
    first, second = bar("implicit"), bar("implicit")
    first.advance(0.05, dt=0.01, progress=False)
    first.save(tmp_path / "state.h5")
    second.restore(tmp_path / "state.h5")
    assert second.time == first.time and np.array_equal(second.u.x.array, first.u.x.array)
    assert ImplicitRestart.more == ("functions of time",)
    with pytest.raises(ValueError):
        bar("explicit").restore(tmp_path / "state.h5")


@pytest.mark.parametrize("wanted", [True, False])
def test_progress_is_shown_where_it_is_wanted(wanted, monkeypatch):
    monkeypatch.setattr("dolfinx_impact.common.progress_lines.FIRST", 0.0)
    out = io.StringIO()
    monkeypatch.setattr(sys, "stdout", out)
    schedule = StepSchedule(1.0, 3.0, 10, 20)
    with StepProgress(MPI.COMM_SELF, schedule, wanted) as shown:
        shown.show_step(15, 2.0, 0.2, 1e-3)
    line = "50%: step 15  t = 2  dt = 0.2, drift +1.0e-03, 0 s\n"
    assert out.getvalue() == (line if wanted else "")
