# SPDX-License-Identifier: MIT
"""First stage: UFL form or expression -> FFCx's intermediate representation, with explicit options.

FFCx's own command line reads private option files of the machine; here every option is written down, so that a kernel
depends on nothing but the form.
"""

from dataclasses import dataclass

import numpy as np
import ufl
from ffcx.analysis import analyze_ufl_objects
from ffcx.ir.representation import compute_ir
from ufl.algorithms.map_integrands import map_integrand_dags
from ufl.corealg.multifunction import MultiFunction

# Tables are compared and rounded at round-off level (FFCx's defaults, 1e-6, would round shape functions as well).
OPTIONS = {
    "scalar_type": "float64",
    "sum_factorization": False,
    "table_rtol": 1e-13,
    "table_atol": 1e-14,
    "epsilon": 1e-14,
    "verbosity": 30,
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
class Integral:
    """One kernel to write: FFCx's representation with the facts about it that FFCx does not keep together."""

    name: str
    integral_type: str  # "cell", "exterior_facet", "expression"
    subdomains: tuple
    ir: object
    rank: int
    shape: tuple  # of the element tensor (for an expression: points, components)
    coefficients: list
    constants: list
    argument_elements: tuple
    coordinate_element: object
    signature: str
    points: np.ndarray | None = None
    entity_type: str = "cell"
    hypothesis: str = ""


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


def check_names(objects, given):
    """Names of coefficients and constants: those given, w0, w1, ... for the others. ValueError where two are the
    same."""
    names = [given.get(id(o)) or given.get(o) or f"w{i}" for i, o in enumerate(objects)]
    if len(set(names)) != len(names):
        twice = sorted({n for n in names if names.count(n) > 1})
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


def canonical(form):
    """The form with its constants renumbered from 0, and the dict from old constants to new.

    UFL orders operands by the printed numbers of constants ("10" before "9"), and numbers count up through a process:
    without this, the same form written twice may have two signatures and two kernels.
    """
    constants = sorted(form.constants(), key=lambda c: c.count())
    new = {c: ufl.Constant(c.ufl_domain(), c.ufl_shape, count=i) for i, c in enumerate(constants)}
    return map_integrand_dags(_Renumber(new), form), new


def form_signature(form):
    """UFL's signature of a form, independent of names and of object numbers."""
    return canonical(form)[0].signature()


def form_integrals(form, name, names, hypothesis=""):
    """Integrals of a UFL form.

    Args:
        form: rank 0, 1 or 2 UFL form.
        name: name of the form.
        names: dict from coefficient or constant (or its id) to its name.
        hypothesis: for the kernel's description.

    Returns:
        list of Integral.

    Raises:
        ValueError: interior-facet or custom integrals, names used twice.
    """
    if not isinstance(form, ufl.Form):
        raise TypeError(f"{name}: expected a UFL form, found {type(form).__name__}")
    if form.empty():
        raise ValueError(f"{name}: the form is zero, there is nothing to compile")
    kinds = {i.integral_type() for i in form.integrals()} - {"cell", "exterior_facet"}
    if kinds:
        raise ValueError(f"{name}: integrals of type {sorted(kinds)} are not supported, only dx and ds")
    form, renumbered = canonical(form)
    names = dict(names) | {new: names.get(id(old)) or names.get(old) for old, new in renumbered.items()}
    analysis = analyze_ufl_objects([form], np.dtype("float64"))
    ir = compute_ir(analysis, {}, "impact", dict(OPTIONS), False)
    data = analysis.form_data[0]
    coefficients = data.reduced_coefficients
    originals = [data.original_form.coefficients()[i] for i in data.original_coefficient_positions]
    constants = data.original_form.constants()
    all_names = check_names(list(originals) + list(constants), names)
    signature = form.signature()
    result = []
    for itg, representation in zip(data.integral_data, ir.integrals):
        expression = representation.expression
        offsets = expression.coefficient_offsets
        subdomains = tuple(-1 if s == "otherwise" else int(s) for s in itg.subdomain_id)
        result.append(
            Integral(
                name=name,
                integral_type=itg.integral_type,
                subdomains=subdomains,
                ir=expression,
                rank=representation.rank,
                shape=tuple(int(n) for n in expression.tensor_shape),
                coefficients=[
                    _coefficient(n, e, offsets[c], p)
                    for n, e, c, p in zip(
                        all_names, data.coefficient_elements, coefficients, data.original_coefficient_positions
                    )
                ],
                constants=[
                    Constant(n, int(np.prod(c.ufl_shape, dtype=int)), int(expression.original_constant_offsets[c]))
                    for n, c in zip(all_names[len(coefficients) :], constants)
                ],
                argument_elements=tuple(data.argument_elements),
                coordinate_element=itg.domain.ufl_coordinate_element(),
                signature=signature,
                hypothesis=hypothesis,
            )
        )
    return result


def expression_signature(expression, points):
    """Signature of an expression at points; like UFL's for forms it does not depend on names or object numbers."""
    domain = ufl.domain.extract_unique_domain(expression)
    numbering = {domain: 0}
    for group in (
        ufl.algorithms.extract_coefficients(expression),
        ufl.algorithms.analysis.extract_constants(expression),
    ):
        numbering.update({c: i for i, c in enumerate(group)})
    text = ufl.algorithms.signature.compute_expression_signature(expression, numbering)
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
        points=np.asarray(points, dtype=float),
        entity_type=entity_type,
    )
