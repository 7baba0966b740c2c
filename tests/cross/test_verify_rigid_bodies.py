# SPDX-License-Identifier: MIT
"""Rigid bodies in `verify`: rows pass, and every kind of fault on one side is seen."""

import copy

import numpy as np
import pytest
import scenario_faults

import dolfinx_impact as di
from impact_verify import rigid_bodies
from impact_verify.report import Report
from impact_verify.scenarios import explicit_runs, implicit_runs

SMALL = 1 + 1e-4
STEPS = 6  # of runs that one side runs with a fault; bodies touch in the first ones


def of(body, **changes):
    """Another rigid body, with some changes."""
    given = {
        "mass": body.mass, "inertia": body.inertia, "centre": body.centre, "velocity": body._start_velocity,
        "spin": body._start_spin, "force": body.external_force, "torque": body.external_torque, "fixed": body.fixed,
        "meets": body.meets, "friction": body.friction,
    }  # fmt: skip
    return di.RigidBody(body.surface, **{**given, **changes})


def static_failures(case, **changes):
    """Forms of rows that fail when our body is another one."""
    report = Report()
    body = case.body.rigid[0]
    case.body.rigid = (of(body, **changes), case.body.rigid[1])
    rigid_bodies.compare_at_rest(report, case)
    return {row.name.split(" of ")[0] for row in report.failures()}


@pytest.mark.parametrize("steps", (60, pytest.param(rigid_bodies.STEPS, marks=pytest.mark.slow)))
def test_rows_pass(steps, monkeypatch):
    monkeypatch.setattr(rigid_bodies, "STEPS", steps)
    report = Report()
    rigid_bodies.run(report)
    assert report.passed and len(report.rows) >= 45, [(r.name, r.note) for r in report.failures()]
    assert {row.form for row in report.rows} == {"contact.rigid_static", "contact.rigid_meeting"}


@pytest.mark.parametrize("make", (rigid_bodies.tilted_plate, rigid_bodies.disc_with_torque))
def test_other_equilibria_are_seen(make):
    """Another centre, to which torques refer; a rotation that is fixed; a force that is another one."""
    case = make("quadrilateral", 1)
    centre = case.body.rigid[0].centre + [1e-4, 0.0, 0.0]
    assert {"rotation", "displacement"} <= static_failures(case, centre=centre)
    case = make("quadrilateral", 1)
    assert {"rotation", "contact force"} <= static_failures(case, fixed=("x", "rz"))


def test_another_torque_at_rest_is_seen():
    case = rigid_bodies.tilted_plate("quadrilateral", 1)
    right = di.RigidBody.external_torque
    wrong = property(right.fget, lambda self, value: right.fset(self, SMALL * np.asarray(value)))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(di.RigidBody, "external_torque", wrong)
        assert {"rotation", "displacement", "contact force"} <= static_failures(case)


@pytest.mark.parametrize("name", ("mass", "spin", "friction", "stiffness", "centre"))
def test_another_meeting_is_seen(name, monkeypatch):
    """Of the bodies what moves them, of their contact friction and stiffness."""
    monkeypatch.setattr(rigid_bodies, "STEPS", 60)
    ours, theirs, meeting = rigid_bodies.balls()
    first = ours[0]
    if name == "stiffness":
        monkeypatch.setattr(rigid_bodies, "PART_OF_LIMIT", SMALL * rigid_bodies.PART_OF_LIMIT)
    elif name == "centre":
        first = of(first, centre=first.centre + [0.0, 1e-4, 0.0])
    else:
        first = of(first, **{name: SMALL * (first._start_spin if name == "spin" else getattr(first, name))})
    report = Report()
    rigid_bodies.compare_meeting(report, "balls", [first, ours[1]], theirs, meeting)
    seen = {row.name.split(" of ")[0] for row in report.failures()}
    assert {"velocity", "kinetic energy"} <= seen, seen


@pytest.mark.parametrize("runs", (explicit_runs, implicit_runs))
@pytest.mark.parametrize("fault", ("angle", "pivot"))
def test_another_prescribed_rotation_is_seen(runs, fault):
    case = next(iter(runs.cam("quadrilateral", 1)))
    if fault == "angle" and runs is implicit_runs:
        case = next(case for case in runs.cam("quadrilateral", 1) if case.contact == "lagrange")
    changes = {"angle": lambda t: SMALL * case.angle(t)}
    if fault == "pivot":
        body = copy.copy(case.body)
        ours = di.RigidCylinder(case.body.rigid[0]._point, 0.8)
        ours.pivot = case.body.rigid[0].pivot + [1e-4, 0.0, 0.0]
        body.rigid = (ours, case.body.rigid[1])
        changes = {"body": body}
    seen = scenario_faults.failed(case, 30 if runs is implicit_runs else 150, **changes)
    assert {"displacement", "contact force", "external energy", "friction energy"} <= seen, seen


@pytest.mark.parametrize("name", ("mass", "inertia", "torque", "centre", "fixed"))
def test_another_rigid_body_in_implicit_steps_is_seen(name):
    kind = "lagrange" if name in ("mass", "torque") else "penalty"
    wanted = f"block under a rigid body, {kind}"
    case = next(case for case in implicit_runs.cam("quadrilateral", 1) if case.name == wanted)
    body, ours = copy.copy(case.body), case.body.rigid[0]
    values = {
        "torque": SMALL * ours.external_torque, "centre": ours.centre + [1e-4, 0.0, 0.0], "fixed": ("rz",),
    }  # fmt: skip
    value = values[name] if name in values else SMALL * getattr(ours, name)
    if name == "fixed":
        body.rigid = (of(ours, fixed=value, spin=0.0), body.rigid[1])
    else:
        body.rigid = (of(ours, **{name: value}), body.rigid[1])
    seen = scenario_faults.failed(case, STEPS, body=body)
    assert {"kinetic energy", "contact force", "displacement"} <= seen, seen


@pytest.mark.slow
def test_rows_of_runs_pass():
    """They are rows of the level history; those in the plane pass in test_verify_history.py."""
    from impact_verify import runs_in_time

    report = Report()
    for runs in (explicit_runs, implicit_runs):
        for cell in ("quadrilateral", "hexahedron"):
            for case in runs.cam(cell, 1):
                runs_in_time.compare(report, case)
    assert report.passed and len(report.rows) == 61
