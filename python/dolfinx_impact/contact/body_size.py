# SPDX-License-Identifier: MIT
"""The length scale that tolerances of gaps refer to."""

import numpy as np
from mpi4py import MPI


def body_size(mesh):
    """Diagonal of the box around the whole mesh [L]. Collective."""
    x = mesh.geometry.x
    box = np.concatenate([np.max(-x, axis=0, initial=-np.inf), np.max(x, axis=0, initial=-np.inf)])
    mesh.comm.Allreduce(MPI.IN_PLACE, box, MPI.MAX)
    return float(np.linalg.norm(box[:3] + box[3:]))
