# SPDX-License-Identifier: MIT
"""Rigid motions that neither supports nor contact prevent, found before the linear solver breaks."""

import numpy as np
from petsc4py import PETSc
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

AXES = "xyz"
UNRESISTED = 1e-10  # of |K||r|: below it the forces K r on a rigid motion r are round-off


def bodies(V):
    """Number of the connected part of the mesh each node belongs to (owned and ghosts), and how many there are.

    Collective.
    """
    comm, index_map = V.mesh.comm, V.dofmap.index_map
    num = index_map.size_local + index_map.num_ghosts
    cells = V.dofmap.list
    rows, cols = np.repeat(cells[:, 0], cells.shape[1]), cells.ravel()
    count, local = connected_components(coo_matrix((np.ones(len(rows)), (rows, cols)), shape=(num, num)), False)
    offsets = np.concatenate([[0], np.cumsum(comm.allgather(count))])
    label = local + offsets[comm.rank]
    # Parts of different ranks are one where they share a node: ghosts tell their owners.
    ghosts = comm.allgather((index_map.ghosts, label[index_map.size_local :]))
    low, high = index_map.local_range
    edges = [np.empty((0, 2), dtype=np.int64)]
    for nodes, labels in ghosts:
        mine = (nodes >= low) & (nodes < high)
        edges.append(np.column_stack([label[nodes[mine] - low], labels[mine]]))
    edges = np.concatenate(comm.allgather(np.concatenate(edges)))
    shape = (offsets[-1], offsets[-1])
    _, number = connected_components(coo_matrix((np.ones(len(edges)), edges.T), shape=shape), False)
    number = number[label]
    used = np.unique(np.concatenate(comm.allgather(np.unique(number))))  # nodes without cells make parts of no body
    return np.searchsorted(used, number), len(used)


class RigidBodyModes:
    """Unit rigid motions of all bodies, as fields over positions; turns are scaled by the body's size. Collective.

    Args:
        V: displacement space. u: displacements (array over owned and ghost dofs), about which motions are small [L].
        axisymmetric: x is the radius.

    Attributes:
        body: number of the body of each node (owned and ghosts). x: (nodes, gdim) their present positions [L].
        centres: (bodies, gdim) mean positions [L]. names: of the motions of one body. count: of the bodies.
    """

    def __init__(self, V, u, axisymmetric):
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
        self._moves = np.array([np.eye(gdim)[a] for a in axes])
        self._turns = () if axisymmetric else ((0, 1),) if gdim == 2 else ((1, 2), (2, 0), (0, 1))
        self.names = [f"move along {AXES[a]}" for a in axes]
        self.names += [f"turn about {AXES[3 - a - b]}" for a, b in self._turns]

    @property
    def num_modes(self):
        """Number of motions of all bodies together."""
        return self.count * len(self.names)

    def fields(self, body, x):
        """Motions of the points' own bodies: (points, motions of a body, gdim)."""
        out = np.zeros((len(x), len(self.names), self.gdim))
        out[:, : len(self._moves)] = self._moves
        arm = (x - self.centres[body]) / np.maximum(self.size[body], 1e-300)[:, None]
        for k, (a, b) in enumerate(self._turns, len(self._moves)):
            out[:, k, a], out[:, k, b] = -arm[:, b], arm[:, a]
        return out

    def rows(self, body, x, vectors):
        """Work of unit forces on all motions: (points, num_modes).

        Args:
            body: (n) whose points they are. x: (n, gdim) where they act [L]. vectors: (n, gdim) unit forces.
        """
        out = np.zeros((len(x), self.count, len(self.names)))
        out[np.arange(len(x)), body] = np.einsum("nma,na->nm", self.fields(body, x), vectors)
        return out.reshape(len(x), self.num_modes)

    def field(self, mode):
        """A combination of the motions at the owned nodes, (n, gdim).

        Args:
            mode: (num_modes) its coefficients.
        """
        own = self.body[: self.num_owned]
        coefficients = np.reshape(mode, (self.count, len(self.names)))[own]
        return np.einsum("nm,nma->na", coefficients, self.fields(own, self.x[: self.num_owned]))

    def everywhere(self, number):
        """One of the motions of all bodies at the owned nodes, (n, gdim)."""
        b, k = divmod(number, len(self.names))
        own = self.body[: self.num_owned]
        values = self.fields(own, self.x[: self.num_owned])[:, k]
        return np.where((own == b)[:, None], values, 0.0)


def _unresisted(stiffness, motions, modes):
    """Combinations of rigid motions that a tangent does not resist: K r is small against |K||r|. Collective.

    Args:
        stiffness: PETSc matrix K [F/L].
        motions: RigidBodyModes.
        modes: (num_modes, k) orthonormal combinations.

    Returns:
        (num_modes, number of those without resistance).
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


def unconstrained_modes(V, fixed, contacts, u, axisymmetric=False, stiffness=None):
    """Sentences about the rigid motions that supports and active contacts leave. Collective.

    Bodies that nothing holds but that nearly touch are held by it: their contacts `close_nearest()`.

    Args:
        V: displacement space.
        fixed: mask of prescribed dofs (owned and ghosts).
        contacts: StaticContact.
        u: present displacements (array over owned and ghost dofs) [L].
        axisymmetric: x is the radius.
        stiffness: tangent of the bodies, where it may resist rigid motions (springs in a residual) [F/L]; None: it does
            not.

    Returns:
        list of str, empty if everything is held; the same on all ranks, and the same on any number of them.
    """
    comm, gdim = V.mesh.comm, V.mesh.geometry.dim
    motions = RigidBodyModes(V, u, axisymmetric)
    supports = np.zeros((motions.num_modes, motions.num_modes))
    dofs = np.flatnonzero(fixed[: motions.num_owned * gdim])
    for part in np.array_split(dofs, max(1, len(dofs) // 10000)):
        nodes = part // gdim
        r = motions.rows(motions.body[nodes], motions.x[nodes], np.eye(gdim)[part % gdim])
        supports += r.T @ r

    def free():
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
    loose = free()
    if loose.shape[1] > 0 and any([c.close_nearest() for c in contacts]):
        loose = free()
    if loose.shape[1] == 0:
        return []
    sentences = []
    for b, part in enumerate(loose.reshape(motions.count, len(motions.names), -1)):
        strength = np.linalg.norm(part, axis=1)
        found = [n for n, s in zip(motions.names, strength) if s > 1e-3]
        if found:
            where = ", ".join(f"{v:.4g}" for v in motions.centres[b])
            sentences.append(f"the body around ({where}) is free to {', to '.join(found)}")
    return sentences
