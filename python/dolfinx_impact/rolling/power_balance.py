# SPDX-License-Identifier: MIT
"""Power that drives rolling bodies, and where it goes: friction, and what the contact puts into deformation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..common.types import FloatArray
from .contact import RollingContact
from .flow import Flow
from .torque import Torque


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


def power_balance(flow: Flow, torques: Sequence[Torque], contacts: Sequence[RollingContact]) -> PowerBalance:
    """Powers of the contact forces f on nodes that move with V = w + (Grad u) w, and, as parts of rigid bodies, with R.

    The driving power is minus the sum of f R; deformation takes the sum of f (V - R), and from it what the pressure
    does on the normal part of the velocity jump; friction takes the tangential part. Collective.

    Args:
        flow: flow of the bodies.
        torques: on the bodies that spin.
        contacts: in the steady state.

    Returns:
        Powers of all ranks.
    """
    rigid: FloatArray = flow.at_nodes()
    for torque in torques:
        rigid[torque.nodes] = torque.velocities()
    driving = rolling = friction = 0.0
    for contact in contacts:
        contact.update_flow()
        contact.update_gap(contact.problem.u.x.array)
        contact.update_matrices()
        velocity = contact.material_velocity()
        owned, gdim = len(velocity), contact.gdim
        forces = contact.contact_forces()[: owned * gdim].reshape(-1, gdim)
        g = contact.geometry
        cover = np.where(g.participates, g.cover, 0.0)
        pressure = np.einsum("na,na->n", g.normal, contact.traction)
        jump = contact.relative_velocity(contact.problem.u.x.array[: owned * gdim])
        opening = np.einsum("na,na->n", g.normal, jump)
        imposed = np.einsum("na,na->n", contact.traction, contact.imposed_velocity())
        driving -= float(np.sum(forces * rigid[:owned])) + float(np.sum(cover * imposed))
        rolling += float(np.sum(forces * (velocity - rigid[:owned]))) - float(np.sum(cover * pressure * opening))
        friction += contact.friction_power
    comm = contacts[0].comm
    return PowerBalance(float(comm.allreduce(driving)), friction, float(comm.allreduce(rolling)))
