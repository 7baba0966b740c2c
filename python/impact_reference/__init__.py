# SPDX-License-Identifier: MIT
"""The hand-written finite element solver: it takes and returns NumPy arrays and uses no part of FEniCS.

Classical elements (B^T D B, shape functions, quadrature tables and node order of its own) verify the kernels that are
generated from UFL. `reference_nodes` states the node order; degrees of freedom are node-major with the component
fastest. The user chooses the units; docstrings give dimensions: [L] length, [F] force, [M] mass, [T] time.
"""

from . import (
    contact,
    elements,
    explicit,
    interface,
    model,
    newmark,
    plastic_body,
    plasticity,
    rigid_body,
    rigid_meeting,
    rolling,
    rotation,
    rules,
    sparse,
    streamlines,
)
from ._reference import Material
from .contact import Contact, ContactSolution, RigidCylinder, RigidPlane, RigidSphere
from .discretisation import StaticSolution
from .elements import (
    element_ale_inertia,
    element_ale_load,
    element_b_matrix,
    element_body_force,
    element_damping,
    element_energy,
    element_flux_load,
    element_follower_pressure,
    element_foundation,
    element_gyroscopic,
    element_internal_force,
    element_lumped_mass,
    element_mass,
    element_poisson,
    element_scalar_load,
    element_stiffness,
    element_stress,
    element_tangent,
    element_traction,
    second_piola,
)
from .explicit import ExplicitResult, GeneralContact, NodalKinematic, NodalPenalty, RigidBall
from .interface import (
    InterfaceHistory,
    adhesive_pressure,
    cohesive_history,
    damped_pressure,
    exponential_pressure,
    friction_history,
    spring_pressure,
)
from .model import Model
from .newmark import ImplicitContact, NewmarkContactHistory, NewmarkResult, NewmarkScheme
from .plastic_body import PlasticBody, PlasticStates
from .plasticity import J2Answer, J2History, J2Parameters, J2Point, PlasticElement, element_plastic
from .rigid_body import RigidBody
from .rolling import RollingModel, RollingSolution, Spinning, Translating
from .rules import (
    default_rule,
    facet_nodes,
    facet_type,
    facets,
    quadrature,
    reference_nodes,
    shape_functions,
)
from .sliding_mass import SlidingMass
from .sparse import Csr
from .tie import Tie, TieSolution

__all__ = [
    "Contact",
    "ContactSolution",
    "Csr",
    "ExplicitResult",
    "GeneralContact",
    "ImplicitContact",
    "InterfaceHistory",
    "J2Answer",
    "J2History",
    "J2Parameters",
    "J2Point",
    "Material",
    "Model",
    "NewmarkContactHistory",
    "NewmarkResult",
    "NewmarkScheme",
    "NodalKinematic",
    "NodalPenalty",
    "PlasticBody",
    "PlasticElement",
    "PlasticStates",
    "RigidBall",
    "RigidBody",
    "RigidCylinder",
    "RigidPlane",
    "RigidSphere",
    "RollingModel",
    "RollingSolution",
    "SlidingMass",
    "Spinning",
    "StaticSolution",
    "Tie",
    "TieSolution",
    "Translating",
    "adhesive_pressure",
    "cohesive_history",
    "contact",
    "damped_pressure",
    "default_rule",
    "element_ale_inertia",
    "element_ale_load",
    "element_b_matrix",
    "element_body_force",
    "element_damping",
    "element_energy",
    "element_flux_load",
    "element_follower_pressure",
    "element_foundation",
    "element_gyroscopic",
    "element_internal_force",
    "element_lumped_mass",
    "element_mass",
    "element_plastic",
    "element_poisson",
    "element_scalar_load",
    "element_stiffness",
    "element_stress",
    "element_tangent",
    "element_traction",
    "elements",
    "explicit",
    "exponential_pressure",
    "facet_nodes",
    "facet_type",
    "facets",
    "friction_history",
    "interface",
    "model",
    "newmark",
    "plastic_body",
    "plasticity",
    "quadrature",
    "reference_nodes",
    "rigid_body",
    "rigid_meeting",
    "rolling",
    "rotation",
    "rules",
    "second_piola",
    "shape_functions",
    "sparse",
    "spring_pressure",
    "streamlines",
]
