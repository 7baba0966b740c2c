# SPDX-License-Identifier: MIT
"""Cross-verification of the UFL side against the hand-written solver, level by level.

`cross_check` compares forms of the catalogue; `run.main` is the command line. Modules are imported on first use, so
that importing dolfinx_impact does not need the hand-written solver, SLEPc or matplotlib.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import ufl

    from .report import Report


def cross_check(form_or_name: str | ufl.Form | None = None, **options: Any) -> Report:
    """Compare forms of the catalogue, or a form of the user, with the hand-written solver.

    Args:
        form_or_name: a name of the catalogue, a UFL form, a path of a user's file, or None for all forms.
        options: keyword arguments of `verify.run.cross_check`.

    Returns:
        Report with `rows` and `passed`.

    Raises:
        ValueError: unknown form, operator, cell, degree or level; a UFL form without an operator.
    """
    from .run import cross_check as check

    return check(form_or_name, **options)
