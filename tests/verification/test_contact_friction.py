# SPDX-License-Identifier: MIT
"""A block pressed on a rigid plane or on another block and pushed along it: stick, onset of slip, sliding, and back."""

import numpy as np
import pytest
from contact_model import Model, assert_coulomb, enforce

import dolfinx_impact as di

FRICTION, E, PRESSED = 0.3, 1e3, 0.01
CASES = [
    ("rigid", "Lagrange", 1, 2),
    ("rigid", "Lagrange", 2, 2),
    ("rigid", "Penalty", 1, 2),
    ("rigid", "Penalty", 2, 2),
    ("rigid", "Penalty", 1, 3),
    ("block", "Lagrange", 1, 2),
    ("block", "Lagrange", 2, 2),
    ("block", "Penalty", 1, 2),
    ("block", "Penalty", 2, 2),
    ("block", "Penalty", 1, 3),
]
cases = pytest.mark.parametrize("on, method, degree, dim", CASES, ids=["-".join(map(str, c)) for c in CASES])


class Block:
    """A block under a stiff plate that is pressed down and then shifted; `contact` after every solve is checked."""

    def __init__(self, on, method, degree, dim):
        law = di.LinearElastic(E, 0.3, hypothesis="3d" if dim == 3 else "plane_strain")
        if on == "rigid":
            size, cells = ((1.0, 0.5), (6, 3)) if dim == 2 else ((1.0, 0.8, 0.5), (4, 3, 2))
            m = Model("block", law, degree, size=size, cells=cells)
            pair = m.pair("bottom", di.RigidPlane([0] * dim, [0] * (dim - 1) + [1]), friction=FRICTION)
        else:
            sizes = (((2.0, 0.5), (1.0, 0.5)), ((9, 3), (5, 2))) if dim == 2 else (
                ((2.0, 1.6, 0.5), (1.0, 0.8, 0.5)), ((6, 5, 2), (4, 3, 2)))  # fmt: skip
            names = ("lower", "upper", "lower_cells", "upper_cells")
            m = Model("two_blocks", law, degree, **dict(zip(names, (*sizes[0], *sizes[1]))))
            m.hold("bottom")
            pair = m.pair(friction=FRICTION)
        self.down, self.shift = m.hold("top", dim - 1), m.hold("top", 0)
        if dim == 3:
            m.hold("top", 1)
        self.model, self.problem = m, m.problem(enforce(method, pair))
        self.contact = self.problem.contact[0]
        self.iterations, self.area = [], 0.8 if dim == 3 else 1.0
        self.press(PRESSED)

    def press(self, depth, atol=0.0):
        self.down.value = -depth
        self.iterations += self.problem.solve(atol=atol).iterations

    def push(self, shift, parts=1):
        """Shift the plate; returns friction force over normal force, positive against +x."""
        start = self.shift.value.item()
        for k in range(parts):
            before = self.contact.slip.copy()
            self.shift.value = start + (shift - start) * (k + 1) / parts
            report = self.problem.solve(rtol=1e-12)  # so that pressures are good to 1e-10
            self.iterations += report.iterations
            if report.cut_backs == 0:  # else `before` is not where the last increment began
                assert_coulomb(self.contact, self.contact.slip - before)
        force = self.contact.force
        # Equilibrium: what the plate gives is what the contact takes, to the tolerance of Newton's method.
        plate = self.model.support(self.problem, "top")
        np.testing.assert_allclose(plate, -force, rtol=0, atol=1e-9 * np.abs(force).max())
        return -force[0] / force[-1]


@cases
def test_stick_slip_and_back(on, method, degree, dim):
    block = Block(on, method, degree, dim)
    status, normal = block.contact.status, block.contact.force[-1]
    assert normal > 0.5 * E * PRESSED * block.area and np.any(status == di.ContactStatus.stick)
    small = block.push(0.001)
    assert 0 < small < 0.5 * FRICTION and np.any(block.contact.status == di.ContactStatus.stick)
    # Linear while the rim of the contact keeps its state: twice the shift, twice the force.
    assert block.push(0.002) == pytest.approx(2 * small, rel=0.03)
    assert FRICTION / 2 < block.push(0.008, 2) < FRICTION  # part of it slips
    assert np.unique(block.contact.status[block.contact.status > 0]).tolist() == [1, 2]
    # All of it: friction times normal force, however far it goes. A deformable master's face is not
    # quite level, and in space slips at the sides are not quite along x.
    limit = pytest.approx(FRICTION, rel=1e-9 if on == "rigid" and dim == 2 else 5e-3)
    for shift in (0.03, 0.035):
        before = block.contact.dissipated
        assert block.push(shift, 3) == limit
        assert not np.any(block.contact.status == di.ContactStatus.stick)
    # Sliding as a whole takes friction times normal force times way.
    work = block.contact.dissipated - before
    assert work == pytest.approx(
        FRICTION * block.contact.force[-1] * 0.005, rel=1e-9 if on == "rigid" and dim == 2 else 1e-2
    )
    # A little back: nearly everything sticks, with nearly the stiffness that the sticking block had at first.
    back = block.push(0.0345)
    touching = block.contact.status > 0
    assert np.count_nonzero(block.contact.status == di.ContactStatus.stick) > 0.6 * np.count_nonzero(touching)
    assert (FRICTION - back) / 0.0005 == pytest.approx(small / 0.001, rel=0.15)
    assert -block.push(0.005, 4) == limit
    # Newton's method with the active set: no more than ten linear solutions for an increment.
    assert max(block.iterations) <= 10


@cases
def test_the_path_matters(on, method, degree, dim):
    """The same plate position, reached straight and by way of a push and return: the second is left with a force."""
    straight, detour = Block(on, method, degree, dim), Block(on, method, degree, dim)
    assert abs(straight.push(0.0)) < 1e-6
    detour.push(0.01, 4)
    left = detour.push(0.0, 4)
    assert left < -0.02  # a tenth of the limit
    # Repeated, the cycle closes on itself: shakedown to a loop.
    detour.push(0.01, 4)
    assert detour.push(0.0, 4) == pytest.approx(left, rel=0.02)


@cases
def test_open_contact_forgets(on, method, degree, dim):
    """Pushed, lifted and pressed again: nothing is left of the push."""
    block = Block(on, method, degree, dim)
    fresh, pressure = block.contact.force.copy(), block.contact.pressure.copy()
    block.push(0.005, 2)
    block.press(-0.001)
    assert np.all(block.contact.status == di.ContactStatus.open) and not np.any(block.contact.force)
    assert not np.any(block.contact.slip)
    block.shift.value = 0.0
    block.press(0.0, atol=1e-9 * fresh[-1])  # just touching
    np.testing.assert_allclose(block.model.u.x.array, 0.0, atol=1e-10)
    block.press(PRESSED)
    np.testing.assert_allclose(block.contact.force, fresh, rtol=0, atol=1e-8 * fresh[-1])
    np.testing.assert_allclose(block.contact.pressure, pressure, rtol=0, atol=1e-7 * pressure.max())


@pytest.mark.parametrize("method", ["Lagrange", "Penalty"])
@pytest.mark.parametrize("direction", [(1.0, 0.0), (0.6, 0.8), (-0.8, 0.6)])
def test_traction_patch(method, direction):
    """Uniform shear below the limit on a block that sticks: uniform tractions, also on a slope; above it, it slides.

    Tractions of the uniform stress act on all other sides, so that the stress is the same everywhere."""
    pressure, shear = 20.0, 0.25 * 20.0
    law = di.LinearElastic(E, 0.0, hypothesis="plane_strain")  # sticking, it may not widen
    m = Model("block", law, size=(1.0, 0.5), cells=(5, 3))
    stress = np.array([[0.0, shear], [shear, -pressure]])
    x = m.mesh.geometry.x
    turn = np.array([[direction[0], -direction[1]], [direction[1], direction[0]]])
    x[:, :2] = x[:, :2] @ turn.T
    stress = turn @ stress @ turn.T
    for side, normal in (("top", (0, 1)), ("left", (-1, 0)), ("right", (1, 0))):
        m.pull(side, stress @ turn @ np.array(normal, dtype=float))
    pair = m.pair("bottom", di.RigidPlane((0, 0), turn @ (0.0, 1.0)), friction=FRICTION)
    problem = m.problem(enforce(method, pair, **({"penalty": 1e5} if method == "Penalty" else {})))
    problem.solve()
    contact = problem.contact[0]
    # Both enforcements hold a uniform traction: to the tolerance of Newton's method.
    np.testing.assert_allclose(contact.pressure, pressure, rtol=1e-8)
    expected = np.tile(-stress @ turn @ (0.0, 1.0), (len(contact.pressure), 1))
    np.testing.assert_allclose(contact.traction, expected, rtol=0, atol=1e-8 * pressure)
    assert np.all(contact.status == di.ContactStatus.stick)
    assert_coulomb(contact)
    for load in m.loads:  # a third more shear is above the limit: nothing holds the block
        side = stress + 0.3 * shear * turn @ np.array([[0, 1], [1, 0]]) @ turn.T
        load.constant.value[:] = side @ np.linalg.solve(stress, load.constant.value)
    with pytest.raises(RuntimeError, match="rigid motion|did not converge"):
        problem.solve(cut_backs=0)
