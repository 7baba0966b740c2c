# SPDX-License-Identifier: MIT
"""UFL expressions as their user has written them, for messages."""

import re

import ufl
from ufl.corealg.traversal import unique_pre_traversal

LONGEST = 60
_FUNCTIONS = {
    "CellAvg": "ufl.cell_avg({})",
    "FacetAvg": "ufl.facet_avg({})",
    "CellMax": "cell_max({})",
    "CellVolume": "ufl.CellVolume(mesh)",
    "FacetArea": "ufl.FacetArea(mesh)",
    "Circumradius": "ufl.Circumradius(mesh)",
    "CellDiameter": "ufl.CellDiameter(mesh)",
    "MinCellEdgeLength": "ufl.MinCellEdgeLength(mesh)",
    "MaxCellEdgeLength": "ufl.MaxCellEdgeLength(mesh)",
    "MinFacetEdgeLength": "ufl.MinFacetEdgeLength(mesh)",
    "MaxFacetEdgeLength": "ufl.MaxFacetEdgeLength(mesh)",
    "FacetNormal": "ufl.FacetNormal(mesh)",
    "CellNormal": "ufl.CellNormal(mesh)",
    "CellCoordinate": "the reference coordinates of a cell (CellCoordinate)",
    "FacetCoordinate": "the reference coordinates of a facet (FacetCoordinate)",
    "QuadratureWeight": "the weight of a point (QuadratureWeight)",
    "ReferenceNormal": "ufl.FacetNormal(mesh)",
    "BesselJ": "ufl.bessel_J",
    "BesselY": "ufl.bessel_Y",
    "BesselI": "ufl.bessel_I",
    "BesselK": "ufl.bessel_K",
}


def in_words(expression):
    """An expression, or one of UFL's operators by its class, as a user has written it.

    Args:
        expression: UFL expression, or a class of UFL.

    Returns:
        Text, shortened.
    """
    kind = expression if isinstance(expression, type) else type(expression)
    name = kind.__name__
    if isinstance(expression, type):
        return _FUNCTIONS.get(name, f"ufl.{name.lower()}").format("...")
    if name.startswith("Bessel"):
        order, argument = expression.ufl_operands
        return f"{_FUNCTIONS[name]}({order}, {_short(str(argument))})"
    if name in ("CellAvg", "FacetAvg", "CellMax"):
        operand = expression.ufl_operands[0]
        text = _names(operand)
        if "i_" in text:  # indices that UFL has introduced: the functions alone say more
            functions = [getattr(c, "name", "") for c in ufl.algorithms.extract_coefficients(operand)]
            text = ", ".join(["..."] + [f for f in functions if isinstance(f, str) and f])
        return _FUNCTIONS[name].format(_short(text))
    return _FUNCTIONS.get(name) or _short(_names(expression))


def find(expression, kinds):
    """First part of an expression that is of one of some classes, or None."""
    return next((o for o in unique_pre_traversal(expression) if isinstance(o, kinds)), None)


def _names(expression):
    """Text of an expression with the names of its functions; UFL's own numbers of arguments as v and du."""
    text = str(expression)
    for c in ufl.algorithms.extract_coefficients(expression):
        name = getattr(c, "name", "")
        if isinstance(name, str) and name:
            text = text.replace(str(c), name)
    text = re.sub(r"\bv_0\b", "v", re.sub(r"\bv_1\b", "du", text))
    return re.sub(r"\bw_(\d+)\b", r"w\1", text)


def _short(text):
    return text if len(text) <= LONGEST else text[: LONGEST - 3] + "..."
