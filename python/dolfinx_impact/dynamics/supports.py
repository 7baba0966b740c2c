# SPDX-License-Identifier: MIT
"""Prescribed displacements, constant or functions of time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from dolfinx.fem import DirichletBC, Function
from mpi4py import MPI

from ..common.described import Described
from ..amplitude import PrescribedMotion
from ..common.types import BoolArray, FloatArray, IntArray
from .functions_of_time import FunctionsOfTime

START = 1e-12  # part of the largest displacement by which u may differ from a prescribed value at the start


class Supports(Described):
    """Prescribed degrees of freedom of a problem; where several prescribe the same one, the first counts.

    Args:
        bcs: Dirichlet conditions and prescribed motions.
        u: displacement function at the start [L].
        functions: receives the amplitudes of the motions.

    Attributes:
        parts: prescribed owned degrees of freedom, their values [L] and the column of their function of time
            (-1: constant), for every support.
        mask: mask of prescribed degrees of freedom, owned and ghosts.

    Raises:
        ValueError: a prescribed displacement differs from u at the start; on all ranks.
    """

    def __init__(self, bcs: Sequence[DirichletBC | PrescribedMotion], u: Function, functions: FunctionsOfTime) -> None:
        V = u.function_space
        num_owned, comm = V.dofmap.index_map.size_local * V.dofmap.index_map_bs, V.mesh.comm
        self.mask: BoolArray = np.zeros(len(u.x.array), dtype=bool)
        self.parts: list[tuple[IntArray, FloatArray, int]] = []
        self._conditions: list[DirichletBC] = []
        self._present: FloatArray = np.zeros(len(u.x.array))  # values of a condition now, where it prescribes any
        for given in bcs:
            amplitude = given.amplitude if isinstance(given, PrescribedMotion) else None
            bc = given.bc if isinstance(given, PrescribedMotion) else given
            dofs = bc.dof_indices()[0]
            free = dofs[~self.mask[dofs]]
            self.mask[free] = True
            dofs = free[free < num_owned]
            values = np.zeros(len(u.x.array))
            bc.set(values)
            column = -1 if amplitude is None else functions.add(amplitude)[0]
            start = values[dofs] * (1.0 if amplitude is None else amplitude.sample(np.zeros(1))[0, 0])
            jump = float(np.max(np.abs(start - u.x.array[dofs]), initial=0.0))
            size = max(float(np.max(np.abs(values), initial=0.0)) for values in (start, u.x.array))
            if comm.allreduce(jump, MPI.MAX) > START * comm.allreduce(size, MPI.MAX):
                raise ValueError(
                    "a prescribed displacement jumps at the start: let u have its value, or use PrescribedMotion with "
                    "an amplitude that begins where u is"
                )
            self.parts.append((dofs, values[dofs], column))
            self._conditions.append(bc)

    def check(self) -> None:
        """Refuse that the value of a condition has been changed, on this rank. It does not communicate.

        Raises:
            ValueError: one has.
        """
        for bc, (dofs, values, _) in zip(self._conditions, self.parts):
            bc.set(self._present)
            if not np.array_equal(self._present[dofs], values, equal_nan=True):
                raise ValueError(
                    "the value of a Dirichlet condition was changed after the problem was made, which goes on with the "
                    "old one: give PrescribedMotion(bc, amplitude), a function of time, before the problem is made"
                )
