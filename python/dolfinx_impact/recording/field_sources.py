# SPDX-License-Identifier: MIT
"""What is written for the names of fields, and when it is evaluated."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from dolfinx.fem import Function

from ..assembly.cauchy_stress import VON_MISES
from ..forms.elasticity import STRESS
from ..assembly.history_field import HistoryField
from .body_fields import BodyFields
from .contact_fields import ContactFields
from .expression_fields import expression_field, known_names
from .field_arguments import RecordedProblem, body_names, contact_names
from .field_source import FieldSource, MotionFields
from .names import dimension
from .output_options import OutputOptions


def field_sources(
    problem: RecordedProblem, names: Sequence[str], motion: Mapping[str, Function], options: OutputOptions
) -> list[FieldSource]:
    """Sources of fields, one for each series. Collective.

    Args:
        problem: the problem.
        names: names of fields, as check_fields returned them.
        motion: functions of the motion by name; they get these names.
        options: how fields are written, and expressions.
    """
    sources: list[FieldSource] = []
    moving = [name for name in names if name in motion]
    for name in moving:
        motion[name].name = name
    if moving:
        sources.append(MotionFields([motion[name] for name in moving], [dimension(name) for name in moving]))
    given, own = known_names(options.expressions), body_names(problem)
    of_bodies = [name for name in names if name in own or name in given]
    if of_bodies:
        fields = [
            expression_field(name, options.expressions, problem.space) if name in given else _body_field(problem, name)
            for name in of_bodies
        ]
        sources.append(BodyFields(problem.space.mesh, fields, [dimension(name) for name in of_bodies]))
    of_contacts = [name for name in names if name in contact_names(problem) and name not in given]
    if of_contacts:
        sources.append(ContactFields(problem.space, problem.contact, of_contacts))
    return sources


def _body_field(problem: RecordedProblem, name: str) -> HistoryField:
    """Field of the materials."""
    if name in (STRESS, VON_MISES):
        return problem.stress if name == STRESS else problem.von_mises
    return problem.history[name]
