# SPDX-License-Identifier: MIT
"""Level history of `verify`: explicit runs agree, and every kind of fault on one side is seen."""

import copy
import itertools

import numpy as np
import pytest
import scenario_faults

import dolfinx_impact as di
from dolfinx_impact import _cpp
from dolfinx_impact.contact.explicit.nodal import NodalPair
from dolfinx_impact.dynamics import explicit_bodies
from impact_verify import cross_check, runs_in_time, yielding_runs
from impact_verify.contact_bodies import SLAVE
from impact_verify.report import Report
from impact_verify.scenarios import explicit_runs
from impact_verify.scenarios import scenario as scenarios

STEPS = 150  # a fault shows soon


def cases(cell, degree):
    return itertools.chain.from_iterable(
        make(cell, degree) for c, d, make in explicit_runs.RUNS if (c, d) == (cell, degree)
    )


def case_of(cell, name):
    return next(case for case in cases(cell, 1) if case.name == name)


@pytest.mark.parametrize(
    "steps", (STEPS // 6, pytest.param(scenarios.STEPS[scenarios.Explicit], marks=pytest.mark.slow))
)
def test_rows_of_a_cell_pass(steps, monkeypatch):
    """Bars, a disc that comes to roll, rigid masters, bodies without contact; both kinds of contact. All steps of these
    runs are rows of `verify`, which CI runs as well: here they are those of the level at all."""
    monkeypatch.setattr(runs_in_time, "run_implicit", lambda report: None)  # test_verify_implicit.py
    monkeypatch.setattr(yielding_runs, "run", lambda report: None)
    right = runs_in_time.compare
    monkeypatch.setattr(runs_in_time, "compare", lambda r, case: right(r, case, min(case.num_steps, steps)))
    report = cross_check(cells=["quadrilateral"], degrees=[1], levels=["history"])
    assert report.passed and len(report.rows) > 100
    kinds = {row.form for row in report.rows}
    contacts = ("penalty", "kinematic", "general", "free")
    # Cells with one point: test_verify_one_point.py.
    others = {k for k in kinds if not k.startswith("j2.") and not k.endswith(".reduced")}
    assert others == {f"explicit.{contact}" for contact in contacts}
    assert any(k.startswith("j2.") for k in kinds), "bodies that yield: test_verify_material.py"
    what = {row.name.split(" of the ")[0] for row in report.rows}
    assert {
        "displacement",
        "velocity",
        "contact force",
        "kinetic energy",
        "friction energy",
        "viscosity energy",
    } <= what


@pytest.mark.long_rows(where=lambda cell: cell == "tetrahedron")
@pytest.mark.parametrize("cell", ("hexahedron", "tetrahedron"))
@pytest.mark.parametrize("steps", (STEPS // 5, pytest.param(STEPS, marks=pytest.mark.slow)))
def test_rows_in_space_pass(steps, cell):
    report = Report()
    for case in cases(cell, 1):
        runs_in_time.compare(report, case, steps)
    assert report.passed and len(report.rows) > 10


def compare_varied_runs(runs, seeds=None, steps=None):
    report = Report()
    for cell, degree, make in runs:
        for case in explicit_runs.varied_runs(cell, degree, make, seeds):
            runs_in_time.compare(report, case, steps)
    return report


PLANE = [run for run in explicit_runs.RUNS if run[0] == "quadrilateral"]
SPACE = [run for run in explicit_runs.RUNS if run[0] in ("hexahedron", "tetrahedron")]


def test_variations_in_the_plane_pass():
    """Variations that the level itself does not contain."""
    report = compare_varied_runs(PLANE, [11], STEPS)
    assert report.passed and len(report.rows) > 100


def test_a_variation_in_space_passes():
    report = compare_varied_runs([("hexahedron", 1, explicit_runs.overhang)], [11], STEPS)
    assert report.passed and len(report.rows) > 10


@pytest.mark.slow
def test_many_variations_pass():
    for runs, seeds in ((PLANE, range(20, 32)), (SPACE, range(20, 23))):
        report = compare_varied_runs(runs, seeds)
        assert report.passed and len(report.rows) > 100


def test_variations_differ():
    """Step, rotation and velocities differ between seeds; the same seed gives the same variation."""
    first, second, again = (
        next(iter(explicit_runs.varied_runs("quadrilateral", 1, explicit_runs.overhang, [seed]))) for seed in (1, 2, 1)
    )
    places = [case.body.V.tabulate_dof_coordinates()[:, :2] for case in (first, second, again)]
    velocities = [case.velocity(x) for case, x in zip((first, second, again), places)]
    assert first.step_fraction == again.step_fraction != second.step_fraction
    for one, two, three in (places, velocities):
        assert np.array_equal(one, three) and np.abs(one - two).max() > 1e-3


def test_velocities_do_not_depend_on_round_off_of_places():
    """The lower body's top is at 1 to round-off only."""
    for case in cases("hexahedron", 1):
        # The ball falls on a block at rest, and the cam turns on one.
        if "block" in case.name and not any(rigid in case.name for rigid in ("ball", "cam")):
            places = case.body.V.tabulate_dof_coordinates()
            expected = case.velocity(places)
            assert np.any(expected) and not np.any(expected[np.isclose(places[:, 2], 1.0, atol=1e-9)])
            for error in (-1e-15, 1e-15):
                assert np.array_equal(case.velocity(places + error), expected)


@pytest.mark.parametrize("cell", ("quadrilateral", "hexahedron"))
def test_facing_by_the_normals_of_the_last_search_is_seen(cell, monkeypatch):
    """The starts of the level show it, in the plane and in space."""
    make = NodalPair.__init__

    def keep(self, *args, **kwargs):
        make(self, *args, **kwargs)
        for side in self.sides():
            side.keep_normals(True)

    monkeypatch.setattr(NodalPair, "__init__", keep)
    try:
        report = compare_varied_runs([(cell, 1, explicit_runs.overhang)])
    except RuntimeError as error:  # springs that are pressed from nowhere bring energy
        assert "unstable" in str(error)
    else:
        assert {"contact force", "displacement"} <= {row.name.split(" of the ")[0] for row in report.failures()}


def failed(case, **changes):
    """What a comparison sees when one side runs a changed case."""
    return scenario_faults.failed(case, STEPS, **changes)


SMALL = 1 + 1e-6


def another_ball(case, **changes):
    """The case with another ball on our side."""
    right = case.body.rigid[0]
    given = {
        "mass": right.mass, "inertia": right.inertia, "velocity": right._start_velocity, "spin": right._start_spin,
        "force": right.external_force,
    }  # fmt: skip
    body = copy.copy(case.body)
    body.rigid = (di.RigidBody(right.surface, **{**given, **changes}), case.body.rigid[1])
    return body


@pytest.mark.parametrize("cell", ("quadrilateral", "hexahedron"))
@pytest.mark.parametrize("name", ("mass", "inertia", "velocity", "spin", "force", "fixed"))
def test_another_rigid_ball_is_seen(cell, name):
    """A part in a million of what moves the ball; a component that is fixed on one side."""
    case = case_of(cell, "block under a rigid ball")
    value = ("x",) if name == "fixed" else SMALL * np.asarray(vars(case.body.rigid[0]).get(name, 0.0))
    if name in ("velocity", "spin"):
        value = SMALL * getattr(case.body.rigid[0], f"_start_{name}")
    if name == "force":
        value = SMALL * case.body.rigid[0].external_force
    seen = failed(case, body=another_ball(case, **{name: value if np.ndim(value) or name == "fixed" else float(value)}))
    assert {"contact force", "kinetic energy"} <= seen, seen
    assert not failed(case), "the case itself passes"


def tilted(x):
    """Normals of the smooth hill, a millionth off."""
    return np.vstack([SMALL * (x[0] - 0.5), np.ones(x.shape[1])])


@pytest.mark.parametrize(
    "cell, name, changes, seen",
    (
        ("quadrilateral", "shaken", {"damping": (1e-6, 0.0)}, {"displacement", "velocity", "damping energy"}),
        ("quadrilateral", "damped, linear-elastic", {"damping": (0.1, 0.004 * SMALL)}, {"displacement"}),
        ("quadrilateral", "damped, neo-hookean", {"damping": (0.1 * SMALL, 0.004)}, {"velocity"}),
        ("quadrilateral", "classical scheme, damped", {"velocities": "half_step"}, {"displacement", "velocity"}),
        ("quadrilateral", "viscous, linear-elastic", {"viscosity": (0.06 * SMALL, 1.2)}, {"viscosity energy"}),
        ("quadrilateral", "viscous, neo-hookean", {"viscosity": (0.06, 1.2 * SMALL)}, {"displacement"}),
        (
            "quadrilateral",
            "support that moves",
            {"motion": lambda t: 0.02 * SMALL * np.sin(3 * t)},
            {"external energy"},
        ),
        ("quadrilateral", "shaken", {"gravity": (np.array([0.0, -1e-6]), lambda t: 1.0)}, {"external energy"}),
        ("quadrilateral", "disc on a block, penalty", {"options": {"balanced": True}}, {"contact force"}),
        ("quadrilateral", "disc on a block, kinematic", {"options": {"sweeps": 2}}, {"contact force"}),
        ("quadrilateral", "body on a smooth hill, balanced penalty", {"smooth": None}, {"contact force"}),
        ("hexahedron", "body on a smooth hill, balanced penalty", {"smooth": None}, {"contact force", "displacement"}),
        ("triangle", "body on a smooth hill, kinematic", {"smooth": tilted}, {"contact force", "displacement"}),
        (
            "quadrilateral",
            "block under a rigid cylinder that moves, penalty",
            {"obstacle": lambda t: np.array([0.01 * t, -0.03 * SMALL * np.sin(t / 4)])},
            {"contact force", "external energy"},
        ),
    ),
)
def test_a_fault_in_what_is_given_is_seen(cell, name, changes, seen):
    assert seen <= failed(case_of(cell, name), **changes)


ON_SPRINGS, ON_DASHPOTS = "body on normal springs, linear-elastic", "body on springs and dashpots, linear-elastic"


@pytest.mark.parametrize(
    "name, foundation, seen",
    (
        (ON_SPRINGS, (0.4 * SMALL, 0.0), {"displacement", "internal energy"}),
        (ON_SPRINGS, (np.array([1e-6, 0.4]), 0.0), {"displacement"}),  # no springs along the surface
        (ON_DASHPOTS, (np.array([0.3, 0.5]), 0.2 * SMALL), {"displacement", "damping energy"}),
        (ON_DASHPOTS, (np.array([0.3, 0.5]), np.array([1e-6, 0.2])), {"velocity"}),
    ),
)
def test_other_springs_and_dashpots_are_seen(name, foundation, seen):
    assert seen <= failed(case_of("quadrilateral", name), foundation=foundation)


def test_another_added_mass_is_seen():
    case = case_of("quadrilateral", "body on normal springs and dashpots, with mass, neo-hookean")
    assert {"displacement", "kinetic energy"} <= failed(case, added_mass=case.added_mass * SMALL)


def test_springs_that_count_as_loads_are_seen(monkeypatch):
    """The motion is right then, energies are not."""
    right = explicit_bodies.ExplicitBodies.add

    def wrong(self, form, kind):
        kinds = _cpp.integrators.WorkKind
        return right(self, form, kinds.damping if kind == kinds.foundation else kind)

    monkeypatch.setattr(explicit_bodies.ExplicitBodies, "add", wrong)
    assert failed(case_of("quadrilateral", ON_SPRINGS)) == {"internal energy", "damping energy"}


def test_springs_in_the_damping_by_stiffness_are_seen(monkeypatch):
    """Rayleigh's beta is of the bodies' stiffness alone."""
    right = explicit_bodies.stiffness_damping

    def wrong(u, velocity, v, material, beta):
        springs = case.body.tags, SLAVE, case.foundation[0]
        return right(u, velocity, v, material, beta) + beta * di.Foundation(*springs).springs(velocity, v)

    case = case_of("quadrilateral", ON_DASHPOTS)
    monkeypatch.setattr(explicit_bodies, "stiffness_damping", wrong)
    assert {"displacement", "damping energy"} <= failed(case)


def test_another_friction_is_seen():
    case = case_of("quadrilateral", "disc on a block, penalty")
    changed = copy.copy(case.body)
    changed.friction *= SMALL
    assert {"contact force", "friction energy"} <= failed(case, body=changed)


def test_another_contact_stiffness_is_seen(monkeypatch):
    """The share of the nodal stiffness, a millionth off."""
    right = NodalPair._make
    monkeypatch.setattr(NodalPair, "_make", lambda self, **options: right(self, **options, share=1 / SMALL))
    assert {"contact force", "displacement"} <= failed(case_of("hexahedron", "block on a block, neo-hookean, penalty"))


def test_another_mass_is_seen(monkeypatch):
    from dolfinx_impact.assembly import lumped_mass

    right = lumped_mass.cell_masses
    monkeypatch.setattr(lumped_mass, "cell_masses", lambda *a, **k: [(c, m * SMALL) for c, m in right(*a, **k)])
    assert {"displacement", "kinetic energy"} <= failed(case_of("quadrilateral", "shaken"))


def test_another_energy_is_seen(monkeypatch):
    """Energies are compared by themselves: the motion may be right."""
    right = di.ExplicitProblem.energy_history.fget

    def wrong(self):
        rows = right(self).copy()
        rows[7, 2] *= SMALL
        return rows

    monkeypatch.setattr(di.ExplicitProblem, "energy_history", property(wrong))
    assert failed(case_of("quadrilateral", "shaken")) == {"internal energy"}
