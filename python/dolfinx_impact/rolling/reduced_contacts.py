# SPDX-License-Identifier: MIT
"""Contact and friction of a rolling problem, reduced to the nodes that touch or may touch soon."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from dolfinx.fem import FunctionSpace
from mpi4py import MPI

from ..common.types import BoolArray, FloatArray
from .body_response import BodyResponse, Compliance
from .contact_operators import Candidates, ContactOperators
from .friction_problem import FrictionProblem, Nodes, State
from .torque import ReducedTorque

OTHER_FLOW = 0.05  # relative change of the flow with which the compliance of velocities is made again


class ReducedContacts:
    """Keeps the factors of the bodies and the compliance of the candidates from solve to solve.

    The compliance may be that of an earlier geometry: who uses it corrects what it leaves.

    Args:
        V: displacement space.
        fixed: mask of prescribed dofs, owned.

    Attributes:
        response: of the bodies.
    """

    def __init__(self, V: FunctionSpace, fixed: BoolArray) -> None:
        self._comm, self.response = V.mesh.comm, BodyResponse(V, fixed)
        self._chosen: list[BoolArray] = []
        self._candidates: Candidates | None = None
        self._compliance: Compliance | None = None
        self._flow, self._factors = 0.0, 0

    def renew(self) -> None:
        """Make factors and compliance again, when they are used next."""
        self.response.forget_factors()

    def forces(
        self,
        operators: ContactOperators,
        near: Sequence[BoolArray],
        at: Sequence[Sequence[FloatArray]],
        torque: ReducedTorque | None,
    ) -> tuple[list[FloatArray], float, str]:
        """Multipliers that obey contact and friction. Collective.

        Args:
            operators: of the contacts, whose bodies `response` has been told.
            near: masks of nodes that touch or may touch, (n) each.
            at: forces (n, gdim) [F], gaps (n) [L], and slip velocities (n, gdim) [L/T] of each contact, which belong to
                each other.
            torque: to be reached by a change of spin, or None.

        Returns:
            Nodal forces, (n, gdim) each [F]; change of the spin [1/T]; what went wrong, or an empty text.
        """
        candidates = self._update(operators, near)
        values = [candidates.gather(v) for v in at]
        friction = [np.full(len(c.nodes), c.friction) for c in operators.contacts]
        carriers = [c.carriers for c in operators.contacts]
        constants: list[Any] = [candidates.gather(v) for v in (operators.frames, friction, carriers, operators.held)]
        reduced = torque.gathered(operators, candidates) if torque else None
        found: Any = None
        change, fault = 0.0, ""
        if self._comm.rank == 0:
            assert self._compliance is not None
            problem, state = FrictionProblem(Nodes(*constants), self._compliance), State(*values)
            if reduced is None:
                found, fault = problem.solve(state)
            else:
                found, change, fault = reduced.solve(problem, state)
        change, fault = self._comm.bcast((change, fault))
        return candidates.scatter(found, [np.zeros_like(f) for f in at[0]]), change, fault

    def _update(self, operators: ContactOperators, near: Sequence[BoolArray]) -> Candidates:
        """Candidates and their compliance. Collective."""
        flow = self._comm.allreduce(sum(c.speed() for c in operators.contacts), MPI.MAX)
        new = [bool(np.any(a & ~b)) for a, b in zip(near, self._chosen)] if self._chosen else [True]
        stale = self.response.num_factors != self._factors or abs(flow - self._flow) > OTHER_FLOW * self._flow
        if self._comm.allreduce(any(new) or stale, MPI.LOR) or self._candidates is None:
            self._chosen = [a | b for a, b in zip(near, self._chosen or near)]
            self._candidates = Candidates(self._comm, self._chosen)
            self._compliance = self.response.compliance(operators, self._candidates)
            self._factors, self._flow = self.response.num_factors, flow
        return self._candidates
