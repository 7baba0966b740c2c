# SPDX-License-Identifier: MIT
"""Stiffness that the surface of a body offers to penalty springs; docs/explicit/penalty.md, "Stiffness"."""

import numpy as np
from dolfinx.fem import FunctionSpace

from ... import _cpp
from ...assembly import operators
from ...common.cell_numbers import input_cell_numbers
from ...common.types import FloatArray, IntArray
from ..nodal_sum import NodalSum
from ..protocol import ExplicitContactProblem

# Part of the stiffness of the outermost cells in uniaxial strain. A surface node has half of the mass of a layer; with
# half of its stiffness it moves no faster than the mesh, and the force of an impact rings least.
LAYER = 0.5
# Part of what the cells around a node count in the bound of the highest squared frequency (Irons and Treharne): what
# steps of 0.9 of the stable one leave to contact, 1/0.9^2 - 1.
ROOM = 0.19 / 0.81


def nodal_compliances(
    problem: ExplicitContactProblem, slave: _cpp.surface.Facets, master: _cpp.surface.Facets | None
) -> tuple[FloatArray, FloatArray]:
    """Reciprocals of the stiffness of the nodes of both surfaces. Collective.

    Args:
        problem: explicit problem; its bodies count as undeformed.
        slave: this rank's slave facets.
        master: this rank's master facets; None: the master is rigid.

    Returns:
        Compliances of slave and master, each by node that this rank owns; zero at other nodes, and where the bodies
        have no stiffness that is known [L/F].
    """
    total = NodalSum(problem.space.dofmap.index_map, 1)
    owned: int = total.index_map.size_local
    sides = [side for side in (slave, master) if side is not None]
    surface = np.zeros(total.num_nodes)
    for side in sides:
        surface[side.nodes.ravel()] = 1.0
    most = ROOM * problem.frequency_stiffness(total(surface).ravel() > 0.0)
    moduli = _cell_moduli(problem)
    out = [np.zeros(owned), np.zeros(owned)]
    for values, side in zip(out, sides):
        factors = np.ones(side.size) if moduli is None else LAYER * _layer_stiffness(problem.space, side, moduli)
        sums = _cpp.surface.nodal_sums(side, problem.axisymmetric, np.ascontiguousarray(factors), total.num_nodes)
        layer = total(sums).ravel()
        stiffness = np.where(layer > 0.0, most if moduli is None else np.minimum(layer, most), 0.0)[:owned]
        known = stiffness > 0.0
        values[known] = 1.0 / stiffness[known]
    return out[0], out[1]


def _cell_moduli(problem: ExplicitContactProblem) -> FloatArray | None:
    """P-wave modulus of each owned cell, (num_cells) [F/L^2]; None for a residual of one's own."""
    material = problem.material
    if material is None:
        return None
    mesh = problem.space.mesh
    moduli = np.zeros(mesh.topology.index_map(mesh.topology.dim).size_local)
    for tag, m in material.parts():
        cells = operators.entities_of(mesh, "cell", -1 if tag is None else tag, material.cell_tags)
        moduli[cells] = m.p_wave_modulus
    return moduli


def _layer_stiffness(V: FunctionSpace, facets: _cpp.surface.Facets, moduli: FloatArray) -> FloatArray:
    """Stiffness per area of the layer of nodes behind each facet: P-wave modulus over height [F/L^3].

    Args:
        V: displacement space.
        facets: facets of owned cells.
        moduli: P-wave moduli of the owned cells [F/L^2].
    """
    mesh, gdim = V.mesh, V.mesh.geometry.dim
    cells = _cells(V, facets)
    shape = facets.geometry.shape
    corners = {"interval": 2, "triangle": 3, "quadrilateral": 4}[shape]
    simplex = mesh.topology.cell_name() in ("triangle", "tetrahedron")
    num_vertices = gdim + 1 if simplex else 2**gdim
    X = facets.X[:, :corners]
    if shape == "interval":
        along = X[:, 1] - X[:, 0]
        normal = np.column_stack([along[:, 1], -along[:, 0]])
    elif shape == "triangle":
        normal = np.cross(X[:, 1] - X[:, 0], X[:, 2] - X[:, 0])
    else:  # of the diagonals; corners are those of a tensor product
        normal = np.cross(X[:, 3] - X[:, 0], X[:, 2] - X[:, 1])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    middle = mesh.geometry.x[mesh.geometry.dofmap[cells, :num_vertices], :gdim].mean(axis=1)
    to_centre = np.abs(np.einsum("fc,fc->f", normal, middle - X.mean(axis=1)))
    height = (num_vertices if simplex else 2) * to_centre
    stiffness: FloatArray = moduli[cells] * V.element.basix_element.degree / height
    return stiffness


def _cells(V: FunctionSpace, facets: _cpp.surface.Facets) -> IntArray:
    """Cell of each facet, by its number on this rank."""
    numbers = input_cell_numbers(V.mesh.topology)
    order = np.argsort(numbers)
    cells: IntArray = order[np.searchsorted(numbers[order], facets.id // 8)]
    return cells
