# SPDX-License-Identifier: MIT
"""What the checks of a form have found: a table, a page with pictures, JSON and JUnit."""

from __future__ import annotations

from dataclasses import dataclass, field

from dolfinx_impact.common.types import FloatArray
from ..report import Report, Row


@dataclass
class Finding(Row):
    """One check of a form of one's own.

    Args:
        applies: whether the check was made; if not, `note` says why, and difference and tolerance are zero.
    """

    applies: bool = True

    @property
    def status(self) -> str:
        """ "pass", "FAIL" or "does not apply"."""
        return ("pass" if self.passed else "FAIL") if self.applies else "does not apply"


@dataclass
class Curve:
    """Numbers of a check, for its picture.

    Args:
        x: abscissae, shape (n).
        y: ordinates, shape (n).
        label: text of the legend.
        slope: slope of theory in a doubly logarithmic picture; None: no line of theory.
    """

    x: FloatArray
    y: FloatArray
    label: str
    slope: float | None = None


@dataclass
class Picture:
    """Curves of one check.

    Args:
        title: title.
        xlabel: text of the abscissa.
        ylabel: text of the ordinate.
        curves: curves.
        points: whether curves are drawn as points alone.
    """

    title: str
    xlabel: str
    ylabel: str
    curves: list[Curve] = field(default_factory=list)
    points: bool = False


class SelfCheckReport(Report):
    """Findings of the checks of forms of one's own.

    Attributes:
        pictures: pictures by the text about the cell that they belong to.
    """

    title = "Checks of a form of one's own"

    def __init__(self) -> None:
        super().__init__()
        self.pictures: dict[str, list[Picture]] = {}

    def __repr__(self) -> str:
        made = [f for f in self.findings if f.applies]
        failed = ", ".join(dict.fromkeys(f.name for f in made if not f.passed))
        end = f"failed: {failed}" if failed else "all passed" if made else "nothing was checked"
        return f"SelfCheckReport({len(made)} checks made, {end})"

    @property
    def findings(self) -> list[Finding]:
        """The rows."""
        return [r for r in self.rows if isinstance(r, Finding)]

    @property
    def passed(self) -> bool:
        """Whether checks were made and every one of them passed."""
        made = [f for f in self.findings if f.applies]
        return bool(made) and all(f.passed for f in made)

    def of(self, check: str) -> list[Finding]:
        """Findings of one check.

        Args:
            check: name of the check.
        """
        return [f for f in self.findings if f.name == check]

    def print(self, all_rows: bool = False) -> None:
        """Print a table with one line for each check, and a sentence for each that failed or does not apply.

        Args:
            all_rows: print the sentence of each check that passed, too.
        """
        from rich.console import Console
        from rich.markup import escape
        from rich.table import Table

        console = Console(width=150)
        colours = {"pass": "green", "FAIL": "red", "does not apply": "yellow"}
        table = Table(title=self.title)
        for column in ("form", "cell", "check", "found", "tolerance", "", "what it says"):
            table.add_column(column, justify="right" if column in ("found", "tolerance") else "left")
        for f in self.findings:
            numbers = [f"{f.difference:.1e}", f"{f.tolerance:.1e}"] if f.applies else ["", ""]
            mark = f"[{colours[f.status]}]{f.status}[/]"
            table.add_row(escape(f.form), f"{f.cell} P{f.degree}", f.name, *numbers, mark, escape(f.note))
        console.print(table)
        made = [f for f in self.findings if f.applies]
        failed = [f for f in made if not f.passed]
        verdict = "nothing was checked" if not made else f"{len(failed)} failed" if failed else "all passed"
        console.print(f"{len(made)} checks, {len(self.findings) - len(made)} do not apply; {verdict}")
        for f in failed:
            console.print(f"[red]FAIL[/] {escape(f.form)} {f.cell} {f.name}: {escape(f.note)}", soft_wrap=True)
