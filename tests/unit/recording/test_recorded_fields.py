# SPDX-License-Identifier: MIT
"""Fields that problems record, on several numbers of ranks; the checks are in recorded_fields_checks.py."""

import recorded_fields_checks
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(recorded_fields_checks)
