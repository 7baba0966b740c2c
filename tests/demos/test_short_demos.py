# SPDX-License-Identifier: MIT
"""The short demos to copy from: short, of public names only, and what the pages show is what they print and draw."""

import ast
import base64
import subprocess
import sys

import dolfinx_impact as di
import jupytext
import nbformat
import numpy as np
import pytest
from outputs import numbers, words
from PIL import Image

from dolfinx_impact import cli

DEMOS = (
    "bar_on_wall", "block_with_friction", "crushed_ring", "drop_hammer", "hertz", "interior_penalty",
    "kelvin_voigt",
    "nearly_incompressible", "own_form", "own_interface_law", "own_plasticity", "self_check", "tied_beam", "two_bars",
    "two_materials",
)  # fmt: skip
MODULES = {"basix", "dolfinx", "dolfinx_impact", "gmsh", "matplotlib", "mpi4py", "numpy", "ufl"}
ROUND_OFF = 1e-9  # numbers below are round-off, which another number of ranks changes
NOTEBOOK = """
import sys
import jupytext
namespace = {"__name__": "__main__"}
for cell in jupytext.read(sys.argv[1]).cells:
    if cell.cell_type == "code" and "pictures" not in cell.metadata.get("tags", ()):
        exec(compile(cell.source, sys.argv[1], "exec"), namespace)
"""


def test_all_are_listed():
    assert {name for name, (path, _) in cli.demos().items() if not cli.is_application(path)} == set(DEMOS)


@pytest.mark.parametrize("name", DEMOS)
def test_it_can_be_copied(name):
    """No module of its own, no switch, no private name: nothing but what a user has."""
    text = cli.demos()[name][0].read_text()
    assert 60 <= len(text.splitlines()) <= 100 and "environ" not in text
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            assert {alias.name.partition(".")[0] for alias in node.names} <= MODULES
            assert not any(alias.name.startswith("dolfinx_impact.") for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.module.partition(".")[0] in MODULES - {"dolfinx_impact"}
        elif isinstance(node, ast.Attribute):
            assert not node.attr.startswith("_")
            if isinstance(node.value, ast.Name) and node.value.id == "di":
                assert node.attr in di.__all__


def picture(path):
    """A picture in grey, 48 x 24 values from 0 to 1."""
    return np.asarray(Image.open(path).convert("L").resize((48, 24), Image.Resampling.BOX)) / 255


def assert_as_in_the_pages(name, output, path, checkout):
    """What a demo printed and drew is what its page shows."""
    figures = checkout / "docs" / "figures"
    printed = (figures / f"demo_{name}.txt").read_text()
    again = f"run env/run python3 docs/demo_figures.py docs/figures {name}"
    assert words(output) == words(printed), again
    np.testing.assert_allclose(numbers(output), numbers(printed), rtol=2e-3, atol=ROUND_OFF, err_msg=again)
    # Colours are fewer in the pages, and nodes in another order: some per mille of the mean grey.
    assert np.abs(picture(path) - picture(figures / f"demo_{name}.png")).mean() < 0.01, again


@pytest.fixture(scope="module")
def notebooks(checkout, tmp_path_factory):
    folder = tmp_path_factory.mktemp("notebooks")
    command = [sys.executable, checkout / "docs" / "notebooks.py", folder, "--no-run"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return folder


def test_every_demo_is_a_notebook(notebooks):
    assert {path.name for path in notebooks.iterdir()} == {f"{name}.ipynb" for name in cli.demos()}
    for name in cli.demos():
        cells = jupytext.read(notebooks / f"{name}.ipynb").cells
        assert cells[0].cell_type == "markdown" and {cell.cell_type for cell in cells} == {"markdown", "code"}


def test_notebooks_have_outputs_and_pictures(checkout, tmp_path):
    """As `make notebooks ARGS=NAME` makes them: what the demo prints, and its picture as PNG."""
    command = [sys.executable, checkout / "docs" / "notebooks.py", tmp_path, "two_bars"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["two_bars.ipynb"]
    cells = [cell for cell in nbformat.read(tmp_path / "two_bars.ipynb", 4).cells if cell.cell_type == "code"]
    assert [cell.execution_count for cell in cells] == list(range(1, len(cells) + 1))
    printed = "".join(output.text for cell in cells for output in cell.outputs if output.output_type == "stream")
    page = (checkout / "docs" / "figures" / "demo_two_bars.txt").read_text()
    assert words(f"{printed}results in results/two_bars\n") == words(page)
    pictures = [output.data["image/png"] for output in cells[-1].outputs]
    assert len(pictures) == 1 and base64.b64decode(pictures[0]).startswith(b"\x89PNG")


def test_an_unknown_demo_is_no_notebook(checkout, tmp_path):
    command = [sys.executable, checkout / "docs" / "notebooks.py", tmp_path / "made", "two_barss"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=100)
    assert done.returncode == 2 and "there is no demo two_barss; there are bar_on_wall," in done.stderr


@pytest.mark.long_rows(where=lambda name: name not in ("hertz", "own_form"))
@pytest.mark.parametrize("name", DEMOS)
def test_a_notebook_runs(name, notebooks, checkout, tmp_path):
    """On one rank: its code cells, in order, in one namespace, as a kernel runs them."""
    command = [sys.executable, "-c", NOTEBOOK, notebooks / f"{name}.ipynb"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    assert_as_in_the_pages(name, f"{done.stdout}results in results/{name}\n", tmp_path / f"{name}.png", checkout)


# Two demos on two ranks; of the others those on one rank of which no notebook runs. `make verify` has the other rows.
IN_MAKE_TEST = {
    ("bar_on_wall", 2), ("two_bars", 2), ("block_with_friction", 1), ("own_plasticity", 1), ("self_check", 1),
    ("kelvin_voigt", 1), ("two_materials", 2), ("nearly_incompressible", 2), ("interior_penalty", 1),
    ("own_interface_law", 1), ("tied_beam", 2), ("drop_hammer", 1), ("crushed_ring", 1),
}  # fmt: skip


@pytest.mark.mpi
@pytest.mark.long_rows(where=lambda name, ranks: (name, ranks) not in IN_MAKE_TEST)
@pytest.mark.parametrize("ranks", [1, 2])
@pytest.mark.parametrize("name", DEMOS)
def test_a_demo_runs(name, ranks, impact, checkout, tmp_path):
    """By the command, which needs nothing that the notebook has not."""
    folder = tmp_path / "here"
    status, output, errors = impact("demo", name, "--ranks", ranks, "--output", folder)
    assert status == 0, output + errors
    assert [path.name for path in folder.iterdir()] == [f"{name}.png"]
    assert_as_in_the_pages(name, output.replace(str(folder), f"results/{name}"), folder / f"{name}.png", checkout)
