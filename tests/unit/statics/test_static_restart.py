# SPDX-License-Identifier: MIT
"""Static problems that go on after a restart: the checks of static_restart_checks.py on one rank and on several."""

import static_restart_checks
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(static_restart_checks, in_make_test={"two_halves_are_the_whole": (1, 2)})
