# SPDX-License-Identifier: MIT
"""Bodies whose rigid body modes only contact constrains, on 1 to 3 ranks."""

import unconstrained_modes_checks
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(unconstrained_modes_checks)
