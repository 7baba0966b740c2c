# SPDX-License-Identifier: MIT
"""Force and moment across sections of bodies, from nodal internal forces."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, Protocol

import numpy as np
import ufl
from dolfinx import fem
from dolfinx.fem import Function, FunctionSpace
from dolfinx.la import InsertMode
from dolfinx.mesh import MeshTags, meshtags
from mpi4py import MPI

from ..common import arguments
from ..common.collective import guard
from ..common.types import ArrayLike, FloatArray, IntArray
from ..materials import Material, MaterialMap, _Material
from .cauchy_stress import CauchyStress
from .operators import InternalForce, internal_force_form
from .resultant import Resultant, checked_point, checked_tag, resultant


class ProblemWithSections(Protocol):
    """What is read of a problem.

    Attributes:
        u: displacement [L].
        material: material of the bodies; None with a residual of the user's own.
    """

    u: Function
    material: Material | None

    @property
    def has_history(self) -> bool: ...

    @property
    def history(self) -> Any: ...


def section_force(
    problem: ProblemWithSections,
    cells: tuple[MeshTags, int],
    facets: tuple[MeshTags, int] | None = None,
    point: ArrayLike | None = None,
) -> Resultant:
    """Force and moment across a section, on the cells on one of its sides, at the present displacement. Collective.

    They are the sums of the internal forces of the tagged cells at the nodes of the section (Cook et al., Concepts and
    Applications of Finite Element Analysis, section 2.9, forces of elements on nodes): with the other forces on these
    cells, loads, supports, contact and inertia at their other nodes, they are in equilibrium to round-off, which
    integrals of the stress are not.

    Args:
        problem: static, explicit, implicit or rolling problem of a material.
        cells: tags of cells and the tag of those on one side of the section.
        facets: tags of facets and the tag of the section; None: all nodes that these cells share with others.
        point: point that the moment is about, (gdim); None: the origin [L].

    Returns:
        Resultant of what the cells on the other side do to the tagged ones. Tension across a section pulls the tagged
        cells towards the others.

    Raises:
        TypeError: an argument is of the wrong type; on all ranks.
        ValueError: no cell has the tag, or no node lies on the section; the residual is the user's own; on all ranks.
    """
    V = problem.u.function_space
    mesh = V.mesh
    tdim = mesh.topology.dim
    with guard(mesh.comm, "section_force") as ranks:
        if problem.material is None:
            raise ValueError(
                "section_force needs a problem of a material: with a residual of your own assemble its part"
            )
        for name, given, dim in (("cells", cells, tdim), ("facets", facets, tdim - 1)):
            if given is None and name == "facets":
                continue
            if not (isinstance(given, tuple) and len(given) == 2 and hasattr(given[0], "find")):
                raise TypeError(f"{name} must be a pair of MeshTags and a tag, found {given!r:.60}")
            arguments.tags(name, given[0], mesh, dim)
            checked_tag(given[1])
        about = checked_point(point, mesh.geometry.dim)
        ranks.same(cells=int(cells[1]), facets=None if facets is None else int(facets[1]), point=about.tolist())
    chosen = np.asarray(cells[0].find(int(cells[1])), dtype=np.int32)
    nodes = _nodes_of_section(V, chosen, facets)
    counts = [mesh.comm.allreduce(len(found), MPI.SUM) for found in (chosen, nodes)]
    if counts[0] == 0:
        raise ValueError(f"section_force: no cell has the tag {cells[1]}")
    if counts[1] == 0:
        raise ValueError(
            f"section_force: the cells with the tag {cells[1]} have no node on the section: "
            + ("they share none with other cells" if facets is None else f"that of the facets with tag {facets[1]}")
        )
    bs = V.dofmap.index_map_bs
    forces = _internal_force(problem, chosen)
    dofs = (bs * nodes[:, None] + np.arange(bs)).ravel()
    return resultant(problem.u, problem.material, forces, dofs, about)


class _SomeCells(MaterialMap):
    """Materials of some cells of a mesh; the others have none.

    Args:
        cell_tags: tags of the cells.
        materials: material by tag, one for each tag and perhaps others.
    """

    def __init__(self, cell_tags: MeshTags, materials: Mapping[int, _Material]) -> None:
        found = {int(t) for here in cell_tags.topology.comm.allgather(np.unique(cell_tags.values)) for t in here}
        self.cell_tags = cell_tags
        self.materials = MappingProxyType({tag: law for tag, law in materials.items() if tag in found})


def _nodes_of_section(V: FunctionSpace, cells: IntArray, facets: tuple[MeshTags, int] | None) -> IntArray:
    """Owned nodes of cells that other cells have, too, or that lie on facets. Collective."""
    index_map, cell_map = V.dofmap.index_map, V.mesh.topology.index_map(V.mesh.topology.dim)
    inside = np.zeros(cell_map.size_local + cell_map.num_ghosts, dtype=bool)
    inside[cells] = True
    own = inside[: cell_map.size_local]
    marks = []
    for side in (own, ~own):  # each cell counts on the rank that owns it
        function = fem.Function(fem.functionspace(V.mesh, ("Lagrange", V.element.basix_element.degree)))
        values = function.x.array
        values[np.unique(V.dofmap.list[: cell_map.size_local][side])] = 1.0
        function.x.scatter_reverse(InsertMode.add)
        marks.append(values[: index_map.size_local] > 0.0)
    touched, shared = marks[0], marks[0] & marks[1]
    if facets is None:
        return np.flatnonzero(shared).astype(np.int32)
    on = fem.locate_dofs_topological(V, facets[0].dim, facets[0].find(int(facets[1])))
    on = on[on < index_map.size_local]
    found: IntArray = on[touched[on]].astype(np.int32)
    return found


def _internal_force(problem: ProblemWithSections, cells: IntArray) -> FloatArray:
    """Nodal internal forces of some cells, owned entries complete [F]. Collective."""
    u, material = problem.u, problem.material
    assert material is not None  # refused before
    mesh, dim = u.function_space.mesh, u.function_space.mesh.topology.dim
    tags = material.cell_tags
    if tags is None:
        values = np.ones(len(cells), dtype=np.int32)
    else:
        place = np.searchsorted(tags.indices, cells)
        values = tags.values[place].astype(np.int32)
    order = np.argsort(cells)
    part = meshtags(mesh, dim, cells[order].astype(np.int32), values[order])
    some = _SomeCells(part, {1 if tag is None else tag: law for tag, law in material.parts()})
    if problem.has_history:
        return CauchyStress(u, some, problem.history.points).forces()
    force = InternalForce(internal_force_form(u, ufl.TestFunction(u.function_space), some))
    return force.apply().array
