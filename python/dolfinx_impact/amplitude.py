# SPDX-License-Identifier: MIT
"""Functions of time: of loads, prescribed motion and rigid obstacles."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from dolfinx.fem import DirichletBC

from .common.collective import comm_of, guard
from .common.fixed import Fixed
from .common.types import FloatArray
from .common.arguments import number


class Amplitude:
    """Checked function of time that is sampled at time levels.

    Args:
        what: a number, a callable of the time [T], a pair (times, values) that is linear in between and constant
            outside, or None (one at all times; vectors: zero).
        name: for messages.
        size: components of its values.

    Raises:
        TypeError: another kind. ValueError: values of another shape, not finite, times that do not increase.
    """

    def __init__(self, what: Any, name: str, size: int = 1) -> None:
        self.name, self.size = name, size
        self._function: Callable[[float], Any]
        if what is None:
            still = np.ones(1) if size == 1 else np.zeros(size)
            self._function = lambda t: still
        elif callable(what):
            self._function = what
        elif isinstance(what, tuple) and len(what) == 2 and np.ndim(what[0]) == 1:
            self._function = self._table(*what)
        elif size == 1:
            value = number(name, what)
            self._function = lambda t: value
        else:
            raise TypeError(f"{name} must be a function of time or a pair (times, values), found {what!r:.60}")

    def _table(self, times: Any, values: Any) -> Callable[[float], FloatArray]:
        times, values = np.array(times, dtype=float), np.array(values, dtype=float)
        if len(times) == 0 or len(values) != len(times) or np.any(np.diff(times) <= 0):
            raise ValueError(f"{self.name}: a table needs increasing times and as many values")
        columns = values.reshape(len(times), -1).T
        return lambda t: np.array([np.interp(t, times, column) for column in columns])

    def sample(self, times: Sequence[float] | FloatArray) -> FloatArray:
        """Values at the times: (num_times, size)."""
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
        amplitude: as for Amplitude, a function of time or a table [1].
    """

    def __init__(self, bc: DirichletBC, amplitude: Any) -> None:
        with guard(comm_of(bc), "PrescribedMotion", amplitude=amplitude):
            if not hasattr(bc, "dof_indices"):
                raise TypeError(f"PrescribedMotion takes a DirichletBC, found {type(bc).__name__}")
            self.bc, self.amplitude = bc, Amplitude(amplitude, "amplitude of a prescribed motion")

    def __repr__(self) -> str:
        return f"PrescribedMotion(of {len(self.bc.dof_indices()[0])} degrees of freedom of this rank)"
