"""Facets and values travel to the ranks that need them, and only those."""

import pathlib

import exchange_checks
import numpy as np
import pairs
import pytest

from dolfinx_impact import _cpp


@pytest.mark.parametrize("name", exchange_checks.CHECKS)
def test_one_rank(name):
    exchange_checks.CHECKS[name]()


@pytest.mark.mpi
@pytest.mark.parametrize("ranks", [2, 3, 4])
def test_several_ranks(mpirun, ranks):
    output = mpirun(ranks, pathlib.Path(exchange_checks.__file__), timeout=100)
    assert output.count("passed: ") == len(exchange_checks.CHECKS)


def test_refused():
    V, slave, master = pairs.two_bodies()
    other = pairs.two_bodies(dim=3)[1]
    with pytest.raises(ValueError, match="dimension"):
        _cpp.search.Exchange(V._cpp_object, other, master, 0.1)
    with pytest.raises(ValueError, match="reach"):
        _cpp.search.Exchange(V._cpp_object, slave, master, -1.0)
    with pytest.raises(ValueError, match="displacement space"):
        _cpp.search.Exchange(V._cpp_object, slave, pairs.two_bodies(degree=2)[2], 0.1)
    exchange = _cpp.search.Exchange(V._cpp_object, slave, master, 0.1)
    with pytest.raises(ValueError, match="forward takes"):
        exchange.forward(np.zeros(3))
    with pytest.raises(ValueError, match="reverse takes"):
        exchange.reverse(np.zeros(3), np.zeros(300))
