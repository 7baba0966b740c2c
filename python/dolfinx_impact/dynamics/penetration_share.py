# SPDX-License-Identifier: MIT
"""How much of the deformation is penetration of penalty contacts; docs/explicit/penalty.md, "Slow loads"."""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from dolfinx.fem import Function
from mpi4py import MPI

from ..assembly import operators
from ..foundation import Foundation
from ..loads import Load
from ..materials import Material
from .run_history import Energies

WARN = 0.05  # share that is warned of: forces under given displacements are too small by it
SLOW = 0.1  # a body bears a load when its kinetic energy is below this part of the energy of deformation
STEPS = 100  # steps in which it does so, before the share is judged: in the first ones of an impact springs come first


class PenetrationShare:
    """Part of the springs in the energy that deformation takes.

    Springs and bodies bear the same force, one behind the other: the energies they take are in the ratio of their
    compliances, and the springs' part is the part that penetration has in the approach of the bodies.

    Args:
        u: displacement function [L].
        material: material of the bodies; None: their energy is not known.
        loads: loads of the problem.
        springs: whether each contact acts by springs.
        from_rest: whether the integrator's internal energy is that since the start (bodies of nonlinear elasticity)
            instead of that of the undeformed body.
    """

    def __init__(
        self,
        u: Function,
        material: Material | None,
        loads: Sequence[Load],
        springs: Sequence[bool],
        from_rest: bool,
    ) -> None:
        self._u, self._material, self._loads = u, material, loads
        self._comm, self._known = u.function_space.mesh.comm, material is not None
        self._springs = list(springs)
        self._unknown_start = from_rest and self._known and any(self._springs)
        self.begin_anew()

    def begin_anew(self) -> None:
        """Forget the steps so far; the present state may be another one."""
        self._most_stored = self._most_strain = 0.0
        self._num_slow, self._warned = 0, False
        # Energy of the bodies when the internal energy was zero.
        self._offset: float | None = None if self._unknown_start else 0.0

    def update(self, values: Energies) -> None:
        """Take note of the energy of bodies that were deformed at the start. Collective.

        Args:
            values: energies of the present displacement [F L].
        """
        if self._offset is None:
            self._offset = self._energy() - float(values["internal"])

    def _energy(self) -> float:
        """Energy of elastic bodies and foundations at the present displacement [F L]. Collective."""
        u, material = self._u, self._material
        if not self._comm.allreduce(bool(np.any(u.x.array)), MPI.LOR):
            return 0.0
        assert material is not None  # else the energy is not known
        form = operators.strain_energy_form(u, material)
        for load in self._loads:
            if isinstance(load, Foundation):
                form += load.energy_form(u, material)
        return float(operators.Energy(form).value())

    def of(self, stored: float, values: Energies) -> float:
        """Share of springs.

        Args:
            stored: energy of the springs [F L].
            values: energies of all contacts and bodies at the same time [F L].

        Returns:
            Energy of the springs over that of all springs and of the deformation of the bodies; zero without either,
            not a number for a residual of one's own, whose energy is not known [1].
        """
        if not self._known:
            return math.nan
        total = float(values["contact"] + np.maximum(self._deformation(values), 0.0))
        return stored / total if total > 0.0 else 0.0

    def _deformation(self, values: Energies | npt.NDArray[np.void]) -> npt.NDArray[np.float64]:
        return np.asarray(values["internal"] + values["plastic"] + (self._offset or 0.0), dtype=np.float64)

    def add(self, rows: npt.NDArray[np.void]) -> None:
        """Look at steps.

        Args:
            rows: energies of the steps.
        """
        if not self._known or not any(self._springs) or not len(rows):
            return
        strain = rows["contact"] + np.maximum(self._deformation(rows), 0.0)
        slow = (rows["contact"] > 0.0) & (rows["kinetic"] < SLOW * strain)
        self._num_slow += int(np.count_nonzero(slow))
        self._most_stored = max(self._most_stored, float(np.max(rows["contact"][slow], initial=0.0)))
        self._most_strain = max(self._most_strain, float(np.max(strain[slow], initial=0.0)))

    def warn(self) -> None:
        """Warn once, on rank 0, if penetrations change what a load does that bodies have borne for some time."""
        if self._warned or self._num_slow < STEPS or not self._most_stored > WARN * self._most_strain:
            return
        self._warned = True
        if self._comm.rank == 0:
            share = 100 * self._most_stored / self._most_strain
            warnings.warn(
                f"under load {share:.0f} % of the deformation is penetration of the springs of penalty contact: forces "
                "under given displacements are too small by as much. Take Kinematic, which has no penetration, finer "
                "cells, a larger penalty with smaller steps, or begin from a static solution "
                "(contact.penetration_share)",
                stacklevel=4,
            )
