# SPDX-License-Identifier: MIT
"""Foamed rubber of Blatz and Ko (1962), a law that the package does not know, for Python and for C++.

The energy per reference volume is W = mu/2 (tr C^-1 + 2 J - 5) with C = F^T F and J = det F. In a bar that is stretched
by s, the sides are free with the stretch s^(-1/4), and the force per reference area is mu (s^(-1/2) - s^(-3)).

    dolfinx-impact verify foam.py                  # is it consistent?
    dolfinx-impact compile foam.py -o foam.h       # kernels for a C++ program
"""

import ufl
from dolfinx import fem

import dolfinx_impact as di


def foam(mesh, degree=1):
    """The law in space, and in plane strain."""
    V = fem.functionspace(mesh, ("Lagrange", degree, (mesh.geometry.dim,)))
    u, v = fem.Function(V, name="displacement"), ufl.TestFunction(V)
    mu = fem.Constant(mesh, 0.3e6)  # shear modulus [Pa]
    H = ufl.grad(u)
    if mesh.geometry.dim == 2:
        H = ufl.as_tensor([[H[0, 0], H[0, 1], 0], [H[1, 0], H[1, 1], 0], [0, 0, 0]])
    F = ufl.variable(ufl.Identity(3) + H)
    J, inverse = ufl.det(F), ufl.inv(F)
    W = mu / 2 * (ufl.inner(inverse, inverse) + 2 * J - 5)
    energy = W * ufl.dx(degree=di.quadrature_degree(u))
    stress = ufl.diff(W, F) * F.T / J  # Cauchy's
    return di.verify.OwnForm(ufl.derivative(energy, u, v), u, energy=energy, stress=stress, parameters={"mu": mu})
