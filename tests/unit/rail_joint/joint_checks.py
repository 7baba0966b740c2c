# SPDX-License-Identifier: MIT
"""Model and passage of a rail joint with coarse cells, on any number of ranks."""

import json
import re
import shutil
import time

import numpy as np
import pytest
import ufl
from dolfinx import fem
from mpi4py import MPI
from shared_folder import shared_folder

import dolfinx_impact as di
import impact_studies.rail_joint.case as case_module
from impact_studies.rail_joint import Case, JointModel, Passage, RailJoint
from impact_studies.rail_joint.passage import TOLERANCE
from impact_studies.rail_joint.saved_case import seal
from impact_studies.rail_joint.wheel import HUB_TAGS, RIM_TAG

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


# Few large cells: the largest load on the head that the model takes.
TINY = SMALL.changed(
    rail_length=0.2, bar_length=0.1, coarse=0.3, load=400e3, gap=3e-3, begin=-3e-3, end=3e-3
)  # fmt: skip
STAGES = ("preload 1", "start 1", "rolling 1", "unloading 1", "preload 2", "start 2", "rolling 2", "unloading 2")


def check_parts_meshed_apart():
    """End post and bars tied instead of meshed with the rails, under a pressure on the running surface: with the same
    nodes displacements are the same, with others near by. The passage: tests/verification/test_rail_joint_parts.py."""
    found = []
    for tied, size in (("none", 1.0), ("bars", 1.5), ("all", 1.0), ("all", 1.5)):
        model = JointModel(TINY.changed(tied=tied, tied_size=size), COMM)
        u, head = fem.Function(model.V), model.tags["master_surface"]
        problem = di.StaticProblem(
            u, model.material, bcs=[*model.bcs, *model.parked()],
            loads=[model.track, di.Traction(model.facet_tags, head, (0.0, 0.0, -1e7))], contact=model.ties,
        )  # fmt: skip
        problem.solve(progress=False)
        assert len(problem.contact) == {"none": 0, "bars": 1, "all": 3}[tied]
        for c in problem.contact[1:]:
            assert abs(c.area / 3.93e-3 - 1.0) < 1e-3  # half of the rail's section [m^2]
        x = model.V.tabulate_dof_coordinates()
        ends = np.linalg.norm(x - (0.5 * TINY.gap, 0.0, 0.0), axis=1) < 1e-9
        found.append(-COMM.allreduce(u.x.array.reshape(-1, 3)[ends, 2].min(initial=0.0), MPI.MIN))
    # Direct solutions of ill-conditioned systems; coarser parts by the error of their cells.
    assert found[0] > 1e-5 and abs(found[2] / found[0] - 1.0) < 1e-8
    assert abs(found[1] / found[0] - 1.0) < 1e-3 and abs(found[3] / found[0] - 1.0) < 1e-2


class Killed(BaseException):
    """The process is killed: nothing of the case runs any more."""


def run_case(joint, folder, kill_in=None, resume=False, pictures=False):
    """Run a case, from its start or from where it was killed; kill it at the beginning of a stage, in `rolling` after
    some steps. Returns its summary, None if it was killed, and the stages that it has run."""
    case = Case(joint, folder, COMM, pictures, progress=False, resume=resume, interval=0.0, frames=4)
    stage, run = case._stage, []
    passes = len(case._passes)

    def watched(name, work):
        if name == "unloading":
            name = f"unloading {passes + sum(n.startswith('unloading') for n in run) + 1}"
        name = name if name[-1].isdigit() or name not in ("preload", "start", "rolling") else f"{name} 1"
        run.append(name)
        if name != kill_in:
            return stage(name, work)
        if not name.startswith("rolling"):
            raise Killed
        save, count = case._saved.save, []

        def saved(*args, **kwargs):
            save(*args, **kwargs)
            count.append(1)
            if len(count) == 9:  # of the 28 of a passage
                raise Killed

        case._saved.save = saved
        return stage(name, work)

    case._stage = watched
    try:
        return case.solve(), run
    except Killed:
        return None, run
    finally:
        COMM.barrier()


def compare(whole, found):
    """Every number of the passages and all rows of the tables are those of the uninterrupted run; on several ranks
    MUMPS does not repeat the last digits of the equilibria, nor do forces that settle from them."""
    tolerance = 0.0 if COMM.size == 1 else 1e-4
    records = [json.loads((folder / "summary.json").read_text()) for folder in (whole, found)]
    assert records[0]["identity"] == records[1]["identity"]
    both = [[record["summary"], *record["passes"]] for record in records]
    assert len(both[0]) == len(both[1])
    for ours, theirs in zip(*both):
        assert ours.keys() == theirs.keys()
        for name in set(ours) - {"seconds", "energy_missed"}:
            if COMM.size == 1:
                assert ours[name] == theirs[name], name
            elif name.startswith("residual_"):
                # Elastic rails keep none but what the equilibrium without a wheel misses.
                noise = TOLERANCE * theirs["hertz_pressure"]
                assert ours[name] == pytest.approx(theirs[name], rel=1e-3, abs=noise), name
            else:
                assert ours[name] == pytest.approx(theirs[name], rel=1e-3, abs=1e-9), name
    for table in ("force", "energy", "ends"):
        ours, theirs = (np.loadtxt(f / f"{table}.csv", delimiter=",", skiprows=1) for f in (whole, found))
        assert ours.shape == theirs.shape and len(ours) > 20
        assert np.abs(ours - theirs).max() <= tolerance * np.abs(theirs).max(), table


def check_killed_run_goes_on():
    """A passage that is killed while the wheel rolls and in the unloading ends as if it had not been."""
    with shared_folder() as folder:
        whole, _ = run_case(TINY, folder / "whole")
        assert whole.static_force == pytest.approx(TINY.load, rel=1e-5)
        assert 0.3 < whole.least_force < 1.1 and whole.plastic_strain == 0.0
        if TINY.sides == 2:
            across = np.loadtxt(folder / "whole" / "force.csv", delimiter=",", skiprows=1)[:, 3]
            assert not np.any(across), "by symmetry there is no lateral force"
        killed = folder / "killed"
        assert run_case(TINY, killed, "rolling 1")[0] is None
        assert (killed / "resume" / "state.json").exists() and not (killed / "summary.json").exists()
        before = contents(killed)
        with pytest.raises(ValueError, match="of another joint or run, whose parameters differ"):
            Case(TINY.changed(speed=20.0), killed, COMM, pictures=False, resume=True, frames=4)
        if COMM.size > 1 and COMM.rank == 0:
            with pytest.raises(ValueError, match="whose ranks differ"):
                Case(TINY, killed, MPI.COMM_SELF, pictures=False, resume=True, frames=4)
        assert contents(killed) == before, "a run that is refused changes no file"
        assert run_case(TINY, killed, "unloading 1", resume=True)[1][:3] == ["mesh", "restart", "rolling 1"]
        assert run_case(TINY, killed, resume=True)[0] is not None
        assert not (killed / "resume").exists(), "nothing is left to resume"
        compare(folder / "whole", killed)
        before = contents(killed)
        again, stages = run_case(TINY, killed, resume=True)
        assert stages == [], "what is complete is not run again"
        assert contents(killed).items() >= results_of(before).items()
        record = json.loads((killed / "summary.json").read_text())
        assert again.as_dict() == record["summary"] and again.hertz_half_axes == whole.hertz_half_axes


def contents(folder):
    """Bytes of the files of a folder, as they are while no rank writes."""
    COMM.barrier()
    found = {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    COMM.barrier()
    return found


def results_of(found):
    """Files without the parameters, which have the time of writing."""
    return {name: data for name, data in found.items() if not name.startswith("parameters")}


def check_a_new_run_removes_the_results_of_an_old_one():
    """Else its report would show their pictures."""
    with shared_folder() as folder:
        names = ("force.png", "passages.png", "plastic.png", "passage.gif", "report.html", "summary.json", "ends.csv")
        if COMM.rank == 0:
            for name in (*names, "of_the_user.png"):
                (folder / name).write_bytes(b"old")
        COMM.barrier()
        Case(SMALL, folder, COMM, resume=True).run.close()
        assert set(contents(folder)) == {"of_the_user.png", "parameters.json", "parameters.toml"}


def check_run_killed_in_every_stage_goes_on():
    """Two passages over steel that yields, with pictures; killed once in each stage, the same run goes on each time."""
    joint = TINY.changed(passes=2, yield_stress=600e6)
    with shared_folder() as folder:
        whole, _ = run_case(joint, folder / "whole", pictures=True)
        assert whole.plastic_strain > 1e-5 and whole.residual_von_mises > 1e6
        for k, stage in enumerate(STAGES):
            found, stages = run_case(joint, folder / "killed", stage, resume=k > 0, pictures=True)
            assert found is None and stages[-1] == stage
        assert run_case(joint, folder / "killed", resume=True, pictures=True)[0] is not None
        compare(folder / "whole", folder / "killed")
        for name in ("force.png", "residual.png"):
            assert (folder / "killed" / name).exists() == (folder / "whole" / name).exists()
        with pytest.raises(ValueError, match="whose pictures differ"):
            run_case(joint, folder / "other", "unloading 1")
            Case(joint, folder / "other", COMM, pictures=True, resume=True, frames=4)


def check_a_folder_of_an_older_version_goes_on():
    """Its state does not say whether equilibria share factors: those that follow make their own. Numbers are those of
    shared ones to the tolerance of equilibria."""
    joint, found = TINY.changed(passes=2), []
    with shared_folder() as folder:
        assert run_case(joint, folder / "new", "preload 2")[0] is None
        if COMM.rank == 0:
            shutil.copytree(folder / "new", folder / "old")
            path = folder / "old" / "resume" / "state.json"
            state = json.loads(path.read_text())
            del state["seal"], state["carried"]["shares"]
            path.write_text(json.dumps({**state, "seal": seal(state)}))
        COMM.barrier()
        for name in ("new", "old"):
            summary, stages = run_case(joint, folder / name, resume=True)
            assert stages[:2] == ["mesh", "restart"] and stages[-1] == "unloading 2"
            found.append(summary)
    for name in ("static_force", "least_force", "peak_force"):
        new, old = (getattr(summary, name) for summary in found)
        assert old == pytest.approx(new, rel=1e-3), name


def check_a_run_in_a_folder_is_alone():
    """A second case is refused on all ranks while the first one is there."""
    with shared_folder() as folder:
        case = Case(SMALL, folder, COMM, pictures=False)
        with pytest.raises(RuntimeError, match="another run writes to"):
            Case(SMALL, folder, COMM, pictures=False)
        case.run.close()
        Case(SMALL, folder, COMM, pictures=False).run.close()


def check_prediction_of_a_long_run():
    """Number of steps and rate are those of the run itself, within what pressed springs change."""
    with shared_folder() as folder:
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


def check_a_lifted_wheel_needs_no_factors_of_its_own():
    """Nor do springs in the place of multipliers: those of the preload serve. Displacements are as with their own to
    the tolerance of equilibria."""
    found = []
    model = JointModel(TINY, COMM)
    for shared in (True, False):
        passage = Passage(model, progress=False)
        static = passage.preload()
        if not shared:
            passage._first, passage._shares = None, False
        passage.start(static)
        loaded = COMM.allreduce(np.abs(passage.u.x.array).max(), MPI.MAX)
        passage.unload()
        assert passage._shares == shared, "no factors but those of the preload were made"
        assert passage.residual.linear_solver.num_set_ups == 1
        found.append(passage.u.x.array.copy())
    # Elastic rails go back to where they were: to the tolerance of equilibria, 3e-5 of the forces.
    assert COMM.allreduce(np.abs(found[0] - found[1]).max(), MPI.MAX) < 1e-3 * loaded
