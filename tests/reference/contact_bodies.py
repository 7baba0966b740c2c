# SPDX-License-Identifier: MIT
"""Pairs of bodies for the contact tests of the hand-written solver."""

import impact_reference as ir
import numpy as np
from reference_meshes import box, dofs, facets_where, nodes_where

DEGREES = [(1, 1), (1, 2), (2, 1), (2, 2)]  # of the displacement and of the geometry


def in_space(cell):
    return gdim_of(cell) == 3


def gdim_of(cell):
    return 2 if cell in ("triangle", "quadrilateral") else 3


def material(cell, E=1e3, nu=0.3, hypothesis=None, law="linear_elastic"):
    return ir.Material(E, nu, hypothesis=hypothesis or ("plane_strain" if gdim_of(cell) == 2 else "3d"), law=law)


class Pair:
    """Lower body (master) and upper body (slave) in one model, not connected."""

    def __init__(self, lower, upper, cell, law, degree=1, geometry_degree=1):
        self.cell, self.gdim, self.split = cell, gdim_of(cell), len(lower[0])
        self.lower, self.upper = lower, upper
        points, cells = np.vstack([lower[0], upper[0]]), np.vstack([lower[1], upper[1] + self.split])
        self.model = ir.Model(points, cells, cell, law, degree=degree, geometry_degree=geometry_degree)

    def facets(self, upper, where):
        points, cells = self.upper if upper else self.lower
        return facets_where(points, cells, self.cell, where) + (self.split if upper else 0)

    def held(self, *conditions):
        """(dofs, values) of (where, components, value) conditions; later ones do not override earlier ones."""
        value_of = {}
        for where, components, value in conditions:
            for dof in dofs(nodes_where(self.model.field_points, where), components, self.gdim):
                value_of.setdefault(int(dof), value)
        return np.array(list(value_of)), np.array(list(value_of.values()))


def blocks(cell, degree=1, geometry_degree=1, lower=None, upper=None, gap=0.0, mapping=None, shift=0.0, **law):
    """Unit block (-1 < last coordinate < 0) under a unit block, cut into `lower` and `upper` cells, then mapped."""
    d = gdim_of(cell)
    lower, upper = lower or ((3, 2), (2, 2, 1))[d - 2], upper or ((4, 2), (3, 3, 1))[d - 2]
    p, c = box(cell, lower, geometry_degree)
    q, e = box(cell, upper, geometry_degree)
    p, q = p - np.eye(d)[-1], q + gap * np.eye(d)[-1] + shift * np.eye(d)[0]
    mapped = [np.array([x if mapping is None else mapping(x) for x in points]) for points in (p, q)]
    pair = Pair((mapped[0], c), (mapped[1], e), cell, material(cell, **law), degree, geometry_degree)
    pair.slave = facets_where(q, e, cell, lambda x: abs(x[-1] - gap) < 1e-9) + pair.split
    pair.master = facets_where(p, c, cell, lambda x: abs(x[-1]) < 1e-9)
    return pair


def central_difference(function, u, direction, step):
    return (function(u + step * direction) - function(u - step * direction)) / (2 * step)


def moment(points, forces):
    """Sum of x times f: a number about z in the plane, a vector in space."""
    if points.shape[1] == 2:
        return np.sum(points[:, 0] * forces[:, 1] - points[:, 1] * forces[:, 0])
    return np.cross(points, forces).sum(0)
