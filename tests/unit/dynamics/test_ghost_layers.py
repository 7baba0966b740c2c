# SPDX-License-Identifier: MIT
"""Ghost cells that explicit runs do not need; the checks are in ghost_layers_checks.py."""

import ghost_layers_checks
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(ghost_layers_checks)
