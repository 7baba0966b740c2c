# SPDX-License-Identifier: MIT
"""Static solves of bodies that are apart and that contact alone can hold; see on_ranks.py: cells are scattered."""

import re

import numpy as np
import pytest
from box_bodies import Boxes
from dolfinx import fem

import dolfinx_impact as di

FORCE = 3.0  # of the loads, per area
METHODS = {
    "multipliers": di.Lagrange,
    "saddle point": lambda pair: di.Lagrange(pair, basis="standard"),
    "penalty": lambda pair: di.Penalty(pair, penalty=1e5),
    "augmented": lambda pair: di.Penalty(pair, penalty=1e5, augmented=True),
    "law": lambda pair: di.Penalty(pair, law=di.interface.linear_pressure(1e5)),
}


def solve(problem, **options):
    return problem.solve(progress=False, **options)


def box(dim, low, high, cells=2):
    """Box from its ranges along the first and the last axis; it is one wide along the middle one."""
    middle = ([0.0], [1.0]) if dim == 3 else ([], [])
    return ((low[0], *middle[0], low[1]), (high[0], *middle[1], high[1]), (cells,) * dim)


class Tower:
    """Blocks on each other with gaps, which move up and down only, between a floor and, if wanted, a ceiling.

    Args:
        dim: 2 or 3. count: blocks, each of height 1. gap: below each. method: of METHODS. master: the floor is a block
            that is held instead of a plane. ceiling: distance of a plane from the highest block.
    """

    def __init__(self, dim, count, gap, method, master=False, ceiling=None, held=True, hypothesis=None):
        self.up, self.dim, self.gap = dim - 1, dim, gap
        x0 = 0.0 if hypothesis == "axisymmetric" else 0.3
        boxes = [box(dim, (x0, k + (k + 1) * gap), (x0 + 1.0, k + 1 + (k + 1) * gap), 1 + k) for k in range(count)]
        if master:
            boxes.append(box(dim, (x0 - 0.0 * x0, -1.0), (x0 + 1.3, 0.0), 2))
        m = self.m = Boxes(boxes, "quadrilateral" if dim == 2 else "hexahedron")
        ends = [(k + (k + 1) * gap, k + 1 + (k + 1) * gap) for k in range(count)]
        surfaces = {1 + 2 * k: (k, self.up, low) for k, (low, _) in enumerate(ends)}
        surfaces |= {2 + 2 * k: (k, self.up, high) for k, (_, high) in enumerate(ends)}
        if master:
            surfaces[0] = (count, self.up, 0.0)
        self.tags = m.tags(surfaces)
        normal = (*(0.0,) * self.up, 1.0)
        floor = 0 if master else di.RigidPlane((0.0,) * dim, normal)
        make = METHODS[method]
        pairs = [di.ContactPair(self.tags, 1, floor)]
        pairs += [di.ContactPair(self.tags, 1 + 2 * k, 2 * k) for k in range(1, count)]
        if ceiling is not None:
            place = (*(0.0,) * self.up, ends[-1][1] + ceiling)
            pairs.append(di.ContactPair(self.tags, 2 * count, di.RigidPlane(place, tuple(-c for c in normal))))
        bcs = []
        for k in range(count if held else 0):
            bcs += m.hold(k, 0, x0, *range(self.up))
        if master:
            bcs += m.hold(count, self.up, -1.0, *range(dim))
        self.load = di.Traction(self.tags, 2 * count, tuple(-FORCE * c for c in normal))
        law = m.law if hypothesis is None else di.LinearElastic(1e3, 0.0, 1.0, hypothesis)
        self.problem = di.StaticProblem(m.u, law, bcs=bcs, loads=[self.load], contact=[make(p) for p in pairs])
        self.area = np.pi if hypothesis == "axisymmetric" else 1.0  # Boxes are as deep as wide

    def check(self, report, bodies, contact=0, sign=1.0):
        """As many bodies have moved, one contact bears the load, free nodes are in balance."""
        (moved,) = report.brought_together
        assert len(re.findall(r"the body around", moved)) == bodies, moved
        found = self.problem.contact[contact].force[self.up]
        assert found == pytest.approx(sign * FORCE * self.area, rel=1e-8)  # the solver's rtol, and sums
        assert self.m.imbalance(self.problem) < 1e-8 * FORCE * self.area


def check_a_block_falls_on_what_bears_it():
    """By each method, in the plane, in space and axisymmetric, on a plane and on another block: the displacement is
    that of the same block without a gap, less the gap."""
    cases = [(dim, master, None) for dim in (2, 3) for master in (False, True)]
    cases += [(2, False, "axisymmetric"), (2, True, "axisymmetric")]
    for k, method in enumerate(METHODS):
        for j, (dim, master, hypothesis) in enumerate(cases):
            if method == "saddle point" and not master:
                continue  # against planes multipliers are nodal, and condensed
            if (k + j) % 3 == 0 or (method, dim) == ("multipliers", 2):
                tower = Tower(dim, 1, 0.3, method, master, hypothesis=hypothesis)
                touching = Tower(dim, 1, 0.0, method, master, hypothesis=hypothesis)
                tower.check(solve(tower.problem, steps=2), 1)
                if method == "law":
                    continue  # it has no force where bodies only touch
                assert not solve(touching.problem).brought_together
                # both are solutions of one system: rtol times its condition number
                assert tower.m.lowest(tower.up) == pytest.approx(touching.m.lowest(tower.up) - 0.3, abs=1e-8)


def check_blocks_stack_up():
    """Three blocks of which the load pushes the highest: each falls on the next one, and all on the floor."""
    for dim, method, cells in ((2, "penalty", 3), (3, "multipliers", 2)):
        tower = Tower(dim, cells, 0.2, method)
        tower.check(solve(tower.problem), cells)
        for contact in tower.problem.contact:
            assert abs(contact.force[tower.up]) == pytest.approx(FORCE, rel=1e-8)


def check_a_block_goes_from_the_floor_to_the_ceiling():
    """Contact holds on one side: a load upward takes the block away from the floor, after a load downward, too."""
    for method in ("multipliers", "penalty"):
        for before in (False, True):
            tower = Tower(2, 1, 0.0, method, ceiling=0.25)
            if before:
                assert not solve(tower.problem).brought_together
            tower.load.constant.value[:] = (0.0, FORCE)
            tower.check(solve(tower.problem), 1, contact=1, sign=-1.0)
            assert tower.problem.contact[0].force[1] == 0.0


def check_a_block_slides_to_a_wall():
    """On a floor without friction, pushed down and towards a wall that is apart: it slides, and touches both."""
    for method in ("multipliers", "penalty"):
        m = Boxes([box(2, (0.0, 0.0), (1.0, 1.0), 3)], "triangle")
        tags = m.tags({1: (0, 1, 0.0), 2: (0, 0, 1.0), 3: (0, 1, 1.0), 4: (0, 0, 0.0)})
        pairs = [di.ContactPair(tags, 1, di.RigidPlane((0, 0), (0, 1)))]
        pairs += [di.ContactPair(tags, 2, di.RigidPlane((1.4, 0), (-1, 0)))]
        loads = [di.Traction(tags, 3, (0.0, -2.0)), di.Traction(tags, 4, (1.0, 0.0))]
        problem = di.StaticProblem(m.u, m.law, loads=loads, contact=[METHODS[method](p) for p in pairs])
        (moved,) = solve(problem).brought_together
        assert "by 0.4 along (1, 0)" in moved, moved
        assert problem.contact[0].force[1] == pytest.approx(2.0, rel=1e-8)
        assert problem.contact[1].force[0] == pytest.approx(-1.0, rel=1e-8)


def refused(problem):
    """Text of the error of a solve, which is that of all ranks, and after which nothing has moved."""
    with pytest.raises(RuntimeError) as caught:
        solve(problem)
    assert np.all(problem.u.x.array == 0.0)
    comm = problem.space.mesh.comm
    assert all(text == str(caught.value) for text in comm.allgather(str(caught.value)))
    return str(caught.value)


def check_what_is_not_unique_is_said():
    """Free to slide or to turn, no load, nothing in the way: an error with a sentence, and nothing has moved."""
    for method in ("multipliers", "penalty"):
        text = refused(Tower(2, 1, 0.1, method, held=False).problem)
        assert "free to move along x" in text and "not brought together: the body around" in text, text
        text = refused(Tower(3, 1, 0.1, method, held=False).problem)
        assert "may turn" in text or "more than one direction" in text, text
        tower = Tower(2, 1, 0.1, method)
        tower.load.constant.value[:] = (0.0, 0.0)
        assert "no load moves what is free" in refused(tower.problem)
        tower.load.constant.value[:] = (0.0, 1.0)
        assert "meets nothing that bears it" in refused(tower.problem)


def check_a_hinged_block_is_told_to_turn():
    """A block that one point of a support leaves free to turn: it is not moved as if it were free to fall."""
    m = Boxes([box(2, (0.0, 0.1), (1.0, 1.1), 2)], "quadrilateral")
    tags = m.tags({1: (0, 1, 0.1), 2: (0, 1, 1.1)})
    corner = fem.locate_dofs_geometrical(m.V, lambda x: np.isclose(x[0], 0.0) & np.isclose(x[1], 0.1))
    problem = di.StaticProblem(
        m.u, m.law, bcs=[fem.dirichletbc(np.zeros(2), corner, m.V)], loads=[di.Traction(tags, 2, (0.0, -1.0))],
        contact=[di.Penalty(di.ContactPair(tags, 1, di.RigidPlane((0, 0), (0, 1))))],
    )  # fmt: skip
    assert "the loads turn the body around (0.5, 0.6)" in refused(problem)
