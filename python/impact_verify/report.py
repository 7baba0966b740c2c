# SPDX-License-Identifier: MIT
"""Rows of differences, and their console table and JSON file."""

import json
import math
from collections.abc import Collection
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from dolfinx_impact.io.hdf5 import write_whole
from dolfinx_impact.io.run_folder import versions


@dataclass
class Row:
    """One comparison.

    Args:
        level: level of the comparison, one of levels.LEVELS.
        form: form or method that is compared.
        cell: cell.
        degree: degree of the displacement.
        geometry_degree: degree of the geometry.
        hypothesis: hypothesis of the material.
        difference: difference, which must not exceed the tolerance [1].
        tolerance: bound on the difference [1].
        reason: what the tolerance follows from.
        name: quantity and body that are compared.
        note: what is wrong, as far as it is known, and where the largest difference is.
        cause: what is wrong with a form that differs, as far as it is known.

    Attributes:
        passed: whether the difference is within the tolerance; a NaN does not pass.
    """

    level: str
    form: str
    cell: str
    degree: int
    geometry_degree: int
    hypothesis: str
    difference: float
    tolerance: float
    reason: str
    name: str = ""
    note: str = ""
    cause: str = ""
    passed: bool = field(init=False)

    def __post_init__(self) -> None:
        self.difference = float(self.difference)
        self.passed = bool(self.difference <= self.tolerance)


class Report:
    """Rows of a verification run.

    Args:
        cells: cells that the run is restricted to; None for all.
        degrees: degrees of the displacement that it is restricted to; None for all.
        forms: forms that it is restricted to; None for all.

    Attributes:
        rows: the comparisons.
        figures: title and PNG file of each figure.
    """

    def __init__(
        self,
        cells: Collection[str] | None = None,
        degrees: Collection[int] | None = None,
        forms: Collection[str] | None = None,
    ) -> None:
        self.rows: list[Row] = []
        self.figures: list[tuple[str, Path]] = []
        self.cells, self.degrees, self.forms = cells, degrees, forms

    def __repr__(self) -> str:
        failed = sum(not row.passed for row in self.rows)
        end = f"{failed} failed" if failed else "all passed" if self.rows else "nothing was compared"
        return f"{type(self).__name__}({len(self.rows)} rows, {end})"

    def wants(self, cell: str, degree: int) -> bool:
        """Is the run not restricted to other elements?

        Args:
            cell: cell.
            degree: degree of the displacement.

        Returns:
            Whether rows of this element are part of the run.
        """
        return (not self.cells or cell in self.cells) and (not self.degrees or degree in self.degrees)

    def add(self, *args: Any, **kwargs: Any) -> Row:
        """Add a row, unless the run is restricted to others.

        Args:
            args: arguments of `Row`.
            kwargs: keyword arguments of `Row`.

        Returns:
            The row.
        """
        row = Row(*args, **kwargs)
        if self.wants(row.cell, row.degree) and (not self.forms or row.form in self.forms):
            self.rows.append(row)
        return row

    @property
    def passed(self) -> bool:
        """Whether there are rows and every one of them passed."""
        return bool(self.rows) and all(r.passed for r in self.rows)

    def failures(self) -> list[Row]:
        """Rows that did not pass.

        Returns:
            The rows.
        """
        return [r for r in self.rows if not r.passed]

    def summary(self) -> list[tuple[str, str, int, Row]]:
        """Worst row of each level and form, by difference over tolerance.

        Returns:
            Level, form, number of rows and worst row of each.
        """
        groups: dict[tuple[str, str], list[Row]] = {}
        for r in self.rows:
            groups.setdefault((r.level, r.form), []).append(r)

        def ratio(r: Row) -> float:
            if r.difference != r.difference:
                return float("inf")
            return (
                r.difference / r.tolerance if r.tolerance > 0 else float("inf") * r.difference if r.difference else 0.0
            )

        return [(level, form, len(rows), max(rows, key=ratio)) for (level, form), rows in groups.items()]

    def print(self, all_rows: bool = False) -> None:
        """Print a table with the worst row of each level and form, and every row that failed.

        Args:
            all_rows: print every row in the table.
        """
        from rich.console import Console
        from rich.markup import escape
        from rich.table import Table

        console = Console(width=150)
        table = Table(title="UFL kernels against the hand-written solver")
        for column in ("level", "form", "rows", "worst case", "difference", "tolerance", "tolerance from", ""):
            table.add_column(column, justify="right" if column in ("rows", "difference", "tolerance") else "left")
        lines = [(r.level, r.form, 1, r) for r in self.rows] if all_rows else self.summary()
        for level, form, count, r in lines:
            table.add_row(
                level,
                form,
                str(count),
                row_label(r),
                f"{r.difference:.1e}",
                f"{r.tolerance:.1e}",
                r.reason,
                "[green]pass[/green]" if r.passed else "[red]FAIL[/red]",
            )
        console.print(table)
        for r in self.failures():
            console.print(
                f"[red]FAIL[/red] {r.level} {r.form} {row_label(r)}: {r.difference:.3e} > {r.tolerance:.1e}. "
                f"{escape(r.note)}"
            )
        failed = f"{len(self.failures())} failed" if self.rows else "nothing was compared"
        verdict = "all passed" if self.passed else failed
        console.print(f"{len(self.rows)} rows, {verdict}")

    def write_json(self, path: Path | str) -> None:
        """Write {"rows": [...], "passed": ..., "versions": {...}}; numbers that are not finite are null.

        Args:
            path: file to write; its folder is made.
        """
        path = Path(path)
        path.parent.mkdir(parents=True, exist_ok=True)
        rows = [{k: _finite(v) for k, v in asdict(r).items()} for r in self.rows]
        data = {"rows": rows, "passed": self.passed, "versions": versions()}
        write_whole(path, json.dumps(data, indent=1, allow_nan=False) + "\n")


def _finite(value: Any) -> Any:
    """The value; None for numbers that JSON does not have."""
    return None if isinstance(value, float) and not math.isfinite(value) else value


def row_label(r: Row) -> str:
    """Short text about the element and the quantity of a row.

    Args:
        r: row.

    Returns:
        Text.
    """
    element = f"{r.cell} P{r.degree}" if r.cell else ""
    geometry = f" on geometry {r.geometry_degree}" if r.cell and r.geometry_degree != r.degree else ""
    return " ".join(text for text in (f"{element}{geometry}", r.hypothesis, r.name) if text)
