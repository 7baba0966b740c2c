# SPDX-License-Identifier: MIT
"""Third stage: shared scalar expressions -> LNodes declarations, each placed at the level it depends on.

Products become chains whose common heads are shared (factors used most come first), negative powers become one
reciprocal, and every value used twice, or used at a deeper level than its own, becomes a variable.
"""

from collections import Counter

import ffcx.codegeneration.lnodes as L

from . import algebra as alg
from .cxx import AnyLane
from .shared_pairs import Factor, trees

WORTH_A_BRANCH = 40  # operations that a branch may save, some 40 clock cycles against a few
CHEAP = ("abs", "min_value", "max_value")  # functions of one operation
FUNCTION = 20  # operations of another function, of vectors
REAL, SCALAR, BOOL = L.DataType.REAL, L.DataType.SCALAR, L.DataType.BOOL


class Schedule:
    """Orders and names the scalar expressions of one integral.

    Args:
        access: function (symbol key) -> LNodes expression that reads the symbol.
        prefix: of the variables declared.
        share_pairs: whether products share the pairs of factors that most of them have (shared_pairs.py), otherwise
            their heads in the order of the factors' frequency.
    """

    def __init__(self, access, prefix="t", share_pairs=False):
        self.access, self.prefix, self.share_pairs = access, prefix, share_pairs
        self._plans = {}  # (product, number of a root) -> tree of its factors
        self._low = {}  # hash-consed low-level nodes: key -> index
        self._key, self._level, self._args = [], [], []
        self._of = {}  # algebra node -> low index
        self._frequency = Counter()
        self._variable = {}  # low index -> LNodes symbol
        self._num_variables = 0
        self._uses = Counter()
        self._deeper = set()

    # -- lowering ---------------------------------------------------------------------------------------------------
    def prepare(self, values):
        """Lower the values (pairs of number and node) that will be asked for with `expression`."""
        roots = [n for _, n in values if n is not None]
        seen, stack = set(), list(roots)
        while stack:
            node = stack.pop()
            if node in seen:
                continue
            seen.add(node)
            if node.kind == "product":
                self._frequency.update(n for n, _ in node.data)
            stack.extend(alg.children(node))
        if self.share_pairs:
            self._plan(values, seen)
        self._roots = {v: self._root(v) for v in values if v[1] is not None}
        self._uses, self._deeper = Counter(), set()
        visited, stack = set(), [low for _, low in self._roots.values()]
        self._uses.update(stack)
        while stack:
            i = stack.pop()
            if i in visited:
                continue
            visited.add(i)
            for j in self._args[i]:
                self._uses[j] += 1
                if self._level[j] < self._level[i]:
                    self._deeper.add(j)
                stack.append(j)

    def _plan(self, values, nodes):
        """Trees of all products; the numbers of values that are asked for and of terms of sums are factors, too."""
        terms = [(c, n) for node in nodes if node.kind == "sum" for c, n in node.data]
        numbered = {
            (n, abs(c)) for c, n in [*values, *terms] if n is not None and n.kind == "product" and abs(c) != 1.0
        }
        wanted = {(n, None): list(n.data) for n in nodes if n.kind == "product"}
        wanted |= {(n, c): [*n.data, (c, 1)] for n, c in numbered}
        keys = sorted(wanted, key=lambda k: (k[0].number, k[1] or 0.0))
        factors = []
        for key in keys:
            factors.append([])
            for base, p in wanted[key]:
                level, number = (alg.CONSTANT, -1) if isinstance(base, float) else (base.level, base.number)
                factors[-1] += [Factor(level, number, base, p < 0)] * abs(p)
        self._plans = dict(zip(keys, trees(factors)))

    def _tree(self, tree):
        """Low-level node of a tree of factors."""
        if isinstance(tree, Factor):
            if isinstance(tree.base, float):
                return self._make(("number", tree.base), (), alg.CONSTANT)
            low = self._lower(tree.base)
            return self._make(("reciprocal", low), (low,), tree.level) if tree.inverse else low
        a, b = (self._tree(t) for t in tree)
        return self._make(("multiply", a, b), (a, b), max(self._level[a], self._level[b]))

    def _make(self, key, args, level):
        i = self._low.get(key)
        if i is None:
            i = self._low[key] = len(self._key)
            self._key.append(key)
            self._args.append(args)
            self._level.append(level)
        return i

    def _lower(self, node):
        done = self._of.get(node)
        if done is not None:
            return done
        if node.kind == "symbol":
            i = self._make(("symbol", node.data), (), node.level)
        elif node.kind == "product":
            i = self._chain(node)
        elif node.kind == "sum":
            terms = tuple((c, None) if n is None else self._term(c, n) for c, n in node.data)
            i = self._make(("sum", terms), tuple(n for _, n in terms if n is not None), node.level)
        elif node.kind == "call":
            name, args = node.data
            low = tuple((c, None if n is None else self._lower(n)) for c, n in args)
            i = self._make(("call", name, low), tuple(n for _, n in low if n is not None), node.level)
        else:
            condition, a, b = node.data
            args = []
            key = ("select", self._condition(condition, args), self._pair(a, args), self._pair(b, args))
            i = self._make(key, tuple(args), node.level)
        self._of[node] = i
        return i

    def _term(self, c, node):
        """(number, low) of a term of a sum. Where pairs are shared, the number joins a product."""
        if not self.share_pairs or node.kind != "product" or abs(c) == 1.0:
            return (c, self._lower(node))
        return (1.0 if c > 0 else -1.0, self._tree(self._plans[node, abs(c)]))

    def _root(self, value):
        """(sign, low) of a value asked for from outside: its number joins the product, so that it can be shared."""
        c, node = value
        if self.share_pairs or node.kind != "product" or abs(c) == 1.0:
            return self._term(c, node)
        number = (alg.CONSTANT, 0, -1, self._make(("number", abs(c)), (), alg.CONSTANT))
        return (1.0 if c > 0 else -1.0, self._chain(node, [number]))

    def _pair(self, value, args):
        c, n = value
        if n is not None:
            args.append(self._lower(n))
            return (c, args[-1])
        return (c, None)

    def _condition(self, c, args):
        return (c[0],) + tuple(
            self._condition(x, args) if isinstance(x[0], str) else self._pair(x, args) for x in c[1:]
        )

    def _chain(self, node, numbers=()):
        if self.share_pairs:
            return self._tree(self._plans[node, None])
        factors = list(numbers)
        for base, p in node.data:
            low = self._lower(base)
            level = base.level
            if p < 0:
                low = self._make(("reciprocal", low), (low,), level)
            factors += [(level, -self._frequency[base], base.number, f) for f in self._squares(low, level, abs(p))]
        factors.sort()
        head = factors[0][3]
        for level, _, _, low in factors[1:]:
            head = self._make(("multiply", head, low), (head, low), level)
        return head

    def _squares(self, low, level, power):
        """Factors of an integer power: the value itself up to its third power, beyond that repeated squares."""
        if power < 4:
            return [low] * power
        factors = []
        while power:
            if power % 2:
                factors.append(low)
            power //= 2
            if power:
                low = self._make(("multiply", low, low), (low, low), level)
        return factors

    # -- writing ----------------------------------------------------------------------------------------------------
    def level_of(self, value):
        return alg.CONSTANT if value[1] is None else value[1].level

    def declare(self, values, level):
        """Declarations of all variables of one level that the values need; call for each level in turn."""
        statements = []
        for value in values:
            if value[1] is not None:
                self._declare(self._roots[value][1], level, statements, set())
        return statements

    def _declare(self, i, level, statements, visiting):
        stack = [(i, False)]
        while stack:
            j, ready = stack.pop()
            if j in self._variable or (not ready and j in visiting):
                continue
            if not ready:
                visiting.add(j)
                stack.append((j, True))
                stack.extend((k, False) for k in reversed(self._args[j]))
                continue
            if self._level[j] == level and self._needs_variable(j):
                symbol = L.Symbol(f"{self.prefix}{self._num_variables}", SCALAR if level > alg.CONSTANT else REAL)
                self._num_variables += 1
                value = self._expression(j)
                self._variable[j] = symbol
                statements.append(L.VariableDecl(symbol, value))

    def forget(self, level, kept=()):
        """Forget the variables of a level and those above it, as their loop has ended, but those that are kept."""
        self._variable = {j: v for j, v in self._variable.items() if self._level[j] < level or j in kept}

    def keep(self, values, level, place):
        """Store variables of a level that other values, which a later loop computes, are made of.

        Args:
            values: the later values.
            level: level of the variables.
            place: function (number, count) -> LNodes expression of the place of one of so many variables.

        Returns:
            Statements that store them, and the identities of what is stored, for `forget`.
        """
        seen, statements, kept = set(), [], set()
        stack = [self._roots[v][1] for v in values if v[1] is not None]
        while stack:
            j = stack.pop()
            if j in seen:
                continue
            seen.add(j)
            if j not in self._variable:
                stack.extend(self._args[j])
            elif self._level[j] == level:
                kept.add(j)
        for number, j in enumerate(sorted(kept)):
            target = place(number, len(kept))
            statements.append(L.Assign(target, self._variable[j]))
            self._variable[j] = target
        return statements, kept

    def _needs_variable(self, j):
        if self._key[j][0] in ("symbol", "number"):
            return False
        return self._uses[j] > 1 or j in self._deeper

    def expression(self, value):
        """LNodes expression of a value whose variables have been declared."""
        c, node = value
        if node is None:
            return L.LiteralFloat(c)
        sign, low = self._roots[value]
        return self._times(sign, self._read(low))

    def _read(self, j):
        return self._variable.get(j) or self._expression(j)

    def _times(self, c, e):
        if c == 1.0:
            return e
        if c == -1.0:
            return L.Neg(e)
        return L.Mul(L.LiteralFloat(float(c)), e)

    def _value(self, pair):
        c, j = pair
        return L.LiteralFloat(float(c)) if j is None else self._times(c, self._read(j))

    def _expression(self, j):
        key = self._key[j]
        kind = key[0]
        if kind == "symbol":
            return self.access(key[1])
        if kind == "number":
            return L.LiteralFloat(key[1])
        if kind == "multiply":
            return L.Mul(self._read(key[1]), self._read(key[2]))
        if kind == "reciprocal":
            return L.Div(L.LiteralFloat(1.0), self._read(key[1]))
        if kind == "sum":
            return self._sum(key[1])
        if kind == "call":
            call = L.MathFunction(key[1], [self._value(a) for a in key[2]])
            call.dtype = SCALAR if self._level[j] > alg.CONSTANT else REAL
            return call
        _, condition, a, b = key
        result = L.Conditional(self._test(condition), self._value(a), self._value(b))
        result.dtype = SCALAR if self._level[j] > alg.CONSTANT else REAL
        return result

    def separate(self, values, level, place, at_least, first=None):
        """Conditionals of one condition whose first values cost much and belong to nothing else: they can be left out
        where the condition holds in no lane. What other values need is declared before, and read again afterwards.

        Args:
            values: values that are asked for next.
            level: highest level of the conditionals; variables up to it may be declared.
            place: function (number, count) -> LNodes expression of the place of one of so many conditionals.
            at_least: number of operations from which it is worth a branch, WORTH_A_BRANCH unless there is one [1].
            first: None, or a pair of an algebra node of kind "select" and a function that returns statements, which
                begin the branch of this node's condition and find what values of the level SOLVED depend on; what they
                declare ends with the branch. Only this condition is taken then.

        Returns:
            Number of conditionals, statements in front of the branch, its condition and its statements; zero and
            nothing where there are none.
        """
        return self._separate([self._roots[v][1] for v in values if v[1] is not None], level, place, at_least, first)

    def _separate(self, roots, level, place, at_least, first=None, done=()):
        """`separate` for low-level nodes; conditions in `done` have their branch already."""
        groups = {}
        for j in sorted(self._open(roots)):
            if self._key[j][0] == "select" and alg.POINT <= self._level[j] <= level:
                groups.setdefault(self._key[j][1], []).append(j)
        levels = range(alg.POINT, level + 1)
        # What depends on the solution is not known in front of a branch that solves.
        earlier = range(alg.POINT, alg.SOLVED if first else level + 1)
        if first:
            groups = {c: g for c, g in groups.items() if c == self._key[self._of[first[0]]][1]}
        for condition, selects in groups.items():
            if condition in done:
                continue
            inner = [self._key[j][2][1] for j in selects if self._key[j][2][1] is not None]
            others = [n for j in selects for n in self._args[j] if n not in inner]
            if any(self._level[n] not in earlier and self._level[n] >= alg.POINT for n in others):
                continue
            outside = self._open([*roots, *others], selects) - set(selects)
            if sum(map(self._cost, self._open(inner) - outside - set(selects))) < at_least:
                continue
            before, inside = [], []
            shared = sorted(n for n in outside if n in others or not self._open([n]) & set(selects))
            for lower in earlier:
                for n in shared:
                    self._declare(n, lower, before, set())
            places = [place(k, len(selects)) for k in range(len(selects))]
            before += [L.Assign(p, self._value(self._key[j][3])) for j, p in zip(selects, places)]
            test, known = self._test(condition), set(self._variable)
            inside += first[1]() if first else []
            # A branch in the branch, for a case that is rare.
            nested, *parts = self._separate(
                selects,
                level,
                lambda k, n, used=len(selects): place(k + used, n),
                WORTH_A_BRANCH,
                done=(*done, condition),
            )
            inside += [*parts[0], AnyLane(*parts[1:])] if nested else []
            for j, p in zip(selects, places):  # in the order in which they are made of each other
                for lower in levels:
                    for n in self._args[j]:
                        self._declare(n, lower, inside, set())
                inside.append(L.Assign(p, self._expression(j)))
                self._variable[j] = p
            self._variable = {j: v for j, v in self._variable.items() if j in known or j in selects}
            return len(selects) + nested, before, test, inside
        return 0, [], None, []

    def _cost(self, j):
        """Operations that a low-level node takes, about: those of functions are many."""
        return FUNCTION if self._key[j][0] == "call" and self._key[j][1] not in CHEAP else 1

    def _open(self, roots, ends=()):
        """Low-level nodes that are computed for some others, those included; not below `ends` nor variables."""
        seen, stack = set(), list(roots)
        while stack:
            j = stack.pop()
            if j in seen or j in self._variable:
                continue
            seen.add(j)
            if j not in ends:
                stack.extend(self._args[j])
        return seen

    def is_used_once(self, value):
        """Is a value, which was asked for, part of no other?"""
        return self._uses[self._roots[value][1]] == 1

    def symbols_to_read(self, values):
        """Keys of the symbols that are read when these values are computed from now on."""
        nodes = self._open([self._roots[v][1] for v in values if v[1] is not None])
        return [self._key[j][1] for j in nodes if self._key[j][0] == "symbol"]

    def condition(self, select):
        """LNodes expression of the condition of an algebra node of kind "select", whose variables are declared."""
        return self._test(self._key[self._of[select]][1])

    def _sum(self, terms):
        # A positive term first, so that the line does not begin with a minus sign.
        order = sorted(range(len(terms)), key=lambda k: (terms[k][0] < 0, k))
        result = None
        for k in order:
            c, j = terms[k]
            term = L.LiteralFloat(abs(c)) if j is None else self._times(abs(c), self._read(j))
            if result is None:
                result = term if c > 0 else L.Neg(term)
                continue
            result = L.Add(result, term) if c > 0 else L.Sub(result, term)
        return result

    def _test(self, c):
        operator, *operands = c
        args = [self._test(x) if isinstance(x[0], str) else self._value(x) for x in operands]
        if operator == "!":
            return L.Not(args[0])
        return _COMPARE[operator](*args)


_COMPARE = {"<": L.LT, "<=": L.LE, ">": L.GT, ">=": L.GE, "==": L.EQ, "!=": L.NE, "&&": L.And, "||": L.Or}
