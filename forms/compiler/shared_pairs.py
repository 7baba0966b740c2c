# SPDX-License-Identifier: MIT
"""Common factors of many products: which pairs of factors are multiplied once for all of them.

Greedily, the pair that most products have becomes one factor, until no two products have a pair in common (Breuer 1969,
"Generation of optimal code for expressions via factorization"). Factors that are known earlier come first: a product
of constants is computed once, and what the iterate of the local equations is multiplied with stands before the
iteration.
"""

from collections import Counter
from dataclasses import dataclass, field
from itertools import combinations
from typing import Any

from . import algebra as alg

# Values of one stage are computed equally often.
STAGE = {alg.CONSTANT: 0, alg.CELL: 1, alg.AVERAGED: 2, alg.POINT: 3, alg.SOLVED: 3, alg.ITERATE: 4}


@dataclass(frozen=True)
class Factor:
    """A factor of a product.

    Attributes:
        level: what it depends on, as levels of the algebra.
        number: order among the factors of a level.
        base: an algebra node, or a number.
        inverse: whether the product is divided by it.
    """

    level: int
    number: int
    base: Any = field(compare=False)
    inverse: bool

    @property
    def key(self):
        """Identity, and order among factors."""
        return (self.level, self.number, self.base if isinstance(self.base, float) else 0.0, self.inverse)


def trees(products):
    """Products as trees of pairs, in which what several products have in common is the same subtree.

    Args:
        products: list of products, each a list of Factor; powers are factors that occur several times.

    Returns:
        list of trees: a Factor, or a pair (tree, tree).
    """
    return _Sharing(products).trees()


class _Sharing:
    """Products as sorted lists of numbers of subtrees.

    Args:
        products: see trees.
    """

    def __init__(self, products):
        self.subtrees, self.stages, self.numbers = [], [], {}
        factors = {f.key: f for product in products for f in product}
        for key in sorted(factors):
            self._add(factors[key], STAGE[factors[key].level], key)
        self.products = [sorted(self.numbers[f.key] for f in product) for product in products]

    def _add(self, tree, stage, key):
        if key not in self.numbers:
            self.numbers[key] = len(self.subtrees)
            self.subtrees.append(tree)
            self.stages.append(stage)
        return self.numbers[key]

    def _pair(self, a, b):
        return self._add((self.subtrees[a], self.subtrees[b]), max(self.stages[a], self.stages[b]), ("pair", a, b))

    def trees(self):
        last = max(STAGE.values())
        for stage in range(last + 1):
            self._share(stage)
            for i, product in enumerate(self.products):
                known = [n for n in product if self.stages[n] <= stage]
                if known and (stage == last or len(known) < len(product)):
                    rest = [n for n in product if self.stages[n] > stage]
                    head = known[0]
                    for n in known[1:]:
                        head = self._pair(head, n)
                    self.products[i] = [head, *rest]
        return [self.subtrees[product[0]] for product in self.products]

    def _share(self, stage):
        """Replace pairs that several products have, among factors that are known at a stage."""
        products = [[n for n in p if self.stages[n] <= stage] for p in self.products]
        pairs = [self._pairs(p) for p in products]
        count, where = Counter(), {}
        for i, own in enumerate(pairs):
            count.update(own)
            for pair in own:
                where.setdefault(pair, set()).add(i)
        while count:
            number, a, b = max((c, -a, -b) for (a, b), c in count.items())
            a, b = -a, -b
            if number < 2:
                break
            new = self._pair(a, b)
            for i in sorted(where[a, b]):
                for pair in pairs[i]:
                    where[pair].discard(i)
                    count[pair] -= pairs[i][pair]
                    if count[pair] <= 0:
                        del count[pair]
                for product in (products[i], self.products[i]):
                    for _ in range(pairs[i][a, b]):
                        product.remove(a)
                        product.remove(b)
                        product.append(new)
                    product.sort()
                pairs[i] = self._pairs(products[i])
                count.update(pairs[i])
                for pair in pairs[i]:
                    where.setdefault(pair, set()).add(i)

    @staticmethod
    def _pairs(product):
        """How often each pair of factors can be taken out of a product."""
        powers = Counter(product)
        found = {pair: min(powers[pair[0]], powers[pair[1]]) for pair in combinations(sorted(powers), 2)}
        found.update({(n, n): p // 2 for n, p in powers.items() if p > 1})
        return Counter(found)
