# SPDX-License-Identifier: MIT
"""Guards of public calls on the ranks of COMM_WORLD: errors of one rank, values that differ; see on_ranks.py."""

import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI

from dolfinx_impact.common.collective import agree, attempt, channel, comm_of, describe, guard, same

COMM = MPI.COMM_WORLD
LAST = COMM.size - 1
SEVERAL = COMM.size > 1


class Odd(Exception):
    """An error that a text alone does not make."""

    def __init__(self, a, b):
        super().__init__(f"{a} and {b}")


def check_error_of_one_rank_is_raised_on_all():
    for kind, found in ((ValueError, ValueError), (KeyError, KeyError), (FileNotFoundError, FileNotFoundError),
                        (KeyboardInterrupt, KeyboardInterrupt), (ZeroDivisionError, ZeroDivisionError)):  # fmt: skip
        with pytest.raises(found, match=f"rank {LAST} of {COMM.size}: .*no good" if SEVERAL else "no good"):
            with guard(COMM, "call"):
                if COMM.rank == LAST:
                    raise kind("no good")


def check_error_that_takes_more_than_a_text():
    with pytest.raises(Exception, match="1 and 2") as e:
        with guard(COMM, "call"):
            if COMM.rank == LAST:
                raise Odd(1, 2)
    assert type(e.value) is (Exception if SEVERAL else Odd)


def check_class_that_pickle_cannot_name():
    class Local(ValueError):
        pass

    with pytest.raises(ValueError, match="inside"):
        with guard(COMM, "call"):
            if COMM.rank == LAST:
                raise Local("inside")


def check_lowest_rank_is_named_and_others_counted():
    with pytest.raises(ValueError, match="value 0") as e:
        with guard(COMM, "call"):
            raise ValueError(f"value {COMM.rank}")
    if SEVERAL:
        assert str(e.value) == f"rank 0 of {COMM.size}: value 0 (and {LAST} more ranks failed)"


def check_same_error_on_all_ranks_names_none():
    error = ValueError("the same")
    with pytest.raises(ValueError) as e:
        with guard(COMM, "call"):
            raise error
    assert e.value is error


def check_values_that_differ():
    same(COMM, "call", a=1, b=None, c="x", d=np.arange(40.0), e=[1, (2, 3)], f=len)
    if not SEVERAL:
        return
    with pytest.raises(ValueError, match=f"advance: dt differs between the ranks: 1 on rank 0, {LAST + 1} on rank"):
        same(COMM, "advance", until=2.0, dt=1.0 if COMM.rank == 0 else LAST + 1.0)
    with pytest.raises(ValueError, match="callback differs.*None on rank 0, a function on rank"):
        same(COMM, "advance", callback=None if COMM.rank == 0 else len)
    with pytest.raises(ValueError, match=r"values differs .*\[\.\.\.\]|values differs .*\.\.\."):
        same(COMM, "call", values=list(range(200)) + [COMM.rank])
    with pytest.raises(ValueError, match="more differs between the ranks: not given on rank 0, 1 on rank"):
        same(COMM, "call", **({"more": 1} if COMM.rank == LAST else {}))


def check_different_calls():
    if SEVERAL:
        with pytest.raises(ValueError, match=f"different calls: save on rank 0, advance on rank {LAST}"):
            same(COMM, "advance" if COMM.rank == LAST else "save")


def check_values_given_inside():
    with guard(COMM, "call") as g:
        g.same(steps=3)
    if SEVERAL:
        with pytest.raises(ValueError, match="steps differs"):
            with guard(COMM, "call") as g:
                g.same(steps=COMM.rank)


def check_agree_passes_errors_of_functions():
    assert attempt(divmod, 7, 2) == ((3, 1), None)
    agree(COMM, None)
    _, error = attempt(lambda: 1 / 0 if COMM.rank == LAST else 1)
    with pytest.raises(ZeroDivisionError, match="division by zero"):
        agree(COMM, error, "advance")


def check_one_rank_alone_needs_no_other():
    """Problems on COMM_SELF in a run of several ranks."""
    with guard(MPI.COMM_SELF, f"call {COMM.rank}", value=COMM.rank):
        pass
    if COMM.rank == LAST:
        with pytest.raises(ValueError, match="^alone$"):
            with guard(MPI.COMM_SELF, "call"):
                raise ValueError("alone")


def check_communicators_that_have_all_ranks_meet():
    """A rank that knows another communicator than the others, of the same ranks."""
    mine = COMM.Dup()
    with pytest.raises(TypeError, match="u is None"):
        with guard(mine if COMM.rank == LAST else COMM, "call"):
            if COMM.rank == LAST:
                raise TypeError("u is None")
    assert channel(MPI.COMM_SELF) == MPI.COMM_SELF
    mine.Free()


def check_part_of_the_ranks():
    part = COMM.Split(int(COMM.rank == LAST))
    if COMM.rank != LAST:
        with pytest.raises(ValueError, match="of the part"):
            with guard(part, "call"):
                if part.rank == part.size - 1:
                    raise ValueError("of the part")
    part.Free()


def check_communicator_is_found():
    domain = mesh.create_unit_square(COMM, 2, 2)
    V = fem.functionspace(domain, ("Lagrange", 1, (2,)))
    u = fem.Function(V)
    bc = fem.dirichletbc(np.zeros(2), np.zeros(0, dtype=np.int32), V)
    tags = mesh.meshtags(domain, 1, np.zeros(0, dtype=np.int32), np.zeros(0, dtype=np.int32))
    form = ufl.inner(u, ufl.TestFunction(V)) * ufl.dx
    for thing in (u, V, domain, bc, [bc], tags, form, {"a": tags}):
        found = comm_of(None, "text", 3.0, thing)
        assert found != MPI.COMM_WORLD and found.size == COMM.size, thing
    assert comm_of(None, [], int) is None


def check_rank_without_communicator_meets_the_others():
    with pytest.raises(TypeError, match="u is None"):
        with guard(comm_of(None) if COMM.rank == LAST else COMM, "call"):
            if COMM.rank == LAST:
                raise TypeError("u is None")


def check_descriptions():
    domain = mesh.create_unit_square(MPI.COMM_SELF, 1, 1)
    V = fem.functionspace(domain, ("Lagrange", 1))
    for _ in range(COMM.rank):  # other numbers of objects on each rank
        fem.Function(V)
    u, v = fem.Function(V), ufl.TestFunction(V)
    same(COMM, "call", form=u * v * ufl.dx, u=u, mesh=domain)
    assert describe(1) == describe(1.0) == describe(np.float32(1)) == describe(np.array(1))
    assert describe(True) != describe(1) and describe(1e300) == "1e+300" and describe(float("nan")) == "nan"
    assert describe(u * v * ufl.dx) != describe(2 * u * v * ufl.dx)
    assert describe(np.arange(40)) != describe(np.arange(1, 41))
    assert describe({"a": [1, None]}) == "{'a': [1, None]}"
