# SPDX-License-Identifier: MIT
"""Rows of the benchmark: their content, a check for impossible values, and the table that grows during a run."""

import math
import time
from collections.abc import Callable, Iterable, Sequence
from typing import Any, TypedDict

from dolfinx_impact.common.messages import progress_is_shown
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

PEAK = "share of peak flops"
BANDWIDTH = "share of bandwidth"


class Row(TypedDict):
    """One measured value and its baseline."""

    name: str
    cell: str
    ranks: int
    value: float
    unit: str
    baseline: float
    ratio: float


# What the progress bar counts: a text, and the function that measures some rows.
Job = tuple[str, Callable[[], Iterable[Row]]]


def row(name: str, cell: str, ranks: int, value: float, unit: str, baseline: float) -> Row:
    """Make a row with its ratio.

    Args:
        name: measured quantity and baseline.
        cell: cell and degree, or the model.
        ranks: number of MPI ranks.
        value: measured value [unit].
        unit: unit of value and baseline.
        baseline: value that it is compared with [unit].

    Returns:
        The row; its ratio is value over baseline [1].
    """
    return {
        "name": name,
        "cell": cell,
        "ranks": ranks,
        "value": float(value),
        "unit": unit,
        "baseline": float(baseline),
        "ratio": float(value / baseline),
    }


def impossible(rows: Iterable[Row]) -> list[str]:
    """Find rows that cannot be true: a kernel above the processor's peak, or a number that is not finite.

    Args:
        rows: rows of a run.

    Returns:
        A sentence for each such row.
    """
    complaints = []
    for r in rows:
        where = f"{r['name']} ({r['cell']})"
        if not all(math.isfinite(x) for x in (r["value"], r["baseline"], r["ratio"])):
            complaints.append(f"{where}: {r['value']} {r['unit']} against {r['baseline']} is no finite ratio")
        elif r["name"].endswith(PEAK) and r["ratio"] > 1.0:
            complaints.append(
                f"{where}: {r['value']:.2f} {r['unit']} is {r['ratio']:.2f} times the peak of this processor, "
                f"{r['baseline']:.2f} {r['unit']}: the count of operations, the time or the peak is wrong"
            )
    return complaints


COLUMNS = "{:44s} {:34s} {:>5s} {:>10s} {:21s} {:>10s} {:>7s}"


def line(r: Row) -> str:
    """Line of the table for a row.

    Args:
        r: row.

    Returns:
        Text in columns.
    """
    numbers = f"{r['value']:.2f}", r["unit"], f"{r['baseline']:.2f}", f"{r['ratio']:.2f}"
    return COLUMNS.format(r["name"], r["cell"], str(r["ranks"]), *numbers).rstrip()


def measure(jobs: Sequence[Job], console: Console | None = None, seconds: dict[str, float] | None = None) -> list[Row]:
    """Run the jobs one after another and print the rows of each when it ends, above a progress bar.

    Args:
        jobs: a text and a function that returns rows, for each job.
        console: console to print to; None for standard output.
        seconds: what each job took by the clock on the wall is added, by its text [s].

    Returns:
        All rows.
    """
    console = console or Console(soft_wrap=True)
    rows: list[Row] = []
    columns = (BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), TextColumn("{task.description}"))
    with Progress(*columns, console=console, transient=True, disable=not progress_is_shown()) as progress:
        task = progress.add_task("", total=len(jobs))

        def say(text: str, **style: Any) -> None:
            progress.console.print(text, markup=False, highlight=False, soft_wrap=True, **style)

        say(COLUMNS.format("name", "cell", "ranks", "value", "unit", "baseline", "ratio"), style="bold")
        for what, work in jobs:
            progress.update(task, description=what)
            begin = time.monotonic()
            for r in work():
                rows.append(r)
                say(line(r), style="red" if impossible([r]) else None)
            if seconds is not None:
                seconds[what] = time.monotonic() - begin
            progress.advance(task)
    return rows
