# SPDX-License-Identifier: MIT
"""Node orders of the two sides, matched by the positions of the nodes on the reference cell."""

from functools import lru_cache
from typing import TypeAlias, Union

import basix
import basix.ufl
import impact_reference
import numpy as np

from dolfinx_impact.common.types import AnyArray, ArrayLike, FloatArray, IntArray

TENSOR = ("quadrilateral", "hexahedron")
# Rule of the hand-written solver: its name, or its points and weights; None is the solver's default.
TheirRule: TypeAlias = Union[str, tuple[ArrayLike, ArrayLike], None]


@lru_cache(maxsize=None)
def _permutation(cell: str, degree: int) -> IntArray:
    ours = basix.ufl.element("Lagrange", cell, degree).basix_element.points
    theirs = impact_reference.reference_nodes(cell, degree)
    if cell in TENSOR:  # [-1, 1]^d there, [0, 1]^d here
        theirs = (theirs + 1) / 2
    distance = np.linalg.norm(ours[:, None, :] - theirs[None, :, :], axis=2)
    order = np.argmin(distance, axis=1)
    if len(set(order)) != len(order) or distance[np.arange(len(order)), order].max() > 1e-12:
        raise RuntimeError(f"the nodes of the two sides do not match on {cell}s of degree {degree}")
    return order


def permutation(cell: str, degree: int) -> IntArray:
    """Numbers of our nodes of a cell in the hand-written solver's order.

    Args:
        cell: cell.
        degree: degree of the element, 1 or 2.

    Returns:
        Entry i is the other side's number of our node i, shape (num_nodes).

    Raises:
        RuntimeError: the nodes of the two sides do not match.
    """
    return _permutation(cell, degree).copy()


def dofs(cell: str, degree: int, components: int) -> IntArray:
    """Numbers of our degrees of freedom of a cell in the hand-written solver's order.

    Args:
        cell: cell.
        degree: degree of the element, 1 or 2.
        components: number of components per node; the component is the fastest index.

    Returns:
        Entry i is the other side's number of our degree of freedom i, shape (components * num_nodes).
    """
    order = permutation(cell, degree)
    return (components * order[:, None] + np.arange(components)).ravel()


def reflection(cell: str, degree: int) -> IntArray:
    """Order of a cell's nodes after its first two axes are swapped.

    Args:
        cell: cell.
        degree: degree of the element, 1 or 2.

    Returns:
        Numbers of the other side's nodes, shape (num_nodes).
    """
    x = impact_reference.reference_nodes(cell, degree)
    mirrored = x[:, [1, 0, *range(2, x.shape[1])]]
    return np.argmin(np.linalg.norm(mirrored[:, None] - x[None], axis=2), axis=1)


def to_theirs(values: AnyArray, order: IntArray) -> AnyArray:
    """Reorder the rows of an array from our order to theirs.

    Args:
        values: array, shape (n, ...).
        order: the other side's number of each of our rows, shape (n).

    Returns:
        Array in their order, shape (n, ...).
    """
    out = np.empty_like(values)
    out[order] = values
    return out


def facet_vertices(cell: str, facet: int) -> list[int]:
    """Vertices of one of our local facets.

    Args:
        cell: cell.
        facet: our local number of the facet.

    Returns:
        Local vertices in the other side's numbers.
    """
    topology = basix.topology(getattr(basix.CellType, cell))
    vertices = permutation(cell, 1)
    return [int(vertices[v]) for v in topology[-2][facet]]


def num_facets(cell: str) -> int:
    """Number of facets of a cell.

    Args:
        cell: cell.

    Returns:
        Number of facets.
    """
    return len(basix.topology(getattr(basix.CellType, cell))[-2])


def nodes(cell: str, degree: int) -> FloatArray:
    """Our nodes of the reference cell.

    Args:
        cell: cell.
        degree: degree of the element, 1 or 2.

    Returns:
        Reference coordinates, shape (num_nodes, tdim) [1].
    """
    return basix.ufl.element("Lagrange", cell, degree).basix_element.points


def random_cell(
    rng: np.random.Generator, cell: str, geometry_degree: int, hypothesis: str, distortion: float = 0.12
) -> FloatArray:
    """Geometry nodes of a random, distorted (curved) cell.

    The reference cell is mapped by a random linear map; then every node is moved, by little enough to keep the sign of
    the Jacobian. Axisymmetric cells are shifted to positive radii.

    Args:
        rng: random numbers.
        cell: cell.
        geometry_degree: degree of the geometry, 1 or 2.
        hypothesis: "axisymmetric" keeps radii positive.
        distortion: largest motion of a node over the cell's size [1].

    Returns:
        Nodes in our order, shape (num_nodes, gdim) [L].
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
