# SPDX-License-Identifier: MIT
"""Contact-impact for DOLFINx: UFL forms compiled to verified C++ kernels.

This package exports the classes that a user composes. Its subpackages follow the data flow: assembly (kernels,
operators, lumped mass), contact, statics, dynamics, io. `dolfinx_impact.forms` has the physics in UFL, `theory` has
closed-form solutions, and `verify`, a package beside this one, compares it with the hand-written solver.
"""

from .compat import model_to_mesh  # first: it refuses a DOLFINx that this package was not tried on
from . import _cpp, forms, theory, verify
from .amplitude import AmplitudeTable, PrescribedMotion
from .common.lone_error import abort_at_exit
from .common.moved_packages import find_moved_modules
from .common.units import MILLIMETRES, SI, Units
from .common.visible_warnings import undo_capture
from .contact import (
    ContactPair,
    ContactStatus,
    GeneralContact,
    Kinematic,
    Lagrange,
    Penalty,
    RigidBody,
    RigidCylinder,
    RigidPlane,
    RigidSphere,
    RigidSurface,
    Tie,
)
from .dynamics.explicit import ExplicitProblem
from .dynamics.implicit.newmark_problem import NewmarkProblem
from .assembly import jit, operators
from .assembly.jit import cache_folder, compile_expression, compile_form
from .interface import FrictionLaw, InterfaceLaw, InterfaceUpdate
from .loads import BodyForce, FollowerPressure, Traction
from .foundation import Foundation
from .added_mass import AddedMass
from .assembly.lumped_mass import lumped_mass
from .assembly.quadrature_degree import quadrature_degree
from .assembly.section_force import section_force
from .forms.cell_maximum import cell_max
from .inelastic import InelasticMaterial, MaterialFlow, MaterialUpdate
from .materials import LinearElastic, MaterialMap, NeoHookean, Rayleigh, StVenantKirchhoff
from .plasticity import ArmstrongFrederick, J2Plasticity, Table, Voce
from .io.deformed_body import DeformedBody
from .io.mesh_reader import check_mesh, read_mesh
from .io.partition import PartitionedMesh, partition
from .assembly.operators import Energy, InternalForce, PointValues, Tangent
from .rolling.motions import Spin, Translation
from .rolling.rolling_problem import RollingProblem
from .statics.static_problem import StaticProblem

undo_capture()
abort_at_exit()
find_moved_modules()

__version__ = "0.1.0"

__all__ = [
    "AddedMass",
    "AmplitudeTable",
    "ArmstrongFrederick",
    "BodyForce",
    "DeformedBody",
    "Energy",
    "ExplicitProblem",
    "FollowerPressure",
    "Foundation",
    "FrictionLaw",
    "GeneralContact",
    "InelasticMaterial",
    "InterfaceLaw",
    "InterfaceUpdate",
    "InternalForce",
    "J2Plasticity",
    "LinearElastic",
    "MILLIMETRES",
    "MaterialFlow",
    "MaterialMap",
    "MaterialUpdate",
    "NeoHookean",
    "NewmarkProblem",
    "PartitionedMesh",
    "PointValues",
    "PrescribedMotion",
    "Rayleigh",
    "RollingProblem",
    "SI",
    "Spin",
    "StVenantKirchhoff",
    "StaticProblem",
    "Table",
    "Tangent",
    "Traction",
    "Translation",
    "Units",
    "Voce",
    "ContactPair",
    "ContactStatus",
    "Kinematic",
    "Lagrange",
    "Penalty",
    "RigidBody",
    "RigidCylinder",
    "RigidPlane",
    "RigidSphere",
    "RigidSurface",
    "Tie",
    "_cpp",
    "cache_folder",
    "cell_max",
    "check_mesh",
    "compile_expression",
    "compile_form",
    "forms",
    "jit",
    "lumped_mass",
    "model_to_mesh",
    "operators",
    "partition",
    "quadrature_degree",
    "read_mesh",
    "section_force",
    "theory",
    "verify",
]
