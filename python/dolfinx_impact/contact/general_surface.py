# SPDX-License-Identifier: MIT
"""A surface whose facets may touch each other; docs/general_contact.md."""

from __future__ import annotations

import functools

import numpy as np
from dolfinx import mesh as dmesh
from dolfinx.fem import FunctionSpace
from dolfinx.mesh import MeshTags
from mpi4py import MPI

from .. import _cpp
from ..common.collective import guard
from ..common.fixed import Fixed
from ..common.types import BoolArray
from ..loads import _tag, check_tag
from .nodal_sum import NodalSum
from .pair import _boundary, _guarded, _surface

AXIS = 1e-12  # part of the largest radius within which a facet is on the axis


class GeneralSurface(Fixed):
    """Facets of the boundary that may touch each other.

    Args:
        facet_tags: tags of facets.
        tags: tags of the facets that belong to the surface; None: all facets of the boundary, tagged or not.
        friction: coefficient of friction [1].
        name: name for messages and files.
    """

    rigid, rigid_body = False, None

    def __init__(self, facet_tags: MeshTags, tags: tuple[int, ...] | None, friction: float, name: str) -> None:
        self.facet_tags, self.tags, self.friction, self.name = facet_tags, tags, friction, name

    def __repr__(self) -> str:
        which = "all outer facets" if self.tags is None else f"tags {list(self.tags)}"
        return f"GeneralSurface({self.name!r}: {which}, friction {self.friction})"

    def facets(self, V: FunctionSpace, axisymmetric: bool = False) -> _cpp.surface.Facets:
        """Find this rank's facets. Collective.

        Args:
            V: displacement space.
            axisymmetric: whether x is the radius: facets on the axis are none of the surface.

        Returns:
            The facets.

        Raises:
            ValueError: a tag without facets, or facets inside the body; on all ranks.
        """
        mesh = V.mesh
        tdim = mesh.topology.dim
        for tag in self.tags or ():
            check_tag(self.facet_tags, tag, mesh, self.name)
        mesh.topology.create_connectivity(tdim - 1, tdim)
        mesh.topology.create_connectivity(tdim, tdim - 1)
        exterior = dmesh.exterior_facet_indices(mesh.topology)
        if self.tags is None:
            chosen = exterior
        else:
            tagged = self.facet_tags.indices[np.isin(self.facet_tags.values, self.tags)]
            inside = mesh.comm.allreduce(len(np.setdiff1d(tagged, _boundary(mesh, exterior))), MPI.SUM)
            if inside:
                raise ValueError(f"{self.name}: {inside} facets with the tags {list(self.tags)} lie inside the body")
            chosen = np.intersect1d(tagged, exterior)
        if axisymmetric:
            reach = max(float(np.abs(mesh.geometry.x[:, 0]).max(initial=0.0)), 1e-300)
            on_axis = dmesh.locate_entities_boundary(mesh, tdim - 1, lambda x: np.abs(x[0]) <= AXIS * reach)
            chosen = np.setdiff1d(chosen, on_axis)
        return _guarded(mesh.comm, functools.partial(_surface, V, chosen))

    def nodes_with(self, tag: int, V: FunctionSpace) -> BoolArray:
        """Find the nodes of the facets with a tag, of all ranks. Collective.

        Args:
            tag: tag of facets of the boundary.
            V: displacement space.

        Returns:
            Mask of the owned and ghost nodes.

        Raises:
            ValueError: no facet of the boundary has the tag; on all ranks.
        """
        with guard(V.mesh.comm, "force_on", tag=tag):
            which = _tag(tag)
        mesh = V.mesh
        check_tag(self.facet_tags, which, mesh, self.name)
        chosen = np.intersect1d(self.facet_tags.find(which), dmesh.exterior_facet_indices(mesh.topology))
        made = _guarded(mesh.comm, functools.partial(_surface, V, chosen))
        index_map = V.dofmap.index_map
        marks = np.zeros((index_map.size_local + index_map.num_ghosts, 1))
        marks[made.nodes] = 1.0
        return np.asarray(NodalSum(index_map, 1)(marks)[:, 0] > 0.0)
