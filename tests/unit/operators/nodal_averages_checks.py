# SPDX-License-Identifier: MIT
"""Averages at nodes against sums that FFCx's kernels assemble, on the ranks of COMM_WORLD; see on_ranks.py."""

import itertools

import basix.ufl
import numpy as np
import pytest
import ufl
from dolfinx import fem, la, mesh
from mpi4py import MPI
from operator_checks import CELLS, body

from dolfinx_impact import _cpp, compat
from dolfinx_impact.assembly.history_field import HistoryField

COMM = MPI.COMM_WORLD


def curved(cell):
    """A cell of degree 2 on this rank, with moved nodes in the middle of its edges."""
    element = basix.ufl.element("Lagrange", cell, 2, shape=(CELLS[cell],))
    x = basix.create_element(basix.ElementFamily.P, basix.CellType[cell], 2, basix.LagrangeVariant.gll_warped).points
    moved = x + 0.1 * np.sin(3.0 * x[:, ::-1])
    cells = np.arange(len(x), dtype=np.int64)[None]
    return mesh.create_mesh(MPI.COMM_SELF, cells, x=moved, e=ufl.Mesh(element))


def expected(field, domain):
    """Sums of the values times shape function and volume over those of one, by FFCx's kernels."""
    dx = ufl.dx(domain=domain, metadata={"quadrature_degree": field.degree})
    V, Q = (fem.functionspace(domain, ("Lagrange", 1, shape)) for shape in (field.shape, ()))
    sums = []
    for form in (ufl.inner(field.function(), ufl.TestFunction(V)) * dx, ufl.TestFunction(Q) * dx):
        b = fem.assemble_vector(fem.form(form))
        b.scatter_reverse(la.InsertMode.add)
        sums.append(b.array.reshape(-1, b.block_size)[: b.index_map.size_local])
    return sums[0] / sums[1]


def compare(domain, shape, degree):
    tdim = domain.topology.dim
    num_cells = domain.topology.index_map(tdim).size_local
    num_points = len(basix.make_quadrature(domain.basix_cell(), degree)[1])
    values = np.random.default_rng(COMM.rank).normal(size=(num_cells, num_points, *shape))
    field = HistoryField("a", shape, degree, domain, lambda: values.reshape(num_cells, num_points, -1))
    nodes = field.at_nodes()
    found = nodes.x.array.reshape(-1, nodes.function_space.dofmap.bs)
    theirs = expected(field, domain)
    # Both add up the same numbers of size one, a few per node, in different orders.
    np.testing.assert_allclose(found[: len(theirs)], theirs, atol=1e-13)
    ghosts = nodes.copy()
    ghosts.x.scatter_forward()
    np.testing.assert_array_equal(ghosts.x.array, nodes.x.array)
    field = HistoryField("b", shape, degree, domain, lambda: np.full((num_cells, num_points, values[0, 0].size), 3.0))
    np.testing.assert_allclose(field.at_nodes().x.array, 3.0, rtol=1e-14)  # the mean of equal values


def check_cells_with_straight_edges():
    for cell, shape, degree in itertools.product(CELLS, ((), (4,)), (1, 2, 3)):
        compare(body(cell), shape, degree)


def check_curved_cells():
    for cell in CELLS:
        compare(curved(cell), (2,), 4)


def check_surfaces_in_space():
    """Cells of another dimension than their nodes."""
    domain = body("triangle")
    x = np.column_stack([domain.geometry.x[:, :2], domain.geometry.x[:, 0] ** 2])
    element = basix.ufl.element("Lagrange", "triangle", 1, shape=(3,))
    cells = compat.geometry_dofmap(domain)[: domain.topology.index_map(2).size_local].astype(np.int64)
    used, renumbered = np.unique(cells, return_inverse=True)
    surface = mesh.create_mesh(MPI.COMM_SELF, renumbered.reshape(cells.shape), x=x[used], e=ufl.Mesh(element))
    compare(surface, (), 2)


def check_wrong_sizes():
    domain = body("quadrilateral", comm=MPI.COMM_SELF)
    V = fem.functionspace(domain, ("Lagrange", 1))._cpp_object
    points, weights = basix.make_quadrature(basix.CellType.quadrilateral, 2)
    right = np.ones(domain.topology.index_map(2).size_local * len(weights))
    for arguments in (
        (points.ravel(), weights, right[1:]),
        (points.ravel()[1:], weights, right),
        (points.ravel(), weights[1:], right),
        (np.empty(0), np.empty(0), np.empty(0)),
    ):
        with pytest.raises(ValueError, match="averages at nodes"):
            _cpp.operators.nodal_averages(V, *arguments)


def check_a_wrong_size_on_one_rank():
    """All ranks say so: the others must not wait for it."""
    domain = body("quadrilateral")
    V = fem.functionspace(domain, ("Lagrange", 1))._cpp_object
    points, weights = basix.make_quadrature(basix.CellType.quadrilateral, 2)
    values = np.ones(domain.topology.index_map(2).size_local * len(weights) + (COMM.rank == COMM.size - 1))
    with pytest.raises(ValueError, match="averages at nodes"):
        _cpp.operators.nodal_averages(V, points.ravel(), weights, values)
