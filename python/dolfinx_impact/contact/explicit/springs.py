# SPDX-License-Identifier: MIT
"""Penalty springs of explicit contact as a stiffness matrix; docs/explicit/penalty.md, "Stiffness"."""

from collections.abc import Mapping, Sequence

import numpy as np
from dolfinx.fem import FunctionSpace
from petsc4py import PETSc

from ... import _cpp
from ...common.types import AnyArray, FloatArray
from .nodal import NodalResult


def stiffness(contacts: Sequence[NodalResult], V: FunctionSpace, u: FloatArray) -> PETSc.Mat | None:
    """Matrix of all springs of given stiffness at nodes that have a master, closed or not. Collective.

    Args:
        contacts: contacts of the problem.
        V: displacement space.
        u: displacements, of which the owned dofs are read [L].

    Returns:
        The matrix; None if no contact has a given stiffness [F/L].
    """
    contacts = [c for c in contacts if c.penalty]
    if not contacts:
        return None
    bs, own = V.dofmap.index_map_bs, V.dofmap.index_map
    size = (own.size_local * bs, own.size_global * bs)
    matrix = PETSc.Mat().createAIJ((size, size), comm=V.mesh.comm)
    matrix.setUp()
    for contact in contacts:
        made, halo, values = contact.searched(u, _cpp.nodal.NodePenalty, **contact.parameters)
        for side in made.directions:
            _add(matrix, side.springs(halo, values), bs, contact.pair.friction > 0)
    matrix.assemble()
    return matrix


def _add(matrix: PETSc.Mat, springs: Mapping[str, AnyArray], bs: int, sticking: bool) -> None:
    """Add springs to a matrix: along the normal, or in all directions if friction may make nodes stick."""
    for node, masters, phi, n, k in zip(
        *(springs[name] for name in ("nodes", "masters", "phi", "normal", "stiffness"))
    ):
        weights = np.concatenate([[1.0], -phi])
        directions = np.eye(bs) if sticking else np.outer(n, n)
        dofs = (bs * np.concatenate([[node], masters])[:, None] + np.arange(bs)).reshape(-1).astype(PETSc.IntType)
        matrix.setValues(dofs, dofs, k * np.kron(np.outer(weights, weights), directions), PETSc.InsertMode.ADD_VALUES)
