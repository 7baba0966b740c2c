# SPDX-License-Identifier: MIT
"""Contact that finds itself: no pairs, self-contact, edges, thin bodies; docs/explicit/general_contact.md."""


import general_contact_checks
import numpy as np
import pytest
from dolfinx import fem, mesh
from flying_bodies import Flying, box, ring, rotation
from mpi4py import MPI
from on_ranks import rank_tests

import dolfinx_impact as di
from dolfinx_impact.contact.explicit.general import GeneralOutput
from dolfinx_impact.contact.general_surface import GeneralSurface

test_one_rank, test_several_ranks = rank_tests(general_contact_checks)
SPACE = ("hexahedron", "tetrahedron")
PLANE = ("quadrilateral", "triangle")
# Work of forces and changes of energies are the same sums: with steps of one length the balance is off by round-off.
BALANCE = 1e-12


def run(bodies, until, friction=0.0, part=0.6):
    """Advance; momentum and angular momentum stay to round-off, and the energies balance.

    Args:
        part: of the stable step at the start, for steps that are all alike: the integrator's own energy is not exact
            when they change.

    Returns:
        The problem, the deepest penetration, and the largest numbers of springs of nodes and of edges.
    """
    problem = bodies.problem(friction)
    momentum, spin = bodies.momentum(problem), bodies.angular_momentum(problem)
    seen = np.zeros(3)

    def look(p):
        general = next(c for c in p.contact if isinstance(c, GeneralOutput))
        seen[:] = np.maximum(seen, [general.deepest, *general.num_springs])

    problem.advance(until=until, dt=part * problem.stable_step(), callback=look, progress=False)
    _, m, v, x = bodies._owned(problem)
    size = float((m * np.abs(v)).sum()) * max(1.0, float(np.abs(x).max()))
    assert np.abs(bodies.momentum(problem) - momentum).max() < 1e-13 * size
    assert np.abs(bodies.angular_momentum(problem) - spin).max() < 1e-13 * size
    assert abs(problem.energy["drift"]) < BALANCE
    assert problem.energy["impact"] + problem.energy["contact"] > -1e-4 * problem.energy["total"]  # springs give none
    return problem, seen[0], int(seen[1]), int(seen[2])


def plane_blocks(cell, law=None):
    return Flying(
        [((8, 8), box((0.0, 0.0), (1.0, 1.0)), (0.0, 0.0)), ((7, 7), box((0.13, 1.01), (1.13, 2.01)), (0.0, -1.0))],
        cell,
        law,
    )


def faces_of_blocks(bodies):
    """Tags of the faces that meet: 1 and 2."""
    m = bodies.mesh
    middle = mesh.compute_midpoints(m, 1, bodies.tags.indices)[:, 1]
    values = np.where(np.abs(middle - 1.0) < 1e-6, 1, np.where(np.abs(middle - 1.01) < 1e-6, 2, 0)).astype(np.int32)
    return mesh.meshtags(m, 1, bodies.tags.indices[values > 0], values[values > 0])


@pytest.mark.parametrize("cell", PLANE)
def test_two_blocks_as_a_balanced_pair(cell):
    bodies = plane_blocks(cell)
    problem, deep, _, _ = run(bodies, 0.2)
    pair = di.Penalty(di.ContactPair(faces_of_blocks(bodies), 1, 2), balanced=True)
    other = bodies.problem(contact=[pair])
    other.advance(until=0.2, progress=False)
    assert deep < 0.01  # a twelfth of a cell
    # The same springs but at the corners, whose area is that of both faces here.
    for body in (0, 1):
        general, named = bodies.mean_velocity(problem, body)[1], bodies.mean_velocity(other, body)[1]
        assert abs(general - named) < 0.03


@pytest.mark.parametrize("cell", SPACE)
def test_blocks_with_friction(cell):
    blocks = [
        ((3, 3, 3), box((0.0, 0.0, 0.0), (1.0, 1.0, 1.0)), (0.0, 0.0, 0.0)),
        ((2, 2, 2), box((0.23, 0.17, 1.01), (1.23, 1.17, 2.01)), (0.3, 0.2, -1.0)),
    ]
    problem, deep, nodes, edges = run(Flying(blocks, cell), 0.2, friction=0.3)
    assert nodes > 5 and edges > 0 and deep < 0.03
    assert problem.energy["friction"] > 1e-3


def crossed_prisms(cell, shift=0.0, along=None, slides=0.0):
    """Two prisms that meet edge on edge, at a right angle.

    Args:
        shift: of the upper one along both edges; along: along that of the lower one alone.
        slides: velocity of the upper one along the lower one's edge.
    """
    top = np.sqrt(0.5)
    first = box((-1.5, -0.5, -0.5 - top), (1.5, 0.5, 0.5 - top), rotation((1, 0, 0), np.pi / 4))
    low = np.array([-0.5 + (shift if along is None else along), -1.5 + shift, -0.5 + top + 0.01])
    second = box(low, low + [1.0, 3.0, 1.0], rotation((0, 1, 0), np.pi / 4))
    return Flying([((6, 2, 2), first, (0, 0, 0)), ((2, 6, 2), second, (slides, 0, -1.0))], cell)


@pytest.mark.parametrize("cell", SPACE)
@pytest.mark.parametrize("shift", (0.0, 0.13))
def test_crossed_prisms_do_not_sink(cell, shift):
    """Facets of the one have no nodes of the other behind them, unless nodes happen to lie where the edges cross."""
    bodies = crossed_prisms(cell, shift)
    problem, deep, nodes, edges = run(bodies, 0.6)
    assert edges == 1 if shift else nodes + edges > 0
    assert deep < 0.12  # of prisms that are 1.4 high
    velocities = [bodies.mean_velocity(problem, b)[2] for b in (0, 1)]
    assert velocities[0] < velocities[1] - 0.1  # they part


@pytest.mark.parametrize(
    "cell,along,slides,end",
    (
        ("hexahedron", 1.46, 0.0, 1.14),  # near the end of the lower one, which is bent down and turns
        ("tetrahedron", 0.48, 0.0, 1.41),  # near a node
        ("hexahedron", 0.13, 2.0, 1.38),  # over a node, where one edge follows the other
    ),
)
def test_crossed_prisms_near_ends_and_over_nodes(cell, along, slides, end):
    """Edges that have come through stay closed as deep as they are, and their neighbours take over: before they were
    given up near nodes and ends, and the centres came to 0.99, 1.16 and 1.24."""
    bodies = crossed_prisms(cell, 0.13, along, slides)
    problem, deep, _, edges = run(bodies, 0.6)
    assert edges == 1 and deep < 0.12
    assert bodies.centre(problem, 1)[2] - bodies.centre(problem, 0)[2] > end
    if not slides:
        assert abs(problem.energy["impact"]) < 1e-3


@pytest.mark.parametrize("cell", SPACE)
def test_corner_on_corner(cell):
    """Corners that pass beside each other are held by their edges."""
    turn, high = rotation((1, -1, 0), np.arctan(np.sqrt(2.0))), np.sqrt(3.0) / 2.0
    first = box((-0.5, -0.5, -0.5 - high), (0.5, 0.5, 0.5 - high), turn)
    second = box((-0.45, -0.48, -0.5 + high + 0.01), (0.55, 0.52, 0.5 + high + 0.01), turn)
    bodies = Flying([((2, 2, 2), first, (0, 0, 0)), ((2, 2, 2), second, (0, 0, -1.0))], cell)
    _, deep, _, edges = run(bodies, 0.3)
    assert edges > 0 and deep < 0.03


@pytest.mark.parametrize("cell", PLANE)
def test_coaxial_cylinders_in_one_dimension(cell):
    """Two cylinders whose radius is held, one falls on the other: a plane wave with pressure rho c v / 2 runs through
    both, and they exchange their velocities."""
    law = di.LinearElastic(1000.0, 0.3, density=1.0, hypothesis="axisymmetric")
    lower, upper = box((0.0, 0.0), (1.0, 1.0)), box((0.0, 1.001), (1.0, 2.001))
    bodies = Flying([((6, 12), lower, (0.0, 0.0)), ((5, 12), upper, (0.0, -1.0))], cell, law)
    m, V = bodies.mesh, bodies.V
    m.topology.create_connectivity(2, 2)
    cells = np.arange(m.topology.index_map(2).size_local, dtype=np.int32)
    held = fem.dirichletbc(0.0, fem.locate_dofs_topological(V.sub(0), 2, cells), V.sub(0))
    problem = bodies.problem(bcs=[held])
    wave = np.sqrt(1000.0 * 0.7 / 1.3 / 0.4)  # velocity, with density 1; it is back at the contact at 2 / wave = 0.054
    forces = []

    def look(p):
        if 0.015 < p.time < 0.045:
            forces.append(p.contact[0].force_on(2)[1])

    problem.advance(until=0.08, dt=0.5 * problem.stable_step(), callback=look, progress=False)
    # The springs' compliance, a hundredth of the bodies', and the mesh, twelve cells for a front.
    assert np.mean(forces) == pytest.approx(0.5 * np.pi * wave, rel=0.03) and np.std(forces) < 0.05 * np.mean(forces)
    velocities = [bodies.mean_velocity(problem, b)[1] for b in (0, 1)]
    np.testing.assert_allclose(velocities, [-1.0, 0.0], atol=0.01)
    assert abs(problem.energy["drift"]) < BALANCE


@pytest.mark.parametrize("cell", (*PLANE, "hexahedron"))
def test_both_faces_of_a_notch_bear(cell):
    """A node that is pressed into both has a spring to each; by symmetry their forces are alike to round-off."""
    bodies = general_contact_checks.notch(MPI.COMM_SELF, cell)
    tip = np.flatnonzero((bodies.body == 2) & (bodies.X[:, -1] < 0.006))
    seen = []

    def look(p):
        contact = p.contact[0]
        right, left = contact.force_on(1), contact.force_on(2)
        mirrored = right * ([-1.0] + [1.0] * (bodies.dim - 1))
        more = contact.num_springs[0] - np.sum(contact.status > 0)
        at_tip = (contact.traction * contact.weight[:, None])[np.isin(contact.nodes, tip)].sum(axis=0)
        seen.append((np.abs(left - mirrored).max(), np.abs(right).max(), more, *at_tip[[0, -1]]))

    problem = bodies.problem()
    momentum = bodies.momentum(problem)
    problem.advance(until=0.08, dt=0.5 * problem.stable_step(), callback=look, progress=False)
    difference, force, more, tip_side, tip_up = np.max(seen, axis=0)
    assert force > 1.0 and difference < 1e-11 * force
    assert more >= len(tip) and tip_up > 0.3 and np.abs([s[3] for s in seen]).max() < 1e-11
    assert problem.contact[0].deepest < 0.02  # of cells of 0.18 and more
    assert np.abs(bodies.momentum(problem) - momentum).max() < 1e-13 and abs(problem.energy["drift"]) < BALANCE


@pytest.mark.parametrize("cell,low", (("triangle", 0.0), ("quadrilateral", -0.7)))
def test_corner_of_a_floor_and_a_wall(cell, low):
    """The node in the corner is behind one body and beyond the end of the other."""
    bodies = Flying(
        [
            ((8, 4), box((-2.0, -1.0), (0.0, 0.0)), (0.0, 0.0)),
            ((2, 6), box((0.0, low), (0.6, 1.5)), (0.0, 0.0)),
            ((3, 3), box((-0.705, 0.005), (-0.005, 0.705)), (1.0, -1.0)),
        ],
        cell,
    )
    corner = np.argmin(np.linalg.norm(bodies.X - (-0.005, 0.005), axis=1))
    least = [0.0]

    def look(p):
        contact = p.contact[0]
        x, y = (contact.traction * contact.weight[:, None])[contact.nodes == corner][0]
        least[0] = max(least[0], min(-x, y))

    problem = bodies.problem(0.2)
    problem.advance(until=0.12, dt=0.5 * problem.stable_step(), callback=look, progress=False)
    assert least[0] > 1.0  # both bear at once
    assert abs(problem.energy["drift"]) < BALANCE
    x = bodies.X + problem.u.x.array.reshape(-1, 2)
    assert x[corner, 0] < 0.03 and x[corner, 1] > -0.03  # an eighth of a cell


@pytest.mark.parametrize("cell", PLANE)
def test_a_block_slides_over_the_seam_of_two_others(cell):
    """The side of the second one does not hold it up."""
    blocks = [
        ((6, 3), box((-2.0, -1.0), (0.0, 0.0)), (0.0, 0.0)),
        ((5, 3), box((0.0, -1.0), (1.7, 0.0)), (0.0, 0.0)),
        ((3, 2), box((-0.6, 0.0), (0.4, 0.5)), (1.0, -0.05)),
    ]
    bodies = Flying(blocks, cell)
    problem, deep, nodes, _ = run(bodies, 0.3)
    assert nodes > 2 and deep < 0.002
    assert abs(bodies.mean_velocity(problem, 2)[0] - 1.0) < 1e-4


@pytest.mark.parametrize("cell", (*PLANE, *SPACE))
def test_thin_plate_hit_from_both_sides(cell):
    dim = 2 if cell in PLANE else 3
    t, counts = (0.03, (20, 1)) if dim == 2 else (0.05, (8, 8, 1))
    wide = [1.0] * (dim - 1)
    low, high = np.array([-0.2] * (dim - 1) + [0.0]), np.array([0.2] * (dim - 1) + [0.4])
    up = np.array([0.0] * (dim - 1) + [1.0])
    along = np.array([0.05] + [0.0] * (dim - 1))
    bodies = Flying(
        [
            (counts, box([-w for w in wide] + [-t], wide + [t]), 0.0 * up),
            ((3,) * dim, box(low + (t + 0.01) * up, high + (t + 0.01) * up), -1.0 * up),
            ((3,) * dim, box(low - (t + 0.41) * up + along, high - (t + 0.41) * up + along), 1.0 * up),
        ],
        cell,
    )
    problem, deep, nodes, _ = run(bodies, 0.3, friction=0.2)
    assert nodes >= 4 and deep < 0.6 * t
    assert abs(bodies.centre(problem, 0)[-1]) < 0.2 * t  # it stays between them
    for body, way in ((1, 1.0), (2, -1.0)):
        assert way * bodies.mean_velocity(problem, body)[-1] > 0.5


def folded_strip(cell):
    """A strip bent to a U, whose legs are thrown at each other."""
    length, radius, thickness = 2.0, 0.2, 0.1

    def place(p):
        s, y = p[:, 0] * (2.0 * length + np.pi * radius), (p[:, 1] - 0.5) * thickness
        angle = np.clip((s - length) / radius, 0.0, np.pi)
        r = radius - y
        back = np.where(s > length + np.pi * radius, s - length - np.pi * radius, 0.0)
        return np.column_stack([np.minimum(s, length) + r * np.sin(angle) - back, -r * np.cos(angle)])

    def velocity(x):
        return np.column_stack([0.0 * x[:, 0], -2.0 * np.sign(x[:, 1]) * np.clip((length - x[:, 0]) / length, 0, 1)])

    return Flying([((80, 2), place, velocity)], cell)


@pytest.mark.parametrize("cell", PLANE)
def test_strip_folds_onto_itself(cell):
    bodies = folded_strip(cell)
    problem, deep, nodes, _ = run(bodies, 0.3, friction=0.3)
    assert nodes > 4 and deep < 0.015  # of a thickness of 0.1
    assert problem.contact[0]._general.searches < 0.2 * problem.step
    y = bodies.X[:, 1] + problem.u.x.array.reshape(-1, 2)[:, 1]
    upper, lower = (bodies.X[:, 0] < 1.9) & (bodies.X[:, 1] > 0), (bodies.X[:, 0] < 1.9) & (bodies.X[:, 1] < 0)
    assert y[upper].mean() > y[lower].mean() + 0.05


def crushed_ring(speed):
    blocks = [
        ((6, 2), box((-1.5, 1.01), (1.5, 2.01)), (0.0, -speed)),
        ((6, 2), box((-1.5, -2.01), (1.5, -1.01)), (0.0, speed)),
    ]
    return Flying([((48, 2), ring(1.0, 0.1), (0.0, 0.0)), *blocks], "quadrilateral")


def test_ring_is_crushed_until_its_inner_faces_touch():
    bodies = crushed_ring(1.0)
    inside = np.hypot(*bodies.X.T) < 0.95
    met = [0]
    problem = bodies.problem(0.2)

    def look(p):
        contact = p.contact[0]
        met[0] = max(
            met[0], int(np.sum(inside[contact.nodes] & (contact.status > 0) & (bodies.body[contact.nodes] == 0)))
        )

    problem.advance(until=1.5, dt=0.5 * problem.stable_step(), callback=look, progress=False)
    assert met[0] > 4
    assert abs(problem.energy["drift"]) < BALANCE
    assert bodies.mean_velocity(problem, 1)[1] > 0.3 and bodies.mean_velocity(problem, 2)[1] < -0.3


def test_nodes_that_are_pressed_through_are_told():
    """Blocks with more energy than the ring can take: no surface is passed silently."""
    problem = crushed_ring(3.0).problem(0.2)
    with pytest.raises(RuntimeError, match="was pressed through the surface that held it back"):
        problem.advance(until=0.8, progress=False)


def test_named_pairs_win():
    """Where a pair is named its springs act, and general contact adds none."""
    runs = []
    for more in (False, True):
        bodies = plane_blocks("quadrilateral")
        contact = [di.Penalty(di.ContactPair(faces_of_blocks(bodies), 1, 2))]
        contact += [di.GeneralContact(bodies.tags)] if more else []
        problem = bodies.problem(contact=contact)
        problem.advance(until=0.2, progress=False)
        runs.append(problem)
    general = runs[1].contact[1]
    assert isinstance(general.pair, GeneralSurface) and not np.any(general.traction)
    # Nodes have other numbers, and sums another order.
    np.testing.assert_allclose(runs[1].u.x.array, runs[0].u.x.array, atol=1e-13)


def test_given_tags_alone_touch():
    bodies = plane_blocks("quadrilateral")
    problem = bodies.problem(contact=[di.GeneralContact(bodies.tags, tags=[1])])
    problem.advance(until=0.1, progress=False)
    assert bodies.mean_velocity(problem, 1)[1] == pytest.approx(-1.0, abs=1e-12)
    both = bodies.problem(contact=[di.GeneralContact(faces_of_blocks(bodies), tags=(1, 2))])
    both.advance(until=0.1, progress=False)
    assert bodies.mean_velocity(both, 1)[1] > -0.7


def test_results():
    bodies = plane_blocks("triangle")
    problem = bodies.problem(0.2)
    problem.advance(until=0.05, progress=False)
    contact = problem.contact[0]
    n = len(contact.nodes)
    shapes = {"gap": (n,), "normal": (n, 2), "pressure": (n,), "traction": (n, 2), "slip": (n, 2), "status": (n,)}
    for name, shape in shapes.items():
        assert getattr(contact, name).shape == shape, name
    assert contact.num_springs[0] == np.sum(contact.status > 0) == np.sum(np.isfinite(contact.gap)) > 0
    assert np.all(contact.pressure >= 0.0) and contact.pressure.max() > 0.0
    assert 0.5 < contact.area < 3.0 and contact.stored > 0.0
    assert contact._general.num_candidates[0] > 0 and contact._general.num_candidates[1] == 0
    assert contact._general.energy()["stored"] == pytest.approx(contact.stored)
    np.testing.assert_allclose(np.linalg.norm(contact.normal, axis=1), 1.0, rtol=1e-12)
    field = contact.field(problem, contact.pressure, "pressure")
    assert field.x.array.max() == contact.pressure.max()
    assert "general contact" in repr(contact) and "all outer facets" in repr(di.GeneralContact(bodies.tags))
    assert "tags [1]" in repr(di.GeneralContact(bodies.tags, tags=1))


def test_bodies_that_overlap_at_the_start_are_refused():
    bodies = Flying(
        [((2, 2), box((0.0, 0.0), (1.0, 1.0)), (0.0, 0.0)), ((2, 2), box((0.1, 0.9), (1.1, 1.9)), (0.0, 0.0))],
        "quadrilateral",
    )
    with pytest.raises(ValueError, match="lie deeper in another body than a twentieth of a cell"):
        bodies.problem().advance(until=0.1, progress=False)


def test_what_it_is_not_for():
    m = mesh.create_unit_square(MPI.COMM_SELF, 2, 2)
    m.topology.create_connectivity(1, 2)
    facets = mesh.exterior_facet_indices(m.topology)
    tags = mesh.meshtags(m, 1, facets, np.ones(len(facets), dtype=np.int32))
    law = di.LinearElastic(1.0, 0.3, 1.0, "plane_strain")
    general = di.GeneralContact(tags)
    u, curved = (fem.Function(fem.functionspace(m, ("Lagrange", degree, (2,)))) for degree in (1, 2))
    with pytest.raises(ValueError, match="needs straight facets"):
        di.ExplicitProblem(curved, law, contact=[general])
    with pytest.raises(ValueError, match="several GeneralContact"):
        di.ExplicitProblem(u, law, contact=[general, di.GeneralContact(tags)])


@pytest.mark.slow
def test_heap_of_blocks():
    """Thirty blocks, turned at random, that fly at each other and tumble."""
    random = np.random.default_rng(7)
    bodies = []
    for k in range(30):
        place = np.array([1.9 * (k % 3), 1.9 * (k // 3 % 3), 1.9 * (k // 9)])
        turn = rotation(random.normal(size=3), random.uniform(0.0, 2.0))
        velocity = 0.15 * (np.array([1.9, 1.9, 2.9]) - place) + random.uniform(-0.1, 0.1, 3)
        bodies.append(((2, 2, 2), box(place - 0.5, place + 0.5, turn), velocity))
    heap = Flying(bodies, "hexahedron")
    problem, deep, nodes, edges = run(heap, 12.0, friction=0.3, part=0.5)
    assert nodes > 20 and edges > 10 and deep < 0.06
