# SPDX-License-Identifier: MIT
"""Equal work for all ranks; the checks are in partition_checks.py."""

import partition_checks
import pytest
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(partition_checks, ranks=(2, 3, 4))


@pytest.mark.slow
@pytest.mark.parametrize("ranks", [8, 16])
def test_equal_work_of_many_ranks(rank_group, ranks):
    """Less than a tenth is lost, on more ranks than there are cores."""
    rank_group(ranks, 600, module=partition_checks.__file__, check="check_equal_work")
