# SPDX-License-Identifier: MIT
"""The element tensor: weighted factors times tables of test and trial functions, added to A."""

import ffcx.codegeneration.lnodes as L
import numpy as np

from . import tensor
from .cxx import Rounded
from .sumfactorisation import combine, integrate_test

INT, REAL, SCALAR = L.DataType.INT, L.DataType.REAL, L.DataType.SCALAR
A = L.Symbol("A", SCALAR)


def _symbol(name):
    return L.Symbol(name, SCALAR)


class ElementTensor:
    """Statements before, inside and after the loop over the points of one rule.

    Args:
        writer: KernelWriter. rule: Rule.
        targets: pairs ((block, component), value); value is weight times factor.
    """

    def __init__(self, writer, rule, targets):
        self.writer, self.rule, self.targets = writer, rule, targets
        self.integral, self.rank = writer.integral, writer.integral.rank
        self.tensor, self.reduced = {}, []
        if self.rank == 1:
            self._plan_vector()

    # -- rank 1 -------------------------------------------------------------------------------------------------------
    def _plan_vector(self):
        """Sort the blocks: by sum factorisation, or by a reduced table."""
        element = self.integral.argument_elements[0]
        factor = tensor.factors(element, self.rule.points) if self.rule.grid is not None else None
        for (block, _), value in self.targets:
            tr = block.ma_data[0].tabledata
            table, row = self.writer.rows(self._argument(block, 0), tr)
            begin, stride = int(tr.offset), int(tr.block_size)
            uniform = row is None
            derivatives = self._derivatives(block)
            known = not tr.is_piecewise or self.rule.num_points == 1
            if uniform and factor is not None and known and tensor.matches(factor, derivatives, table[0]):
                self.factor, self.stride = factor, stride
                self.tensor[(begin, derivatives)] = value
            else:
                self.reduced.append((tr, table, begin, stride, row, value))

    def _argument(self, block, number):
        """Modified test (0) or trial function (1) of a block."""
        return self.rule.data["modified_arguments"][block.ma_data[number].ma_index]

    def _derivatives(self, block):
        counts = [0] * self.writer.tdim
        for d in self._argument(block, 0).local_derivatives:
            counts[d] += 1
        return tuple(counts)

    def _test_name(self, derivatives=None):
        return f"v_{self.rule.number}" + ("" if derivatives is None else "_D" + "".join(map(str, derivatives)))

    def before(self):
        declarations = []
        if self.rank == 0 and self.integral.integral_type != "expression":
            declarations.append(L.ArrayDecl(_symbol(f"sum_{self.rule.number}"), sizes=(1,), values=np.zeros(1)))
        if self.rank == 1:
            size = max((b for b, _ in self.tensor), default=-1) + 1
            for d in sorted({d for _, d in self.tensor}):
                sizes = [1 if self.factor.constant(k) else len(self.rule.grid) for k in d]
                zero = np.zeros((size, *sizes)) if any(map(self.factor.constant, d)) else None
                declarations.append(L.ArrayDecl(_symbol(self._test_name(d)), sizes=(size, *sizes), values=zero))
            if self.rule.num_points > 1:
                for k, (tr, table, *_) in enumerate(self.reduced):
                    split = self._split(k)
                    columns = self._basis(k)[1].shape[0] if split is None else self.rule.num_points
                    zero = np.zeros(columns) if split is None else None
                    declarations.append(L.ArrayDecl(_symbol(self._sum_name(k)), sizes=(columns,), values=zero))
        return [L.Section("weighted factors of the test function", [], declarations)] if declarations else []

    def _sum_name(self, k):
        return f"v_{self.rule.number}_{k}"

    def _basis(self, k):
        """(table per point [entity, point, column], reduction [column, dof]) of a reduced block."""
        tr, table, begin, stride, row, _ = self.reduced[k]
        if row is not None:
            return table, np.eye(table.shape[2])
        basis, reduction = tensor.reduce_columns(table[0])
        return basis[None], reduction

    def _split(self, k):
        """Shared row and own entries of a reduced block (tensor.split_rows), or None."""
        basis, _ = self._basis(k)
        if self.reduced[k][4] is not None or basis.shape[1] < 3:
            return None
        return tensor.split_rows(basis[0])

    def inside(self):
        schedule = self.writer.schedule
        if self.integral.integral_type == "expression":
            components = self.integral.shape[1]
            return [
                L.Assign(A[L.MultiIndex([L.Symbol("iq", INT), L.LiteralInt(c)], [0, components])], e)
                for (_, c), e in ((t, schedule.expression(v)) for t, v in self.targets)
            ]
        if self.rank == 0:
            return [L.AssignAdd(_symbol(f"sum_{self.rule.number}")[0], schedule.expression(v)) for _, v in self.targets]
        if self.rank == 1:
            return self._inside_vector(schedule)
        return self._inside_matrix(schedule)

    def _inside_vector(self, schedule):
        statements = []
        q = self.rule.indices(self.writer.tdim)
        for (begin, d), value in sorted(self.tensor.items()):
            access = _symbol(self._test_name(d))[begin]
            constant = [self.factor.constant(k) for k in d]
            for index, c in zip(q, constant):
                access = access[0 if c else index]
            statements.append((L.AssignAdd if any(constant) else L.Assign)(access, schedule.expression(value)))
        for k, (tr, table, begin, stride, row, value) in enumerate(self.reduced):
            if self.rule.num_points == 1:
                statements.append(L.VariableDecl(_symbol(f"f_{self.rule.number}_{k}"), schedule.expression(value)))
                continue
            if self._split(k) is not None:  # kept by point, combined after the loop
                at = _symbol(self._sum_name(k))[self.rule.flat(self.writer.tdim)]
                statements.append(L.Assign(at, schedule.expression(value)))
                continue
            basis, _ = self._basis(k)
            if basis.shape[1] > 1 or row is not None or not np.all(np.isin(basis, (1.0, -1.0))):
                name = self.writer._table(f"{tr.name}_test", basis)
                f = _symbol(f"f_{k}")
                statements.append(L.VariableDecl(f, schedule.expression(value)))
                entity = self.writer.row(row)
                point = L.LiteralInt(0) if basis.shape[1] == 1 else self.rule.flat(self.writer.tdim)
                for column in range(basis.shape[2]):
                    entry = L.Symbol(name, REAL)[entity][point][column]
                    statements.append(L.AssignAdd(_symbol(self._sum_name(k))[column], L.Mul(entry, f)))
            else:
                for column in range(basis.shape[2]):
                    e = schedule.expression(value)
                    e = e if basis[0, 0, column] > 0 else L.Neg(e)
                    statements.append(L.AssignAdd(_symbol(self._sum_name(k))[column], e))
        return statements

    def after(self):
        if self.rank == 0 and self.integral.integral_type != "expression":
            return [L.Section("sum over the points", [L.AssignAdd(A[0], _symbol(f"sum_{self.rule.number}")[0])], [])]
        if self.rank != 1:
            return []
        statements = []
        if self.tensor:
            statements += self._after_tensor()
        statements += self._combine_points()
        statements += self._after_reduced()
        return [L.Section("element vector", statements, [])]

    def _after_tensor(self):
        groups = {}
        for begin in sorted({b for b, _ in self.tensor}):
            groups.setdefault(tuple(sorted(d for b, d in self.tensor if b == begin)), []).append(begin)
        statements = []
        for derivatives, begins in groups.items():
            loop = len(begins) > 1 and begins == list(range(len(begins)))
            for begin in [None] if loop else begins:
                index = L.Symbol("k", INT) if begin is None else L.LiteralInt(begin)
                body = integrate_test(
                    self.writer,
                    self.rule,
                    self.factor,
                    self._test_name(),
                    derivatives,
                    lambda node: L.Add(L.LiteralInt(self.stride * node), index),
                    index,
                    lambda dof, e: L.AssignAdd(A[dof], self._rounded(e)),
                )
                size = len(begins) if begin is None else 1
                statements.append(L.ForRange(index if begin is None else L.Symbol("once", INT), 0, size, body))
        return statements

    def _combine_points(self):
        """Columns of the blocks kept by point: shared entry times the sum, plus each point's own."""
        statements = []
        if self.rule.num_points == 1:
            return statements
        for k in range(len(self.reduced)):
            split = self._split(k)
            if split is None:
                continue
            shared, columns, own = split
            f, total = _symbol(self._sum_name(k)), _symbol(f"{self._sum_name(k)}_all")
            statements.append(L.VariableDecl(total, combine([(1.0, f[q]) for q in range(self.rule.num_points)])))
            for column in range(len(shared)):
                pairs = [(shared[column], total)] + [(x, f[q]) for q, x in enumerate(own) if columns[q] == column]
                statements.append(L.VariableDecl(_symbol(f"{self._sum_name(k)}_c{column}"), combine(pairs)))
        return statements

    def _after_reduced(self):
        terms = {}
        for k, (tr, table, begin, stride, row, value) in enumerate(self.reduced):
            basis, reduction = self._basis(k)
            for column in range(reduction.shape[0]):
                if self.rule.num_points == 1:
                    f = _symbol(f"f_{self.rule.number}_{k}")
                    scale = float(basis[0, 0, column]) if row is None else None
                    if scale is None:
                        name = self.writer._table(f"{tr.name}_test", basis)
                        f = L.Mul(L.Symbol(name, REAL)[self.writer.row(row)][0][column], f)
                        scale = 1.0
                elif self._split(k) is not None:
                    f, scale = _symbol(f"{self._sum_name(k)}_c{column}"), 1.0
                else:
                    f, scale = _symbol(self._sum_name(k))[column], 1.0
                for dof in np.flatnonzero(reduction[column]):
                    pair = (scale * float(reduction[column, dof]), f)
                    terms.setdefault(begin + stride * int(dof), []).append(pair)
        return [L.AssignAdd(A[dof], self._rounded(combine(pairs))) for dof, pairs in sorted(terms.items())]

    def _rounded(self, value):
        """A value that is added to A. A sum with the last product of it has another rounding: the sweep, which adds to
        nothing, is to have that of `tabulate`."""
        return Rounded(value) if self.integral.has_sweep and not self.integral.history else value

    # -- rank 2 -------------------------------------------------------------------------------------------------------
    def _inside_matrix(self, schedule):
        """A[i, j] += sum over derivative pairs; the test table is applied first, once per test function."""
        num_columns = self.integral.shape[1]
        i, j = L.Symbol("i", INT), L.Symbol("j", INT)
        declarations, groups = [], {}
        for k, ((block, _), value) in enumerate(self.targets):
            f = _symbol(f"f_{self.rule.number}_{k}")
            declarations.append(L.VariableDecl(f, schedule.expression(value)))
            test, trial = (m.tabledata for m in block.ma_data)
            rows = (int(test.offset), int(test.block_size), np.asarray(test.values).shape[3])
            columns = (int(trial.offset), int(trial.block_size), np.asarray(trial.values).shape[3])
            both = [(self._argument(block, number), tr) for number, tr in enumerate((test, trial))]
            groups.setdefault(rows, {}).setdefault(columns, {}).setdefault(trial.name, []).append((*both, f))
        statements = []
        for rows, by_columns in sorted(groups.items()):
            body, temporary = [], 0
            for columns, by_trial in sorted(by_columns.items()):
                products = []
                for _, entries in sorted(by_trial.items()):
                    t = _symbol(f"r{temporary}")
                    temporary += 1
                    total = None
                    for test, _, f in entries:
                        term = self._times_table(*test, i, f)
                        total = term if total is None else L.Add(total, term)
                    body.append(L.VariableDecl(t, total))
                    products.append(self._times_table(*entries[0][1], j, t))
                total = products[0]
                for p in products[1:]:
                    total = L.Add(total, p)
                row = L.Add(L.Mul(L.LiteralInt(rows[1]), i), L.LiteralInt(rows[0]))
                column = L.Add(L.Mul(L.LiteralInt(columns[1]), j), L.LiteralInt(columns[0]))
                index = L.Add(L.Mul(L.LiteralInt(num_columns), row), column)
                body.append(L.ForRange(j, 0, columns[2], [L.AssignAdd(A[index], total)]))
            statements.append(L.ForRange(i, 0, rows[2], body))
        return declarations + statements

    def _times_table(self, mt, tr, dof, factor):
        if tr.ttype == "ones":
            return factor
        table, row = self.writer.rows(mt, tr)
        name = self.writer._table(f"{tr.name}_arg", table)
        point = L.LiteralInt(0) if tr.is_piecewise else self.rule.flat(self.writer.tdim)
        return L.Mul(L.Symbol(name, REAL)[self.writer.row(row)][point][dof], factor)
