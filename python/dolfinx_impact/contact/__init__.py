# SPDX-License-Identifier: MIT
"""Contact: pairs of surfaces, rigid obstacles, and how contact is enforced. What is discretised: docs/contact.md."""

from .mortar.lagrange import Lagrange
from .mortar.tie import Tie
from .general import GeneralContact
from .explicit.nodal import Kinematic
from .pair import ContactPair, ContactStatus
from .penalty.penalty import Penalty
from .rigid import RigidCylinder, RigidPlane, RigidSphere
from .rigid_body import RigidBody
from .rigid_surface import RigidSurface

__all__ = [
    "ContactPair",
    "ContactStatus",
    "GeneralContact",
    "Kinematic",
    "Lagrange",
    "Penalty",
    "RigidBody",
    "RigidCylinder",
    "RigidPlane",
    "RigidSphere",
    "RigidSurface",
    "Tie",
]
