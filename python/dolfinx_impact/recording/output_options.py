# SPDX-License-Identifier: MIT
"""How fields are written, and which the user gives as expressions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ..common.units import Units
from .expression_fields import check_expressions
from .field_writer import ENDINGS


@dataclass(frozen=True)
class OutputOptions:
    """Checked arguments of `record`.

    Attributes:
        expressions: UFL expressions by name.
        ending: ending of the files of fields.
        units: units that names of fields end with; None: names alone.
    """

    expressions: dict[str, Any]
    ending: str
    units: Units | None

    def same_on_all_ranks(self) -> list[Any]:
        """What must be the same on all ranks."""
        return [list(self.expressions), self.ending, self.units]


def output_options(expressions: Any, ending: Any, units: Any) -> OutputOptions:
    """Check arguments of `record`, on this rank.

    Args:
        expressions: UFL expressions by name; None: none.
        ending: ending of the files of fields.
        units: Units or None.

    Raises:
        TypeError: an argument is of the wrong type.
        ValueError: an expression is no field, or the ending is unknown.
    """
    if ending not in ENDINGS:
        raise ValueError(f"ending is {ending!r}: use one of {', '.join(map(repr, ENDINGS))}")
    if units is not None and not isinstance(units, Units):
        raise TypeError(f"units must be Units, found {type(units).__name__}: for example di.SI, or di.Units('mm', 'N')")
    return OutputOptions(check_expressions(expressions), ending, units)
