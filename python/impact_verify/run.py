# SPDX-License-Identifier: MIT
"""`dolfinx-impact verify`: runs the levels or checks a form of one's own; table, JSON, JUnit, page; 0 if all passed."""

import argparse
import sys
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path

import ufl
from mpi4py import MPI

from dolfinx_impact.forms import registry
from dolfinx_impact.own_forms.user_file import run_file
from . import (
    catalogue,
    contact,
    derivative,
    element,
    history,
    html,
    junit,
    material,
    order,
    plastic_bodies,
    ranks,
    rolling,
    solution,
    spectrum,
    user_form,
    yielding_runs,
)
from . import operator as operator_level
from .model_warnings import model_warnings_off
from .report import Report
from .selfcheck import page
from .selfcheck import self_check as selfcheck

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
    _check(cells, degrees, levels)
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
    with model_warnings_off():
        _run_bodies(report, levels, progress)
        if "order" in levels:
            order.run(report, None, progress)
    if "ranks" in levels:
        ranks.run(report, progress=progress)
    return report


def _run_bodies(report: Report, levels: Collection[str], progress: bool = True, announce: bool = False) -> None:
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
        ("history", history),
        ("rolling", rolling),
    ):
        if level not in levels:
            continue
        if announce:
            print(f"level {level}", file=sys.stderr)
        module.run(report, progress)
        if level == "solution":
            plastic_bodies.solution_rows(report)
        elif level == "history":
            plastic_bodies.history_rows(report)
            history.run_implicit(report)
            yielding_runs.run(report)


def _check(cells: Collection[str] | None, degrees: Collection[int] | None, levels: Collection[str]) -> None:
    for value in cells or ():
        if value not in registry.CELLS:
            raise ValueError(f"cell {value!r} is unknown: use {', '.join(registry.CELLS)}")
    for value in degrees or ():
        if value not in registry.DEGREES:
            raise ValueError(f"degree {value!r} is not in the catalogue: use 1 or 2")
    for value in levels:
        if value not in LEVELS:
            raise ValueError(f"level {value!r} is unknown: use {', '.join(LEVELS)}")


def parser() -> argparse.ArgumentParser:
    """Parser of the command line.

    Returns:
        Parser.
    """
    p = argparse.ArgumentParser(prog="dolfinx-impact verify", description=__doc__)
    p.add_argument("file", nargs="?", help="a file of your own")
    p.add_argument(
        "name", nargs="?", help="function of a mesh or form in the file, to be checked by itself; without it all that "
        "the file has. Or an operator of the hand-written solver, as with --as",
    )  # fmt: skip
    p.add_argument(
        "--as", dest="operator", metavar="OPERATOR",
        help="operator of the hand-written solver to compare the file's forms with, for example elasticity",
    )  # fmt: skip
    p.add_argument("--checks", nargs="+", metavar="CHECK", help=f"of a file: of {', '.join(selfcheck.CHECKS)}")
    p.add_argument("--cells", nargs="+", metavar="CELL", help=f"of {', '.join(registry.CELLS)}")
    p.add_argument("--degree", nargs="+", type=int, metavar="P", help="1, 2 or both")
    p.add_argument("--forms", nargs="+", metavar="FORM", help="of the catalogue")
    p.add_argument("--levels", nargs="+", default=LEVELS, metavar="LEVEL", help=f"of {', '.join(LEVELS)}")
    p.add_argument(
        "--ranks", nargs="+", type=int, default=[1, 2, 3], metavar="N", help="numbers of MPI ranks to compare"
    )
    p.add_argument("--count", type=int, default=100, help="random cells per element comparison")
    p.add_argument("--json", metavar="OUT", help="write the rows here")
    p.add_argument("--junit", metavar="OUT", help="write the rows here as JUnit XML, for continuous integration")
    p.add_argument(
        "--output", metavar="DIR", help="folder of the page and the figures (default results/verify, of a file "
        "results/verify/FILE)",
    )  # fmt: skip
    p.add_argument("--all-rows", action="store_true", help="print every row, not the worst per form")
    return p


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command.

    Args:
        argv: arguments; None for those of the process.

    Returns:
        Exit status: 0 when every row passed, 1 when one failed, 2 for input that cannot be used.
    """
    args = parser().parse_args(argv)
    report = Report(args.cells, args.degree, args.forms)
    try:
        if args.file and _is_self_check(args):
            report = _self_check(args)
        else:
            _run(report, args)
    except (TypeError, ValueError, FileNotFoundError, RuntimeError) as e:
        print(f"dolfinx-impact verify: {e}", file=sys.stderr)
        return 2
    if MPI.COMM_WORLD.rank == 0:
        report.print(args.all_rows)
        if args.json:
            report.write_json(args.json)
        if args.junit:
            junit.write(report, args.junit, f"verify.{Path(args.file).stem}" if args.file else "verify")
    return 0 if report.passed else 1


def _is_self_check(args: argparse.Namespace) -> bool:
    """Whether the file's forms are to be checked by themselves, or against the hand-written solver.

    Raises:
        FileNotFoundError: no such file.
        ValueError: the file raises, or the name is neither one of the file nor one of an operator.
    """
    if args.operator is not None:
        return False
    if args.name is None:
        if user_form.is_operator(Path(args.file).stem):
            hint = f"--as {Path(args.file).stem} compares with the hand-written solver"
            print(f"dolfinx-impact verify: the forms of {args.file} are checked by themselves; {hint}", file=sys.stderr)
        return True
    namespace = run_file(args.file)
    if user_form.is_operator(args.name):
        return args.name in namespace and not isinstance(namespace[args.name], ufl.Form)
    if args.name not in namespace:
        raise ValueError(
            f"{args.file} defines nothing called {args.name!r}, and the hand-written solver has no operator "
            f"{args.name!r}; it has {', '.join(user_form.operators())}"
        )
    return True


def _self_check(args: argparse.Namespace) -> Report:
    """Check the forms of a file by themselves; rank 0 writes their page."""
    rank = MPI.COMM_WORLD.rank
    report = selfcheck.self_check(
        args.file, args.name, cells=args.cells, checks=args.checks, progress=rank == 0 and sys.stderr.isatty()
    )
    if rank == 0:
        folder = Path(args.output or Path("results/verify") / Path(args.file).stem)
        print(f"page: {page.write(report, folder / 'index.html')}", file=sys.stderr)
    return report


def _run(report: Report, args: argparse.Namespace) -> None:
    _check(args.cells, args.degree, args.levels)
    if args.file:
        only = args.name if args.operator is not None else None
        user_form.check(report, args.file, args.operator or args.name, only=only)
        return
    for name in args.forms or [None]:
        first = [level for level in args.levels if level == "element"]
        cross_check(
            name, cells=args.cells, degrees=args.degree, levels=first, count=args.count, report=report, progress=True
        )
    folder = Path(args.output or "results/verify")
    folder.mkdir(parents=True, exist_ok=True)
    with model_warnings_off():
        _run_bodies(report, args.levels, announce=True)
        if "order" in args.levels:
            order.run(report, folder)
    if "ranks" in args.levels:
        print("level ranks", file=sys.stderr)
        ranks.run(report, args.ranks)
    report.figures.insert(0, ("Differences against their tolerances", html.differences_plot(report, folder)))
    print(f"page: {html.write(report, folder / 'index.html')}", file=sys.stderr)
