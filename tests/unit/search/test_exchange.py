# SPDX-License-Identifier: MIT
"""Facets and values travel to the ranks that need them, and only those."""

import exchange_checks
import numpy as np
import partitioned_bodies
import pytest
from on_ranks import rank_tests

from dolfinx_impact import _cpp


test_one_rank, test_several_ranks = rank_tests(exchange_checks, ranks=(2, 3, 4), timeout=100)


def test_refused():
    V, slave, master = partitioned_bodies.two_bodies()
    other = partitioned_bodies.two_bodies(dim=3)[1]
    with pytest.raises(ValueError, match="dimension"):
        _cpp.search.Exchange(V._cpp_object, other, master, 0.1)
    with pytest.raises(ValueError, match="reach"):
        _cpp.search.Exchange(V._cpp_object, slave, master, -1.0)
    with pytest.raises(ValueError, match="displacement space"):
        _cpp.search.Exchange(V._cpp_object, slave, partitioned_bodies.two_bodies(degree=2)[2], 0.1)
    exchange = _cpp.search.Exchange(V._cpp_object, slave, master, 0.1)
    with pytest.raises(ValueError, match="forward takes"):
        exchange.forward(np.zeros(3))
    with pytest.raises(ValueError, match="reverse takes"):
        exchange.reverse(np.zeros(3), np.zeros(300))
