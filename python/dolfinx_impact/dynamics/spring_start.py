# SPDX-License-Identifier: MIT
"""The springs of an explicit contact at its start: they bear what a contact by multipliers has borne."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy
from mpi4py import MPI

from .. import _cpp
from ..common.types import BoolArray, FloatArray, IntArray
from .started_problem import StartedProblem

FIRST = 1e-3  # of the distance that bounds the penetration: first guess of the approach that closes the springs
MARGIN = 1e-2  # of their penetration, by which nodes that bear nothing are open
CLOSE = 1e-6  # relative accuracy of the force of the springs


class SpringStart:
    """Penetration and friction of the springs of an explicit contact that bear what a steady or static contact bears.

    A contact by multipliers has no penetration, and springs need one. The slave body, with its supports, is moved
    against the master until the springs bear the same force: what their compliance takes from the approach of the
    bodies is given back. The tractions of friction become the tangential forces of the springs.

    Args:
        steady: contact with the tractions.
        nodes: nodes of the slave body, owned and ghosts.
        problem: explicit problem in the same state, with penalty contact.
        directions: mask of the directions in which the slave body may be moved, (gdim); None: all.
        number: which contact of the explicit problem it is.

    Attributes:
        nodes: as given.
    """

    def __init__(
        self,
        steady: Any,
        nodes: IntArray,
        problem: StartedProblem,
        directions: BoolArray | None = None,
        number: int = 0,
    ) -> None:
        self.nodes, self._steady, self._problem = nodes, steady, problem
        self._contact = problem.contact[number]
        self._gdim, self._comm = self._contact.gdim, self._contact.comm
        pressed = (steady.weight * steady.pressure) @ steady.normal
        if directions is not None:
            pressed = np.where(directions, pressed, 0.0)
        total = self._comm.allreduce(pressed)
        self._force = float(np.linalg.norm(total))
        self._normal = total / self._force if self._force > 0.0 else total

    def approach(self) -> float:
        """How far the slave body must be moved against the normal for the springs to bear the force [L]. Collective.

        Raises:
            RuntimeError: no approach was found; on all ranks.
        """
        if self._force == 0.0:
            return 0.0
        u, step = self._problem.u.x.array, FIRST * self._contact.facet_length

        def excess(distance: float) -> float:
            return self._borne(self.moved(u, distance)) / self._force - 1.0

        low = high = 0.0
        if excess(0.0) > 0.0:
            while excess(low) > 0.0:
                low, high, step = low - step, low, 2.0 * step
        else:
            while excess(high) <= 0.0:
                if step > self._contact.facet_length:
                    raise RuntimeError("springs of the explicit contact do not bear the steady force: refine the mesh")
                low, high, step = high, high + step, 2.0 * step
        return float(scipy.optimize.brentq(excess, low, high, xtol=CLOSE * (high - low), rtol=CLOSE))

    def moved(self, u: FloatArray, distance: float) -> FloatArray:
        """Displacements with the slave body moved against the normal.

        Args:
            u: displacements, owned and ghost dofs [L].
            distance: by which it is moved [L].
        """
        out = u.reshape(-1, self._gdim).copy()
        out[self.nodes] -= distance * self._normal
        return out.ravel()

    def _borne(self, u: FloatArray) -> float:
        """Force of new springs in a configuration along the normal, of all ranks [F]. Collective."""
        problem, contact = self._problem, self._contact
        masses = problem.mass.array[: problem.num_owned : self._gdim]
        twin, halo, values = contact.searched(u, _cpp.nodal.NodePenalty, masses, **contact.parameters)
        zero = np.zeros_like(values)
        for side in twin.directions:
            side.add_forces(halo, values, zero, np.ones_like(values), problem.contact_step, zero.copy())
        force = self._comm.allreduce(np.array(twin.force)[: self._gdim], MPI.SUM)
        return float(force @ self._normal)

    def hand_over(self) -> None:
        """Give the springs the nodal forces of the steady state. Collective.

        Bodies that are moved against each other penetrate everywhere by the same amount, steady pressures are not the
        same everywhere: what is left is an offset of the gap of each node, until the node opens.
        """
        steady, contact = self._steady, self._contact
        forces = np.asarray(steady.contact_forces()).reshape(-1, self._gdim)[contact.nodes]
        normal, stiffness = contact.normal, contact.stiffness
        pressing = np.einsum("na,na->n", forces, normal)
        along = forces - pressing[:, None] * normal
        inside = stiffness > 0.0
        found = np.where(inside, contact.gap, 0.0)  # nodes without a master have an infinite one
        compliance = np.where(inside, 1.0 / np.where(inside, stiffness, 1.0), 0.0)
        closed = inside & (pressing > 0.0)
        force = np.where(closed, pressing, 0.0)
        # Nodes beside the contact, which the approach has pushed in, stay just open.
        gap = np.where(closed, -force * compliance, MARGIN * np.abs(found))
        side = contact.sides()[0]
        values = {
            "closed": np.where(closed, 1, 0), "tangential": np.where(closed[:, None], along, 0.0),
            "spring_force": force, "spring_compliance": compliance, "spring_gap": np.where(closed, gap, 0.0),
            "spring_surplus": 0.0, "spring_tangential_surplus": 0.0, "energies": 0.0,
            "spring_offset": np.where(inside, gap - found, 0.0),
        }  # fmt: skip
        state = side.saved_state()
        for name, value in values.items():
            state.array(name)[...] = value
        side.resume(state)
