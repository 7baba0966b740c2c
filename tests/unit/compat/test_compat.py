# SPDX-License-Identifier: MIT
"""Each function of compat.py on the release that is installed, against what does not depend on releases."""

import os
import subprocess
import sys

import basix.ufl
import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI

from dolfinx_impact import compat

SELF = MPI.COMM_SELF


def curved(degree=2):
    """One quadrilateral of a given degree with straight sides, 2 long and 1 high, and a second one on its right."""
    element = basix.ufl.element("Lagrange", "quadrilateral", degree, shape=(2,))
    points = np.array([[0.0, 0.0], [2.0, 0.0], [0.0, 1.0], [2.0, 1.0], [3.0, 0.0], [3.0, 1.0]])
    if degree == 1:
        return mesh.create_mesh(SELF, np.array([[0, 1, 2, 3], [1, 4, 3, 5]]), x=points, e=element)
    nodes = np.asarray(element.sub_elements[0].basix_element.points) * [2.0, 1.0]
    return mesh.create_mesh(SELF, np.arange(len(nodes))[None], x=nodes, e=element)


def test_the_release_is_one_of_those_allowed():
    assert compat.release_of(compat.installed()) == compat.RELEASE
    assert all(compat.release_of(f"{one}.0.post0") for one in compat.TRIED)


@pytest.mark.parametrize("version", ("0.8.0", "0.10.0.post5", "0.12.0.dev0", "1.0.0", "2019.1.0", "unknown"))
def test_other_releases_are_refused_in_one_sentence(version):
    with pytest.raises(ImportError, match=f"DOLFINx {version} is installed") as found:
        compat.release_of(version)
    assert all(one in str(found.value) for one in compat.TRIED) and "\n" not in str(found.value)


@pytest.mark.parametrize("version", ("0.8.0", "0.10.0", "0.12.0"))
def test_importing_the_package_refuses_them(version, tmp_path):
    """A DOLFINx that has nothing but its version: the package must not try to use it."""
    (tmp_path / "dolfinx").mkdir()
    (tmp_path / "dolfinx" / "__init__.py").write_text(f'__version__ = "{version}"\n')
    where = os.pathsep.join([str(tmp_path), *os.environ.get("PYTHONPATH", "").split(os.pathsep)])
    command = [sys.executable, "-c", "import dolfinx_impact"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, env={**os.environ, "PYTHONPATH": where})
    assert done.returncode != 0
    last = done.stderr.strip().splitlines()[-1]
    assert last.startswith(f"ImportError: DOLFINx {version} is installed") and compat.tried() in last


@pytest.mark.parametrize("degree", (1, 2))
def test_geometry(degree):
    domain = curved(degree)
    for seen in (domain, domain._cpp_object):
        assert compat.coordinate_element(seen).degree == degree
        assert compat.geometry_dofmap(seen).shape == ((2, 4) if degree == 1 else (1, 9))
    x = domain.geometry.x[compat.geometry_dofmap(domain)]
    extent = np.ptp(x, axis=1)[np.argsort(domain.topology.original_cell_index)]
    np.testing.assert_array_equal(extent[:, :2], [[2.0, 1.0], [1.0, 1.0]][: len(extent)])


def test_nodes_of_cells_outlive_the_mesh():
    dofmap = compat.geometry_dofmap(mesh.create_unit_square(SELF, 30, 30))
    meshes = [mesh.create_unit_square(SELF, 30, 30) for _ in range(3)]  # what would take its place
    np.testing.assert_array_equal(np.unique(dofmap), np.arange(31 * 31))
    assert len(meshes) == 3


def test_cells_and_dimensions_of_a_domain():
    surface = ufl.Mesh(basix.ufl.element("Lagrange", "triangle", 1, shape=(3,)))
    assert compat.cell_name(surface) == "triangle"
    assert (compat.topological_dimension(surface), compat.geometric_dimension(surface)) == (2, 3)
    domain = curved().ufl_domain()
    assert compat.cell_name(domain) == "quadrilateral"
    assert (compat.topological_dimension(domain), compat.geometric_dimension(domain)) == (2, 2)


def test_interpolation_points():
    domain = mesh.create_unit_square(SELF, 2, 2)
    V = fem.functionspace(domain, ("Lagrange", 2, (2,)))
    np.testing.assert_allclose(compat.interpolation_points(V), V.element.basix_element.points, atol=1e-15)
    Q = fem.functionspace(domain, basix.ufl.quadrature_element("triangle", degree=3))
    points = basix.make_quadrature(basix.CellType.triangle, 3)[0]
    np.testing.assert_allclose(compat.interpolation_points(Q), points, atol=1e-15)
    f = fem.Function(V)
    x = ufl.SpatialCoordinate(domain)
    f.interpolate(fem.Expression(ufl.as_vector([x[0] ** 2, x[0] * x[1]]), compat.interpolation_points(V)))
    exact = fem.Function(V)
    exact.interpolate(lambda p: np.array([p[0] ** 2, p[0] * p[1]]))
    np.testing.assert_allclose(f.x.array, exact.x.array, atol=1e-15)


def test_collapse():
    domain = mesh.create_unit_square(SELF, 3, 2)
    quadratic = basix.ufl.element("Lagrange", "triangle", 2, shape=(2,))
    W = fem.functionspace(domain, basix.ufl.mixed_element([quadratic, basix.ufl.element("Lagrange", "triangle", 1)]))
    w = fem.Function(W)
    w.x.array[:] = np.arange(len(w.x.array))
    for k, sub in enumerate((W.sub(0), W.sub(1))):
        space, dofs = compat.collapse(sub)
        assert dofs.dtype == np.int32 and len(dofs) == len(fem.Function(space).x.array)
        np.testing.assert_array_equal(w.x.array[dofs], w.sub(k).collapse().x.array)


def test_vectors_and_index_maps():
    V = fem.functionspace(mesh.create_unit_square(SELF, 3, 2), ("Lagrange", 1, (2,)))
    b = compat.create_vector(V)
    assert b.getSize() == 2 * 12 and b.getBlockSize() == 2 and b.norm() == 0.0
    with b.localForm() as local:
        assert local.getSize() == 2 * 12
    b.destroy()
    numbers = compat.create_index_map(SELF, 5, np.zeros(0), np.zeros(0))
    assert (numbers.size_local, numbers.size_global, numbers.num_ghosts) == (5, 5, 0)


def test_partitioners():
    element = basix.ufl.element("Lagrange", "quadrilateral", 1, shape=(2,))
    plain = mesh.create_unit_square(SELF, 3, 2, mesh.CellType.quadrilateral)
    points, cells = plain.geometry.x[:, :2].copy(), compat.geometry_dofmap(plain).astype(np.int64)
    asked = []

    def here(comm, num_ranks, cell_types, nodes):
        asked.append(len(nodes[0]) // 4)
        return compat.adjacencylist(np.zeros((asked[-1], 1), dtype=np.int32))

    def with_offsets(comm, num_ranks, cell_types, nodes):
        num_cells = len(nodes[0]) // 4
        return compat.adjacencylist(np.zeros(num_cells, np.int32), np.arange(num_cells + 1, dtype=np.int32))

    for partitioner in (compat.create_cell_partitioner(mesh.GhostMode.shared_facet), here, with_offsets):
        made = mesh.create_mesh(SELF, cells, x=points, e=element, partitioner=partitioner)
        assert made.topology.index_map(2).size_global == 6
    assert asked == [6]


def test_facets_as_integrals_take_them():
    domain = mesh.create_unit_square(SELF, 3, 2)
    topology = domain.topology
    topology.create_connectivity(1, 2)
    topology.create_connectivity(2, 1)
    facets = mesh.exterior_facet_indices(topology)
    pairs = compat.facet_entities(topology._cpp_object, facets).reshape(-1, 2)
    of_cells = topology.connectivity(2, 1).array.reshape(-1, 3)
    np.testing.assert_array_equal(of_cells[pairs[:, 0], pairs[:, 1]], facets)


def test_linear_problems():
    """A quadratic function is its own finite element solution."""
    domain = mesh.create_unit_square(SELF, 3, 3)
    V = fem.functionspace(domain, ("Lagrange", 2))
    u, v, exact = ufl.TrialFunction(V), ufl.TestFunction(V), fem.Function(V)
    exact.interpolate(lambda x: 1 + x[0] ** 2 + 2 * x[1] ** 2)
    domain.topology.create_connectivity(1, 2)
    bcs = [fem.dirichletbc(exact, fem.locate_dofs_topological(V, 1, mesh.exterior_facet_indices(domain.topology)))]
    options = {"ksp_type": "preonly", "pc_type": "lu"}
    problem = compat.linear_problem(ufl.inner(ufl.grad(u), ufl.grad(v)) * ufl.dx, -6 * v * ufl.dx, bcs, options, "a_")
    np.testing.assert_allclose(problem.solve().x.array, exact.x.array, rtol=1e-12)


@pytest.fixture
def model():
    gmsh = pytest.importorskip("gmsh")
    gmsh.initialize(["", "-v", "0"], interruptible=False)
    yield gmsh.model
    gmsh.finalize()


def three_boxes(model, dim):
    """Three boxes side by side, meshed, without physical groups; entities of the first and last one's far side."""
    add = model.occ.addRectangle if dim == 2 else model.occ.addBox
    boxes = [add(k, 0, 0, 1, 1) if dim == 2 else add(k, 0, 0, 1, 1, 1) for k in range(3)]
    model.occ.fragment([(dim, boxes[0])], [(dim, box) for box in boxes[1:]])
    model.occ.synchronize()
    model.mesh.generate(dim)
    at = {x: e for d, e in model.getEntities(dim - 1) if np.ptp(model.getBoundingBox(d, e)[::3]) < 1e-3
          for x in [round(model.getBoundingBox(d, e)[0])]}  # fmt: skip
    return boxes, at[0]


@pytest.mark.parametrize("dim", (2, 3))
def test_meshes_of_gmsh_have_cells_and_facets_of_groups(model, dim):
    """Edges, points and cells in no group do not count, whatever release reads them."""
    boxes, left = three_boxes(model, dim)
    model.addPhysicalGroup(dim, [boxes[0]], 7)
    model.addPhysicalGroup(dim, [boxes[1]], 9)
    model.addPhysicalGroup(dim - 1, [left], 4, name="left")
    model.addPhysicalGroup(0, [1], 1)
    model.addPhysicalGroup(1, [1], 2) if dim == 3 else None
    groups = model.getPhysicalGroups()
    made = compat.model_to_mesh(model, SELF, gdim=dim)
    assert made.mesh.geometry.dim == made.mesh.topology.dim == dim == made.cell_tags.dim
    assert model.getPhysicalGroups() == groups  # the model is as it was
    volumes = fem.Function(fem.functionspace(made.mesh, ("DG", 0)))
    dx = ufl.Measure("dx", made.mesh, subdomain_data=made.cell_tags)
    volumes = [fem.assemble_scalar(fem.form(fem.Constant(made.mesh, 1.0) * dx(tag))) for tag in (7, 9)]
    assert volumes == pytest.approx([1.0, 1.0], rel=1e-12)
    assert made.mesh.geometry.x[:, 0].max() == pytest.approx(2.0)
    assert len(made.cell_tags.values) == made.mesh.topology.index_map(dim).size_local
    assert made.facet_tags.dim == dim - 1 and set(made.facet_tags.values) == {4}
    ds = ufl.Measure("ds", made.mesh, subdomain_data=made.facet_tags)
    assert fem.assemble_scalar(fem.form(fem.Constant(made.mesh, 1.0) * ds(4))) == pytest.approx(1.0, rel=1e-12)


def test_meshes_without_groups_of_facets_have_empty_tags(model):
    boxes, _ = three_boxes(model, 2)
    model.addPhysicalGroup(2, boxes, 1)
    mesh_of, cells, facets = compat.model_to_mesh(model, SELF, gdim=2)
    assert len(facets.indices) == 0 and facets.dim == 1 and set(cells.values) == {1}
    assert len(mesh_of.geometry.x) == len(compat.gmsh_nodes(model))


def test_a_model_without_groups_is_refused(model):
    three_boxes(model, 2)
    with pytest.raises(RuntimeError, match="no physical group"):
        compat.model_to_mesh(model, SELF, gdim=2)


def test_cells_of_two_kinds_and_groups_without_cells_are_refused(model):
    """DOLFINx 0.9 aborts the process at nodes that no cell has whose kind it takes."""
    boxes, _ = three_boxes(model, 2)
    model.mesh.clear()
    model.addPhysicalGroup(2, boxes, 1)
    with pytest.raises(RuntimeError, match="no physical group that holds cells.*mesh the model"):
        compat.model_to_mesh(model, SELF, gdim=2)
    model.mesh.setRecombine(2, boxes[0])
    model.mesh.generate(2)
    with pytest.raises(ValueError, match=r"cells of 2 kinds \(Triangle 3, Quad\w* 4\)"):
        compat.model_to_mesh(model, SELF, gdim=2)
