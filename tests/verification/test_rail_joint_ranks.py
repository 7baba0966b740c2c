# SPDX-License-Identifier: MIT
"""The passage over a rail joint does not depend on the number of ranks."""

import joint_rank_checks
import pytest
from on_ranks import rank_tests

pytestmark = pytest.mark.slow
test_one_rank, test_several_ranks = rank_tests(joint_rank_checks, ranks=(2, 3, 4), timeout=900)
