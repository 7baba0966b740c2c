# SPDX-License-Identifier: MIT
"""Sums of several components, multiplied out and collected anew by the factors that are their own.

Nine components of a stress are sums of the same invariants times each one's own cofactor, entry of F and products of
these. UFL's derivatives leave them as sums of such sums, one for each invariant. Collected by what is their own,

    P_ij = (a b + c d) cof_ij + (e + f g) F_ij + ...,

the sums in parentheses are the same in all components and are computed once. A factor is the more a component's own the
fewer sums have it.
"""

from collections import Counter

from . import algebra as alg

# Products of sums are multiplied out up to so many terms of a sum.
LARGEST_SUM = 60


def collect(algebra, values, times=1):
    """Values with their sums collected.

    Args:
        algebra: Algebra of the values.
        values: list of (number, node).
        times: how often. What the first time has put together belongs to one sum, and is multiplied out by the second.

    Returns:
        list of values of the same algebra.
    """
    for _ in range(times):
        collector = _Collector(algebra, [node for _, node in values if node is not None])
        values = [value if value[1] is None else collector.scaled(*value) for value in values]
    return values


class _Collector:
    """Rewrites the nodes that `roots` are made of, each once."""

    def __init__(self, algebra, roots):
        self.algebra = algebra
        self.uses = alg.uses(roots)
        self.unguarded, self.reciprocals = _unguarded(roots)
        self.done, self.terms, self.num_sums = {}, {}, Counter()
        inner = set()
        order = _children_first(roots)
        for node in reversed(order):  # outer sums before those that they have taken in
            if node.kind == "sum" and node not in inner:
                self.terms[node] = self._multiplied_out(node, inner)
                self.num_sums.update({base for _, powers in self.terms[node] for base in powers})
        for node in order:
            if node not in inner:
                self.done[node] = self._rewritten(node)

    def _new(self, node):
        """Value that a node has become; conditionals of terms are not among the roots' nodes."""
        if node not in self.done:
            self.done[node] = self._rewritten(node)
        return self.done[node]

    def scaled(self, number, node):
        return self.algebra.multiply((number, None), self._new(node))

    # -- terms --------------------------------------------------------------------------------------------------------
    def _own(self, node):
        """Is a node part of one sum only, and can be multiplied out without cancellation? A difference from a number
        stays: it may be small. Conditionals are multiplied out if one of their values is zero."""
        if self.uses[node] != 1:
            return False
        if node.kind == "select":
            return any(value == (0.0, None) for value in node.data[1:])
        return node.kind == "sum" and all(n is not None for _, n in node.data)

    def _multiplied_out(self, node, inner):
        """Terms (number, exponents by factor) of a sum. Nodes that are multiplied out are added to `inner`."""
        terms = []
        for number, product in node.data:
            powers = self.algebra.powers((1.0, product))
            own = [base for base, p in powers.items() if p == 1 and self._own(base)]
            if product is not None and own and (product is own[0] or self.uses[product] == 1):
                taken, within = own[0], set()
                rest = Counter({base: p for base, p in powers.items() if base is not taken})
                found = [(number * c, _product(rest, f)) for c, f in self._inside(taken, within)]
                if len(found) + len(terms) <= LARGEST_SUM:
                    inner |= {taken, product} | within
                    terms += found
                    continue
            terms.append((number, Counter(powers)))
        return terms

    def _inside(self, node, inner):
        """Terms of a sum, or of the conditional of a sum."""
        if node.kind == "sum":
            return self._multiplied_out(node, inner)
        condition, a, b = node.data
        number, value = b if a == (0.0, None) else a
        powers = self.algebra.powers((1.0, value))
        sums = [base for base, p in powers.items() if p == 1 and self._own(base)]
        if sums and (value is sums[0] or self.uses[value] == 1):
            rest = Counter({base: p for base, p in powers.items() if base is not sums[0]})
            found = [(number * c, _product(rest, f)) for c, f in self._inside(sums[0], inner)]
            inner |= {sums[0], value}
        else:
            found = [(number, Counter(powers))]
        return [self._conditional(condition, a == (0.0, None), *term) for term in found]

    def _conditional(self, condition, otherwise, number, powers):
        """A term under a condition. Factors and reciprocals that are computed whatever holds go out of it; others may
        be no numbers where it does not hold."""
        known = {base: self.unguarded if p > 0 else self.reciprocals for base, p in powers.items()}
        out = Counter({base: p for base, p in powers.items() if base in known[base]})
        value = (1.0, None)
        for base, p in powers.items():
            if base not in out:
                value = self.algebra.multiply(value, self.algebra.power((1.0, base), p))
        zero = (0.0, None)
        scale, guarded = self.algebra.select(condition, *((zero, value) if otherwise else (value, zero)))
        return number * scale, _product(out, {guarded: 1})

    # -- rewriting ----------------------------------------------------------------------------------------------------
    def _rewritten(self, node):
        algebra = self.algebra
        if node.kind == "sum":
            return self._collected(self.terms[node])
        if node.kind == "product":
            return self._monomial(1.0, dict(node.data))
        if node.kind == "call":
            name, arguments = node.data
            return algebra.call(name, *(self._value(a) for a in arguments))
        if node.kind == "select":
            condition, a, b = node.data
            return algebra.select(self._condition(condition), self._value(a), self._value(b))
        return (1.0, node)

    def _value(self, value):
        return value if value[1] is None else self.scaled(*value)

    def _condition(self, c):
        return (c[0],) + tuple(self._condition(x) if isinstance(x[0], str) else self._value(x) for x in c[1:])

    def _monomial(self, number, powers):
        value = (number, None)
        for base, p in powers.items():
            value = self.algebra.multiply(value, self.algebra.power(self._new(base), p))
        return value

    def _own_factor(self, powers, count):
        """The factor by which a term is collected: it depends on the fewest symbols and is in the fewest sums."""
        return min(powers, key=lambda b: (len(b.unknowns), self.num_sums[b], -count[b], b.number), default=None)

    def _collected(self, terms):
        """Sum of terms, collected by each one's own factor."""
        if len(terms) < 2:
            return self.algebra.add(*(self._monomial(*term) for term in terms))
        count = Counter(base for _, powers in terms for base in powers)
        own = [self._own_factor(powers, count) for _, powers in terms]
        shared = [
            (len(self.num_sums), 0) if base is None else (len(base.unknowns), self.num_sums[base]) for base in own
        ]
        # What most sums have may be the same in all of them: a value of its own.
        common = [term for term, n in zip(terms, shared) if n == max(shared)]
        if 1 < len(common) < len(terms):
            others = [term for term, n in zip(terms, shared) if n < max(shared)]
            return self.algebra.add(self._collected(common), self._collected(others))
        groups = {}
        for (number, powers), base in zip(terms, own):
            key = (base, -1 if base is not None and powers[base] < 0 else 1)
            groups.setdefault(key, []).append((number, powers))
        values = []
        for (base, power), group in groups.items():
            if len(group) == 1 or base is None:
                values += [self._monomial(*term) for term in group]
                continue
            rest = self._collected([(number, _product(powers, {base: power}, -1)) for number, powers in group])
            values.append(self.algebra.multiply(self.algebra.power(self._new(base), power), rest))
        return self.algebra.add(*values)


def _product(a, b, power=1):
    """Exponents of a b^power."""
    total = Counter(a)
    for base, p in b.items():
        total[base] += power * p
        if total[base] == 0:
            del total[base]
    return total


def _children_first(roots):
    """All nodes that roots are made of, each after those that it is made of."""
    order, seen, stack = [], set(), [(r, False) for r in roots]
    while stack:
        node, ready = stack.pop()
        if ready:
            order.append(node)
        elif node not in seen:
            seen.add(node)
            stack.append((node, True))
            stack.extend((child, False) for child in alg.children(node))
    return order


def _unguarded(roots):
    """Nodes that are computed whatever conditions hold, and those whose reciprocals are."""
    seen, reciprocals, stack = set(), set(), list(roots)
    while stack:
        node = stack.pop()
        if node in seen:
            continue
        seen.add(node)
        if node.kind == "select":
            stack.extend(alg.condition_nodes(node.data[0]))
        else:
            stack.extend(alg.children(node))
        if node.kind == "product":
            reciprocals |= {base for base, p in node.data if p < 0}
    return seen, reciprocals
