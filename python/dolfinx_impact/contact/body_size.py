# SPDX-License-Identifier: MIT
"""The length scale of tolerances of gaps."""

import numpy as np
from dolfinx.mesh import Mesh
from mpi4py import MPI


def body_size(mesh: Mesh) -> float:
    """Diagonal of the bounding box of the whole mesh. Collective.

    Args:
        mesh: mesh of the bodies.

    Returns:
        The diagonal [L].
    """
    x = mesh.geometry.x
    box = np.concatenate([np.max(-x, axis=0, initial=-np.inf), np.max(x, axis=0, initial=-np.inf)])
    mesh.comm.Allreduce(MPI.IN_PLACE, box, MPI.MAX)
    return float(np.linalg.norm(box[:3] + box[3:]))
