# SPDX-License-Identifier: MIT
"""Penalty springs of explicit contact as a stiffness matrix; docs/explicit/penalty.md, "Stiffness"."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from dolfinx.common import IndexMap
from dolfinx.fem import FunctionSpace
from petsc4py import PETSc

from ... import _cpp
from ...common.types import AnyArray, FloatArray

if TYPE_CHECKING:  # it imports this module
    from .nodal import NodalResult


def searched(
    contact: "NodalResult",
    u: FloatArray,
    law: type[_cpp.nodal.NodeToSurface],
    masses: FloatArray | None = None,
    **options: Any,
) -> tuple[_cpp.nodal.NodeToSurface, _cpp.operators.Halo, FloatArray]:
    """Make another contact of the same pair, with the candidates of a given configuration. Collective.

    The contact of the running problem does not change.

    Args:
        contact: contact of the running problem.
        u: displacements, of which the owned dofs are read [L].
        law: C++ class of the new contact, see NodalResult.make.
        masses: of the owned nodes, for stiffness from masses and step; None: ones [M].
        options: its parameters.

    Returns:
        The new contact, the halo of the nodes it knows, and the displacements of these nodes [L].
    """
    made, V = contact.make(law, **options), contact.V
    if contact.motion is not None:
        made.set_obstacle(contact.motion.sample([contact.problem.time])[0].tolist(), [0.0] * 3)
    own, bs = V.dofmap.index_map, V.dofmap.index_map_bs
    num = own.size_local * bs
    made.search(np.ascontiguousarray(u[:num]), np.zeros(0))
    ghosts = np.concatenate([own.ghosts, made.remote_nodes])
    owners = np.concatenate([own.owners, made.remote_owners]).astype(np.int32)
    halo = _cpp.operators.Halo(IndexMap(V.mesh.comm, own.size_local, ghosts, owners))
    values, mass = np.zeros(halo.num_nodes * bs), np.ones(halo.num_nodes)  # a given stiffness does not need masses
    values[:num] = u[:num]
    if masses is not None:
        mass[: own.size_local] = masses
        halo.forward(mass, 1)
    halo.forward(values, bs)
    made.number(halo, mass)
    return made, halo, values


def stiffness(contacts: Sequence["NodalResult"], V: FunctionSpace, u: FloatArray) -> PETSc.Mat | None:
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
        made, halo, values = searched(contact, u, _cpp.nodal.NodePenalty, **contact.parameters)
        for side in [made] + ([made.other] if made.other is not None else []):
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
