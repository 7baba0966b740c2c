# SPDX-License-Identifier: MIT
"""One rank's error becomes an error on all ranks, and arguments are the same on all ranks.

A rank that raises while the others wait for it in an exchange leaves them waiting for ever. Every public call that
communicates therefore checks its arguments under a guard, before it communicates:

    with guard(comm, "advance", until=until, dt=dt):  # values that must be the same on all ranks
        ...                                           # checks of this rank: they may raise, they do not communicate

At its end the guard makes one reduction of three integers. It raises on all ranks if a check raised on any rank, if a
value differs between ranks, or if the ranks are in different calls. Only then the ranks exchange texts. On a
communicator of one rank nothing is exchanged: errors pass through as they are, whatever they are.

`agree` is the same for an error that was caught, for loops that let a user's function run: one reduction per pass.
`comm_of` finds a communicator when the argument that should have it is wrong. This module needs nothing else of the
package.
"""

import hashlib
import os
import pickle
import time

import numpy as np
from mpi4py import MPI

SHOWN = 200  # characters of a value in an error
FEW = 16  # entries of an array that is shown, not hashed
PATIENCE = 20.0  # s that a rank waits for the others where it does not know whether they are in the call

_world = None  # a duplicate of COMM_WORLD, so that no message of others meets ours


def channel(comm):
    """Communicator that guards exchange over: one for all communicators that have all ranks.

    DOLFINx gives each mesh, and what belongs to it, a communicator of its own. A rank whose argument is wrong may know
    another of them than the other ranks do, or none; if all ranks of the run take part, they meet all the same.
    Collective where the run has several ranks and `comm` has all of them.
    """
    global _world
    if comm.size == 1 or comm.size < MPI.COMM_WORLD.size:
        return comm
    if _world is None:
        _world = MPI.COMM_WORLD.Dup()
    return _world


def comm_of(*things):
    """Communicator of the first of some objects that has one: functions, spaces, meshes, tags, boundary conditions,
    forms, loads, contacts, lists of them. None if none has: then a guard takes COMM_WORLD, but waits for the other
    ranks for some seconds only, as this rank may be alone in the call."""
    return next((c for c in map(_comm, things) if c is not None), None)


def _comm(thing, depth=6):
    if thing is None or depth == 0 or isinstance(thing, (str, bytes, type)):
        return None
    if isinstance(thing, (list, tuple, dict)):
        parts = thing.values() if isinstance(thing, dict) else thing
        return next((c for c in (_comm(part, depth - 1) for part in parts) if c is not None), None)
    if isinstance(thing, MPI.Comm):
        return thing
    for name in ("comm", "mesh", "topology", "function_space", "facet_tags", "cell_tags", "pair", "bc", "space"):
        found = _comm(getattr(thing, name, None), depth - 1)
        if found is not None:
            return found
    for name in ("ufl_domain", "ufl_cargo"):  # UFL forms and domains know the mesh they were made for
        if callable(getattr(thing, name, None)):
            try:
                return _comm(getattr(thing, name)(), depth - 1)
            except Exception:  # a form of several domains has no one domain
                return None
    return None


class guard:
    """Checks of a public call, made on all ranks together; see the module's text.

    Args:
        comm: communicator of the call; what `comm_of` found.
        call: name of the call, for messages.
        values: arguments that must be the same on all ranks; see `describe`. More may be given by `same`.

    Raises:
        ValueError: a value that differs between ranks; different calls.
        Other errors: of the type that the lowest failing rank raised, on all ranks, with that rank in the text.
    """

    def __init__(self, comm, call, /, **values):
        self.comm, self.call, self._values = comm, call, values

    def same(self, **values):
        """More values that must be the same on all ranks; those that are known only after a check."""
        self._values.update(values)

    def __enter__(self):
        return self

    def __exit__(self, kind, error, trace):
        comm = MPI.COMM_WORLD if self.comm is None else self.comm
        if comm.size > 1:
            _exchange(channel(comm), self.call, error, self._values, alone=self.comm is None)
        return False  # on one rank the error goes on


def same(comm, call, /, **values):
    """Raise ValueError on all ranks unless each value is the same on all ranks. Collective, one reduction."""
    with guard(comm, call, **values):
        pass


def agree(comm, error, call=""):
    """Raise on all ranks if any rank has an error. Collective, one reduction.

    Args:
        comm: communicator.
        error: exception of this rank, or None.
        call: name, for messages.
    """
    if comm.size > 1:
        _exchange(channel(comm), call, error, {})
    elif error is not None:
        raise error


def attempt(work, *args):
    """(result, None) of a function, or (None, error) if it raises: for `agree`."""
    try:
        return work(*args), None
    except BaseException as error:  # interrupts as well: the other ranks must hear of it
        return None, error


def describe(value):
    """A text that is the same on two ranks if a value is: no addresses, no numbers of objects.

    Numbers count by value (1 is 1.0), arrays by shape and entries, lists, tuples and dicts by their parts, UFL forms by
    their signature, functions by being there, objects of this package by their public attributes. Objects may have a
    method `same_on_all_ranks` that returns a value that stands for them; others count by their type.
    """
    if hasattr(value, "same_on_all_ranks") and not isinstance(value, type):
        return f"{type(value).__name__} {describe(value.same_on_all_ranks())}"
    if isinstance(value, (np.generic, np.ndarray)) and np.ndim(value) == 0:
        value = value.item()
    if isinstance(value, int) and not isinstance(value, bool) and abs(value) < 2**53:
        value = float(value)
    if isinstance(value, float):
        return f"{value:.0f}" if value.is_integer() and abs(value) < 2**53 else repr(value)
    if value is None or isinstance(value, (bool, int, complex, str, bytes)):
        return repr(value)
    if isinstance(value, os.PathLike):
        return repr(os.fspath(value))
    if isinstance(value, np.ndarray):
        if value.size <= FEW:
            return describe(value.tolist())
        entries = repr(value.tolist()).encode() if value.dtype == object else np.ascontiguousarray(value).tobytes()
        return f"array of shape {value.shape}, sum {hashlib.sha256(entries).hexdigest()[:16]}"
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(describe(v) for v in value)}]"
    if isinstance(value, dict):
        return f"{{{', '.join(f'{describe(k)}: {describe(v)}' for k, v in value.items())}}}"
    if callable(getattr(value, "signature", None)) and hasattr(value, "integrals"):
        return f"form {value.signature()[:16]}"
    if isinstance(value, type):
        return f"class {value.__name__}"
    if type(value).__module__.split(".")[0] == __package__.split(".")[0]:
        return f"{type(value).__name__} {describe({k: v for k, v in vars(value).items() if k[0] != '_'})}"
    if callable(value):
        return "a function"
    return f"a {type(value).__name__}"


def _exchange(comm, call, error, values, alone=False):
    """Raise on all ranks if one has an error, or if calls or values differ. Collective.

    Args:
        alone: this rank may be alone in the call. If the others do not come it raises its own error.
    """
    texts = {}
    if error is None:
        texts, trouble = attempt(lambda: {name: describe(value) for name, value in values.items()})
        error, texts = trouble, texts or {}
    digest = hashlib.sha256(repr((call, texts)).encode()).digest()
    number = int.from_bytes(digest[:7], "big")
    state = np.array([error is not None, number, -number], dtype=np.int64)
    request = comm.Iallreduce(MPI.IN_PLACE, state, MPI.MAX)
    if alone and error is not None and not _arrives(request):
        raise error
    request.Wait()
    if state[0] == 0 and state[1] == -state[2]:
        return
    reports = comm.allgather((call, None if error is None else _packed(error), texts))
    failed = [(rank, e) for rank, (_, e, _) in enumerate(reports) if e is not None]
    if not failed:
        raise ValueError(_difference(reports))
    if error is not None and len(failed) == comm.size and len({e for _, e in failed}) == 1:
        raise error  # the same everywhere: no rank to name
    rank, (kind, text) = failed[0]
    others = f" (and {len(failed) - 1} more ranks failed)" if len(failed) > 1 else ""
    raise _error(kind, f"rank {rank} of {comm.size}: {text}{others}") from error


def _arrives(request):
    """Does a request complete before patience ends?"""
    end = time.monotonic() + PATIENCE
    while not request.Test():
        if time.monotonic() > end:
            return False
        time.sleep(1e-4)
    return True


def _packed(error):
    """Type and text of an error for other ranks. The type is the nearest that pickle can name."""
    text = str(error) or type(error).__name__
    for kind in type(error).__mro__:
        try:
            return pickle.dumps(kind), text
        except Exception:  # a class that was made in a function
            continue
    return pickle.dumps(RuntimeError), text


def _error(kind, text):
    """An error of a kind with a text, or of the nearest kind that takes a text alone."""
    try:
        kinds = pickle.loads(kind).__mro__
    except Exception:  # a class that this rank cannot import
        kinds = (RuntimeError,)
    for kind in kinds:
        try:
            return kind(text)
        except Exception:
            continue
    return RuntimeError(text)


def _difference(reports):
    """What differs between ranks, in a sentence. Args: of each rank, call, error and texts of its values."""
    first = reports[0]
    for rank, other in enumerate(reports):
        if other[0] != first[0]:
            return f"the ranks are in different calls: {first[0]} on rank 0, {other[0]} on rank {rank}"
        for name in {**first[2], **other[2]}:
            a, b = (report[2].get(name, "not given") for report in (first, other))
            if a != b:
                a, b = _parted(a, b)
                return (
                    f"{first[0]}: {name} differs between the ranks: {a} on rank 0, {b} on rank {rank}; give the same "
                    "on all ranks"
                )
    return "the ranks do not agree"  # texts are equal, so digests were: not reached


def _parted(a, b):
    """Two texts, cut to where they differ if they are long."""
    if max(len(a), len(b)) <= SHOWN:
        return a, b
    begin = max(0, len(os.path.commonprefix([a, b])) - SHOWN // 4)
    return tuple(("..." if begin else "") + t[begin : begin + SHOWN] + ("..." if len(t) > begin + SHOWN else "")
                 for t in (a, b))  # fmt: skip
