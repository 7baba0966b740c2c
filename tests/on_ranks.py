"""The same checks in the test's own process and on several ranks."""

import pathlib

import pytest


def rank_tests(checks, ranks=(2, 3), timeout=300):
    """Tests of a module of checks: `test_one_rank, test_several_ranks = rank_tests(module)`.

    Args:
        checks: module with CHECKS (name -> function without arguments); run as a script it prints "passed: name" on
            rank 0 after each. ranks: numbers of ranks. timeout: of a run on several ranks [s].
    """

    @pytest.mark.parametrize("name", checks.CHECKS)
    def test_one_rank(name):
        checks.CHECKS[name]()

    @pytest.mark.mpi
    @pytest.mark.parametrize("ranks", ranks)
    def test_several_ranks(mpirun, ranks):
        output = mpirun(ranks, pathlib.Path(checks.__file__), timeout=timeout)
        assert [line[8:] for line in output.splitlines() if line.startswith("passed: ")] == list(checks.CHECKS)

    return test_one_rank, test_several_ranks
