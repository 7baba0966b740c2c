"""Rigid motions that neither supports nor contact prevent, found before the linear solver breaks."""

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

AXES = "xyz"


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


def motions(x, centre, axisymmetric):
    """Rigid motions at points, shape (modes, points, gdim), and their names. Rotations are about `centre`."""
    gdim = x.shape[1]
    fields, names = [], []
    for a in range(gdim):
        if axisymmetric and a == 0:
            continue
        fields.append(np.broadcast_to(np.eye(gdim)[a], x.shape))
        names.append(f"move along {AXES[a]}")
    if not axisymmetric:
        for a, b in ((0, 1),) if gdim == 2 else ((1, 2), (2, 0), (0, 1)):
            turn = np.zeros_like(x)
            turn[:, a], turn[:, b] = -(x[:, b] - centre[b]), x[:, a] - centre[a]
            fields.append(turn)
            names.append(f"turn about {AXES[3 - a - b]}")
    return np.array(fields), names


def against_master(rows, x, nodes, directions, master):
    """Rows of a contact's held_rows: slave nodes along directions, less what they face on a deformable master.

    Near a slave node its master moves like the master's nearest known node: enough for a yes or no.

    Args:
        rows: as free_motions gives it. x: reference positions of all nodes. nodes: (n) of the slave. directions: (n,
        gdim). master: facets, or None for a rigid obstacle.
    """
    slave = rows(nodes, directions)
    known = np.empty(0, dtype=int) if master is None else np.unique(master.nodes.ravel())
    if (
        len(nodes) == 0 or len(known) == 0
    ):  # on other ranks only: it counts as held, the linear solver has the last word
        return slave
    nearest = known[cKDTree(x[known]).query(x[nodes])[1]]
    return slave + rows(nearest, directions, -1.0)


def free_motions(V, fixed, contacts, axisymmetric=False):
    """Sentences about the rigid motions that supports and active contacts leave. Collective.

    Bodies that nothing holds but that nearly touch are held by it: their contacts are told to `touch_nearest()`.

    Args:
        V: displacement space. fixed: mask of prescribed dofs (owned and ghosts). contacts: with `held_rows(rows)` and
            `touch_nearest()`.

    Returns:
        list of str, empty if everything is held; the same on all ranks.
    """
    comm, gdim = V.mesh.comm, V.mesh.geometry.dim
    body, count = bodies(V)
    num_owned = V.dofmap.index_map.size_local
    x = V.tabulate_dof_coordinates()[:, :gdim]
    owned, own = x[:num_owned], body[:num_owned]
    sums = np.zeros((count, gdim + 2))
    for c in range(gdim):
        sums[:, c] = np.bincount(own, weights=owned[:, c], minlength=count)
    sums[:, gdim] = np.bincount(own, minlength=count)
    sums = np.sum(comm.allgather(sums), axis=0)
    centres = sums[:, :gdim] / sums[:, gdim, None]
    distance = np.linalg.norm(owned - centres[own], axis=1)
    size = np.array([np.max(distance[own == b], initial=0.0) for b in range(count)])
    size = np.max(comm.allgather(size), axis=0)
    _, names = motions(x[:1], centres[0], axisymmetric)
    modes = len(names)

    def rows(nodes, vectors, sign=1.0):
        """Work of unit forces along vectors at nodes on every rigid motion of every body, turns scaled by size."""
        out = np.zeros((len(nodes), count * modes))
        for b in np.unique(body[nodes]):
            at = np.flatnonzero(body[nodes] == b)
            fields, _ = motions(x[nodes[at]], centres[b], axisymmetric)
            fields[[k for k, n in enumerate(names) if "turn" in n]] /= max(size[b], 1e-300)
            out[at[:, None], b * modes + np.arange(modes)] = sign * np.einsum("mna,na->nm", fields, vectors[at])
        return out

    supports = np.zeros((count * modes, count * modes))
    dofs = np.flatnonzero(fixed[: num_owned * gdim])
    for part in np.array_split(dofs, max(1, len(dofs) // 10000)):
        r = rows(part // gdim, np.eye(gdim)[part % gdim])
        supports += r.T @ r

    def free():
        gram = supports + sum(r.T @ r for contact in contacts for r in contact.held_rows(rows))
        gram = np.sum(comm.allgather(gram), axis=0)
        values, vectors = np.linalg.eigh(gram)
        return vectors[:, values < 1e-10 * max(values[-1], 1.0)]

    loose = free()
    if loose.shape[1] > 0 and any([c.touch_nearest() for c in contacts]):
        loose = free()
    if loose.shape[1] == 0:
        return []
    sentences = []
    for b in range(count):
        part = loose[b * modes : (b + 1) * modes]
        strength = np.linalg.norm(part, axis=1)
        found = [n for n, s in zip(names, strength) if s > 1e-3]
        if found:
            where = ", ".join(f"{v:.4g}" for v in centres[b])
            sentences.append(f"the body around ({where}) is free to {', to '.join(found)}")
    return sentences
