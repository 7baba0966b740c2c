# SPDX-License-Identifier: MIT
"""Pictures of deformed bodies on several numbers of ranks; the checks are in deformed_body_checks.py."""

import deformed_body_checks
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(deformed_body_checks)
