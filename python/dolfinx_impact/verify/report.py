# SPDX-License-Identifier: MIT
"""Rows of differences, and what is made of them: console table, JSON, exit status."""

import json
from dataclasses import asdict, dataclass, field
from pathlib import Path

from ..io.hdf5 import write_whole

LEVELS = ("element", "operator", "solution", "spectrum", "order", "derivative", "contact", "ranks", "user")


@dataclass
class Row:
    """One comparison.

    `name` says what was compared ("matrix", "reactions", ...); `difference` is what must not exceed `tolerance`;
    `reason` says where the tolerance comes from.
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
    passed: bool = field(init=False)

    def __post_init__(self):
        self.difference = float(self.difference)
        self.passed = bool(self.difference <= self.tolerance)  # a NaN does not pass


class Report:
    """Rows of a verification run.

    Args:
        cells, degrees, forms: to restrict the run to; None: all.

    Attributes:
        rows: list of Row. figures: list of (title, path of a PNG).
    """

    def __init__(self, cells=None, degrees=None, forms=None):
        self.rows, self.figures = [], []
        self.cells, self.degrees, self.forms = cells, degrees, forms

    def wants(self, cell, degree):
        """Is a comparison on these elements asked for? Levels skip what is not."""
        return (not self.cells or cell in self.cells) and (not self.degrees or degree in self.degrees)

    def add(self, *args, **kwargs):
        """Add a row, unless the run is restricted to others."""
        row = Row(*args, **kwargs)
        if self.wants(row.cell, row.degree) and (not self.forms or row.form in self.forms):
            self.rows.append(row)
        return row

    @property
    def passed(self):
        """True when there are rows and every one of them passed."""
        return bool(self.rows) and all(r.passed for r in self.rows)

    def failures(self):
        return [r for r in self.rows if not r.passed]

    def summary(self):
        """Per level and form: (level, form, number of rows, worst row by difference over tolerance)."""
        groups = {}
        for r in self.rows:
            groups.setdefault((r.level, r.form), []).append(r)

        def badness(r):
            if r.difference != r.difference:
                return float("inf")
            return (
                r.difference / r.tolerance if r.tolerance > 0 else float("inf") * r.difference if r.difference else 0.0
            )

        return [(level, form, len(rows), max(rows, key=badness)) for (level, form), rows in groups.items()]

    def print(self, all_rows=False):
        """Console table: one line per level and form with its worst row, and every row that failed."""
        from rich.console import Console
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
                case(r),
                f"{r.difference:.1e}",
                f"{r.tolerance:.1e}",
                r.reason,
                "[green]pass[/green]" if r.passed else "[red]FAIL[/red]",
            )
        console.print(table)
        for r in self.failures():
            console.print(
                f"[red]FAIL[/red] {r.level} {r.form} {case(r)}: {r.difference:.3e} > {r.tolerance:.1e}. {r.note}"
            )
        failed = f"{len(self.failures())} failed" if self.rows else "nothing was compared"
        verdict = "all passed" if self.passed else failed
        console.print(f"{len(self.rows)} rows, {verdict}")

    def versions(self):
        import basix
        import dolfinx
        import ffcx
        import numpy
        import ufl
        from petsc4py import PETSc

        import dolfinx_impact

        return {
            "dolfinx_impact": dolfinx_impact.__version__,
            "dolfinx": dolfinx.__version__,
            "ffcx": ffcx.__version__,
            "basix": basix.__version__,
            "ufl": ufl.__version__ if hasattr(ufl, "__version__") else "",
            "petsc": ".".join(map(str, PETSc.Sys.getVersion())),
            "numpy": numpy.__version__,
        }

    def write_json(self, path):
        """{"rows": [...], "versions": {...}}"""
        path = Path(path)
        path.parent.mkdir(parents=True, exist_ok=True)
        data = {"rows": [asdict(r) for r in self.rows], "passed": self.passed, "versions": self.versions()}
        write_whole(path, json.dumps(data, indent=1) + "\n")


def case(r):
    """Short text for what a row was about."""
    element = f"{r.cell} P{r.degree}" if r.cell else ""
    geometry = f" on geometry {r.geometry_degree}" if r.cell and r.geometry_degree != r.degree else ""
    return f"{element}{geometry} {r.hypothesis} {r.name}".strip()
