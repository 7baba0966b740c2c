# SPDX-License-Identifier: MIT
"""Pairs of surfaces that may touch, with checked input."""

import enum

import numpy as np
from dolfinx import mesh as dmesh
from mpi4py import MPI

from .. import _cpp
from ..common.arguments import LARGEST_DEGREE, integer
from ..common.collective import comm_of, guard
from ..loads import _tag, check_tag, facet_tags_of
from ..common.arguments import number
from .nodal_sum import NodalSum
from .rigid import _Rigid


class ContactStatus(enum.IntEnum):
    """Of a contact point in a converged state; arrays of status hold these numbers."""

    open = 0
    stick = 1
    slip = 2


class ContactPair:
    """Two surfaces that may touch: the slave carries the contact points, the master the facets they are projected on.

    Args:
        facet_tags: dolfinx MeshTags over facets.
        slave: tag of the slave surface; better the finer mesh and the softer body.
        master: tag of the master surface, or a RigidPlane, RigidSphere, RigidCylinder, RigidSurface.
        friction: Coulomb's coefficient, zero or more [1].
        search_distance: within which slave and master are paired; None: from the sizes of the facets [L].
        remove_penetration: contact points that penetrate before anything is loaded start in touch instead: what they
            penetrate by is added to their gaps from then on. For meshes that overlap where the bodies do not.
        name: for messages and files.

    Raises:
        TypeError: tags that are no integers, a master of another kind. ValueError: slave and master are the same
        surface, negative or infinite friction. What needs the mesh is checked when a problem takes the pair.
    """

    def __init__(
        self, facet_tags, slave, master, friction=0.0, search_distance=None, remove_penetration=False, name=None
    ):
        given = dict(slave=slave, master=master, friction=friction, search_distance=search_distance, name=name)
        with guard(comm_of(facet_tags), "ContactPair", **given, remove_penetration=bool(remove_penetration)):
            self._check(facet_tags, slave, master, friction, search_distance)
        self.remove_penetration = bool(remove_penetration)
        self.name = name or f"contact {self.slave}-{'rigid' if self.rigid else self.master}"

    def __repr__(self):
        return f"ContactPair({self.name!r}: slave {self.slave}, master {self.master!r}, friction {self.friction})"

    def _check(self, facet_tags, slave, master, friction, search_distance):
        """Arguments of a pair, on this rank."""
        self.facet_tags, self.slave = facet_tags_of("ContactPair", facet_tags), _tag(slave)
        if not isinstance(master, (_Rigid, int, float, np.integer, np.floating)):
            hint = " (make an object of it)" if isinstance(master, type) else ""
            raise TypeError(f"master must be a tag or a rigid obstacle, found {master!r:.60}{hint}")
        self.master = master if isinstance(master, _Rigid) else _tag(master)
        self.rigid = isinstance(master, _Rigid)
        if not self.rigid and self.slave == self.master:
            raise ValueError(
                f"slave and master have the same tag {self.slave}: self-contact is not supported, tag two surfaces"
            )
        self.friction = number("friction", friction)
        if self.friction < 0.0:
            raise ValueError(f"friction is {self.friction}: a coefficient of friction is zero or positive")
        self.search_distance = None
        if search_distance is not None:
            self.search_distance = number("search_distance", search_distance, 0.0, " [L]")

    def surfaces(self, V):
        """This rank's slave and master facets on the displacement space V (the master is None if rigid). Collective.

        Raises:
            ValueError: on all ranks, for a tag without facets, facets inside the body, shared facets or nodes.
        """
        mesh = V.mesh
        tdim = mesh.topology.dim
        for what, tag in (("slave", self.slave),) + (() if self.rigid else (("master", self.master),)):
            check_tag(self.facet_tags, tag, mesh, f"{self.name}, {what}")
        mesh.topology.create_connectivity(tdim - 1, tdim)
        mesh.topology.create_connectivity(tdim, tdim - 1)
        exterior = dmesh.exterior_facet_indices(mesh.topology)
        made = []
        for tag in (self.slave,) if self.rigid else (self.slave, self.master):
            facets = self.facet_tags.find(tag)
            inside = mesh.comm.allreduce(len(np.setdiff1d(facets, _boundary(mesh, exterior))), MPI.SUM)
            if inside:
                raise ValueError(f"{self.name}: {inside} facets with the tag {tag} lie inside the body")
            made.append(_guarded(mesh.comm, lambda f=np.intersect1d(facets, exterior): _surface(V, f)))
        if self.rigid:
            return made[0], None
        self._check_shared_nodes(V, *made)
        return tuple(made)

    def _check_shared_nodes(self, V, slave, master):
        index_map, gdim = V.dofmap.index_map, V.mesh.geometry.dim
        total = NodalSum(index_map, 2)
        marks = np.zeros((index_map.size_local + index_map.num_ghosts, 2))
        marks[slave.nodes, 0] = marks[master.nodes, 1] = 1.0
        # A node of both sides may lie on no rank that has a facet of both: its owner hears of either.
        shared = np.flatnonzero(np.all(total(marks)[: index_map.size_local] > 0.0, axis=1))
        count = V.mesh.comm.allreduce(len(shared), MPI.SUM)
        if count:
            first = V.tabulate_dof_coordinates()[shared[:3], :gdim].round(12).tolist()
            some = sum(V.mesh.comm.allgather(first), [])[:3]
            raise ValueError(
                f"{self.name}: slave and master share {count} nodes, the first at {some}: a body cannot touch "
                "itself there; leave the common edge out of one of the tags, or mesh the bodies apart"
            )


def _surface(V, facets):
    return _cpp.surface.make_surface(V._cpp_object, np.ascontiguousarray(facets, dtype=np.int32))


def _boundary(mesh, exterior):
    """Exterior facets this rank knows, and all ghosts: only its owner knows whether a ghost is exterior."""
    tdim = mesh.topology.dim
    ghosts = np.arange(
        mesh.topology.index_map(tdim - 1).size_local,
        mesh.topology.index_map(tdim - 1).size_local + mesh.topology.index_map(tdim - 1).num_ghosts,
        dtype=np.int32,
    )
    return np.concatenate([exterior, ghosts])


def _guarded(comm, function):
    """Result of a function that may fail on some ranks: then ValueError on all."""
    result, error = None, ""
    try:
        result = function()
    except (ValueError, RuntimeError) as e:
        error = str(e)
    errors = [e for e in comm.allgather(error) if e]
    if errors:
        raise ValueError(errors[0])
    return result


def check_pair(pair):
    """What an enforcement of contact was given, on this rank."""
    if not isinstance(pair, ContactPair):
        raise TypeError(f"expected a ContactPair, found {type(pair).__name__}")


def check_quadrature_degree(degree):
    """None, or a degree that quadrature rules exist for."""
    return None if degree is None else integer("quadrature_degree", degree, 1, LARGEST_DEGREE)
