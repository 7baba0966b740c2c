# SPDX-License-Identifier: MIT
"""Which fields a problem has that can be recorded."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, Protocol

from dolfinx.fem import Function, FunctionSpace

from ..assembly.cauchy_stress import VON_MISES
from ..forms.elasticity import STRESS
from ..assembly.fields import is_mixed
from ..assembly.material_history import MaterialHistory
from ..assembly.history_field import HistoryField
from ..assembly.body_stress import NO_STRESS
from ..materials import Material
from .expression_fields import known_names
from .names import CONTACT, MOTION, SLIDING
from .output_options import OutputOptions


class RecordedProblem(Protocol):
    """What is read of a problem whose fields are recorded.

    Attributes:
        u: displacement [L].
        material: material of the bodies; None with a residual of the user's own.
        space: displacement space.
    """

    u: Function
    material: Material | None
    space: FunctionSpace

    @property
    def contact(self) -> Sequence[Any]: ...

    @property
    def has_history(self) -> bool: ...

    @property
    def history(self) -> MaterialHistory: ...

    @property
    def stress(self) -> HistoryField: ...

    @property
    def von_mises(self) -> HistoryField: ...


def body_names(problem: RecordedProblem) -> list[str]:
    """Names of the fields that the materials of a problem have.

    Args:
        problem: the problem.
    """
    if problem.material is None:
        return []
    return [*(problem.history if problem.has_history else ()), STRESS, VON_MISES]


def contact_names(problem: RecordedProblem) -> list[str]:
    """Names of the fields that all contacts of a problem have.

    Args:
        problem: the problem.
    """
    known = (*CONTACT, *SLIDING)
    return [name for name in known if problem.contact and all(name in c.fields for c in problem.contact)]


def check_fields(
    problem: RecordedProblem, fields: Iterable[str], motion: Sequence[str], options: OutputOptions
) -> tuple[str, ...]:
    """Check the names of fields, on this rank.

    Args:
        problem: the problem.
        fields: the argument `fields` of `record`.
        motion: names of the functions of the motion that the problem has.
        options: how fields are written, and expressions.

    Returns:
        The names, those of all expressions among them.

    Raises:
        TypeError: `fields` is a text, or an item is none.
        ValueError: the problem has no such field, or an expression has the name of one that it has.
    """
    if isinstance(fields, str):
        raise TypeError(f"fields must be a list of names, found the text {fields!r}: put it into a list")
    names = list(fields)
    wrong = [f for f in names if not isinstance(f, str)]
    if wrong:
        raise TypeError(f"fields must hold names, found {type(wrong[0]).__name__}: UFL goes into expressions={{...}}")
    given = known_names(options.expressions)
    own = [*body_names(problem), *motion, *contact_names(problem)]
    twice = [name for name in options.expressions if name in (*own, *MOTION, *CONTACT)]
    if twice:
        raise ValueError(f"expressions {twice}: the problem has fields of these names, take others")
    names += [name for name in options.expressions if name not in names]
    if is_mixed(problem.space) and any(name in motion for name in names):
        raise ValueError(
            "record: u is on a mixed space, whose fields have elements of their own: give fields=[] and "
            'expressions={"displacement of the body": ufl.split(u)[0], ...}, which are averaged at the vertices'
        )
    known = [*motion, *(name for name in own if name not in motion), *given]
    unknown = [name for name in names if name not in known]
    if problem.material is None and any(name in (STRESS, VON_MISES) for name in unknown):
        raise ValueError(f"fields {unknown}: {NO_STRESS}")
    if unknown and not problem.contact and all(name in CONTACT for name in unknown):
        raise ValueError(f"fields {unknown} are those of contacts, and the problem has none: give contact=[...]")
    if unknown:
        raise ValueError(f"fields {unknown} are unknown: use some of {', '.join(known)}, or give expressions")
    return tuple(dict.fromkeys(names))
