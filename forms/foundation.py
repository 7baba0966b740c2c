# SPDX-License-Identifier: MIT
"""Winkler's foundation: independent springs or dashpots between a surface and the ground; seed (3.9), (3.10)."""

import ufl

from .materials import weight


def foundation(k, u, v, hypothesis="3d", ds=ufl.ds):
    """Internal virtual work of springs along a boundary, the integral of k (u . n) (v . n), or of the sum of
    k_i u_i v_i; of dashpots with a velocity in place of u.

    Args:
        k: a scalar: along the normal n of the reference configuration only; a vector: along each coordinate
            [F/L^3], of dashpots [F T/L^3].
        u: displacement, or velocity.
        v: test function.
    """
    mesh = ufl.domain.extract_unique_domain(v)
    if k.ufl_shape == ():
        n = ufl.FacetNormal(mesh)
        density = k * ufl.dot(u, n) * ufl.dot(v, n)
    else:
        density = sum(k[i] * u[i] * v[i] for i in range(len(v)))
    return density * weight(mesh, hypothesis) * ds
