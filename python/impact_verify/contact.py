# SPDX-License-Identifier: MIT
"""Level contact: gaps, forces, tangents and mortar integrals on random facing patches, then whole solutions, of ties
too, and contact without pairs."""

import numpy as np

from . import contact_patch, contact_static, general, general_static, interface_laws, rigid_bodies, stick_slip, tied
from .contact_bodies import CASES, TwoBodies, facet_of, obstacles, roughen, steel, two_bodies
from .report import Report

FRICTION = 0.5
OFFSET = 0.5  # distance of axisymmetric bodies from the axis [L]


def run(report: Report, progress: bool = True) -> None:
    """Add the rows of this level.

    Args:
        report: report to add to.
        progress: not used; all levels share these arguments.
    """
    for cell, hypothesis in CASES:
        for degree in (1, 2):
            if not report.wants(cell, degree):
                continue
            for geometry_degree in (1, 2):
                patches(report, cell, hypothesis, degree, geometry_degree)
    contact_static.run(report)
    interface_laws.run(report)
    stick_slip.run(report)
    tied.run(report)
    rigid_bodies.run(report)
    general.run(report)
    general_static.run(report)


def patches(report: Report, cell: str, hypothesis: str, degree: int, geometry_degree: int, seed: int = 1) -> None:
    """Add the rows of one kind of element: a deformable master, and rigid ones.

    Args:
        report: report to add to.
        cell: cell.
        hypothesis: hypothesis of the material.
        degree: degree of the displacement, 1 or 2.
        geometry_degree: degree of the geometry, 1 or 2.
        seed: seed of the random numbers.
    """
    body = random_patch(cell, hypothesis, degree, geometry_degree, seed)
    contact_patch.penalty(report, body, "deformable master", seed)
    contact_patch.mortar(report, body, "deformable master", seed)
    contact_patch.adjusted(report, body, "deformable master", seed)
    rigid = obstacles(body.gdim, OFFSET if hypothesis == "axisymmetric" else 0.0)
    if hypothesis == "axisymmetric":  # a sphere has its centre on the axis, a cylinder would be a torus
        rigid = rigid[:1]
    for name, ours, theirs in rigid:
        body.rigid = ours, theirs
        contact_patch.penalty(report, body, name, seed)
        contact_patch.nodes_on_obstacle(report, body, name, seed)
    contact_patch.adjusted(report, body, name, seed)


def random_patch(cell: str, hypothesis: str, degree: int, geometry_degree: int, seed: int) -> TwoBodies:
    """Two bodies whose nodes are moved at random; the slave extends beyond the master's edge by more than a facet.

    Args:
        cell: cell.
        hypothesis: hypothesis of the material.
        degree: degree of the displacement, 1 or 2.
        geometry_degree: degree of the geometry, 1 or 2.
        seed: seed of the random numbers.

    Returns:
        The bodies.
    """
    dim = 2 if facet_of(cell) == "interval" else 3
    lower, upper = ((4, 2), (4, 1)) if dim == 2 else ((2, 2, 1), (3, 1, 1))
    domain, tags = two_bodies(cell, lower, upper, geometry_degree, start=(0.45, 0.15), length=(0.9, 0.7))
    roughen(domain, np.random.default_rng(seed), 0.02)
    if hypothesis == "axisymmetric":
        domain.geometry.x[:, 0] += OFFSET
    return TwoBodies(domain, tags, degree, steel(hypothesis), FRICTION)
