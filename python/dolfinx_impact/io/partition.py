# SPDX-License-Identifier: MIT
"""A mesh shared out anew: each rank has equal work, cells and what nodes of a contact cost beside them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from dolfinx import cpp, io, la, mesh
from dolfinx.mesh import Mesh, MeshTags
from mpi4py import MPI

from .. import _cpp, compat
from ..common.cell_numbers import has_input, input_cell_numbers
from ..common.collective import common, guard
from ..common.types import FloatArray, IntArray
from .bisection import Cost, bisect, one_rank_each

__all__ = ["PartitionedMesh", "partition"]

# Time of a slave node in a step over that of a linear hexahedron, penalty with friction (docs/performance.md).
NODE_COST = 3.0
# Nodes per facet of a large surface, by the cells below.
_NODES_PER_FACET = {"triangle": 1.0, "quadrilateral": 1.0, "tetrahedron": 0.5, "hexahedron": 1.0}


@dataclass(frozen=True)
class PartitionedMesh:
    """A mesh with equal work on all ranks; unpacks as (mesh, cell_tags, facet_tags).

    Attributes:
        mesh: the mesh, without ghost cells. Its cells and nodes keep their numbers in the input of the first mesh.
        cell_tags: tags of its cells; None if none were given.
        facet_tags: tags of its facets; None if none were given.
        work: of this rank: cost of the cells and slave nodes that it owns, in cells [1].
        imbalance: how much the largest work exceeds the mean, over the mean; the same on all ranks [1].
    """

    mesh: Mesh
    cell_tags: MeshTags | None
    facet_tags: MeshTags | None
    work: float
    imbalance: float

    def __iter__(self) -> Iterator[Any]:
        return iter((self.mesh, self.cell_tags, self.facet_tags))


def partition(
    domain: Mesh,
    cell_tags: MeshTags | None = None,
    facet_tags: MeshTags | None = None,
    slave: int | Sequence[int] = (),
    node_cost: float = NODE_COST,
    cell_cost: Cost | None = None,
) -> PartitionedMesh:
    """Share out the cells of a mesh anew, so that all ranks have equal work in explicit steps. Collective.

    Cells are cut along the coordinates (docs/howto/many_ranks.md) into blocks of equal cost. The result has no ghost
    cells, which explicit steps need for residuals with `ufl.dS` only.

    Args:
        domain: mesh, whatever its ghosts; it stays as it is.
        cell_tags: tags of its cells, which come along.
        facet_tags: tags of its facets, which come along.
        slave: tag or tags of facets whose nodes are slaves of a contact; of both surfaces where the contact is
            balanced.
        node_cost: cost of a slave node over that of a cell of cost 1 [1].
        cell_cost: cost of cells by their midpoints, (n, 3) -> (n), as where cells yield; None: 1 each [1].

    Returns:
        Mesh, tags, and the work of the ranks.

    Raises:
        TypeError: an argument is of the wrong type; on all ranks.
        ValueError: tags are of another dimension or mesh, or missing, no facet has a tag of `slave`, costs are
            negative, not finite or all zero; on all ranks.
    """
    if not isinstance(domain, Mesh):
        raise TypeError(f"partition takes a mesh of dolfinx.mesh, found {type(domain).__name__}")
    tdim = domain.topology.dim
    with guard(domain.comm, "partition", slave=slave, node_cost=node_cost) as ranks:
        slave = [int(tag) for tag in np.atleast_1d(np.asarray(slave, dtype=np.int64))]
        for name, tags, dim in (("cell_tags", cell_tags, tdim), ("facet_tags", facet_tags, tdim - 1)):
            if tags is not None and not isinstance(tags, MeshTags):
                raise TypeError(f"{name} must be MeshTags or None, found {type(tags).__name__}")
            if tags is not None and tags.dim != dim:
                raise ValueError(f"{name} needs tags of dimension {dim}, found tags of dimension {tags.dim}")
            if tags is not None and tags.topology is not domain.topology._cpp_object:
                raise ValueError(f"{name}: the tags are of another mesh: make them on the one that is shared out")
        if slave and facet_tags is None:
            raise ValueError("slave = ...: give the facet_tags that these numbers are of")
        if not (np.isfinite(node_cost) and node_cost >= 0.0):
            raise ValueError(f"node_cost = {node_cost}: it is finite and not negative")
        costs = _costs(domain, facet_tags, slave, float(node_cost), cell_cost)
        ranks.same(cell_tags=cell_tags is None, facet_tags=facet_tags is None, cell_cost=cell_cost is None)
    _check_sums(domain.comm, costs, facet_tags, slave)
    owned = np.arange(len(costs), dtype=np.int32)
    parts = _on_one_rank(domain.comm, mesh.compute_midpoints(domain, tdim, owned), costs)
    nodes = domain.geometry.index_map()
    places = compat.geometry_dofmap(domain)[: len(owned)]  # no rows on a rank without cells
    cells = nodes.local_to_global(places.reshape(-1)).reshape(places.shape)
    made = mesh.create_mesh(
        domain.comm,
        cells,
        x=domain.geometry.x[: nodes.size_local, : domain.geometry.dim],
        e=domain.ufl_domain().ufl_coordinate_element(),  # a domain of its own: that of UFL knows one mesh only
        partitioner=lambda *given: one_rank_each(parts),
    )
    new_cells, new_facets = (None if t is None else _move(domain, t, made) for t in (cell_tags, facet_tags))
    _keep_input_numbers(domain, made)
    with guard(domain.comm, "partition"):  # `cell_cost` is called with other midpoints than before
        new_costs = _cell_costs(made, cell_cost)
    work = _work(made, new_facets, slave, float(node_cost), new_costs)
    total, most = made.comm.allreduce(work, MPI.SUM), made.comm.allreduce(work, MPI.MAX)
    return PartitionedMesh(made, new_cells, new_facets, work, most * made.comm.size / total - 1.0)


def _cell_costs(domain: Mesh, cell_cost: Cost | None) -> FloatArray:
    """Cost of owned cells, without contact."""
    tdim = domain.topology.dim
    num = domain.topology.index_map(tdim).size_local
    if cell_cost is None:
        return np.ones(num)
    costs = np.asarray(cell_cost(mesh.compute_midpoints(domain, tdim, np.arange(num, dtype=np.int32))), dtype=float)
    if costs.shape != (num,):
        raise ValueError(f"cell_cost must return a value for each of {num} midpoints, found shape {costs.shape}")
    if not np.all(np.isfinite(costs) & (costs >= 0.0)):
        raise ValueError("cell_cost returned a value that is negative or not finite")
    return costs


def _check_sums(comm: MPI.Comm, costs: FloatArray, facet_tags: MeshTags | None, slave: Sequence[int]) -> None:
    """Check what the ranks know together: there is some cost, and facets of each slave tag. Collective.

    Raises:
        ValueError: there is none; on all ranks.
    """
    here = np.array([costs.sum(), *(len(_slave_facets(facet_tags, [tag])) for tag in slave)])
    total = np.empty_like(here)
    comm.Allreduce(here, total)
    if not total[0] > 0.0:
        raise common(ValueError("all cells cost nothing: cell_cost must be positive somewhere"))
    missing = [tag for tag, count in zip(slave, total[1:]) if count == 0]
    if missing:
        raise common(ValueError(f"slave: no facet of facet_tags has the tag {missing[0]}"))


def _slave_facets(facet_tags: MeshTags | None, slave: Sequence[int]) -> IntArray:
    """Facets with one of these tags, as this rank knows them."""
    if facet_tags is None or not slave:
        return np.zeros(0, dtype=np.int32)
    found: IntArray = facet_tags.indices[np.isin(facet_tags.values, slave)]
    return found


def _costs(
    domain: Mesh, facet_tags: MeshTags | None, slave: Sequence[int], node_cost: float, cell_cost: Cost | None
) -> FloatArray:
    """Cost of owned cells; those at slave facets have that of the facets' nodes."""
    topology, tdim = domain.topology, domain.topology.dim
    costs = _cell_costs(domain, cell_cost).copy()
    if slave:
        topology.create_connectivity(tdim - 1, tdim)
        to_cells = topology.connectivity(tdim - 1, tdim)
        cells = to_cells.array[to_cells.offsets[_slave_facets(facet_tags, slave)]]
        cell = compat.cell_name(domain.ufl_domain())
        np.add.at(costs, cells[cells < len(costs)], node_cost * _NODES_PER_FACET[cell])
    return costs


def _on_one_rank(comm: MPI.Comm, middles: FloatArray, costs: FloatArray) -> IntArray:
    """Ranks of this rank's cells; the cuts are made on rank 0, which needs 36 B for each cell of the mesh."""
    counts: list[int] | None = comm.gather(len(costs), root=0)
    rows, mine = np.column_stack([middles, costs]), np.empty(len(costs), dtype=np.int32)
    if counts is None:
        comm.Gatherv(rows, None, root=0)
        comm.Scatterv(None, mine, root=0)
        return mine
    all_rows = np.empty((sum(counts), 4))
    comm.Gatherv(rows, [all_rows, [4 * n for n in counts]], root=0)
    comm.Scatterv([bisect(all_rows[:, :3], all_rows[:, 3], comm.size), counts], mine, root=0)
    return mine


def _move(domain: Mesh, tags: MeshTags, made: Mesh) -> MeshTags:
    """Tags of a mesh on the same mesh with other owners of its cells."""
    dim = tags.dim
    domain.topology.create_connectivity(dim, domain.topology.dim)
    domain.topology.create_connectivity(dim, 0)
    chosen = tags.indices < domain.topology.index_map(dim).size_local
    if np.any(chosen):
        places = mesh.entities_to_geometry(domain, dim, tags.indices[chosen])
    else:  # DOLFINx divides by the number of vertices that it finds, none on a rank without cells
        kind = cpp.mesh.cell_entity_type(domain.topology.cell_type, dim, 0)
        places = np.zeros((0, cpp.mesh.cell_num_vertices(kind)), dtype=np.int32)
    nodes = domain.geometry.index_map().local_to_global(places.reshape(-1)).reshape(places.shape)
    vertices, values = io.distribute_entity_data(made, dim, nodes, tags.values[chosen])
    made.topology.create_connectivity(dim, 0)
    made.topology.create_connectivity(dim, made.topology.dim)
    out = mesh.meshtags_from_entities(made, dim, compat.adjacencylist(vertices), values)
    out.name = tags.name
    return out


def _keep_input_numbers(domain: Mesh, made: Mesh) -> None:
    """Give cells and geometry nodes the numbers that they have in the input of the first mesh. Collective.

    Checkpoints, the choice between facets at one distance, and messages know cells by them: they must not depend on the
    ranks. Of a submesh, which has no input, they are its global numbers.
    """
    topology, geometry = domain.topology, domain.geometry
    cells, nodes = topology.index_map(topology.dim), geometry.index_map()
    given: IntArray = np.arange(*cells.local_range, dtype=np.int64)
    if domain.comm.allreduce(has_input(topology), MPI.LAND):
        given = input_cell_numbers(topology)[: cells.size_local].astype(np.int64)
    of_nodes = geometry.input_global_indices[: nodes.size_local]
    _cpp.files.set_input_numbers(
        made._cpp_object,
        _from_owners(domain.comm, given, made.topology.original_cell_index),
        _from_owners(domain.comm, of_nodes, made.geometry.input_global_indices),
    )


def _from_owners(comm: MPI.Comm, values: IntArray, wanted: IntArray) -> IntArray:
    """Values of entities by their global numbers; each rank has those of its own, in this order. Collective."""
    ends = np.cumsum(comm.allgather(len(values)))
    owners = np.searchsorted(ends, wanted, side="right")
    order = np.argsort(owners, kind="stable")
    asked = np.split(wanted[order], np.searchsorted(owners[order], np.arange(1, comm.size)))
    first = ends[comm.rank] - len(values)
    replies = comm.alltoall([values[numbers - first] for numbers in comm.alltoall(asked)])
    found = np.empty(len(wanted), dtype=np.int64)
    found[order] = np.concatenate(replies)
    return found


def _work(
    domain: Mesh, facet_tags: MeshTags | None, slave: Sequence[int], node_cost: float, cell_costs: FloatArray
) -> float:
    """Cost of the cells and slave nodes that this rank owns. Collective."""
    facets, topology = _slave_facets(facet_tags, slave), domain.topology
    topology.create_connectivity(topology.dim - 1, 0)
    to_vertices = topology.connectivity(topology.dim - 1, 0)
    is_slave = la.vector(topology.index_map(0))
    per_facet = to_vertices.offsets[1] if len(to_vertices.offsets) > 1 else 1
    is_slave.array[to_vertices.array.reshape(-1, per_facet)[facets].reshape(-1)] = 1.0
    is_slave.scatter_reverse(la.InsertMode.add)
    num_slaves = np.count_nonzero(is_slave.array[: topology.index_map(0).size_local])
    return float(cell_costs.sum() + node_cost * num_slaves)
