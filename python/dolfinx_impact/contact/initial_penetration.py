# SPDX-License-Identifier: MIT
"""The reference configuration: surfaces of wrong orientation are refused, penetrations are reported and removed."""

import logging

import numpy as np
from dolfinx.fem import FunctionSpace
from mpi4py import MPI

from ..common.described import Described
from .. import _cpp
from ..common.types import FloatArray
from .pair import ContactPair

LOG = logging.getLogger("dolfinx_impact")


class InitialPenetration(Described):
    """Penetrations of the contact points in the reference configuration of bodies and obstacles. Collective.

    Args:
        found: the C++ object.
        comm: communicator of the mesh.

    Attributes:
        num_points: number of contact points of all ranks that penetrate.
        depth: their largest penetration [L].
        where: position of the largest penetration, gdim components; None without penetration [L].
        offset: values to be added to all later gaps, (n) [L].
    """

    where: list[float] | None

    def __init__(self, found: _cpp.gap.InitialPenetration, comm: MPI.Comm) -> None:
        self.num_points, self.depth = found.num_points, found.depth
        self.where, self.offset = found.where or None, found.offset
        if found.warning and comm.rank == 0:
            LOG.warning(found.warning)

    @classmethod
    def of(
        cls,
        pair: ContactPair,
        V: FunctionSpace,
        slave: _cpp.surface.Facets,
        master: _cpp.surface.Facets | None,
        x: FloatArray,
        gap: FloatArray,
    ) -> "InitialPenetration":
        """Find them. Collective.

        Args:
            pair: the pair of surfaces.
            V: displacement space.
            slave: this rank's facets of the slave.
            master: this rank's facets of the master; None: the master is rigid.
            x: positions of the contact points, (n, gdim) [L].
            gap: gaps of the contact points, (n), infinite without master [L].

        Returns:
            The penetrations.

        Raises:
            ValueError: every point penetrates by more than half of the thinner body; on all ranks.
        """
        arguments = pair.name, V._cpp_object, slave, master, np.ravel(x), gap, pair.remove_penetration
        return cls(_cpp.gap.InitialPenetration(*arguments), V.mesh.comm)


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
    obstacle.orientation_hint = pair.rigid_master.orientation_hint()
    _cpp.gap.check_side(pair.name, V._cpp_object, slave, obstacle)


def nearly_touching(comm: MPI.Comm, gap: FloatArray, size: FloatArray) -> float | None:
    """Largest gap of points that are to be closed between bodies that nearly touch. Collective.

    Args:
        comm: communicator of the mesh.
        gap: gaps of the contact points, (n), infinite without master [L].
        size: sizes of the points' facets, (n) [L].

    Returns:
        The gap; None if the bodies do not nearly touch [L].
    """
    found: float | None = _cpp.gap.nearly_touching(comm, gap, size)
    return found
