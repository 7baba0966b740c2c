# SPDX-License-Identifier: MIT
"""The state before anything is loaded: surfaces the wrong way round are refused, penetrations reported and removed."""

import logging

import numpy as np
from mpi4py import MPI

from .. import _cpp
from ..assembly import rigid_body_modes
from .nodal_sum import NodalSum
from .body_size import body_size

LOG = logging.getLogger("dolfinx_impact")
# Coordinates come from files and from curves that gmsh computes: what is smaller than this part of the bodies' size
# is their round-off, no overlap.
ROUND_OFF = 1e-10
# Bodies nearly touch if they are apart by less than this part of a facet: what a facet of size h of a round body of
# radius R bulges by is h^2/(8 R), a hundredth of h on meshes with 70 facets around.
NEARLY = 0.01


class InitialPenetration:
    """Gaps of the contact points in the reference configuration, obstacles where they were made. Collective.

    Args:
        pair: ContactPair.
        V: displacement space. slave, master: this rank's facets (master None: rigid).
        x: (n, gdim) positions of the contact points [L].
        gap: (n), infinite where there is no master [L].

    Attributes:
        num_points: contact points of all ranks that penetrate. depth: their largest penetration [L]. where: its place,
        (gdim), None without penetration. offset: (n) what is added to the gaps from now on [L].

    Raises:
        ValueError: on all ranks, where every point is deeper than half of the thinner body.
    """

    def __init__(self, pair, V, slave, master, x, gap):
        comm = V.mesh.comm
        penetration = np.maximum(0.0, -gap)
        deep = penetration > ROUND_OFF * body_size(V.mesh)
        here = int(np.argmax(penetration)) if len(penetration) else None
        mine = (0, 0.0, None) if here is None else (np.count_nonzero(deep), penetration[here], x[here].tolist())
        counts, depths, places = zip(*comm.allgather(mine))
        self.num_points, deepest = int(sum(counts)), int(np.argmax(depths))
        self.depth = float(depths[deepest]) if self.num_points else 0.0
        self.where = places[deepest] if self.num_points else None
        shallowest = comm.allreduce(float(np.min(penetration[np.isfinite(gap)], initial=np.inf)), MPI.MIN)
        if np.isfinite(shallowest) and shallowest > 0.0 and self.num_points:
            _check_depth(pair, V, slave, master, shallowest)
        self.offset = np.where(deep, penetration, 0.0) if pair.remove_penetration else np.zeros(len(gap))
        if self.num_points and comm.rank == 0:
            place = ", ".join(f"{round(v, 12) + 0.0:.4g}" for v in self.where)
            end = ": removed, gaps count from there" if pair.remove_penetration else ""
            LOG.warning(
                f"{pair.name}: {self.num_points} points penetrate before anything is loaded, by up to "
                f"{self.depth:.3e} at ({place}){end}"
            )


def _check_depth(pair, V, slave, master, shallowest):
    """A press fit overlaps by less than half of the thinner body. Collective."""
    comm, gdim = V.mesh.comm, V.mesh.geometry.dim
    label, count = rigid_body_modes.bodies(V)
    owned = V.dofmap.index_map.size_local
    x = V.tabulate_dof_coordinates()[:owned, :gdim]
    boxes = np.full((count, 2 * gdim), -np.inf)
    np.maximum.at(boxes, label[:owned], np.hstack([x, -x]))
    used = np.zeros(count)
    for surface in (slave, master):
        if surface is not None:
            used[np.unique(label[surface.nodes])] = 1.0
    comm.Allreduce(MPI.IN_PLACE, boxes, MPI.MAX)
    comm.Allreduce(MPI.IN_PLACE, used, MPI.MAX)
    thinner = float(np.min((boxes[:, :gdim] + boxes[:, gdim:])[used > 0]))
    if shallowest > 0.5 * thinner:
        raise ValueError(
            f"{pair.name}: every slave point lies at least {shallowest:.3e} inside the master before anything is "
            f"loaded, more than half of the thinner body ({thinner:.3e}): move the bodies apart, or correct the tags, "
            "the normal of a plane or the sign of a radius"
        )


def check_side(pair, V, slave, obstacle):
    """Refuse a rigid obstacle whose far side the slave looks at. Collective.

    Where the slave is nearest to the obstacle's surface its outward normals point against the obstacle's. They are
    compared at the slave's nodes within a facet of the nearest; a slave farther outside than a facet has time to turn.

    Raises:
        ValueError: on all ranks; says what to turn round.
    """
    comm, gdim = V.mesh.comm, V.mesh.geometry.dim
    x = V.tabulate_dof_coordinates()[:, :gdim]
    sums, marks = np.zeros(x.size), np.zeros(len(x))
    _cpp.gap.add_normals(slave, sums)
    marks[slave.nodes] = 1.0
    # Facets of all ranks, every node once: ranks share nodes.
    index_map = V.dofmap.index_map
    sums, marks = NodalSum(index_map, gdim)(sums).ravel(), NodalSum(index_map, 1)(marks).ravel()
    nodes = np.flatnonzero(marks[: index_map.size_local])
    inward = sums.reshape(-1, gdim)[nodes]
    inward /= np.maximum(np.linalg.norm(inward, axis=1), 1e-300)[:, None]
    gap, normal, _ = obstacle.evaluate(np.ascontiguousarray(x[nodes]).ravel())
    facet = float(np.max(np.ptp(slave.X, axis=1), initial=0.0))
    facet = comm.allreduce(facet, MPI.MAX)
    nearest = comm.allreduce(float(np.min(np.abs(gap), initial=np.inf)), MPI.MIN)
    near = np.abs(gap) <= nearest + facet
    parts = [np.einsum("na,na->", inward[near], normal[near]), np.count_nonzero(near)]
    agreement, number = comm.allreduce(np.array(parts, dtype=float), MPI.SUM)
    lowest = comm.allreduce(float(np.min(gap, initial=np.inf)), MPI.MIN)
    # +1: face to face; -1: back to back. Between, edges and both sides of thin bodies: no judgement.
    if agreement < -0.5 * number and lowest <= facet:
        turn = pair.master._turn()
        raise ValueError(f"{pair.name}: the slave looks away from the obstacle where it is nearest: {turn}")


def nearly_touching(comm, gap, size):
    """Up to which gap points are to be closed where bodies nearly touch; None: they are apart. Collective.

    Args:
        gap: (n), infinite where there is no master [L].
        size: (n) of the points' facets [L].
    """
    near = gap[gap < NEARLY * size]
    largest = comm.allreduce(float(np.max(near, initial=-np.inf)), MPI.MAX)
    return np.nextafter(largest, np.inf) if np.isfinite(largest) else None
