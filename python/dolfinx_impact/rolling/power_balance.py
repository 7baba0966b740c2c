# SPDX-License-Identifier: MIT
"""Power that drives rolling bodies, and where it goes: friction, and what the contact puts into deformation."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class PowerBalance:
    """Powers of a steady state; driving = friction + rolling, to the solver's tolerance.

    Attributes:
        driving: torques times spins, and forces that hold bodies in translation times their velocities [F L/T].
        friction: that slip takes: traction times slip velocity, with the opposite sign [F L/T].
        rolling: that deformation takes [F L/T]. Elastic bodies give back what they take, so that it is the error of
            the derivative along the flow, which vanishes as cells are refined; plastic flow takes some.
    """

    driving: float
    friction: float
    rolling: float
