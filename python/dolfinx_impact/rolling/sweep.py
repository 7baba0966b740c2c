# SPDX-License-Identifier: MIT
"""Creep curves: steady states for a sequence of creepages, each found from the one before."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from mpi4py import MPI

from ..common.types import FilePath, FloatArray
from ..io import hdf5
from .progress import progress_bar

INPUTS = ("creep", "lateral", "spin")
UNITS = {"creep": "1", "lateral": "1", "spin": "1/L", "force": "F", "torque": "F L", "omega": "1/T"}


SAME = 1e-6  # relative difference of numbers of one problem: a spin that was found has the solver's accuracy


@dataclass
class Fingerprint:
    """What tells the points of one problem from those of another.

    Attributes:
        text: material, size, contacts.
        numbers: prescribed displacements, loads, rates.
    """

    text: str
    numbers: FloatArray

    def matches(self, other: Fingerprint) -> bool:
        """Is the other one of the same problem?"""
        if self.text != other.text or self.numbers.shape != other.numbers.shape:
            return False
        return bool(np.allclose(self.numbers, other.numbers, rtol=SAME, atol=0.0))


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


def read(path: FilePath, points: dict[str, FloatArray], problem: Fingerprint) -> list[dict[str, Any]]:
    """Rows of a file that an earlier sweep over the same points has written.

    Args:
        path: the file; there may be none.
        points: creepages of this sweep.
        problem: what the points belong to.

    Raises:
        ValueError: the file belongs to another sweep.
    """
    import h5py

    if not Path(path).exists():
        return []
    with h5py.File(path, "r") as file:
        found = {name: file[name][:] for name in UNITS if name in file}
        text, numbers = file.attrs.get("problem"), file.attrs.get("numbers")
    if text is None or numbers is None or set(found) != set(UNITS):
        raise ValueError(f"{path} is no file of a sweep")
    if not problem.matches(Fingerprint(str(text), np.asarray(numbers))):
        raise ValueError(f"{path} has the sweep of another problem: remove it, or give another name")
    num = len(found["creep"])
    if num > len(points["creep"]) or any(np.any(found[name] != points[name][:num]) for name in INPUTS):
        raise ValueError(f"{path} has a sweep over other creepages: remove it, or give another name")
    return [{name: found[name][k] for name in UNITS} for k in range(num)]


def write(path: FilePath, rows: list[dict[str, Any]], problem: Fingerprint) -> None:
    """Write rows to an HDF5 file, with units; the former file stays until the new one is complete.

    Args:
        path: the file.
        rows: one dict per point.
        problem: what the points belong to.
    """

    def fill(file: Any) -> None:
        for name, unit in UNITS.items():
            file[name] = np.array([row[name] for row in rows])
            file[name].attrs["unit"] = unit
        file.attrs["problem"], file.attrs["numbers"] = problem.text, problem.numbers

    hdf5.create(path, fill)


def run(
    comm: MPI.Comm,
    points: dict[str, FloatArray],
    solve: Callable[[float, float, float], dict[str, Any]],
    file: FilePath | None,
    progress: bool,
    problem: Fingerprint,
) -> dict[str, FloatArray]:
    """Solve for all points. Collective.

    Args:
        comm: communicator of the problem.
        points: creepages.
        solve: of creep, lateral and spin; returns the results by name.
        file: HDF5 file that is written after each point, and whose points are not solved again; or None.
        progress: show a bar on rank 0.
        problem: what the points belong to.
    """
    rows: list[dict[str, Any]] = []
    fault = None
    if file is not None and comm.rank == 0:
        try:
            rows = read(file, points, problem)
        except (OSError, ValueError) as error:
            fault = str(error)
    rows, fault = comm.bcast((rows, fault))
    if fault:
        raise ValueError(fault)
    total = len(points["creep"])
    with progress_bar(comm, progress, total) as show:
        for k in range(len(rows), total):
            here = tuple(float(points[name][k]) for name in INPUTS)
            show(k, f"creep {here[0]:.3g}, lateral {here[1]:.3g}, spin {here[2]:.3g}")
            rows.append({**dict(zip(INPUTS, here)), **solve(*here)})
            if file is not None:
                if comm.rank == 0:
                    try:
                        write(file, rows, problem)
                    except OSError as error:
                        fault = f"{file} cannot be written: {error}"
                fault = comm.bcast(fault)
                if fault:
                    raise RuntimeError(fault)
        show(total, "")
    return {name: np.array([row[name] for row in rows]) for name in UNITS}
