# SPDX-License-Identifier: MIT
"""Explicit scenarios of contact that finds itself, docs/explicit/general_contact.md."""

from collections.abc import Iterator

import basix.ufl
import numpy as np
import ufl
from dolfinx import mesh
from dolfinx.mesh import Mesh
from mpi4py import MPI

from dolfinx_impact.common.types import FloatArray
from ..contact_bodies import grid_of_box, two_bodies
from .placed_bodies import GAP, body_of, falling, open_gap
from .scenario import Scenario, VelocityField
from .variation import RandomVariation

OUTSIDE = 1  # tag of all outer facets
QUARTER = np.sqrt(0.5)


def touching(cell: str, degree: int, variation: RandomVariation = RandomVariation()) -> Iterator[Scenario]:
    """Bodies whose surfaces are not named: in the plane blocks, a thin plate under a block and a strip that folds, in
    space blocks and crossed prisms, in both a block that falls into the notch between two others, with friction.

    Args:
        cell: cell.
        degree: degree of the displacement, 1.
        variation: random variation of the runs.

    Yields:
        Runs.
    """
    plane = cell in ("triangle", "quadrilateral")
    lower, upper = ((6, 3), (4, 3)) if plane else ((3, 3, 2), (2, 2, 2))
    domain, _ = two_bodies(cell, lower, upper, start=(0.33, 0.21), length=(0.9, 0.8))
    open_gap(domain, GAP)
    variation.rotate_upper_body(domain)
    yield _run("two blocks", domain, falling(0.1, 0.05))
    if plane:
        yield _thin_plate(cell, variation)
        yield _strip(cell)
        yield _rings(cell, variation)
    else:
        yield _crossed_prisms(cell, variation)
        yield _sliding_prism(cell)
    yield _notch(cell)


def _run(
    name: str,
    domain: Mesh,
    velocity: VelocityField,
    friction: float = 0.3,
    hypothesis: str | None = None,
    law: str = "neo_hookean",
) -> Scenario:
    dim = domain.geometry.dim
    hypothesis = hypothesis or ("3d" if dim == 3 else "plane_strain")
    domain.topology.create_connectivity(dim - 1, dim)
    facets = mesh.exterior_facet_indices(domain.topology)
    tags = mesh.meshtags(domain, dim - 1, facets, np.full(len(facets), OUTSIDE, dtype=np.int32))
    body = body_of(domain, tags, 1, hypothesis, law, friction=friction)
    steps = 120 if dim == 3 else 250  # the hand-written solver looks at all nodes, facets and edges in every step
    return Scenario(f"{name}, contact without pairs", body, velocity, contact="general", steps=steps)


def _thin_plate(cell: str, variation: RandomVariation) -> Scenario:
    """A block thrown on a plate that is one cell thick."""
    domain, _ = two_bodies(cell, (14, 1), (4, 3), start=(0.33,), length=(0.4,))
    lower = ~open_gap(domain, GAP)
    domain.geometry.x[lower, 1] = 1.0 - 0.08 * (1.0 - domain.geometry.x[lower, 1])
    variation.rotate_upper_body(domain)
    return _run("block on a thin plate", domain, falling(0.1))


def _rings(cell: str, variation: RandomVariation) -> Scenario:
    """Two rings about an axis, of which the upper one falls on the lower one."""
    domain, _ = two_bodies(cell, (5, 3), (4, 3), start=(0.33,), length=(0.9,))
    open_gap(domain, GAP)
    variation.rotate_upper_body(domain)
    domain.geometry.x[:, 0] += 0.6
    return _run("two rings", domain, falling(0.1, 0.05), hypothesis="axisymmetric", law="linear_elastic")


def _strip(cell: str) -> Scenario:
    """A strip bent to a U, whose legs are thrown at each other."""
    length, other, radius, thickness = 1.0, 0.87, 0.15, 0.1  # no node lies right opposite to another one
    kind = getattr(mesh.CellType, cell)
    domain = mesh.create_rectangle(MPI.COMM_SELF, [[0.0, 0.0], [1.0, 1.0]], [36, 2], kind)
    x = domain.geometry.x
    s, y = x[:, 0] * (length + other + np.pi * radius), (x[:, 1] - 0.5) * thickness
    angle, r = np.clip((s - length) / radius, 0.0, np.pi), radius - y
    back = np.maximum(0.0, s - length - np.pi * radius)
    x[:, 0], x[:, 1] = np.minimum(s, length) + r * np.sin(angle) - back, -r * np.cos(angle)

    def velocity(positions: FloatArray) -> FloatArray:
        part = np.clip((length - positions[:, 0]) / length, 0.0, 1.0)
        return np.column_stack([0.0 * part, -0.12 * np.sign(positions[:, 1]) * part])

    return _run("strip that folds", domain, velocity)


def _sliding_prism(cell: str) -> Scenario:
    """As crossed prisms; the upper one slides along the edge of the lower one, over nodes."""
    domain = _prisms(cell, (2, 8, 2), RandomVariation())
    return _run("sliding prism", domain, lambda x: np.where(x[:, 2:] > 1.0 + 0.5 * GAP, (0.0, 0.25, -0.05), 0.0), 0.1)


def _crossed_prisms(cell: str, variation: RandomVariation) -> Scenario:
    """Two prisms that lie crosswise and meet edge on edge."""
    return _run("crossed prisms", _prisms(cell, (2, 3, 2), variation), falling(0.04, 0.01))


def _prisms(cell: str, lower: tuple[int, ...], variation: RandomVariation) -> Mesh:
    domain, _ = two_bodies(cell, lower, (3, 2, 2), start=(0.0, 0.0), length=(1.0, 1.0))
    x, upper = domain.geometry.x, open_gap(domain, GAP)
    # Two boxes with an edge upward, along the second axis, and downward, along the first one; shifted, so that the
    # edges cross between nodes.
    for own, axes, middle in ((~upper, (0, 2), (0.5, 0.5, 0.5)), (upper, (1, 2), (0.5, 0.5, 1.25 + GAP))):
        y = x[own] - middle
        if middle[2] > 1.0:
            y[:, 2] *= 2.0
        a, b = y[:, axes[0]].copy(), y[:, axes[1]].copy()
        y[:, axes[0]], y[:, axes[1]] = QUARTER * (a - b), QUARTER * (a + b)
        x[own] = y
    x[upper, 2] += 2.0 * QUARTER + GAP
    x[upper, :2] += (0.02, 0.03)
    x[:, 2] += 1.0 - QUARTER
    variation.rotate_upper_body(domain, lambda p: 1.0 - np.abs(p[:, 0]))
    return domain


def _notch(cell: str) -> Scenario:
    """A block that falls with an edge into the notch that two others form: nodes have springs to both of them."""
    plane = cell in ("triangle", "quadrilateral")
    dim, counts = (2, (3, 3)) if plane else (3, (2, 2, 2))
    long = np.ones(dim)
    # Boxes with a lower or an upper corner, or edge, at the origin, turned by half a right angle.
    boxes = ((0.0 * long, 0.9 * long), (-1.0 * long, -0.1 * long), (0.0 * long, 0.7 * long))
    points, cells, first = [], [], 0
    for body, (low, high) in enumerate(boxes):
        grid, own = grid_of_box(cell, low, high, counts if body else tuple(n + 1 for n in counts))
        x = grid.copy()
        # The faces of the first two rise from the notch to the right and to the left, the third lies between them.
        a, b = ((x[:, 0], x[:, -1] - 0.9), (x[:, 0] + 0.1, x[:, -1] + 1.0), (x[:, 0], x[:, -1]))[body]
        x[:, 0], x[:, -1] = QUARTER * (a - b), QUARTER * (a + b)
        if body == 2:
            x += np.array([0.004, 0.03, 0.004 + GAP])[[0, 2] if plane else [0, 1, 2]]
        points.append(x)
        cells.append(own + first)
        first += len(x)
    element = basix.ufl.element("Lagrange", cell, 1, shape=(dim,))
    domain = mesh.create_mesh(MPI.COMM_SELF, np.vstack(cells), x=np.vstack(points), e=ufl.Mesh(element))

    def velocity(positions: FloatArray) -> FloatArray:
        out = np.zeros_like(positions)
        out[positions[:, -1] > np.abs(positions[:, 0]) + 0.5 * GAP, -1] = -0.04
        return out

    return _run("block in a notch", domain, velocity)
