# SPDX-License-Identifier: MIT
"""Every demo and application runs, on one rank and on two, and leaves its files; each is a page that ends with an
assert."""

import ast
import json
import os
import subprocess
import sys

import jupytext
import pytest
from outputs import numbers, words

from dolfinx_impact import cli, compat

ALL = sorted(cli.demos())
FILES = {
    "wheel_on_rail": (
        "axis.csv", "axis.h5", "two_solvers.png", "wheel_on_rail_2d.png", "wheel_on_rail_3d.png", "wheel_on_rail_2d.bp",
        "wheel_on_rail_3d.bp",
    ),
    "wheel_contact": ("points.csv", "points.h5", "wheel_contact.bp", "wheel_contact.png"),
    "block_own_form": ("block.bp", "block_own_form.png"),
    "wheel_rail_creep": ("curve.csv", "curve.h5", "wheel_rail_creep.bp", "wheel_rail_creep.png"),
    "creep_curve": ("creep_curve.bp", "creep_curve.png", "curve.csv", "curve.h5"),
    "hertz_cylinder": (
        "convergence.csv", "convergence.h5", "hertz_cylinder.bp", "hertz_cylinder.png", "pressure.csv", "pressure.h5",
    ),
    "impact_bars": (
        "cases.csv", "errors_penalty.csv", "errors_kinematic.h5", "impact_bars.png", "impact_bars_convergence.png",
        "two_bars.bp",
    ),
    "implicit_or_explicit": ("implicit_or_explicit.png", "methods.csv", "methods.h5"),
    "rail_joint": (
        "energy.csv", "energy.h5", "energy.png", "ends.png", "footprint.png", "force.csv", "force.h5", "force.png",
        "frames.bp", "parameters.toml", "paraview_state.py", "passage.gif", "plastic.png", "report.html",
        "residual.png", "sequence.png", "shear.png", "summary.json", "waves.png",
    ),
    "rail_joint_plane": (
        "energy.csv", "energy.h5", "force.csv", "force.h5", "rail_joint_plane_0.bp", "rail_joint_plane_5.bp",
        "rail_joint_plane_energy.png", "rail_joint_plane_force.png", "rail_joint_plane_sequence.png",
    ),
    "rolling_three_ways": ("history.csv", "history.h5", "rolling_three_ways.bp", "rolling_three_ways.png"),
    "standing_waves": (
        "campbell.csv", "campbell.h5", "rail_0.bp", "rail_80.bp", "rail_95.bp", "standing_waves.png",
    ),
    "rolling_disc": ("rim.csv", "rim.h5", "rolling_disc.bp", "rolling_disc.png"),
}  # fmt: skip


def test_every_application_says_what_it_leaves():
    assert set(FILES) == {name for name, (path, _) in cli.demos().items() if cli.is_application(path)}


# Of the applications, which are studies, `make test` runs one of rolling, on two ranks, and `make verify` the others.
# Static contact and impact: test_short_demos.py. Passages over a rail joint: tests/unit/rail_joint,
# tests/cross/test_rail_joint_twin.py.
IN_MAKE_TEST = {("rolling_disc", 2)}


@pytest.mark.mpi
@pytest.mark.long_rows(where=lambda name, ranks: (name, ranks) not in IN_MAKE_TEST)
@pytest.mark.parametrize("ranks", (1, 2))
@pytest.mark.parametrize("name", sorted(FILES))
def test_an_application_runs_and_leaves_its_files(name, ranks, impact, tmp_path):
    folder = tmp_path / "here"
    status, output, errors = impact("demo", name, "--ranks", ranks, "--output", folder)
    assert status == 0, output + errors
    assert "left out" not in output
    for file in FILES[name]:
        path = folder / file
        assert path.exists(), f"{file} is missing; there are {sorted(p.name for p in folder.iterdir())}"
        if path.suffix == ".png":
            assert path.read_bytes()[:4] == b"\x89PNG" and path.stat().st_size > 10_000
    record = json.loads((folder / "parameters.json").read_text())
    assert record["run"] == name and record["ranks"] == ranks and record["versions"]["dolfinx"] == compat.installed()
    assert output.count("results in") == 1, "one rank prints, the others do not"


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(FILES))
def test_the_printed_output_of_an_application_is_that_of_the_pages(name, impact, checkout, tmp_path):
    """The whole run, not the short one of the tests: the same words, and as many numbers; times differ."""
    folder = tmp_path / "here"
    status, output, errors = impact("demo", name, "--output", folder, timeout=1200, env={"IMPACT_DEMO_FAST": "0"})
    assert status == 0, output + errors
    output = output.replace(str(folder), f"results/{name}")
    printed = (checkout / "docs" / "figures" / f"demo_{name}.txt").read_text()
    assert words(output) == words(printed) and len(numbers(output)) == len(numbers(printed))


@pytest.mark.parametrize("name", ALL)
def test_a_demo_is_a_page(name):
    path = cli.demos()[name][0]
    page = jupytext.read(path, fmt="py:light")
    text = [cell.source for cell in page.cells if cell.cell_type == "markdown"]
    code = [cell.source for cell in page.cells if cell.cell_type == "code"]
    assert text[0].startswith("# "), "the page begins with its title"
    assert page.cells[0].cell_type == "markdown" and len(text) >= 4
    for source in code:
        ast.parse(source)
    last = ast.parse(code[-1]).body[-1]
    assert isinstance(last, ast.Assert) and not isinstance(last.test, ast.Constant)


def test_a_wrong_number_makes_the_demo_fail(tmp_path):
    """The asserts are read: with another density the disc is not that of the benchmark."""
    source = cli.demos()["rolling_disc"][0].read_text()
    changed = source.replace("7800.0", "7900.0")
    assert changed != source
    (tmp_path / "changed.py").write_text(changed)
    done = subprocess.run(
        [sys.executable, "changed.py"],
        cwd=tmp_path,
        env={**os.environ, "IMPACT_DEMO_FAST": "1"},
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert done.returncode != 0 and "AssertionError" in done.stderr


def test_the_gallery_shows_the_demos(checkout):
    gallery = (checkout / "docs" / "gallery.md").read_text()
    for name in ALL:
        assert f"demo {name}" in gallery, f"docs/gallery.md does not say how to run {name}"
        for file in FILES.get(name, [f"{name}.png"]):
            if file.endswith(".png"):
                own = file if file.startswith(name) else f"{name}_{file}"
                picture = checkout / "docs" / "figures" / f"demo_{own}"
                assert f"figures/{picture.name}" in gallery
                assert picture.stat().st_size < 200_000
