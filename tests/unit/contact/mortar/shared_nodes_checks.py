# SPDX-License-Identifier: MIT
"""Slave nodes that several contacts by multipliers have in common, and slave tags round sharp edges; docs/contact.md.

See on_ranks.py: cells are scattered over the ranks, so that pairs and their common nodes are split.
"""

import numpy as np
import pytest
from box_bodies import CELLS, Boxes
from mpi4py import MPI

import dolfinx_impact as di

COMM = MPI.COMM_WORLD
# Sums of a hundred forces of order one, solved to 1e-10 of the largest.
BALANCED = 1e-9
# Stresses are uniform and exact in every cell; what is left is the solution's tolerance.
PATCH = 1e-10
LEFT, RIGHT = (lambda x: x[0] < 1.0), (lambda x: x[0] > 1.0)


def on_these_ranks(rows):
    """All rows on one rank, the first and one of the middle on several: they differ in nothing but the cells."""
    rows = list(rows)
    return rows if COMM.size == 1 else [rows[0], rows[len(rows) // 2]]


def lagrange(tags, slave, master, **options):
    basis = options.pop("basis", "dual")
    return di.Lagrange(di.ContactPair(tags, slave, master, **options), basis=basis)


def forces(problem):
    """Forces of the pairs, and the largest free residual against the loads of order one is small."""
    return [np.array(c.force) for c in problem.contact]


def excess(contact, friction):
    """Largest friction traction beyond its bound, of all ranks."""
    tangential = contact.traction - contact.pressure[:, None] * contact.normal
    over = np.linalg.norm(tangential, axis=1) - friction * contact.pressure
    return contact.comm.allreduce(float(over.max(initial=0.0)), MPI.MAX)


def foot(cell, degree, facets, split=False, poisson=0.0, friction=(0.0, 0.0), side=0.0, basis="dual", steps=1):
    """A block of width 2 on two blocks of width 1 side by side, pressed with 1 per area."""
    dim = 2 if cell in CELLS[2] else 3
    low, high = (lambda *x: x if dim == 2 else (x[0], 0.0, x[1])), (lambda *x: x if dim == 2 else (x[0], 1.0, x[1]))
    count = (lambda n, m: (n, m)) if dim == 2 else (lambda n, m: (n, 2, m))
    boxes = [(low(0, 0), high(1, 1), count(2, 1)), (low(1, 0), high(2, 1), count(3, 2))]
    m = Boxes([*boxes, (low(0, 1), high(2, 2), count(facets, 1))], cell, degree, poisson=poisson)
    up = dim - 1
    surfaces = {4: (0, up, 1.0), 5: (1, up, 1.0), 8: (2, up, 2.0), 3: (2, up, 1.0)}
    if split:
        surfaces |= {3: (2, up, 1.0, LEFT), 6: (2, up, 1.0, RIGHT)}
    tags = m.tags(surfaces)
    bcs = m.hold(0, up, 0.0, *range(dim)) + m.hold(1, up, 0.0, *range(dim))
    if not any(friction):
        bcs += m.hold(2, up, 2.0, *range(up))
    pairs = [
        lagrange(tags, 3, 4, friction=friction[0], basis=basis),
        lagrange(tags, 6 if split else 3, 5, friction=friction[1], basis=basis),
    ]
    load = np.zeros(dim)
    load[0], load[up] = side, -1.0
    problem = di.StaticProblem(m.u, m.law, bcs=bcs, loads=[di.Traction(tags, 8, tuple(load))], contact=pairs)
    problem.solve(steps)
    return m, problem


def check_one_foot_on_two_masters():
    """Without lateral strain each master carries what stands on it and the foot's top sinks by p h/E, to round-off,
    whether the masters meet at a node or inside a facet of the foot, with one tag on the foot or two."""
    kinds = [(cell, degree) for cells in CELLS.values() for cell in cells for degree in (1, 2)]
    for cell, degree in on_these_ranks(kinds):
        for facets, split in ((3, False), (4, False), (4, True)):
            m, problem = foot(cell, degree, facets, split)
            for force in forces(problem):
                assert np.abs(force - np.eye(m.dim)[-1]).max() < PATCH, (cell, degree, facets, split)
            assert abs(m.lowest(m.dim - 1) + 2e-3) < PATCH * 2e-3
            pressures = np.concatenate([c.pressure[c.status > 0] for c in problem.contact])
            assert np.abs(pressures - 1.0).max(initial=0.0) < BALANCED


def check_friction_on_two_masters():
    """Bodies that bulge and are pushed aside: forces of the pairs balance the load and the supports, and no pair with a
    larger coefficient than its own."""
    rows = [("quadrilateral", 1, 5, False), ("triangle", 2, 4, True), ("hexahedron", 1, 3, False)]
    rows += [("tetrahedron", 1, 4, True)]
    more = (("dual", (0.1, 0.4)), ("linear", (0.3, 0.3)), ("standard", (0.3, 0.2)), ("dual", (0.0, 0.4)))
    for (cell, degree, facets, split), (basis, friction) in on_these_ranks(zip(rows, more)):
        m, problem = foot(cell, degree, facets, split, poisson=0.3, friction=friction, side=0.1, basis=basis)
        load = np.zeros(m.dim)
        load[0], load[-1] = -0.2, 2.0
        assert np.abs(sum(forces(problem)) - load).max() < BALANCED, (cell, basis)
        assert np.abs(m.support(problem) - load).max() < BALANCED
        assert m.imbalance(problem) < BALANCED
        nodal = m.sum(sum(c.contact_forces() for c in problem.contact).reshape(-1, m.dim).sum(axis=0))
        assert np.abs(nodal).max() < BALANCED  # on slaves and masters
        for c in problem.contact:
            assert excess(c, max(friction)) < BALANCED


def check_laws_of_friction_on_two_masters():
    """A law that is constant is the number, at nodes that pairs share as well, beside a number or another law."""
    for cell, degree, facets, split in on_these_ranks([("quadrilateral", 1, 5, False), ("triangle", 2, 4, True)]):
        first, second = (di.FrictionLaw(lambda pressure, mu=mu: mu + 0 * pressure) for mu in (0.3, 0.1))
        found = []
        for friction in ((0.3, 0.1), (first, second), (0.3, second)):
            m, _ = foot(cell, degree, facets, split, poisson=0.3, friction=friction, side=0.1)
            found.append(m.u.x.array.copy())
        assert all(np.abs(u - found[0]).max() < 1e-15 for u in found[1:]), cell


def pressed(split, master, cell, degree, friction):
    """A block on a wider one or on a plane, its foot tagged once or in two parts."""
    m = Boxes([((-0.5, -0.5), (2.5, 0), (7, 2)), ((0, 0), (2, 1), (6, 2))], cell, degree, poisson=0.3)
    surfaces = {4: (0, 1, 0.0), 8: (1, 1, 1.0), 3: (1, 1, 0.0)}
    if split:
        surfaces |= {3: (1, 1, 0.0, LEFT), 6: (1, 1, 0.0, RIGHT)}
    tags = m.tags(surfaces)
    opposite = 4 if master == "block" else di.RigidPlane((0.0, 0.0), (0.0, 1.0))
    pairs = [lagrange(tags, s, opposite, friction=friction) for s in ((3, 6) if split else (3,))]
    bcs = m.hold(0, 1, -0.5, 0, 1) + ([] if friction else m.hold(1, 1, 1.0, 0))
    load = di.Traction(tags, 8, (2.0 if friction else 0.0, -30.0))
    problem = di.StaticProblem(m.u, m.law, bcs=bcs, loads=[load], contact=pairs)
    problem.solve()
    return m, problem


def check_divided_slave_is_the_undivided_one():
    """A slave tagged in two parts that share a node gives the displacements of one tag, and the forces add up."""
    for cell, degree in on_these_ranks([("quadrilateral", 1), ("triangle", 2)]):
        for master in ("block", "plane"):
            for friction in (0.0, 0.3) if COMM.size == 1 else (0.3,):
                whole, one = pressed(False, master, cell, degree, friction)
                parts, two = pressed(True, master, cell, degree, friction)
                apart = np.abs(whole.u.x.array - parts.u.x.array).max(initial=0.0)
                assert COMM.allreduce(apart, MPI.MAX) < 1e-11 * 0.1, (cell, master, friction)
                assert np.abs(sum(forces(two)) - forces(one)[0]).max() < 60.0 * BALANCED
                assert abs(sum(c.area for c in two.contact) - one.contact[0].area) < 1e-9


def corner(cell, degree, friction, one_tag, turn=0.0):
    """A box in the corner of two rigid planes, pressed on both, in space held at one side."""
    dim = 2 if cell in CELLS[2] else 3
    up, count = dim - 1, 3 if dim == 2 else 2
    m = Boxes([(np.zeros(dim), np.ones(dim), (count,) * dim)], cell, degree, turn, poisson=0.3)
    surfaces = {8: (0, up, 1.0), 9: (0, 0, 1.0)}
    surfaces |= {3: [(0, up, 0.0), (0, 0, 0.0)]} if one_tag else {3: (0, up, 0.0), 4: (0, 0, 0.0)}
    tags = m.tags(surfaces)
    origin = np.zeros(dim)
    planes = [di.RigidPlane(origin, m.axes[up]), di.RigidPlane(origin, m.axes[0])]
    pairs = [lagrange(tags, s, p, friction=friction) for s, p in zip((3, 3 if one_tag else 4), planes)]
    loads = [di.Traction(tags, 8, tuple(-1.0 * m.axes[up])), di.Traction(tags, 9, tuple(-0.3 * m.axes[0]))]
    bcs = m.hold(0, 1, 0.0, 1) if dim == 3 else []
    problem = di.StaticProblem(m.u, m.law, bcs=bcs, loads=loads, contact=pairs)
    problem.solve()
    return m, problem


def check_corner_of_two_planes():
    """Both conditions of the corner's nodes hold: without friction each plane carries its own load; with friction they
    carry both together within the bounds, however the box is turned and tagged."""
    for cell in on_these_ranks((*CELLS[2], *CELLS[3])):
        for degree in (1, 2) if cell in CELLS[2] and COMM.size == 1 else (1,):
            for turn in (0.0, 0.4) if cell in CELLS[2] else (0.0,):
                for one_tag in (False, True):
                    m, problem = corner(cell, degree, 0.0, one_tag, turn)
                    floor, wall = forces(problem)
                    assert np.abs(floor - m.axes[-1]).max() < BALANCED, (cell, degree, turn, one_tag)
                    assert np.abs(wall - 0.3 * m.axes[0]).max() < BALANCED
            m, problem = corner(cell, degree, 0.3, False)
            total = sum(forces(problem))
            total[1:-1] = 0.0  # the support at y = 0 takes part
            assert np.abs(total - (m.axes[-1] + 0.3 * m.axes[0])).max() < BALANCED, (cell, degree)
            assert m.imbalance(problem) < BALANCED
            for c in problem.contact:
                assert excess(c, 0.3) < 1e-6


def pushed_along_the_edge(cell, push, turn=0.0):
    m = Boxes([((0, 0, 0), (1, 1, 1), (2, 2, 2))], cell, 1, turn)
    tags = m.tags({3: (0, 2, 0.0), 4: (0, 0, 0.0), 8: (0, 2, 1.0), 9: (0, 0, 1.0), 10: (0, 1, 0.0)})
    planes = [di.RigidPlane((0.0, 0.0, 0.0), m.axes[axis]) for axis in (2, 0)]
    pairs = [lagrange(tags, s, p, friction=mu) for s, p, mu in zip((3, 4), planes, (0.3, 0.2))]
    loads = [(8, -1.0 * m.axes[2]), (9, -0.5 * m.axes[0]), (10, push * m.axes[1])]
    loads = [di.Traction(tags, tag, tuple(load)) for tag, load in loads]
    problem = di.StaticProblem(m.u, m.law, loads=loads, contact=pairs)
    problem.solve(2)
    return m, problem


def check_sliding_along_the_edge_of_two_planes():
    """Along the edge the bounds of both planes add up, 0.3 + 0.2/2 of the loads: with less the box is held, in every
    position alike, with more there is no equilibrium."""
    for cell in CELLS[3] if COMM.size == 1 else CELLS[3][:1]:
        found = []
        for turn in (0.0, 0.4):
            m, problem = pushed_along_the_edge(cell, 0.39, turn)
            total = m.axes @ sum(forces(problem))
            assert np.abs(total - [0.5, -0.39, 1.0]).max() < BALANCED
            for c, friction in zip(problem.contact, (0.3, 0.2)):
                assert excess(c, friction) < 1e-6
            found.append([m.axes @ force for force in forces(problem)])
        assert np.abs(np.subtract(*found)).max() < 1e-6
    with pytest.raises(RuntimeError):
        pushed_along_the_edge("hexahedron", 0.41)


def three_blocks(cell, degree, poisson, friction):
    """A block on two, one of which is pressed aside against the other: a T of three contacts."""
    m = Boxes(
        [((0, 0), (1, 1), (3, 3)), ((1, 0), (2, 1), (4, 4)), ((0, 1), (2, 2), (4, 2))], cell, degree, 0.0, poisson
    )
    surfaces = {3: (2, 1, 1.0), 4: (0, 1, 1.0), 5: (1, 1, 1.0), 6: (0, 0, 1.0), 7: (1, 0, 1.0)}
    tags = m.tags(surfaces | {8: (2, 1, 2.0), 10: (1, 0, 2.0)})
    bcs = m.hold(0, 1, 0.0, 1) + m.hold(1, 1, 0.0, 1) + m.hold(0, 0, 0.0, 0) + m.hold(2, 0, 0.0, 0)
    pairs = [lagrange(tags, a, b, friction=friction) for a, b in ((3, 4), (3, 5), (6, 7))]
    loads = [di.Traction(tags, 8, (0.0, -1.0)), di.Traction(tags, 10, (-0.5, 0.0))]
    problem = di.StaticProblem(m.u, m.law, bcs=bcs, loads=loads, contact=pairs)
    problem.solve()
    return m, problem


def check_three_blocks_that_meet_at_a_point():
    """The nodes at the cross point are slaves and masters of several pairs: everything is in equilibrium."""
    for cell, degree in (("quadrilateral", 1), ("triangle", 2))[: 2 if COMM.size == 1 else 1]:
        for poisson, friction in ((0.0, 0.0), (0.3, 0.3)):
            m, problem = three_blocks(cell, degree, poisson, friction)
            left, right, between = forces(problem)
            assert abs(left[1] + right[1] - 2.0) < BALANCED, (cell, poisson)
            assert np.abs(m.support(problem) - [0.5, 2.0]).max() < BALANCED
            assert m.imbalance(problem) < BALANCED
            if not friction:
                assert abs(left[1] - 1.0) < 0.02
                # Bodies are pressed aside by 5e-4: the vertical forces turn by that at most.
                assert np.abs([left[0], right[0], between[1], between[0] + 0.5]).max() < 1e-3


def check_slave_of_one_pair_is_master_of_another():
    """One surface is the slave on the left block and the master of the right one: exact without lateral strain."""
    for cell, degree in on_these_ranks([("quadrilateral", 1), ("quadrilateral", 2), ("triangle", 1), ("triangle", 2)]):
        for poisson, friction in ((0.0, 0.0), (0.3, 0.3)):
            boxes = [((0, 0), (1, 1), (3, 2)), ((1, 0), (2, 1), (4, 2)), ((0, 1), (2, 2), (5, 2))]
            m = Boxes(boxes, cell, degree, poisson=poisson)
            tags = m.tags({3: (2, 1, 1.0), 4: (0, 1, 1.0), 5: (1, 1, 1.0), 8: (2, 1, 2.0)})
            bcs = m.hold(0, 1, 0.0, 0, 1) + m.hold(1, 1, 0.0, 0, 1) + m.hold(2, 1, 2.0, 0)
            pairs = [lagrange(tags, 3, 4, friction=friction), lagrange(tags, 5, 3, friction=friction)]
            problem = di.StaticProblem(m.u, m.law, bcs=bcs, loads=[di.Traction(tags, 8, (0.0, -1.0))], contact=pairs)
            problem.solve()
            on_left, on_right = forces(problem)
            assert abs(on_left[1] - on_right[1] - 2.0) < BALANCED and m.imbalance(problem) < BALANCED
            if poisson == 0.0:
                assert abs(on_left[1] - 1.0) < PATCH and abs(m.lowest(1) + 2e-3) < PATCH * 2e-3, (cell, degree)


def check_block_and_plane_under_one_foot():
    """A plane lies 5e-4 under the head of a block: the block carries E g/h, then the plane takes the rest."""
    for cell in CELLS[2] if COMM.size == 1 else CELLS[2][:1]:
        m = Boxes([((0, 0), (1, 1), (3, 2)), ((0, 1), (1, 2), (2, 2))], cell)
        tags = m.tags({3: (1, 1, 1.0), 4: (0, 1, 1.0), 8: (1, 1, 2.0)})
        pairs = [lagrange(tags, 3, 4), lagrange(tags, 3, di.RigidPlane((0.0, 1.0 - 5e-4), (0.0, 1.0)))]
        bcs = m.hold(0, 1, 0.0, 0, 1) + m.hold(1, 1, 2.0, 0)
        load = di.Traction(tags, 8, (0.0, -0.3))
        problem = di.StaticProblem(m.u, m.law, bcs=bcs, loads=[load], contact=pairs)
        problem.solve()
        assert np.abs(np.array(forces(problem))[:, 1] - [0.3, 0.0]).max() < PATCH
        load.constant.value = (0.0, -1.0)
        problem.solve()
        assert np.abs(np.array(forces(problem))[:, 1] - [0.5, 0.5]).max() < PATCH


def check_masters_one_behind_the_other():
    """A plate lies between foot and base, and both are masters of the foot: only the plate is touched."""
    m = Boxes([((0, 0), (1, 1), (3, 2)), ((0, 1), (1, 1.1), (4, 1)), ((0, 1.1), (1, 2.1), (3, 2))], "quadrilateral")
    tags = m.tags({3: (2, 1, 1.1), 4: (1, 1, 1.1), 5: (0, 1, 1.0), 6: (1, 1, 1.0), 8: (2, 1, 2.1)})
    bcs = m.hold(0, 1, 0.0, 0, 1) + m.hold(2, 1, 2.1, 0) + m.hold(1, 0, 0.0, 0)
    pairs = [lagrange(tags, 3, 5), lagrange(tags, 3, 4), lagrange(tags, 6, 5)]
    problem = di.StaticProblem(m.u, m.law, bcs=bcs, loads=[di.Traction(tags, 8, (0.0, -1.0))], contact=pairs)
    problem.solve()
    assert np.abs(np.array(forces(problem))[:, 1] - [0.0, 1.0, 1.0]).max() < PATCH


def check_what_is_over_constrained_is_named():
    """The same pair twice, each the other's master, and conditions that contradict each other."""
    m = Boxes([((0, 0), (1, 1), (3, 2)), ((0, 1), (1, 2), (4, 2))], "quadrilateral")
    tags = m.tags({3: (1, 1, 1.0), 4: (0, 1, 1.0)})
    plane = di.RigidPlane((0.0, 1.0), (0.0, 1.0))
    for given, words in (
        (((3, 4), (3, 4)), r"3 on 4 \(1\) and 3 on 4 \(2\) pair the same 4 slave facets with the same master twice"),
        (((3, plane), (3, plane)), "pair the same 4 slave facets"),
        (((3, 4), (4, 3)), "3 on 4 and 4 on 3: the slave of each is the master of the other, on 4 and 3"),
    ):
        with pytest.raises(ValueError, match=words):
            di.StaticProblem(m.u, m.law, contact=[lagrange(tags, *pair) for pair in given])
    m = Boxes([((0, 0), (1, 1), (3, 3))], "quadrilateral", poisson=0.3)
    tags = m.tags({3: (0, 1, 0.0), 4: (0, 0, 0.0)})
    overhang = di.RigidPlane((0.0, 1.0), (np.cos(0.5), -np.sin(0.5)))
    pairs = [lagrange(tags, 3, di.RigidPlane((0.0, 0.0), (0.0, 1.0)), name="floor")]
    pairs.append(lagrange(tags, 4, overhang, name="overhang"))
    bcs = m.hold(0, 0, 0.0, 0) + m.hold(0, 0, 1.0, 0)
    problem = di.StaticProblem(m.u, m.law, bcs=bcs, contact=pairs)
    overhang.displacement = (0.6, 0.0, 0.0)  # the side cannot move away, and its lower end would have to sink
    with pytest.raises(
        RuntimeError, match=r"the first at \[\[0.0, 0.0\]\], cannot .* (floor|overhang) and (floor|over)"
    ):
        problem.solve(cut_backs=1)


def check_impact_of_a_divided_slave():
    """Newmark's method: an impact on a slave in two parts is that on the undivided one, with friction."""
    ends = []
    for split in (False, True):
        m = Boxes([((0, 0), (2, 1), (5, 2)), ((0, 1.01), (2, 2), (5, 2))], "quadrilateral", poisson=0.3)
        surfaces = {4: (0, 1, 1.0), 3: (1, 1, 1.01)}
        if split:
            surfaces |= {3: (1, 1, 1.01, lambda x: x[0] < 0.8), 6: (1, 1, 1.01, lambda x: x[0] > 0.8)}
        tags = m.tags(surfaces)
        velocity = m.u.copy()
        velocity.interpolate(lambda x: np.stack([0.3 * (x[1] > 1.005), -1.0 * (x[1] > 1.005)]))
        pairs = [lagrange(tags, s, 4, friction=0.3) for s in ((3, 6) if split else (3,))]
        problem = di.NewmarkProblem(m.u, m.law, velocity=velocity, bcs=m.hold(0, 1, 0.0, 0, 1), contact=pairs)
        problem.advance(0.024, 2e-3)
        ends.append((m.u.x.array.copy(), sum(forces(problem))))
    (whole, one), (parts, two) = ends
    assert np.linalg.norm(one) > 1.0, "nothing touches"
    assert COMM.allreduce(np.abs(whole - parts).max(initial=0.0), MPI.MAX) < 1e-9
    assert np.abs(one - two).max() < 1e-6 * np.linalg.norm(one)


def box_on_floor(whole, cell, degree, rigid, friction, turn=0.0):
    """A box pressed on a floor, its slave tag the bottom alone or the sides, too."""
    dim = 2 if cell in CELLS[2] else 3
    up, count = dim - 1, 4 if dim == 2 else 2
    low, high = -0.5 * np.ones(dim), 1.5 * np.ones(dim)
    high[up] = 0.0
    floor = [] if rigid else [(low, high, (11,) * up + (2,) if dim == 2 else (5, 5, 1))]
    m = Boxes([(np.zeros(dim), np.ones(dim), (count,) * dim), *floor], cell, degree, turn, poisson=0.3)
    sides = [(0, axis, end) for axis in range(up) for end in (0.0, 1.0)] if whole else []
    surfaces = {3: [(0, up, 0.0), *sides], 8: (0, up, 1.0)}
    tags = m.tags(surfaces if rigid else surfaces | {4: (1, up, 0.0)})
    master = di.RigidPlane(np.zeros(dim), m.axes[up]) if rigid else 4
    bcs = [] if rigid else m.hold(1, up, -0.5, *range(dim))
    bcs += m.hold(0, up, 1.0, *range(up)) if turn == 0.0 else []
    load = di.Traction(tags, 8, tuple(-30.0 * m.axes[up]))
    problem = di.StaticProblem(
        m.u, m.law, bcs=bcs, loads=[load], contact=[lagrange(tags, 3, master, friction=friction)]
    )
    problem.solve()
    return m, problem


def check_slave_tags_round_sharp_edges():
    """Sides of a box that are tagged with its bottom change nothing: forces, pressures, areas and displacements are
    those of the bottom alone, although the sides bulge over the floor."""
    rows = [(cell, degree, rigid, 0.0, 0.0) for cell in CELLS[2] for degree in (1, 2) for rigid in (False, True)]
    rows += [("quadrilateral", 1, False, 0.3, 0.3), ("triangle", 2, True, 0.3, 0.3)]
    rows += [("hexahedron", 1, False, 0.0, 0.0), ("tetrahedron", 2, True, 0.0, 0.0), ("hexahedron", 2, True, 0.0, 0.0)]
    for row in on_these_ranks(rows):
        bottom, one = box_on_floor(False, *row)
        box, two = box_on_floor(True, *row)
        a, b = one.contact[0], two.contact[0]
        apart = np.abs(bottom.u.x.array - box.u.x.array).max(initial=0.0)
        assert COMM.allreduce(apart, MPI.MAX) < 1e-11, row
        most = [COMM.allreduce(float(c.pressure.max(initial=0.0)), MPI.MAX) for c in (a, b)]
        assert abs(most[0] - most[1]) < 1e-8 * most[0] and abs(a.area - b.area) < 1e-9, row
        assert np.abs(a.force - b.force).max() < 30.0 * BALANCED, row
        if row[0] == "quadrilateral" and not row[3]:
            assert np.abs(b.force - [0.0, 30.0]).max() < 30.0 * BALANCED, row


def nook(cell, degree, wall):
    """A block pressed on a floor and on a wall beside it, which are one master; its tag has both sides."""
    dim = 2 if cell in CELLS[2] else 3
    low, high = (lambda *x: x if dim == 2 else (x[0], 0.0, x[1])), (lambda *x: x if dim == 2 else (x[0], 1.0, x[1]))
    count = (lambda n, m: (n, m)) if dim == 2 else (lambda n, m: (n, 1, m))
    boxes = [(low(-1, 0), high(2, 1), count(4, 1)), (low(-1, 1), high(0, 2), count(1, 2))]
    m = Boxes([*boxes, (low(0, 1), high(1, 2), count(3, 3))], cell, degree)
    up = dim - 1
    master = [(0, up, 1.0), (1, 0, 0.0)] if wall else [(0, up, 1.0)]
    tags = m.tags({3: [(2, up, 1.0), (2, 0, 0.0)], 4: master})
    bcs = m.hold(0, up, 0.0, *range(dim)) + m.hold(1, 0, -1.0, *range(dim))
    bcs += m.hold(2, up, 2.0, up, value=-0.01) + m.hold(2, 0, 1.0, 0, value=-0.01)
    if dim == 3:
        bcs += m.hold(2, up, 2.0, 1)
    return di.StaticProblem(m.u, m.law, bcs=bcs, contact=[lagrange(tags, 3, 4)])


def check_an_edge_with_both_sides_at_the_master_is_named_where_a_solve_fails():
    """One iteration is too few. Where only the foot faces a master, the side does not count, and nothing is said."""
    for cell, degree in on_these_ranks((("quadrilateral", 1), ("hexahedron", 1), ("triangle", 2), ("tetrahedron", 2))):
        with pytest.raises(RuntimeError, match=r"the slave has an edge of (8|9)\d degrees at") as error:
            nook(cell, degree, True).solve(max_iterations=1, cut_backs=0)
        assert "leave one side out of its tag, or make a pair of each" in str(error.value)
        with pytest.raises(RuntimeError) as error:
            nook(cell, degree, False).solve(max_iterations=1, cut_backs=0)
        assert "did not converge" in str(error.value) and "edge" not in str(error.value)
