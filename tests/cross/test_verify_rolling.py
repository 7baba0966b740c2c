# SPDX-License-Identifier: MIT
"""Level rolling of `verify`: both sides agree, and every kind of fault on one side is seen."""

import functools

import impact_reference
import numpy as np
import pytest
import ufl

from dolfinx_impact import _cpp
from dolfinx_impact.forms import ale
from dolfinx_impact.rolling.rolling_contact import RollingContact
from dolfinx_impact.rolling.flow import Flow
from dolfinx_impact.rolling.motions import Translation
from impact_verify import cross_check, levels, rolling
from impact_verify.report import Report
from impact_verify.rolling_bodies import RollingCase

SMALL = 1 + 1e-6
CREEPS = ((-1.5e-3, 0.0), (8e-3, 0.0))


def on_plane(friction=0.3, **options):
    options = {"creeps": CREEPS} | options
    return RollingCase("cylinder on a rigid plane", "quadrilateral", "plane_strain", 20, friction=friction, **options)


def on_rail(friction=0.3, **options):
    options = {"creeps": CREEPS, "depth": 0.02} | options
    return RollingCase("wheel on a rail", "quadrilateral", "plane_strain", 20, 0, (23, 6), friction, **options)


def in_space(friction=0.3, cell="hexahedron"):
    creeps = ((2e-3, 3e-3), (0.1, 0.2))
    return RollingCase("short cylinder on a rigid plane", cell, "3d", 12, 2, (), friction, creeps, 0.03)


def report_of(compare, *arguments):
    report = Report()
    compare(report, *arguments)
    return report


def names(rows):
    return {row.name.split(" of the ")[0] for row in rows}


def failed(compare, *arguments):
    """Quantities whose rows fail."""
    report = report_of(compare, *arguments)
    assert all(row.level == "rolling" and row.note for row in report.failures())
    return names(report.failures())


@functools.cache
def free(cell):
    return next(case for case in rolling.free_bodies() if case.cell == cell)


# --- both sides agree ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("cell", ["quadrilateral", "triangle", "hexahedron", "tetrahedron"])
def test_matrices_and_frequencies_pass(cell):
    report = report_of(rolling.compare_matrices, free(cell))
    assert report.passed and names(report.rows) == {"K - W", "W", "G", "M", "load"}
    assert report_of(rolling.compare_frequencies, free(cell)).passed


@pytest.mark.parametrize("make", [on_plane, on_rail, in_space, functools.partial(in_space, cell="tetrahedron")])
def test_solutions_pass(make):
    """With friction, stages with stick and slip at once; without friction, and with a law of finite strain."""
    case = make()
    report = report_of(rolling.compare_solutions, case)
    assert report.passed, [(row.name, row.note) for row in report.failures()]
    assert {"u", "multipliers", "gap", "torque", "slip velocity", "status", "friction power"} <= names(report.rows)
    assert report_of(rolling.compare_solutions, make(friction=0.0)).passed


def test_finite_strain_passes():
    assert report_of(rolling.compare_solutions, on_plane(law="neo_hookean")).passed


def test_partial_slip_is_part_of_the_rows():
    """Rows that compare stick alone, or slip alone, would say little."""
    case = on_plane(creeps=rolling.PLANE)
    statuses, right = [], impact_reference.RollingModel.solve

    def watch(self, *arguments, **options):
        found = right(self, *arguments, **options)
        statuses.append(set(found.status[found.status > 0]))
        return found

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(impact_reference.RollingModel, "solve", watch)
        assert report_of(rolling.compare_solutions, case).passed
    assert {1, 2} in statuses and {2} in statuses


@pytest.mark.parametrize("number", range(3))
def test_free_rolling_passes(number):
    report = report_of(rolling.compare_free_rolling, list(rolling.free_rolling())[number])
    assert report.passed and "omega" in names(report.rows)


@pytest.mark.slow
def test_all_rows_pass():
    report = Report()
    rolling.run(report)
    assert report.passed and len(report.rows) > 200


def test_level_belongs_to_verify(monkeypatch):
    called = []
    monkeypatch.setattr(rolling, "run", lambda report, progress: called.append(report))
    assert "rolling" in levels.LEVELS and cross_check(levels=["rolling"]) is called[0]


# --- faults: each is seen, and without it the same rows pass above ---------------------------------------------------


def test_no_inertia_is_seen(monkeypatch):
    """W left out, with the centrifugal load at the undeformed radius."""
    monkeypatch.setattr(ale, "ale_inertia", lambda u, v, density, w, dx: 0.0 * ufl.inner(u, v) * dx)
    assert {"K - W", "W"} <= failed(rolling.compare_matrices, free("quadrilateral"))
    assert {"u", "torque"} <= failed(rolling.compare_solutions, on_plane())


@pytest.mark.parametrize("factor", [-1.0, SMALL])
def test_another_gyroscopic_matrix_is_seen(monkeypatch, factor):
    """A wrong sign exchanges waves with the flow and against it."""
    right = ale.gyroscopic
    monkeypatch.setattr(ale, "gyroscopic", lambda *a: factor * right(*a))
    assert failed(rolling.compare_matrices, free("quadrilateral")) == {"G"}
    assert failed(rolling.compare_frequencies, free("quadrilateral"))


def test_a_missing_load_is_seen(monkeypatch):
    right = ale.centrifugal_load
    monkeypatch.setattr(ale, "centrifugal_load", lambda *a: SMALL * right(*a))
    assert failed(rolling.compare_matrices, free("triangle")) == {"load"}


def test_a_translation_with_a_load_is_seen(monkeypatch):
    """A straight flow has no acceleration: a load at zero displacement would be one of its ends."""
    right = Flow.form

    def wrong(self, u, v, material):
        form, dx = right(self, u, v, material), ufl.dx(domain=u.function_space.mesh)
        for tag, motion in self._motions.items():
            if isinstance(motion, Translation):
                form += ale.centrifugal_load(v, self._indicators[tag], self._constants[motion], dx)
        return form

    monkeypatch.setattr(Flow, "form", wrong)
    assert failed(rolling.compare_matrices, free("quadrilateral")) == {"load"}


# The least fault is looked for on all bodies. Greater ones, with which solutions are hardly found, on one.
@pytest.mark.long_rows(where=lambda make, factor: factor != SMALL and make is not on_plane)
@pytest.mark.parametrize("make", [on_plane, on_rail, in_space])
@pytest.mark.parametrize("factor", [-1.0, 0.0, SMALL])
def test_another_convective_derivative_is_seen(monkeypatch, make, factor):
    """Wrong sign, left out, and off by a millionth: (Grad u) w in the velocities."""
    right = impact_reference.streamlines.derivative

    def wrong(*given):
        matrix = right(*given)
        return impact_reference.streamlines.Csr(matrix.indptr, matrix.indices, factor * np.asarray(matrix.data))

    monkeypatch.setattr(impact_reference.streamlines, "derivative", wrong)
    assert {"u", "multipliers", "torque"} <= failed_or_stuck(make())


def failed_or_stuck(case):
    """Quantities that fail; all of them if the side with the fault finds no solution."""
    try:
        return failed(rolling.compare_solutions, case)
    except RuntimeError as error:
        assert "did not converge" in str(error) or "were not found" in str(error)
        return {"u", "multipliers", "torque", "slip velocity"}


@pytest.mark.long_rows(where=lambda make: make is in_space)
@pytest.mark.parametrize("make", [on_plane, on_rail, in_space])
def test_the_derivative_downstream_is_seen(monkeypatch, make):
    """On the hand-written side, whose scores are turned round."""
    right = impact_reference.streamlines.upstream_score
    monkeypatch.setattr(impact_reference.streamlines, "upstream_score", lambda c: right(-c))
    assert {"u", "multipliers", "torque"} <= failed_or_stuck(make())


def test_the_mean_of_both_sides_is_seen(monkeypatch):
    """A central derivative."""
    monkeypatch.setattr(impact_reference.streamlines, "upstream_score", lambda c: 0.0)
    assert {"u", "multipliers"} <= failed_or_stuck(on_plane())


def test_slip_without_the_derivative_of_the_master_is_seen(monkeypatch):
    """Only a master that deforms has one."""
    monkeypatch.setattr(impact_reference.streamlines, "add", lambda of_slave, of_master, factor=1.0: of_slave)
    assert {"u", "multipliers", "torque"} <= failed_or_stuck(on_rail())


def test_slip_without_the_speed_of_the_master_is_seen(monkeypatch):
    monkeypatch.setattr(RollingContact, "update_obstacle", lambda self: None)
    assert {"u", "multipliers", "slip velocity"} <= failed_or_stuck(on_plane())


def test_another_friction_is_seen(monkeypatch):
    def wrong(self, V, slave, master, options, fixed):
        other = _cpp.multipliers.MortarOptions(name=options.name, friction=SMALL * options.friction)
        return _cpp.rolling.RollingContact(V, slave, master, other, fixed, self.spec.flow._cpp_object)

    monkeypatch.setattr(RollingContact, "_in_cpp", wrong)
    assert {"u", "multipliers", "torque"} <= failed(rolling.compare_solutions, on_plane())


@pytest.mark.parametrize("name, factor", [("slip_velocity", SMALL), ("torque", SMALL), ("friction_power", SMALL)])
def test_a_result_off_by_a_millionth_is_seen(monkeypatch, name, factor):
    right = impact_reference.RollingModel.solve

    def wrong(self, *arguments, **options):
        found = right(self, *arguments, **options)
        setattr(found, name, getattr(found, name) * factor)
        return found

    monkeypatch.setattr(impact_reference.RollingModel, "solve", wrong)
    assert failed(rolling.compare_solutions, on_plane()) == {name.replace("_", " ")}
