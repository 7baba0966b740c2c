# SPDX-License-Identifier: MIT
"""The hand-written finite element solver: NumPy in, NumPy out, no FEniCS inside.

Classical elements (B^T D B, own shape functions, own quadrature tables, own node order) against which the kernels
generated from UFL are verified. See `reference_nodes` for the node order; degrees of freedom are node-major with the
component fastest. Units are the caller's; the docstrings give dimensions: [L] length, [F] force, [M] mass, [T] time.
"""

from . import contact, elements, explicit, model, rules, sparse
from ._reference import Material
from .contact import Contact, ContactSolution, RigidCylinder, RigidPlane, RigidSphere
from .elements import (
    element_ale_inertia,
    element_ale_load,
    element_b_matrix,
    element_body_force,
    element_damping,
    element_energy,
    element_flux_load,
    element_follower_pressure,
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
from .explicit import ExplicitResult, NodalKinematic, NodalPenalty
from .model import Model, StaticSolution
from .rules import (
    default_rule,
    facet_nodes,
    facet_type,
    facets,
    quadrature,
    reference_nodes,
    shape_functions,
)
from .sparse import Csr

__all__ = [
    "Contact",
    "ContactSolution",
    "Csr",
    "ExplicitResult",
    "Material",
    "Model",
    "NodalKinematic",
    "NodalPenalty",
    "RigidCylinder",
    "RigidPlane",
    "RigidSphere",
    "StaticSolution",
    "contact",
    "default_rule",
    "element_ale_inertia",
    "element_ale_load",
    "element_b_matrix",
    "element_body_force",
    "element_damping",
    "element_energy",
    "element_flux_load",
    "element_follower_pressure",
    "element_gyroscopic",
    "element_internal_force",
    "element_lumped_mass",
    "element_mass",
    "element_poisson",
    "element_scalar_load",
    "element_stiffness",
    "element_stress",
    "element_tangent",
    "element_traction",
    "elements",
    "explicit",
    "facet_nodes",
    "facet_type",
    "facets",
    "model",
    "quadrature",
    "reference_nodes",
    "rules",
    "second_piola",
    "shape_functions",
    "sparse",
]
