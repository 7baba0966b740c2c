# SPDX-License-Identifier: MIT
"""Contact with smooth surfaces."""

import smooth_contact_checks
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(smooth_contact_checks, ranks=(2, 3))
