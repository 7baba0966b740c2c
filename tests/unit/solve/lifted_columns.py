# SPDX-License-Identifier: MIT
"""Columns over a plane, each with its own gap, for tests of active sets whose solution is known."""

import basix.ufl
import numpy as np
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI


def lifted_columns(gaps):
    """Unit squares side by side, each lifted by its gap: displacement space, and tags of lower (1) and upper sides (2).

    Args:
        gaps: height of each square above y = 0, (num_columns) [L].
    """
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]])
    points = np.concatenate([corners + [2.0 * k, gap] for k, gap in enumerate(gaps)])
    element = ufl.Mesh(basix.ufl.element("Lagrange", "quadrilateral", 1, shape=(2,)))
    domain = mesh.create_mesh(MPI.COMM_SELF, np.arange(4 * len(gaps)).reshape(-1, 4), x=points, e=element)
    facets = [mesh.locate_entities_boundary(domain, 1, side) for side in (lambda x: x[1] < 0.5, lambda x: x[1] > 0.9)]
    order = np.argsort(np.concatenate(facets))
    values = np.repeat([1, 2], [len(f) for f in facets]).astype(np.int32)
    tags = mesh.meshtags(domain, 1, np.concatenate(facets)[order], values[order])
    return fem.functionspace(domain, ("Lagrange", 1, (2,))), tags
