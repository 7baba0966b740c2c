# SPDX-License-Identifier: MIT
"""Functions of time: of loads, prescribed motion and rigid obstacles."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, cast

import numpy as np
from dolfinx.fem import DirichletBC

from . import _cpp
from .common.arguments import number, path
from .common.collective import comm_of, guard
from .common.fixed import Fixed, read_only
from .common.types import ArrayLike, FilePath, FloatArray

INTERPOLATIONS = ("linear", "smooth")
OUTSIDE = ("hold", "refuse")


def is_in_time(value: Any) -> bool:
    """Whether a value is a function of time, or a pair (times, values)."""
    return callable(value) or (isinstance(value, tuple) and len(value) == 2 and np.ndim(value[0]) == 1)


class AmplitudeTable(Fixed):
    """Function of time from a table of times and values: of loads, supports and rigid obstacles.

    Wherever a function of time is taken, `amplitude=` of loads, of `PrescribedMotion`, and `motion` of rigid obstacles,
    a table can be given. It is a function too: `table(0.2)`, with which static problems, which have no time, set the
    values of their loads between two solves.

    Args:
        times: times that increase, (n) [T].
        values: values at these times, (n), or of a vector (n, 2) or (n, 3): [1] of an amplitude, [L] of a motion.
        interpolation: "linear", or "smooth": in each interval from a to b, a + (b - a) r^3 (10 - 15 r + 6 r^2) with r
            from 0 to 1, which begins and ends with neither velocity nor acceleration.
        before: what holds before the first time: "hold", the first value, or "refuse", an error.
        after: what holds after the last time: "hold", the last value, or "refuse". Explicit problems ask for one step
            beyond the time that they reach.
        name: for messages.

    Raises:
        TypeError: times or values are no numbers.
        ValueError: times that do not increase, another number of values, numbers that are not finite, or an unknown
            interpolation.
    """

    def __init__(
        self,
        times: ArrayLike,
        values: ArrayLike,
        interpolation: str = "linear",
        before: str = "hold",
        after: str = "hold",
        name: str = "amplitude table",
    ) -> None:
        options = _table_options(interpolation, before, after)
        t, v = _numbers("times", times), _numbers("values", values)
        if t.ndim != 1 or v.ndim not in (1, 2) or len(v) != len(t):
            raise ValueError(
                f"{name}: a table needs increasing times and as many values, found times of shape {t.shape} and values "
                f"of shape {v.shape}"
            )
        self._take(_cpp.problems.AmplitudeTable(t, v.ravel(), *options, str(name)), interpolation, before, after, name)

    @classmethod
    def from_csv(
        cls,
        file: FilePath,
        interpolation: str = "linear",
        before: str = "hold",
        after: str = "hold",
        name: str | None = None,
    ) -> AmplitudeTable:
        """Read a table from a text file: in each line a time and one, two or three values, between commas, semicolons
        or blanks. Empty lines, lines that begin with #, and one line of titles at the head are left out.

        Args:
            file: the file; each rank reads it.
            interpolation: as for the table.
            before: as for the table.
            after: as for the table.
            name: for messages; None: the name of the file.

        Returns:
            The table.

        Raises:
            TypeError: `file` is no name of a file.
            ValueError: a line is of another kind, with its number; or what the table itself refuses.
            RuntimeError: the file cannot be read.
        """
        options = _table_options(interpolation, before, after)
        path("file", file)
        name = f"table {file}" if name is None else str(name)
        table = cls.__new__(cls)
        table._take(
            _cpp.problems.AmplitudeTable.from_csv(str(file), *options, name), interpolation, before, after, name
        )
        object.__setattr__(table, "_made", True)
        return table

    def _take(
        self, table: _cpp.problems.AmplitudeTable, interpolation: str, before: str, after: str, name: str
    ) -> None:
        self._cpp_object = table
        self.interpolation, self.before, self.after, self.name = interpolation, before, after, name

    @property
    def times(self) -> FloatArray:
        """Times, (n) [T]."""
        return cast(FloatArray, read_only(self._cpp_object.times))

    @property
    def values(self) -> FloatArray:
        """Values at these times, (n, size)."""
        return cast(FloatArray, read_only(self._cpp_object.values))

    @property
    def size(self) -> int:
        """Components of a value."""
        return self._cpp_object.size

    def sample(self, times: ArrayLike) -> FloatArray:
        """Values at times.

        Args:
            times: any times, (m) [T].

        Returns:
            Values, (m, size).

        Raises:
            ValueError: a time outside of the table, where that is refused.
        """
        return self._cpp_object.sample(np.atleast_1d(np.asarray(times, dtype=float)))

    def __call__(self, time: float) -> Any:
        """Value at a time, a number or (size).

        Raises:
            ValueError: the time is outside of the table, and that is refused.
        """
        row = self.sample([time])[0]
        return float(row[0]) if self.size == 1 else row

    def __repr__(self) -> str:
        t = self.times
        kind = "numbers" if self.size == 1 else f"vectors of {self.size}"
        return f"AmplitudeTable({len(t)} {kind} from {t[0]:g} to {t[-1]:g}, {self.interpolation})"

    def same_on_all_ranks(self) -> list[Any]:
        """Values that collective.describe compares between ranks."""
        return [self.times, self.values, self.interpolation, self.before, self.after]


def _numbers(name: str, given: Any) -> FloatArray:
    try:
        return np.ascontiguousarray(given, dtype=float)
    except (TypeError, ValueError):
        raise TypeError(f"{name} of an amplitude table must be numbers, found {given!r:.60}") from None


def _table_options(interpolation: Any, before: Any, after: Any) -> tuple[bool, bool, bool]:
    """Options as the C++ side takes them."""
    for name, value, known in (
        ("interpolation", interpolation, INTERPOLATIONS), ("before", before, OUTSIDE), ("after", after, OUTSIDE)
    ):  # fmt: skip
        if value not in known:
            raise ValueError(f"{name} is {value!r:.60}: use {' or '.join(map(repr, known))}")
    return interpolation == "smooth", before == "refuse", after == "refuse"


class Amplitude:
    """Checked function of time that is sampled at time levels.

    Args:
        what: a number, a callable of the time [T], an AmplitudeTable, a pair (times, values) that is linear in between
            and constant outside, or None (one at all times; vectors: zero).
        name: for messages.
        size: components of its values.

    Raises:
        TypeError: another kind. ValueError: values of another shape, not finite, times that do not increase.
    """

    def __init__(self, what: Any, name: str, size: int = 1) -> None:
        self.name, self.size = name, size
        self._function: Callable[[float], Any]
        self._many: Callable[[ArrayLike], FloatArray] | None = None
        if what is None:
            still = np.ones(1) if size == 1 else np.zeros(size)
            self._function = lambda t: still
        elif isinstance(what, AmplitudeTable):
            self._many = self._from(what)
        elif callable(what):
            self._function = what
        elif isinstance(what, tuple) and len(what) == 2 and np.ndim(what[0]) == 1:
            self._function = self._table(*what)
        elif size == 1:
            value = number(name, what)
            self._function = lambda t: value
        else:
            raise TypeError(f"{name} must be a function of time or a pair (times, values), found {what!r:.60}")

    def _from(self, table: AmplitudeTable) -> Callable[[ArrayLike], FloatArray]:
        """The table at many times, whose vectors of two components get a third that is zero."""
        missing = self.size - table.size
        if missing and (self.size, table.size) != (3, 2):
            raise ValueError(f"{self.name}: {table!r} has {table.size} values at a time, where {self.size} are needed")
        return lambda times: np.pad(table.sample(times), ((0, 0), (0, missing)))

    def _table(self, times: Any, values: Any) -> Callable[[float], FloatArray]:
        times, values = np.array(times, dtype=float), np.array(values, dtype=float)
        if len(times) == 0 or len(values) != len(times) or np.any(np.diff(times) <= 0):
            raise ValueError(f"{self.name}: a table needs increasing times and as many values")
        columns = values.reshape(len(times), -1).T
        return lambda t: np.array([np.interp(t, times, column) for column in columns])

    def sample(self, times: Sequence[float] | FloatArray) -> FloatArray:
        """Values at the times: (num_times, size)."""
        if self._many is not None:
            return self._many(times)
        rows = np.array([np.asarray(self._function(t), dtype=float).ravel() for t in times])
        if rows.shape != (len(times), self.size):
            raise ValueError(f"{self.name} has values of shape {rows.shape[1:]}: it needs {self.size}")
        bad = np.flatnonzero(~np.all(np.isfinite(rows), axis=1))
        if len(bad):
            raise ValueError(f"{self.name} is {rows[bad[0]].tolist()} at the time {times[bad[0]]:g}")
        return rows


class PrescribedMotion(Fixed):
    """Displacement prescribed as a function of time: that of a Dirichlet boundary condition times an amplitude.

    Args:
        bc: Dirichlet boundary condition on the displacement space or a part of it.
        amplitude: a number, a function of time, an AmplitudeTable or a pair (times, values) [1].
    """

    def __init__(self, bc: DirichletBC, amplitude: Any) -> None:
        with guard(comm_of(bc), "PrescribedMotion", amplitude=amplitude):
            if not hasattr(bc, "dof_indices"):
                raise TypeError(f"PrescribedMotion takes a DirichletBC, found {type(bc).__name__}")
            self.bc, self.amplitude = bc, Amplitude(amplitude, "amplitude of a prescribed motion")

    def __repr__(self) -> str:
        return f"PrescribedMotion(of {len(self.bc.dof_indices()[0])} degrees of freedom of this rank)"
