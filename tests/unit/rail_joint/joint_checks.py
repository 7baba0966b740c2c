# SPDX-License-Identifier: MIT
"""Model and passage of a rail joint with coarse cells, on any number of ranks."""

import json
import re
import tempfile
import time
from pathlib import Path

import numpy as np
import pytest
import ufl
from dolfinx import fem
from mpi4py import MPI

import dolfinx_impact.rail_joint.case as case_module
from dolfinx_impact.rail_joint import Case, JointModel, Passage, RailJoint
from dolfinx_impact.rail_joint.wheel import HUB_TAGS, RIM_TAG

COMM = MPI.COMM_WORLD
SMALL = RailJoint().changed(
    cells=1,
    coarse=0.1,
    speed=80.0,
    begin=-6e-3,
    end=6e-3,
    rail_length=0.5,
    bar_length=0.3,
    sleepers=0.3,
    yield_stress=np.inf,
    wheel_mass=700.0,
)


def check_the_wheel_is_balanced():
    """Its mass, its centre of mass, and the velocity of rolling."""
    for joint in (SMALL, SMALL.changed(cone=0.05, fillet=0.013)):
        model = JointModel(joint, COMM)
        wheel, x = model.wheel, ufl.SpatialCoordinate(model.mesh)
        moments = np.zeros(4)
        for tag in (RIM_TAG, *HUB_TAGS):
            dx = ufl.Measure("dx", domain=model.mesh, subdomain_data=model.cell_tags)(tag)
            density = wheel.densities[tag]
            parts = [fem.assemble_scalar(fem.form(density * f * dx)) for f in (fem.Constant(model.mesh, 1.0), *x)]
            moments += COMM.allreduce(np.array(parts), MPI.SUM)
        assert joint.sides * moments[0] == pytest.approx(700.0, rel=1e-12)
        centre = moments[1:] / moments[0]
        # Normal to the axle it is the axle's; along it, one half has its own, and a coned wheel is thinner outside.
        assert np.linalg.norm(np.cross(centre - wheel.centre, wheel.axis)) < 2e-3 * joint.wheel_radius
        if joint.cone == 0.0:
            assert abs(centre[0] - wheel.centre[0]) < 1e-9 and abs(centre[2] - wheel.centre[2]) < 1e-9
        velocity = model.rolling_velocity(fem.Function(model.V))
        places = model.V.tabulate_dof_coordinates()
        lowest = np.linalg.norm(places - (joint.begin, 0.0, 0.0), axis=1) < 1e-9
        slow = np.abs(velocity.x.array.reshape(-1, 3)[lowest]).max(initial=0.0)
        assert slow < 1e-2 * joint.speed, "the contact point stands; velocities are means over chords of cells"


def check_resumed_run_is_the_same_run():
    """A run that is killed on its way and resumed ends where the uninterrupted one does."""
    folder = Path(COMM.bcast(tempfile.mkdtemp() if COMM.rank == 0 else None))
    whole = Case(SMALL, folder / "whole", COMM, pictures=False, progress=False).solve()
    assert whole.static_force == pytest.approx(SMALL.load, rel=1e-5)
    assert 0.5 < whole.least_force < 1.1 and whole.cells == JointModel(SMALL, COMM).num_cells

    case = Case(SMALL, folder / "killed", COMM, pictures=False, progress=False, interval=0.0)
    stage = case._stage

    def killed(name, work):
        if name != "rolling":
            return stage(name, work)
        problem = work.__closure__ and next(
            c.cell_contents for c in work.__closure__ if hasattr(c.cell_contents, "run")
        )
        advance, count = problem.run.advance, []

        def limited(*args, **kwargs):
            count.append(1)
            if len(count) > 12:
                raise KeyboardInterrupt
            advance(*args, **kwargs)

        problem.run.advance = limited
        return work()

    case._stage = killed
    with pytest.raises(KeyboardInterrupt):
        case.solve()
    COMM.barrier()
    assert (folder / "killed" / "checkpoint.h5").exists()
    other = SMALL.changed(speed=20.0)
    with pytest.raises(ValueError, match="checkpoint of another joint"):
        Case(other, folder / "killed", COMM, resume=True)
    resumed = Case(SMALL, folder / "killed", COMM, pictures=False, progress=False, resume=True).solve()
    # Restarts are exact; the tables begin where the run was resumed, so only what is behind the joint is compared. On
    # several ranks MUMPS does not repeat the last digits of the preload, nor do forces that settle from it.
    for name in ("static_force", "dynamic_factor", "peak_place"):
        assert getattr(resumed, name) == pytest.approx(getattr(whole, name), rel=1e-9 if COMM.size == 1 else 1e-6), name
    assert not (folder / "killed" / "checkpoint.h5").exists(), "nothing is left to resume"
    record = json.loads((folder / "killed" / "summary.json").read_text())
    assert record["summary"]["steps"] == whole.steps


def check_prediction_of_a_long_run():
    """Number of steps and rate are those of the run itself, within what pressed springs change."""
    folder = Path(COMM.bcast(tempfile.mkdtemp() if COMM.rank == 0 else None))
    case, said, trial = Case(SMALL, folder, COMM, pictures=False, progress=False), [], case_module.TRIAL
    case.run.print = said.append
    passage = Passage(JointModel(SMALL, COMM), progress=False)
    case_module.TRIAL = 0.5
    try:
        case._predict(passage)
    finally:
        case_module.TRIAL = trial
    (text,) = said
    steps, rate = (float(x) for x in re.search(r"1 x (\d+) steps .* ([\d.]+) steps per second", text).groups())
    run = passage.start(passage.preload())
    begun, step = time.perf_counter(), run.step
    run.advance(0.1 * SMALL.duration, progress=False)
    measured = (run.step - step) / (time.perf_counter() - begun)
    assert steps == pytest.approx(10 * (run.step - step), rel=0.1)
    assert 0.1 < rate / measured < 10.0, "the machine may be busy with one of the two"
    assert "GB more for equilibria" in text
