# SPDX-License-Identifier: MIT
"""Contact that finds itself in static and implicit problems; docs/general_contact.md."""

import general_static_checks
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(general_static_checks)
