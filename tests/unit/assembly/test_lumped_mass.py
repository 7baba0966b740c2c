# SPDX-License-Identifier: MIT
"""Lumped masses: the whole mass in every direction, nothing negative, and row sums where row sums are asked for."""

import operator_checks
import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact.forms import inertia

DENSITY = 3.0
CELLS = list(operator_checks.CELLS)


def space(cell, degree, left=0.0):
    domain = operator_checks.body(cell, (3, 2, 2), MPI.COMM_SELF, left)
    return fem.functionspace(domain, ("Lagrange", degree, (domain.geometry.dim,)))


def hypotheses(cell):
    return ["3d"] if cell in ("tetrahedron", "hexahedron") else ["plane_strain", "plane_stress", "axisymmetric"]


def schemes(cell, degree):
    if degree == 1:
        return ["auto", "row_sum", "hrz"] + (["nodal"] if cell in ("quadrilateral", "hexahedron") else [])
    return ["auto", "hrz"] + (["nodal", "row_sum"] if cell in ("quadrilateral", "hexahedron") else [])


CASES = [
    (cell, degree, hypothesis, scheme)
    for cell in CELLS
    for degree in (1, 2)
    for hypothesis in hypotheses(cell)
    for scheme in schemes(cell, degree)
]


def total_mass(V, hypothesis):
    """By quadrature of high degree, with DOLFINx's own kernels."""
    weight = 2 * ufl.pi * ufl.SpatialCoordinate(V.mesh)[0] if hypothesis == "axisymmetric" else 1
    return DENSITY * fem.assemble_scalar(fem.form(weight * ufl.dx(V.mesh, metadata={"quadrature_degree": 6})))


@pytest.mark.parametrize("case", CASES, ids=lambda c: "-".join(map(str, c)))
def test_total_is_exact_and_entries_positive(case):
    cell, degree, hypothesis, scheme = case
    V = space(cell, degree, left=0.0)  # axisymmetric bodies have nodes on the axis
    material = di.LinearElastic(1.0, 0.3, DENSITY, hypothesis)
    refused = hypothesis == "axisymmetric" and (scheme == "nodal" or (degree == 2 and scheme == "row_sum"))
    if refused:  # no mass on the axis
        with pytest.raises(ValueError, match="(?s)positive|nodal mass.*use hrz"):
            di.lumped_mass(V, material, scheme)
        return
    diagonal = di.lumped_mass(V, material, scheme).array
    assert diagonal.min() > 0
    by_direction = diagonal.reshape(-1, V.mesh.geometry.dim)
    # A hundred additions of positive numbers.
    assert by_direction.sum(axis=0) == pytest.approx(total_mass(V, hypothesis), rel=1e-13)
    assert np.ptp(by_direction, axis=1).max() <= 1e-13 * diagonal.max()


@pytest.mark.parametrize("cell", CELLS)
def test_row_sums_are_row_sums(cell):
    for hypothesis in hypotheses(cell):
        V = space(cell, 1, left=0.5)
        u, v = ufl.TrialFunction(V), ufl.TestFunction(V)
        dx = ufl.dx(V.mesh, metadata={"quadrature_degree": 6})
        consistent = fem.assemble_matrix(fem.form(inertia.mass(u, v, DENSITY, hypothesis, dx))).to_dense()
        diagonal = di.lumped_mass(V, di.LinearElastic(1.0, 0.3, DENSITY, hypothesis), "row_sum").array
        assert diagonal == pytest.approx(consistent.sum(axis=1), rel=1e-13)


def test_hrz_is_the_scaled_diagonal():
    """One cell: the diagonal of the consistent matrix, scaled to the cell's mass in every direction."""
    domain = mesh.create_unit_square(MPI.COMM_SELF, 1, 1, mesh.CellType.quadrilateral)
    V = fem.functionspace(domain, ("Lagrange", 2, (2,)))
    dx = ufl.dx(domain, metadata={"quadrature_degree": 6})
    M = fem.assemble_matrix(
        fem.form(inertia.mass(ufl.TrialFunction(V), ufl.TestFunction(V), DENSITY, "plane_strain", dx))
    ).to_dense()
    expected = np.diag(M) * DENSITY / (np.trace(M) / 2)
    found = di.lumped_mass(V, di.LinearElastic(1.0, 0.3, DENSITY, "plane_strain"), "hrz").array
    assert found == pytest.approx(expected, rel=1e-13)


def test_nodal_mass_is_simpsons_rule():
    domain = mesh.create_unit_square(MPI.COMM_SELF, 1, 1, mesh.CellType.quadrilateral)
    V = fem.functionspace(domain, ("Lagrange", 2, (2,)))
    found = di.lumped_mass(V, di.LinearElastic(1.0, 0.3, 36.0, "plane_strain"), "nodal").array[::2]
    assert sorted(found) == pytest.approx([1] * 4 + [4] * 4 + [16], rel=1e-13)


def test_densities_by_tag():
    V = space("hexahedron", 2)
    tags = operator_checks.tags_of_cells(V.mesh)
    light, heavy = di.LinearElastic(1.0, 0.3, 1.0), di.NeoHookean(1.0, 0.3, 10.0)
    both = di.MaterialMap(tags, {1: light, 2: heavy})
    dx = ufl.Measure("dx", V.mesh, subdomain_data=tags, metadata={"quadrature_degree": 4})
    one = fem.Constant(V.mesh, 1.0)
    expected = fem.assemble_scalar(fem.form(one * dx(1))) + 10 * fem.assemble_scalar(fem.form(one * dx(2)))
    for scheme in ("auto", "hrz"):
        assert di.lumped_mass(V, both, scheme).array.sum() == pytest.approx(3 * expected, rel=1e-13)


@pytest.mark.parametrize(
    "cell, degree, scheme, words",
    [
        ("hexahedron", 1, "lumped", "'lumped' is unknown.*row_sum, hrz"),
        ("triangle", 2, "row_sum", "not positive.*hrz"),
        ("tetrahedron", 2, "nodal", "not positive.*hrz"),
    ],
)
def test_schemes_that_do_not_fit(cell, degree, scheme, words):
    V = space(cell, degree)
    with pytest.raises(ValueError, match=words):
        di.lumped_mass(V, di.LinearElastic(1.0, 0.3, 1.0, hypotheses(cell)[0]), scheme)


def test_density_is_asked_for():
    with pytest.raises(ValueError, match="no density"):
        di.lumped_mass(space("triangle", 1), di.LinearElastic(1.0, 0.3, hypothesis="plane_strain"))


@pytest.mark.parametrize("ranks", [2, 3])
def test_several_ranks(script_on_ranks, ranks):
    """Same totals on several ranks; a body across the axis is the same error on all, though few have the faulty
    cells."""
    output = script_on_ranks(
        ranks,
        """
        import numpy as np
        from dolfinx import fem, mesh
        from mpi4py import MPI
        import dolfinx_impact as di
        comm = MPI.COMM_WORLD

        def lumped(left, degree, scheme, hypothesis):
            domain = mesh.create_rectangle(comm, [(left, 0), (2, 1)], (8, 1), mesh.CellType.quadrilateral)
            V = fem.functionspace(domain, ("Lagrange", degree, (2,)))
            b = di.lumped_mass(V, di.LinearElastic(1.0, 0.3, 3.0, hypothesis), scheme)
            assert np.all(b.array > 0)
            return comm.allreduce(b.array[: 2 * b.index_map.size_local].sum())

        for degree, scheme in ((1, "row_sum"), (2, "hrz")):
            assert abs(lumped(0.0, degree, scheme, "axisymmetric") / (2 * 3 * np.pi * 4) - 1) < 1e-13
            try:
                lumped(-0.4, degree, scheme, "axisymmetric")
            except ValueError as e:
                everywhere = comm.allgather(str(e))
                assert len(set(everywhere)) == 1, everywhere
                print("same")
        assert abs(lumped(0.0, 2, "nodal", "plane_strain") / (2 * 3 * 2) - 1) < 1e-13
        """,
    )
    assert output.count("same") == 2 * ranks
