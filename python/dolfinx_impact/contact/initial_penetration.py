# SPDX-License-Identifier: MIT
"""The reference configuration: surfaces of wrong orientation are refused, penetrations are reported and removed."""

import logging

import numpy as np
from dolfinx.fem import FunctionSpace
from mpi4py import MPI

from ..common.described import Described
from .. import _cpp
from ..assembly import rigid_body_modes
from ..common.types import FloatArray
from .nodal_sum import NodalSum
from .body_size import body_size
from .pair import ContactPair

LOG = logging.getLogger("dolfinx_impact")
# Penetrations below this part of the bodies' size are round-off of coordinates that come from files or from gmsh.
ROUND_OFF = 1e-10
# Bodies nearly touch if the gap is less than this part of a facet. On a round body of radius R the distance between a
# facet of size h and its arc is h^2/(8 R), a hundredth of h on meshes with 70 facets around.
NEARLY = 0.01


class InitialPenetration(Described):
    """Penetrations of the contact points in the reference configuration of bodies and obstacles. Collective.

    Args:
        pair: the pair of surfaces.
        V: displacement space.
        slave: this rank's facets of the slave.
        master: this rank's facets of the master; None: the master is rigid.
        x: positions of the contact points, (n, gdim) [L].
        gap: gaps of the contact points, (n), infinite without master [L].

    Attributes:
        num_points: number of contact points of all ranks that penetrate.
        depth: their largest penetration [L].
        where: position of the largest penetration, gdim components; None without penetration [L].
        offset: values to be added to all later gaps, (n) [L].

    Raises:
        ValueError: every point penetrates by more than half of the thinner body; on all ranks.
    """

    where: list[float] | None

    def __init__(
        self,
        pair: ContactPair,
        V: FunctionSpace,
        slave: _cpp.surface.Facets,
        master: _cpp.surface.Facets | None,
        x: FloatArray,
        gap: FloatArray,
    ) -> None:
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
        if self.where is not None and comm.rank == 0:
            place = ", ".join(f"{round(v, 12) + 0.0:.4g}" for v in self.where)
            end = ": removed, gaps count from there" if pair.remove_penetration else ""
            LOG.warning(
                f"{pair.name}: {self.num_points} points penetrate before anything is loaded, by up to "
                f"{self.depth:.3e} at ({place}){end}"
            )


def _check_depth(
    pair: ContactPair,
    V: FunctionSpace,
    slave: _cpp.surface.Facets,
    master: _cpp.surface.Facets | None,
    shallowest: float,
) -> None:
    """Refuse penetrations of more than half of the thinner body; a press fit has less. Collective."""
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


def check_side(pair: ContactPair, V: FunctionSpace, slave: _cpp.surface.Facets, obstacle: _cpp.gap.Rigid) -> None:
    """Refuse a rigid obstacle whose surface does not face the slave. Collective.

    Where the slave is nearest to the obstacle, its outward normals must be opposite to those of the obstacle. Normals
    are compared at the slave's nodes that are at most one facet farther away than the nearest one. A slave whose nodes
    are all farther outside than one facet is accepted.

    Args:
        pair: pair with a rigid master.
        V: displacement space.
        slave: this rank's facets of the slave.
        obstacle: the obstacle on the C++ side.

    Raises:
        ValueError: the surfaces do not face each other; on all ranks.
    """
    comm, gdim = V.mesh.comm, V.mesh.geometry.dim
    x = V.tabulate_dof_coordinates()[:, :gdim]
    sums, marks = np.zeros(x.size), np.zeros(len(x))
    _cpp.gap.add_normals(slave, sums)
    marks[slave.nodes] = 1.0
    # Sums over the facets of all ranks; every node is counted by its owner only.
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
    # The mean is +1 for opposite normals, -1 for equal ones. Values between come from edges and from both sides of thin
    # bodies; they are accepted.
    if agreement < -0.5 * number and lowest <= facet:
        hint = pair.rigid_master.orientation_hint()
        raise ValueError(f"{pair.name}: the slave's normals point away from the obstacle where it is nearest: {hint}")


def nearly_touching(comm: MPI.Comm, gap: FloatArray, size: FloatArray) -> float | None:
    """Largest gap of points that are to be closed between bodies that nearly touch. Collective.

    Args:
        comm: communicator of the mesh.
        gap: gaps of the contact points, (n), infinite without master [L].
        size: sizes of the points' facets, (n) [L].

    Returns:
        The gap; None if the bodies do not nearly touch [L].
    """
    near = gap[gap < NEARLY * size]
    largest = comm.allreduce(float(np.max(near, initial=-np.inf)), MPI.MAX)
    return np.nextafter(largest, np.inf) if np.isfinite(largest) else None
