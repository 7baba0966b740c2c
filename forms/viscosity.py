# SPDX-License-Identifier: MIT
"""Bulk viscosity, which damps shock fronts and the ringing behind them; docs/explicit/scheme.md."""

import ufl

from .materials import weight


def bulk(u, velocity, v, law, density, linear, quadratic, dx=ufl.dx):
    """Virtual work of the pressure -q = linear rho c_d L e + quadratic^2 rho L^2 |e| min(0, e), e = div velocity.

    L is the size of the reference cell, c_d the dilatational wave speed (3.80). Laws of finite strain: e = F^-T : Grad
    velocity and the stress q J F^-T, which a turning body does not feel. Von Neumann and Richtmyer (1950), Landshoff
    (1955).

    Args:
        u: displacement, UFL function [L].
        velocity: UFL function [L/T].
        density: per reference volume [M/L^3].
        linear, quadratic: factors [1].
    """
    mesh = ufl.domain.extract_unique_domain(velocity)
    length = abs(ufl.JacobianDeterminant(mesh)) ** (1.0 / len(ufl.SpatialCoordinate(mesh)))
    rates, test = law.gradient(velocity), law.gradient(v)
    if law.linear:
        rate, virtual = ufl.tr(rates), ufl.tr(test)
    else:
        F = law.gradient(u) + ufl.Identity(rates.ufl_shape[0])
        inverse = ufl.inv(F).T
        rate, virtual = ufl.inner(inverse, rates), ufl.det(F) * ufl.inner(inverse, test)
    speed = ufl.sqrt((law.lmbda + 2 * law.mu) / density)
    compression = (rate - abs(rate)) / 2
    pressure = density * length * (linear * speed * rate + quadratic**2 * length * abs(rate) * compression)
    return pressure * virtual * weight(mesh, law.hypothesis) * dx
