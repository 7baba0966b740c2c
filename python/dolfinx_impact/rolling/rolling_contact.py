# SPDX-License-Identifier: MIT
"""Contact by multipliers with friction against the steady slip velocity; seed (3.58)-(3.60), docs/rolling.md."""

from __future__ import annotations

from typing import Any

from .. import _cpp
from ..common.types import FloatArray
from ..contact.mortar.lagrange import Lagrange, LagrangeContact
from .flow import Flow


class RollingLagrange(Lagrange):
    """A Lagrange contact that a RollingProblem binds to its flow.

    Args:
        spec: as the user gave it.
        flow: flow of the bodies.
    """

    def __init__(self, spec: Lagrange, flow: Flow) -> None:
        super().__init__(spec.pair, spec.quadrature_degree, spec.basis)
        self.flow = flow

    def _bind(self, problem: Any) -> RollingContact:
        return RollingContact(self, problem)


class RollingContact(LagrangeContact):
    """Multipliers of a pair whose bodies flow past each other, with Coulomb friction against the steady slip velocity:
    a view of rolling::RollingContact (C++). Slip that adds up, `slip`, is zero in steady states.

    Args:
        spec: RollingLagrange.
        problem: static problem of the bodies.
    """

    may_share_nodes = False
    all_in_cpp = True
    spec: RollingLagrange
    _cpp_object: _cpp.rolling.RollingContact

    def _in_cpp(self, V: Any, slave: Any, master: Any, options: Any, fixed: Any) -> _cpp.rolling.RollingContact:
        return _cpp.rolling.RollingContact(V, slave, master, options, fixed, self.spec.flow._cpp_object)

    @property
    def fields(self) -> tuple[str, ...]:
        return (*super().fields, "slip_velocity")

    @property
    def slip_velocity(self) -> FloatArray:
        """Slip velocity of slave against master, (n, gdim) [L/T]."""
        return self._cpp_object.slip_velocity

    @property
    def friction_power(self) -> float:
        """Power that friction takes out of the motion, of all ranks [F L/T]."""
        return self._cpp_object.friction_power

    def update_obstacle(self) -> None:
        """Take over the present velocity of a rigid master."""
        if self.pair.rigid:
            self._cpp_object.obstacle_velocity = [float(v) for v in self.pair.rigid_master.velocity]
