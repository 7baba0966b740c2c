# SPDX-License-Identifier: MIT
"""A point law and averages over the cell inside a kernel: the local equations solved at each point, outputs and sums
stored behind the element tensor, and the loops over the points that averages need before the last one."""

import ffcx.codegeneration.lnodes as L
import numpy as np

from . import algebra as alg
from .cxx import AnyLane, Apart, CxxFormatter, LocalSolve, StoreHistory, Text
from .schedule import WORTH_A_BRANCH

INT, SCALAR = L.DataType.INT, L.DataType.SCALAR
A = L.Symbol("A", SCALAR)
BRANCH = ("start", "scale", "start_error", "residual", "jacobian")  # equations where the branch's condition holds
EQUATIONS = (*BRANCH, "other residual", "other jacobian")
VOLUME, SUMS, SOLVED, KEPT, BRANCHED = "cell_volume", "cell_sums", "solved", "kept", "branched"
LOCAL_X = "local_x"  # of LocalSolve


def _array(name):
    return L.Symbol(name, SCALAR)


def _branched(number, _):
    """Place of a conditional that is computed in a branch."""
    return _array(BRANCHED)[number]


def _zero(name, size):
    return L.ArrayDecl(_array(name), sizes=(size,), values=np.zeros(size))


def _quadrature(key):
    """Field and first entry of a symbol of the algebra that is read at the points; None for others."""
    return (key[1], key[3]) if key[0] == "quadrature" else (key[1], key[2]) if key[0] == "dof" else None


def _assigned(statement):
    """What a statement assigns to, or None."""
    return statement.lhs if isinstance(statement, L.Assign) else None


class LocalPart:
    """Statements of a point law and of averages, before, inside and after the last loop over the points.

    Args:
        writer: KernelWriter of an integral with local expressions.
    """

    def __init__(self, writer):
        self.writer, self.integral, self.law = writer, writer.integral, writer.integral.law
        self.values = {}  # part -> values of its components
        self.last = self.law.num_loops - 1
        self.solves_last = self.law.num_unknowns > 0 and self.law.solved_in == self.last
        self.kept = self.law.num_unknowns > 0 and not self.solves_last  # solution in an array, by point
        self.branch = None  # the first equation, where it is a conditional
        self.written = False  # does a branch write the internal variables?

    # -- symbols ------------------------------------------------------------------------------------------------------
    def unknown(self, component, iterating):
        """Value of a local unknown: the solution, or the iterate inside the local equations."""
        kind, level = ("iterate", alg.ITERATE) if iterating else ("solution", alg.SOLVED)
        return self.writer.algebra.symbol((kind, component), level)

    def average(self, number, component):
        """Value of an average. Loops that do not have it yet do not ask for it."""
        return self.writer.algebra.symbol(("average", number, component), alg.AVERAGED)

    def access(self, key):
        """LNodes expression of one of these symbols."""
        if key[0] == "iterate":
            return _array("iterate")[key[1]]
        if key[0] == "average":
            return _array(f"average_{key[1]}")[key[2]]
        return self._solved(key[1]) if self.kept else _array(LOCAL_X)[key[1]]

    def _solved(self, component):
        return _array(SOLVED)[self._at_point(self.law.num_unknowns, component)]

    def _at_point(self, stride, offset):
        point = self.rule.flat(self.writer.tdim)
        return L.Add(L.Mul(L.LiteralInt(stride), point), L.LiteralInt(offset))

    # -- reading ------------------------------------------------------------------------------------------------------
    def read(self, rule, weight):
        """Read the expressions into the form's algebra, at the points of its rule."""
        self.rule = rule
        solved = self._components(False)
        iterated = self._components(True) if self.law.num_unknowns else solved
        for part, (first, count) in self.law.parts.items():
            of_iterate = part in ("residual", "jacobian")
            self.values[part] = (iterated if of_iterate else solved)[first : first + count]
        if self.law.num_unknowns:
            self._read_branch()
        if "volume" not in self.values:
            return
        multiply = self.writer.algebra.multiply
        (volume,) = self.values["volume"] = [multiply(weight, self.values["volume"][0])]
        for part, components in self.values.items():
            if part.split()[0] == "sum":
                self.values[part] = [multiply(volume, c) for c in components]
            elif part.split()[0] == "average" and not self.law.averages[int(part.split()[1])].maximum:
                self.values[part] = [self._weighted(volume, c) for c in components]

    def _read_branch(self):
        """Where the first equation is a conditional whose condition is known before the iteration, as that of yielding:
        equations that hold where no lane satisfies it, which need not evaluate what belongs to the others."""
        algebra, (_, first) = self.writer.algebra, self.values["residual"][0]
        if first is None or first.kind != "select" or alg.condition_level(first.data[0]) >= alg.SOLVED:
            return
        self.branch = first

        def otherwise(value):
            number, node = value
            if node is None or node.kind != "select" or node.data[0] != first.data[0]:
                return value
            return algebra.multiply(algebra.number(number), node.data[2])

        for part in ("residual", "jacobian"):
            self.values[f"other {part}"] = [otherwise(v) for v in self.values[part]]

    def _weighted(self, volume, value):
        """Value times the volume, w |det J|; a gradient's factor 1/det J is taken out, which saves its division."""
        algebra = self.writer.algebra
        for node, exponent in algebra.powers(volume).items():
            if node.kind != "call" or node.data[0] != "abs" or exponent != 1:
                continue
            ((scale, determinant),) = node.data[1]
            if algebra.powers(value).get(determinant) == -1:
                sign = algebra.select((">", (1.0, determinant), algebra.number(0.0)), *map(algebra.number, (1.0, -1.0)))
                size = algebra.multiply(algebra.number(abs(scale)), algebra.multiply(sign, (1.0, determinant)))
                volume = algebra.multiply(algebra.multiply(volume, algebra.power((1.0, node), -1)), size)
        return algebra.multiply(volume, value)

    def _components(self, iterating):
        """Values of all components; components that are zero have no entry in FFCx's graph."""
        writer, graph = self.writer, self.law.graph
        writer.iterating = iterating
        values = alg.GraphReader(writer.algebra, graph["factorization"], writer._terminal).read()
        writer.iterating = False
        size = sum(count for _, count in self.law.parts.values())
        components = [writer.algebra.number(0.0)] * size
        for contributions in graph["block_contributions"].values():
            for block in contributions:
                for index, component in block.factor_indices_comp_indices:
                    value = values[index]
                    components[component] = writer.algebra.close_sum(value) if isinstance(value, dict) else value
        return components

    def wanted(self):
        """Values that are asked for: all components."""
        return self._of(*self.values)

    def _of(self, *parts):
        return [v for part in parts for v in self.values.get(part, ())]

    def _parts(self, kind):
        return [part for part in self.values if part.split()[0] == kind]

    # -- writing ------------------------------------------------------------------------------------------------------
    def before(self, factors):
        """Statements before the last loop over the points: what it needs, and the loops before it."""
        law, statements = self.law, []
        if law.num_unknowns:
            statements.append(Text(f"LocalFailures<T, {law.num_unknowns}> failures;"))
        if self.kept:
            statements.append(L.ArrayDecl(_array(SOLVED), sizes=(law.num_unknowns * self.rule.num_points,)))
        if law.averages:
            statements.append(_zero(VOLUME, 1))
        for loop in range(self.last):
            statements += self._loop_of_averages(loop, factors)
        if law.sums:
            statements.append(_zero(SUMS, len(law.sums)))
        return statements + self.writer.schedule.declare(self._wanted_last(factors), alg.AVERAGED)

    def _wanted_last(self, factors):
        """Values that the last loop asks for."""
        parts = self._parts("output") + self._parts("sum") + list(EQUATIONS if self.solves_last else ())
        return factors + self._of(*parts)

    def _loop_of_averages(self, loop, factors):
        schedule = self.writer.schedule
        numbers = [i for i, average in enumerate(self.law.averages) if average.loop == loop]
        parts = [f"average {i}" for i in numbers] + (["volume"] if loop == 0 else [])
        solves = self.law.num_unknowns > 0 and loop == self.law.solved_in
        wanted = self._of(*parts, *(EQUATIONS if solves else ()))
        before = schedule.declare(wanted, alg.AVERAGED)
        inner = self._solve() if solves else []
        inner += schedule.declare(wanted, alg.POINT) + schedule.declare(wanted, alg.SOLVED)
        if loop == 0:
            inner.append(L.AssignAdd(_array(VOLUME)[0], schedule.expression(self.values["volume"][0])))
        for i in numbers:
            for c, value in enumerate(self.values[f"average {i}"]):
                entry, value = _array(f"average_{i}")[c], schedule.expression(value)
                larger = L.Assign(entry, L.MathFunction("max_value", [entry, value]))
                inner.append(larger if self.law.averages[i].maximum else L.AssignAdd(entry, value))
        kept = set()
        if loop == self.last - 1 and not self.kept:
            # The last loop reads what this one has computed.
            stored, kept = schedule.keep(
                self._wanted_last(factors), alg.POINT, lambda k, size: _array(KEPT)[self._at_point(size, k)]
            )
            inner += stored
        schedule.forget(alg.POINT, kept)
        sizes = {i: len(self.values[f"average {i}"]) for i in numbers}
        declarations = [_zero(f"average_{i}", size) for i, size in sizes.items()]
        if kept:
            declarations.append(L.ArrayDecl(_array(KEPT), sizes=(len(kept) * self.rule.num_points,)))
        lowest = L.LiteralFloat(float(np.finfo(float).min))
        first = [
            L.Assign(_array(f"average_{i}")[c], lowest)
            for i, size in sizes.items()
            if self.law.averages[i].maximum
            for c in range(size)
        ]
        divided = [
            L.Assign(_array(f"average_{i}")[c], L.Div(_array(f"average_{i}")[c], _array(VOLUME)[0]))
            for i, size in sizes.items()
            if not self.law.averages[i].maximum
            for c in range(size)
        ]
        loops = self.writer.point_loops(self.rule, inner, always=True)
        return [L.Section(f"averages over the cell, loop {loop}", before + first + loops + divided, declarations)]

    def inside(self, factors):
        """Statements at a point of the last loop, in front of those of the element tensor, whose factors are declared
        here, too."""
        schedule = self.writer.schedule
        values = factors + self._of(*self._parts("output"), *self._parts("sum"))
        solve = (self.branch, self._solve_in_branch) if self.solves_last and self._is_zero_elsewhere() else None
        count, statements, condition, branch = 0, [], None, []
        if solve:
            count, statements, condition, branch = schedule.separate(values, alg.SOLVED, _branched, 0, solve)
            if count:
                statements = [_zero(LOCAL_X, self.law.num_unknowns), *statements]
        if not count:
            # What the equations do not need comes after them: it would only take registers while they are solved.
            solved = self._solve() if self.solves_last else []
            count, statements, condition, branch = schedule.separate(values, alg.SOLVED, _branched, WORTH_A_BRANCH)
            statements = solved + statements
        if count:
            statements, branch = self._write_in_branch(statements, branch, factors)
            statements = [L.ArrayDecl(_array(BRANCHED), sizes=(count,)), *statements, AnyLane(condition, branch)]
        return statements + schedule.declare(factors, alg.POINT) + schedule.declare(factors, alg.SOLVED)

    def behind(self):
        """Statements at a point of the last loop behind those of the element tensor: outputs and sums."""
        schedule = self.writer.schedule
        values = self._of(*self._parts("output"), *self._parts("sum"))
        statements = schedule.declare(values, alg.POINT) + schedule.declare(values, alg.SOLVED)
        for k, name in enumerate(self.law.sums):
            statements.append(L.AssignAdd(_array(SUMS)[k], schedule.expression(self.values[f"sum {name}"][0])))
        return statements + self._outputs()

    def _new_history(self):
        """Of each component of the internal variables in place its name, new value, old one and place of the new one;
        the old value's symbol in the algebra comes last."""
        found = []
        for number, output in enumerate(self.law.outputs if self.integral.is_in_place else ()):
            if output.history < 0:
                continue
            first = self.integral.coefficients[output.history].offset
            for c, value in enumerate(self.values[f"output {output.name}"]):
                index = self._at_point(output.num_components, c)
                old, new = (_array(f"{what}_{number}")[index] for what in ("history", "output"))
                found.append((f"new_{number}_{c}", value, old, new, (f"w{output.history}", first + c)))
        return found

    def _write_in_branch(self, statements, branch, factors):
        """Internal variables that a branch alone changes are written there, where nothing reads the old ones later.

        Args:
            statements: those in front of the branch, which gives first values to what the branch changes.
            branch: statements of the branch.
            factors: of the element tensor, which is computed behind.

        Returns:
            Statements in front of the branch, and those of it.
        """
        schedule, history = self.writer.schedule, self._new_history()
        symbols = {symbol for *_, symbol in history}
        places = {}
        for name, (number, node), old, new, symbol in history:
            if number != 1.0 or node is None or node.kind != "select" or not schedule.is_used_once((number, node)):
                return statements, branch
            scale, other = node.data[2]
            place = schedule.expression((number, node))
            keeps = scale == 1.0 and other is not None and other.kind == "symbol" and _quadrature(other.data) == symbol
            if not keeps or not any(_assigned(s) is place for s in branch):
                return statements, branch
            places[id(place)] = (_array(name), old, new)
        later = factors + self._of(
            *self._parts("sum"), *(f"output {o.name}" for o in self.law.outputs if o.history < 0)
        )
        if not places or any(_quadrature(key) in symbols for key in schedule.symbols_to_read(later)):
            return statements, branch
        self.written = True
        kept = [L.Assign(new, old) for _, old, new in places.values()]
        statements = [s for s in statements if id(_assigned(s)) not in places]
        branch = [
            L.VariableDecl(places[id(_assigned(s))][0], s.rhs) if id(_assigned(s)) in places else s for s in branch
        ]
        return [*statements, Apart(kept)], [*branch, *(L.Assign(new, name) for name, _, new in places.values())]

    def _outputs(self):
        """Statements that write the outputs. They come last: in place, what they overwrite is not read afterwards."""
        schedule, history = self.writer.schedule, [] if self.written else self._new_history()
        statements = [L.VariableDecl(_array(name), schedule.expression(value)) for name, value, *_ in history]
        if history:
            statements.append(StoreHistory([(_array(name), old, new) for name, _, old, new, _ in history]))
        others = []
        for output, offset in zip(self.law.outputs, self.integral.output_offsets):
            if self.integral.is_in_place and output.history >= 0:
                continue
            for c, value in enumerate(self.values[f"output {output.name}"]):
                index = self._at_point(output.num_components, offset + c)
                others.append(L.Assign(A[index], schedule.expression(value)))
        return [*statements, Apart(others)] if self.integral.is_in_place and others else [*statements, *others]

    def _is_zero_elsewhere(self):
        """Do the equations say that the unknowns are zero where the condition of the first one does not hold?"""
        n, number = self.law.num_unknowns, self.writer.algebra.number
        if self.branch is None:
            return False
        unknowns = [self.unknown(i, True) for i in range(n)]
        unit = [number(i == j) for i in range(n) for j in range(n)]
        return self.values["other residual"] == unknowns and self.values["other jacobian"] == unit

    def _solve_in_branch(self):
        """Statements that solve the local equations where their condition holds in a lane."""
        schedule, values = self.writer.schedule, self.values
        statements = schedule.declare(self._of(*BRANCH), alg.POINT)
        start = [schedule.expression(v) for v in values["start"]]
        equations = self._equations("residual", "jacobian")
        error = schedule.expression(values["start_error"][0]) if "start_error" in values else None
        scale = schedule.expression(values["scale"][0])
        solve = LocalSolve("local", start, scale, equations, declared=True, error=error)
        return [*statements, solve, self._failures()]

    def _failures(self):
        return Text(f"failures.add(local, {CxxFormatter()(self.rule.flat(self.writer.tdim))});")

    def _solve(self):
        schedule, values = self.writer.schedule, self.values
        statements = schedule.declare(self._of(*EQUATIONS), alg.POINT)
        start = [schedule.expression(v) for v in values["start"]]
        condition = None if self.branch is None else schedule.condition(self.branch)
        other = None if self.branch is None else self._equations("other residual", "other jacobian")
        equations = self._equations("residual", "jacobian")
        statements += [
            LocalSolve("local", start, schedule.expression(values["scale"][0]), equations, condition, other),
            self._failures(),
        ]
        if self.kept:
            statements += [L.Assign(self._solved(i), _array(LOCAL_X)[i]) for i in range(self.law.num_unknowns)]
        return statements

    def _equations(self, residual, jacobian):
        """Statements that fill the arrays of the residual and of its derivative with these parts."""
        schedule = self.writer.schedule
        statements = schedule.declare(self._of(residual, jacobian), alg.ITERATE)
        for name, part in (("residual", residual), ("jacobian", jacobian)):
            statements += [L.Assign(_array(name)[i], schedule.expression(v)) for i, v in enumerate(self.values[part])]
        schedule.forget(alg.ITERATE)
        return statements

    def after(self):
        """Statements behind the loops over the points."""
        statements = [
            L.Assign(A[L.LiteralInt(self.integral.sum_offset + k)], _array(SUMS)[k]) for k in range(len(self.law.sums))
        ]
        if self.law.num_unknowns:
            statements.append(Text(f"failures.store(A + {self.integral.report_offset});"))
        return statements
