# SPDX-License-Identifier: MIT
"""Contact that finds itself: all outer facets against each other, no pairs named; docs/explicit/general_contact.md."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from typing import Any

import numpy as np
from dolfinx import mesh as dmesh
from dolfinx.fem import FunctionSpace
from dolfinx.mesh import MeshTags
from mpi4py import MPI

from ... import _cpp
from ...amplitude import Amplitude
from ...common.arguments import number
from ...common.collective import comm_of, guard
from ...common.fixed import Fixed
from ...common.types import FloatArray, IntArray
from ...loads import _tag, check_tag, facet_tags_of
from ..nodal_sum import NodalSum
from ..pair import ContactPair, _boundary, _guarded, _surface
from ..penalty.static_general import StaticGeneral
from ..protocol import ExplicitContactProblem, StaticContactProblem
from .nodal_output import NodalOutput

AXIS = 1e-12  # part of the largest radius within which a facet is on the axis
RESULTS = ("normal", "gap", "pressure", "traction", "slip", "status")  # arrays by node


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


class GeneralContact(Fixed):
    """Contact of all outer facets with each other in an explicit problem, by penalty; docs/explicit/general_contact.md.

    Neither side is slave or master, a body may touch itself, and edges touch edges in 3D. What pairs of the same
    problem enforce between their surfaces is left to them. Displacements of degree 1 on straight facets.

    Args:
        facet_tags: tags of facets.
        tags: tags of the facets that may touch; None: all facets of the boundary, tagged or not.
        friction: coefficient of friction, zero or more [1].
        name: name for messages and files.

    Raises:
        TypeError: `facet_tags` are no tags of facets, or a tag is no integer; on all ranks.
        ValueError: no tags in `tags`, a tag twice, or a friction that is negative or not finite; on all ranks. The tags
            are compared with the mesh when a problem is made.
    """

    def __init__(
        self,
        facet_tags: MeshTags,
        tags: Sequence[int] | int | None = None,
        friction: float = 0.0,
        name: str = "general contact",
    ) -> None:
        with guard(comm_of(facet_tags), "GeneralContact", tags=tags, friction=friction, name=name):
            facet_tags_of("GeneralContact", facet_tags)
            chosen = None
            if tags is not None:
                given = list(tags) if isinstance(tags, (list, tuple, set, np.ndarray)) else [tags]
                chosen = tuple(_tag(tag) for tag in given)
                if not chosen:
                    raise ValueError("tags is empty: name the tags of facets that may touch, or give None for all")
                if len(set(chosen)) < len(chosen):
                    raise ValueError(f"tags has a tag twice: {list(chosen)}")
            coefficient = number("friction", friction)
            if coefficient < 0.0:
                raise ValueError(f"friction is {coefficient}: a coefficient of friction is zero or positive")
            self.pair = GeneralSurface(facet_tags, chosen, coefficient, name)

    def __repr__(self) -> str:
        which = "all outer facets" if self.pair.tags is None else f"tags {list(self.pair.tags)}"
        return f"GeneralContact({self.pair.name!r}: {which}, friction {self.pair.friction})"

    def _bind(self, problem: StaticContactProblem) -> StaticGeneral:
        return StaticGeneral(self.pair, problem)

    def _bind_explicit(self, problem: ExplicitContactProblem) -> GeneralOutput:
        return GeneralOutput(self.pair, problem)


def named_pairs(contacts: Sequence[Any]) -> list[ContactPair]:
    """Pairs of surfaces that a general contact of the same problem leaves alone.

    Args:
        contacts: contacts that a problem was given.

    Raises:
        ValueError: several contacts are general.
    """
    if sum(isinstance(c, GeneralContact) for c in contacts) > 1:
        raise ValueError("contact has several GeneralContact: give the tags of all surfaces that may touch to one")
    pairs = [getattr(c, "pair", None) for c in contacts]
    return [pair for pair in pairs if isinstance(pair, ContactPair) and not pair.rigid]


class GeneralOutput(NodalOutput):
    """General contact of an explicit problem, a view of cpp/dolfinx_impact/enforcement/general/GeneralContact.h; points
    are the surface nodes that this rank owns.

    A node is pushed by springs of its own, as corner of facets that other nodes have come through, and as end of edges:
    traction and pressure have all of it. Status, gap and slip are those of its own spring; in a corner between facets,
    where it has up to three, of that with the largest force.

    Args:
        pair: the surface.
        problem: the problem.

    Attributes:
        nodes: owned surface nodes, (n).
        weight: areas of the nodes, (n) [L^2].
        pressure: part of the traction along the outward normal, positive in compression, (n) [F/L^2].
        traction: contact force on the node over its area, (n, gdim) [F/L^2].
        normal: mean outward normals of the surface at the nodes, (n, gdim) [1].
        gap: gap of the node's own spring, negative; infinite while it is open, (n) [L].
        slip: accumulated since the node's own spring has closed, (n, gdim) [L].
        status: ContactStatus numbers of the nodes' own springs, (n).
        stored: energy stored in the springs, of all ranks [F L].
        penetration_share: energy in the springs over that in springs and bodies [1].
        deepest: deepest penetration of all ranks in the last step [L].
        num_springs: closed springs of all ranks: of nodes, and of crossed edges.

    Raises:
        ValueError: surfaces that do not fit the problem; on all ranks.
    """

    initial = None
    kind, kinematic, is_penalty, body, penalty = "GeneralContact", False, True, None, 0.0
    motion: Amplitude | None = None
    nodes: IntArray
    weight: FloatArray
    points: FloatArray
    normal: FloatArray
    gap: FloatArray
    pressure: FloatArray
    traction: FloatArray
    slip: FloatArray
    status: IntArray
    penetration_share = deepest = 0.0
    num_springs = (0, 0)

    def __init__(self, pair: GeneralSurface, problem: ExplicitContactProblem) -> None:
        self.pair: Any = pair
        self.problem, self.V = problem, problem.space
        V = problem.space
        self.comm, self.gdim = V.mesh.comm, V.mesh.geometry.dim
        self._facets = pair.facets(V, problem.axisymmetric)
        surfaces = [other.surfaces(V) for other in problem.named_pairs]
        named = [(slave, master) for slave, master in surfaces if master is not None]
        self._general = _cpp.nodal.GeneralContact(
            V._cpp_object, self._facets, pair.friction, named, problem.axisymmetric
        )
        self._cpp_object = _cpp.nodal.NodalPair([self._general])
        self.nodes, self.weight = self._general.nodes, self._general.areas
        self._X = self._general.X.reshape(-1, self.gdim)

    @property
    def options(self) -> dict[str, Any]:
        return {}

    def facets(self) -> tuple[_cpp.surface.Facets, None]:
        return self._facets, None

    def sides(self) -> list[Any]:
        return [self._general]

    def refresh(self) -> None:
        self.update_results()

    def update_results(self) -> None:
        gdim = self.gdim
        results = self._general.results()
        self.status, self.gap, self.slip = (results[name] for name in ("status", "gap", "slip"))
        self.points = self._X + self.problem.u.x.array.reshape(-1, gdim)[self.nodes]
        self.normal = self._general.normals().reshape(-1, gdim)
        forces = self._general.nodal_forces().reshape(-1, gdim)
        self.traction = forces / self.weight[:, None]
        self.pressure = np.maximum(0.0, -np.sum(self.traction * self.normal, axis=1))
        springs = self._general.num_springs
        sums = self.sum_up(forces, forces.sum(axis=0), np.any(forces != 0.0, axis=1), *map(float, springs))
        self.num_springs = int(sums[0]), int(sums[1])
        self.deepest = self.comm.allreduce(self._general.deepest, MPI.MAX)

    def force_on(self, tag: int) -> FloatArray:
        """Contact force on the surface with a tag, at the present time. Collective.

        Forces at nodes that it shares with other surfaces count to it.

        Args:
            tag: tag of facets.

        Returns:
            Force, (gdim) [F].

        Raises:
            ValueError: no facet of the boundary has the tag; on all ranks.
        """
        with guard(self.comm, "force_on", tag=tag):
            which = _tag(tag)
        mesh = self.V.mesh
        check_tag(self.pair.facet_tags, which, mesh, self.pair.name)
        chosen = np.intersect1d(self.pair.facet_tags.find(which), dmesh.exterior_facet_indices(mesh.topology))
        made = _guarded(self.comm, functools.partial(_surface, self.V, chosen))
        index_map = self.V.dofmap.index_map
        marks = np.zeros((index_map.size_local + index_map.num_ghosts, 1))
        marks[made.nodes] = 1.0
        mask = NodalSum(index_map, 1)(marks)[:, 0] > 0.0
        forces = (self.traction * self.weight[:, None])[mask[self.nodes]]
        return np.asarray(self.comm.allreduce(forces.sum(axis=0), MPI.SUM))

    def results_state(self) -> tuple[_cpp.state.State, _cpp.state.State]:
        return self.state_of(RESULTS)

    def resume_results(self, rows: _cpp.state.State, totals: _cpp.state.State) -> None:
        """There are no contact forces in a checkpoint to compute them from."""
        for name in RESULTS:
            now = getattr(self, name)
            setattr(self, name, rows.array(name).reshape(now.shape).astype(now.dtype))
        self.resume_totals(totals)

    def covered(self) -> FloatArray:
        """One or zero: a node is in contact or not."""
        return np.any(self.traction != 0.0, axis=1).astype(float)
