# SPDX-License-Identifier: MIT
"""The file of ratios over time: it only grows, and the page of the docs is drawn from it."""

import importlib.util
import pathlib

import pytest

from impact_studies.bench import ratio_history
from impact_studies.bench.rows import row

DOCS = pathlib.Path(__file__).parents[3] / "docs"
MACHINE = {"processor": "a processor", "load": 0.25, "cores": 2}


def rows(factor):
    return [
        row("force / A", "hexahedron P1", 1, factor * 8.0, "Mcells/s", 2.0),
        row("steps / one rank", "P1", 2, 3.0, "1/s", 2.0),
    ]


def figures():
    specification = importlib.util.spec_from_file_location("bench_figures", DOCS / "bench_figures.py")
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


def test_runs_are_appended(tmp_path):
    path = tmp_path / "history.csv"
    ratio_history.append(path, rows(1.0), MACHINE, "0123abcd")
    first = path.read_text()
    ratio_history.append(path, rows(1.5), MACHINE, "4567abcd (changed)")
    assert path.read_text().startswith(first)
    lines = ratio_history.read(path)
    assert [(line["commit"], line["name"], float(line["ratio"])) for line in lines] == [
        ("0123abcd", "force / A", 4.0),
        ("0123abcd", "steps / one rank", 1.5),
        ("4567abcd (changed)", "force / A", 6.0),
        ("4567abcd (changed)", "steps / one rank", 1.5),
    ]
    assert {line["processor"] for line in lines} == {"a processor"} and {line["load"] for line in lines} == {"0.2"}
    assert ratio_history.by_row(lines)["force / A", "hexahedron P1"] == [("0123abcd", 4.0), ("4567abcd (changed)", 6.0)]
    assert ("steps / one rank", "P1, 2 ranks") in ratio_history.by_row(lines)


def test_another_file_is_not_changed(tmp_path):
    path = tmp_path / "other.csv"
    path.write_text("a,b\n1,2\n")
    with pytest.raises(ValueError, match="has the columns"):
        ratio_history.append(path, rows(1.0), MACHINE, "0123abcd")
    assert path.read_text() == "a,b\n1,2\n"


def test_a_table_and_a_figure_for_each_processor(tmp_path):
    path = tmp_path / "history.csv"
    for processor, factor in (("one", 1.0), ("other", 2.0), ("one", 0.5)):
        ratio_history.append(path, rows(factor), {**MACHINE, "processor": processor}, f"commit{factor}")
    lines = ratio_history.read(path)
    table = figures().table(lines)
    assert table.split("\n\n")[0].splitlines()[2].split()[-4:] == ["2", "2", "4", "2"]  # last, lowest, highest, runs
    assert table.split("\n\n")[1].splitlines()[2].split()[-4:] == ["8", "8", "8", "1"]
    axes = figures().figure(lines).axes
    assert [ax.get_title() for ax in axes] == ["one", "other"]
    assert list(axes[0].get_lines()[0].get_ydata()) == [1.0, 0.5]


def test_the_table_of_the_page_is_that_of_the_file():
    table = figures().table(ratio_history.read(DOCS / "bench_history.csv"))
    assert (DOCS / "figures" / "bench_history.txt").read_text() == table, "run docs/bench_figures.py"
