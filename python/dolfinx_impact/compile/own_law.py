# SPDX-License-Identifier: MIT
"""A law of a user's own on one kind of cells, as forms that kernels are written of."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import ufl
from dolfinx import fem
from ufl.algorithms.analysis import extract_constants

from ..forms.point_law import PointLaw
from .case import Case

# Kinds of kernels. "elastic_tangent" is the stiffness of the elastic part of a law with internal variables.
KINDS = ("force", "tangent", "elastic_tangent", "energy", "mass", "stress")
DISPLACEMENT = "u"  # name of the unknown in every kernel
DENSITY = "density"  # name of the constant of the mass

Named: TypeAlias = "ufl.Coefficient | ufl.Constant"


class KernelForm(NamedTuple):
    """A form that a kernel is written of, with the point law of its internal variables and outputs, if any."""

    form: ufl.Form
    law: PointLaw | None = None


@dataclass
class OwnLaw:
    """A law of a user's own on one kind of cells.

    Attributes:
        name: name of the law in the user's file; its kernels are called "NAME.force" and so on.
        case: the cells.
        forms: form of each kind of kernel, of KINDS.
        names: names of coefficients and constants.
        values: values that constants have in the file, by name; not of symbolic ones.
        missing: why there are no kernels of a kind, by kind.
    """

    name: str
    case: Case
    forms: dict[str, KernelForm]
    names: dict[Named, str]
    values: dict[str, list[float]]
    missing: dict[str, str] = field(default_factory=dict)


def values_of(constants: dict[Named, str]) -> dict[str, list[float]]:
    """Values of constants of DOLFINx by name.

    Args:
        constants: names of constants; symbolic ones and coefficients have no value.

    Raises:
        ValueError: a value is not finite.
    """
    values: dict[str, list[float]] = {}
    for c, name in constants.items():
        if isinstance(c, fem.Constant):
            value = np.ravel(c.value).astype(float)
            if not np.isfinite(value).all():
                raise ValueError(f"the constant {name!r} is {value.tolist()}: give it a finite value in the file")
            values[name] = [float(v) for v in value]
    return values


def constants_of(*terms: Any) -> list[ufl.Constant]:
    """Constants of forms and expressions, in the order in which they were made.

    Args:
        terms: forms, expressions, or None.
    """
    found = {c for term in terms if term is not None for c in extract_constants(term)}
    return sorted(found, key=lambda c: c.count())
