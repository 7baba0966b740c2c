# SPDX-License-Identifier: MIT
"""Order of convergence of tied boxes in space, against that of one mesh; docs/tie.md."""

import numpy as np
import pytest
import ufl
from box_bodies import Boxes
from dolfinx import fem, mesh
from mpi4py import MPI
from tied_boxes import boxes, outside, tie

import dolfinx_impact as di
from dolfinx_impact import compat

pytestmark = pytest.mark.slow


def strain(u):
    return ufl.sym(ufl.grad(u))


def energy_error(m, facets, contact):
    """Norm of the strain that is wrong, of a smooth displacement that is prescribed on facets."""
    x, y, z = ufl.SpatialCoordinate(m.mesh)
    first = ufl.sin(2 * x) * ufl.cos(1.5 * z) * ufl.cos(y)
    exact = 0.01 * ufl.as_vector([first, ufl.cos(x) * ufl.sin(2 * y + z), ufl.cos(x + y) * ufl.sin(2 * z)])
    v, dx = ufl.TestFunction(m.V), ufl.dx(metadata={"quadrature_degree": 2 * m.degree + 4})
    residual = ufl.inner(strain(m.u), strain(v)) * dx + ufl.inner(ufl.div(strain(exact)), v) * dx
    boundary = fem.Function(m.V)
    boundary.interpolate(fem.Expression(exact, compat.interpolation_points(m.V)))
    dofs = fem.locate_dofs_topological(m.V, 2, facets)
    problem = di.StaticProblem(
        m.u, residual=residual, hypothesis="3d", bcs=[fem.dirichletbc(boundary, dofs)], contact=contact
    )
    problem.solve(progress=False)
    off = strain(m.u - exact)
    return float(np.sqrt(m.sum(fem.assemble_scalar(fem.form(ufl.inner(off, off) * dx)))))


def tied(cell, degree, n, basis):
    m = boxes(cell, slave=3 * n, master=2 * n, degree=degree, layers=2 * n)
    m.degree = degree
    return energy_error(m, outside(m), [tie(m, basis=basis)])


def alone(cell, degree, n):
    """One box of the cells of the coarser half."""
    m = Boxes([((0.0, 0.0, 0.0), (1.0, 1.0, 2.0), (2 * n, 2 * n, 4 * n))], cell, degree, comm=MPI.COMM_WORLD)
    m.degree = degree
    m.mesh.topology.create_connectivity(2, 3)
    return energy_error(m, mesh.exterior_facet_indices(m.mesh.topology), [])


@pytest.mark.parametrize(
    "cell, degree, basis",
    [
        ("hexahedron", 1, "dual"), ("hexahedron", 2, "dual"), ("tetrahedron", 1, "dual"), ("tetrahedron", 2, "dual"),
        ("tetrahedron", 2, "linear"),
    ],
)  # fmt: skip
def test_the_order_of_convergence_in_space(cell, degree, basis):
    sizes = (2, 4) if degree == 2 else (3, 6)
    errors = [(tied(cell, degree, n, basis), alone(cell, degree, n)) for n in sizes]
    orders = np.log2(np.array(errors[0]) / errors[1])
    # Measured, tied and in one mesh: 1.004 and 1.002, 1.998 and 1.995, 0.997 and 0.996, 1.977 and 1.980; with
    # multipliers at corners alone 1.90, as supports leave out those all around the joint.
    assert orders[0] > orders[1] - (0.01 if basis == "dual" else 0.1), (errors, orders)
    assert errors[1][0] < 1.1 * errors[1][1]  # half of the cells are finer
