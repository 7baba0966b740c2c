# SPDX-License-Identifier: MIT
"""Inertia: consistent mass, its action and the vector of nodal quadrature; the inertia term of seed (3.46),
corrected."""

import numpy as np
import ufl

from .materials import weight


def mass(u, v, density, hypothesis="3d", dx=ufl.dx):
    """Virtual work of inertia, integral of density u . v: a matrix when u is a trial function [M]."""
    mesh = ufl.domain.extract_unique_domain(v)
    return density * ufl.inner(u, v) * weight(mesh, hypothesis) * dx


def row_sum(v, density, hypothesis="3d", dx=ufl.dx):
    """Row sums of the mass matrix, integral of density 1 . v; with a rule at the nodes: the nodal (GLL) lumped mass."""
    mesh = ufl.domain.extract_unique_domain(v)
    ones = ufl.as_tensor(np.ones(v.ufl_shape).tolist()) if v.ufl_shape else 1
    return density * ufl.inner(ones, v) * weight(mesh, hypothesis) * dx
