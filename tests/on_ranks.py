# SPDX-License-Identifier: MIT
"""The same checks in the test's own process and on several ranks: a module's functions check_*.

All checks of a session share one mpirun per number of ranks, rank_group.py: DOLFINx is imported and forms are compiled
once. Each check on each number of ranks is a test of its own.
"""

import itertools
import zlib

import pytest
import ufl
from mpi4py import MPI
from ufl.utils.counted import Counted

MOST = 3  # ranks in `make test`


def numbers_in_make_test(name, ranks):
    """On how many ranks `make test` runs a check: on one; one in eight, by its name, on the most, the others on the
    fewest.

    Three ranks take several times as long as two on two cores, as each waits in busy loops while another one works.
    """
    few = [n for n in ranks if n <= MOST] or [min(ranks)]
    return 1, few[0] if zlib.crc32(name.encode()) % 8 else few[-1]


def checks_of(names):
    """name -> function, of a module's names; those that it imports do not count."""
    own = {k: f for k, f in names.items() if k.startswith("check_") and f.__code__.co_filename == names["__file__"]}
    return {name.removeprefix("check_"): f for name, f in own.items()}


def rank_tests(module, ranks=(2, 3), timeout=300, in_make_test=None):
    """Tests of a module of checks: `test_one_rank, test_several_ranks = rank_tests(module)`.

    `make test` runs each check on one rank and on several (`numbers_in_make_test`). On the other numbers `make verify`
    runs them; they repeat what was checked, at a multiple of the cost on two cores.

    Args:
        module: with functions check_* without arguments.
        ranks: numbers of ranks.
        timeout: limit of each check on several ranks [s].
        in_make_test: numbers of ranks of checks that take too long for those of their turn, by name.
    """
    checks = checks_of(vars(module))
    assert checks, f"{module.__name__} has no function check_*"
    chosen = {name: numbers_in_make_test(name, ranks) for name in checks} | (in_make_test or {})
    assert set(chosen) == set(checks) and {1, *ranks}.issuperset(itertools.chain(*chosen.values()))

    @pytest.mark.long_rows(where=lambda name: 1 not in chosen[name])
    @pytest.mark.parametrize("name", checks)
    def test_one_rank(name):
        checks[name]()

    @pytest.mark.long_rows(where=lambda ranks, name: ranks not in chosen[name])
    @pytest.mark.parametrize("name", checks)
    @pytest.mark.parametrize("ranks", ranks)
    def test_several_ranks(rank_group, ranks, name):
        rank_group(ranks, timeout, module=module.__file__, check=f"check_{name}")

    return test_one_rank, test_several_ranks


def on_rank_0(comm, function):
    """function() on rank 0 alone, its result on all ranks. Collective.

    UFL numbers coefficients, constants and indices as they are made. A rank that has made more of them than the others
    may sort the terms of a form otherwise, and the form is then not the same on all ranks: the numbers are levelled.
    """
    found = comm.bcast(function() if comm.rank == 0 else None, root=0)
    classes = _counted_classes()
    here = {name: next(c._counter) for name, c in classes.items()}
    everywhere = comm.allgather(here)
    for name, c in classes.items():
        c._counter = itertools.count(max(numbers.get(name, 0) for numbers in everywhere))
    for c in (ufl.Mesh, ufl.MeshView):
        c._ufl_global_id = comm.allreduce(c._ufl_global_id, MPI.MAX)
    return found


def _counted_classes():
    """By name, UFL's classes whose objects are numbered."""
    found, todo = {}, [Counted]
    while todo:
        c = todo.pop()
        todo += c.__subclasses__()
        if c is not Counted and "_counter" in vars(c):
            found[f"{c.__module__}.{c.__qualname__}"] = c
    for c in found.values():
        c._counter = c._counter or itertools.count()
    return found
