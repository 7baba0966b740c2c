# SPDX-License-Identifier: MIT
"""Rows of a table that `make test` leaves to `make verify`: the others hold each value, or each pair of values."""

import itertools
import os
import subprocess
import sys

import pytest
from rows import covering_array

VALUES = {"cell": ("triangle", "quadrilateral", "tetrahedron", "hexahedron"), "degree": (1, 2), "friction": (0.0, 0.3)}
PRODUCT = [dict(zip(VALUES, row)) for row in itertools.product(*VALUES.values())]
NOT_EVERY = [row for row in PRODUCT if row["cell"] != "triangle" or row["friction"]]


def together(rows, strength):
    return {values for row in rows for values in itertools.combinations(row.items(), strength)}


@pytest.mark.parametrize("table", [PRODUCT, NOT_EVERY], ids=["product", "not every combination"])
@pytest.mark.parametrize("strength, most", [(1, 4), (2, 9), (3, 16)])
def test_all_that_occurs_together_is_kept(table, strength, most):
    kept = [table[place] for place in covering_array(table, strength)]
    assert together(kept, strength) == together(table, strength)
    assert len(kept) <= most


MODULE = """
import pytest

@pytest.mark.covering(2)
@pytest.mark.parametrize("a", [[1], [2]])
@pytest.mark.parametrize("b", "xy")
@pytest.mark.parametrize("c", [True, False])
def test_pairs(a, b, c): pass

@pytest.mark.covering(1)
@pytest.mark.parametrize("a", [1, 2, 3])
@pytest.mark.parametrize("b", "xy")
def test_values(a, b): pass

@pytest.mark.long_rows(where=lambda a: a > 1)
@pytest.mark.parametrize("a", [1, 2, 3])
def test_rows(a): pass
"""


def test_the_other_rows_are_slow(checkout, tmp_path):
    """Of eight rows with two values of three parameters four hold every pair; of six three hold every value."""
    (tmp_path / "test_module.py").write_text(MODULE)

    def names(expression):
        command = [sys.executable, "-m", "pytest", "-q", "--collect-only", "-p", "conftest", "-m", expression]
        command += ["-c", checkout / "pyproject.toml", "--rootdir", tmp_path, tmp_path]
        surroundings = {**os.environ, "PYTHONPATH": str(checkout / "tests")}
        done = subprocess.run(command, capture_output=True, text=True, env=surroundings)
        assert done.returncode == 0, done.stdout + done.stderr
        found = [line.partition("::")[2].partition("[")[0] for line in done.stdout.splitlines() if "::" in line]
        return {name: found.count(name) for name in found}

    assert names("not slow") == {"test_pairs": 4, "test_values": 3, "test_rows": 1}
    assert names("slow") == {"test_pairs": 4, "test_values": 3, "test_rows": 2}
