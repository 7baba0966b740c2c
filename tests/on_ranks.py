# SPDX-License-Identifier: MIT
"""The same checks in the test's own process and on several ranks: a module's functions check_*.

As a script, on_ranks.py MODULE.py runs them on the ranks of COMM_WORLD and prints "passed: NAME" on rank 0 after each.
"""

import pathlib
import runpy
import sys

import pytest
from mpi4py import MPI


def checks_of(names):
    """name -> function, of a module's names; those that it imports do not count."""
    own = {k: f for k, f in names.items() if k.startswith("check_") and f.__code__.co_filename == names["__file__"]}
    return {name.removeprefix("check_"): f for name, f in own.items()}


def rank_tests(module, ranks=(2, 3), timeout=300):
    """Tests of a module of checks: `test_one_rank, test_several_ranks = rank_tests(module)`.

    Args:
        module: with functions check_* without arguments. ranks: numbers of ranks. timeout: of a run on several [s].
    """
    checks = checks_of(vars(module))

    @pytest.mark.parametrize("name", checks)
    def test_one_rank(name):
        checks[name]()

    @pytest.mark.mpi
    @pytest.mark.parametrize("ranks", ranks)
    def test_several_ranks(mpirun, ranks):
        output = mpirun(ranks, pathlib.Path(__file__), module.__file__, timeout=timeout)
        assert [line[8:] for line in output.splitlines() if line.startswith("passed: ")] == list(checks)

    return test_one_rank, test_several_ranks


def main(path):
    """Run the checks of a module on the ranks."""
    sys.path.insert(0, str(pathlib.Path(path).parent))
    for name, check in checks_of(runpy.run_path(path)).items():
        check()
        MPI.COMM_WORLD.barrier()
        if MPI.COMM_WORLD.rank == 0:
            print(f"passed: {name}", flush=True)


if __name__ == "__main__":
    main(sys.argv[1])
