# SPDX-License-Identifier: MIT
"""Gaps are judged along the path from the last converged state: what has passed through a master is not open."""

import logging

import basix.ufl
import numpy as np
import pytest
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact import compat
from dolfinx_impact._cpp.gap import through_master, through_obstacle

BOX = np.array([[-1.0, -1], [1, -1], [1, 1], [-1, 1]]) * 0.5
DISC = di.RigidCylinder((0, 0), 0.5)
OBSTACLES = {
    "cylinder": DISC,
    "sphere": di.RigidSphere((0, 0), 0.5),
    "facets": di.RigidSurface.from_facets(BOX, [[0, 1], [1, 2], [2, 3], [3, 0]]),
}


def passed(obstacle, start, end, gdim=2, offset=0.0):
    start, end = (np.array(x, dtype=float) for x in (start, end))
    return bool(through_obstacle(obstacle.obstacle(gdim), start, end, np.full(1, offset), 1e-12)[0])


@pytest.mark.parametrize("name", OBSTACLES)
def test_paths_through_obstacles(name):
    """From above to below the obstacle; not: beside it, into it and not out of it, back, along its surface."""
    obstacle = OBSTACLES[name]
    assert passed(obstacle, (0.0, 0.6), (0.1, -0.7))
    assert passed(obstacle, (0.0, 0.5), (0.0, -50.0)), "touches at the start, goes far"
    assert passed(obstacle, (0.0, 0.45), (0.1, -0.7)), "penetrates at the start, as with a penalty"
    assert not passed(obstacle, (0.9, 0.6), (0.9, -0.7))
    assert not passed(obstacle, (0.0, 0.6), (0.0, -0.3))
    assert not passed(obstacle, (0.0, 0.45), (0.1, 0.7))
    assert not passed(obstacle, (-0.3, 0.5), (0.3, 0.5))


def test_paths_in_space_and_where_nothing_can_be_passed():
    assert passed(di.RigidSphere((0, 0, 0), 0.5), (0, 0.1, 0.6), (0, 0.1, -0.6), gdim=3)
    assert passed(di.RigidCylinder((0, 0, 0), 0.5, (1, 0, 0)), (3, 0.1, 0.6), (-2, 0.1, -0.6), gdim=3)
    assert not passed(di.RigidPlane((0, 0), (0, 1)), (0, 1), (0.5, -1)), "inside, however deep"
    assert not passed(di.RigidCylinder((0, 0), -1.0), (0, 0.99), (0.1, -0.9)), "across a bore"
    assert passed(di.RigidCylinder((0, 0), 0.001), (0, 0.4), (0, -0.4)), "thinner than a step of the path"
    assert not passed(DISC, (0.0, 0.4), (0.0, 0.6), offset=0.1), "an initial penetration was removed"


@pytest.mark.parametrize("depth, through", ((0.01, False), (0.2, True)))
def test_points_that_lose_their_master_deep_inside_it(depth, through):
    """Facets of 0.2: half a facet deep and then without master, or at the surface and over its edge."""
    gaps = {k: np.array([-depth * k if k < 0.7 else np.inf, 0.0]) for k in np.arange(1, 8) / 8}
    found = through_master(MPI.COMM_SELF, np.array([1, 0], dtype=np.int8), np.full(2, 0.2), lambda part: gaps[part])
    assert found.tolist() == [through, 0]


class Beam:
    """A beam between two rigid rollers, held along itself at one end only: contact alone bears it."""

    def __init__(self, cell, method, move):
        m = mesh.create_rectangle(MPI.COMM_SELF, [(0, 0), (60, 5)], (30, 2), getattr(mesh.CellType, cell))
        V = fem.functionspace(m, ("Lagrange", 2, (2,)))
        sides = [(3, lambda x: np.isclose(x[1], 0)), (4, lambda x: np.isclose(x[1], 5))]
        facets = [mesh.locate_entities_boundary(m, 1, where) for _, where in sides]
        values = np.repeat([tag for tag, _ in sides], [len(f) for f in facets]).astype(np.int32)
        order = np.argsort(np.concatenate(facets))
        tags = mesh.meshtags(m, 1, np.concatenate(facets)[order], values[order])
        ends = mesh.locate_entities_boundary(m, 1, lambda x: np.isclose(x[0], 0))
        bc = fem.dirichletbc(0.0, fem.locate_dofs_topological(V.sub(0), 1, ends), V.sub(0))
        top, support = di.RigidCylinder((0, 10), 5), di.RigidCylinder((50, -5), 5)
        self.u, self.top = fem.Function(V), top
        law = di.LinearElastic(70e3, 0.3, hypothesis="plane_stress")
        pairs = [di.ContactPair(tags, 4, top), di.ContactPair(tags, 3, support)]
        self.problem = di.StaticProblem(self.u, law, bcs=[bc], contact=[method(p) for p in pairs])
        top.displacement = (0, move, 0)


@pytest.mark.parametrize("cell", ("quadrilateral", "triangle"))
def test_a_beam_stays_between_its_rollers(cell):
    """Forces of penalty contact that grow with the way; Newton's method alone puts the beam beyond a roller."""
    moves = (-0.34, -0.4, -0.44)
    forces = []
    for move in moves:
        beam = Beam(cell, di.Penalty, move)
        beam.problem.solve()
        assert np.abs(beam.u.x.array).max() < 1.1 * abs(move)
        forces.append(-beam.problem.contact[0].force[1])
    # The beam is linear, and its contact moves along the rollers by little.
    np.testing.assert_allclose(np.array(forces) / np.array(moves), forces[0] / moves[0], rtol=0.01)


def test_bodies_that_nothing_holds_any_more_are_no_solution(monkeypatch, contacts_in_python):
    """Without looking at paths, the beam beyond the roller is refused as it hangs in the air. (It gets there in moves
    from 0.42 on; in shorter ones the last digits of residuals decide.)"""
    monkeypatch.setattr(
        "dolfinx_impact.contact.penalty.quadrature_penalty.QuadraturePenalty.passed_through", lambda self: ""
    )
    beam = Beam("quadrilateral", di.Penalty, -0.48)
    with pytest.raises(RuntimeError, match=r"contact was lost \(4 on .*smallest gap .*free to move along y"):
        beam.problem.solve(cut_backs=0)


@pytest.mark.parametrize("method", (di.Lagrange, di.Penalty))
def test_a_contact_that_opens_is_told(method, caplog):
    """A block that is held at its top: the obstacle under it moves up and away again."""
    m = mesh.create_rectangle(MPI.COMM_SELF, [(0, 0), (1, 1)], (2, 2), mesh.CellType.quadrilateral)
    V = fem.functionspace(m, ("Lagrange", 1, (2,)))
    facets = [mesh.locate_entities_boundary(m, 1, lambda x, y=y: np.isclose(x[1], y)) for y in (0.0, 1.0)]
    tags = mesh.meshtags(m, 1, np.sort(facets[0]), np.full(len(facets[0]), 3, dtype=np.int32))
    bc = fem.dirichletbc(np.zeros(2), fem.locate_dofs_topological(V, 1, facets[1]), V)
    floor, u = di.RigidPlane((0, 0), (0, 1)), fem.Function(V)
    law = di.LinearElastic(1e3, 0.3, hypothesis="plane_strain")
    problem = di.StaticProblem(u, law, bcs=[bc], contact=[method(di.ContactPair(tags, 3, floor))])
    with caplog.at_level(logging.WARNING, logger="dolfinx_impact"):
        floor.displacement = (0, 0.01)
        problem.solve()
        assert not caplog.records
        floor.displacement = (0, -0.02)
        problem.solve()
    assert "contacts that were closed carry no force at the end" in caplog.text
    assert problem.contact[0].pair.name in caplog.text and "smallest gap 2.000e-02" in caplog.text


def plate_and_punch(cell, method):
    """A narrow punch on a plate of 0.2, and the nodes of the punch."""
    quads = {"plate": ((-1.0, -0.2), (1.0, 0.0), (10, 2)), "punch": ((-0.25, 0.0), (0.25, 0.3), (3, 2))}
    x, cells, tags = [], [], []
    for k, (low, high, count) in enumerate(quads.values()):
        part = mesh.create_rectangle(MPI.COMM_SELF, [low, high], count, getattr(mesh.CellType, cell))
        cells.append(compat.geometry_dofmap(part) + sum(len(p) for p in x))
        x.append(part.geometry.x[:, :2])
        tags += [k + 1] * len(cells[-1])
    element = basix.ufl.element("Lagrange", cell, 1, shape=(2,))
    domain = mesh.create_mesh(MPI.COMM_SELF, np.concatenate(cells), x=np.concatenate(x), e=element)
    V = fem.functionspace(domain, ("Lagrange", 1, (2,)))
    of = np.array(tags)[domain.topology.original_cell_index]
    punch = np.unique(V.dofmap.list[of == 2])
    domain.topology.create_connectivity(1, 2)
    facets = mesh.locate_entities_boundary(domain, 1, lambda x: np.isclose(x[1], 0.0))
    of = np.array([of[domain.topology.connectivity(1, 2).links(f)[0]] for f in facets], dtype=np.int32)
    pair = di.ContactPair(mesh.meshtags(domain, 1, facets, of), 2, 1)
    problem = di.StaticProblem(
        fem.Function(V), di.LinearElastic(1.0, 0.3, hypothesis="plane_strain"), contact=[method(pair)]
    )
    return problem, punch


@pytest.mark.parametrize("cell", ("quadrilateral", "triangle"))
@pytest.mark.parametrize("method", (di.Lagrange, di.Penalty))
@pytest.mark.parametrize(
    "motion, through",
    (
        ((1.5, -0.3), True),  # deep in the plate on its way, and out of it at its side
        ((1.5, 0.3), False),  # above the plate
        ((1.5, -0.01), False),  # along its surface and over its edge
        ((0.3, -0.3), False),  # still over the plate: in it, which the contact sees
    ),
)
def test_a_punch_that_has_left_the_plate(cell, method, motion, through):
    """Where a point is without a master, its path from the start of the increment says whether it may be open."""
    problem, punch = plate_and_punch(cell, method)
    contact = problem.contact[0]._cpp_object
    u = np.zeros_like(problem.u.x.array)
    contact.begin_step(u, None)
    u.reshape(-1, 2)[punch] = motion
    contact.update_gap(u)
    said = contact.passed_through()
    assert ("points have passed through the master in this increment" in said) == through, said
