# SPDX-License-Identifier: MIT
"""External virtual work: body force, dead traction, pressure that follows the surface; seed (3.25), (3.27), (3.46)."""

import ufl

from .materials import gradient, weight


def body_force(f, v, hypothesis="3d", dx=ufl.dx):
    """Integral of f . v; f per volume [F/L^3]."""
    mesh = ufl.domain.extract_unique_domain(v)
    return ufl.inner(f, v) * weight(mesh, hypothesis) * dx


def traction(t, v, hypothesis="3d", ds=ufl.ds):
    """Integral of t . v over a boundary; t per reference area [F/L^2]."""
    mesh = ufl.domain.extract_unique_domain(v)
    return ufl.inner(t, v) * weight(mesh, hypothesis) * ds


def follower_pressure(p, u, v, hypothesis="3d", ds=ufl.ds):
    """Virtual work of a pressure p >= 0 that pushes on the deformed surface: - integral of p J F^-T n . v (Nanson)."""
    mesh = ufl.domain.extract_unique_domain(v)
    H = gradient(u, hypothesis)
    F = ufl.Identity(H.ufl_shape[0]) + H
    area = ufl.as_tensor([[F[1, 1], -F[1, 0]], [-F[0, 1], F[0, 0]]]) if F.ufl_shape[0] == 2 else _cofactor(F)
    n = ufl.FacetNormal(mesh)
    normal = n if F.ufl_shape[0] == len(n) else ufl.as_vector([n[0], n[1], 0])
    pushed = area * normal
    return -p * sum(pushed[i] * v[i] for i in range(len(v))) * weight(mesh, hypothesis) * ds


def _cofactor(F):
    """J F^-T without division."""
    return ufl.as_tensor(
        [
            [
                F[(i + 1) % 3, (j + 1) % 3] * F[(i + 2) % 3, (j + 2) % 3]
                - F[(i + 1) % 3, (j + 2) % 3] * F[(i + 2) % 3, (j + 1) % 3]
                for j in range(3)
            ]
            for i in range(3)
        ]
    )


def follower_pressure_tangent(p, u, du, v, hypothesis="3d", ds=ufl.ds):
    """Derivative of follower_pressure at u in the direction du."""
    return ufl.derivative(follower_pressure(p, u, v, hypothesis, ds), u, du)
