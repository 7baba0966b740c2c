# SPDX-License-Identifier: MIT
"""Bodies whose rigid body modes only contact constrains, on 1 to 3 ranks."""

import rigid_body_modes_checks
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(rigid_body_modes_checks)
