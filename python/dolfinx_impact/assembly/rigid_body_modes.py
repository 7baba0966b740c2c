# SPDX-License-Identifier: MIT
"""Rigid body modes that neither supports nor contacts prevent; they are found before the linear system is solved."""

from collections.abc import Sequence
from typing import Protocol

import numpy as np
import scipy
from dolfinx.fem import FunctionSpace
from petsc4py import PETSc

from ..common.described import Described
from ..common.types import BoolArray, FloatArray, IntArray

AXES = "xyz"
UNRESISTED = 1e-10  # of |K||r|: below it the forces K r on a rigid motion r are round-off


class ConstrainingContact(Protocol):
    """A contact as the search for unconstrained modes needs it; contact.protocol.StaticContact has these methods."""

    def rigid_body_constraints(self, motions: "RigidBodyModes") -> list[FloatArray]:
        """Rows of the active constraints applied to the rigid body modes. Collective.

        Args:
            motions: the rigid body modes.

        Returns:
            Arrays (num_points, motions.num_modes).
        """

    def close_nearest(self) -> bool:
        """Activate the points nearest to the master if the bodies nearly touch. Collective.

        Returns:
            Whether there are any.
        """


def bodies(V: FunctionSpace) -> tuple[IntArray, int]:
    """Bodies: the connected parts of a mesh. Collective.

    Args:
        V: displacement space.

    Returns:
        Number of the body of each owned and ghost node, (num_nodes), and the number of bodies.
    """
    comm, index_map = V.mesh.comm, V.dofmap.index_map
    num = index_map.size_local + index_map.num_ghosts
    cells = V.dofmap.list
    rows, cols = np.repeat(cells[:, 0], cells.shape[1]), cells.ravel()
    count, local = scipy.sparse.csgraph.connected_components(
        scipy.sparse.coo_matrix((np.ones(len(rows)), (rows, cols)), shape=(num, num)), False
    )
    offsets = np.concatenate([[0], np.cumsum(comm.allgather(count))])
    label = local + offsets[comm.rank]
    # Parts of different ranks that share a node belong to one body: the owner of a ghost node gets its label.
    ghosts = comm.allgather((index_map.ghosts, label[index_map.size_local :]))
    low, high = index_map.local_range
    shared = [np.empty((0, 2), dtype=np.int64)]
    for nodes, labels in ghosts:
        mine = (nodes >= low) & (nodes < high)
        shared.append(np.column_stack([label[nodes[mine] - low], labels[mine]]))
    edges = np.concatenate(comm.allgather(np.concatenate(shared)))
    shape = (offsets[-1], offsets[-1])
    _, number = scipy.sparse.csgraph.connected_components(
        scipy.sparse.coo_matrix((np.ones(len(edges)), edges.T), shape=shape), False
    )
    number = number[label]
    used = np.unique(np.concatenate(comm.allgather(np.unique(number))))  # parts that have nodes
    return np.searchsorted(used, number), len(used)


class RigidBodyModes(Described):
    """Linearised rigid motions of all bodies, as fields over positions. Collective.

    Translations have length one; rotations are about the body's centre and scaled by its size.

    Args:
        V: displacement space.
        u: displacements of the configuration, owned and ghost dofs [L].
        axisymmetric: whether x is the radius of an axisymmetric body.

    Attributes:
        gdim: dimension of space.
        body: number of the body of each owned and ghost node, (num_nodes).
        num_owned: number of owned nodes.
        x: present positions of the nodes, (num_nodes, gdim) [L].
        centres: mean positions of the bodies, (count, gdim) [L].
        size: largest distance of a node from the centre of its body, (count) [L].
        names: names of the modes of one body.
        count: number of bodies.
    """

    def __init__(self, V: FunctionSpace, u: FloatArray, axisymmetric: bool) -> None:
        comm, gdim = V.mesh.comm, V.mesh.geometry.dim
        self.gdim = gdim
        self.body, self.count = bodies(V)
        self.num_owned = V.dofmap.index_map.size_local
        self.x = V.tabulate_dof_coordinates()[:, :gdim] + u.reshape(-1, gdim)
        x, own = self.x[: self.num_owned], self.body[: self.num_owned]
        sums = np.zeros((self.count, gdim + 1))
        for c in range(gdim):
            sums[:, c] = np.bincount(own, weights=x[:, c], minlength=self.count)
        sums[:, gdim] = np.bincount(own, minlength=self.count)
        sums = np.sum(comm.allgather(sums), axis=0)
        self.centres = sums[:, :gdim] / sums[:, gdim, None]
        size = np.zeros(self.count)
        np.maximum.at(size, own, np.linalg.norm(x - self.centres[own], axis=1))
        self.size = np.max(comm.allgather(size), axis=0)
        axes = range(1 if axisymmetric else 0, gdim)
        self._translations = np.array([np.eye(gdim)[a] for a in axes])
        self._rotations: tuple[tuple[int, int], ...] = ((0, 1),) if gdim == 2 else ((1, 2), (2, 0), (0, 1))
        if axisymmetric:
            self._rotations = ()
        self.names = [f"move along {AXES[a]}" for a in axes]
        self.names += [f"turn about {AXES[3 - a - b]}" for a, b in self._rotations]

    @property
    def num_modes(self) -> int:
        """Number of modes of all bodies together."""
        return self.count * len(self.names)

    def fields(self, body: IntArray, x: FloatArray) -> FloatArray:
        """Displacements of points under the modes of their bodies.

        Args:
            body: bodies of the points, (n).
            x: positions of the points, (n, gdim) [L].

        Returns:
            Displacements, (n, modes of one body, gdim) [1].
        """
        out = np.zeros((len(x), len(self.names), self.gdim))
        out[:, : len(self._translations)] = self._translations
        arm = (x - self.centres[body]) / np.maximum(self.size[body], 1e-300)[:, None]
        for k, (a, b) in enumerate(self._rotations, len(self._translations)):
            out[:, k, a], out[:, k, b] = -arm[:, b], arm[:, a]
        return out

    def rows(self, body: IntArray, x: FloatArray, vectors: FloatArray) -> FloatArray:
        """Work of unit forces on the modes of all bodies.

        Args:
            body: bodies of the points, (n).
            x: points at which the forces act, (n, gdim) [L].
            vectors: unit forces, (n, gdim) [1].

        Returns:
            Work, (n, num_modes) [1].
        """
        out = np.zeros((len(x), self.count, len(self.names)))
        out[np.arange(len(x)), body] = np.einsum("nma,na->nm", self.fields(body, x), vectors)
        return out.reshape(len(x), self.num_modes)

    def field(self, mode: FloatArray) -> FloatArray:
        """Displacements of the owned nodes under a combination of the modes.

        Args:
            mode: coefficients of the modes, (num_modes).

        Returns:
            Displacements, (num_owned, gdim) [1].
        """
        own = self.body[: self.num_owned]
        coefficients = np.reshape(mode, (self.count, len(self.names)))[own]
        return np.einsum("nm,nma->na", coefficients, self.fields(own, self.x[: self.num_owned]))

    def everywhere(self, number: int) -> FloatArray:
        """Displacements of the owned nodes under one mode; bodies without this mode do not move.

        Args:
            number: number of the mode, less than num_modes.

        Returns:
            Displacements, (num_owned, gdim) [1].
        """
        b, k = divmod(number, len(self.names))
        own = self.body[: self.num_owned]
        values = self.fields(own, self.x[: self.num_owned])[:, k]
        return np.where((own == b)[:, None], values, 0.0)


def _unresisted(stiffness: PETSc.Mat, motions: RigidBodyModes, modes: FloatArray) -> FloatArray:
    """Combinations of rigid body modes that a tangent does not resist: K r is small against |K||r|. Collective.

    Args:
        stiffness: tangent K of the bodies [F/L].
        motions: the rigid body modes.
        modes: orthonormal combinations, (num_modes, k).

    Returns:
        The combinations without resistance, (num_modes, number of them).
    """
    comm = stiffness.getComm().tompi4py()
    x, y = stiffness.createVecs()
    fields, forces = [], []
    for mode in modes.T:
        x.array[:] = motions.field(mode).ravel()
        stiffness.mult(x, y)
        fields.append(x.array.copy())
        forces.append(y.array.copy())
    x.destroy()
    y.destroy()
    fields, forces = np.array(fields), np.array(forces)
    work, lengths = comm.allreduce(fields @ forces.T), comm.allreduce(fields @ fields.T)
    turn = np.linalg.eigh(work + work.T)[1]  # springs resist some combinations of motions, others not
    resisting = np.sqrt(comm.allreduce(np.sum((turn.T @ forces) ** 2, axis=1)))
    size = stiffness.norm(PETSc.NormType.NORM_INFINITY) * np.sqrt(np.einsum("ka,kl,la->a", turn, lengths, turn))
    return modes @ turn[:, resisting < UNRESISTED * size]


def unconstrained_modes(
    V: FunctionSpace,
    fixed: BoolArray,
    contacts: Sequence[ConstrainingContact],
    u: FloatArray,
    axisymmetric: bool = False,
    stiffness: PETSc.Mat | None = None,
) -> list[str]:
    """Sentences about the rigid body modes that supports and active contacts do not constrain. Collective.

    If modes are unconstrained and bodies nearly touch, `close_nearest()` of the contacts activates their nearest
    points, and the modes are found again.

    Args:
        V: displacement space.
        fixed: mask of prescribed dofs, owned and ghosts.
        contacts: contacts of the problem.
        u: present displacements, owned and ghost dofs [L].
        axisymmetric: whether x is the radius of an axisymmetric body.
        stiffness: tangent of the bodies, where it may resist rigid body modes (springs in a residual) [F/L]; None: it
            does not.

    Returns:
        One sentence per body with unconstrained modes; the same on all ranks and on any number of ranks.
    """
    comm, gdim = V.mesh.comm, V.mesh.geometry.dim
    motions = RigidBodyModes(V, u, axisymmetric)
    supports = np.zeros((motions.num_modes, motions.num_modes))
    dofs = np.flatnonzero(fixed[: motions.num_owned * gdim])
    for part in np.array_split(dofs, max(1, len(dofs) // 10000)):
        nodes = part // gdim
        work = motions.rows(motions.body[nodes], motions.x[nodes], np.eye(gdim)[part % gdim])
        supports += work.T @ work

    def unconstrained() -> FloatArray:
        """Combinations of modes on which no constraint does work, as columns."""
        gram = supports + sum(r.T @ r for contact in contacts for r in contact.rigid_body_constraints(motions))
        gram = np.sum(comm.allgather(gram), axis=0)
        values, vectors = np.linalg.eigh(gram)
        loose = vectors[:, values < 1e-10 * max(values[-1], 1.0)]
        if stiffness is None or loose.shape[1] == 0:
            return loose
        # A law of small strains does not resist motions about the reference configuration, others those about the
        # present one.
        return max((_unresisted(stiffness, m, loose) for m in (motions, at_rest)), key=lambda modes: modes.shape[1])

    at_rest = RigidBodyModes(V, np.zeros_like(u), axisymmetric)
    modes = unconstrained()
    if modes.shape[1] > 0 and any([c.close_nearest() for c in contacts]):
        modes = unconstrained()
    if modes.shape[1] == 0:
        return []
    sentences = []
    for b, of_body in enumerate(modes.reshape(motions.count, len(motions.names), -1)):
        strength = np.linalg.norm(of_body, axis=1)
        found = [n for n, s in zip(motions.names, strength) if s > 1e-3]
        if found:
            where = ", ".join(f"{v:.4g}" for v in motions.centres[b])
            sentences.append(f"the body around ({where}) is free to {', to '.join(found)}")
    return sentences
