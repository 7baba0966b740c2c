# SPDX-License-Identifier: MIT
"""Contacts that share slave nodes, and slave tags round sharp edges, on one rank and several."""

import shared_nodes_checks
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(shared_nodes_checks)
