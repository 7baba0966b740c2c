# SPDX-License-Identifier: MIT
"""Problems of the same bodies that share a linear solver: StaticProblem.share_linear_solver."""

import shared_solver_checks
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(shared_solver_checks)
