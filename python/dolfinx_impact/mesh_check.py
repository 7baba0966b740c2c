"""Checking a mesh: folded and flat cells, missing tags. Collective, with the same error on every rank."""

from collections import Counter
from dataclasses import dataclass

from mpi4py import MPI

import basix
import numpy as np

SHOWN = 5  # cells or nodes named in an error


@dataclass
class MeshReport:
    """What `check_mesh` found: `num_negative` cells have det J < 0 throughout (a numbering, not a fault)."""

    num_cells: int
    num_negative: int
    smallest_det: float  # min over cells of |det J| / (largest extent of the cell)^tdim [1]
    cell_counts: dict  # tag -> number of cells
    facet_counts: dict  # tag -> number of facets


def check_mesh(
    mesh, cell_tags=None, facet_tags=None, required_cell_tags=(), required_facet_tags=(), *,
    cell_names=None, facet_names=None, where="mesh", numbers=None,
):  # fmt: skip
    """Check cells and tags; raise ValueError on every rank if anything is wrong, else return a MeshReport. Collective.

    The sign of det J may differ from cell to cell (DOLFINx renumbers simplices) but not inside one, and det J may not
    vanish. `where` begins the error messages; `numbers` (rank 0 only) are the cells' numbers in the file.
    """
    comm, cell_names, facet_names = mesh.comm, cell_names or {}, facet_names or {}
    lowest, highest, extent, centroid = _jacobians(mesh)
    size = extent**mesh.topology.dim
    flat = np.minimum(np.abs(lowest), np.abs(highest)) <= 1e-12 * size
    bad = np.flatnonzero(flat | (lowest * highest <= 0) | ~np.isfinite(size))
    tag_of = dict(zip(cell_tags.indices, cell_tags.values)) if cell_tags is not None else {}
    cell_map = mesh.topology.index_map(mesh.topology.dim)
    mine = [
        (
            int(cell_map.local_range[0] + c), int(mesh.topology.original_cell_index[c]), centroid[c],
            label(tag_of.get(c), cell_names), "zero volume" if flat[c] else "folded or inverted",
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
            problem = f"{where}: {total_bad} cells of {cell_map.size_global} have det J zero or of both signs:\n"
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


def _jacobians(mesh):
    """Per owned cell: smallest and largest det J over test points, extent, centroid."""
    tdim, gdim, cmap = mesh.topology.dim, mesh.geometry.dim, mesh.geometry.cmap
    cell = getattr(basix.CellType, mesh.topology.cell_name())
    element = basix.create_element(basix.ElementFamily.P, cell, cmap.degree, basix.LagrangeVariant(cmap.variant))
    points = basix.geometry(cell)
    if cmap.degree > 1:
        points = np.vstack([points, element.points, basix.make_quadrature(cell, 2 * cmap.degree)[0]])
    shape = element.tabulate(1, points)[1:, :, :, 0]  # (tdim, points, nodes)
    cells = mesh.geometry.dofmap[: mesh.topology.index_map(tdim).size_local]
    x = mesh.geometry.x[cells][:, :, :gdim]
    jacobian = np.einsum("dqn,cng->cqgd", shape, x)
    if gdim == tdim:
        det = np.linalg.det(jacobian)
    else:  # a surface in space: signed by the mean normal
        normal = np.cross(jacobian[..., 0], jacobian[..., 1])
        mean = normal.mean(axis=1)
        length = np.linalg.norm(mean, axis=1)
        det = np.einsum("cqg,cg->cq", normal, mean / np.where(length > 0, length, 1)[:, None])
    extent = np.ptp(x, axis=1).max(axis=1, initial=0)
    return det.min(axis=1, initial=np.inf), det.max(axis=1, initial=-np.inf), extent, x.mean(axis=1)


def _counts(mesh, tags):
    """Tag -> number of entities over all ranks, each counted once."""
    if tags is None:
        return {}
    mesh.topology.create_entities(tags.dim)
    owned = tags.values[tags.indices < mesh.topology.index_map(tags.dim).size_local]
    total = Counter()
    for part in mesh.comm.allgather(Counter(owned.tolist())):
        total.update(part)
    return dict(sorted(total.items()))


def label(tag, names):
    name = next((name for name, number in names.items() if number == tag), None)
    return f"{tag}" if name is None else f'{tag} ("{name}")'


def _require(where, kind, required, counts, names):
    """Raise ValueError when a required tag, given by number or name, has no entity."""
    missing = [tag for tag in required if counts.get(names.get(tag) if isinstance(tag, str) else int(tag), 0) == 0]
    if missing:
        there = ", ".join(f"{label(tag, names)}: {n}" for tag, n in counts.items()) or "none"
        raise ValueError(
            f"{where}: {kind} tags {missing} are missing or empty; there are {there} (number of {kind}s after the "
            f"colon); add the physical group to the mesh, or ask for one of these"
        )
