# SPDX-License-Identifier: MIT
"""Energies of an implicit problem, and works that add up over its steps; docs/implicit/energies.md."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from mpi4py import MPI

from ...common.described import Described
from ...common.types import FloatArray
from ...contact.penalty.quadrature_penalty import QuadraturePenalty
from ..run_history import ENERGIES

if TYPE_CHECKING:
    from ...contact.mortar.lagrange import LagrangeContact


@dataclass
class Forces:
    """Forces at one time, each over owned degrees of freedom [F].

    Attributes:
        internal: internal forces.
        external: forces of loads.
        damping: forces that resist the velocity.
        support: forces of supports on the bodies, zero elsewhere.
        obstacles: force of each rigid obstacle on its slave, (num_contacts, 3); zero for deformable masters.
    """

    internal: FloatArray
    external: FloatArray
    damping: FloatArray
    support: FloatArray
    obstacles: FloatArray


@dataclass
class Works:
    """Works so far, over all ranks [F L].

    Attributes:
        internal: work against internal forces.
        external: work of loads, of supports, and of obstacles that move.
        damping: work against damping.
    """

    internal: float = 0.0
    external: float = 0.0
    damping: float = 0.0


@dataclass(repr=False)
class EnergyAccount(Described):
    """Sums up works by the trapezoidal rule.

    Attributes:
        comm: communicator of the problem.
        works: works so far.
        forces: forces at the present time; None before the first.
    """

    comm: MPI.Intracomm
    works: Works = field(default_factory=Works)
    forces: Forces | None = None

    def add_step(self, forces: Forces, moved: FloatArray, obstacles: FloatArray) -> None:
        """Add the works of a step. Collective.

        Args:
            forces: forces at its end.
            moved: increments of displacement, over owned degrees of freedom [L].
            obstacles: increments of the obstacles' displacements, (num_contacts, 3) [L].
        """
        before, self.forces = self.forces, forces
        assert before is not None  # the start has set it
        pairs = [
            before.internal + forces.internal,
            before.external + forces.external + before.support + forces.support,
            before.damping + forces.damping,
        ]
        sums = self.comm.allreduce(np.array([0.5 * float(pair @ moved) for pair in pairs]), MPI.SUM).tolist()
        self.works.internal += sums[0]
        # Forces of obstacles are sums over all ranks already.
        self.works.external += sums[1] + 0.5 * float(np.sum((before.obstacles + forces.obstacles) * obstacles))
        self.works.damping += sums[2]


def stored_in_contact(contact: LagrangeContact | QuadraturePenalty) -> float:
    """Energy of the springs of a penalty contact; zero with multipliers. Collective.

    Args:
        contact: contact of a converged step.

    Returns:
        Energy [F L].
    """
    if not isinstance(contact, QuadraturePenalty) or contact.penalty is None or contact.tangential is None:
        return 0.0
    normal = contact.pressure
    tangential = contact.traction - normal[:, None] * contact.normal
    density = 0.5 * normal**2 / contact.penalty
    if contact.pair.friction > 0.0:
        density = density + 0.5 * np.sum(tangential**2, axis=1) / contact.tangential
    return float(contact.comm.allreduce(float(np.sum(contact.weight * density)), MPI.SUM))


def energies(
    kinetic: float,
    stored: float | None,
    works: Works,
    contacts: Sequence[LagrangeContact | QuadraturePenalty],
    has_history: bool,
) -> dict[str, float]:
    """Energies at the present time. Collective.

    Args:
        kinetic: kinetic energy [F L].
        stored: strain energy; None: not known, the work against internal forces takes its place [F L].
        works: works so far.
        contacts: contacts.
        has_history: whether a material has internal variables.

    Returns:
        Energies by the names of ENERGIES [F L].
    """
    values = dict.fromkeys(ENERGIES, 0.0)
    values["kinetic"] = kinetic
    values["internal"] = works.internal if stored is None else stored
    values["plastic"] = works.internal - values["internal"] if has_history else 0.0
    in_contact = [stored_in_contact(c) for c in contacts]
    values["contact"] = sum(in_contact)
    values["friction"] = sum(c.dissipated for c in contacts)
    values["damping"] = works.damping
    values["external"] = works.external
    return values
