# SPDX-License-Identifier: MIT
"""Every parameter of `joint`, `study` and `creep` with everything that it cannot be: status 2 and one sentence."""

import math

import pytest

from impact_studies.creep import creep_command as creep
from impact_studies.creep.parameters import WheelOnRail
from impact_studies.rail_joint import joint_command as joint
from impact_studies.rail_joint import study
from impact_studies.rail_joint.parameters import RailJoint, Study

COMMANDS = {
    "joint": (RailJoint, joint.main), "study": (RailJoint, lambda a: study.main(["rail_joint", *a])),
    "creep": (WheelOnRail, creep.main),
}  # fmt: skip
TOML = ("[1, 2]", "{a = 1}", "1979-05-27", '"wrong"', '""', "nan", "-inf", "1e300", "-1e300", "[[1, 2], [0.1]]")
TEXTS = ("wrong", "", "nan", "-inf", "1e300", "-1e300", "1e999", "12 parsec", "0x10", "1_000", "[1", "__import__('os')")


@pytest.fixture
def nothing_runs(monkeypatch, tmp_path):
    """No command gets beyond its parameters, and none writes a file."""

    def fail(*_, **__):
        raise AssertionError("a run was begun")

    for module in (joint, study, creep):
        for name in ("Case", "RunFolder"):
            monkeypatch.setattr(module, name, fail, raising=False)
    monkeypatch.chdir(tmp_path)


def beside(parameters, name, low):
    """A value beside the range of a number, or None where there is no such end."""
    bounds = parameters.model_fields[name].json_schema_extra["bounds"]
    if low:
        end = bounds["low"] if bounds["low"] is not None else bounds["above"]
        return None if end is None else -1.0 if end == 0.0 else end - 0.01 * abs(end)
    return None if bounds["high"] is None else 1.01 * bounds["high"]


def refused(main, arguments, name, capsys):
    assert main(arguments) == 2, (name, arguments)
    out, err = capsys.readouterr()
    assert name in out and "Traceback" not in out + err and len(out.splitlines()) == 1, (arguments, out)


@pytest.mark.parametrize("command", COMMANDS)
def test_texts(command, nothing_runs, capsys):
    parameters, main = COMMANDS[command]
    for name in parameters.model_fields:
        texts = [*TEXTS, *(repr(v) for v in (beside(parameters, name, low) for low in (True, False)) if v is not None)]
        for text in texts:
            refused(main, [f"{name}={text}"], name, capsys)
    refused(main, ["no_such_name=1"], "no_such_name", capsys)


@pytest.mark.parametrize("command", COMMANDS)
def test_files(command, nothing_runs, capsys, tmp_path):
    parameters, main = COMMANDS[command]
    file = tmp_path / "given.toml"
    for name in parameters.model_fields:
        kind = parameters.model_fields[name].annotation
        more = ("5",) if kind is bool else ("true", "2.5", "10000000000000000000000") if kind is int else ("true",)
        for text in (*TOML, *(more if kind in (int, float, bool) else ("5", "true"))):
            file.write_text(f"{name} = {text}\n", encoding="utf-8")
            refused(main, [str(file)], name, capsys)
    for text, said in (("no_such_name = 1", "no_such_name"), ("[table]\nspeed = 1", "table"), ("a = ", "no TOML file"),
                       ("speed = 1\nspeed = 2", "no TOML file")):  # fmt: skip
        file.write_text(text, encoding="utf-8")
        refused(main, [str(file)], said, capsys)
    file.write_bytes(b"\x00\xff")
    refused(main, [str(file)], "no TOML file", capsys)
    refused(main, [str(tmp_path / "none.toml")], "cannot be read", capsys)
    refused(main, [str(tmp_path)], "cannot be read", capsys)
    refused(main, [str(file), "another.toml"], "more than one file", capsys)


@pytest.mark.parametrize("parameters", [RailJoint, WheelOnRail, Study])
def test_values_from_python(parameters):
    for name in parameters.model_fields:
        for value in (None, object(), {"a": 1}, 1 + 1j, b"5", math.nan, -math.inf, 10**400, -(10**400), {1.0}):
            with pytest.raises(ValueError) as found:
                parameters(**{name: value})
            assert str(found.value).startswith(f"{name} is ") and "\n" not in str(found.value)


@pytest.mark.parametrize("option", ["gap", "speed", "load", "end-post"])
@pytest.mark.parametrize("text", ["wrong", "nan", "inf", "-1", "1e300", "5,,6", "", "3 parsec"])
def test_lists_of_a_study(option, text, nothing_runs, capsys):
    refused(study.main, ["rail_joint", f"--{option}={text}"], option.replace("-", "_"), capsys)


@pytest.mark.parametrize("text", ["wrong", "nan", "inf", "-1", "0", "1e300", "2.5", ""])
def test_cases_at_once(text, nothing_runs, capsys):
    refused(study.main, ["rail_joint", f"--jobs={text}"], "jobs", capsys)


@pytest.mark.parametrize(
    "given, name",
    [
        ({"crown_radius": math.inf}, "wheel_crown_radius"), ({"wheel_crown_radius": -0.2}, "wheel_crown_radius"),
        ({"wheel_crown_radius": 0.0}, "wheel_crown_radius"), ({"crown_radius": 0.02}, "crown_radius"),
        ({"radius": 0.03}, "radius"), ({"reach": 40.0}, "reach|radius"), ({"path": 900.0}, "radius"),
        ({"wheel_crown_radius": -math.inf}, "wheel_crown_radius"), ({"speed": 1e9}, "speed"),
        ({"speed": 3000.0}, "speed"), ({"density": 1e12}, "speed"), ({"E": 10.0, "load": 1e-7}, "speed"),
        ({"load": 1e-12}, "load"), ({"E": 1e15, "load": 1e-6}, "load"),
    ],
)  # fmt: skip
def test_wheels_and_rails_that_do_not_fit(given, name):
    with pytest.raises(ValueError, match=name):
        WheelOnRail(**given)


def test_folders_that_cannot_be_written(tmp_path, capsys):
    """A file in the place of the folder."""
    file = tmp_path / "file"
    file.write_text("here")
    for main in (joint.main, creep.main, lambda a: study.main(["rail_joint", *a])):
        refused(main, ["--output", str(file)], str(file), capsys)


@pytest.mark.parametrize("command, parameters", [(joint.main, RailJoint), (creep.main, WheelOnRail)])
def test_the_template_is_a_file_of_parameters(command, parameters, tmp_path, capsys):
    assert command(["--template"]) == 0
    path = tmp_path / "given.toml"
    path.write_text(capsys.readouterr().out, encoding="utf-8")
    assert parameters.from_toml(path) == parameters()


def test_a_kernel_that_a_killed_run_left_unfinished(tmp_path, monkeypatch, capsys):
    """FFCx waits for it in vain; one sentence names the file."""

    def get_cached_module(*_):
        raise TimeoutError("JIT compilation timed out (e.g. remove /a b/lib_1.c) or increase timeout option.")

    monkeypatch.setattr("ffcx.codegeneration.jit.get_cached_module", get_cached_module)
    small = ["cells=1", "coarse=0.3", "load=400e3", "rail_length=0.2", "bar_length=0.1", "sleepers=0.3"]
    small += ["begin=-3e-3", "end=3e-3", "gap=3e-3", "wheel_mass=700"]
    for main, given in ((joint.main, small), (creep.main, ["cells=1", "reach=2.5"])):
        assert main([*given, "--output", str(tmp_path / main.__module__)]) == 1
        out, err = capsys.readouterr()
        assert "remove /a b/lib_1.c" in out.splitlines()[-1] and "Traceback" not in out + err


def test_one_steel():
    for name in ("E", "nu", "density"):
        assert getattr(RailJoint(), name) == getattr(WheelOnRail(), name)
