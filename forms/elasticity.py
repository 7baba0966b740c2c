# SPDX-License-Identifier: MIT
"""Internal virtual work, its tangent and its energy for the laws of materials.py; seed (3.17)-(3.30)."""

import ufl

from . import one_point
from .materials import stress_components, weight
from .point_law import PointLaw

STRESS = "stress"


def internal_energy(u, law, dx=ufl.dx):
    """Strain energy, integral of psi(u), that of hourglass modes included [F L]."""
    if law.integration == "reduced":
        return one_point.internal_energy(u, law, dx)
    return energy_integrand(u, law) * dx


def energy_integrand(u, law):
    """Integrand of `internal_energy`."""
    if law.integration == "reduced":
        return one_point.energy_density(u, law)
    mesh = ufl.domain.extract_unique_domain(u)
    return law.energy_density(u) * weight(mesh, law.hypothesis)


def internal_force(u, v, law, dx=ufl.dx):
    """Internal virtual work, integral of stress(u) : grad v, seed (3.27), total Lagrangian for finite strain."""
    if law.integration == "reduced":
        return one_point.internal_force(u, v, law, dx)
    mesh = ufl.domain.extract_unique_domain(u)
    return ufl.inner(law.stress(u), law.gradient(v)) * weight(mesh, law.hypothesis) * dx


def tangent(u, du, v, law, dx=ufl.dx):
    """Derivative of the internal virtual work at u in the direction du, seed (3.25), (3.65)."""
    if law.integration == "reduced":
        return one_point.tangent(u, du, v, law, dx)
    mesh = ufl.domain.extract_unique_domain(v)
    return ufl.inner(law.stress_derivative(u, du), law.gradient(v)) * weight(mesh, law.hypothesis) * dx


def internal_force_with_stress(u, v, law, dx=ufl.dx):
    """Internal virtual work, and a point law with the Cauchy stress as the output "stress" (stress_components)."""
    at_points = one_point.mean_law(u, law) if law.integration == "reduced" else law
    stress = at_points.cauchy_stress(u)
    components = [stress[i, j] for i, j in stress_components(len(u))]
    return internal_force(u, v, law, dx), PointLaw(outputs={STRESS: ufl.as_vector(components)})
