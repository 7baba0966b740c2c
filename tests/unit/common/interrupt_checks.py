# SPDX-License-Identifier: MIT
"""Ctrl-C and exceptions while steps are being taken: all ranks stop after the same step. See on_ranks.py."""

import functools
import os
import signal
import threading
from unittest.mock import patch

import numpy as np
import pytest
from dolfinx import fem, mesh
from restart_checks import COMM, block_on_block, state
from shared_folder import shared_folder
from over_ranks import largest

import dolfinx_impact as di
from dolfinx_impact import _cpp
from dolfinx_impact.common.collective import common
from dolfinx_impact.common.interrupts import Interrupts
from dolfinx_impact.contact import in_cpp

LAST = COMM.rank == COMM.size - 1
VARIANTS = ({}, {"kind": di.Kinematic}, {"law": di.NeoHookean, "balanced": True})


def with_ctrl_c(check):
    """A check with Python's own handler of SIGINT. Where a shell starts the tests in the background (`make test &`,
    nohup) the signal is ignored, and what a process ignores, those that it starts ignore, too."""

    @functools.wraps(check)
    def checked():
        before = signal.signal(signal.SIGINT, signal.default_int_handler)
        try:
            check()
        finally:
            signal.signal(signal.SIGINT, signal.SIG_DFL if before is None else before)

    return checked


def press():
    """What Ctrl-C does, on the last rank only."""
    if LAST:
        signal.raise_signal(signal.SIGINT)


class Reached(Exception):
    pass


def reach():
    raise common(Reached())  # on all ranks


class At:
    """Calls something at a step, from among a problem's recorders: pieces end there only."""

    def __init__(self, problem, step, work):
        self.problem, self.step, self.work = problem, step, work
        problem._stepper.recorders.append(self)

    def steps_left(self):
        return self.step - self.problem.step if self.problem.step < self.step else 10**9

    def after(self):
        if self.problem.step == self.step:
            self.work()

    def add(self, rows):
        pass

    def flush(self):
        pass


def often_checked(**variant):
    """A problem whose stiffness is looked at again every 20 steps."""
    problem = block_on_block(**variant)
    problem._cpp_object.safe_step.longest_interval = 20
    return problem


def go_on_from(problem, end, variant, make=block_on_block):
    """States at the end of the run that was left, and of one that is restored from its checkpoint."""
    with shared_folder() as path:
        problem.save(path / "left.h5")
        again = make(**variant)
        again.restore(path / "left.h5")
        assert again.step == problem.step and again.time == problem.time
        np.testing.assert_array_equal(state(again), state(problem))
    for p in (problem, again):
        p.advance(end, progress=False)
    return state(problem), state(again)


@with_ctrl_c
def check_ctrl_c_within_a_piece():
    """Steps that C++ takes alone: the signal comes to one rank while it is at it. Functions, histories and checkpoint
    are those of the step that is told, and the run goes on bit for bit."""
    for variant in VARIANTS:
        problem = block_on_block(**variant)
        end = 1e6 * problem.stable_step()  # half a minute and more, if no signal came
        timer = threading.Timer(0.15, lambda: os.kill(os.getpid(), signal.SIGINT))
        At(problem, 1, timer.start if LAST else lambda: None)
        with pytest.raises(KeyboardInterrupt):
            problem.advance(end, progress=False)
        step = problem.step
        assert len(set(COMM.allgather(step))) == 1 and step > 1
        assert len(problem.energy_history) == step
        assert problem.time == problem._stepper.schedule.time(step)

        other = block_on_block(**variant)
        At(other, step, reach)
        with pytest.raises(Reached):
            other.advance(end, progress=False)
        assert other.time == problem.time
        np.testing.assert_array_equal(state(problem), state(other))
        for name in ("kinetic", "internal", "contact", "friction", "damping", "external"):
            assert problem.energy[name] == other.energy[name], name
        np.testing.assert_array_equal(problem.energy_history, other.energy_history)


@with_ctrl_c
def check_left_in_a_callback_and_gone_on():
    """By Ctrl-C or an exception on one rank, at a step at which stiffness is looked at again: what is left goes on as
    if nothing had been, and so does its checkpoint."""
    for variant in VARIANTS[1:]:
        whole = often_checked(**variant)
        end = 32 * whole.stable_step()
        whole.advance(end, progress=False, callback=lambda p: None)
        for what, kind in ((press, KeyboardInterrupt), (lambda: 1 / (0 if LAST else 1), ZeroDivisionError)):

            def leave(problem, what=what):
                if problem.step == 20:
                    what()

            problem = often_checked(**variant)
            with pytest.raises(kind):
                problem.advance(end, callback=leave, progress=False)
            assert problem.step == 20 and len(problem.energy_history) == 20
            # Writing a checkpoint looks for contact anew: that of the run itself to round-off.
            left, restored = go_on_from(problem, end, variant, often_checked)
            np.testing.assert_array_equal(left, restored)
            assert problem.step == whole.step
            np.testing.assert_allclose(left, state(whole), rtol=1e-6, atol=1e-7)


@with_ctrl_c
def check_a_function_of_time_that_fails():
    """On one rank, in the middle of a run."""
    problem = block_on_block()
    dt = 0.9 * problem.stable_step()
    problem.advance(200 * dt, progress=False)
    before = state(problem)
    inner = problem._stepper.functions.amplitudes[0]._function
    problem._stepper.functions.amplitudes[0]._function = lambda t: (
        np.array([np.nan]) if LAST and t > 210 * dt else inner(t)
    )
    with pytest.raises(ValueError, match="functions|amplitude|nan"):
        problem.advance(400 * dt, progress=False)
    assert problem.step == 200
    np.testing.assert_array_equal(state(problem), before)
    problem._stepper.functions.amplitudes[0]._function = inner
    problem.advance(400 * dt, progress=False)
    assert np.all(np.isfinite(state(problem)))


@with_ctrl_c
def check_histories_are_written_when_a_run_is_left():
    import h5py

    with shared_folder() as path:
        problem = block_on_block()
        recorder = problem.record(path / "run", every=100)
        with pytest.raises(KeyboardInterrupt):
            problem.advance(
                1000 * problem.stable_step(), callback=lambda p: press() if p.step == 77 else None, progress=False
            )
        COMM.barrier()
        with h5py.File(path / "run" / "history.h5", "r") as file:
            assert len(file["time"]) == problem.step == 77
        recorder.close()


@with_ctrl_c
def check_handlers():
    """The handler that was there is back afterwards; one of the user's own is asked, one that ignores is left alone."""
    handler = signal.getsignal(signal.SIGINT)
    seen = []
    try:
        problem = block_on_block()
        dt = 0.9 * problem.stable_step()
        for own, stops in ((lambda *_: seen.append(1), False), (signal.SIG_IGN, False), (handler, True)):
            signal.signal(signal.SIGINT, own)
            end, first = problem.time + 20 * dt, problem.step
            work = lambda: problem.advance(  # noqa: E731
                end, callback=lambda p: press() if p.step == first + 5 else None, progress=False
            )
            if stops:
                with pytest.raises(KeyboardInterrupt):
                    work()
            else:
                work()
            assert signal.getsignal(signal.SIGINT) is own
            assert problem.step == first + (5 if stops else 20)
        assert len(seen) == LAST
    finally:
        signal.signal(signal.SIGINT, handler)


@with_ctrl_c
def check_nested_and_late_signals():
    """The inner block raises; several signals are one; a signal after the last check is delivered at the end."""
    raised = 0
    with Interrupts(COMM) as outer:
        try:
            with Interrupts(COMM) as inner:
                press()
                press()
                inner.check()
        except KeyboardInterrupt:
            raised += 1
        outer.check()
    assert raised == 1
    try:
        with Interrupts(COMM):
            press()
    except KeyboardInterrupt:
        raised += 1
    assert raised == 1 + LAST


@with_ctrl_c
def check_other_threads():
    """A run in a thread that gets no signals is like any other."""
    # Only where MPI allows it: one thread at a time communicates.
    problem, found = block_on_block(), []
    end = 30 * problem.stable_step()
    worker = threading.Thread(target=lambda: found.append(problem.advance(end, progress=False)))
    worker.start()
    worker.join()
    assert found == [None] and problem.time == end


@functools.cache
def flat():
    """One mesh for all problems that are compared: DOLFINx may partition a second one otherwise."""
    return mesh.create_rectangle(COMM, [[0.0, 0.0], [1.0, 0.5]], [6, 3], mesh.CellType.quadrilateral)


def pressed_block():
    """A soft block that a rigid plane presses and shears in several increments, with friction."""
    domain = flat()
    facets = mesh.locate_entities_boundary(domain, 1, lambda x: np.isclose(x[1], 0.5))
    tags = mesh.meshtags(domain, 1, np.sort(facets), np.full(len(facets), 3, dtype=np.int32))
    V = fem.functionspace(domain, ("Lagrange", 1, (2,)))
    u = fem.Function(V)
    bottom = fem.locate_dofs_geometrical(V, lambda x: np.isclose(x[1], 0.0))
    plane = di.RigidPlane(point=(0.0, 0.5), normal=(0.0, -1.0))
    return u, tags, [fem.dirichletbc(np.zeros(2), bottom, V)], plane


@with_ctrl_c
def check_statics_goes_back_to_the_last_converged_state():
    """Ctrl-C on one rank in the middle of an increment; the next solve goes on from there to the same end. Contacts are
    called in Python, where their methods count."""
    with patch.object(in_cpp, "contact_in_cpp", _cpp.solve.PythonContact):
        statics_goes_back()


def statics_goes_back():
    for kind in (di.Lagrange, di.Penalty):

        def make(kind=kind):
            u, tags, bcs, plane = pressed_block()
            load = di.BodyForce((0.0, -5.0), per_mass=False)
            soft = di.NeoHookean(1e3, 0.3, hypothesis="plane_strain")
            pair = di.ContactPair(tags, 3, plane, friction=0.3)
            return di.StaticProblem(u, soft, bcs=bcs, loads=[load], contact=[kind(pair)]), plane, load

        def counted(problem, wanted=0):
            """Counts iterations, notes accepted states, and presses Ctrl-C in one iteration."""
            contact, count, accepted = problem.contact[0], [], []
            update, accept = contact.update_gap, contact.accept_step

            def updated(u):
                count.append(1)
                if len(count) == wanted:
                    press()
                return update(u)

            def noted():
                accept()
                accepted.append((len(count), problem.u.x.array.copy()))

            contact.update_gap, contact.accept_step = updated, noted
            return accepted

        whole, plane, _ = make()
        plane.displacement = (0.02, -0.04)
        accepted = counted(whole)
        whole.solve(steps=2)
        iterations, halfway = accepted[0]
        problem, plane, load = make()
        plane.displacement = (0.02, -0.04)
        contact = problem.contact[0]
        counted(problem, iterations + 2)  # in the second increment
        with pytest.raises(KeyboardInterrupt):
            problem.solve(steps=2)
        np.testing.assert_allclose(problem.u.x.array, halfway, rtol=0, atol=1e-13)
        np.testing.assert_allclose(contact.displacement, np.array([0.01, -0.02, 0.0]), atol=1e-15)
        assert load.constant.value[1] == -5.0 and load._reached[1] == pytest.approx(-2.5)
        problem.solve()
        np.testing.assert_allclose(problem.u.x.array, whole.u.x.array, rtol=0, atol=1e-9)
        np.testing.assert_allclose(contact.force, whole.contact[0].force, rtol=1e-7)


def check_an_implicit_step_goes_back():
    """An exception in the middle of a step, on all ranks: the problem has the state after the step before, and goes on
    from there as one that was never left."""
    with patch.object(in_cpp, "contact_in_cpp", _cpp.solve.PythonContact):

        def make():
            u, tags, bcs, plane = pressed_block()
            v = fem.Function(u.function_space)
            v.x.array[1::2] = 0.5  # towards the plane
            soft = di.NeoHookean(1e3, 0.3, density=1.0, hypothesis="plane_strain")
            load = di.BodyForce((0.0, 5.0), per_mass=False)
            return di.NewmarkProblem(
                u, soft, velocity=v, loads=[load], contact=[di.Lagrange(di.ContactPair(tags, 3, plane))]
            )

        whole, problem = make(), make()
        whole.advance(0.02, dt=0.005, progress=False)
        problem.advance(0.01, dt=0.005, progress=False)
        contact, count = problem.contact[0], []
        before = [f.x.array.copy() for f in (problem.u, problem.velocity, problem.acceleration)]
        update, force = contact.update_gap, contact.force.copy()

        def updated(u):
            count.append(1)
            update(u)
            if len(count) == 3:
                reach()

        contact.update_gap = updated
        with pytest.raises(Reached):
            problem.advance(0.02, dt=0.005, progress=False)
        assert problem.time == pytest.approx(0.01, rel=1e-12)
        for f, values in zip((problem.u, problem.velocity, problem.acceleration), before):
            np.testing.assert_array_equal(f.x.array, values)
        contact.update_gap = update
        problem.advance(0.02, dt=0.005, progress=False)
        assert contact.force[1] < -1.0 and not np.array_equal(force, contact.force)  # still pressed
        np.testing.assert_allclose(problem.u.x.array, whole.u.x.array, rtol=0, atol=1e-10)
        np.testing.assert_allclose(contact.force, whole.contact[0].force, rtol=1e-7)


@with_ctrl_c
def check_statics_by_a_method_of_petsc():
    """An exception passes through PETSc's own methods as it is."""
    u, tags, bcs, plane = pressed_block()
    soft = di.NeoHookean(1e3, 0.3, hypothesis="plane_strain")
    problem = di.StaticProblem(
        u, soft, bcs=bcs, loads=[di.BodyForce((30.0, -50.0), per_mass=False)], options={"snes_type": "newtonls"}
    )
    check, count = Interrupts.check, []

    def pressed(self, *arguments):  # before every residual that PETSc asks for
        count.append(1)
        if len(count) == 3:
            press()
        return check(self, *arguments)

    Interrupts.check = pressed
    try:
        with pytest.raises(KeyboardInterrupt):
            problem.solve()
    finally:
        Interrupts.check = check
    assert not np.any(u.x.array)
    problem.solve()
    assert largest(np.abs(u.x.array)) > 1e-3
