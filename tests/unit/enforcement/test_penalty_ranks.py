"""Penalty contact does not depend on the number of ranks."""

import pathlib

import penalty_checks
import pytest


@pytest.mark.parametrize("name", penalty_checks.CHECKS)
def test_one_rank(name):
    penalty_checks.CHECKS[name]()


@pytest.mark.mpi
@pytest.mark.parametrize("ranks", [2, 3, 4])
def test_several_ranks(mpirun, ranks):
    output = mpirun(ranks, pathlib.Path(penalty_checks.__file__), timeout=120)
    assert output.count("passed: ") == len(penalty_checks.CHECKS)
