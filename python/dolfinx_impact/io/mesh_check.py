# SPDX-License-Identifier: MIT
"""Checks of a mesh: folded and flat cells, missing tags. Collective, with the same error on every rank."""

import zlib
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from mpi4py import MPI

import basix
import numpy as np
from dolfinx.mesh import Mesh, MeshTags

from .. import compat
from ..common.cell_numbers import input_cell_numbers
from ..common.collective import comm_of, guard
from ..common.types import BoolArray, FloatArray, IntArray
from .torn_nodes import check_nodes

SHOWN = 5  # cells or nodes named in an error
CHUNK = 50_000  # cells whose Jacobians are in memory at the same time


@dataclass
class MeshReport:
    """Result of `check_mesh`.

    Attributes:
        num_cells: number of cells of all ranks [1].
        num_negative: number of cells with det J < 0 at all points; this is a matter of numbering, not an error [1].
        smallest_det: minimum over cells of |det J| / (largest extent of the cell)^tdim [1].
        cell_counts: number of cells by tag [1].
        facet_counts: number of facets by tag [1].
    """

    num_cells: int
    num_negative: int
    smallest_det: float
    cell_counts: dict[int, int]
    facet_counts: dict[int, int]


def check_mesh(
    mesh: Mesh,
    cell_tags: MeshTags | None = None,
    facet_tags: MeshTags | None = None,
    required_cell_tags: Iterable[int | str] = (),
    required_facet_tags: Iterable[int | str] = (),
    *,
    cell_names: Mapping[str, int] | None = None,
    facet_names: Mapping[str, int] | None = None,
    where: str = "mesh",
    numbers: IntArray | None = None,
) -> MeshReport:
    """Check cells and tags. Collective.

    The sign of det J may differ between cells, as DOLFINx renumbers simplices, but not inside a cell, and det J must
    not vanish.

    Args:
        mesh: mesh to check.
        cell_tags: tags of cells, or None.
        facet_tags: tags of facets, or None.
        required_cell_tags: tags of cells, or their names, that must not be empty.
        required_facet_tags: tags of facets, or their names, that must not be empty.
        cell_names: tags of cells by name, or None.
        facet_names: tags of facets by name, or None.
        where: beginning of error messages.
        numbers: numbers of the cells in the file, in the order of the mesh's input; on rank 0 only.

    Returns:
        What was found.

    Raises:
        TypeError: `mesh` is no mesh; on all ranks.
        ValueError: cells are flat, folded or inverted, or required tags are missing; on all ranks.
    """
    with guard(comm_of(mesh, cell_tags, facet_tags), "check_mesh") as ranks:
        if not hasattr(mesh, "geometry") or not hasattr(mesh, "topology"):
            raise TypeError(f"mesh must be a dolfinx mesh, found {type(mesh).__name__}")
        ranks.same(required_cell_tags=list(required_cell_tags), required_facet_tags=list(required_facet_tags))
    comm, cell_names, facet_names = mesh.comm, cell_names or {}, facet_names or {}
    lowest, highest, extent, centroid = _jacobians(mesh)
    size = extent**mesh.topology.dim
    flat = np.minimum(np.abs(lowest), np.abs(highest)) <= 1e-12 * size
    over = _folded_over(mesh)[: len(flat)]
    bad = np.flatnonzero(flat | (lowest * highest <= 0) | ~np.isfinite(size) | over)
    tag_of = dict(zip(cell_tags.indices, cell_tags.values)) if cell_tags is not None else {}
    cell_map = mesh.topology.index_map(mesh.topology.dim)
    mine = [
        (
            int(cell_map.local_range[0] + c), int(input_cell_numbers(mesh.topology)[c]), centroid[c],
            label(tag_of.get(c), cell_names), "zero volume" if flat[c] else "folded or inverted" if not over[c] else
            "lies over a neighbour (inverted)",
        )
        for c in bad[:SHOWN]
    ]  # fmt: skip
    total_bad = comm.allreduce(len(bad))
    problem = None
    if total_bad:
        every = sorted((item for part in comm.allgather(mine) for item in part), key=lambda item: item[0])
        if comm.rank == 0:
            lines = [
                f"  cell {number}" + ("" if numbers is None else f" (gmsh element {numbers[original]})")
                + f", centre ({', '.join(f'{x:.6g}' for x in x0)}), tag {tag}: {what}"
                for number, original, x0, tag, what in every[:SHOWN]
            ]  # fmt: skip
            more = f"\n  and {total_bad - SHOWN} more" if total_bad > SHOWN else ""
            problem = (
                f"{where}: {total_bad} cells of {cell_map.size_global} have det J zero or of both signs, or lie over "
            )
            problem += "a neighbour:\n"
            problem += (
                "\n".join(lines) + more + "\nMove their nodes apart, or remesh there (order of the nodes, distortion)."
            )
        raise ValueError(comm.bcast(problem, root=0))
    cell_counts, facet_counts = _counts(mesh, cell_tags), _counts(mesh, facet_tags)
    _require(where, "cell", required_cell_tags, cell_counts, cell_names)
    _require(where, "facet", required_facet_tags, facet_counts, facet_names)
    smallest = np.min(np.minimum(np.abs(lowest), np.abs(highest)) / size, initial=np.inf)
    return MeshReport(
        num_cells=cell_map.size_global,
        num_negative=comm.allreduce(int(np.sum(highest < 0))),
        smallest_det=comm.allreduce(float(smallest), op=MPI.MIN),
        cell_counts=cell_counts,
        facet_counts=facet_counts,
    )


def _jacobians(mesh: Mesh) -> tuple[FloatArray, ...]:
    """Jacobians of owned cells, computed for CHUNK cells at a time.

    Returns:
        Smallest and largest det J over test points, (num_cells) [L^tdim]; extent, (num_cells) [L]; centroid,
        (num_cells, gdim) [L].
    """
    tdim, cmap = mesh.topology.dim, compat.coordinate_element(mesh)
    cell = getattr(basix.CellType, mesh.topology.cell_name())
    element = basix.create_element(basix.ElementFamily.P, cell, cmap.degree, basix.LagrangeVariant(cmap.variant))
    points: FloatArray = np.asarray(basix.geometry(cell))
    if cmap.degree > 1:
        points = np.vstack([points, element.points, basix.make_quadrature(cell, 2 * cmap.degree)[0]])
    shape = np.asarray(element.tabulate(1, points))[1:, :, :, 0]  # (tdim, points, nodes)
    num_cells = mesh.topology.index_map(tdim).size_local
    dofmap, starts = compat.geometry_dofmap(mesh)[:num_cells], range(0, num_cells, CHUNK)
    parts = [_jacobians_of(mesh, shape, dofmap[first : first + CHUNK]) for first in starts or (0,)]
    return tuple(np.concatenate(values) for values in zip(*parts))


def _jacobians_of(mesh: Mesh, shape: FloatArray, cells: IntArray) -> tuple[FloatArray, ...]:
    """`_jacobians` of some cells.

    Args:
        mesh: mesh.
        shape: derivatives of the shape functions, (tdim, points, nodes) [1].
        cells: nodes of the cells, (cells, nodes).

    Returns:
        As `_jacobians`.
    """
    gdim = mesh.geometry.dim
    x = mesh.geometry.x[cells][:, :, :gdim]
    tdim, points, nodes = shape.shape
    coordinates: FloatArray = np.swapaxes(x, 1, 2)  # (cells, gdim, nodes)
    jacobian = (coordinates @ shape.reshape(tdim * points, nodes).T).reshape(len(x), gdim, tdim, points)
    J = [[jacobian[:, g, d] for d in range(tdim)] for g in range(gdim)]  # (cells, points) each
    if tdim == gdim == 2:
        det = J[0][0] * J[1][1] - J[0][1] * J[1][0]
    elif tdim == 3:
        minors = [J[i][1] * J[j][2] - J[i][2] * J[j][1] for i, j in ((1, 2), (2, 0), (0, 1))]
        det = sum((J[g][0] * minors[g] for g in range(3)), np.zeros(()))
    else:  # surface or line in space: the sign is that relative to the mean normal or direction
        columns = [np.stack([J[g][d] for g in range(gdim)], axis=-1) for d in range(tdim)]
        along = np.cross(columns[0], columns[1]) if tdim == 2 else columns[0]
        mean = along.mean(axis=1)
        length = np.linalg.norm(mean, axis=1)
        det = np.einsum("cqg,cg->cq", along, mean / np.where(length > 0, length, 1)[:, None])
    extent = np.ptp(x, axis=1).max(axis=1, initial=0)
    return det.min(axis=1, initial=np.inf), det.max(axis=1, initial=-np.inf), extent, x.mean(axis=1)


def _folded_over(mesh: Mesh) -> BoolArray:
    """Find cells that are on the same side of a facet as the neighbour that shares it.

    The sign of det J does not show whether a triangle or tetrahedron is inverted, as DOLFINx renumbers its vertices;
    its neighbours do. For other cells det J itself shows it.

    Returns:
        Mask of this rank's cells, ghosts included.
    """
    tdim, gdim = mesh.topology.dim, mesh.geometry.dim
    dofmap = compat.geometry_dofmap(mesh)
    num_cells = len(dofmap)
    over = np.zeros(num_cells, dtype=bool)
    if mesh.topology.cell_name() not in ("triangle", "tetrahedron") or tdim != gdim or num_cells == 0:
        return over
    vertices = dofmap[:, : tdim + 1]
    # Facet k is opposite to vertex k. Its sorted vertices identify it.
    facets = np.concatenate([np.sort(np.delete(vertices, k, axis=1), axis=1) for k in range(tdim + 1)])
    opposite = np.concatenate(list(vertices.T))
    cells = np.tile(np.arange(num_cells), tdim + 1)
    order = np.lexsort(facets.T)
    facets, opposite, cells = facets[order], opposite[order], cells[order]
    pairs = np.flatnonzero(np.all(facets[1:] == facets[:-1], axis=1))
    x = mesh.geometry.x[:, :gdim]
    origin = x[facets[pairs, 0]]
    edges = [x[facets[pairs, k]] - origin for k in range(1, tdim)]
    normal = np.column_stack([-edges[0][:, 1], edges[0][:, 0]]) if tdim == 2 else np.cross(edges[0], edges[1])
    sides = [np.einsum("pg,pg->p", normal, x[opposite[pairs + k]] - origin) for k in (0, 1)]
    wrong = pairs[sides[0] * sides[1] > 0.0]
    over[cells[wrong]] = over[cells[wrong + 1]] = True
    return over


def check_cells(mesh: Mesh) -> None:
    """Check the cells of a mesh, once for given coordinates. Collective.

    Args:
        mesh: mesh to check.

    Raises:
        ValueError: cells are flat, folded or inverted, or nodes of a truss are torn; on all ranks.
    """
    now = zlib.crc32(np.ascontiguousarray(mesh.geometry.x))
    known = getattr(mesh, "_impact_checked", None) == now
    if mesh.comm.allreduce(int(known), MPI.MIN):
        return
    check_nodes(mesh)
    if mesh.topology.cell_name() in ("triangle", "quadrilateral", "tetrahedron", "hexahedron"):
        check_mesh(mesh, where="the mesh of u")
    setattr(mesh, "_impact_checked", now)


def _counts(mesh: Mesh, tags: MeshTags | None) -> dict[int, int]:
    """Number of entities of all ranks by tag. Collective."""
    if tags is None:
        return {}
    mesh.topology.create_entities(tags.dim)
    owned = tags.values[tags.indices < mesh.topology.index_map(tags.dim).size_local]
    total: Counter[int] = Counter()
    for part in mesh.comm.allgather(Counter(owned.tolist())):
        total.update(part)
    return dict(sorted(total.items()))


def label(tag: int | None, names: Mapping[str, int]) -> str:
    """Text for a tag, with its name if it has one.

    Args:
        tag: tag, or None.
        names: tags by name.

    Returns:
        Text for messages.
    """
    name = next((name for name, number in names.items() if number == tag), None)
    return f"{tag}" if name is None else f'{tag} ("{name}")'


def _require(
    where: str, kind: str, required: Iterable[int | str], counts: Mapping[int, int], names: Mapping[str, int]
) -> None:
    """Raise ValueError if a required tag, given by number or name, has no entity."""
    numbers = [(tag, names.get(tag) if isinstance(tag, str) else int(tag)) for tag in required]
    missing = [tag for tag, number in numbers if number is None or counts.get(number, 0) == 0]
    if missing:
        there = ", ".join(f"{label(tag, names)}: {n}" for tag, n in counts.items()) or "none"
        raise ValueError(
            f"{where}: {kind} tags {missing} are missing or empty; there are {there} (number of {kind}s after the "
            f"colon); add the physical group to the mesh, or ask for one of these"
        )
