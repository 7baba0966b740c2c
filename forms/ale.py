# SPDX-License-Identifier: MIT
"""Rolling in the ALE frame: a body that turns with a given spin on a mesh that does not; seed (3.49)-(3.57), corrected.

w = Omega x (X - centre) is the velocity of the material through the mesh, A = Grad N . w the convective derivative of
the shape functions. Needs w . N = 0 on the boundary of a body of revolution.
"""

import ufl


def convection(mesh, spin, centre):
    """Velocity w = Omega x (X - centre) [L/T]. spin: a scalar about z in 2D, a vector in 3D [1/T]; centre: point
    [L]."""
    x = ufl.SpatialCoordinate(mesh)
    if len(x) == 2:
        return ufl.as_vector([-spin * (x[1] - centre[1]), spin * (x[0] - centre[0])])
    return ufl.cross(spin, x - centre)


def gyroscopic(velocity, v, density, w, dx=ufl.dx):
    """G, seed (3.56): integral of density (v . Grad velocity w - Grad v w . velocity); skew-symmetric."""
    forward = ufl.inner(ufl.grad(velocity) * w, v)
    backward = ufl.inner(velocity, ufl.grad(v) * w)
    return density * (forward - backward) * dx


def ale_inertia(u, v, density, w, dx=ufl.dx):
    """W, seed (3.57): integral of density (Grad u w) . (Grad v w); symmetric."""
    return density * ufl.inner(ufl.grad(u) * w, ufl.grad(v) * w) * dx


def centrifugal_load(v, density, w, dx=ufl.dx):
    """f_inertia at zero displacement, seed (3.54): integral of density w . (Grad v w)."""
    return density * ufl.inner(w, ufl.grad(v) * w) * dx


def momentum_balance(u, velocity, acceleration, v, law, density, w, f, dx=ufl.dx):
    """Weak form of the balance of momentum, seed (3.53) corrected and integrated by parts: residual, zero at the
    solution.

    With D/Dt = d/dt + w . Grad the inertia term becomes density (a . v + 2 (Grad velocity w) . v - (Grad phi w) . (Grad
    v w)) after Grad phi = I + Grad u; f is a force per unit mass. The gyroscopic pair is written skew, as in seed
    (3.56).
    """
    stiffness = ufl.inner(law.stress(u), law.gradient(v))
    deformed = w + ufl.grad(u) * w
    gyro = ufl.inner(ufl.grad(velocity) * w, v) - ufl.inner(velocity, ufl.grad(v) * w)
    inertia = ufl.inner(acceleration, v) + gyro - ufl.inner(deformed, ufl.grad(v) * w)
    return (stiffness + density * (inertia - ufl.inner(f, v))) * dx
