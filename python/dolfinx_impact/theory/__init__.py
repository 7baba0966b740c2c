# SPDX-License-Identifier: MIT
"""Closed forms of classical contact theory and of plasticity: what a computation is compared with.

Seed 3.2.1 and 3.4 as corrected in docs/theory.md, and the textbook answers around them. Linear elastic half-spaces and
half-planes, small strain, contact small against the bodies. Any consistent set of units. Results are frozen, their
attributes carry their units, and they draw themselves with `.plot(ax)`; a single number is returned as a float.

A radius is positive for a convex body, negative for a concave one, np.inf for a flat one; E = np.inf is a rigid body.
"""

from .elastic_bodies import Bodies, effective_modulus
from .curvature import RelativeCurvature, profile, relative_curvature
from .dissimilar import BondedIndentation, Dundurs, bentall_johnson, bonded_indentation, dundurs
from .foundation import WinklerContact, winkler
from .half_space import half_plane_displacement, half_space_displacement
from .hertz import HertzLine, HertzPoint, hertz_line, hertz_point
from .hertz_ellipse import HertzElliptic, hertz_elliptic
from .hertz_impact import HertzImpact, hertz_impact
from .impact import BarImpact, YieldVelocity, bar_impact, impact_stress, yield_velocity
from .indenters import Cone, Wedge, cone, wedge
from .partial_slip import CattaneoMindlin, CattaneoMindlinLine, cattaneo_mindlin, cattaneo_mindlin_line
from .plasticity import (
    LineShakedown,
    PlasticBarImpact,
    PlasticCycle,
    PlasticCylinder,
    PlasticSphere,
    line_shakedown,
    plastic_bar_impact,
    plastic_cycle,
    plastic_cylinder,
    plastic_sphere,
    prandtl_pressure,
)
from .punch import CircularPunch, FlatPunch, circular_punch, flat_punch
from .rolling import Carter, carter
from .statics import BarPull, PressFit, bar_pull, press_fit
from .stress import Stress

__all__ = [
    "BarImpact",
    "BarPull",
    "Bodies",
    "BondedIndentation",
    "Carter",
    "CattaneoMindlin",
    "CattaneoMindlinLine",
    "CircularPunch",
    "Cone",
    "Dundurs",
    "FlatPunch",
    "HertzElliptic",
    "HertzImpact",
    "HertzLine",
    "HertzPoint",
    "LineShakedown",
    "PlasticBarImpact",
    "PlasticCycle",
    "PlasticCylinder",
    "PlasticSphere",
    "PressFit",
    "RelativeCurvature",
    "Stress",
    "Wedge",
    "WinklerContact",
    "YieldVelocity",
    "bar_impact",
    "bar_pull",
    "bentall_johnson",
    "bonded_indentation",
    "carter",
    "cattaneo_mindlin",
    "cattaneo_mindlin_line",
    "circular_punch",
    "cone",
    "dundurs",
    "effective_modulus",
    "flat_punch",
    "half_plane_displacement",
    "half_space_displacement",
    "hertz_elliptic",
    "hertz_impact",
    "hertz_line",
    "hertz_point",
    "impact_stress",
    "line_shakedown",
    "plastic_bar_impact",
    "plastic_cycle",
    "plastic_cylinder",
    "plastic_sphere",
    "prandtl_pressure",
    "press_fit",
    "profile",
    "relative_curvature",
    "wedge",
    "winkler",
    "yield_velocity",
]
