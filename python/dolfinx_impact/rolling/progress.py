# SPDX-License-Identifier: MIT
"""Progress bar of a sequence of steady states."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from mpi4py import MPI


@contextmanager
def progress_bar(comm: MPI.Comm, wanted: bool, total: int) -> Iterator[Callable[[int, str], None]]:
    """A bar on rank 0, in a `with` block.

    Args:
        comm: communicator.
        wanted: whether there is one.
        total: number of states.

    Yields:
        A function of the number of states that are done and of a text, called before each state and at the end.
    """
    if not wanted or comm.rank != 0:
        yield lambda done, text: None
        return
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    with Progress(TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn()) as bar:
        task = bar.add_task("", total=total)
        yield lambda done, text: bar.update(task, completed=done, description=text)
