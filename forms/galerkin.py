# SPDX-License-Identifier: MIT
"""Weighted residuals, seed (3.31)-(3.37), for a Poisson-type problem: the first check of Galerkin's method itself.

Strong form: H(u) = div(k grad u) + f = 0 in the domain, J(u) = q - k grad u . n = 0 on the flux boundary.
"""

import ufl


def weighted_residual(u, w, k, f, q, dx=ufl.dx, ds=ufl.ds):
    """Integral of w H(u) + integral of w J(u), integrated by parts, with the sign changed: zero at the solution.

    Args:
        u: field.
        w: weight; Galerkin's choice is the test function, seed (3.36).
        k: conductivity.
        f: source per volume.
        q: flux into the body per area.
    """
    return flux(u, w, k, dx) - ufl.inner(f, w) * dx - ufl.inner(q, w) * ds


def flux(u, w, k, dx=ufl.dx):
    """Integral of k grad u . grad w: the stiffness of the scalar problem."""
    return k * ufl.inner(ufl.grad(u), ufl.grad(w)) * dx
