# SPDX-License-Identifier: MIT
"""An error on one rank is raised on all ranks, and arguments are checked to be the same on all ranks.

If one rank raises while the others wait for it in an exchange, they wait for ever. Every public call that communicates
therefore checks its arguments under a guard before it communicates:

    with guard(comm, "advance", until=until, dt=dt):  # values that must be the same on all ranks
        ...                                           # checks of this rank; they may raise and do not communicate

At the end of the block the guard makes one reduction of three integers. It raises on all ranks if a check raised on any
rank, if a value differs between ranks, or if the ranks are in different calls. Texts are exchanged only in these cases.
On a communicator of one rank nothing is exchanged: errors pass through unchanged.

An exception that one rank alone raises inside an exchange leaves the others waiting there. Nothing that handles an
exception may communicate then: its rank must end, so that the launcher ends the others. Errors that all ranks raise
together are marked (`common`), and handlers ask for the mark (`is_common`) before they communicate.

`agree` does the same for an error that was caught; loops that call a user's function use it once per iteration.
`comm_of` finds a communicator in a list of arguments, some of which may be wrong. This module imports nothing else of
the package.
"""

import hashlib
import os
import pickle
import time
from collections.abc import Callable
from types import TracebackType
from typing import Any, Literal, TypeVar

import numpy as np
from mpi4py import MPI

SHOWN = 200  # characters of a value in an error
FEW = 16  # arrays of up to this many entries are shown, larger ones hashed
PATIENCE = 20.0  # s that a rank waits for the others if it does not know whether they are in the call

_world: MPI.Comm | None = None  # a duplicate of COMM_WORLD that separates these messages from all others
_Result = TypeVar("_Result")
_Error = TypeVar("_Error", bound=BaseException)
_COMMON = "_raised_on_all_ranks"  # attribute of exceptions that all ranks raise together
_Report = tuple[str, tuple[bytes, str] | None, dict[str, str]]  # of a rank: call, packed error, texts of its values


def channel(comm: MPI.Comm) -> MPI.Comm:
    """Communicator over which guards exchange: the same one for all communicators that contain all ranks.

    DOLFINx gives each mesh and its dependent objects a communicator of its own. A rank with a wrong argument may find
    another communicator than the other ranks, or none; on the common one their exchanges still match. Collective if the
    run has several ranks and `comm` contains all of them.

    Args:
        comm: communicator of a call.

    Returns:
        A duplicate of COMM_WORLD, or `comm` if it has one rank or not all ranks of the run.
    """
    global _world
    if comm.size == 1 or comm.size < MPI.COMM_WORLD.size:
        return comm
    if _world is None:
        _world = MPI.COMM_WORLD.Dup()
    return _world


def comm_of(*things: Any) -> MPI.Comm | None:
    """Communicator of the first argument that has one.

    Args:
        things: functions, spaces, meshes, tags, boundary conditions, forms, loads, contacts, or lists of them.

    Returns:
        The communicator, or None if no argument has one. For None a guard uses COMM_WORLD, but waits only some seconds
        for the other ranks, as this rank may be the only one in the call.
    """
    return next((c for c in map(_comm, things) if c is not None), None)


def _comm(thing: Any, depth: int = 6) -> MPI.Comm | None:
    """Communicator of one object, searched through its attributes down to a depth."""
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
    for name in ("ufl_domain", "ufl_cargo"):  # UFL forms and domains refer to their mesh
        if callable(getattr(thing, name, None)):
            try:
                return _comm(getattr(thing, name)(), depth - 1)
            except Exception:  # UFL raises for a form on several domains
                return None
    return None


class guard:
    """Context of the checks of a public call, made on all ranks together; see the docstring of the module.

    Args:
        comm: communicator of the call, as comm_of found it; None: none was found.
        call: name of the call, for messages.
        values: arguments that must be the same on all ranks, compared by `describe`; `same` adds further ones.

    Raises:
        ValueError: a value differs between ranks, or the ranks are in different calls.
        Exception: a check failed; the type is that of the lowest failing rank, on all ranks, with the rank in the text.
    """

    def __init__(self, comm: MPI.Comm | None, call: str, /, **values: Any) -> None:
        self.comm, self.call, self._values = comm, call, values

    def same(self, **values: Any) -> None:
        """Add values that must be the same on all ranks and are known only after a check.

        Args:
            values: the values by name.
        """
        self._values.update(values)

    def __enter__(self) -> "guard":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> Literal[False]:
        comm = MPI.COMM_WORLD if self.comm is None else self.comm
        if comm.size > 1:
            _exchange(channel(comm), self.call, error, self._values, alone=self.comm is None)
        return False  # on one rank the error propagates


def same(comm: MPI.Comm | None, call: str, /, **values: Any) -> None:
    """Check that values are the same on all ranks. Collective, one reduction.

    Args:
        comm: communicator of the call.
        call: name of the call, for messages.
        values: the values by name, compared by `describe`.

    Raises:
        ValueError: a value differs between ranks, or the ranks are in different calls; on all ranks.
    """
    with guard(comm, call, **values):
        pass


def agree(comm: MPI.Comm, error: BaseException | None, call: str = "") -> None:
    """Raise on all ranks if any rank has an error. Collective, one reduction.

    Args:
        comm: communicator of the call.
        error: exception of this rank, or None.
        call: name of the call, for messages.

    Raises:
        Exception: the error of the lowest failing rank.
    """
    if comm.size > 1:
        _exchange(channel(comm), call, error, {})
    elif error is not None:
        raise error


def common(error: _Error) -> _Error:
    """Mark an error that every rank raises at the same place, because all have found the same values.

    Args:
        error: exception that this rank is about to raise.

    Returns:
        The same exception.
    """
    vars(error)[_COMMON] = True
    return error


def is_common(comm: MPI.Comm, error: BaseException | None) -> bool:
    """Whether all ranks have raised an exception together, so that its handler may communicate.

    Args:
        comm: communicator of the handler.
        error: exception of this rank; None: there is none on any rank.

    Returns:
        True for one rank, for no error and for errors that guards, `agree` and `common` have marked.
    """
    return comm.size == 1 or error is None or _COMMON in vars(error)


def attempt(work: Callable[..., Any], *args: Any) -> tuple[Any, BaseException | None]:
    """Call a function and catch what it raises, for `agree`.

    Args:
        work: the function.
        args: its arguments.

    Returns:
        The result and None, or None and the exception.
    """
    try:
        return work(*args), None
    except BaseException as error:  # interrupts as well: the error must be raised on the other ranks too
        return None, error


def describe(value: Any) -> str:
    """Text that is equal on two ranks if a value is equal; it has no addresses and no numbers of objects.

    Numbers are compared by value (1 equals 1.0), arrays by shape and entries, lists, tuples and dicts by their items,
    UFL forms by their signature, objects of this package by their public attributes; all functions count as equal. An
    object may have a method `same_on_all_ranks` whose return value is compared in its place; others are compared by
    type.

    Args:
        value: the value.

    Returns:
        The text.
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
        # UFL sorts operands by printed numbers of objects ("10" before "9"), and ranks may have made other numbers of
        # objects before: form_signature renumbers them.
        from ..forms.compiler.frontend import form_signature

        return f"form {form_signature(value)[:16]}"
    if isinstance(value, type):
        return f"class {value.__name__}"
    if type(value).__module__.split(".")[0] == __name__.split(".")[0]:
        return f"{type(value).__name__} {describe({k: v for k, v in vars(value).items() if k[0] != '_'})}"
    if callable(value):
        return "a function"
    return f"a {type(value).__name__}"


def _exchange(
    comm: MPI.Comm, call: str, error: BaseException | None, values: dict[str, Any], alone: bool = False
) -> None:
    """Raise on all ranks if one has an error, or if calls or values differ. Collective.

    Args:
        comm: communicator of the call.
        call: name of the call.
        error: exception of this rank, or None.
        values: values that must be the same on all ranks, by name.
        alone: this rank may be the only one in the call; it raises its own error if the others do not respond.
    """
    texts: dict[str, str] = {}
    if error is None:
        described, error = attempt(lambda: {name: describe(value) for name, value in values.items()})
        texts = described or {}
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
        raise common(ValueError(_difference(reports)))
    if error is not None and len(failed) == comm.size and len({e for _, e in failed}) == 1:
        raise common(error)  # the same everywhere: no rank to name
    rank, (kind, text) = failed[0]
    others = f" (and {len(failed) - 1} more ranks failed)" if len(failed) > 1 else ""
    raise common(_error(kind, f"rank {rank} of {comm.size}: {text}{others}")) from error


def _arrives(request: MPI.Request) -> bool:
    """Whether a request completes within PATIENCE seconds."""
    end = time.monotonic() + PATIENCE
    while not request.Test():
        if time.monotonic() > end:
            return False
        time.sleep(1e-4)
    return True


def _packed(error: BaseException) -> tuple[bytes, str]:
    """Type and text of an error for other ranks. The type is the nearest base class that pickle can name."""
    text = str(error) or type(error).__name__
    for kind in type(error).__mro__:
        try:
            return pickle.dumps(kind), text
        except Exception:  # a class that was defined in a function
            continue
    return pickle.dumps(RuntimeError), text


def _error(packed: bytes, text: str) -> BaseException:
    """Exception of a packed type with a text, or of the nearest base class whose only argument is a text."""
    kinds: tuple[Any, ...]
    try:
        kinds = pickle.loads(packed).__mro__
    except Exception:  # a class that this rank cannot import
        kinds = (RuntimeError,)
    for kind in kinds:
        try:
            return kind(text)
        except Exception:
            continue
    return RuntimeError(text)


def _difference(reports: list[_Report]) -> str:
    """A sentence about the first difference between the reports of the ranks."""
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
    return "the ranks do not agree"  # not reached: equal texts have equal digests


def _parted(a: str, b: str) -> tuple[str, str]:
    """Two texts; long ones are cut to the part where they differ."""
    if max(len(a), len(b)) <= SHOWN:
        return a, b
    begin = max(0, len(os.path.commonprefix([a, b])) - SHOWN // 4)
    first, second = (("..." if begin else "") + t[begin : begin + SHOWN] + ("..." if len(t) > begin + SHOWN else "")
                     for t in (a, b))  # fmt: skip
    return first, second
