"""Bulk viscosity, which damps shock fronts and the ringing behind them; docs/explicit.md."""

import ufl

from .materials import weight

SIMPLEX = {"triangle": 2, "tetrahedron": 6}


def bulk(velocity, v, law, density, linear, quadratic, dx=ufl.dx):
    """Virtual work of the pressure -q = linear rho c_d L e + quadratic^2 rho L^2 |e| min(0, e), e = div velocity.

    L is the size of the cell, c_d the dilatational wave speed. Von Neumann and Richtmyer (1950), Landshoff (1955).

    Args:
        velocity: UFL function [L/T]. density: per reference volume [M/L^3]. linear, quadratic: factors [1].
    """
    mesh = ufl.domain.extract_unique_domain(velocity)
    dim, cell = mesh.geometric_dimension(), mesh.ufl_cell().cellname()
    length = (SIMPLEX.get(cell, 1) * abs(ufl.JacobianDeterminant(mesh))) ** (1.0 / dim)
    rate = ufl.tr(law.gradient(velocity))
    speed = ufl.sqrt((law._lambda + 2 * law.mu) / density)
    compression = (rate - abs(rate)) / 2
    pressure = density * length * (linear * speed * rate + quadratic**2 * length * abs(rate) * compression)
    return pressure * ufl.tr(law.gradient(v)) * weight(mesh, law.hypothesis) * dx
