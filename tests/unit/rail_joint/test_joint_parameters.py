# SPDX-License-Identifier: MIT
"""Parameters of a rail joint: units, files, bad input."""

import math

import pytest

import dolfinx_impact as di
from impact_studies.rail_joint import RailJoint
from impact_studies.rail_joint.joint_command import main, parameters


def test_a_file_says_what_the_object_has(tmp_path):
    joint = RailJoint().changed(speed=40.0, end_post="nylon", head_profile=((-0.04, -3e-3), (0.0, 0.0), (0.04, -3e-3)))
    path = tmp_path / "joint.toml"
    path.write_text(joint.to_toml(), encoding="utf-8")
    assert RailJoint.from_toml(path) == joint


@pytest.mark.parametrize(
    "name, text, value",
    [
        ("speed", "160 km/h", 160 / 3.6), ("speed", "30", 30.0), ("gap", "6 mm", 6e-3), ("load", "1.1e2 kN", 110e3),
        ("pad_stiffness", "80 kN/mm", 80e6), ("yield_stress", "inf", math.inf), ("friction", "25 %", 0.25),
        ("passes", "3", 3), ("E", "206 GPa", 206e9), ("smooth", "true", True), ("end_post", "ptfe", "ptfe"),
    ],
)  # fmt: skip
def test_units(name, text, value):
    assert getattr(parameters([f"{name}={text}"]), name) == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize(
    "text, message",
    [
        ("speed=120 kN", r"from 0.1 to 200 \[m/s\] \(or a text in km/h\)"), ("gap=thick", "from 0.0001 to"),
        ("velocity=3", "no velocity; it has"), ("spede=3", "did you mean speed"), ("end_post=wood", "one of epoxy"),
        ("preset=huge", "coarse, medium, fine"), ("begin=-1 mm", "does not roll over the gap"),
        ("support=ballast", "pads, winkler"), ("smooth=perhaps", "true or false"),
        ("bar_length=5", "rail_length is 1.5"),
        ("end=0.6", "bar_length is 0.9"), ("rail_length=0.2", "rail_length is 0.2 m: give more than half"),
        ("wheel_mass=200 kg", "the rim alone"), ("wheel_radius=0.8", "wheel_mass is 600 kg: the rim alone"),
        ("head_profile=[[0, 0], [1, 1], [2, 2]]", "ascending y from"), ("E=1 GPa", "mm wide, more than half"),
        ("head_profile=[[-0.04, 0], [0.04, 0], [0, 0]]", "ascending y"),
    ],
)  # fmt: skip
def test_bad_values(text, message):
    with pytest.raises(ValueError, match=message):
        parameters([text])


def test_sleepers_that_the_rails_do_not_reach():
    with pytest.raises(ValueError, match="sleepers is 2 m: the rails of 0.8 m"):
        RailJoint(sleepers=2.0, rail_length=0.8)
    assert RailJoint(sleepers=2.0, rail_length=0.8, support="winkler").sleepers == 2.0


def test_values_by_place_and_twice():
    assert RailJoint("medium", 100e3).load == 100e3
    with pytest.raises(TypeError, match="given twice: preset"):
        RailJoint("medium", preset="fine")


def test_bad_files(tmp_path, capsys):
    broken = tmp_path / "broken.toml"
    broken.write_text("speed = = 3\n", encoding="utf-8")
    for path, message in ((broken, "is no TOML file"), (tmp_path / "none.toml", "cannot be read")):
        with pytest.raises(ValueError, match=message):
            RailJoint.from_toml(path)
        assert main([str(path)]) == 2 and message in capsys.readouterr().out


def test_the_template_is_a_file_of_parameters(tmp_path, capsys):
    assert main(["--template", "gap=5 mm"]) == 0
    path = tmp_path / "joint.toml"
    path.write_text(capsys.readouterr().out, encoding="utf-8")
    assert RailJoint.from_toml(path).gap == pytest.approx(5e-3)


def test_cells_follow_the_contact_of_hertz():
    joint = RailJoint()
    hertz = di.theory.hertz_elliptic(130e3, 0.46, math.inf, math.inf, 0.30, 207e9, 0.3, 207e9, 0.3)
    assert joint.cell_size == pytest.approx(hertz.a / 4) and joint.changed(preset="fine").cell_size == hertz.a / 16
    assert joint.changed(cells=3).cell_size == pytest.approx(hertz.a / 3)
    assert joint.sides == 2 and joint.changed(cone=0.05).sides == 1


def test_p2_needs_a_period_of_the_wheel_on_its_track():
    """The beam on a bed by its deflection under a load: w = P b / (2 k), b = (k / (4 E I))^(1/4)."""
    joint = RailJoint()
    bed = 100e6 / 0.6
    stiffness = 2.0 * bed / (bed / (4.0 * 207e9 * 3038e-8)) ** 0.25
    assert joint.track_stiffness == pytest.approx(stiffness, rel=1e-12)
    assert joint.p2_period == pytest.approx(2.0 * math.pi * math.sqrt(600.0 / stiffness), rel=1e-12)
    assert 8e-3 < joint.p2_period < 30e-3, "what is told of P2"
    for speed in (60.0 / 3.6, 120.0 / 3.6, 200.0 / 3.6):
        short = joint.changed(speed=speed)
        long = short.for_p2()
        assert not short.shows_p2 and long.shows_p2 and long.cells == 2
        assert not long.changed(end=0.98 * long.end).shows_p2
    assert joint.changed(cells=3).for_p2().cells == 3
