# SPDX-License-Identifier: MIT
"""One suite shared by several pytest processes: `pytest --share FOLDER`, each with the same folder and arguments.

A process takes the next part that nobody has taken, until none is left: no list says which tests are whose, a new
module is shared as well, and the processes end together whatever the parts take. A part is a module. Three kinds of
tests wait until every process has run its share:

- those on the ranks of a group, in one process. They start once and wait for each other in busy loops, so that beside
  other work everything takes several times as long;
- modules marked `waits`, in the other processes at the same time: their tests sleep most of the time;
- those marked `alone`, which need the machine for themselves, in the end.
"""

import fcntl
import itertools
import pathlib

RANKS, WAITS, ALONE = "ranks", "waits", "alone"


def part_of(item):
    """Name of the part that a test belongs to, and when its time comes: "" at once, then RANKS, WAITS, ALONE."""
    if item.get_closest_marker("alone"):
        return ALONE, ALONE
    if "rank_group" in item.fixturenames:
        return RANKS, RANKS
    return item.nodeid.partition("::")[0], WAITS if item.get_closest_marker("waits") else ""


def parts_of(items):
    """When -> name -> tests, in the order in which parts are taken."""
    parts = {"": {}, RANKS: {}, WAITS: {}, ALONE: {}}
    # Unit tests last: with short modules at the end the processes end together.
    for item in sorted(items, key=lambda item: "unit" in pathlib.PurePath(item.nodeid.partition("::")[0]).parts):
        name, when = part_of(item)
        parts[when].setdefault(name, []).append(item)
    return parts


class Share:
    """What the processes with one folder tell each other.

    A part is taken by the process that makes the file of its name. For each stage before the last one, a process keeps
    a lock that all may have until it has done its share; the system gives back those of a process that died.
    """

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        self.folder.mkdir(parents=True, exist_ok=True)
        self._locks = [open(self.folder / f"at work, stage {stage}", "w") for stage in range(2)]
        for lock in self._locks:
            fcntl.flock(lock, fcntl.LOCK_SH)

    def take(self, name):
        """Whether nobody had taken this part: it is this process's now."""
        try:
            (self.folder / name.replace("/", "|")).touch(exist_ok=False)
        except FileExistsError:
            return False
        return True

    def wait_for_the_others(self):
        """Until every other process has done its share of the present stage, or has ended."""
        with self._locks.pop(0) as lock:
            fcntl.flock(lock, fcntl.LOCK_UN)
            fcntl.flock(lock, fcntl.LOCK_EX)  # and back with the end of the file's use: the next one goes on as well


def run(session, folder):
    """Run this process's share of the tests that were collected."""
    share, parts = Share(folder), parts_of(session.items)
    for stage in (parts[""], parts[RANKS] | parts[WAITS], parts[ALONE]):
        _run(session, itertools.chain.from_iterable(tests for name, tests in stage.items() if share.take(name)))
        if stage is not parts[ALONE]:
            share.wait_for_the_others()


def _run(session, items):
    """As pytest's own loop. The next test is taken before the present one is run: it tells which fixtures end."""
    item = next(items, None)
    while item is not None:
        following = next(items, None)
        item.config.hook.pytest_runtest_protocol(item=item, nextitem=following)
        if session.shouldfail:
            raise session.Failed(session.shouldfail)
        if session.shouldstop:
            raise session.Interrupted(session.shouldstop)
        item = following
