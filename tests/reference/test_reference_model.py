# SPDX-License-Identifier: MIT
"""Numbering, assembly, several materials, sparse matrices, and what bad input is answered."""

import time

import impact_reference as ir
import numpy as np
import pytest
from reference_meshes import CELLS, box, dofs, nodes_where

STEEL = ir.Material(200.0, 0.3, 7.0, "plane_strain")


def plate(degree=None, geometry_degree=1, n=2, **options):
    points, cells = box("quadrilateral", (n, n), geometry_degree)
    options.setdefault("material", STEEL)
    return ir.Model(points, cells, "quadrilateral", degree=degree, geometry_degree=geometry_degree, **options)


@pytest.mark.parametrize("cell", CELLS)
@pytest.mark.parametrize("degree, geometry", [(1, 1), (2, 1), (1, 2), (2, 2)])
def test_numbering(cell, degree, geometry):
    """As many nodes as the structured mesh of that degree has, each at its place, shared between cells."""
    counts = (2, 3, 2)[: ir.reference_nodes(cell, 1).shape[1]]
    points, cells = box(cell, counts, geometry)
    expected, _ = box(cell, counts, degree)
    hypothesis = "3d" if len(counts) == 3 else "plane_stress"
    model = ir.Model(points, cells, cell, ir.Material(1, 0, 1, hypothesis), degree=degree, geometry_degree=geometry)
    assert len(np.unique(np.round(model.field_points, 9), axis=0)) == len(model.field_points) == len(expected)
    N, _ = ir.shape_functions(cell, geometry, ir.reference_nodes(cell, degree))
    for own, field in zip(cells, model.field_cells):
        assert np.allclose(N @ points[own], model.field_points[field], atol=1e-14)
    if degree == geometry:
        assert np.array_equal(model.field_cells, cells) and np.array_equal(model.field_points, points)
    if (degree, geometry) == (2, 1):
        assert np.array_equal(model.field_points[: len(points)], points)  # vertices keep their numbers
        sizes = {"triangle": [3, 3], "quadrilateral": [4, 4, 1], "tetrahedron": [4, 6], "hexahedron": [8, 12, 6, 1]}[
            cell
        ]
        parts = np.split(model.field_cells, np.cumsum(sizes)[:-1], axis=1)
        for before, after in zip(parts[:-1], parts[1:]):
            assert before.max() < after.min()  # vertices, edges, faces, centres


@pytest.mark.parametrize("degree, geometry", [(1, 1), (2, 1), (1, 2), (2, 2)])
def test_assembly_is_the_sum_of_elements(degree, geometry):
    points, cells = box("triangle", (3, 2), geometry, distort=0.2)
    model = ir.Model(points, cells, "triangle", STEEL, degree=degree, geometry_degree=geometry)
    K = np.zeros((model.num_dofs,) * 2)
    for own, field in zip(cells, model.field_cells):
        at = dofs(field, (0, 1), 2)
        K[np.ix_(at, at)] += ir.element_stiffness("triangle", points[own], STEEL, degree, geometry)
    csr = model.stiffness()
    assert np.abs(csr.toarray() - K).max() < 1e-13 * np.abs(K).max()
    x = np.random.default_rng(0).uniform(size=model.num_dofs)
    assert np.allclose(csr.dot(x), K @ x, rtol=1e-12) and np.allclose(csr @ x, csr.dot(x))
    assert np.allclose(csr.diagonal(), np.diag(K), rtol=1e-13)
    assert np.allclose(model.internal_force(x), K @ x, rtol=1e-11)
    assert np.isclose(model.energy(x), x @ K @ x / 2, rtol=1e-12)
    for row in range(model.num_dofs):
        columns = csr.indices[csr.indptr[row] : csr.indptr[row + 1]]
        assert np.all(np.diff(columns) > 0)


def test_every_matrix_and_vector_with_two_materials():
    """Assembled quantities are the sums of the element functions, each cell with its own material."""
    points, cells = box("quadrilateral", (3, 2), 1, lambda x: np.array(x) + [0.1 * x[1], 0.0], distort=0.2)
    tags = np.arange(len(cells)) % 2
    law = {0: ir.Material(100, 0.2, 3, "plane_stress", "neo_hookean"), 1: ir.Material(50, 0.3, 9, "plane_stress")}
    model = ir.Model(points, cells, "quadrilateral", materials=law, cell_tags=tags, degree=2)
    u = np.random.default_rng(4).uniform(-0.01, 0.01, model.num_dofs)
    ale = (1.5, [0.2, 0.3])
    own = {
        "mass": (lambda X, m, v: ir.element_mass("quadrilateral", X, m, 2), model.mass()),
        "lumped": (lambda X, m, v: ir.element_lumped_mass("quadrilateral", X, m, "auto", 2), model.mass(lumped=True)),
        "damping": (lambda X, m, v: ir.element_damping("quadrilateral", X, m, 0.4, 0.1, 2), model.damping(0.4, 0.1)),
        "gyroscopic": (lambda X, m, v: ir.element_gyroscopic("quadrilateral", X, m, *ale, 2), model.gyroscopic(*ale)),
        "inertia": (lambda X, m, v: ir.element_ale_inertia("quadrilateral", X, m, *ale, 2), model.ale_inertia(*ale)),
        "load": (lambda X, m, v: ir.element_ale_load("quadrilateral", X, m, *ale, 2), model.ale_load(*ale)),
        "force": (lambda X, m, v: ir.element_internal_force("quadrilateral", X, m, v, 2), model.internal_force(u)),
        "tangent": (lambda X, m, v: ir.element_tangent("quadrilateral", X, m, v, 2), model.tangent(u)),
    }
    for name, (element, assembled) in own.items():
        assembled = assembled.toarray() if isinstance(assembled, ir.Csr) else assembled
        total = np.zeros_like(assembled)
        for c, cell in enumerate(cells):
            at = dofs(model.field_cells[c], (0, 1), 2)
            part = element(points[cell], law[tags[c]], u[at])
            total[np.ix_(at, at) if part.ndim == 2 else at] += part
        assert np.abs(total - assembled).max() < 1e-12 * np.abs(total).max(), name  # order of summation


def test_elimination_order_is_a_permutation_that_changes_nothing():
    """A model large enough to be dissected, against a dense solution."""
    points, cells = box("tetrahedron", (4, 5, 6), distort=0.1)
    model = ir.Model(points, cells, "tetrahedron", ir.Material(10.0, 0.3), degree=1)
    fixed = dofs(nodes_where(points, lambda x: x[0] < 1e-9), (0, 1, 2), 3)
    load = np.random.default_rng(0).uniform(-1, 1, model.num_dofs)
    u, _ = model.solve_static(fixed, 0.0, load)
    free = np.setdiff1d(np.arange(model.num_dofs), fixed)
    exact = np.linalg.solve(model.stiffness().toarray()[np.ix_(free, free)], load[free])
    assert np.allclose(u[free], exact, atol=1e-11 * np.abs(exact).max())  # condition number below 1e4


def test_two_materials_in_series():
    """Bar of two halves, nu = 0: the elongations add."""
    points, cells = box("quadrilateral", (4, 1), 1)
    tags = (points[cells].mean(axis=1)[:, 0] > 0.5) + 3
    laws = {3: ir.Material(100, 0, 1, "plane_stress"), 4: ir.Material(50, 0, 9, "plane_stress")}
    model = ir.Model(points, cells, "quadrilateral", materials=laws, cell_tags=tags)
    left, right = (nodes_where(points, lambda x: abs(x[0] - s) < 1e-9) for s in (0, 1))
    load = np.zeros(model.num_dofs)
    load[2 * right] = 0.5
    fixed = np.concatenate([dofs(left, 0, 2), [2 * left[0] + 1]])
    u, reactions = model.solve_static(fixed, 0.0, load)
    assert np.allclose(u[2 * right], 0.5 / 100 + 0.5 / 50, rtol=1e-12)
    assert np.isclose(reactions.sum(), -1, rtol=1e-12)
    assert np.isclose(model.mass(lumped=True)[::2].sum(), 5, rtol=1e-13)


def test_prescribed_values_and_full_constraint():
    model = plate()
    x = model.field_points
    u, reactions = model.solve_static(np.arange(model.num_dofs), (0.01 * x).reshape(-1))
    assert np.array_equal(u, (0.01 * x).reshape(-1))
    assert np.allclose(reactions, model.internal_force(u))
    u, _ = model.solve_static([0, 1, 2])
    assert np.array_equal(u, np.zeros(model.num_dofs))


def test_mechanism_of_a_poor_rule_is_reported():
    points, cells = box("quadrilateral", (1, 1))
    model = ir.Model(points, cells, "quadrilateral", STEEL, rule="table:1")
    with pytest.raises(RuntimeError, match="singular although every rigid motion is held: use a rule with more points"):
        model.solve_static([0, 1, 2], 0.0, np.arange(8.0))  # the hourglass modes are left


def test_rule_argument_reaches_the_assembly():
    model = plate(rule="table:1")
    values = np.linalg.eigvalsh(model.stiffness().toarray())
    full = np.linalg.eigvalsh(plate().stiffness().toarray())
    assert np.sum(values < 1e-10) == 18 - 4 * 3 and np.sum(full < 1e-10) == 3  # four points see three strains each


def test_wrappers_are_looked_up_when_called(monkeypatch):
    """Sabotage from outside must be seen: everything asks rules.quadrature."""
    good = plate().stiffness().toarray()
    right = ir.rules.quadrature

    def wrong(cell_type, rule):
        points, weights = right(cell_type, rule)
        return points, weights * 1.5

    monkeypatch.setattr(ir.rules, "quadrature", wrong)
    assert np.allclose(plate().stiffness().toarray(), 1.5 * good)
    X = ir.reference_nodes("triangle", 1)
    assert np.isclose(ir.element_mass("triangle", X, STEEL).sum(), 2 * 7 * 0.75)


@pytest.mark.slow
def test_a_hundred_thousand_degrees_of_freedom():
    points, cells = box("hexahedron", (32, 32, 32))
    model = ir.Model(points, cells, "hexahedron", ir.Material(200.0, 0.3, 7.0))
    assert model.num_dofs > 1e5
    start = time.process_time()
    K = model.stiffness()
    mass = model.mass(lumped=True)
    elapsed = time.process_time() - start
    assert np.isclose(mass.sum(), 21, rtol=1e-12)
    assert np.abs(K.dot(np.ones(model.num_dofs))).max() < 1e-10
    assert elapsed < 20  # processor seconds; about one on an idle core


def bad(message, kind=ValueError):
    return pytest.raises(kind, match=message)


def test_bad_material():
    for E in (0, -1, float("nan"), float("inf")):
        with bad("Young's modulus E is .*must be positive"):
            ir.Material(E, 0.3)
    for nu in (-1, 0.6, float("nan")):
        with bad("Poisson's ratio nu is .*between -1 and 0.5"):
            ir.Material(1, nu)
    with bad("locking-free mixed form"):
        ir.Material(1, 0.5)
    for density in (-1, float("nan")):
        with bad("density is .*must be zero"):
            ir.Material(1, 0.3, density)
    with bad("unknown hypothesis 'plane'.*plane_stress"):
        ir.Material(1, 0.3, hypothesis="plane")
    with bad("unknown law 'hooke'.*neo_hookean"):
        ir.Material(1, 0.3, law="hooke")
    with bad("density is 0, but a mass is asked for"):
        plate(material=ir.Material(1, 0.3, hypothesis="plane_strain")).mass()
    with bad("density is 0"):
        plate(material=ir.Material(1, 0.3, hypothesis="plane_strain")).mass(lumped=True)


def test_bad_mesh():
    points, cells = box("quadrilateral", (2, 2))
    with bad("unknown cell type"):
        ir.Model(points, cells, "square", STEEL)
    with bad("degree is 3"):
        ir.Model(points, cells, "quadrilateral", STEEL, degree=3)
    with bad("degree is 3"):
        ir.Model(points, cells, "quadrilateral", STEEL, geometry_degree=3)
    with bad("has 4 nodes, but cells has 3 columns"):
        ir.Model(points, cells[:, :3], "quadrilateral", STEEL)
    with bad("has 9 nodes, but cells has 4 columns"):
        ir.Model(points, cells, "quadrilateral", STEEL, geometry_degree=2)
    wrong = cells.copy()
    wrong[2, 1] = 77
    with bad("cell 2 names node 77, but the points are numbered 0 to 8"):
        ir.Model(points, wrong, "quadrilateral", STEEL)
    wrong[2, 1] = -1
    with bad("cell 2 names node -1"):
        ir.Model(points, wrong, "quadrilateral", STEEL)
    wrong[2, 1] = wrong[2, 0]
    with bad("cell 2 names node . twice"):
        ir.Model(points, wrong, "quadrilateral", STEEL)
    with bad("cell 1 is inverted .* determinant of its Jacobian is -0.0625"):
        ir.Model(points, np.array([cells[0], cells[1][::-1], cells[2], cells[3]]), "quadrilateral", STEEL)
    flat = points * [1, 0]
    with bad("cell 0 is inverted or has no volume: the determinant of its Jacobian is 0"):
        ir.Model(flat, cells, "quadrilateral", STEEL)
    hole = points.copy()
    hole[4, 1] = np.nan
    with bad("point 4 has a coordinate that is NaN"):
        ir.Model(hole, cells, "quadrilateral", STEEL)
    with bad("point 9 belongs to no cell"):
        ir.Model(np.vstack([points, [[5, 5]]]), cells, "quadrilateral", STEEL)
    with bad("2 coordinates, but the points have 3"):
        ir.Model(np.pad(points, ((0, 0), (0, 1))), cells, "quadrilateral", STEEL)
    with bad("cells must hold integers", TypeError):
        ir.Model(points, cells * 1.0, "quadrilateral", STEEL)
    with bad("hypothesis '3d' does not go with quadrilateral"):
        ir.Model(points, cells, "quadrilateral", ir.Material(1, 0.3))
    with bad("r = -0.5.*r >= 0"):
        ir.Model(points - [0.5, 0], cells, "quadrilateral", ir.Material(1, 0.3, hypothesis="axisymmetric"))


def test_bad_tags():
    points, cells = box("quadrilateral", (2, 2))
    laws = {1: STEEL, 2: ir.Material(1, 0, hypothesis="plane_stress")}
    with bad("different hypotheses"):
        ir.Model(points, cells, "quadrilateral", materials=laws, cell_tags=[1, 2, 1, 2])
    with bad("cell 3 has tag 7, for which no material"):
        ir.Model(points, cells, "quadrilateral", materials={1: STEEL}, cell_tags=[1, 1, 1, 7])
    with bad("4 cells but 3 cell_tags"):
        ir.Model(points, cells, "quadrilateral", materials={1: STEEL}, cell_tags=[1, 1, 1])
    with bad("needs cell_tags"):
        ir.Model(points, cells, "quadrilateral", materials=laws)
    with bad("either one material or"):
        ir.Model(points, cells, "quadrilateral")


def test_bad_element_input():
    X = ir.reference_nodes("triangle", 1)
    with bad("inverted or has no volume: the determinant of its Jacobian is -1"):
        ir.element_stiffness("triangle", X[::-1], STEEL)
    with bad("shape .6, 2., but .3, 2. was given"):
        ir.element_stiffness("triangle", X, STEEL, geometry_degree=2)
    with bad("NaN"):
        ir.element_stiffness("triangle", X * np.nan, STEEL)
    with bad("6 degrees of freedom, but 4"):
        ir.element_internal_force("triangle", X, STEEL, np.zeros(4))
    with bad("NaN"):
        ir.element_internal_force("triangle", X, STEEL, np.full(6, np.nan))
    with bad("needs 2 components, but 3"):
        ir.element_body_force("triangle", X, [0, 0, 1])
    with bad("facet 3 does not exist"):
        ir.element_traction("triangle", X, 3, [0, 1])
    with bad("no facet of the triangle"):
        ir.element_traction("triangle", X, [0, 1, 2], [0, 1])
    with bad("unknown lumping scheme 'diagonal'"):
        ir.element_lumped_mass("triangle", X, STEEL, "diagonal")
    axisymmetric = ir.Material(1, 0.3, 1, "axisymmetric")
    with bad("r = -1"):
        ir.element_stiffness("triangle", X - [1, 0], axisymmetric)
    with bad("on the axis"):
        ir.element_stiffness("triangle", X, axisymmetric, rule=([[0, 0.5]], [0.5]))
    with bad("ALE frame is not for axisymmetric"):
        ir.element_gyroscopic("triangle", X, axisymmetric, 1.0, [0, 0])
    with bad("spin needs 1 component"):
        ir.element_ale_inertia("triangle", X, STEEL, [0, 0, 1.0], [0, 0])


def test_bad_requests():
    model = plate()
    with bad("18 degrees of freedom, but 5"):
        model.internal_force(np.zeros(5))
    with bad("degree of freedom 3 is NaN"):
        model.tangent(np.where(np.arange(18) == 3, np.nan, 0.0))
    with bad("no cell has a facet with the nodes 0 8"):
        model.traction([[0, 8]], [1, 0])
    with bad("names node 99"):
        model.traction([[0, 99]], [1, 0])
    with bad("between two cells"):
        middle = nodes_where(model.points, lambda x: abs(x[0] - 0.5) < 1e-9)[:2]
        model.follower_pressure(np.zeros(18), [middle], 1.0)
    with bad("fixed degree of freedom 18 is out of range"):
        model.solve_static([18])
    with bad("NaN"):
        model.solve_static([0, 1, 2], [0, 0, np.nan])
    with bad("19 frequencies were asked for"):
        model.frequencies(19)
    with bad("vector has 3 entries"):
        model.stiffness().dot(np.zeros(3))
    with bad("mass is not positive", RuntimeError):
        points, cells = box("triangle", (2, 2), 2)
        ir.Model(points, cells, "triangle", STEEL, geometry_degree=2).frequencies(1, lumped=True, scheme="row_sum")


def test_free_rigid_motions_are_named():
    model = plate()
    with bad("translation x of the body with node 0; .*rotation about z", RuntimeError):
        model.solve_static([])
    with bad("rigid motions are free: translation y of the body with node 0; fix more", RuntimeError):
        model.solve_static(dofs(np.arange(9), 0, 2))
    with bad("rotation about z", RuntimeError):
        model.solve_static([0, 1])
    points, cells = box("quadrilateral", (1, 1))
    two = ir.Model(np.vstack([points, points + [3, 0]]), np.vstack([cells, cells + 4]), "quadrilateral", STEEL)
    with bad("of the body with node 4", RuntimeError):
        two.solve_static(np.arange(8))
    ring = ir.Model(points + [1, 0], cells, "quadrilateral", ir.Material(1, 0.3, hypothesis="axisymmetric"))
    with bad("translation z .the axial direction", RuntimeError):
        ring.solve_static([0])
