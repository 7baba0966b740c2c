# SPDX-License-Identifier: MIT
"""Friction at nodes whose displacement is prescribed in part: blocks pushed by a whole side, planes of symmetry."""

import numpy as np
import pytest
from contact_model import Model, tangential
from dolfinx import fem

import dolfinx_impact as di

FRICTION, E, LOAD = 0.25, 1e3, 1e-3
BASES = {
    "dual": di.Lagrange,
    "standard": lambda pair: di.Lagrange(pair, basis="standard"),
    "linear": lambda pair: di.Lagrange(pair, basis="linear"),
    "penalty": di.Penalty,
}
CASES = [
    ("rigid", "dual", 1, 2),
    ("rigid", "dual", 2, 2),
    ("rigid", "dual", 1, 3),
    ("rigid", "penalty", 1, 2),
    ("rigid", "penalty", 1, 3),
    ("block", "dual", 1, 2),
    ("block", "dual", 2, 2),
    ("block", "dual", 1, 3),
    ("block", "standard", 1, 2),
    ("block", "standard", 1, 3),
    ("block", "linear", 2, 2),
    ("block", "penalty", 1, 2),
    ("block", "penalty", 1, 3),
]
cases = pytest.mark.parametrize("on, basis, degree, dim", CASES, ids=["-".join(map(str, c)) for c in CASES])


class Pushed:
    """A block under a dead load, pushed along x by all nodes of its left side, those of the contact as well.

    Args:
        on: "rigid" or "block", what it lies on. slope: of the interface, dy/dx (in space: dz/dx).
    """

    def __init__(self, on, basis, degree, dim, slope=0.0):
        law = di.LinearElastic(E, 0.0, hypothesis="3d" if dim == 3 else "plane_strain")
        up = np.eye(dim)[-1]
        if on == "rigid":
            size, cells = ((1.0, 0.5), (6, 3)) if dim == 2 else ((1.0, 0.8, 0.5), (4, 3, 2))
            m = Model("block", law, degree, size=size, cells=cells)
            normal = up - slope * np.eye(dim)[0]
            pair, left = m.pair("bottom", di.RigidPlane([0] * dim, normal), friction=FRICTION), "left"
        else:
            sizes = (((2.0, 0.5), (1.0, 0.5)), ((9, 3), (5, 2))) if dim == 2 else (
                ((2.0, 1.6, 0.5), (1.0, 0.8, 0.5)), ((6, 5, 2), (4, 3, 2)))  # fmt: skip
            names = ("lower", "upper", "lower_cells", "upper_cells")
            m = Model("two_blocks", law, degree, **dict(zip(names, (*sizes[0], *sizes[1]))))
            m.hold("bottom")
            pair, left = m.pair(friction=FRICTION), "slave_left"
        x = m.mesh.geometry.x
        x[:, dim - 1] += slope * x[:, 0]
        self.push, self.load = m.hold(left, 0), m.pull("top", -LOAD * up)
        if dim == 3:
            m.hold(left, 1)
        self.model, self.problem = m, m.problem(BASES[basis](pair))
        self.contact = self.problem.contact[0]

    def go(self, shift, steps=2):
        self.push.value = shift
        report = self.problem.solve(steps=steps, rtol=1e-12)
        assert report.cut_backs == 0 and max(report.iterations) <= 12, report.table()
        return -self.contact.force[0] / self.contact.force[-1]


@pytest.mark.covering(2)
@pytest.mark.parametrize("slope", (0.0, 0.05, 0.3))
@cases
def test_a_pushed_block_has_all_of_its_friction(on, basis, degree, dim, slope):
    """Horizontal over vertical force is (slope + friction)/(1 - slope friction), every node slips."""
    block = Pushed(on, basis, degree, dim, slope)
    # Round-off, see below; a deformable master's surface tilts by load over stiffness, 1e-6, more at the block's edges.
    limit = 1e-8 if on == "rigid" else 1e-5
    for shift, friction in ((0.02, FRICTION), (0.03, FRICTION), (0.02, -FRICTION)):
        before = block.contact.dissipated
        ratio = block.go(shift)
        assert ratio == pytest.approx((slope + friction) / (1 - slope * friction), rel=limit)
        touching = block.contact.status > 0
        assert np.all(block.contact.status[touching] == di.ContactStatus.slip)
        # Forces of a block that has moved as a whole are round-off of stiffness times displacement: 1e-8 of this load.
        p = block.contact.pressure
        size = np.linalg.norm(tangential(block.contact), axis=1)
        np.testing.assert_allclose(size, FRICTION * p, rtol=0, atol=1e-8 * p.max())
    way = 0.01 * np.hypot(1.0, slope)
    normal = np.linalg.norm(block.contact.force) / np.hypot(1.0, FRICTION)
    assert block.contact.dissipated - before == pytest.approx(FRICTION * normal * way, rel=0.01)


@pytest.mark.parametrize("on, basis", [("rigid", "dual"), ("rigid", "penalty"), ("block", "dual"), ("block", "linear")])
@pytest.mark.parametrize("dim", (2, 3))
def test_a_block_that_is_pushed_and_then_held_keeps_its_friction(on, basis, dim):
    """In an increment in which nothing is prescribed to move, tractions stay; where the pressure falls, they fall with
    the bound; with the pressure gone they are gone."""
    block = Pushed(on, basis, 1, dim, slope=0.05)
    pushed = block.go(0.02)
    before = block.contact.traction.copy()
    assert block.go(0.02, steps=1) == pytest.approx(pushed, rel=1e-8)
    np.testing.assert_allclose(block.contact.traction, before, rtol=0, atol=1e-7 * np.abs(before).max())
    block.load.constant.value = 0.5 * block.load.constant.value
    block.go(0.02, steps=1)
    p, t = block.contact.pressure, np.linalg.norm(tangential(block.contact), axis=1)
    assert np.all(t <= FRICTION * p + 1e-8 * p.max()) and t.sum() > 0.5 * FRICTION * p.sum()


@pytest.mark.parametrize("method", ("dual", "linear"))
@pytest.mark.parametrize("slope", (0.0, 0.2))
def test_nothing_rubs_on_a_plane_of_symmetry(method, slope):
    """Half a block on half of another one, x = 0 their plane of symmetry, pressed so that they slip outside: the node
    on the plane has no friction, although the mean slip beside it is none; it converges where the interface is inclined
    to the plane by more than 5 degrees as well."""
    stiff, soft = (di.LinearElastic(e, 0.3, hypothesis="plane_strain") for e in (10 * E, E))
    m = Model("two_blocks", {"master_body": stiff, "slave_body": soft}, lower_cells=(9, 4), upper_cells=(7, 4))
    x = m.mesh.geometry.x
    x[:, 1] += slope * x[:, 0]
    m.hold("bottom", 1)
    left = m.V.sub(0).collapse()[0]
    m.bcs.append(
        fem.dirichletbc(fem.Function(left), fem.locate_dofs_geometrical((m.V.sub(0), left), at_the_plane), m.V.sub(0))
    )
    push = m.hold("top", 1)
    problem = m.problem(BASES[method](m.pair(friction=0.05)))
    push.value = -0.01
    report = problem.solve(steps=2)
    assert report.cut_backs == 0
    c = problem.contact[0]
    on_plane = np.abs(c.points[:, 0]) < 1e-9
    size = np.linalg.norm(tangential(c), axis=1)
    assert on_plane.sum() == 1 and c.pressure[on_plane] > 0.0
    # Round-off of the traction's normal part, and of positions.
    assert size[on_plane] < 1e-12 * c.pressure.max() and np.abs(c.slip[on_plane]).max() < 1e-15
    assert np.count_nonzero(c.status == di.ContactStatus.slip) >= 3, "beside it they do"
    if slope == 0.0:
        np.testing.assert_allclose(c.normal[on_plane], [[0.0, 1.0]], atol=1e-15)


def at_the_plane(x):
    return np.isclose(x[0], 0.0)
