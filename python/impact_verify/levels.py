# SPDX-License-Identifier: MIT
"""The levels of the comparison with the hand-written solver, and what runs them."""

import sys
from collections.abc import Collection, Mapping

import ufl

from dolfinx_impact.forms import registry
from . import (
    averaged_pressure,
    catalogue,
    contact,
    derivative,
    element,
    material,
    one_point,
    order,
    plastic_bodies,
    ranks,
    rolling,
    runs_in_time,
    solution,
    spectrum,
    user_form,
    yielding_runs,
)
from . import operator as operator_level
from .model_warnings import model_warnings_off
from .report import Report

LEVELS = (
    "element", "operator", "material", "solution", "spectrum", "order", "derivative", "contact", "history", "rolling",
    "ranks",
)  # fmt: skip


def cross_check(
    form_or_name: str | ufl.Form | None = None,
    *,
    operator: str | None = None,
    constants: Mapping[str, ufl.Constant | float] | None = None,
    hypothesis: str | None = None,
    cells: Collection[str] | None = None,
    degrees: Collection[int] | None = None,
    levels: Collection[str] = ("element",),
    count: int = 100,
    report: Report | None = None,
    progress: bool = False,
) -> Report:
    """Compare forms of the catalogue, or a form of the user, with the hand-written solver.

    Every rank that calls it makes all comparisons by itself.

    Args:
        form_or_name: a name of forms.registry.NAMES, a UFL form, a path of a user's file, or None for all forms.
        operator: operator that a UFL form or a user's file is compared with, for example "elasticity"; None takes the
            name of the file.
        constants: constants of a UFL form by name (E, nu, mu, lmbda, density, ...).
        hypothesis: hypothesis of a UFL form in the plane: "plane_strain" (default), "plane_stress" or "axisymmetric".
        cells: cells that the comparison is restricted to; None for all.
        degrees: degrees of the displacement that it is restricted to; None for all.
        levels: levels to run, a part of LEVELS.
        count: number of random cells per element comparison.
        report: report to add to; None makes a new one.
        progress: show progress bars.

    Returns:
        Report with `rows` and `passed`.

    Raises:
        ValueError: unknown form, operator, cell, degree or level; a UFL form without an operator.
    """
    check_choice(cells, degrees, levels)
    report = report if report is not None else Report(cells, degrees)
    if isinstance(form_or_name, ufl.Form):
        if operator is None:
            raise ValueError(f"operator is None: name one of {', '.join(user_form.ALIASES)} for a form of your own")
        user_form.check_form(report, form_or_name, operator, {**(constants or {}), "hypothesis": hypothesis})
        return report
    if form_or_name is not None and str(form_or_name).endswith(".py"):
        user_form.check(report, form_or_name, operator)
        return report
    if form_or_name is not None and form_or_name not in registry.NAMES:
        raise ValueError(f"form {form_or_name!r} is unknown: the catalogue holds {', '.join(registry.NAMES)}")
    names = None if form_or_name is None else [form_or_name]
    if "element" in levels:
        cases = catalogue.cases(names, cells, degrees)
        if len(cases) > 20:
            element.compile_all(cases, progress)
        element.run(report, cases, count, progress)
        if names is None:
            one_point.run_elements(report)
    with model_warnings_off():
        run_bodies(report, levels, progress)
        if "order" in levels:
            order.run(report, None, progress)
    if "ranks" in levels:
        ranks.run(report, progress=progress)
    return report


def run_bodies(report: Report, levels: Collection[str], progress: bool = True, announce: bool = False) -> None:
    """Run the levels between element and order.

    Args:
        report: report to add to.
        levels: levels to run.
        progress: show progress bars.
        announce: name every level on the standard error.
    """
    for level, module in (
        ("operator", operator_level),
        ("material", material),
        ("solution", solution),
        ("spectrum", spectrum),
        ("derivative", derivative),
        ("contact", contact),
        ("history", runs_in_time),
        ("rolling", rolling),
    ):
        if level not in levels:
            continue
        if announce:
            print(f"level {level}", file=sys.stderr)
        module.run(report, progress)
        if level == "solution":
            plastic_bodies.solution_rows(report)
            averaged_pressure.solution_rows(report)
        elif level == "history":
            plastic_bodies.history_rows(report)
            averaged_pressure.history_rows(report)
            runs_in_time.run_implicit(report)
            yielding_runs.run(report)
            one_point.run_motion(report)
            one_point.run_flow(report)


def check_choice(cells: Collection[str] | None, degrees: Collection[int] | None, levels: Collection[str]) -> None:
    """Refuse what there is nothing to compare of.

    Args:
        cells: cells, or None.
        degrees: degrees of the displacement, or None.
        levels: levels.

    Raises:
        ValueError: an unknown cell, degree or level.
    """
    for value in cells or ():
        if value not in registry.CELLS:
            raise ValueError(f"cell {value!r} is unknown: use {', '.join(registry.CELLS)}")
    for value in degrees or ():
        if value not in registry.DEGREES:
            raise ValueError(f"degree {value!r} is not in the catalogue: use 1 or 2")
    for value in levels:
        if value not in LEVELS:
            raise ValueError(f"level {value!r} is unknown: use {', '.join(LEVELS)}")
