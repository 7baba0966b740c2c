# SPDX-License-Identifier: MIT
"""Fields without partition: cells for VTK, and errors that all ranks raise."""

import numpy as np
import pytest
from dolfinx import fem, mesh
from mpi4py import MPI

from dolfinx_impact.io.gather import Gathered, gather_field, gather_mesh, together


@pytest.mark.parametrize(
    "kind, degree, number", [("triangle", 1, 5), ("quadrilateral", 1, 9), ("tetrahedron", 1, 10), ("hexahedron", 2, 72)]
)
def test_cells_for_vtk(kind, degree, number):
    """Nodes in VTK's order go round each face: the area or volume by VTK's corners is that of the cell."""
    cell = getattr(mesh.CellType, kind)
    make = mesh.create_unit_square if kind in ("triangle", "quadrilateral") else mesh.create_unit_cube
    domain = make(MPI.COMM_SELF, *[1] * (2 if make is mesh.create_unit_square else 3), cell)
    V = fem.functionspace(domain, ("Lagrange", degree))
    f = fem.Function(V)
    f.interpolate(lambda x: x[0])
    found = gather_field(f)
    assert isinstance(found, Gathered) and np.array_equal(found.values[:, 0], found.points[:, 0])
    cells, kind_of_vtk = found.vtk()
    assert kind_of_vtk == number and np.array_equal(np.sort(cells), np.sort(found.cells))
    p = found.points[cells]
    if domain.topology.dim == 2:
        n = 3 if kind == "triangle" else 4
        x, y = p[:, :n, 0], p[:, :n, 1]
        area = np.abs(np.sum(x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1), axis=1)) / 2
        assert area.sum() == pytest.approx(1.0, rel=1e-14)
    elif kind == "hexahedron":
        # Edges 0-1, 0-3 and 0-4 span the cube, and 6 is opposite to 0.
        edges = p[0, [1, 3, 4]] - p[0, 0]
        assert abs(np.linalg.det(edges)) == pytest.approx(1.0) and p[0, 6] == pytest.approx(p[0, 0] + edges.sum(axis=0))
    assert gather_mesh(domain).cells.shape[0] == len(found.cells) and gather_mesh(domain).values is None


def test_errors_of_rank_0_are_those_of_all():
    assert together(MPI.COMM_SELF, lambda: 3) == 3
    with pytest.raises(ValueError, match="five"):
        together(MPI.COMM_SELF, lambda: [int("five")])
    with pytest.raises(RuntimeError, match="KeyError: 'x'"):
        together(MPI.COMM_SELF, lambda: {}["x"])
