# SPDX-License-Identifier: MIT
"""Node orders of the two sides, matched by the positions of the nodes on the reference cell."""

from functools import lru_cache

import basix
import basix.ufl
import impact_reference
import numpy as np

TENSOR = ("quadrilateral", "hexahedron")


@lru_cache(maxsize=None)
def _permutation(cell, degree):
    ours = basix.ufl.element("Lagrange", cell, degree).basix_element.points
    theirs = impact_reference.reference_nodes(cell, degree)
    if cell in TENSOR:  # [-1, 1]^d there, [0, 1]^d here
        theirs = (theirs + 1) / 2
    distance = np.linalg.norm(ours[:, None, :] - theirs[None, :, :], axis=2)
    order = np.argmin(distance, axis=1)
    if len(set(order)) != len(order) or distance[np.arange(len(order)), order].max() > 1e-12:
        raise RuntimeError(f"the nodes of the two sides do not match on {cell}s of degree {degree}")
    return order


def permutation(cell, degree):
    """theirs[i]: number, in the hand-written solver's order, of our node i."""
    return _permutation(cell, degree).copy()


def dofs(cell, degree, components):
    """The same for degrees of freedom, node-major with the component fastest."""
    order = permutation(cell, degree)
    return (components * order[:, None] + np.arange(components)).ravel()


def reflection(cell, degree):
    """Order of a cell's nodes, in the other side's numbers, after its first two axes are swapped."""
    x = impact_reference.reference_nodes(cell, degree)
    mirrored = x[:, [1, 0, *range(2, x.shape[1])]]
    return np.argmin(np.linalg.norm(mirrored[:, None] - x[None], axis=2), axis=1)


def to_theirs(values, order):
    """Rows of an array from our order into theirs."""
    out = np.empty_like(values)
    out[order] = values
    return out


def facet_vertices(cell, facet):
    """Local vertices, in the other side's numbers, of our local facet."""
    topology = basix.topology(getattr(basix.CellType, cell))
    vertices = permutation(cell, 1)
    return [int(vertices[v]) for v in topology[-2][facet]]


def num_facets(cell):
    return len(basix.topology(getattr(basix.CellType, cell))[-2])


def nodes(cell, degree):
    """Our reference nodes, shape (num_nodes, tdim)."""
    return basix.ufl.element("Lagrange", cell, degree).basix_element.points


def random_cell(rng, cell, geometry_degree, hypothesis, distortion=0.12):
    """Geometry nodes of a random, distorted (curved) cell in our order, shape (num_nodes, gdim).

    A random linear map of the reference cell, then every node is moved by up to `distortion` times the cell's size;
    small enough to keep the Jacobian's sign. Axisymmetric cells are shifted to positive radii.
    """
    x = nodes(cell, geometry_degree)
    dim = x.shape[1]
    while True:
        A = np.eye(dim) + 0.4 * rng.uniform(-1, 1, (dim, dim))
        if np.linalg.det(A) > 0.3:
            break
    moved = x + distortion / geometry_degree * rng.uniform(-1, 1, x.shape)
    y = moved @ A.T * rng.uniform(0.5, 2.0)
    if hypothesis == "axisymmetric":
        y[:, 0] += 0.5 - y[:, 0].min()
    return y
