# SPDX-License-Identifier: MIT
"""Rows of the benchmark about many ranks and set-up per cell, from tiny meshes."""

import numpy as np
import pytest

from impact_studies.bench import many_ranks
from impact_studies.bench.setup import most_memory


def test_jobs_are_of_several_ranks_and_sizes():
    """Two and four ranks, with `--large` up to 16 and 4 million cells; the set-up is the last one."""
    assert many_ranks.LARGE_SIDE**3 > 4e6 and many_ranks.KB_PER_CELL * many_ranks.LARGE_SIDE**3 < 24.5e6
    assert [text for text, _ in many_ranks.jobs()] == [
        "equal work on 2 ranks",
        "equal work on 4 ranks",
        "set-up per cell",
    ]
    assert len(many_ranks.jobs(large=True)) == 5


def test_most_memory_is_known_without_the_line_of_the_system(tmp_path):
    """Some sandboxes do not tell it; 100 MB that were once in use count in any case."""
    np.ones(12_500_000)
    status = tmp_path / "status"
    assert most_memory() > 100e6 and most_memory(status) > 100e6  # no such file
    status.write_text("Name:\tpython3\nVmRSS:\t  4 kB\n")
    assert most_memory(status) == most_memory(tmp_path / "none")
    status.write_text("VmHWM:\t  300 kB\n")
    assert most_memory(status) == 300 * 1024.0


@pytest.mark.slow
def test_rows_of_ranks_and_set_up():
    ours, goal = many_ranks.balance_rows(2, 8)
    assert ours["ranks"] == 2 and 1.0 <= ours["value"] < 1.1 < ours["baseline"] and goal["ratio"] < 1.0
    reading, step, memory = many_ranks.setup_rows(20)
    assert reading["value"] == step["value"] > 0.0 and reading["baseline"] > 0.0 and step["baseline"] > 0.0
    assert 0.1 < memory["value"] < 20.0 and all("8000 cells" in r["cell"] for r in (reading, step, memory))
