# SPDX-License-Identifier: MIT
"""First stage: UFL form or expression -> FFCx's intermediate representation, with explicit options.

FFCx's own command line reads private option files of the machine; here every option is written down, so that a kernel
depends on nothing but the form.
"""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import ufl
from ffcx.analysis import analyze_ufl_objects
from ffcx.ir.representation import compute_ir
from ufl.algorithms import extract_coefficients
from ufl.algorithms.map_integrands import map_integrand_dags
from ufl.corealg.map_dag import map_expr_dag
from ufl.corealg.multifunction import MultiFunction

from ..inelastic import UNKNOWN
from ..point_law import PointLaw, flatten
from .averages import Averages, has_averages, lowered
from .geometry import check_sizes, with_sizes
from .integrands import integrands
from .standard_mesh import StandardMesh
from .stress_form import by_test_gradient

# Tables are compared and rounded at round-off level (FFCx's defaults, 1e-6, would round shape functions as well).
OPTIONS = {
    "scalar_type": "float64",
    "sum_factorization": False,
    "table_rtol": 1e-13,
    "table_atol": 1e-14,
    "epsilon": 1e-14,
    "verbosity": 30,
    "part": "full",  # asked for since 0.10
}


@dataclass
class Coefficient:
    """A coefficient of a form as a kernel sees it."""

    name: str
    kind: str  # "node" (Lagrange), "cell" (one value per cell), "quadrature" (values at the points of a rule), "other"
    element: object
    degree: int
    block_size: int
    num_dofs: int  # per cell, blocked
    offset: int  # of its dofs inside the packed array w
    position: int  # in form.coefficients()


@dataclass
class Constant:
    """A constant of a form: its name and where its entries stand in the packed array c."""

    name: str
    size: int
    offset: int


@dataclass
class Numbering:
    """What UFL's coefficients and constants are in a kernel. Several representations meet in one kernel, each with
    coefficients of its own: they are counted once.

    Attributes:
        coefficients: number and first entry in w of each coefficient.
        constants: first entry in c of each constant.
        unknown: coefficient that stands for the solution of the local equations, or None.
        averages: number of the average over the cell that a coefficient stands for.
    """

    coefficients: dict
    constants: dict
    unknown: object = None
    averages: dict = field(default_factory=dict)


@dataclass
class Output:
    """Values at the points that a kernel writes behind the element tensor.

    Attributes:
        name: name of the output.
        num_components: values at a point.
        history: number of the kernel's coefficient that reads the committed values, -1: none.
    """

    name: str
    num_components: int
    history: int


@dataclass
class LocalExpressions:
    """What a kernel evaluates at the points beside the form's integrand, in FFCx's representation: a point law and
    averages over the cell.

    Attributes:
        graph: FFCx's data of all parts in one vector, at the points of the form's rule.
        parts: first component and number of components of each part: those of PointLaw.parts, "average NUMBER", and
            "volume", the absolute value of det J.
        outputs: what is written at the points.
        sums: names of the values that are integrated over a cell.
        num_unknowns: unknowns of the local equations at a point, 0: a law in closed form.
        averages: Average objects, by number.
        solved_in: number of the loop over the points that solves the local equations.
        num_loops: number of loops, the last of which computes the element tensor.
    """

    graph: dict
    parts: dict
    outputs: list
    sums: list
    num_unknowns: int
    averages: list
    solved_in: int
    num_loops: int


@dataclass(frozen=True)
class SweptArrays:
    """Arrays over the nodes of a cell, as NodalArrays of kernels/sweep.h.

    Attributes:
        num_nodes: nodes of a cell.
        num_positions: how many of them, the first, carry its position.
        components: of the coefficient that has as many as positions.
        offset: its first entry in w.
        scalar_offset: first entry in w of the scalar coefficient, -1: there is none.
        test_components: of the test function.
        num_constants: values of constants.
    """

    num_nodes: int
    num_positions: int
    components: int
    offset: int
    scalar_offset: int
    test_components: int
    num_constants: int


@dataclass
class Integral:
    """One kernel to write: FFCx's representation with the facts about it that FFCx does not keep together."""

    name: str
    integral_type: str  # "cell", "exterior_facet", "interior_facet", "expression"
    subdomains: tuple
    ir: object
    rank: int
    shape: tuple  # of the element tensor (for an expression: points, components)
    coefficients: list
    constants: list
    argument_elements: tuple
    coordinate_element: object
    signature: str
    numbering: Numbering
    points: np.ndarray | None = None
    entity_type: str = "cell"
    hypothesis: str = ""
    law: LocalExpressions | None = None

    @property
    def num_cells(self) -> int:
        """Cells that the kernel reads: both sides of an interior facet, "+" first."""
        return 2 if self.integral_type == "interior_facet" else 1

    @property
    def swept_arrays(self):
        """Where the function that gathers and scatters, too (kernels/sweep.h), finds its arrays; None: the kernel has
        no such function. Those of cells with linear geometry have one, of degree 1, and of simplices of degree 2, with
        one coefficient that has as many components as positions, at most one scalar on the same nodes, and the test
        function on them: the calls around them, and the arrays that calls pass, take as long as the kernel of a linear
        tetrahedron, a third of a hexahedron with one point, and an eighth of the step of a quadratic tetrahedron. With
        a point law such a kernel reads and writes internal variables in place; a law may also have sums alone."""
        if self.integral_type != "cell" or self.rank != 1 or not (self.history or self.law_has_sums_alone):
            return None
        positions, test = self.coordinate_element, self.argument_elements[0]
        simplices, boxes = ("triangle", "tetrahedron"), ("quadrilateral", "hexahedron")
        cell = positions.cell_type.name
        gathered = [c for k, c in enumerate(self.coefficients) if k not in self.history]
        vectors = [c for c in gathered if c.element.block_size == positions.block_size]
        if cell not in simplices + boxes or len(vectors) != 1 or positions.embedded_superdegree != 1:
            return None
        element = vectors[0].element
        scalar, others = element.sub_elements[0], [c for c in gathered if c is not vectors[0]]
        if cell not in {1: simplices + boxes, 2: simplices}.get(element.embedded_superdegree, ()):
            return None
        if len(others) > 1 or any(c.element != scalar for c in others) or test not in (element, scalar):
            return None
        return SweptArrays(
            num_nodes=element.dim // element.block_size,
            num_positions=positions.dim // positions.block_size,
            components=element.block_size,
            offset=vectors[0].offset,
            scalar_offset=others[0].offset if others else -1,
            test_components=test.block_size,
            num_constants=sum(c.size for c in self.constants),
        )

    @property
    def has_sweep(self) -> bool:
        """Has the kernel such a function?"""
        return self.swept_arrays is not None

    @property
    def history(self) -> dict[int, int]:
        """Number of the output that each coefficient of internal variables is read from, by the coefficient's number;
        empty where the kernel writes other values at the points than these and the solution of its equations."""
        outputs = self.law.outputs if self.law else []
        if any(o.history < 0 and o.name != UNKNOWN for o in outputs):
            return {}
        return {o.history: number for number, o in enumerate(outputs) if o.history >= 0}

    @property
    def law_has_sums_alone(self) -> bool:
        """Is there nothing beside the element tensor but sums over the cells, or nothing at all?"""
        return self.law is None or not (self.law.outputs or self.law.num_unknowns or self.law.averages)

    @property
    def is_in_place(self) -> bool:
        """May the kernel overwrite the internal variables that it reads?"""
        return bool(self.history) and self.has_sweep

    @property
    def num_points(self):
        """Points at which outputs are written."""
        return len(integrands(self.ir)[0][0].points) if self.law else 0

    @property
    def points_of_rules(self) -> int:
        """Points of all quadrature rules."""
        return sum(len(rule.points) for rule, _ in integrands(self.ir))

    @property
    def num_unknowns(self):
        """Local unknowns at a point."""
        return self.law.num_unknowns if self.law else 0

    @property
    def output_offsets(self):
        """First entry of each output in A, and the first entry behind them."""
        sizes = [self.num_points * o.num_components for o in self.law.outputs] if self.law else []
        return [int(n) for n in np.cumsum([np.prod(self.shape, dtype=int), *sizes])]

    @property
    def sum_offset(self):
        """First entry of the sums in A."""
        return self.output_offsets[-1]

    @property
    def report_offset(self):
        """First entry in A of the report of points that are not solved."""
        return self.sum_offset + (len(self.law.sums) if self.law else 0)

    @property
    def size_A(self):
        """Entries of A: element tensor, outputs, sums, and for local equations the report."""
        return self.report_offset + (3 + self.num_unknowns if self.num_unknowns else 0)


def _kind(element):
    family = getattr(element, "family_name", "")
    if type(element).__name__ == "_QuadratureElement" or getattr(element, "has_custom_quadrature", False):
        return "quadrature"
    sub = element.sub_elements[0] if element.block_size > 1 else element
    if getattr(sub, "has_custom_quadrature", False):
        return "quadrature"
    if family == "P" and element.embedded_superdegree == 0:
        return "cell"
    if family == "P" and not element.discontinuous:
        return "node"
    return "other"


def _coefficient(name, element, offset, position):
    return Coefficient(
        name=name,
        kind=_kind(element),
        element=element,
        degree=int(element.embedded_superdegree),
        block_size=int(element.block_size),
        num_dofs=int(element.dim),
        offset=int(offset),
        position=int(position),
    )


def check_names(objects, given, history=()):
    """Names of coefficients and constants: those given, w0, w1, ... for the others. ValueError where two are the
    same; coefficients of `history` may share a name, which laws of several materials give them."""
    names = [given.get(id(o)) or given.get(o) or f"w{i}" for i, o in enumerate(objects)]
    inner = {n for o, n in zip(objects, names) if o in history}
    others = [n for o, n in zip(objects, names) if o not in history]
    if len(set(others)) != len(others) or inner & set(others):
        twice = sorted({n for n in others if others.count(n) > 1} | (inner & set(others)))
        raise ValueError(f"the form has two coefficients or constants of one name, {twice}: give each its own")
    return names


class _Renumber(MultiFunction):
    """Constants replaced; parents are rebuilt, so that sums and products order their operands anew."""

    expr = MultiFunction.reuse_if_untouched

    def __init__(self, constants):
        super().__init__()
        self.constants = constants

    def constant(self, o):
        return self.constants[o]


def laws_of(law):
    """Dict from subdomain (None: all cells) to its PointLaw; of one PointLaw, a mapping by cell tag, or None."""
    if law is None:
        return {}
    laws = dict(law) if isinstance(law, Mapping) else {None: law}
    for tag, one in laws.items():
        if not isinstance(one, PointLaw):
            raise TypeError(f"law of subdomain {tag!r} must be a PointLaw, found {type(one).__name__}")
    return laws


def history_of(law):
    """Names of the history's coefficients, by coefficient. ValueError where one has two names or is an unknown."""
    names, laws = {}, laws_of(law).values()
    unknowns = {one.unknown for one in laws}
    for one in laws:
        for name, coefficient in one.history.items():
            if names.setdefault(coefficient, name) != name or coefficient in unknowns:
                raise ValueError(f"the coefficient of history {name!r} has another meaning in another law of the form")
    return names


def objects_of(form, law=None):
    """Coefficients and constants that the kernels of a form read, in the order in which they are counted: those of the
    form, and with a law those of its expressions, too, without the local unknowns."""
    laws = laws_of(law).values()
    if not laws:
        return list(form.coefficients()), list(form.constants())
    coefficients = set(form.coefficients()).union(*(one.coefficients() for one in laws))
    coefficients -= {one.unknown for one in laws}
    constants = set(form.constants()).union(*(one.constants() for one in laws))
    return sorted(coefficients, key=lambda c: c.count()), sorted(constants, key=lambda c: c.count())


def canonical(form, law=None):
    """The form with its constants renumbered from 0, and the dict from old constants to new.

    UFL orders operands by the printed numbers of constants ("10" before "9"), and numbers count up through a process:
    without this, the same form written twice may have two signatures and two kernels.
    """
    new = _renumbered(objects_of(form, law)[1])
    return map_integrand_dags(_Renumber(new), form), new


def _renumbered(constants):
    """Dict from constants to others that are counted from 0, in the same order."""
    constants = sorted(constants, key=lambda c: c.count())
    return {c: ufl.Constant(c.ufl_domain(), c.ufl_shape, count=i) for i, c in enumerate(constants)}


def form_signature(form, law=None):
    """Signature of a form and its laws, independent of object numbers, and of where nodes are said to be placed where
    they are the same (standard_mesh.py). Names do not count but those of outputs."""
    renumbered, new = canonical(form, law)
    standard = StandardMesh(renumbered.ufl_domains())
    renumbered = standard.form(renumbered)
    if law is None:
        return renumbered.signature()
    coefficients, _ = objects_of(form, law)
    if any(ufl.domain.extract_unique_domain(c) != form.ufl_domain() for c in coefficients):
        raise ValueError("a coefficient of the point law is on another mesh than the form")
    unknowns = [one.unknown for one in laws_of(law).values() if one.unknown is not None]
    numbers = {c: i for i, c in enumerate([*coefficients, *unknowns])}
    numbering = {standard(c): i for c, i in numbers.items()} | {standard(c): i for i, c in enumerate(new.values())}
    numbering[renumbered.ufl_domain()] = 0
    text = [renumbered.signature(), repr([numbers[c] for c in form.coefficients()])]
    for tag, one in sorted(laws_of(law).items(), key=lambda item: str(item[0])):
        text.append(f"{tag} {list(one.outputs)} {[(name, numbers[c]) for name, c in one.history.items()]}")
        text.append(repr(None if one.unknown is None else numbers[one.unknown]))
        for expression in one.expressions():
            plain = map_expr_dag(standard, map_expr_dag(_Renumber(new), expression))
            text.append(ufl.algorithms.signature.compute_expression_signature(plain, numbering))
    return hashlib.sha512("\n".join(text).encode()).hexdigest()


def form_integrals(form, name, names, hypothesis="", law=None):
    """Integrals of a UFL form.

    Args:
        form: rank 0, 1 or 2 UFL form.
        name: name of the form.
        names: dict from coefficient or constant (or its id) to its name.
        hypothesis: for the kernel's description.
        law: PointLaw of all cell integrals, or a mapping from cell tags to the PointLaw of each; None: no law.

    Returns:
        list of Integral.

    Raises:
        TypeError: no form, or no law.
        ValueError: integrals over other entities, names used twice, a law that does not fit the form.
    """
    if not isinstance(form, ufl.Form):
        raise TypeError(f"{name}: expected a UFL form, found {type(form).__name__}")
    if form.empty():
        raise ValueError(f"{name}: the form is zero, there is nothing to compile")
    check_kinds(name, form)
    check_sizes(name, form)
    form = with_sizes(form)
    laws, history = laws_of(law), history_of(law)
    averaged = any(has_averages(i.integrand()) for i in form.integrals())
    averaged = averaged or any(has_averages(e) for one in laws.values() for e in one.expressions())
    all_coefficients, old_constants = objects_of(form, law)
    signature = form_signature(form, law)
    form, renumbered = canonical(form, law)
    names = dict(names) | {new: names.get(id(old)) or names.get(old) for old, new in renumbered.items()} | history
    averages, parts_of = {}, {}
    for one in [*laws.values(), None]:
        parts = one.parts() if one else {}
        parts_of[one] = {p: [map_expr_dag(_Renumber(renumbered), e) for e in group] for p, group in parts.items()}
    if averaged:
        averages = _averages(name, form, laws)
        form = _form_without_averages(name, form, laws, averages)
        for one, parts in parts_of.items():
            parts_of[one] = {p: [averages[one].replaced(e) for e in group] for p, group in parts.items()}
    form = by_test_gradient(form, lambda integral: _is_plain(integral, laws, averages))
    analysis = analyze_ufl_objects([form], np.dtype("float64"))
    ir = compute_ir(analysis, {}, "impact", dict(OPTIONS), False)
    data = analysis.form_data[0]
    if laws or averaged:
        originals = all_coefficients
    else:
        originals = [data.original_form.coefficients()[i] for i in data.original_coefficient_positions]
    constants = [renumbered[c] for c in old_constants]
    all_names = check_names([*originals, *constants], names, history)
    names_of = dict(zip([*originals, *constants], all_names))
    constant_offsets = _offsets(constants, lambda c: int(np.prod(c.ufl_shape, dtype=int)))
    result = []
    for itg, representation in zip(data.integral_data, ir.integrals):
        subdomains = tuple(-1 if s == "otherwise" else int(s) for s in itg.subdomain_id)
        own_law = _law_of_integral(name, laws, itg.integral_type, subdomains)
        own_averages = None
        if laws or averaged:
            enabled = {c for c, used in zip(data.reduced_coefficients, itg.enabled_coefficients) if used}
            _check_unknowns(name, enabled, laws.values(), own_law)
            used = enabled | set(own_law.coefficients() if own_law else ())
            if averaged and itg.integral_type == "cell":
                in_law = {c for g in parts_of[own_law].values() for e in g for c in extract_coefficients(e)}
                own_averages = averages[own_law].select(enabled | in_law)
                used |= own_averages.read()
            coefficients = [c for c in all_coefficients if c in used]
            positions = [all_coefficients.index(c) for c in coefficients]
        else:  # those that the integral reads: another material may have coefficients of its own
            read = list(itg.enabled_coefficients)
            coefficients = [c for c, used in zip(data.reduced_coefficients, read) if used]
            positions = [p for p, used in zip(data.original_coefficient_positions, read) if used]
        elements = [c.ufl_function_space().ufl_element() for c in coefficients]
        sides = 2 if itg.integral_type == "interior_facet" else 1
        offsets = _offsets(coefficients, lambda c: sides * int(c.ufl_function_space().ufl_element().dim))
        numbering = Numbering(
            {c: (k, offsets[c]) for k, c in enumerate(coefficients)},
            constant_offsets,
            own_law.unknown if own_law else None,
            own_averages.coefficients if own_averages else {},
        )
        expression = representation.expression
        result.append(
            Integral(
                name=name,
                integral_type=itg.integral_type,
                subdomains=subdomains,
                ir=expression,
                rank=representation.rank,
                shape=tuple(int(n) for n in expression.tensor_shape),
                coefficients=[
                    _coefficient(names_of[c], e, offsets[c], p) for c, e, p in zip(coefficients, elements, positions)
                ],
                constants=[
                    Constant(names_of[c], int(np.prod(c.ufl_shape, dtype=int)), constant_offsets[c]) for c in constants
                ],
                argument_elements=tuple(data.argument_elements),
                coordinate_element=itg.domain.ufl_coordinate_element(),
                signature=signature,
                numbering=numbering,
                hypothesis=hypothesis,
                law=_local_expressions(
                    name, own_law, parts_of[own_law], own_averages, representation, numbering, itg.domain
                ),
            )
        )
    return result


def check_kinds(name, form):
    """ValueError where an integral is none over cells or facets."""
    measures = {"vertex": "dP", "custom": "dC", "cutcell": "dX", "interface": "dI"}
    for integral in form.integrals():
        kind = integral.integral_type()
        if kind in ("cell", "exterior_facet", "interior_facet"):
            continue
        raise ValueError(
            f"{name}: the integral over ufl.{measures.get(kind, kind)} is not supported in kernels, which integrate "
            "over dx, ds and dS: StaticProblem and NewmarkProblem assemble such residuals as DOLFINx does"
        )


def _offsets(objects, size):
    """First entry of each object in an array that holds one after the other."""
    ends = np.cumsum([0] + [size(o) for o in objects])
    return {o: int(n) for o, n in zip(objects, ends)}


def _place(integral):
    """Type of an integral and the tags of its cells or facets, -1: all of them, or those without another."""
    tags = integral.subdomain_id()
    tags = tags if isinstance(tags, tuple) else (tags,)
    return integral.integral_type(), tuple(-1 if tag in ("everywhere", "otherwise") else int(tag) for tag in tags)


def _is_plain(integral, laws, averages):
    """Has an integral neither what a law computes at the points of its cells nor averages, which formulas of its kernel
    look for as they are written?"""
    found = [one for one in _laws_of(laws, *_place(integral)) if one is not None]
    computes = any(one.outputs or one.unknown is not None for one in found)
    return not computes and not any(one.needed([integral.integrand()]) for one in averages.values())


def _laws_of(laws, integral_type, subdomains):
    """The law of the cells of each tag, or None."""
    if integral_type != "cell":
        return [None for _ in subdomains]
    return [laws.get(None if s == -1 else s, laws.get(None)) for s in subdomains]


def _law_of_integral(name, laws, integral_type, subdomains):
    """The law of the cells of an integral, or None."""
    found = _laws_of(laws, integral_type, subdomains)
    if any(one is not found[0] for one in found):
        raise ValueError(
            f"{name}: cells of tags {subdomains} have the same integral, but different laws: give them one law"
        )
    return found[0]


def _check_unknowns(name, coefficients, laws, own):
    """ValueError if an integral has a law's unknown or history without being this law's."""
    for one in laws:
        foreign = {one.unknown, *one.history.values()} - {None}
        if own is not None:
            foreign -= {own.unknown, *own.history.values()}
        if one is not own and foreign & coefficients:
            raise ValueError(f"{name}: an integral has the unknown or history of a law of other cells")


def _averages(name, form, laws):
    """Averages of the cells of each law, and of those without one (None)."""
    for integral in form.integrals():
        if has_averages(integral.integrand()) and (integral.integral_type() != "cell" or len(form.arguments()) > 1):
            raise ValueError(
                f"{name}: cell_avg and cell_max are supported in integrals over cells, of forms of rank 0 and 1"
            )
    return {one: Averages(form.ufl_domain(), one.unknown if one else None) for one in [*laws.values(), None]}


def _form_without_averages(name, form, laws, averages):
    """A form in which coefficients stand for the averages over cells."""
    integrals = []
    for integral in form.integrals():
        integrand = integral.integrand()
        if integral.integral_type() == "cell" and has_averages(integrand):
            integrand = averages[_law_of_integral(name, laws, *_place(integral))].of_integrand(integrand)
        integrals.append(integral.reconstruct(integrand=integrand))
    return ufl.Form(integrals)


def _check_points(name, law, rule):
    """ValueError unless the law's coefficients are on the points of the form's rule."""
    for c in [*law.coefficients(), *([law.unknown] if law.unknown is not None else [])]:
        element = c.ufl_function_space().ufl_element()
        if element.has_custom_quadrature:
            points = element.custom_quadrature()[0]
            if points.shape != rule.points.shape or not np.allclose(points, rule.points, rtol=0, atol=1e-12):
                raise ValueError(
                    f"{name}: a coefficient of the point law has {len(points)} points of a quadrature rule, the form "
                    f"integrates with {len(rule.points)} points: give both the same degree and scheme"
                )


def _local_expressions(name, law, parts, averages, representation, numbering, mesh):
    """LocalExpressions of a PointLaw and of averages, at the points of the form's rule; None without them."""
    ir, rank = representation.expression, representation.rank
    if law is None and not averages:
        return None
    what = "a point law" if law is not None else "averages"
    if len(integrands(ir)) != 1:
        degrees = [len(rule.points) for rule, _ in integrands(ir)]
        raise ValueError(
            f"{name}: cells with {what} need one quadrature rule, found rules of {degrees} points: give all terms "
            "over these cells the same metadata"
        )
    if rank > 1:
        raise ValueError(f"{name}: {what} need a form of rank 0 or 1, this one has rank {rank}")
    ((rule, _),) = integrands(ir)
    if law is not None:
        _check_points(name, law, rule)
    given = dict(parts)
    loops = _loops(averages, given)
    if averages or (law is not None and law.sums):
        given["volume"] = [abs(ufl.JacobianDeterminant(mesh))]
    for i, average in enumerate(averages.found.values() if averages else ()):
        given[f"average {i}"] = flatten(average.operand)
    parts, expressions = {}, []
    for part, components in given.items():
        parts[part] = (len(expressions), len(components))
        expressions += components
    analysis = analyze_ufl_objects([(lowered(ufl.as_vector(expressions)), rule.points)], np.dtype("float64"))
    (representation,) = compute_ir(analysis, {}, "impact", dict(OPTIONS), False).expressions
    ((_, graph),) = integrands(representation.expression)
    outputs = [
        Output(o, parts[f"output {o}"][1], numbering.coefficients[law.history[o]][0] if o in law.history else -1)
        for o in (law.outputs if law is not None else ())
    ]
    return LocalExpressions(
        graph,
        parts,
        outputs,
        list(law.sums) if law is not None else [],
        law.num_unknowns if law is not None else 0,
        list(averages.found.values()) if averages else [],
        *loops,
    )


def _loops(averages, law_parts):
    """Number of the loop over the points that solves the local equations, and number of loops.

    Averages that the local equations need come first; averages of what depends on their solution are summed up in the
    loop that solves them, or later.
    """
    if not averages:
        return 0, 1
    equations = [
        e for part in ("start", "scale", "start_error", "residual", "jacobian") for e in law_parts.get(part, ())
    ]
    solved_in = 1 + max((a.loop for a in averages.needed(equations)), default=-1)
    if any(a.solved for a in averages.needed(equations)):
        raise ValueError("the local equations have an average over the cell that depends on their own solution")
    for average in averages.found.values():
        inner = averages.needed([average.operand])
        average.loop = 1 + max((a.loop for a in inner), default=-1)
        if average.solved:
            average.loop = max(average.loop, solved_in)
    last = 1 + max(a.loop for a in averages.found.values())
    return (solved_in if any(a.solved for a in averages.found.values()) else last), last + 1


def expression_signature(expression, points):
    """Signature of an expression at points; like UFL's for forms it does not depend on names or object numbers."""
    new = _renumbered(ufl.algorithms.analysis.extract_constants(expression))
    numbering = {ufl.domain.extract_unique_domain(expression): 0}
    for group in (ufl.algorithms.extract_coefficients(expression), new.values()):
        numbering.update({c: i for i, c in enumerate(group)})
    plain = map_expr_dag(_Renumber(new), expression)
    text = ufl.algorithms.signature.compute_expression_signature(plain, numbering)
    return text + repr(np.asarray(points, dtype=float).tolist())


def expression_integral(expression, points, name, names, entity_type="cell"):
    """A UFL expression evaluated at reference points of a cell, as one Integral of type "expression".

    Args:
        expression: UFL expression without arguments.
        points: shape (num_points, tdim), reference coordinates.
        name: name of the expression.
        names: dict from coefficient or constant (or its id) to its name.
    """
    if ufl.algorithms.extract_arguments(expression):
        raise ValueError(f"{name}: an expression to evaluate at points must not contain test or trial functions")
    analysis = analyze_ufl_objects([(expression, np.asarray(points, dtype=float))], np.dtype("float64"))
    ir = compute_ir(analysis, {}, "impact", dict(OPTIONS), False)
    representation = ir.expressions[0]
    common = representation.expression
    coefficients = ufl.algorithms.extract_coefficients(analysis.expressions[0][0])
    constants = ufl.algorithms.analysis.extract_constants(expression)
    all_names = check_names(list(coefficients) + list(constants), names)
    domain = ufl.domain.extract_unique_domain(expression)
    return Integral(
        name=name,
        integral_type="expression",
        subdomains=(-1,),
        ir=common,
        rank=0,
        shape=(len(points), int(np.prod(expression.ufl_shape, dtype=int))),
        coefficients=[
            _coefficient(n, c.ufl_function_space().ufl_element(), common.coefficient_offsets[c], p)
            for n, c, p in zip(all_names, coefficients, representation.original_coefficient_positions)
        ],
        constants=[
            Constant(n, int(np.prod(c.ufl_shape, dtype=int)), int(common.original_constant_offsets[c]))
            for n, c in zip(all_names[len(coefficients) :], constants)
        ],
        argument_elements=(),
        coordinate_element=domain.ufl_coordinate_element(),
        signature=expression_signature(expression, points),
        numbering=Numbering(
            {c: (k, int(common.coefficient_offsets[c])) for k, c in enumerate(coefficients)},
            {c: int(n) for c, n in common.original_constant_offsets.items()},
        ),
        points=np.asarray(points, dtype=float),
        entity_type=entity_type,
    )
