# SPDX-License-Identifier: MIT
"""The command dolfinx-impact: lists, exit statuses, info; verify, compile and bench get their arguments."""

import os
import signal
import sys
import types

import pytest

from dolfinx_impact import cli, compat


def test_list_names_every_demo_with_its_title(command):
    status, output, _ = command("demo", "--list")
    assert status == 0
    for name, (path, title) in cli.demos().items():
        assert name in output and title in output and path.exists()
    assert output.index("hertz ") < output.index("applications:") < output.index("wheel_on_rail")
    assert "__init__" not in output and "figures" not in output


def test_an_unknown_demo_lists_what_there_is(command):
    status, output, errors = command("demo", "weel_on_rail")
    assert status == 2 and output == ""
    assert "weel_on_rail" in errors and "did you mean wheel_on_rail" in errors and "rolling_disc" in errors


@pytest.mark.parametrize("arguments", (["demo"], ["demo", "rolling_disc", "--ranks", "0"], ["nonsense"], []))
def test_bad_arguments_give_status_2(arguments, impact):
    status, _, errors = impact(*arguments)
    assert status == 2 and errors


@pytest.mark.mpi
@pytest.mark.parametrize("ranks", (1, 2))
@pytest.mark.parametrize("code, wanted", (("import sys; sys.exit(7)", 7), ("raise SystemExit(0)", 0), ("1 / 0", 1)))
def test_the_exit_status_passes_through(ranks, code, wanted, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    script = tmp_path / "own.py"
    script.write_text(f"from mpi4py import MPI\n{code}\n")
    monkeypatch.setattr(cli, "demos", lambda: {"own": (script, "Own")})
    assert cli.main(["demo", "own", "--ranks", str(ranks)]) == wanted


def test_a_signal_gives_128_more(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    script = tmp_path / "own.py"
    script.write_text("import os, signal\nos.kill(os.getpid(), signal.SIGKILL)\n")
    monkeypatch.setattr(cli, "demos", lambda: {"own": (script, "Own")})
    assert cli.main(["demo", "own"]) == 128 + signal.SIGKILL


def test_output_reaches_the_demo_as_a_full_path(tmp_path, monkeypatch, capfd):
    script = tmp_path / "own.py"
    script.write_text("import os\nprint(os.environ['IMPACT_OUTPUT'])\n")
    monkeypatch.setattr(cli, "demos", lambda: {"own": (script, "Own")})
    monkeypatch.chdir(tmp_path)
    assert cli.main(["demo", "own", "--output", "here"]) == 0
    assert capfd.readouterr().out.splitlines() == [str(tmp_path / "here"), "results in here"]


@pytest.mark.parametrize("output, folder", ((("--output", "here"), "here"), ((), "results/own")))
def test_a_demo_runs_in_the_folder_of_its_results(output, folder, tmp_path, monkeypatch, capfd):
    script = tmp_path / "own.py"
    script.write_text("import os\nprint(os.getcwd())\n")
    monkeypatch.setattr(cli, "demos", lambda: {"own": (script, "Own")})
    monkeypatch.chdir(tmp_path)
    assert cli.main(["demo", "own", *output]) == 0
    assert capfd.readouterr().out.splitlines() == [str(tmp_path / folder), f"results in {folder}"]


def test_an_application_runs_where_it_was_started(tmp_path, monkeypatch, capfd):
    script = tmp_path / "applications" / "own.py"
    script.parent.mkdir()
    script.write_text("import os\nprint(os.getcwd())\n")
    monkeypatch.setattr(cli, "demos", lambda: {"own": (script, "Own")})
    monkeypatch.chdir(tmp_path)
    assert cli.main(["demo", "own"]) == 0
    assert capfd.readouterr().out.strip() == str(tmp_path)


def test_a_folder_that_cannot_be_made_gives_status_2(tmp_path, monkeypatch, capsys):
    (tmp_path / "file").write_text("in the way")
    monkeypatch.setattr(cli, "demos", lambda: {"own": (tmp_path / "own.py", "Own")})
    assert cli.main(["demo", "own", "--output", str(tmp_path / "file" / "below")]) == 2
    assert "results cannot be written to" in capsys.readouterr().err


def test_a_demo_finds_the_mpi_of_dolfinx_s_wheel(tmp_path, monkeypatch):
    """Demos import DOLFINx before this package, and the wheel's DOLFINx does not find MPI by itself then."""
    monkeypatch.setenv("LD_LIBRARY_PATH", "/before")
    monkeypatch.setattr(cli.compat.importlib.util, "find_spec", lambda name: None)
    assert cli._environment(None)["LD_LIBRARY_PATH"] == "/before"
    origin = tmp_path / "lib" / "python3.13" / "site-packages" / "dolfinx_solver" / "__init__.py"
    monkeypatch.setattr(cli.compat.importlib.util, "find_spec", lambda name: types.SimpleNamespace(origin=str(origin)))
    assert cli._environment(None)["LD_LIBRARY_PATH"] == f"{tmp_path}/lib:/before"


def test_without_mpirun_it_says_so(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(cli, "mpi_launcher", lambda: None)
    assert cli.main(["demo", "rolling_disc", "--ranks", "2"]) == 2
    assert "mpirun" in capsys.readouterr().err


@pytest.mark.parametrize(
    "command, module",
    (
        ("verify", "impact_verify.verify_command"),
        ("compile", "dolfinx_impact.compile.compile_command"),
        ("bench", "impact_studies.bench.bench_command"),
    ),
)
def test_commands_with_options_of_their_own_get_their_arguments(command, module, monkeypatch):
    seen = []
    stand_in = types.ModuleType(module)
    stand_in.main = lambda arguments: seen.append(arguments) or 3
    monkeypatch.setitem(sys.modules, stand_in.__name__, stand_in)
    assert cli.main([command, "--json", "out.json", "--help"]) == 3
    assert seen == [["--json", "out.json", "--help"]]


def test_info_names_versions_kernels_width_and_caches(impact, tmp_path):
    kernels = tmp_path / "kernels"
    kernels.mkdir()
    (kernels / "one.so").write_bytes(b"x" * 1_500_000)
    status, output, errors = impact("info", env={"IMPACT_JIT_CACHE": str(kernels)})
    assert status == 0, errors
    for word in ("dolfinx ", "ffcx", "basix", "ufl", "petsc", "nanobind", "linear_elastic.force", "hexahedron", "SIMD"):
        assert word in output
    assert f"tried on DOLFINx {compat.tried()}" in output and compat.installed() in output
    assert f"{kernels} (1 files, 1.5 MB)" in output


def test_a_demo_that_does_not_end_is_ended(impact, tmp_path, monkeypatch):
    """By the time limit of the tests' own command; nothing of it is left."""
    script = tmp_path / "own.py"
    script.write_text(
        f"import os, time\nopen({str(tmp_path / 'pid')!r}, 'w').write(str(os.getpid()))\ntime.sleep(1000)\n"
    )
    monkeypatch.setattr(cli, "demos", lambda: {"own": (script, "Own")})
    with pytest.raises(pytest.fail.Exception, match="did not end within 3 s"):
        impact("demo", "own", timeout=3)
    with pytest.raises(ProcessLookupError):
        os.kill(int((tmp_path / "pid").read_text()), 0)


def test_info_counts_the_kernels_that_are_there():
    from dolfinx_impact import _cpp

    rows = cli.kernels_by_form()
    assert rows["linear_elastic.force"][("hexahedron", "3d")] == [1, 2]
    named = {(k.cell, k.hypothesis) for k in _cpp.kernels.table() if k.rank == 1}
    assert {key for row in rows.values() for key in row} <= named
