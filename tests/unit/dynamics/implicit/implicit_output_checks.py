# SPDX-License-Identifier: MIT
"""Implicit runs that are saved, recorded or cut short, alike on all ranks. See on_ranks.py."""

import shutil
import warnings
from unittest.mock import patch

import numpy as np
import pytest
from dolfinx import fem
from implicit_checks import (
    COMM, DT, LAWS, SOME, assert_same, bar, block_on_block, motion, state,
)  # fmt: skip
from mpi4py import MPI
from shared_folder import shared_folder

import dolfinx_impact as di
from dolfinx_impact import _cpp
from dolfinx_impact.statics.material_body import MaterialBody


def check_a_restored_run_is_the_uninterrupted_one():
    """Bit for bit, contact, friction and plastic flow included; `save` changes nothing but the solver's factors, which
    a restored run does not have either."""
    with shared_folder() as path:
        for k, variant in enumerate(SOME):
            whole, again = block_on_block(**variant), block_on_block(**variant)
            whole.advance(8 * DT, DT, progress=False)
            assert whole.contact[0].force[1] > 0.0, variant  # in the middle of the contact
            whole.save(path / f"{k}.h5")
            again.restore(path / f"{k}.h5")
            # Points between two facets of the master are projected anew: their gaps may differ until the next step.
            np.testing.assert_array_equal(motion(again), motion(whole), str(variant))
            assert again.time == whole.time and again.step == whole.step
            for problem in (whole, again):
                problem.advance(12 * DT, DT, progress=False)
            if variant["contact"] == "augmented":  # without friction, open points keep facets from step to step
                np.testing.assert_allclose(motion(again), motion(whole), atol=1e-9 * np.abs(motion(whole)).max())
            else:
                assert_same(state(again), state(whole), str(variant))


def check_steps_end_at_given_times():
    """At `until` and at the times of frames exactly, with equal steps between."""
    import h5py

    with shared_folder() as path:
        problem, times = bar(), []
        recorder = problem.record(path / "run", times=[0.03, 0.1], points=[[1.0, 0.1]])
        problem.advance(0.15, 0.02, callback=lambda p: times.append(p.time), progress=False)
        recorder.close()
        assert times[-1] == problem.time == 0.15 and {0.03, 0.1} <= set(times)
        np.testing.assert_allclose(np.diff(times), [0.015] * 2 + [0.0175] * 4 + [0.05 / 3] * 3, rtol=1e-12)
        COMM.barrier()
        with h5py.File(path / "run" / "history.h5", "r") as file:
            np.testing.assert_array_equal(file["time"][:], times[1:])  # from the recorder's start on
            assert file["points/displacement"].shape == (len(times), 1, 2)
        assert (path / "run" / "fields.bp").exists()


def check_callbacks_after_some_steps():
    """At the start and after steps that are multiples of the pause; functions of time are set in every step."""
    problem, seen, updated = bar(), [], []

    def callback(p):
        seen.append((p.step, p.time))

    problem.advance(0.1, 0.01, callback=callback, callback_every=4, progress=False)
    assert [step for step, _ in seen] == [0, 4, 8] and problem.step == 10
    np.testing.assert_allclose([time for _, time in seen], [0.0, 0.04, 0.08], rtol=1e-12)
    seen.clear()
    problem.advance(0.13, 0.01, callback=callback, callback_every=4, progress=False,
                    update=lambda p, time: updated.append(time))  # fmt: skip
    assert [step for step, _ in seen] == [12] and len(updated) == 3
    for wrong, error in ((0, ValueError), (1.5, ValueError), ("two", TypeError)):
        with pytest.raises(error, match="callback_every"):
            problem.advance(1.0, 0.01, callback=callback, callback_every=wrong, progress=False)
    if COMM.size > 1:
        with pytest.raises(ValueError, match="callback_every"):
            problem.advance(1.0, 0.01, callback=callback, callback_every=1 + COMM.rank, progress=False)
    assert problem.step == 13


def check_a_folder_that_is_removed():
    """The run goes on with one warning; closing the recorder is an error."""
    with shared_folder() as path:
        problem, again = bar(), bar()
        recorder = problem.record(path / "run", every=2)
        for k, p in enumerate((problem, again)):
            p.advance(0.1, 0.02, progress=False)
            COMM.barrier()
            if k == 0 and COMM.rank == 0:
                shutil.rmtree(path / "run")
            COMM.barrier()
            with warnings.catch_warnings(record=True) as told:
                warnings.simplefilter("always")
                p.advance(0.2, 0.02, progress=False)
            assert ["is gone" in str(t.message) for t in told] == [True] * (k == 0 and COMM.rank == 0)
        np.testing.assert_array_equal(motion(problem), motion(again))
        with pytest.raises(RuntimeError, match="is gone: it was removed"):
            recorder.close()


def check_a_run_that_fails_keeps_its_last_state():
    problem = block_on_block(law="neo-Hookean")
    problem.advance(3 * DT, DT, progress=False)
    before = state(problem)
    with pytest.raises(RuntimeError, match="the problem is at the time 0.012"):
        problem.advance(1.0, 0.5, smallest=0.4, max_iterations=1, progress=False)
    np.testing.assert_array_equal(state(problem), before)
    problem.advance(6 * DT, DT, progress=False)  # and goes on


def check_mass_redistribution_keeps_mass_and_momentum():
    """The mass of the contact nodes is at the nodes behind them: the total is the same, the contact nodes have none,
    the kinetic energy of a translation is the same."""
    for lumping in (None, "auto"):
        problem, plain = (block_on_block(impact=i, lumping=lumping) for i in ("mass_redistribution", "none"))
        ones = np.zeros(problem.num_owned)
        ones[::2] = 1.0
        totals = [COMM.allreduce(float(ones @ p.inertia.times(ones))) for p in (problem, plain)]
        assert totals[0] == pytest.approx(totals[1], rel=1e-13)
        massless = problem.inertia.massless
        count = COMM.allreduce(int(massless.sum()))
        assert count == 2 * (7 + 8) and not plain.inertia.massless.any()
        diagonal = problem.inertia.matrix.getDiagonal().array
        assert np.abs(diagonal[massless]).max(initial=0.0) < 1e-15 and np.all(diagonal[~massless] > 0.0)


class FailingBody:
    """Residuals of steps longer than 0.015 cannot be computed, once they have been.

    Attributes:
        length: length of the present step.
    """

    length = 0.0

    def around(self, body):
        right = body._cpp_object
        return _cpp.solve.FunctionBody(
            residual=right.residual, tangent=right.tangent, accept_step=right.accept_step, origin=None,
            fault=lambda: "made to fail" if self.length > 0.015 else right.fault(), stored_energy=right.stored_energy,
            properties=right.properties,
        )  # fmt: skip

    def update(self, problem, time):
        self.length = time - problem.time


def check_plastic_steps_that_are_halved():
    """Halves of a step leave the history of steps that were as short from the start: what the step that failed tried is
    forgotten."""
    law, histories = LAWS["J2"](), []
    for dt in (0.02, 0.01):
        V = bar(material=law).space
        v = fem.Function(V)
        v.interpolate(lambda x: np.vstack([4.0 * x[0], 0.0 * x[0]]))
        failing = FailingBody()
        with patch.object(MaterialBody, "in_cpp", lambda body: failing.around(body)):
            problem = di.NewmarkProblem(fem.Function(V), law, velocity=v)
        problem.advance(0.02, dt, progress=False, update=failing.update)
        assert problem.step == 2 and problem.stepper.cut_backs == int(dt == 0.02)
        histories.append(problem.history["plastic_strain"].values.copy())
    assert COMM.allreduce(histories[0].max(initial=0.0), MPI.MAX) > 1e-3
    np.testing.assert_array_equal(histories[0], histories[1])
