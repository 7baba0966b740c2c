"""Matrix-free operators equal DOLFINx's assembly on 1, 2 and 3 ranks."""

import pathlib

import operator_checks
import pytest


@pytest.mark.parametrize("name", operator_checks.CHECKS)
def test_one_rank(name):
    operator_checks.CHECKS[name]()


@pytest.mark.mpi
@pytest.mark.parametrize("ranks", [2, 3])
def test_several_ranks(mpirun, ranks):
    output = mpirun(ranks, pathlib.Path(operator_checks.__file__), timeout=300)
    assert output.count("passed: ") == len(operator_checks.CHECKS)
