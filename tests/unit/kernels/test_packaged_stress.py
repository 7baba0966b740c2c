# SPDX-License-Identifier: MIT
"""Stress by the kernels that come with the package, against DOLFINx's evaluation of its UFL expression."""

import basix
import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact.assembly.cauchy_stress import CauchyStress
from dolfinx_impact.forms import registry
from dolfinx_impact.forms.materials import stress_components

ROWS = [row for row in registry.TABLE if row.name.endswith(".stress")]
MATERIALS = {"linear_elastic": di.LinearElastic, "neo_hookean": di.NeoHookean}
COUNT = 11  # cells: no multiple of any width


def box(row):
    """A row of distorted cells with r > 0, and a displacement with strains of some percent."""
    dim, kind = registry.CELLS[row.cell], getattr(mesh.CellType, row.cell)
    create = mesh.create_rectangle if dim == 2 else mesh.create_box
    domain = create(
        MPI.COMM_SELF, [[1.0] + [0.0] * (dim - 1), [2.0] + [1.0] * (dim - 1)], [COUNT] + [1] * (dim - 1), kind
    )
    x = domain.geometry.x
    x[:, 1] += 0.1 * x[:, 0] * x[:, 1]
    u = fem.Function(fem.functionspace(domain, ("Lagrange", row.degree, (dim,))), name="u")
    u.interpolate(lambda x: 0.05 * np.array([np.sin(2 * x[0] + x[1]), x[0] * x[1], np.cos(x[0] - x[2])])[:dim])
    return domain, u


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row.symbol)
def test_stress_is_the_expression_at_the_points(row):
    domain, u = box(row)
    material = MATERIALS[row.name.partition(".")[0]](20.0, 0.3, 1.0, row.hypothesis)
    stress = CauchyStress(u, material)
    assert stress._force.compiled.source == "package"
    points = basix.make_quadrature(domain.basix_cell(), stress.degree)[0]
    tensor = material.cauchy_stress(u)
    expression = ufl.as_vector([tensor[i, j] for i, j in stress_components(domain.geometry.dim)])
    cells = np.arange(domain.topology.index_map(domain.topology.dim).size_local, dtype=np.int32)
    theirs = fem.Expression(expression, points).eval(domain, cells)
    found = stress.values()
    # The same few products of strains and moduli in two orders, of numbers of size one; finite strain cancels ones.
    np.testing.assert_allclose(found.reshape(theirs.shape), theirs, atol=1e-12)
    assert np.abs(theirs).max() > 0.1


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row.symbol)
def test_force_beside_the_stress_is_the_force(row):
    """The kernel is a force that writes the stress on the way; sums of numbers of size one in two orders."""
    _, u = box(row)
    material = MATERIALS[row.name.partition(".")[0]](20.0, 0.3, 1.0, row.hypothesis)
    stress = CauchyStress(u, material)
    stress.values()
    force = di.InternalForce(di.operators.internal_force_form(u, ufl.TestFunction(u.function_space), material))
    np.testing.assert_allclose(stress._forces, force.apply().array, atol=1e-13)
