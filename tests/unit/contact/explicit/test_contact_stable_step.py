# SPDX-License-Identifier: MIT
"""Springs of a given penalty set the stable step."""

import pytest
import contact_stable_step_checks
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(contact_stable_step_checks, ranks=(2,), timeout=120)
pytestmark = pytest.mark.filterwarnings("ignore:dt =")
