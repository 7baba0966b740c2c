# SPDX-License-Identifier: MIT
"""LNodes for sum factorisation: lattice values of a field -> values at the points of a product rule, and back."""

import itertools

import ffcx.codegeneration.lnodes as L

from .cxx import Unrolled

INT, SCALAR = L.DataType.INT, L.DataType.SCALAR


def combine(pairs):
    """LNodes expression of a sum of number times expression; zeros left out, None if nothing is left."""
    result = None
    for c, e in sorted(pairs, key=lambda p: p[0] < 0):
        if c == 0.0:
            continue
        term = e if abs(c) == 1.0 else L.Mul(L.LiteralFloat(abs(float(c))), e)
        if result is None:
            result = term if c > 0 else L.Neg(term)
        else:
            result = L.Add(result, term) if c > 0 else L.Sub(result, term)
    return result


def _loops(indices, sizes, body):
    for index, size in reversed(list(zip(indices, sizes))):
        body = [Unrolled(index, 0, size, body)] if size > 1 else body
    return body


def _at(symbol, position):
    access = symbol
    for i in position:
        access = access[i]
    return access


def _stage_name(base, prefix):
    return base + "_" + "".join(map(str, prefix))


def evaluate_field(writer, rule, field, needed):
    """Section that fills the arrays <field>_D<derivatives>_<rule>[component][q0][q1](...).

    Args:
        writer: KernelWriter. rule: Rule. field: "x" or "w<k>".
        needed: dict (component, derivative counts) -> function from dof number to array index.
    """
    dim = writer.tdim
    factor = writer._factors(field, rule)
    m = factor.num_points
    components = sorted({c for c, _ in needed})
    derivatives = sorted({d for _, d in needed})
    source = writer.integral.coefficients[int(field[1:])] if field != "x" else None
    size = max(components) + 1
    declarations, statements = [], []
    for d in derivatives:
        symbol = L.Symbol(writer.field_name(rule.number, field, d), SCALAR)
        declarations.append(L.ArrayDecl(symbol, sizes=(size, *(1 if factor.constant(k) else m for k in d))))
    by_derivatives = {}
    for c in components:
        by_derivatives.setdefault(frozenset(d for cc, d in needed if cc == c), []).append(c)
    for wanted, group in by_derivatives.items():
        whole = len(group) > 1 and group == list(range(len(group)))
        for c in [None] if whole else group:
            index = L.Symbol("k", INT) if c is None else L.LiteralInt(c)
            dof = next(f for (cc, _), f in needed.items() if cc == (group[0] if c is None else c))
            stride, start = dof(1) - dof(0), dof(0)
            read = _reader(field, start, stride, index if c is None else None)
            body = _evaluate_component(writer, rule, field, factor, sorted(wanted), index, read)
            statements += [L.ForRange(index, 0, len(group), body)] if c is None else [_scope(body)]
    what = "coordinates" if field == "x" else source.name
    order = f"{what}: values and reference derivatives at the {m}^{dim} points, one direction after the other"
    return L.Section(order, statements, declarations)


def _scope(body):
    """A block of its own, so that names inside it can be used again."""
    return L.ForRange(L.Symbol("once", INT), 0, 1, body)


def _reader(field, start, stride, component):
    array = L.Symbol("coordinate_dofs" if field == "x" else "w", SCALAR)

    def read(node):
        index = L.LiteralInt(start + stride * node)
        return array[index if component is None else L.Add(index, component)]

    return read


def _evaluate_component(writer, rule, field, factor, wanted, component, read):
    dim, m, n = writer.tdim, factor.num_points, factor.num_nodes
    body, stages = [], {(): None}
    for axis in range(dim):
        following = {}
        for prefix in sorted({d[: axis + 1] for d in wanted}):
            table = factor.unit_table(prefix[-1])
            points = 1 if factor.constant(prefix[-1]) else m
            before = [1 if factor.constant(k) else m for k in prefix[:-1]]
            last = axis == dim - 1
            if last:
                out = L.Symbol(writer.field_name(rule.number, field, prefix), SCALAR)[component]
            else:
                out = L.Symbol(_stage_name(field, prefix), SCALAR)
                body.append(L.ArrayDecl(out, sizes=(*before, points, *[n] * (dim - axis - 1))))
            following[prefix] = out
            if axis == 0:
                for rest in itertools.product(range(n), repeat=dim - 1):
                    for q in range(points):
                        nodes = [factor.node[_flat((i, *rest), n)] for i in range(n)]
                        value = combine([(table[q, i], read(nodes[i])) for i in range(n)])
                        body.append(L.Assign(_at(out, (q, *rest)), value))
                continue
            source = stages[prefix[:-1]]
            indices = [L.Symbol(f"a{i}", INT) for i in range(dim - 1)]
            sizes = before + [n] * (dim - axis - 1)
            position = [i if s > 1 else L.LiteralInt(0) for i, s in zip(indices, sizes)]
            inner = []
            for q in range(points):
                terms = [(table[q, i], _at(source, (*position[:axis], i, *position[axis:]))) for i in range(n)]
                inner.append(L.Assign(_at(out, (*position[:axis], q, *position[axis:])), combine(terms)))
            body += _loops(indices, sizes, inner)
        stages = following
    return body


def _flat(index, n):
    number = 0
    for i in index:
        number = number * n + i
    return number


def integrate_test(writer, rule, factor, name, derivatives, dofs, component, add):
    """Statements A[dof] += sum over points of (1D tables)^T times the array <name>_D<derivatives>[component].

    Args:
        factor: tensor.Factors of the test function. derivatives: list of derivative counts.
        dofs: function node -> index into A (an LNodes expression when `component` is a loop index).
    """
    dim, m, n = writer.tdim, factor.num_points, factor.num_nodes
    body = []
    stages = {d: L.Symbol(f"{name}_D{''.join(map(str, d))}", SCALAR)[component] for d in derivatives}
    for axis in reversed(range(1, dim)):
        merged = {}
        for d in stages:
            merged.setdefault(d[:-1], []).append(d)
        following = {}
        for prefix, ends in sorted(merged.items()):
            before = [1 if factor.constant(k) else m for k in prefix]
            out = L.Symbol(_stage_name(f"{name}_s", prefix), SCALAR)
            after = [n] * (dim - axis - 1)
            body.append(L.ArrayDecl(out, sizes=(*before, n, *after)))
            indices = [L.Symbol(f"a{i}", INT) for i in range(dim - 1)]
            sizes = before + after
            position = [i if s > 1 else L.LiteralInt(0) for i, s in zip(indices, sizes)]
            inner = []
            for i in range(n):
                terms = []
                for d in ends:
                    table = factor.unit_table(d[-1])
                    points = 1 if factor.constant(d[-1]) else m
                    terms += [
                        (table[q, i], _at(stages[d], (*position[:axis], q, *position[axis:]))) for q in range(points)
                    ]
                inner.append(L.Assign(_at(out, (*position[:axis], i, *position[axis:])), combine(terms)))
            body += _loops(indices, sizes, inner)
            following[prefix] = out
        stages = following
    for nodes in itertools.product(range(n), repeat=dim):
        terms = []
        for d, source in stages.items():
            table = factor.unit_table(d[0])
            points = 1 if factor.constant(d[0]) else m
            terms += [(table[q, nodes[0]], _at(source, (q, *nodes[1:]))) for q in range(points)]
        body.append(add(dofs(factor.node[_flat(nodes, n)]), combine(terms)))
    return body
