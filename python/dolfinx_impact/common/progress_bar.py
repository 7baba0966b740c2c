# SPDX-License-Identifier: MIT
"""Progress of work on rank 0: a bar on a terminal and in a notebook, lines elsewhere."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import TracebackType
from typing import TYPE_CHECKING, TypeVar

from mpi4py import MPI

from .messages import progress_is_shown
from .progress_lines import ProgressLines
from .terminal import console

if TYPE_CHECKING:
    import rich.progress

Bar = TypeVar("Bar", bound="ProgressBar")


class ProgressBar:
    """Progress bar with a text before it, one after it and the remaining time, on rank 0 only.

    In a file the bar would be hundreds of lines: there some lines are written instead, the first after some seconds,
    later ones less and less often. Nothing is shown where the level of DOLFINx's log is ERROR or higher. Use it as a
    context manager around the work.

    Args:
        comm: communicator of the work.
        wanted: whether progress is shown at all.
        total: amount of work, in any unit.
        text: what stands before the bar at the start.
        counted: whether work is counted: "3/7" is shown.
    """

    def __init__(self, comm: MPI.Comm, wanted: bool, total: float, text: str = "", counted: bool = False) -> None:
        self._bar: rich.progress.Progress | None = None
        self._lines: ProgressLines | None = None
        self._total, self._counted = total, counted
        if not wanted or comm.rank != 0 or not progress_is_shown():
            return
        from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

        self._console = console()
        if self._console.is_terminal or self._console.is_jupyter:
            columns = [TextColumn("{task.description}", markup=False), BarColumn()]
            columns += [MofNCompleteColumn()] if counted else []
            columns += [TextColumn("{task.fields[after]}", markup=False), TimeRemainingColumn()]
            self._bar = Progress(*columns, console=self._console)
            self._task = self._bar.add_task(text, total=total, after="")
        else:
            self._lines = ProgressLines()

    def __enter__(self: Bar) -> Bar:
        if self._bar:
            self._bar.start()
        return self

    def show(self, completed: float, text: Callable[[], str], after: Callable[[], str] = str) -> None:
        """Show how far the work is.

        Args:
            completed: amount of work that is done, in the unit of `total`.
            text: makes the text before the bar; called only where it is shown.
            after: makes the text after the bar; called only where it is shown.
        """
        if self._bar:
            self._bar.update(self._task, completed=completed, description=text(), after=after())
        elif self._lines:
            seconds = self._lines.due()
            if seconds is not None:
                share = completed / self._total if self._total > 0 else 1.0
                done = f"{completed:.0f} of {self._total:.0f}" if self._counted else f"{share:.0%}"
                words = [part for part in (text(), after(), f"{seconds:.0f} s") if part]
                print(f"{done}: {', '.join(words)}", flush=True)

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._bar:
            self._bar.stop()


@contextmanager
def transient_bar(wanted: bool, stderr: bool = False) -> Iterator[rich.progress.Progress]:
    """Bar of rich that is removed when its work ends, and of which a file gets nothing.

    Args:
        wanted: whether it is shown at all.
        stderr: show it on standard error, not on standard output.

    Yields:
        The bar, for tasks; it takes them also where it is not shown.
    """
    from rich.progress import Progress

    where = console(stderr)
    bar = Progress(disable=not (wanted and progress_is_shown()), transient=True, console=where)
    if bar.disable or not (where.is_terminal or where.is_jupyter):  # a bar that ends writes an empty line into a file
        yield bar
        return
    with bar:
        yield bar
