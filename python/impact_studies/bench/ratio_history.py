# SPDX-License-Identifier: MIT
"""Ratios of the benchmark over time: one line per row and run in a file of comma-separated values, which only grows."""

import csv
import datetime
from collections.abc import Iterable, Mapping
from pathlib import Path

from .rows import Row

COLUMNS = ("date", "commit", "processor", "load", "name", "cell", "ranks", "ratio", "value", "unit", "baseline")


def append(path: Path, rows: Iterable[Row], machine: Mapping[str, object], commit: str) -> None:
    """Append the rows of a run to a file, which is made if it does not exist.

    Args:
        path: the file.
        rows: rows of the run.
        machine: description of the machine by name; `processor` and `load` are written.
        commit: commit that was measured, as git names it, with the words "(changed)" if files differed from it.

    Raises:
        ValueError: the file has other columns; nothing is written.
        OSError: the file cannot be written.
    """
    fresh = not path.exists()
    if not fresh:
        read(path)
    date = datetime.datetime.now(datetime.timezone.utc).strftime("%Y-%m-%dT%H:%MZ")
    about = {"date": date, "commit": commit, "processor": machine["processor"], "load": f"{machine['load']:.1f}"}
    with open(path, "a", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        if fresh:
            writer.writeheader()
        for r in rows:
            numbers = {"ratio": f"{r['ratio']:.4g}", "value": f"{r['value']:.4g}", "baseline": f"{r['baseline']:.4g}"}
            writer.writerow({**r, **about, **numbers})


def read(path: Path) -> list[dict[str, str]]:
    """Read all lines of a file.

    Args:
        path: the file.

    Returns:
        Texts by column, for each line.

    Raises:
        ValueError: the file has other columns.
    """
    with open(path, newline="") as file:
        reader = csv.DictReader(file)
        if tuple(reader.fieldnames or ()) != COLUMNS:
            raise ValueError(f"{path} has the columns {reader.fieldnames}, not {list(COLUMNS)}: give another file")
        return list(reader)


def by_row(lines: Iterable[Mapping[str, str]]) -> dict[tuple[str, str], list[tuple[str, float]]]:
    """Ratios of each row over runs.

    Args:
        lines: lines of a file, all of one processor.

    Returns:
        Commit and ratio of each run in their order, by name and cell (with the number of ranks, if there are several).
    """
    out: dict[tuple[str, str], list[tuple[str, float]]] = {}
    for line in lines:
        ranks = "" if line["ranks"] == "1" else f", {line['ranks']} ranks"
        out.setdefault((line["name"], line["cell"] + ranks), []).append((line["commit"], float(line["ratio"])))
    return out
