# SPDX-License-Identifier: MIT
"""What explicit runs write while they run. See on_ranks.py."""

import shutil
import warnings

import numpy as np
import pytest
from mpi4py import MPI
from restart_checks import COMM, block_on_block
from shared_folder import shared_folder

import dolfinx_impact as di
from dolfinx_impact.dynamics import recorder as recorder_module


def check_histories_and_frames():
    """Energies and contact forces of every step, chosen points at their intervals, frames that ParaView opens."""
    import h5py

    with shared_folder() as path:
        problem, alone = block_on_block(), block_on_block()
        end = 250 * problem.stable_step()
        points = [[0.5, 0.0], [0.7, 0.9]]
        recorder = problem.record(path / "run", every=100, points=points, points_every=10)
        problem.advance(end, progress=False)
        recorder.close()
        alone.advance(end, progress=False)
        np.testing.assert_array_equal(problem.u.x.array, alone.u.x.array)  # writing changes nothing
        steps = problem.step
        assert problem.force_history[0].shape == (steps, 2)
        COMM.barrier()
        with h5py.File(path / "run" / "history.h5", "r") as file:
            assert file["time"].shape == (steps,) and file["time"].attrs["units"] == "T"
            for k, name in enumerate(("time", "kinetic", "internal", "contact", "friction", "impact"), 0):
                np.testing.assert_array_equal(file[name][:], problem.energy_history[:, k])
            np.testing.assert_array_equal(file["force_0"][:], problem.force_history[0])
            assert file["force_0"].attrs["units"] == "F" and np.abs(file["force_0"][:]).max() > 0.0
            assert file["points/displacement"].shape == (1 + steps // 10, 2, 2)
            times = file["points/time"][:]
            np.testing.assert_allclose(np.diff(times), 10 * np.diff(problem.energy_history[:2, 0])[0], rtol=1e-9)
            # The first point is on the support that moves.
            moved = 0.002 * np.sin(20 * times)
            np.testing.assert_allclose(file["points/displacement"][:, 0, 1], moved, rtol=0, atol=1e-15)
            assert file["points/velocity"].attrs["units"] == "L/T"
        assert (path / "run" / "fields.bp").exists()


def check_when_histories_are_written():
    """Not before their time is up, all of them with a checkpoint and by close, nothing after that."""
    import h5py

    with shared_folder() as path:
        problem = block_on_block()

        def rows():
            COMM.barrier()
            with h5py.File(path / "run" / "history.h5", "r") as file:
                found = len(file["time"])
            COMM.barrier()  # nobody reads any more when it is written again
            return found

        def go_on():
            problem.advance(problem.time + 110 * problem.stable_step(), progress=False)
            return rows()

        recorder = problem.record(path / "run", every=100)
        begin, wanted = rows(), recorder_module.INTERVAL
        try:
            recorder_module.INTERVAL = 1e9  # s
            assert go_on() == begin
            problem.save(path / "checkpoint.h5")
            assert rows() == problem.step
            recorder_module.INTERVAL = 0.0
            between = problem.step
            assert go_on() > between and recorder.seconds > 0.0
            recorder.close()
            end = problem.step
            assert rows() == end and go_on() == end < problem.step
        finally:
            recorder_module.INTERVAL = wanted


def check_forces_of_every_step_are_the_contact_s():
    """The history's rows are what a callback sees at the start and after every step."""
    problem = block_on_block()
    seen = []
    problem.advance(200 * problem.stable_step(), callback=lambda p: seen.append(p.contact[0].force), progress=False)
    assert len(seen) == problem.step + 1
    np.testing.assert_allclose(problem.force_history[0], np.array(seen)[:-1], rtol=0, atol=1e-12)


def check_callbacks_after_some_steps():
    """At the start and after steps that are multiples of the pause, with the present state, whatever else is written
    between; functions of time are set in every step nevertheless."""
    with shared_folder() as path:
        problem = block_on_block()
        dt = 0.5 * problem.stable_step()
        seen, updated = [], []

        def callback(p):
            seen.append((p.step, p.time, p.contact[0].force[1]))

        recorder = problem.record(path / "run", every=25, points=[[0.5, 0.0]], points_every=7)
        problem.advance(101 * dt, dt=dt, callback=callback, callback_every=10, progress=False)
        recorder.close()
        assert [step for step, *_ in seen] == list(range(0, 101, 10)) and problem.step == 101
        rows = [step for step, *_ in seen]
        np.testing.assert_array_equal([row[1] for row in seen], problem.energy_history[rows, 0])
        np.testing.assert_allclose([row[2] for row in seen], problem.force_history[0][rows, 1], rtol=0, atol=1e-12)
        seen.clear()
        problem.advance(problem.time + 9 * dt, dt=dt, callback=callback, callback_every=4, progress=False,
                        update=lambda p, time: updated.append(time))  # fmt: skip
        assert [step for step, *_ in seen] == [104, 108] and len(updated) == 10
        for wrong, error in ((0, ValueError), (1.5, ValueError), ("two", TypeError)):
            with pytest.raises(error, match="callback_every"):
                problem.advance(1.0, callback=callback, callback_every=wrong, progress=False)
        if COMM.size > 1:
            with pytest.raises(ValueError, match="callback_every"):
                problem.advance(1.0, callback=callback, callback_every=1 + COMM.rank, progress=False)
        assert problem.step == 110


def go_on_without_folder(path, problem, again, time, lost):
    """Run until the folder, or what is named of it, is removed, then on: the run is what it is without a recorder."""
    recorder = problem.record(path / "run", every=5)
    problem.advance(time, progress=False)
    COMM.barrier()
    if COMM.rank == 0:
        gone = path / "run" / lost
        gone.unlink() if gone.is_file() else shutil.rmtree(gone)
    COMM.barrier()
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        problem.advance(2 * time, progress=False)
        problem.save(path / "checkpoint.h5")
    for end in (time, 2 * time):
        again.advance(end, progress=False)
    np.testing.assert_array_equal(problem.u.x.array, again.u.x.array)
    assert problem.step == again.step
    assert [str(t.message) for t in told if "is gone" in str(t.message)] == [str(t.message) for t in told]
    assert len(told) == (COMM.rank == 0)
    where = str((path / "run" / lost).resolve())
    assert all(str(t.message).startswith(where) and "goes on without" in str(t.message) for t in told)
    with pytest.raises(RuntimeError, match="is gone: it was removed"):
        recorder.close()


def check_a_folder_that_is_removed():
    """By whoever cleans a scratch disk: one warning, and an error when the recorder is closed."""
    for lost in (".", "fields.bp", "history.h5"):
        with shared_folder() as path:
            problem, again = block_on_block(), block_on_block()
            dt = 0.9 * problem.stable_step()
            before, recorder_module.INTERVAL = recorder_module.INTERVAL, 0.0
            try:
                go_on_without_folder(path, problem, again, 20 * dt, lost)
            finally:
                recorder_module.INTERVAL = before


def check_bad_input():
    with shared_folder() as path:
        problem = block_on_block()
        for options, text in (
            ({"fields": ("stresses",)}, "unknown"),
            ({"every": 0}, "every is 0"),
            ({"points": [[0.0]]}, "coordinates"),
        ):
            with pytest.raises(ValueError, match=text):
                problem.record(path / "bad", **options)
        if COMM.rank == 0:
            (path / "file").touch()
        COMM.barrier()
        with pytest.raises(RuntimeError):
            problem.record(path / "file" / "under")


def check_contacts_of_explicit_problems():
    """Static options and multipliers are refused; bodies that overlap are told."""
    assert MPI.COMM_WORLD.size == COMM.size
    for kind, options, text in (
        (di.Lagrange, {}, "static"),
        (di.Penalty, {"augmented": True}, "static"),
        (di.Kinematic, {"sweeps": 0}, "sweeps"),
    ):
        with pytest.raises(ValueError, match=text):
            block_on_block(kind=kind, **options)
