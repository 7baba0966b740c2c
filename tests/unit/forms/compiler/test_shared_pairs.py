# SPDX-License-Identifier: MIT
"""Products as trees of pairs: the same values, and pairs that several products have are multiplied once."""

from math import prod

import pytest

from dolfinx_impact.forms.compiler import algebra as alg
from dolfinx_impact.forms.compiler.shared_pairs import Factor, _Sharing, trees

PRIMES = {number: prime for number, prime in enumerate((2, 3, 5, 7, 11, 13))}


def factors(numbers, level=alg.POINT):
    return [Factor(level, number, None, False) for number in numbers]


def value(tree):
    return PRIMES[tree.number] if isinstance(tree, Factor) else value(tree[0]) * value(tree[1])


def pairs(found):
    """Different pairs among trees: multiplications."""
    known, waiting = set(), list(found)
    while waiting:
        tree = waiting.pop()
        if isinstance(tree, tuple) and id(tree) not in known:
            known.add(id(tree))
            waiting += tree
    return len(known)


@pytest.mark.parametrize(
    "products, multiplications",
    [
        ([(0, 1, 2), (0, 1, 3)], 3),  # the pair of 0 and 1 once
        ([(0, 1, 2, 3), (0, 1, 2, 4), (0, 1, 5)], 5),
        ([(0, 0, 0, 0)], 2),  # the square of a square
        ([(0, 1), (0, 1)], 1),
        ([(2,), (3,)], 0),
    ],
)
def test_products_keep_their_values_with_the_fewest_pairs(products, multiplications):
    found = trees([factors(p) for p in products])
    assert [value(t) for t in found] == [prod(PRIMES[n] for n in p) for p in products]
    assert pairs(found) == multiplications


def test_what_is_known_earlier_is_multiplied_first():
    """Constants together, before what depends on the point, however the product is written."""
    early, late = factors([0, 1], alg.CONSTANT), factors([2, 3])
    (tree,) = _Sharing([[late[0], early[0], late[1], early[1]]]).trees()
    assert value(tree) == 2 * 3 * 5 * 7

    def has_constants(t):
        return isinstance(t, tuple) and (set(t) == set(early) or any(map(has_constants, t)))

    assert has_constants(tree)


def test_order_and_identity_of_factors():
    one = Factor(alg.POINT, 1, "x", False)
    assert one == Factor(alg.POINT, 1, "y", False) != Factor(alg.POINT, 1, "x", True)
    assert Factor(alg.CONSTANT, 9, "x", False).key < one.key
    assert Factor(alg.CONSTANT, 0, 2.0, False).key != Factor(alg.CONSTANT, 0, 3.0, False).key
