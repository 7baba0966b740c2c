# SPDX-License-Identifier: MIT
"""The command `dolfinx-impact creep`: its arguments, its files, and what it refuses."""

import argparse
import csv
from types import SimpleNamespace

import numpy as np
import pytest

from impact_studies.creep import creep_command
from impact_studies.creep.model import CreepModel
from impact_studies.creep.parameters import WheelOnRail


def test_sequences():
    np.testing.assert_allclose(creep_command.sequence("0:3e-3:4"), [0.0, 1e-3, 2e-3, 3e-3])
    np.testing.assert_allclose(creep_command.sequence("1e-3,2e-3"), [1e-3, 2e-3])
    np.testing.assert_allclose(creep_command.sequence("0.5"), [0.5])
    for text in ("0:1", "0:1:0", "a", "0:1:2:3", "nan", "1,,2", ""):
        with pytest.raises(argparse.ArgumentTypeError, match="FIRST:LAST:COUNT|finite"):
            creep_command.sequence(text)


@pytest.mark.parametrize("argument", ["--creep=0:1", "--lateral=5", "--spin=1:2:1000000000", "--creep=nan"])
def test_sequences_that_cannot_be_used(argument, capsys):
    with pytest.raises(SystemExit) as exit:
        creep_command.main([argument])
    assert exit.value.code == 2 and argument.split("=")[0] in capsys.readouterr().err


@pytest.mark.parametrize("argument", ["--load=-1", "--friction=0", "--radius=inf", "--speed=fast", "--cells=1.5"])
def test_numbers_that_cannot_be_used(argument, capsys):
    assert creep_command.main([argument]) == 2
    said = capsys.readouterr().out
    assert f"{argument.split('=')[0][2:]} is " in said and "give a" in said


def test_wheels_that_cannot_be_used(tmp_path, capsys):
    assert creep_command.main(["--crown-radius", "0.01", "--output", str(tmp_path)]) == 2
    assert "crown_radius" in capsys.readouterr().out


@pytest.mark.parametrize("forces", [[0.0], [-1.0], [50.0, 50.0]])
def test_an_approach_that_bears_nothing(forces):
    """Bodies that part, or a force that does not follow the approach: one sentence."""
    model = object.__new__(CreepModel)
    model.data = WheelOnRail(load=100.0)
    model.hertz, model.sides, model._axle = model.data.hertz, 1, [0]
    model._hub = SimpleNamespace(x=SimpleNamespace(array=np.zeros(3)))
    contact = SimpleNamespace(force=np.zeros(3))

    def solve():
        contact.force[2] = forces.pop(0)

    with pytest.raises(RuntimeError, match="no approach was found that bears 100 N"):
        model._press(SimpleNamespace(solve=solve, contact=[contact]))
    assert not forces


def test_points_of_another_wheel_are_refused_and_stay(tmp_path, capsys):
    """With the parameters that belong to them."""
    given = ["--cells", "1", "--reach", "2.5", "--creep", "1e-3", "--output", str(tmp_path)]
    assert creep_command.main(given) == 0
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    capsys.readouterr()
    assert creep_command.main([*given, "--load", "90 kN"]) == 2
    assert "dolfinx-impact creep: " in capsys.readouterr().out
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_files(tmp_path, capsys):
    """Lateral creep: the whole contact; the force is against the creep, and there is a table and a picture."""
    given = ["--cells", "2", "--creep", "1e-3", "--lateral", "0:2e-3:2", "--output", str(tmp_path)]
    assert creep_command.main(given) == 0
    assert "unknowns" in capsys.readouterr().out
    with open(tmp_path / "curve.csv", newline="") as file:
        rows = [row for row in csv.reader(line for line in file if not line.startswith("#"))]
    names = [name.split(" ")[0] for name in rows[0]]
    last = dict(zip(names, map(float, rows[-1])))
    first = dict(zip(names, map(float, rows[-2])))
    assert last["lateral"] == 2e-3 and last["Fy"] < -0.1 * last["Fx"] < 0.0
    assert abs(first["Fy"]) < 0.02 * first["Fx"]
    assert np.hypot(last["Fx"], last["Fy"]) == pytest.approx(last["ratio"] * 0.3 * last["Fz"], rel=1e-6)
    assert last["Fz"] == pytest.approx(100e3, rel=0.01)
    for name in ("creep.png", "curve.h5", "points.h5", "parameters.json"):
        assert (tmp_path / name).is_file()
