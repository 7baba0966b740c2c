# SPDX-License-Identifier: MIT
"""One suite shared by several pytest processes: `pytest --share FOLDER`, each with the same folder and arguments.

A process takes the next part that nobody has taken, until none is left: no list says which tests are whose, a new
module is shared as well, and the processes end together whatever the parts take. A part is a module. Tests that need
the machine for themselves come last, in the process that is the last one: those on the ranks of a group, which start
once and wait for each other in busy loops, so that beside other work everything takes several times as long; and those
marked `alone`.
"""

import fcntl
import itertools
import pathlib

RANKS, ALONE = "ranks", "alone"


def part_of(item):
    """Name of the part that a test belongs to."""
    if item.get_closest_marker("alone"):
        return ALONE
    return RANKS if "rank_group" in item.fixturenames else item.nodeid.partition("::")[0]


def parts_of(items):
    """Name -> tests, in the order in which parts are taken."""
    parts = {}
    for item in items:
        parts.setdefault(part_of(item), []).append(item)
    return parts


class Share:
    """What the processes with one folder tell each other.

    A part is taken by the process that makes the file of its name. Each process keeps a lock that all may have while it
    works; the system gives back that of a process that died.
    """

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        self.folder.mkdir(parents=True, exist_ok=True)
        self._lock = open(self.folder / "at work", "w")
        fcntl.flock(self._lock, fcntl.LOCK_SH)

    def take(self, name):
        """Whether nobody had taken this part: it is this process's now."""
        try:
            (self.folder / name.replace("/", "|")).touch(exist_ok=False)
        except FileExistsError:
            return False
        return True

    def wait_for_the_others(self):
        """Until every other process has run its last part, or has ended; then whoever came first goes on alone."""
        fcntl.flock(self._lock, fcntl.LOCK_UN)
        fcntl.flock(self._lock, fcntl.LOCK_EX)


def run(session, folder):
    """Run this process's share of the tests that were collected."""
    share, parts = Share(folder), parts_of(session.items)
    alone = parts.pop(RANKS, []) + parts.pop(ALONE, [])
    _run(session, itertools.chain.from_iterable(tests for name, tests in parts.items() if share.take(name)))
    share.wait_for_the_others()
    if alone and share.take(ALONE):
        _run(session, iter(alone))


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
