# SPDX-License-Identifier: MIT
"""Rayleigh damping C = alpha M + beta K, the damping term of seed (3.67)."""

from . import elasticity, inertia


def rayleigh(velocity, v, law, density, alpha, beta, mass_dx, stiffness_dx):
    """Virtual work of damping, alpha * mass(velocity, v) + beta * (linear elastic internal work of velocity).

    Args:
        velocity: UFL function, or trial function for the damping matrix [L/T].
        law: a linear law; its stiffness is the one that damps.
        alpha: mass factor [1/T].
        beta: stiffness factor [T].
    """
    if not law.linear:
        raise ValueError(f"Rayleigh damping takes the stiffness of a linear law, not of {law.name}")
    stiffness = elasticity.internal_force(velocity, v, law, stiffness_dx)
    return alpha * inertia.mass(velocity, v, density, law.hypothesis, mass_dx) + beta * stiffness
