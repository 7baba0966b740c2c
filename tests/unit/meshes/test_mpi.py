# SPDX-License-Identifier: MIT
"""Recipes and reading on several ranks: the same meshes, the same errors everywhere, and nothing hangs."""

from pathlib import Path

import pytest


@pytest.mark.parametrize("ranks", [2, 3])
def test_on_ranks(ranks, script_on_ranks, tmp_path):
    worker = Path(__file__).parent / "mpi_worker.py"
    assert "agreed" in script_on_ranks(ranks, worker, tmp_path, timeout=100)
