# SPDX-License-Identifier: MIT
"""`dolfinx-impact verify`: runs the levels or checks a form of one's own; table, JSON, JUnit, page; 0 if all passed."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import ufl
from mpi4py import MPI

from dolfinx_impact.forms import registry
from dolfinx_impact.own_forms.user_file import run_file
from . import html, junit, order, ranks, user_form
from .levels import LEVELS, check_choice, cross_check, run_bodies
from .model_warnings import model_warnings_off
from .report import Report
from .selfcheck import page
from .selfcheck import self_check as selfcheck


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
    check_choice(args.cells, args.degree, args.levels)
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
        run_bodies(report, args.levels, announce=True)
        if "order" in args.levels:
            order.run(report, folder)
    if "ranks" in args.levels:
        print("level ranks", file=sys.stderr)
        ranks.run(report, args.ranks)
    report.figures.insert(0, ("Differences against their tolerances", html.differences_plot(report, folder)))
    print(f"page: {html.write(report, folder / 'index.html')}", file=sys.stderr)
