# SPDX-License-Identifier: MIT
"""Results of contacts as functions; the checks are in contact_function_checks.py."""

import contact_function_checks
from contact_function_checks import *  # noqa: F401, F403
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(contact_function_checks)
