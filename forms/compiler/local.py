# SPDX-License-Identifier: MIT
"""A point law inside a kernel: the local equations solved at each point, and the outputs stored behind the element
tensor."""

import ffcx.codegeneration.lnodes as L

from . import algebra as alg
from .cxx import LocalSolve, Text

INT, SCALAR = L.DataType.INT, L.DataType.SCALAR
A = L.Symbol("A", SCALAR)
SOLUTION = "local"


class LocalPart:
    """Statements of a point law, before, inside and after the loop over the points.

    Args:
        writer: KernelWriter of an integral with a law.
    """

    def __init__(self, writer):
        self.writer, self.integral, self.law = writer, writer.integral, writer.integral.law
        self.values = {}  # part -> values of its components

    def unknown(self, component, iterating):
        """Value of a local unknown: the solution, or the iterate inside the local equations."""
        if iterating:
            return self.writer.algebra.symbol(("unknown", "iterate", component), alg.ITERATE)
        return self.writer.algebra.symbol(("unknown", f"{SOLUTION}_x", component), alg.SOLVED)

    def read(self, rule):
        """Read the law's expressions into the form's algebra, at the points of its rule."""
        self.rule = rule
        solved, iterated = self._components(False), self._components(True)
        for part, (first, count) in self.law.parts.items():
            of_iterate = part in ("residual", "jacobian")
            self.values[part] = (iterated if of_iterate else solved)[first : first + count]

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
        return [v for components in self.values.values() for v in components]

    def before(self):
        """Statements before the loop over the points."""
        count = self.law.num_unknowns
        return [Text(f"LocalFailures<T, {count}> failures;")] if count else []

    def inside(self, factors):
        """Statements at a point, in front of those of the element tensor, whose factors are declared here, too."""
        schedule = self.writer.schedule
        wanted = factors + self.wanted()
        statements = schedule.declare(wanted, alg.POINT)
        if self.law.num_unknowns:
            statements.append(self._solve())
            statements.append(Text(f"failures.add({SOLUTION}, {self._point_text()});"))
        statements += schedule.declare(wanted, alg.SOLVED)
        for output, offset in zip(self.law.outputs, self.integral.output_offsets):
            for c, value in enumerate(self.values[f"output {output.name}"]):
                point = L.Mul(L.LiteralInt(output.num_components), self.rule.flat(self.writer.tdim))
                index = L.Add(point, L.LiteralInt(offset + c))
                statements.append(L.Assign(A[index], schedule.expression(value)))
        return statements

    def _solve(self):
        schedule, values = self.writer.schedule, self.values
        equations = values["residual"] + values["jacobian"]
        inner = schedule.declare(equations, alg.ITERATE)
        for name in ("residual", "jacobian"):
            array = L.Symbol(name, SCALAR)
            inner += [L.Assign(array[i], schedule.expression(v)) for i, v in enumerate(values[name])]
        start = [schedule.expression(v) for v in values["start"]]
        return LocalSolve(SOLUTION, start, schedule.expression(values["scale"][0]), inner)

    def _point_text(self):
        from .cxx import CxxFormatter

        return CxxFormatter()(self.rule.flat(self.writer.tdim))

    def after(self):
        """Statements behind the loop over the points."""
        if not self.law.num_unknowns:
            return []
        return [Text(f"failures.store(A + {self.integral.output_offsets[-1]});")]
