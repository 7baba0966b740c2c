# SPDX-License-Identifier: MIT
"""Contact that finds itself in static and implicit problems, on the ranks of COMM_WORLD."""

import tempfile
from pathlib import Path

import numpy as np
from box_bodies import CELLS, Boxes
from dolfinx import fem
from flying_bodies import Flying, box, rotation
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact.contact.penalty.static_general import StaticGeneral

COMM = MPI.COMM_WORLD
PRISM = ((2, 2, 6), ((-0.2, -0.2, -0.6), (0.2, 0.2, 0.6)))
HALF = 0.2 * np.sqrt(2.0)  # of a prism's height when it stands on an edge


def prisms(gap=1e-3, cell="hexahedron", along=0.0):
    """Two prisms that lie crosswise, edge on edge: no point of one comes near a facet of the other.

    Args:
        along: place where they cross, from the middle of both, where they have nodes.
    """
    bodies = []
    for k, axis in enumerate(((1, 0, 0), (0, 1, 0))):
        on_edge = rotation((0, 0, 1), np.pi / 4)  # about the long axis
        lie = rotation(np.cross((0, 0, 1), axis), np.pi / 2)
        up = np.array([along * (1 - k), along * k, k * (2 * HALF + gap)])
        whole = box(*PRISM[1])
        bodies.append((PRISM[0], lambda p, m=lie @ on_edge, up=up, w=whole: w(p) @ m.T + up, (0.0, 0.0, 0.0)))
    return Flying(bodies, cell)


def held(bodies, where, value):
    dofs = fem.locate_dofs_geometrical(bodies.V, lambda x: where(x[2]))
    return fem.dirichletbc(np.asarray(value, dtype=float), dofs, bodies.V)


def pressed_prisms(way, friction=0.0, side=0.0, cell="hexahedron", along=0.0):
    bodies = prisms(cell=cell, along=along)
    bcs = [
        held(bodies, lambda z: z < -0.4 * HALF, (0.0, 0.0, 0.0)),
        held(bodies, lambda z: z > 2.4 * HALF, (side, 0.0, -way)),
    ]
    contact = [di.GeneralContact(bodies.tags, friction=friction)]
    return bodies, di.StaticProblem(fem.Function(bodies.V), bodies.law, bcs=bcs, contact=contact)


def two_boxes(dim, degree, cell, gap=0.0):
    """A small box on a large one, meshes that do not match, in axes that are turned."""
    low = (0.0,) * (dim - 1)
    count = 5 if dim == 2 else 3
    return Boxes(
        [
            ((*low, -1.0), (1.0,) * (dim - 1) + (0.0,), (count,) * dim),
            ((0.2,) * (dim - 1) + (gap,), (0.8,) * (dim - 1) + (0.6 + gap,), (count - 1,) * dim),
        ],
        cell,
        degree,
        turn=0.5 * np.pi if dim == 2 else 0.0,
    )


def pressed_boxes(dim, degree, cell, contact, gap=0.0, pressure=20.0):
    boxes = two_boxes(dim, degree, cell, gap)
    up = dim - 1
    tags = boxes.tags({1: (1, up, gap), 2: (0, up, 0.0), 3: (1, up, 0.6 + gap)})
    bcs = boxes.hold(0, up, -1.0, *range(dim))
    load = di.Traction(tags, 3, -pressure * boxes.axes[up])
    # The small box must not move along the face, nor turn.
    bcs += boxes.hold(1, 0, 0.2, *(c for c in range(dim) if abs(boxes.axes[up, c]) < 0.5))
    return boxes, di.StaticProblem(boxes.u, boxes.law, bcs=bcs, loads=[load], contact=contact(tags))


def _tangent_error(problem, u, start):
    """Largest difference of the tangent, in a direction, from differences of forces, over the largest derivative."""
    contact, V = problem.contact[0], problem.space
    rng = np.random.default_rng(3)
    way = fem.Function(V)
    bs, owned = V.dofmap.index_map_bs, V.dofmap.index_map.size_local
    numbers = np.concatenate([np.arange(*V.dofmap.index_map.local_range), V.dofmap.index_map.ghosts])
    values = rng.standard_normal((V.dofmap.index_map.size_global, bs))  # the same on all ranks
    way.x.array[:] = values[numbers].reshape(-1)
    contact.begin_step(start, None)

    def forces(part):
        contact.update_gap(u + part * way.x.array)
        return contact.contact_forces()

    h = 1e-7
    differences = (forces(h) - forces(-h)) / (2 * h)
    forces(0.0)
    K = contact.tangent()
    x, y = K.createVecs()
    x.array[:] = way.x.array[: owned * bs]
    K.mult(x, y)
    found = y.array.copy()
    largest = COMM.allreduce(float(np.abs(differences).max(initial=0.0)), MPI.MAX)
    error = COMM.allreduce(float(np.abs(found + differences).max(initial=0.0)), MPI.MAX)
    assert largest > 1.0
    assert COMM.allreduce(len(contact._cpp_object.contact_forces()), MPI.SUM) == V.dofmap.index_map.size_global * bs
    return error / largest


def check_tangent_of_crossed_edges():
    # Sticks, slips; in the middle of edges, and where two share the force.
    for side, along in ((0.0, 0.09), (0.004, 0.09), (0.004, 0.005)):
        for cell in ("hexahedron", "tetrahedron")[: 1 if COMM.size > 1 else 2]:
            bodies, problem = pressed_prisms(0.0, friction=0.3, cell=cell, along=along)
            rng = np.random.default_rng(2)
            start = np.zeros_like(problem.u.x.array)
            moved = start.reshape(-1, 3).copy()
            moved[bodies.body == 1] += (side, 0.3 * side, -0.006)
            moved += 1e-4 * np.sin(7.0 * bodies.X + rng.random(3))
            error = _tangent_error(problem, moved.reshape(-1), start)
            assert error < 1e-6, (cell, error)
            assert problem.contact[0].num_active >= 1


def check_tangent_of_facets():
    for dim, degree in ((2, 1), (2, 2), (3, 1)):
        for cell in CELLS[dim]:
            boxes, problem = pressed_boxes(dim, degree, cell, lambda t: [di.GeneralContact(t, friction=0.2)], gap=1e-3)
            X = boxes.V.tabulate_dof_coordinates()[:, :dim] @ boxes.axes.T
            start = np.zeros_like(problem.u.x.array)
            moved = np.zeros((len(X), dim))
            moved[X[:, -1] > 5e-4] -= 0.01 * boxes.axes[-1] + 0.003 * boxes.axes[0]
            moved += 1e-3 * np.sin(5.0 * X)
            error = _tangent_error(problem, moved.reshape(-1), start)
            assert error < 1e-6, (cell, error)


def check_boxes_carry_the_load():
    """Both ways of contact together carry the load, and the mean displacement is that of multipliers but for what the
    springs give."""
    for dim, degree in ((2, 1), (2, 2), (3, 1)):
        for cell in CELLS[dim]:
            boxes, problem = pressed_boxes(dim, degree, cell, lambda t: [di.GeneralContact(t)])
            problem.solve(progress=False)
            contact, area = problem.contact[0], 0.6 ** (dim - 1)
            on = contact.force_on(1) @ boxes.axes.T
            np.testing.assert_allclose(on[-1], 20.0 * area, rtol=1e-9)
            np.testing.assert_allclose(contact.force_on(2), -contact.force_on(1), rtol=0.0, atol=1e-9)
            assert boxes.imbalance(problem) < 1e-6
            # Pressures of both surfaces; normals turn by a hundredth, whose square does not count.
            np.testing.assert_allclose(boxes.sum(contact.pressure @ contact.weight), 2 * 20.0 * area, rtol=1e-3)
            exact, same = pressed_boxes(dim, degree, cell, lambda t: [di.Lagrange(di.ContactPair(t, 1, 2))])
            same.solve(progress=False)
            # The pressure over half of the penalty, twice: once for each way.
            give = 20.0 / contact.penalty
            lowest = [
                float(COMM.allreduce((b.u.x.array.reshape(-1, dim) @ b.axes[-1]).min(), MPI.MIN))
                for b in (boxes, exact)
            ]
            assert abs(lowest[0] - lowest[1]) < 3.0 * give + 0.01 * abs(lowest[1])


def check_a_gap_is_closed():
    """Bodies that are apart are brought together by the load."""
    boxes, problem = pressed_boxes(2, 1, "quadrilateral", lambda t: [di.GeneralContact(t)], gap=0.05)
    problem.solve(progress=False)
    on = problem.contact[0].force_on(1) @ boxes.axes.T
    np.testing.assert_allclose(on[-1], 12.0, rtol=1e-3)


def check_crossed_prisms_do_not_sink():
    bodies, problem = pressed_prisms(0.03)
    problem.solve(steps=2, progress=False)
    contact = problem.contact[0]
    upper = contact.force_on(2)
    assert upper[2] > 1.0 and contact.num_active > 0
    np.testing.assert_allclose(contact.force_on(1), -upper, rtol=0.0, atol=1e-9 * upper[2])
    assert contact.deepest < 0.1 * 0.03


def check_restart_goes_on_alike():
    """A run that is restored in the middle, with sliding edges, ends where the run without a stop does."""
    with tempfile.TemporaryDirectory() as folder:
        path = COMM.bcast(str(Path(folder) / "state.h5"), 0)
        results = []
        for restored in (False, True):
            bodies, problem = pressed_prisms(0.02, friction=0.3, side=0.0)
            upper = problem.bcs[1].g
            problem.solve(progress=False)
            problem.save(path)
            if restored:
                bodies, problem = pressed_prisms(0.02, friction=0.3, side=0.0)
                problem.restore(path)
                upper = problem.bcs[1].g
            value = getattr(upper, "value", upper)
            value[:] = (0.02, 0.0, -0.025)
            problem.solve(progress=False)
            contact = problem.contact[0]
            assert contact.dissipated > 1e-4
            results.append((problem.u.x.array.copy(), contact.dissipated, contact.deepest))
        np.testing.assert_allclose(results[1][0], results[0][0], rtol=0.0, atol=1e-9)
        np.testing.assert_allclose(results[1][1:], results[0][1:], rtol=1e-6)


def check_both_sides_of_a_thin_plate():
    """A plate one cell thick between two blocks: the far side of it is no contact."""
    boxes = Boxes(
        [
            ((0.0, -0.5), (1.0, 0.0), (4, 2)),
            ((-0.5, 0.0), (1.5, 0.04), (20, 1)),
            ((0.0, 0.04), (1.0, 0.54), (5, 2)),
        ],
        "quadrilateral",
    )
    tags = boxes.tags({1: (0, 1, 0.0), 2: (2, 1, 0.04), 3: (2, 1, 0.54)})
    bcs = boxes.hold(0, 1, -0.5, 0, 1) + boxes.hold(2, 1, 0.54, 0) + boxes.hold(1, 0, -0.5, 0)
    problem = di.StaticProblem(
        boxes.u, boxes.law, bcs=bcs, loads=[di.Traction(tags, 3, (0.0, -10.0))], contact=[di.GeneralContact(tags)]
    )
    problem.solve(progress=False)
    contact = problem.contact[0]
    # The plate is held on its left and bends a little.
    np.testing.assert_allclose(contact.force_on(2), (0.0, 10.0), atol=1e-2)
    np.testing.assert_allclose(contact.force_on(1), (0.0, -10.0), atol=1e-2)
    assert contact.deepest < 1e-3


def check_implicit_impact():
    """Two free blocks that fly at each other and part; the balance of energies gets better with the step."""
    drifts = []
    for dt in (0.00125, 0.000625):
        bodies = Flying(
            [
                ((3, 3), box((0.0, 0.0), (1.0, 1.0)), (0.5, 0.0)),
                ((4, 4), box((1.02, 0.1), (2.02, 1.1)), (-0.5, 0.0)),
            ],
            "quadrilateral",
        )
        law = di.LinearElastic(1000.0, 0.3, density=1.0, hypothesis="plane_strain")
        problem = di.NewmarkProblem(
            fem.Function(bodies.V), law, velocity=bodies.velocity, contact=[di.GeneralContact(bodies.tags)]
        )
        problem.advance(until=0.03, dt=dt, progress=False)
        assert problem.contact[0].num_active > 0 and problem.energy["contact"] > 0.0
        problem.advance(until=0.1, dt=dt, progress=False)
        assert problem.contact[0].num_active == 0
        drifts.append(abs(problem.energy["drift"]))
        back = COMM.allreduce(float(problem.velocity.x.array.reshape(-1, 2)[bodies.body == 0, 0].sum()), MPI.SUM)
        assert back < 0.0
    # The trapezoidal rule is of second order where contact does not change.
    assert drifts[1] < 0.5 * drifts[0] < 0.01, drifts


def check_named_pairs_are_left_to_others():
    boxes, problem = pressed_boxes(
        2, 1, "triangle", lambda t: [di.GeneralContact(t), di.Lagrange(di.ContactPair(t, 1, 2))]
    )
    problem.solve(progress=False)
    general, pair = problem.contact
    assert isinstance(general, StaticGeneral) and general.kind == "general contact at quadrature points"
    assert general.num_active == 0 and pair.num_active > 0
    np.testing.assert_allclose((pair.force @ boxes.axes.T)[1], 12.0, rtol=1e-4)


def check_axisymmetric_discs():
    """Two discs on each other, of other meshes: the force is that of the full circle."""
    boxes = Boxes([((0.0, -0.5), (1.0, 0.0), (5, 3)), ((0.0, 0.0), (0.8, 0.4), (6, 3))], "quadrilateral")
    tags = boxes.tags({1: (1, 1, 0.0), 2: (0, 1, 0.0), 3: (1, 1, 0.4)})
    law = di.LinearElastic(1000.0, 0.3, hypothesis="axisymmetric")
    bcs = boxes.hold(0, 1, -0.5, 1) + boxes.hold(0, 0, 0.0, 0) + boxes.hold(1, 0, 0.0, 0)
    problem = di.StaticProblem(
        boxes.u, law, bcs=bcs, loads=[di.Traction(tags, 3, (0.0, -10.0))], contact=[di.GeneralContact(tags)]
    )
    problem.solve(progress=False)
    np.testing.assert_allclose(problem.contact[0].force_on(1)[1], 10.0 * np.pi * 0.64, rtol=1e-6)


def _refused(words, make):
    try:
        make()
    except (TypeError, ValueError) as error:
        assert words in str(error), error
    else:
        raise AssertionError(f"not refused: {words}")


def check_refusals():
    boxes = two_boxes(2, 1, "quadrilateral", gap=-0.1)
    tags = boxes.tags({1: (1, 1, -0.1), 2: (0, 1, 0.0)})
    _refused("overlap", lambda: di.StaticProblem(boxes.u, boxes.law, contact=[di.GeneralContact(tags)]))
    boxes, problem = pressed_boxes(2, 1, "quadrilateral", lambda t: [di.GeneralContact(t)])
    tags = problem.contact[0].pair.facet_tags
    _refused(
        "several GeneralContact",
        lambda: di.StaticProblem(
            fem.Function(boxes.V), boxes.law, contact=[di.GeneralContact(tags), di.GeneralContact(tags, name="other")]
        ),
    )
    _refused(
        "handed over", lambda: di.ExplicitProblem.from_static(problem, contact=[di.Penalty(di.ContactPair(tags, 1, 2))])
    )
