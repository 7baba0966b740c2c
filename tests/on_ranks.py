# SPDX-License-Identifier: MIT
"""The same checks in the test's own process and on several ranks: a module's functions check_*.

All checks of a session share one mpirun per number of ranks, rank_group.py: DOLFINx is imported and forms are compiled
once. Each check on each number of ranks is a test of its own.
"""

import pytest


def checks_of(names):
    """name -> function, of a module's names; those that it imports do not count."""
    own = {k: f for k, f in names.items() if k.startswith("check_") and f.__code__.co_filename == names["__file__"]}
    return {name.removeprefix("check_"): f for name, f in own.items()}


def rank_tests(module, ranks=(2, 3), timeout=300):
    """Tests of a module of checks: `test_one_rank, test_several_ranks = rank_tests(module)`.

    Args:
        module: with functions check_* without arguments.
        ranks: numbers of ranks.
        timeout: limit of each check on several ranks [s].
    """
    checks = checks_of(vars(module))
    assert checks, f"{module.__name__} has no function check_*"

    @pytest.mark.parametrize("name", checks)
    def test_one_rank(name):
        checks[name]()

    @pytest.mark.parametrize("name", checks)
    @pytest.mark.parametrize("ranks", ranks)
    def test_several_ranks(rank_group, ranks, name):
        rank_group(ranks, timeout, module=module.__file__, check=f"check_{name}")

    return test_one_rank, test_several_ranks
