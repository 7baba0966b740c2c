# SPDX-License-Identifier: MIT
"""Cross-verification of the UFL side against the hand-written solver, level by level.

`cross_check` compares forms of the catalogue, `self_check` checks forms that have no counterpart;
`verify_command.main` is the command line. Modules are imported on first use, so that importing the package does not
need SLEPc or matplotlib.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from dolfinx_impact.common.moved_packages import find_moved_modules

if TYPE_CHECKING:
    import ufl

    from .report import Report
    from .selfcheck.findings import SelfCheckReport
    from dolfinx_impact.own_forms.own_form import OwnForm

__all__ = ["OwnForm", "cross_check", "self_check"]

find_moved_modules()  # those of this package, too


def cross_check(form_or_name: str | ufl.Form | None = None, **options: Any) -> Report:
    """Compare forms of the catalogue, or a form of the user, with the hand-written solver.

    Args:
        form_or_name: a name of the catalogue, a UFL form, a path of a user's file, or None for all forms.
        options: keyword arguments of `impact_verify.levels.cross_check`.

    Returns:
        Report with `rows` and `passed`.

    Raises:
        ValueError: unknown form, operator, cell, degree or level; a UFL form without an operator.
    """
    from .levels import cross_check as check

    return check(form_or_name, **options)


def self_check(form: Any, name: str | None = None, **options: Any) -> SelfCheckReport:
    """Check what must hold of any residual, for forms that have no hand-written counterpart. Collective.

    Args:
        form: function of a mesh that returns an `OwnForm`, UFL form, material with internal variables, or path of a
            user's file.
        name: name of the form; in a file the one to check, None for all.
        options: keyword arguments of `impact_verify.selfcheck.self_check.self_check`.

    Returns:
        Report with `rows` and `passed`.

    Raises:
        TypeError: `form` is nothing that can be checked.
        ValueError: unknown cell or check, or the form cannot be used.
    """
    from .selfcheck.self_check import self_check as check

    return check(form, name, **options)


def __getattr__(name: str) -> Any:
    if name == "OwnForm":
        from dolfinx_impact.own_forms.own_form import OwnForm

        return OwnForm
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
