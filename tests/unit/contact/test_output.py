# SPDX-License-Identifier: MIT
"""Contact arrays as fields in files for ParaView."""

import h5py
import numpy as np
import pytest
from dolfinx import fem, io
from dolfinx import mesh as dmesh
from mpi4py import MPI
from scipy.spatial import cKDTree
from initial_penetration_checks import Square

import dolfinx_impact as di

FIELDS = ("gap", "pressure", "traction", "slip", "status")


@pytest.mark.parametrize(
    "method", (di.Lagrange, lambda pair: di.Penalty(pair, penalty=1e5)), ids=("Lagrange", "Penalty")
)
@pytest.mark.parametrize("dim", (2, 3))
def test_fields_in_files(dim, method, tmp_path):
    """A ball pressed into the middle of the bottom: what the XDMF file holds at the nodes is what the contact says."""
    body, up = Square(dim, 8), np.eye(dim)[-1]
    ball = di.RigidSphere(np.full(dim, 0.5) - 1.5 * up, 1.0)
    problem = body.problem(ball, method, friction=0.2)
    ball.displacement = 0.02 * up
    problem.solve()
    ball.displacement = 0.02 * up + 0.02 * np.eye(dim)[0]  # what has touched before slips
    problem.solve()
    contact = problem.contact[0]
    functions = [contact.field(problem, getattr(contact, name), name) for name in FIELDS]
    with io.VTXWriter(MPI.COMM_SELF, tmp_path / "contact.bp", functions[:2] + functions[4:], "BP4") as file:
        file.write(0.0)
    assert (tmp_path / "contact.bp").exists()
    with io.XDMFFile(MPI.COMM_SELF, tmp_path / "contact.xdmf", "w") as file:
        file.write_mesh(body.mesh)
        for function in functions:
            file.write_function(function)
    with h5py.File(tmp_path / "contact.h5") as file:
        x = file["Mesh/mesh/geometry"][:]
        found = {name: file[f"Function/{name}/0"][:] for name in FIELDS}
    height = x[:, dim - 1]
    bottom = height == 0.0
    for name in FIELDS:
        assert np.all(found[name][~bottom] == 0.0) and np.any(found[name][bottom] != 0.0)
    places = body.V.tabulate_dof_coordinates()
    for name in FIELDS:
        nodes, values = contact.at_nodes(getattr(contact, name))
        distance, at = cKDTree(x[:, :dim]).query(places[nodes, :dim])
        assert distance.max() < 1e-12 and len(nodes) == np.count_nonzero(bottom)
        values = values.reshape(len(nodes), -1)
        np.testing.assert_allclose(found[name][at][:, : values.shape[1]], values, rtol=1e-12, atol=0)
    status = found["status"][bottom]
    assert np.all(found["pressure"] >= 0.0) and set(np.unique(status)) <= {0.0, 1.0, 2.0} and 0.0 in status
    if hasattr(contact, "nodes"):
        assert found["pressure"].max() == contact.pressure.max() and found["gap"].max() == contact.gap.max()


def test_means_at_nodes():
    """Constants stay constants; points without a gap do not count; a status stays a status."""
    body = Square(2, 4)
    contact = body.problem(di.RigidPlane((0.0, 0.0), (0.0, 1.0)), lambda pair: di.Penalty(pair, 1e5)).contact[0]
    left = contact.points[:, 0] < 0.5
    nodes, values = contact.at_nodes(np.where(left, 3.0, np.inf))
    x = body.V.tabulate_dof_coordinates()[nodes, 0]
    assert np.allclose(values[x < 0.6], 3.0, rtol=1e-14) and np.all(np.isinf(values[x > 0.6]))
    _, vectors = contact.at_nodes(np.tile([1.0, -2.0], (len(contact.points), 1)))
    assert np.allclose(vectors, [1.0, -2.0], rtol=1e-14)
    far = contact.points[:, 0] < 0.3  # a facet's first fifth beside a whole one
    assert np.array_equal(contact.at_nodes(np.where(far, 2, 0).astype(np.int8))[1], np.where(x < 0.3, 2.0, 0.0))


@pytest.mark.parametrize("method", (di.Lagrange, di.Penalty), ids=("Lagrange", "Penalty"))
def test_before_the_first_solution_nothing_touches(method):
    body = Square(2, 4)
    contact = body.problem(di.RigidPlane((0.0, -0.1), (0.0, 1.0)), method, friction=0.2).contact[0]
    for name in ("pressure", "traction", "slip", "status"):
        values = getattr(contact, name)
        assert len(values) == len(contact.points) > 0 and not np.any(values), name
    np.testing.assert_allclose(contact.gap, 0.1)
    assert contact.force is None


@pytest.mark.parametrize(
    "kind, method",
    [("static", di.Lagrange), ("static", di.Penalty), ("newmark", di.Lagrange), ("newmark", di.Penalty)]
    + [("explicit", di.Penalty), ("explicit", di.Kinematic)],
)
def test_contacts_print_what_they_are(kind, method):
    """Their pair, and the force on the slave once there is one; no address."""
    made = dmesh.create_unit_square(MPI.COMM_SELF, 2, 2, dmesh.CellType.quadrilateral)
    V = fem.functionspace(made, ("Lagrange", 1, (2,)))
    foot = dmesh.locate_entities_boundary(made, 1, lambda x: np.isclose(x[1], 0.0))
    tags = dmesh.meshtags(made, 1, np.sort(foot), np.full(len(foot), 3, dtype=np.int32))
    pair = di.ContactPair(tags, 3, di.RigidPlane((0.0, 0.0), (0.0, 1.0)), friction=0.25, name="sole")
    top = fem.locate_dofs_geometrical(V, lambda x: np.isclose(x[1], 1.0))
    bcs, law = [fem.dirichletbc(np.array([0.0, -0.01]), top, V)], di.LinearElastic(1.0, 0.0, 1.0, "plane_strain")
    u, contact = fem.Function(V), [method(pair)]
    if kind == "static":
        problem = di.StaticProblem(u, law, bcs=bcs, contact=contact)
        solve = problem.solve
    else:
        velocity = fem.Function(V)
        velocity.x.array[1::2] = -0.1
        make = di.ExplicitProblem if kind == "explicit" else di.NewmarkProblem
        problem = make(u, law, velocity=velocity, contact=contact)
        solve = lambda: problem.advance(0.04, dt=0.01, progress=False)  # noqa: E731
    text = repr(problem.contact[0])
    assert "'sole'" in text and "friction 0.25" in text and f"{len(problem.contact[0].weight)} points" in text
    solve()
    text = repr(problem.contact[0])
    force = problem.contact[0].force
    assert f"({force[0]:.6g}, {force[1]:.6g})" in text and force[1] > 0.0
    assert " object at 0x" not in text
    shapes = text.split("arrays ")[1].rstrip(")") + ")"
    for names, shape in (part.rsplit(" (", 1) for part in shapes.split("; ")):
        for name in names.split(", "):
            values = getattr(problem.contact[0], name)
            assert values.shape == tuple(int(n) for n in shape.rstrip(")").split(",") if n.strip()), name
