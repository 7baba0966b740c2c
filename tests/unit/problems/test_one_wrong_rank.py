# SPDX-License-Identifier: MIT
"""An argument that is wrong on one rank is an error on all of them, for every public call; see one_wrong_rank.py."""

import pathlib

import pytest

TABLE = pathlib.Path(__file__).with_name("one_wrong_rank.py")


@pytest.mark.parametrize("ranks", [2, 3])
def test_wrong_on_one_rank_is_an_error_on_all(script_on_ranks, ranks):
    output = script_on_ranks(ranks, TABLE, timeout=300)
    failed = [line for line in output.splitlines() if line.startswith("FAILED")]
    assert not failed, "\n".join(failed)
    assert output.rstrip().endswith(" 0 failed")
