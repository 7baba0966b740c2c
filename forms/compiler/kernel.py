# SPDX-License-Identifier: MIT
"""Writes one integral as an LNodes tree: tables, values at the points, pointwise algebra, element tensor.

Signature of the kernel (see kernels/Kernel.h for the layout of the arrays when T has several lanes):
    void kernel(T* A, const T* w, const double* c, const T* coordinate_dofs, int entity)

Kernels of interior facets read both cells, "+" first. Each of them sees the facet as one of its own, by a number and a
permutation of the points, which `decoded` finds in `entity`.
"""

import basix
import ffcx.codegeneration.lnodes as L
import numpy as np
import ufl

from . import algebra as alg
from . import geometry, tensor
from .arguments import ElementTensor
from .collect import collect
from .integrands import integrands
from .local import LocalPart
from .schedule import Schedule
from .sumfactorisation import evaluate_field
from .words import in_words

INT, REAL, SCALAR = L.DataType.INT, L.DataType.REAL, L.DataType.SCALAR
A, W, C = L.Symbol("A", SCALAR), L.Symbol("w", SCALAR), L.Symbol("c", REAL)
X = L.Symbol("coordinate_dofs", SCALAR)
AXES = ("q0", "q1", "q2")


def _int(name):
    return L.Symbol(name, INT)


def decoded(integral):
    """C++ lines that decode `entity` for both sides of an interior facet: facet_S, permutation_S, and row_S, the row of
    a table that has one for each of both."""
    lines = []
    if integral.integral_type == "interior_facet":
        num_facets = _num_facets(integral.coordinate_element.cell_type)
        for side in range(2):
            facet, permutation = f"facet_{side}", f"permutation_{side}"
            lines.append(f"[[maybe_unused]] const int {facet} = (entity >> {4 * side}) & 15;")
            lines.append(f"[[maybe_unused]] const int {permutation} = (entity >> {8 + 4 * side}) & 15;")
            lines.append(f"[[maybe_unused]] const int row_{side} = {num_facets} * {permutation} + {facet};")
    return lines


def _num_facets(cell):
    return len(basix.topology(cell)[-2])


class Rule:
    """State of one quadrature rule (or set of evaluation points) while its kernel code is collected."""

    def __init__(self, number, rule, data, tensor_points):
        self.number, self.data = number, data
        self.points, self.weights = rule.points, rule.weights
        self.num_points = len(rule.points)
        self.grid = tensor_points  # 1D points of a product rule, or None
        self.fields = {}  # field -> {(component, derivatives)} evaluated by sum factorisation
        self.tests = {}  # (dof offset, derivatives) -> value, integrated by sum factorisation

    def indices(self, dim):
        if self.grid is None:
            return [_int("iq")]
        return [_int(n) if self.num_points > 1 else L.LiteralInt(0) for n in AXES[:dim]]

    def flat(self, dim):
        """Point number as an index expression."""
        if self.grid is None or self.num_points == 1:
            return _int("iq")
        return L.MultiIndex(self.indices(dim), [len(self.grid)] * dim)


class KernelWriter:
    """Generates the body of one kernel.

    Args:
        integral: frontend.Integral.
        take_out_reciprocals: see algebra.Algebra.
        collected: how often sums are multiplied out and collected (collect.py); if they are, products share pairs of
            factors.
    """

    def __init__(self, integral, take_out_reciprocals=True, collected=0):
        self.integral, self.ir = integral, integral.ir
        self.cell = integral.coordinate_element.cell_type
        self.tdim = len(basix.topology(self.cell)) - 1
        self.algebra = alg.Algebra(take_out_reciprocals)
        self.collected = collected
        self.tables = {}  # name -> array, in order of use
        self.shared_names = {}  # (shape, content) of a table -> name
        self.arrays = {}  # name -> values of the cell by point (_shared_row)
        self.rules = []
        self.schedule = Schedule(self._access, share_pairs=collected > 0 or integral.law is not None)
        self.rule = None
        self.local = LocalPart(self) if integral.law else None
        self.iterating = False  # does the local unknown stand for the iterate, or for the solution?

    # -- terminals: what the algebra's symbols mean ------------------------------------------------------------------
    def _access(self, key):
        """LNodes expression that reads a symbol of the algebra."""
        kind = key[0]
        if kind == "dof":
            _, field, index = key
            array, first = self._array_of(field)
            return array[index - first]
        if kind == "constant":
            return C[key[1]]
        if kind == "quadrature":
            _, field, rule, begin, stride = key
            array, first = self._array_of(field)
            return array[L.as_lexpr(begin - first) + L.as_lexpr(stride) * self.rules[rule].flat(self.tdim)]
        if kind == "table":
            _, name, rule, row, column = key
            point = L.LiteralInt(0) if rule is None else self.rules[rule].flat(self.tdim)
            return L.Symbol(name, REAL)[self.row(row)][point][column]
        if kind == "weight":
            rule = self.rules[key[1]]
            return L.Symbol(f"weights_{rule.number}", REAL)[rule.flat(self.tdim)]
        if kind == "facet":
            _, name, facet, *component = key
            access = L.Symbol(name, REAL)[_int(facet)]
            for i in component:
                access = access[i]
            return access
        if kind == "field":
            _, rule, field, component, derivatives = key
            access = L.Symbol(self.field_name(rule, field, derivatives), SCALAR)[component]
            factor = self._factors(field, self.rules[rule])
            for q, d in zip(self.rules[rule].indices(self.tdim), derivatives):
                access = access[0 if factor.constant(d) else q]
            return access
        if kind in ("iterate", "solution", "average"):
            return self.local.access(key)
        if kind == "array":
            return L.Symbol(key[1], SCALAR)[self.rules[key[2]].flat(self.tdim)]
        raise RuntimeError(f"unknown symbol {key}")

    def _array_of(self, field):
        """Array that the values of a field are read from, and the number in w of its first entry."""
        if field == "x":
            return X, 0
        number = int(field[1:])
        if not self.integral.is_in_place or number not in self.integral.history:
            return W, 0
        name = f"history_{self.integral.history[number]}"
        return L.Symbol(name, SCALAR), self.integral.coefficients[number].offset

    @staticmethod
    def row(name):
        """First index of a table: the integer of a name, or None where the table is the same for all facets."""
        return L.LiteralInt(0) if name is None else _int(name)

    def rows(self, mt, tr):
        """FFCx's table of a modified terminal by row, point and degree of freedom, and the name of the row's number;
        None: there is one row."""
        values = np.asarray(tr.values)
        if len(values) > 1:  # points in the order in which the cell sees them
            num_facets = _num_facets(self.cell)
            values = np.broadcast_to(values, (len(values), num_facets, *values.shape[2:]))
            return values.reshape(-1, *values.shape[2:]), f"row_{self._side(mt)}"
        return values[0], None if tr.is_uniform or values.shape[1] == 1 else self._facet(mt)

    def _side(self, mt):
        """Number of the side of an interior facet."""
        return 1 if mt.restriction == "-" else 0

    def _facet(self, mt):
        """Name of the number of the facet in the cell."""
        return f"facet_{self._side(mt)}" if self.integral.num_cells > 1 else "entity"

    @staticmethod
    def field_name(rule, field, derivatives):
        return f"{field}_D{''.join(map(str, derivatives))}_{rule}"

    def _element_of(self, field):
        if field == "x":
            return self.integral.coordinate_element
        return self.integral.coefficients[int(field[1:])].element

    def _factors(self, field, rule):
        return tensor.factors(self._element_of(field), rule.points) if rule.grid is not None else None

    def _terminal(self, mt, tr):
        t = mt.terminal
        if (mt.restriction and self.integral.num_cells == 1) or mt.averaged or mt.global_derivatives:
            raise ValueError(f"{self.integral.name}: {in_words(mt.expr)} is not supported in kernels")
        if isinstance(t, ufl.Constant):
            offset = self.integral.numbering.constants[t]
            return self.algebra.symbol(("constant", int(offset + mt.flat_component)), alg.CONSTANT)
        if isinstance(t, (ufl.geometry.Jacobian, ufl.geometry.SpatialCoordinate)):
            counts = [0] * self.tdim
            for d in mt.local_derivatives + (mt.component[1:] if isinstance(t, ufl.geometry.Jacobian) else ()):
                counts[d] += 1
            first = self._first_coordinate(mt) + mt.component[0]
            return self._evaluate("x", first, mt, tr, tuple(counts), lambda i: 3 * i + first)
        if isinstance(t, ufl.Coefficient) and t == self.integral.numbering.unknown:
            return self.local.unknown(int(tr.offset), self.iterating)
        if isinstance(t, ufl.Coefficient) and t in self.integral.numbering.averages:
            return self.local.average(self.integral.numbering.averages[t], int(tr.offset))
        if isinstance(t, ufl.Coefficient):
            k, offset = self.integral.numbering.coefficients[t]
            counts = [0] * self.tdim
            for d in mt.local_derivatives:
                counts[d] += 1
            begin, stride = int(tr.offset), int(tr.block_size)
            return self._evaluate(f"w{k}", begin, mt, tr, tuple(counts), lambda i: offset + begin + stride * i)
        if isinstance(t, ufl.geometry.ReferenceNormal):
            return self._facet_table("reference_normals", basix.cell.facet_outward_normals(self.cell), mt, mt.component)
        if isinstance(t, ufl.geometry.CellFacetJacobian):
            return self._facet_table("facet_jacobians", basix.cell.facet_jacobians(self.cell), mt, mt.component)
        if isinstance(t, ufl.geometry.FacetOrientation):
            return self._facet_table("facet_orientations", np.array(basix.cell.facet_orientations(self.cell)), mt, ())
        if isinstance(t, ufl.geometry.CellOrientation):
            # Of cells in a space of more dimensions. The weight of a point has the absolute value of the determinant;
            # the side of a normal is that of the numbering of the vertices, as in FFCx.
            return self.algebra.number(1.0)
        if isinstance(t, ufl.geometry.ReferenceCellVolume):
            return self.algebra.number(basix.cell.volume(self.cell))
        if isinstance(t, ufl.geometry.ReferenceFacetVolume):
            return self.algebra.number(basix.cell.facet_reference_volumes(self.cell)[0])
        if isinstance(t, ufl.geometry.CellVertices):
            vertex, component = map(int, mt.component)
            return self._node(geometry.vertex_dofs(self.integral.coordinate_element)[vertex], mt, component)
        if isinstance(t, ufl.geometry.CellEdgeVectors):
            edge, component = map(int, mt.component)
            first, second = geometry.cell_edges(self.cell)[edge]
            return self._difference({first: 1.0, second: -1.0}, mt, component)
        if isinstance(t, ufl.geometry.FacetEdgeVectors):
            return self._facet_edge(mt, *map(int, mt.component))
        raise ValueError(f"{self.integral.name}: {in_words(t)} is not supported in kernels")

    def _first_coordinate(self, mt):
        """First entry of the coordinates of the cell that is meant."""
        element = self.integral.coordinate_element
        return 3 * self._side(mt) * (element.dim // element.block_size)

    def _node(self, number, mt, component):
        """Coordinate of a node of the cell."""
        return self._dof("x", self._first_coordinate(mt) + 3 * int(number) + component)

    def _difference(self, factors, mt, component):
        """Sum of factor times coordinate over vertices."""
        nodes = geometry.vertex_dofs(self.integral.coordinate_element)
        terms = [(f, self._node(nodes[vertex], mt, component)[1]) for vertex, f in factors.items()]
        return self.algebra.add(*terms)

    def _facet_edge(self, mt, edge, component):
        """Component of the vector of an edge of the facet."""
        values, algebra = geometry.facet_edge_differences(self.cell), self.algebra
        nodes = geometry.vertex_dofs(self.integral.coordinate_element)
        terms = []
        for vertex in range(values.shape[2]):
            if np.any(values[:, edge, vertex]):
                factor = self._facet_table("facet_edges", values, mt, (edge, vertex))
                terms.append(algebra.multiply(factor, self._node(nodes[vertex], mt, component)))
        return algebra.add(*terms)

    def _facet_table(self, name, values, mt, component):
        self.tables[name] = np.asarray(values, dtype=float)
        return self.algebra.symbol(("facet", name, self._facet(mt), *map(int, component)), alg.CONSTANT)

    def _dof(self, field, index):
        return self.algebra.symbol(("dof", field, index), alg.CELL)

    def _evaluate(self, field, component, mt, tr, derivatives, dof):
        """Value of a field at the points: sum over its dofs of table times dof."""
        rule, algebra = self.rule, self.algebra
        table, row = self.rows(mt, tr)
        table_name = self._shared_name(tr.name, table)
        if tr.ttype == "ones" and table.shape[2] == 1:
            return self._dof(field, dof(0))
        uniform, piecewise = row is None, tr.is_piecewise
        factor = self._factors(field, rule)
        product = uniform and factor is not None and tensor.matches(factor, derivatives, table[0])
        if uniform and piecewise and not (product and rule.num_points == 1):
            return algebra.add(*((c, self._dof(field, dof(i))[1]) for i, c in enumerate(table[0, 0]) if c))
        if uniform and table.shape[1] == table.shape[2] and np.array_equal(table[0], np.eye(table.shape[1])):
            return algebra.symbol(("quadrature", field, rule.number, dof(0), dof(1) - dof(0)), alg.POINT)
        if product:
            rule.fields.setdefault(field, {})[(component, derivatives)] = dof
            value = algebra.symbol(("field", rule.number, field, component, derivatives), alg.POINT)
            return algebra.multiply(algebra.number(factor.unit(derivatives)), value)
        if uniform:
            basis, reduction = tensor.reduce_columns(table[0])
            combined = [
                algebra.add(*((s, self._dof(field, dof(i))[1]) for i, s in enumerate(row) if s)) for row in reduction
            ]
            split = tensor.split_rows(basis)
            if split is not None:
                return self._shared_row(f"{field}_{component}_{table_name}", split, combined)
            name = self._table(table_name, basis[None])
        else:
            name = self._table(table_name, table)
            combined = [self._dof(field, dof(i)) for i in range(table.shape[2])]
        at = None if piecewise else rule.number
        level = alg.CELL if piecewise else alg.POINT
        terms = []
        for column, value in enumerate(combined):
            entry = algebra.symbol(("table", name, at, row, column), level)
            terms.append(algebra.multiply(entry, value))
        return algebra.add(*terms)

    def _shared_row(self, name, split, combined):
        """Shared part, the same at all points, plus one product per point (tensor.split_rows)."""
        shared, columns, own = split
        algebra, rule = self.algebra, self.rule
        if name not in self.arrays:
            signs = np.sign(own)  # into the values, so that one number is left where the rule is symmetric
            self.arrays[name] = [algebra.multiply(algebra.number(s), combined[c]) for s, c in zip(signs, columns)]
        own = np.abs(own)
        base = algebra.add(*(algebra.multiply(algebra.number(x), v) for x, v in zip(shared, combined)))
        value = algebra.symbol(("array", name, rule.number), alg.POINT)
        if np.ptp(own) < tensor.TOLERANCE:
            factor = algebra.number(own[0])
        else:
            table = self._table(f"{name}_own", own[None, :, None])
            factor = algebra.symbol(("table", table, rule.number, None, 0), alg.POINT)
        return algebra.add(base, algebra.multiply(factor, value))

    def _shared_name(self, name, table):
        """Name of a table of FFCx. With a point law two representations meet: their names for one table may differ, and
        one name may stand for two tables."""
        if self.local is None:
            return name
        taken = self.shared_names.values()
        return self.shared_names.setdefault(
            (table.shape, table.tobytes()), name if name not in taken else f"{name}_{len(taken)}"
        )

    def _table(self, name, values):
        self.tables[name] = np.asarray(values)
        return name

    # -- assembly of the tree ---------------------------------------------------------------------------------------
    def write(self):
        """The kernel body as an LNodes StatementList."""
        self.targets = []
        for number, (rule, data) in enumerate(integrands(self.ir)):
            tensor_cell = self.integral.integral_type == "cell" and self.cell.name in ("quadrilateral", "hexahedron")
            grid = tensor.grid_of_points(rule.points) if tensor_cell and self.integral.rank < 2 else None
            self.rule = Rule(number, rule, data, grid)
            self.rules.append(self.rule)
            values = alg.GraphReader(self.algebra, data["factorization"], self._terminal).read()
            self.targets.append(self._targets(values))
            if self.local:
                self.local.read(self.rule, self._weight(self.rule))
        if self.collected:
            self._collect()
        wanted = [v for per_rule in self.targets for _, v in per_rule]
        if self.local:
            wanted += self.local.wanted()
        by_point = [v for values in self.arrays.values() for v in values]
        self.schedule.prepare(wanted + by_point)
        body = [L.Section("values that depend on constants only", self.schedule.declare(wanted, alg.CONSTANT), [])]
        cell_values = self.schedule.declare(wanted + by_point, alg.CELL)
        body.append(L.Section("values that depend on the cell only", cell_values, []))
        body.append(self._array_section())
        for rule, targets in zip(self.rules, self.targets):
            self.rule = rule
            body += self._rule_code(rule, targets)
        if self.local:
            body += self.local.after()
        used = self._used_tables(body)
        tables = [L.ArrayDecl(L.Symbol(n, REAL), values=self.tables[n], const=True) for n in used]
        sections = [s for s in body if not isinstance(s, L.Section) or s.statements or s.declarations]
        return L.StatementList(([L.Section("tables: [entity][point][dof]", [], tables)] if tables else []) + sections)

    def _collect(self):
        values = iter(collect(self.algebra, [v for per_rule in self.targets for _, v in per_rule], self.collected))
        self.targets = [[(what, next(values)) for what, _ in per_rule] for per_rule in self.targets]

    def _array_section(self):
        declarations = [L.ArrayDecl(L.Symbol(n, SCALAR), sizes=(len(v),)) for n, v in self.arrays.items()]
        statements = [
            L.Assign(L.Symbol(n, SCALAR)[q], self.schedule.expression(v))
            for n, values in self.arrays.items()
            for q, v in enumerate(values)
        ]
        return L.Section("values of the cell by point", statements, declarations)

    def _used_tables(self, body):
        """Names of the tables the code reads, in order: reduced tables replace some that were collected first."""
        read = set().union(*map(_arrays_read, body)) if body else set()
        return [n for n in self.tables if n in read]

    def _weight(self, rule):
        if self.integral.integral_type == "expression":
            return self.algebra.number(1.0)
        if np.ptp(rule.weights) < 1e-15 * np.max(np.abs(rule.weights)):
            return self.algebra.number(rule.weights[0])
        self.tables[f"weights_{rule.number}"] = np.asarray(rule.weights)
        return self.algebra.symbol(("weight", rule.number), alg.POINT)

    def _targets(self, values):
        """Pairs (block, weighted factor): what is multiplied with the tables of test and trial functions."""
        rule = self.rule
        weight = self._weight(rule)
        targets = []
        for _, contributions in sorted(rule.data["block_contributions"].items()):
            for block in contributions:
                for index, component in block.factor_indices_comp_indices:
                    factor = self.algebra.multiply(self.algebra.number(self._unit(block)), values[index])
                    targets.append(((block, component), self.algebra.multiply(weight, factor)))
        return targets

    def _unit(self, block):
        """Factor that the sum factorisation of a block's test function leaves out (tensor.Factors.unit)."""
        rule = self.rule
        if self.integral.rank != 1 or rule.grid is None or rule.num_points > 1:
            return 1.0
        factor = tensor.factors(self.integral.argument_elements[0], rule.points)
        argument = rule.data["modified_arguments"][block.ma_data[0].ma_index]
        counts = [0] * self.tdim
        for d in argument.local_derivatives:
            counts[d] += 1
        table, _ = self.rows(argument, block.ma_data[0].tabledata)
        return factor.unit(counts) if factor is not None and tensor.matches(factor, tuple(counts), table[0]) else 1.0

    def _rule_code(self, rule, targets):
        element_tensor = ElementTensor(self, rule, targets)
        factors = [v for _, v in targets]
        before = [evaluate_field(self, rule, field, needed) for field, needed in sorted(rule.fields.items())]
        if self.local:
            before += self.local.before(factors)
        before += element_tensor.before()
        inner = self.local.inside(factors) if self.local else self.schedule.declare(factors, alg.POINT)
        inner += element_tensor.inside() + (self.local.behind() if self.local else [])
        loop = self.point_loops(rule, inner)
        return before + [L.Section(f"points of rule {rule.number}", loop, [])] + element_tensor.after()

    def point_loops(self, rule, inner, always=False):
        """Loops over the points of a rule; with `always` one for a single point, too."""
        if (rule.num_points == 1 or not inner) and not always:
            # One point needs no loop; its index is declared once, however many such rules there are.
            first = not any(r.num_points == 1 for r in self.rules[: rule.number])
            index = [L.VariableDecl(_int("iq"), L.LiteralInt(0))] if first else []
            return index + inner if rule.num_points == 1 else []
        grid = rule.grid is not None and rule.num_points > 1
        sizes = [len(rule.grid)] * self.tdim if grid else [rule.num_points]
        loop = inner
        for index, size in reversed(list(zip(rule.indices(self.tdim) if grid else [_int("iq")], sizes))):
            loop = [L.ForRange(index, 0, size, loop)]
        return loop


def _arrays_read(node):
    """Names of the arrays that an LNodes tree accesses."""
    if isinstance(node, (list, tuple)):
        return set().union(*map(_arrays_read, node))
    if not isinstance(node, L.LNode):
        return set()
    own = {node.array.name} if isinstance(node, L.ArrayAccess) else set()
    return own.union(*map(_arrays_read, vars(node).values()))
