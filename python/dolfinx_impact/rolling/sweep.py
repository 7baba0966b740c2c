# SPDX-License-Identifier: MIT
"""Creep curves: steady states for a sequence of creepages, each found from the one before."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from mpi4py import MPI

from .. import _cpp
from ..common.types import FilePath, FloatArray
from ..common.collective import agree, attempt
from ..common.progress_bar import ProgressBar
from ..io import hdf5
from ..io.given_arguments import SUMS, Table

if TYPE_CHECKING:
    from .sweep_state import SweepState

INPUTS = ("creep", "lateral", "spin")
UNITS = {"creep": "1", "lateral": "1", "spin": "1/L", "force": "F", "torque": "F L", "omega": "1/T"}


SAME = 1e-6  # relative difference of rates of one problem: a spin that was found has the solver's accuracy
SUM = 1e-9  # relative difference of sums over nodes: round-off is less, another mesh differs by more
STATE = ("state/values", "state/totals")
OWN = "identity of "  # beginning of the names of entries that the caller states


@dataclass
class Fingerprint:
    """What tells the points of one problem from those of another.

    Attributes:
        arguments: what the problem was made of, by name; see io.given_arguments.
        rates: rates of the motions at the beginning of the sweep.
    """

    arguments: Table
    rates: FloatArray

    def difference(self, arguments: Mapping[str, Any], rates: FloatArray) -> str:
        """What tells another problem first, as "friction differs"; an empty text: it is the same.

        Args:
            arguments: of the other problem.
            rates: of the other problem.
        """
        for name in dict.fromkeys([*self.arguments, *arguments]):
            here, there = (of.get(name) for of in (self.arguments, arguments))
            same = isinstance(here, str | int) and isinstance(there, str | int | np.integer) and here == there
            if isinstance(here, np.ndarray) and isinstance(there, np.ndarray) and here.shape == there.shape:
                same = bool(np.all(np.abs(here - there) <= SUM * np.abs(here).max(initial=0.0)))
            if not same:
                stated = here is not None and there is not None
                return f"{name.removeprefix(SUMS).removeprefix(OWN)} {'differs' if stated else 'is known of one alone'}"
        same = self.rates.shape == rates.shape and np.allclose(self.rates, rates, rtol=SAME, atol=0.0)
        return "" if same else "motions differ"


def stated(identity: Any) -> dict[str, str]:
    """Entries of a fingerprint for what the caller states.

    Args:
        identity: numbers and texts by name, or None.

    Returns:
        Texts by name; those of numbers have all digits.

    Raises:
        TypeError: it is no such table.
    """
    if identity is None:
        return {}
    if not isinstance(identity, Mapping):
        raise TypeError(f"identity must be a dict of numbers and texts by name, found {type(identity).__name__}")
    for name, value in identity.items():
        if not isinstance(name, str) or not isinstance(value, str | bool | int | float | np.number):
            raise TypeError(f"identity must have numbers and texts by name, found {name!r}: {value!r:.60}")
    values = {name: value.item() if isinstance(value, np.number) else value for name, value in identity.items()}
    return {f"{OWN}{name}": repr(value) for name, value in values.items()}


def creepages(creep: Any, lateral: Any, spin: Any) -> dict[str, FloatArray]:
    """The sequences of a sweep, of equal length.

    Args:
        creep: numbers, a number, or None.
        lateral: numbers, a number, or None.
        spin: numbers, a number, or None.

    Raises:
        TypeError: a sequence is not made of numbers.
        ValueError: numbers that are not finite, no sequence at all, or sequences of different lengths.
    """
    given = {name: values for name, values in zip(INPUTS, (creep, lateral, spin)) if values is not None}
    if not given:
        raise ValueError("give at least one of creep, lateral and spin")
    arrays = {}
    for name, values in given.items():
        try:
            arrays[name] = np.atleast_1d(np.asarray(values, dtype=float))
        except (TypeError, ValueError):
            raise TypeError(f"{name} must be numbers, found {values!r:.60}") from None
        if arrays[name].ndim != 1 or not len(arrays[name]) or not np.all(np.isfinite(arrays[name])):
            raise ValueError(f"{name} must be a sequence of finite numbers, found {values!r:.60}")
    lengths = {len(a) for a in arrays.values()} - {1}
    if len(lengths) > 1:
        raise ValueError(f"creepages have different lengths: {', '.join(f'{k} {len(a)}' for k, a in arrays.items())}")
    count = max(lengths, default=1)
    return {name: np.broadcast_to(arrays.get(name, np.zeros(1)), count).copy() for name in INPUTS}


def read(
    path: FilePath, points: dict[str, FloatArray], problem: Fingerprint, state: SweepState
) -> tuple[list[dict[str, Any]], tuple[FloatArray, FloatArray] | None]:
    """Rows of a file that an earlier sweep over the same points has written, and the state at the last of them.

    Args:
        path: the file; there may be none.
        points: creepages of this sweep.
        problem: what the points belong to.
        state: state of the problem.

    Raises:
        OSError: the file cannot be read.
        Damaged: the file is not as it was written.
        ValueError: the file belongs to another sweep.
    """
    import h5py

    if not Path(path).exists():
        return [], None
    _cpp.files.SealedFile(str(path))
    with h5py.File(path, "r") as file:
        if set(file) != {*UNITS, "state"} or any(name not in file for name in STATE):
            raise ValueError(f"{path} is no file of a sweep")
        found = {name: np.asarray(file[name][:]) for name in UNITS}
        values, totals = (np.asarray(file[name][:]) for name in STATE)
        attributes = dict(file.attrs)
    rates = np.asarray(attributes.pop("rates", np.zeros(0)))
    other = problem.difference(attributes, rates)
    if other:
        raise ValueError(f"{path} has the sweep of another problem, {other}: remove it, or give another name")
    num, force = len(found["creep"]), len(np.atleast_1d(found["force"][0])) if len(found["force"]) else 0
    shapes = {name: (num, force) if name == "force" else (num,) for name in UNITS}
    whole = all(found[name].shape == shape and np.all(np.isfinite(found[name])) for name, shape in shapes.items())
    if not whole or values.shape != state.shape or totals.shape != (state.num_totals,):
        raise _cpp.files.Damaged("its tables are not those of a sweep")
    if num > len(points["creep"]) or any(np.any(found[name] != points[name][:num]) for name in INPUTS):
        raise ValueError(f"{path} has a sweep over other creepages: remove it, or give another name")
    return [{name: found[name][k] for name in UNITS} for k in range(num)], (values, totals)


def write(
    path: FilePath, rows: list[dict[str, Any]], problem: Fingerprint, state: tuple[FloatArray, FloatArray]
) -> None:
    """Write rows to a sealed HDF5 file, with units; the former file stays until the new one is complete.

    Args:
        path: the file.
        rows: one dict per point.
        problem: what the points belong to.
        state: state at the last point, as SweepState.read returned it.
    """

    def fill(file: Any) -> None:
        for name, unit in UNITS.items():
            file[name] = np.array([row[name] for row in rows])
            file[name].attrs["unit"] = unit
        for name, values in zip(STATE, state):
            file[name] = values
        for name, value in {**problem.arguments, "rates": problem.rates}.items():
            file.attrs[name] = value

    hdf5.create(path, fill, sealed=True)


def run(
    comm: MPI.Comm,
    points: dict[str, FloatArray],
    solve: Callable[[float, float, float], dict[str, Any]],
    file: FilePath | None,
    progress: bool,
    problem: Fingerprint,
    state: SweepState,
    begin_from: Callable[[dict[str, Any], tuple[FloatArray, FloatArray]], None],
) -> dict[str, FloatArray]:
    """Solve for all points. Collective.

    Args:
        comm: communicator of the problem.
        points: creepages.
        solve: of creep, lateral and spin; returns the results by name.
        file: HDF5 file that is written after each point, and whose points are not solved again; or None.
        progress: show a bar on rank 0.
        problem: what the points belong to.
        state: state of the problem.
        begin_from: function that brings the problem to a row of the file with its state.

    Raises:
        RuntimeError: the file cannot be read, is damaged, or cannot be written; on all ranks.
        ValueError: the file belongs to another sweep; on all ranks.
    """
    rows: list[dict[str, Any]] = []
    if file is not None:
        found, error = attempt(read, file, points, problem, state) if comm.rank == 0 else (None, None)
        if error is not None and not isinstance(error, ValueError):
            error = RuntimeError(f"{file} cannot be read ({error}): remove it, or give another name")
        agree(comm, error, "RollingProblem.sweep")
        rows, last = comm.bcast(found)
        if last is not None:
            begin_from(rows[-1], last)
    total = len(points["creep"])
    with ProgressBar(comm, progress, total, counted=True) as bar:
        for k in range(len(rows), total):
            here = tuple(float(points[name][k]) for name in INPUTS)
            bar.show(k, lambda: f"creep {here[0]:.3g}, lateral {here[1]:.3g}, spin {here[2]:.3g}")
            rows.append({**dict(zip(INPUTS, here)), **solve(*here)})
            if file is not None:
                now, fault = state.read(), None
                if now is not None:
                    fault = attempt(write, file, rows, problem, now)[1]
                if isinstance(fault, OSError):
                    fault = RuntimeError(f"{file} cannot be written: {fault}")
                agree(comm, fault, "RollingProblem.sweep")
        bar.show(total, str)
    return {name: np.array([row[name] for row in rows]) for name in UNITS}
