# SPDX-License-Identifier: MIT
"""Laws of the interface: pressure and shear traction of contact points, written in UFL; docs/interface_laws.md."""

from .cohesive import cohesive_zone
from .friction import anisotropic_friction, falling_friction
from .friction_law import FrictionLaw
from .law import InterfaceLaw, InterfaceUpdate
from .pressure import adhesion, damped_contact, exponential_pressure, linear_pressure

__all__ = [
    "FrictionLaw",
    "InterfaceLaw",
    "InterfaceUpdate",
    "adhesion",
    "anisotropic_friction",
    "cohesive_zone",
    "damped_contact",
    "exponential_pressure",
    "falling_friction",
    "linear_pressure",
]
