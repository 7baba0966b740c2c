# SPDX-License-Identifier: MIT
"""Contact patch test, BENCHMARKS P: a uniform stress passes through surfaces whose meshes do not match.

Multipliers on a mortar with exact segments pass to round-off. A penalty lets the surfaces overlap by p/chi and passes
where its quadrature, on slave facets, is exact; across the kinks of a deformable master it is not, as in the literature
(El-Abbasi & Bathe 2001): there the error is measured and has to fall with the number of points.
"""

import functools

import numpy as np
import patch_checks
import pytest
import ufl
from dolfinx import fem
from mpi4py import MPI
from on_ranks import rank_tests
from partial_facet_integrals import LoadedFacet
from pressed_blocks import E, PressedBlocks, free_sides, hooke

import dolfinx_impact as di
from dolfinx_impact import meshes

test_one_rank, test_several_ranks = rank_tests(patch_checks)
CELLS = {"triangle": 2, "quadrilateral": 2, "tetrahedron": 3, "hexahedron": 3}
STRAIN = -0.01
# What the benchmark asks for. Round-off leaves 1e-13: 1e-16 times the condition number of these meshes.
EXACT = patch_checks.EXACT
every_cell = pytest.mark.parametrize("cell", CELLS)
every_degree = pytest.mark.parametrize("degree", [1, 2])


def assert_patch(blocks, stress, tolerance=EXACT):
    pressure = -stress[-1]
    assert blocks.displacement_error() < tolerance
    assert blocks.stress_error(stress) < tolerance
    assert blocks.pressure_error(pressure) < tolerance
    assert np.all(blocks.contact.status > 0)


@pytest.mark.covering(2)
@every_cell
@every_degree
@pytest.mark.parametrize("nu", [0.0, 0.3])
@pytest.mark.parametrize("swap", [False, True])
def test_two_blocks(cell, degree, nu, swap):
    """P-1, P-2, P-3: free sides. Two blocks, each 0.5 high, are shortened by 0.01 together."""
    dim = CELLS[cell]
    strains = free_sides(dim, nu, STRAIN)
    blocks = PressedBlocks(cell, degree, strains, nu, di.Lagrange, swap=swap)
    stress = np.zeros(dim)
    stress[-1] = {(2, 0.0): -1e4, (2, 0.3): -10989.010989010989}.get((dim, nu), E * STRAIN)
    assert_patch(blocks, stress)
    interface = blocks.contact.points[:, -1]
    np.testing.assert_allclose(interface, 0.5 * (1 + STRAIN), rtol=0, atol=1e-12)
    assert blocks.contact.area == pytest.approx(1.0, rel=1e-12)  # of reference, as the force below
    np.testing.assert_allclose(np.abs(blocks.contact.force), -stress, rtol=0, atol=EXACT * E * -STRAIN)


@pytest.mark.covering(2)
@every_cell
@every_degree
@pytest.mark.parametrize("swap", [False, True])
@pytest.mark.parametrize("rollers", [False, True])
def test_inclined_interface(cell, degree, swap, rollers):
    """P-4, 30 degrees. Without friction the interface has to be a plane of principal stress: here all pressures in
    the plane of the incline are equal, the third one in 3D is another. Where the incline meets a roller its normal is
    not that of a plane of symmetry."""
    strains = np.array([STRAIN] * 2 if CELLS[cell] == 2 else [STRAIN, STRAIN / 2, STRAIN])
    stress = hooke(strains, 0.3)
    blocks = PressedBlocks(cell, degree, strains, 0.3, di.Lagrange, stress, rollers, swap, incline=np.pi / 6)
    assert_patch(blocks, stress)


def pressure_beside(pressure, low, high, degree):
    """Function of a mesh: the pressure on what of the lower surface lies outside low < x < high.

    Where an edge of the upper block lies inside a facet, the load stops there; it is replaced by the polynomial that
    has the same nodal forces: its projection on the shape functions, as a function of a discontinuous space.
    """

    def loads(m):
        tdim = m.mesh.topology.dim
        f = fem.Function(fem.functionspace(m.mesh, ("Discontinuous Lagrange", degree)))
        x = f.function_space.tabulate_dof_coordinates()
        m.mesh.topology.create_connectivity(tdim - 1, tdim)
        for facet in m.facet_tags.find(m.tags["master_surface"]):
            cell = m.mesh.topology.connectivity(tdim - 1, tdim).links(facet)[0]
            dofs = f.function_space.dofmap.cell_dofs(cell)
            dofs = dofs[np.isclose(x[dofs, tdim - 1], 0.5)]
            loaded = LoadedFacet(x[dofs][:, : tdim - 1], degree)
            f.x.array[dofs] = np.linalg.solve(loaded.mass(), loaded.outside(low, high))
        down = ufl.as_vector([0.0] * (tdim - 1) + [-pressure * f])
        return [di.Traction(m.facet_tags, m.tags["master_surface"], down)]

    return loads


@pytest.mark.covering(2)
@every_cell
@every_degree
@pytest.mark.parametrize("swap", [False, True])
def test_narrower_block(cell, degree, swap):
    """P-5: the upper block ends inside facets of the lower one, on the rest of which the same pressure is a load. The
    slave is the narrower or (swap) the wider one: nodes it has beside the contact hand their functions over."""
    dim = CELLS[cell]
    strains = free_sides(dim, 0.3, STRAIN)
    stress = hooke(strains, 0.3)
    cells = (8, 4) if dim == 2 else (8, 2, 2)
    mesh = {"lower": (1.0, 0.5), "upper": (0.6, 0.5)} if dim == 2 else {"lower": (1, 1, 0.5), "upper": (0.6, 1, 0.5)}
    mesh |= {"lower_cells": cells, "upper_cells": (7, *cells[1:-1], 3)}
    beside = pressure_beside(-stress[-1], 0.2, 0.8, degree)
    blocks = PressedBlocks(cell, degree, strains, 0.3, di.Lagrange, swap=swap, more_loads=beside, **mesh)
    contact = blocks.contact
    closed = contact.status > 0
    assert blocks.displacement_error() < EXACT and blocks.stress_error(stress) < EXACT
    np.testing.assert_allclose(contact.pressure[closed], -stress[-1], rtol=EXACT)
    assert contact.geometry.cover[closed].sum() == pytest.approx(0.6, rel=1e-10)  # not one facet more
    assert np.all(closed) != swap  # the wider block's surface is partly free


# --- penalty --------------------------------------------------------------------------------------------------------


@pytest.mark.covering(2)
@every_cell
@every_degree
@pytest.mark.parametrize("augmented", [False, True])
def test_penalty_on_a_rigid_plane(cell, degree, augmented):
    """Known traction: the block sinks in by p/chi, everywhere alike; augmented, not at all."""
    dim, pressure, chi = CELLS[cell], 5000.0, 2.0e6
    m = meshes.make("block", MPI.COMM_SELF, cell=cell, size=(1.0,) * dim, cells=(4, 3, 3)[:dim], distortion=0.1)
    V = fem.functionspace(m.mesh, ("Lagrange", degree, (dim,)))
    u = fem.Function(V, name="u")
    bcs = []
    for axis, name in enumerate(("left", "front")[: dim - 1]):
        dofs = fem.locate_dofs_topological(V.sub(axis), dim - 1, m.facet_tags.find(m.tags[name]))
        bcs.append(fem.dirichletbc(0.0, dofs, V.sub(axis)))
    up = np.eye(dim)[-1]
    pair = di.ContactPair(m.facet_tags, slave=m.tags["bottom"], master=di.RigidPlane(np.zeros(dim), up))
    problem = di.StaticProblem(
        u,
        di.LinearElastic(E, 0.3, hypothesis="3d" if dim == 3 else "plane_strain"),
        bcs=bcs,
        loads=[di.Traction(m.facet_tags, m.tags["top"], -pressure * up)],
        contact=[di.Penalty(pair, penalty=chi, augmented=augmented, tolerance=1e-13)],
    )
    problem.solve(rtol=1e-13)
    contact, offset = problem.contact[0], 0.0 if augmented else pressure / chi
    np.testing.assert_allclose(contact.pressure, pressure, rtol=EXACT)
    np.testing.assert_allclose(contact.gap, -offset, rtol=0, atol=EXACT * pressure / chi)
    strains = free_sides(dim, 0.3, -pressure / E * (0.91 if dim == 2 else 1.0))
    x = V.tabulate_dof_coordinates()[:, :dim]
    np.testing.assert_allclose(u.x.array.reshape(-1, dim), x * strains - offset * up, rtol=0, atol=EXACT)


@every_cell
@every_degree
def test_penalty_on_a_block_that_is_held(cell, degree):
    """The lower block has its displacement prescribed: penetration p/chi at every point, whatever its facets."""
    dim, chi = CELLS[cell], 1.0e7
    strains = free_sides(dim, 0.3, STRAIN)
    stress = hooke(strains, 0.3)
    method = functools.partial(di.Penalty, penalty=chi)
    blocks = PressedBlocks(cell, degree, strains, 0.3, method, rigid=True, sink=-stress[-1] / chi)
    assert_patch(blocks, stress)
    np.testing.assert_allclose(blocks.contact.gap, stress[-1] / chi, rtol=1e-9)


@every_cell
@every_degree
def test_penalty_between_blocks_errs_by_its_quadrature(cell, degree):
    """Kinks of the master inside slave facets: the error of stress is recorded, and falls with the points."""
    dim, chi = CELLS[cell], 1.0e7
    strains = free_sides(dim, 0.3, STRAIN)
    stress = hooke(strains, 0.3)
    errors = []
    for points in (None, 20):
        method = functools.partial(di.Penalty, penalty=chi, quadrature_degree=points)
        blocks = PressedBlocks(cell, degree, strains, 0.3, method, sink=-stress[-1] / chi)
        errors.append(blocks.stress_error(stress))
    print(f"penalty, {cell}, degree {degree}: stress error {errors[0]:.1e}, rule of degree 20 {errors[1]:.1e}")
    assert errors[0] < 0.05 and errors[1] < 0.5 * errors[0]  # measured 0.007 to 0.041, a quarter of that or less
