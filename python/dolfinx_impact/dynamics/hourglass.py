# SPDX-License-Identifier: MIT
"""Energy of the hourglass modes of bodies with one point per cell, and a warning of much; docs/one_point.md."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
from dolfinx import fem
from dolfinx.fem import Function

from ..assembly import operators
from ..assembly.inelastic_part import quadrature_element, set_values
from ..assembly.material_history import MaterialHistory
from ..common.described import Described
from ..forms import one_point
from ..forms.one_point_flow import HOURGLASS_STRAIN, OnePointKinematics
from ..materials import REDUCED, MaterialMap, _Material

WARN = 0.05  # part of the internal energy that is warned of: a usual limit for hourglass energy
EVERY = 500  # steps between two looks at the energy: a look costs about a step


class Hourglassing(UserWarning):
    """Much of the internal energy is in hourglass modes."""


class HourglassEnergy(Described):
    """Part of the internal energy that is in hourglass modes.

    Args:
        u: displacement function [L].
        material: material of the bodies; None: the residual is the user's own.
        history: internal variables of the problem, which have the plastic strains of the modes; None: no material has
            any.
    """

    def __init__(
        self, u: Function, material: _Material | MaterialMap | None, history: MaterialHistory | None = None
    ) -> None:
        self._u, self._comm, self._history = u, u.function_space.mesh.comm, history
        self._plastic: Function | None = None
        self._material = material if material is not None and material.integration == REDUCED else None
        self._energy: operators.Energy | None = None
        self.begin_anew()

    def begin_anew(self) -> None:
        """Forget the steps so far; the present state may be another one."""
        self._internal = self._share = 0.0
        self._num_steps, self._warned = 0, False

    def steps_left(self, many: int) -> int:
        """Number of steps until the energy is looked at.

        Args:
            many: number for bodies without hourglass modes.
        """
        return many if self._material is None else EVERY - self._num_steps

    def add(self, internal: float, num_steps: int = 1) -> None:
        """Take note of steps.

        Args:
            internal: largest internal energy of the steps [F L].
            num_steps: number of steps [1].
        """
        self._internal = max(self._internal, internal)
        self._num_steps += num_steps

    @property
    def due(self) -> bool:
        """Whether there were so many steps that the energy has to be looked at."""
        return self._material is not None and self._num_steps >= EVERY

    def entry(self) -> dict[str, float]:
        """Entry of the energies: "hourglass", the part of the internal energy at the present displacement that is in
        hourglass modes [F L]; empty for bodies without. Collective."""
        if self._material is None:
            return {}
        if self._energy is None:
            self._energy = operators.Energy(self._form(self._material))
        if self._history is not None and self._plastic is not None:
            values = self._history.points.values(HOURGLASS_STRAIN)
            set_values(self._plastic, np.arange(len(values), dtype=np.int32), values)
        value, self._num_steps = self._energy.value(), 0
        if self._internal > 0.0:
            self._share = max(self._share, value / self._internal)
        return {"hourglass": value}

    def _form(self, material: _Material | MaterialMap) -> Any:
        """Form of the energy; sets `_plastic`, whose values it reads."""
        u = self._u
        form = operators.sum_laws(u, material, lambda law, dx: one_point.hourglass_energy(u, law, dx))
        for part in () if self._history is None else self._history.parts:
            if self._plastic is None:
                shape = part.response.history[HOURGLASS_STRAIN]
                space = fem.functionspace(part.mesh, quadrature_element(part.mesh, shape, part.degree))
                self._plastic = Function(space, name=HOURGLASS_STRAIN)
            assert isinstance(part.kinematics, OnePointKinematics)
            form += part.kinematics.hourglass_density(u, self._plastic) * part.dx
        return form

    def warn(self, stacklevel: int = 4) -> None:
        """Warn once, on rank 0, if much of the internal energy was in hourglass modes.

        Args:
            stacklevel: as for warnings.warn.
        """
        if self._warned or not self._share > WARN:
            return
        self._warned = True
        if self._comm.rank == 0:
            warnings.warn(
                f"hourglass modes have {100 * self._share:.0f} % of the largest internal energy so far: more than "
                f"{100 * WARN:.0f} % of the deformation is one that a single point per cell does not see. Take finer "
                "cells, spread loads that act on single nodes, or integration='full'",
                Hourglassing,
                stacklevel=stacklevel,
            )
