# SPDX-License-Identifier: MIT
"""Explicit runs of a plate whose bending is a residual of one's own, by C0 interior penalty."""

import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di


def relative_error_of_frequency(cell, n, penalty=8.0):
    """Of the first mode of a simply supported unit square of unit bending stiffness and mass, 2 pi^2; from the time at
    which its amplitude has been zero twice."""
    domain = mesh.create_unit_square(MPI.COMM_SELF, n, n, cell)
    V = fem.functionspace(domain, ("Lagrange", 2))
    w, v = fem.Function(V, name="w"), ufl.TestFunction(V)
    w.interpolate(lambda x: np.sin(np.pi * x[0]) * np.sin(np.pi * x[1]))
    normal, h = ufl.FacetNormal(domain), ufl.CellDiameter(domain)

    def moment(f):
        return ufl.div(ufl.grad(f))

    def kink(f):
        return ufl.jump(ufl.grad(f), normal)

    residual = ufl.inner(moment(w), moment(v)) * ufl.dx(degree=4)
    residual -= (ufl.avg(moment(w)) * kink(v) + ufl.avg(moment(v)) * kink(w)) * ufl.dS(degree=4)
    residual += penalty / ufl.avg(h) * kink(w) * kink(v) * ufl.dS(degree=4)
    domain.topology.create_connectivity(1, 2)
    edge = fem.locate_dofs_topological(V, 1, mesh.exterior_facet_indices(domain.topology))
    problem = di.ExplicitProblem(w, residual=residual, density=1.0, bcs=[fem.dirichletbc(0.0, edge, V)])
    mode, rows = problem.mass.array * w.x.array, []
    until = 0.85 / np.pi  # of a period of 1 / pi
    problem.advance(until, callback=lambda p: rows.append((p.time, mode @ w.x.array)), progress=False)
    times, amplitudes = np.array(rows).T
    last = np.flatnonzero((amplitudes[1:] > 0) & (amplitudes[:-1] <= 0))[0]
    zero = np.interp(0.0, amplitudes[last : last + 2], times[last : last + 2])
    return 0.75 / np.pi / zero - 1


@pytest.mark.long_rows(where=lambda cell: cell != mesh.CellType.triangle)
@pytest.mark.parametrize("cell", [mesh.CellType.triangle, mesh.CellType.quadrilateral])
def test_frequency_of_a_plate_converges_with_the_second_order(cell):
    """The error of a mode of the fourth order by elements of degree 2 is of order h^2; a cell's size is halved."""
    coarse, fine = (relative_error_of_frequency(cell, n) for n in (8, 16))
    assert abs(fine) < 1e-2 and 3.5 < coarse / fine < 4.5, (coarse, fine)
