# SPDX-License-Identifier: MIT
"""Forces of an implicit problem at one time: bodies, loads, damping, contacts and supports in balance."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import dolfinx.fem.petsc as petsc
import numpy as np
import ufl
from dolfinx import fem
from petsc4py import PETSc

from ...assembly.ffcx_form import ffcx_form
from ...common.described import Described
from ...common.types import BoolArray, FloatArray
from ...statics.bodies import assemble_residual
from .energies import Forces
from .loads_in_time import LoadsInTime
from .motion import State, TimeValues
from .moving_body import MovingBody

if TYPE_CHECKING:
    from ...contact.mortar.lagrange import LagrangeContact
    from ...contact.penalty.quadrature_penalty import QuadraturePenalty


class ForceBalance(Described):
    """Evaluates forces at the present displacement.

    Args:
        u: displacement function [L].
        body: bodies with inertia.
        loads: loads in time.
        external: form of the virtual work of loads; None: there are none.
        contacts: contacts.
        fixed: mask of prescribed degrees of freedom, owned.
    """

    def __init__(
        self,
        u: fem.Function,
        body: MovingBody,
        loads: LoadsInTime,
        external: ufl.Form | None,
        contacts: Sequence[LagrangeContact | QuadraturePenalty],
        fixed: BoolArray,
    ) -> None:
        self._u, self._body, self._loads, self._contacts, self._fixed = u, body, loads, contacts, fixed
        self._external = None if external is None else ffcx_form(external)

    def body_residual(self, factors: FloatArray) -> FloatArray:
        """Internal minus external forces. Collective.

        Args:
            factors: amplitudes of loads, (num_loads) [1].

        Returns:
            Forces over owned degrees of freedom [F].
        """
        with self._loads.scaled(factors):
            b = assemble_residual(self._u, self._body.body, self._body.vector())
            return _taken(b)

    def forces(self, state: State, values: TimeValues) -> Forces:
        """All forces at a time. Collective.

        Args:
            state: motion.
            values: what functions of time prescribe at its time.

        Returns:
            Forces; those of supports balance the others.
        """
        residual, external = self.body_residual(values.factors), self._external_forces(values.factors)
        damping = self._body.damping_forces(state)
        balance = self._body.inertia.times(state.acceleration) + damping + residual
        obstacles = np.zeros((len(self._contacts), 3))
        for row, contact in zip(obstacles, self._contacts):
            balance -= contact.contact_forces()
            if contact.pair.rigid and contact.force is not None:
                row[: len(contact.force)] = contact.force
        return Forces(residual + external, external, damping, np.where(self._fixed, balance, 0.0), obstacles)

    def start(self, velocity: FloatArray, start: TimeValues) -> State:
        """Motion at the start, with accelerations in equilibrium with the forces of bodies, loads and springs of
        contact. Collective.

        Args:
            velocity: velocities over owned degrees of freedom; where motion is prescribed, its own count [L/T].
            start: what functions of time prescribe there.

        Returns:
            Motion at the start.
        """
        n = len(self._fixed)
        velocity = np.where(self._fixed, start.prescribed.velocity, velocity)
        state = State(self._u.x.array[:n].copy(), velocity, np.zeros(n), np.zeros(n))
        forces = -(self.body_residual(start.factors) + self._body.damping_forces(state))
        for contact in self._contacts:
            if not contact.has_multipliers:
                forces += contact.contact_forces()
        state.acceleration = self._body.inertia.accelerations(forces, self._fixed, start.prescribed.acceleration)
        state.mean = state.acceleration.copy()
        return state

    def _external_forces(self, factors: FloatArray) -> FloatArray:
        """Forces of the loads, over owned degrees of freedom [F]. Collective."""
        if self._external is None:
            return np.zeros(len(self._fixed))
        with self._loads.scaled(factors):
            b = petsc.assemble_vector(self._external)
        b.ghostUpdate(PETSc.InsertMode.ADD, PETSc.ScatterMode.REVERSE)
        return _taken(b)


def _taken(b: PETSc.Vec) -> FloatArray:
    """Owned entries of a vector, which is destroyed."""
    values = np.array(b.array_r)
    b.destroy()
    return values
