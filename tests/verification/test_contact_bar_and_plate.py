# SPDX-License-Identifier: MIT
"""Friction problems with known answers: a bar pulled along a plane, and the plate of Feijoo (GRECO, SSNV128)."""

import numpy as np
import pytest
from contact_model import Model, assert_coulomb, enforce

import dolfinx_impact as di

HEIGHT, E, AREA, NORMAL, FRICTION, FORCE = 0.005, 210e9, 1e-4, 1e4, 0.3, 1e3
PLANE = di.RigidPlane((0, 0), (0, 1))


class Bar:
    """A bar on a rough plane, guided from above so that the pressure is even; `contact` is checked after every pull.

    Friction acts on its underside, half the height away from the pull: at 1/67 of the slip length that is worth 0.3 %
    of the displacements (measured: it goes with the height).
    """

    def __init__(self, method, num, degree=1):
        law = di.LinearElastic(E, 0.0, hypothesis="plane_stress")
        self.model = m = Model("block", law, degree, size=(0.5, HEIGHT), cells=(num, 2))
        m.hold("right", 0)
        m.hold("top", 1, value=-NORMAL * HEIGHT / AREA * HEIGHT / E)
        self.end = m.pull("left", (0.0, 0.0))
        self.problem = m.problem(enforce(method, m.pair("bottom", PLANE, friction=FRICTION)))
        self.contact = self.problem.contact[0]
        self.problem.solve()
        # The load that is really there: a penalty gives way a little.
        self.load = self.contact.force[1] * AREA / HEIGHT / 0.5
        self.exact = di.theory.bar_pull(FORCE, self.load, FRICTION, E, AREA)

    def pull(self, force):
        self.end.constant.value[0] = -force / AREA
        report = self.problem.solve(max_iterations=40)
        # Slip runs along the bar by a few facets with every iteration.
        assert max(report.iterations) <= 40 and report.cut_backs <= 2
        assert_coulomb(self.contact)
        return -self.model.at((0.0, 0.0))[0]


@pytest.mark.covering(1)
@pytest.mark.parametrize(
    "method, num, degree",
    [("Penalty", 100, 1), ("Penalty", 200, 1), ("Penalty", 100, 2), ("Lagrange", 100, 1), ("Lagrange", 100, 2)],
)
def test_bar_pulled_along_a_plane(method, num, degree):
    """Slip length, displacements and what is left when the force is taken away; 1 %."""
    bar = Bar(method, num, degree)
    contact, exact = bar.contact, bar.exact
    assert bar.load == pytest.approx(NORMAL, rel={"Lagrange": 1e-9, "Penalty": 0.1}[method])
    assert bar.pull(FORCE) == pytest.approx(exact.end_displacement, rel=0.01)
    # Friction over the width of the bar is the pull, equilibrium.
    assert contact.force[0] * AREA / HEIGHT == pytest.approx(FORCE, rel=1e-8)
    x = np.linspace(0.0, 0.5, 11)
    along = [-bar.model.at((v, 0.0))[0] for v in x]
    np.testing.assert_allclose(along, exact.displacement(x), rtol=0, atol=0.01 * exact.end_displacement)
    slipped = bar.model.places(contact)[contact.status == di.ContactStatus.slip, 0].max()
    # To the length of a facet, and where the displacement is within 0.1 % of its largest.
    assert slipped == pytest.approx(exact.slip_length, abs=0.5 / num + 0.03 * exact.slip_length)
    assert bar.pull(0.0) == pytest.approx(exact.residual_displacement, rel=0.01)


# Nodes on the floor [mm] and their displacement along it [mm]: a solution with 32 x 32 quadratic cells.
PLATE = {0.0: 2.861e-2, 1.25: 2.723e-2, 5.0: 2.287e-2, 7.5: 1.981e-2, 11.25: 1.542e-2}


@pytest.mark.covering(1)
@pytest.mark.parametrize("degree, steps", [(1, 1), (1, 4), (2, 1)])
@pytest.mark.parametrize("method", ["Lagrange", "Penalty"])
def test_plate_pressed_and_pushed(method, degree, steps):
    """Plane strain, pressed on a rough floor (friction 1) and pushed from the side; 3 %, as the sources scatter.

    The floor lets go near the loaded corner, slips behind it and sticks further in. Loads in proportion: the number of
    steps is of no account.
    """
    m = Model(
        "block", di.LinearElastic(130e3, 0.2, hypothesis="plane_strain"), degree, size=(40.0, 40.0), cells=(32, 32)
    )
    m.hold("right", 0)
    m.pull("top", (0.0, -50.0))
    m.pull("left", (150.0, 0.0))
    problem = m.problem(enforce(method, m.pair("bottom", PLANE, friction=1.0)))
    report, contact = problem.solve(steps=steps), problem.contact[0]
    assert_coulomb(contact)
    # A problem linear but for its states: multipliers settle them in one linear problem, to the digit in a second.
    assert max(report.iterations) <= (2 if method == "Lagrange" else 20)
    for x, expected in PLATE.items():
        assert m.at((x, 0.0))[0] == pytest.approx(expected, rel=0.005)  # ours and theirs are equally fine
    places, status = m.places(contact)[:, 0], contact.status
    zones = [places[status == s] for s in (di.ContactStatus.open, di.ContactStatus.slip, di.ContactStatus.stick)]
    assert zones[0].max() < zones[1].max() < zones[2].max() and 2.0 < zones[0].max() < 5.0
    assert contact.force[1] == pytest.approx(50.0 * 40.0, rel=1e-9)
    if degree == 1:  # reaction of the node next to the right edge: 104.86 N/mm published
        node = np.argmin(np.linalg.norm(m.V.tabulate_dof_coordinates()[:, :2] - (38.75, 0.0), axis=1))
        assert contact.contact_forces().reshape(-1, 2)[node, 1] == pytest.approx(104.86, rel=0.01)
