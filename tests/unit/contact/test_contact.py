"""Contact between bodies on 1 to 4 ranks."""

import pathlib

import contact_checks
import pytest


@pytest.mark.parametrize("name", contact_checks.CHECKS)
def test_one_rank(name):
    contact_checks.CHECKS[name]()


@pytest.mark.mpi
@pytest.mark.parametrize("ranks", [2, 3, 4])
def test_several_ranks(mpirun, ranks):
    output = mpirun(ranks, pathlib.Path(contact_checks.__file__), timeout=300)
    assert "passed " + " ".join(contact_checks.CHECKS) in output
