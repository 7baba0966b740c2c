# SPDX-License-Identifier: MIT
"""What DOLFINx, UFL and Basix spell differently from release to release, under one name each.

No other file of Python asks which release is installed, or uses what only some releases have: tests/architecture holds
that. Its counterpart in C++ is common/dolfinx_api.h.
"""

import importlib.util
import re
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NamedTuple

if importlib.util.find_spec("dolfinx_solver") is not None:
    # The wheel with DOLFINx inside loads MPI before every compiled module, and puts its own PETSc in Python's way.
    import dolfinx_solver  # noqa: F401

import dolfinx

# Releases of DOLFINx that this package was run on, and how far; every other one is refused.
TRIED = {"0.9": "the whole suite", "0.11": "the whole suite"}


def installed() -> str:
    """Version of DOLFINx that is installed, as it gives it."""
    return str(getattr(dolfinx, "__version__"))


def library_folder() -> Path | None:
    """Folder of the MPI library that DOLFINx's wheel finds only after `import dolfinx_solver`; None without that wheel.

    A process that has it in LD_LIBRARY_PATH may import DOLFINx first, as scripts do that are written for all releases.
    """
    found = importlib.util.find_spec("dolfinx_solver")
    return Path(found.origin).resolve().parents[3] if found is not None and found.origin else None


def versions() -> dict[str, str]:
    """Versions of DOLFINx and of the libraries that come with it, by name; "unknown" where one does not say."""
    import importlib.metadata

    import basix
    import ffcx

    def of(name: str, module: Any) -> str:
        try:
            return importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            return str(getattr(module, "__version__", "unknown"))

    libraries = {"ffcx": ffcx, "basix": basix, "ufl": ufl}
    return {"dolfinx": installed()} | {name: of(f"fenics-{name}", module) for name, module in libraries.items()}


def tried() -> str:
    """Releases of DOLFINx that this package was tried on, in words."""
    return " and ".join(f"{release} ({how_far})" for release, how_far in TRIED.items())


def release_of(version: str) -> tuple[int, int]:
    """Release of a version, by which it can be compared.

    Args:
        version: version as DOLFINx gives it, such as "0.11.0.post0".

    Returns:
        The first two numbers of the version.

    Raises:
        ImportError: it is a version of a release that was not tried.
    """
    found = _numbers(version)
    if found not in map(_numbers, TRIED):
        raise ImportError(
            f"DOLFINx {version} is installed, and this package was tried on DOLFINx {tried()}: install one of these"
        )
    return found


def _numbers(version: str) -> tuple[int, int]:
    """First two numbers of a version; (0, 0) if it does not begin with two."""
    match = re.match(r"(\d+)\.(\d+)", version)
    return (int(match[1]), int(match[2])) if match else (0, 0)


RELEASE = release_of(installed())

import numpy as np  # noqa: E402
import ufl  # noqa: E402
from dolfinx import common, cpp, fem, graph, io, la, mesh  # noqa: E402
from mpi4py import MPI  # noqa: E402

from .common.types import FloatArray, IntArray  # noqa: E402


class GmshMesh(NamedTuple):
    """A mesh made from a gmsh model.

    Attributes:
        mesh: mesh of the cells that are in physical groups.
        cell_tags: tags of the cells: the numbers of their physical groups.
        facet_tags: tags of the facets, empty if no physical group has facets.
    """

    mesh: mesh.Mesh
    cell_tags: mesh.MeshTags
    facet_tags: mesh.MeshTags


def coordinate_element(domain: Any) -> Any:
    """Element of the map from the reference cell to a cell.

    Args:
        domain: mesh, of Python or C++.

    Returns:
        Coordinate element of DOLFINx; `degree` is the degree of the geometry.
    """
    return domain.geometry.cmaps[0] if RELEASE >= (0, 11) else domain.geometry.cmap


def geometry_dofmap(domain: Any) -> IntArray:
    """Nodes of the geometry of each cell. Some releases copy it at each call: call it before a loop.

    Args:
        domain: mesh, of Python or C++.

    Returns:
        Rows of `geometry.x` of the owned and ghost cells, (num_cells, nodes per cell).
    """
    dofmap: IntArray = domain.geometry.dofmaps[0] if RELEASE >= (0, 11) else domain.geometry.dofmap
    return dofmap


def cell_name(domain: ufl.Mesh) -> str:
    """Name of the cells of a UFL domain, such as "triangle"."""
    return str(domain.ufl_cell())


def geometric_dimension(domain: ufl.Mesh) -> int:
    """Number of coordinates of a point of a UFL domain [1]."""
    return _number(domain.geometric_dimension)


def topological_dimension(domain: ufl.Mesh) -> int:
    """Dimension of the cells of a UFL domain [1]."""
    return _number(domain.topological_dimension)


def _number(found: Any) -> int:
    """Value of what is a property in one release of UFL and a method in another."""
    return int(found() if callable(found) else found)


def interpolation_points(space: fem.FunctionSpace) -> FloatArray:
    """Points of the reference cell at which an expression is evaluated to interpolate it.

    Args:
        space: space that it is interpolated to.

    Returns:
        Points, (n, dimension of the cells) [1].
    """
    points: Any = space.element.interpolation_points
    return np.asarray(points() if callable(points) else points)


def collapse(space: fem.FunctionSpace) -> tuple[fem.FunctionSpace, IntArray]:
    """A subspace as a space of its own.

    Args:
        space: subspace of a space with several components.

    Returns:
        The space, and the degree of freedom in the whole space of each of its degrees of freedom, ghosts included.
    """
    collapsed, dofs = space.collapse()
    return collapsed, np.asarray(dofs[0] if RELEASE >= (0, 11) else dofs, dtype=np.int32)


def create_vector(space: fem.FunctionSpace) -> Any:
    """PETSc vector of the degrees of freedom of a space, with places for ghosts. Collective.

    Args:
        space: function space.

    Returns:
        Vector of zeros; its user destroys it.
    """
    if RELEASE >= (0, 10):
        from dolfinx.fem import petsc

        return petsc.create_vector(space)
    return la.create_petsc_vector(space.dofmap.index_map, space.dofmap.index_map_bs)


def create_index_map(comm: MPI.Intracomm, size: int, ghosts: IntArray, owners: IntArray) -> common.IndexMap:
    """Numbers of a distributed array, with ghosts. Collective.

    Args:
        comm: communicator.
        size: how many numbers this rank owns [1].
        ghosts: global numbers that it has of other ranks, (n).
        owners: ranks that own the ghosts, (n).

    Returns:
        Index map of DOLFINx.
    """
    more = (0,) if RELEASE >= (0, 10) else ()  # the tag of its messages
    return common.IndexMap(comm, size, np.asarray(ghosts, np.int64), np.asarray(owners, np.int32), *more)


def create_cell_partitioner(mode: mesh.GhostMode) -> Any:
    """Function that distributes the cells of a mesh over ranks, for `dolfinx.mesh.create_mesh`.

    Args:
        mode: which ghost cells a rank has.

    Returns:
        DOLFINx's default partitioner with these ghosts, for meshes with two cells at a facet at most.
    """
    return mesh.create_cell_partitioner(mode, *((2,) if RELEASE >= (0, 11) else ()))


def adjacencylist(links: IntArray, offsets: IntArray | None = None) -> Any:
    """Adjacency list as a partitioner of cells returns it.

    Args:
        links: ranks that get the cells, (num_cells, ranks per cell), or all behind each other.
        offsets: where the ranks of a cell begin if they are behind each other, (num_cells + 1).

    Returns:
        Adjacency list of DOLFINx (C++).
    """
    found = graph.adjacencylist(links, offsets)
    return found._cpp_object if RELEASE >= (0, 10) else found


def facet_entities(topology: Any, facets: IntArray) -> IntArray:
    """Facets of the boundary as integrals over them take them.

    Args:
        topology: topology of the mesh (C++), with the connectivities from cells to facets and back.
        facets: facets at one cell each, (n).

    Returns:
        Cell of each facet and number of the facet in the cell, (2 n), one after the other.
    """
    more = () if RELEASE >= (0, 10) else (topology.dim - 1,)
    entities: IntArray = cpp.fem.compute_integration_domains(
        fem.IntegralType.exterior_facet, topology, np.asarray(facets, dtype=np.int32), *more
    )
    return entities


def linear_problem(
    a: ufl.Form, right: ufl.Form, bcs: list[fem.DirichletBC], petsc_options: dict[str, Any], prefix: str
) -> Any:
    """Linear problem of DOLFINx, a(u, v) = L(v). Collective.

    Args:
        a: bilinear form.
        right: linear form L.
        bcs: boundary conditions.
        petsc_options: options of the linear solver by name.
        prefix: of the names of these options in PETSc's database; some releases take one of their own.

    Returns:
        Object whose `solve()` returns the solution.
    """
    from dolfinx.fem import petsc

    more = {"petsc_options_prefix": prefix} if RELEASE >= (0, 10) else {}
    return petsc.LinearProblem(a, right, bcs=bcs, petsc_options=petsc_options, **more)


def ffcx_source(ufl_object: Any, options: dict[str, Any], names: dict[int, str], prefix: str) -> str:
    """C source of FFCx's kernels of a form or an expression.

    Args:
        ufl_object: UFL form, or a pair of an expression and its points.
        options: FFCx's options by name.
        names: name of the form or expression in the source, by id.
        prefix: of names in the source.

    Returns:
        The source, without the header.
    """
    from ffcx.compiler import compile_ufl_objects

    code = compile_ufl_objects([ufl_object], options, names, prefix)
    return str(code[0][-1] if RELEASE >= (0, 11) else code[1])


def gmsh_nodes(model: Any) -> FloatArray:
    """Places of the nodes of a gmsh model as the cells have them that `model_to_mesh` hands to a partitioner.

    Args:
        model: gmsh.model, with a physical group of cells.

    Returns:
        Places of the nodes of cells that are in groups, (n, 3) [L].
    """
    module = io.gmsh if RELEASE >= (0, 10) else io.gmshio
    nodes: FloatArray = module.extract_geometry(_cells_and_facets(model))
    return nodes


def model_to_mesh(model: Any, comm: MPI.Intracomm, rank: int = 0, gdim: int = 3, partitioner: Any = None) -> GmshMesh:
    """Mesh and tags of a gmsh model, alike for all releases of DOLFINx. Collective.

    Cells and facets get the numbers of their physical groups. Cells in no physical group are left out, and so are
    groups of smaller dimension: edges of bodies in three dimensions, and points.

    Args:
        model: gmsh.model, meshed on one rank; None or anything on the others.
        comm: communicator of the mesh.
        rank: the rank that has the model.
        gdim: number of coordinates of a point [1].
        partitioner: function that distributes the cells over ranks, as in dolfinx.mesh.create_mesh.

    Returns:
        Mesh, tags of its cells, tags of its facets.

    Raises:
        RuntimeError: no physical group holds cells; on all ranks.
        ValueError: its cells are of several kinds, as triangles and quadrilaterals; on all ranks.
    """
    kinds = comm.bcast(_kinds_of_cells(model) if comm.rank == rank else None, rank)
    if not kinds:
        raise RuntimeError("the gmsh model has no physical group that holds cells: add one, and mesh the model")
    if len(kinds) > 1:
        raise ValueError(
            f"the physical groups of the gmsh model hold cells of {len(kinds)} kinds ({', '.join(kinds)}), and a mesh "
            "has cells of one kind: recombine all surfaces or none"
        )
    seen = _cells_and_facets(model) if comm.rank == rank else None
    if RELEASE < (0, 10):
        return GmshMesh(*io.gmshio.model_to_mesh(seen, comm, rank, gdim=gdim, partitioner=partitioner))
    data = io.gmsh.model_to_mesh(seen, comm, rank, gdim=gdim, partitioner=partitioner)
    facet_tags = data.facet_tags
    if facet_tags is None:
        none = np.zeros(0, dtype=np.int32)
        facet_tags = mesh.meshtags(data.mesh, data.mesh.topology.dim - 1, none, none)
    return GmshMesh(data.mesh, data.cell_tags, facet_tags)


def _with_cells(model: Any) -> tuple[int, list[int]]:
    """Dimension of the cells of a gmsh model with physical groups, and its entities that are in groups of cells."""
    groups = model.getPhysicalGroups()
    tdim = max(dim for dim, _ in groups)
    found = dict.fromkeys(e for d, tag in groups if d == tdim for e in model.getEntitiesForPhysicalGroup(d, tag))
    return tdim, list(found)


def _kinds_of_cells(model: Any) -> list[str]:
    """Names of the kinds of cells in physical groups of a gmsh model, as "Triangle 3"; empty if there are no groups."""
    if not model.getPhysicalGroups():
        return []
    tdim, entities = _with_cells(model)
    kinds = sorted({int(kind) for e in entities for kind in model.mesh.getElementTypes(tdim, e)})
    return [str(model.mesh.getElementProperties(kind)[0]) for kind in kinds]


def _cells_and_facets(model: Any) -> Any:
    """What DOLFINx shall see of a gmsh model: the cells that are in physical groups, their nodes, groups of facets.

    DOLFINx 0.10 and later also tag edges and points, and refuse a model with cells in no group, which DOLFINx 0.9
    leaves out. All of them abort at nodes that belong to no cell.

    Args:
        model: gmsh.model.

    Returns:
        The functions of the model that DOLFINx calls.
    """
    groups = model.getPhysicalGroups()
    tdim, entities = _with_cells(model)
    all_numbers, x, _ = model.mesh.getNodes()
    in_cells = np.concatenate([nodes for e in entities for nodes in model.mesh.getElements(tdim, e)[2]])
    used = np.isin(all_numbers, in_cells)
    order = np.argsort(all_numbers[used])
    numbers, places = all_numbers[used][order], x.reshape(-1, 3)[used][order]

    def elements(dim: int = -1, tag: int = -1) -> tuple[list[int], list[IntArray], list[IntArray]]:
        """Types, numbers and nodes of the elements of an entity, or of all cells in groups, whose nodes are used."""
        found: dict[int, tuple[list[IntArray], list[IntArray]]] = {}
        for entity in (tag,) if tag != -1 else entities:
            for kind, of_elements, nodes in zip(*model.mesh.getElements(dim, entity)):
                rows = nodes.reshape(len(of_elements), -1)
                kept = np.isin(rows, numbers).all(axis=1)
                of_kind = found.setdefault(kind, ([], []))
                of_kind[0].append(of_elements[kept])
                of_kind[1].append(np.searchsorted(numbers, rows[kept]).astype(np.uint64).reshape(-1) + np.uint64(1))
        parts = [(kind, *map(np.concatenate, both)) for kind, both in found.items()]
        return [part[0] for part in parts], [part[1] for part in parts], [part[2] for part in parts]

    return SimpleNamespace(
        getPhysicalGroups=lambda: [(dim, tag) for dim, tag in groups if dim >= tdim - 1],
        getEntitiesForPhysicalGroup=model.getEntitiesForPhysicalGroup,
        getPhysicalName=model.getPhysicalName,
        mesh=SimpleNamespace(
            getNodes=lambda: (np.arange(1, len(numbers) + 1, dtype=np.uint64), places.reshape(-1), np.zeros(0)),
            getElements=elements,
            getElementProperties=model.mesh.getElementProperties,
        ),
    )
