# SPDX-License-Identifier: MIT
"""Parameters of a rail joint: units, files, bad input."""

import math

import pytest

import dolfinx_impact as di
from dolfinx_impact.rail_joint import RailJoint
from dolfinx_impact.rail_joint.run import main, parameters


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
        ("speed=120 kN", "a number in km/h, m/s"), ("gap=thick", "a number in"), ("velocity=3", "no velocity; it has"),
        ("gap=0", "a positive number"), ("end_post=wood", "one of epoxy"), ("preset=huge", "coarse, medium, fine"),
        ("begin=0.1", "not over the gap"), ("passes=1.5", "a whole number"), ("support=ballast", "pads or winkler"),
        ("load=nan", "a number in"), ("smooth=perhaps", "true or false"),
    ],
)  # fmt: skip
def test_bad_values(text, message):
    with pytest.raises(ValueError, match=message):
        parameters([text])


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
