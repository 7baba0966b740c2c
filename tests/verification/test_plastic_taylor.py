# SPDX-License-Identifier: MIT
"""Taylor's bar of copper, benchmark I-8: 227 m/s against a frictionless wall, 80 microseconds.

Published: final length 21.42 mm and radius of the face 7.22 mm (Foulk et al. 2021); older codes 21.26 to 21.66 mm, 6.8
to 7.24 mm, largest plastic strain 2.47 to 3.25.
Found with 8 by 80 linear quadrilaterals with F-bar, relative to that: length +.0 % and radius -.9 % with the face held
along the axis, +.3 % and +1.1 % with kinematic contact. Without F-bar the radius is too small by more than 3 %.
"""

import numpy as np
import pytest
from dolfinx import fem
from meshes_and_supports import clamp, rectangle, tagged

import dolfinx_impact as di

LENGTH, RADIUS, SPEED = 32.4e-3, 3.2e-3, 227.0
# time [us], radius of the face [mm], length [mm]: Carina, composite tetrahedra (BENCHMARKS I-8)
PUBLISHED = np.array([
    [10, 5.218, 30.140], [20, 6.195, 28.063], [30, 6.811, 26.185], [40, 7.139, 24.556], [50, 7.230, 23.215],
    [60, 7.227, 22.205], [70, 7.227, 21.583], [78, 7.226, 21.412],
])  # fmt: skip


class TaylorBar:
    """Section of the bar in (r, z) with linear quadrilaterals.

    Args:
        n: cells along the radius and along the axis [1].
        contact: whether the wall is a rigid plane; otherwise the face is held along the axis.
        average: of J2Plasticity.
    """

    def __init__(self, n, contact=True, average="auto"):
        domain = rectangle("quadrilateral", (0.0, 0.0), (RADIUS, LENGTH), n)
        tags = tagged(domain, face=lambda x: np.isclose(x[1], 0), axis=lambda x: np.isclose(x[0], 0))
        self.V = V = fem.functionspace(domain, ("Lagrange", 1, (2,)))
        self.u, velocity = fem.Function(V, name="u"), fem.Function(V)
        velocity.interpolate(lambda x: np.vstack([0 * x[0], np.where(contact | (x[1] > 1e-9), -SPEED, 0.0)]))
        pairs = [di.Kinematic(di.ContactPair(tags, 1, di.RigidPlane((0.0, 0.0), (0.0, 1.0))))] if contact else []
        bcs = [clamp(V, tags, 2, 0)] + ([] if contact else [clamp(V, tags, 1, 1)])
        copper = di.J2Plasticity(
            117e9, 0.35, 8930.0, yield_stress=400e6, hardening=100e6, finite_strain=True, hypothesis="axisymmetric",
            average=average,
        )  # fmt: skip
        self.run = di.ExplicitProblem(self.u, copper, velocity=velocity, bcs=bcs, contact=pairs)
        x = V.tabulate_dof_coordinates()
        self.rim, self.top = (np.argmin(np.hypot(x[:, 0] - r, x[:, 1] - z)) for r, z in ((RADIUS, 0), (0, LENGTH)))

    def at(self, time):
        """Radius of the face and length at a time [mm]."""
        self.run.advance(time, progress=False)
        u = self.u.x.array.reshape(-1, 2)
        return 1e3 * np.array([RADIUS + u[self.rim, 0], LENGTH + u[self.top, 1]])


def report(bar, found):
    strain = bar.run.history["plastic_strain"].values.max()
    print(f"radius {found[0]:.3f} mm, length {found[1]:.3f} mm, largest plastic strain {strain:.2f}, "
          f"{bar.run.step} steps, drift {bar.run.energy['drift']:+.1e}")  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("contact", [False, True], ids=["held", "kinematic contact"])
def test_taylor_bar(contact):
    """I-8: the history and the final shape, length 1 %, radius 3 %; the kinetic energy is dissipated."""
    bar = TaylorBar((8, 80), contact)
    for time, *published in PUBLISHED:
        found = bar.at(1e-6 * time)
        print(f"{time:2.0f} us: radius {found[0]:.3f} ({found[0] / published[0] - 1:+.1%}), length {found[1]:.3f} "
              f"({found[1] / published[1] - 1:+.2%})")  # fmt: skip
        assert found[0] == pytest.approx(published[0], rel=0.03) and found[1] == pytest.approx(published[1], rel=0.01)
    found = bar.at(80e-6)
    report(bar, found)
    assert found[0] == pytest.approx(7.22, rel=0.03) and found[1] == pytest.approx(21.42, rel=0.01)
    energy = bar.run.energy
    assert energy["plastic"] == pytest.approx(239.81, rel=0.02)  # almost all of the kinetic energy [J]
    assert abs(energy["drift"]) < 0.01


def test_coarse_taylor_bar():
    """4 by 40 cells, up to 30 us, when the foot has been compressed most: the same limits."""
    bar = TaylorBar((4, 40))
    found = bar.at(30e-6)
    report(bar, found)
    assert found[0] == pytest.approx(6.811, rel=0.03) and found[1] == pytest.approx(26.185, rel=0.01)


def test_without_the_mean_dilatation_the_foot_locks():
    """The checks above must see cells that lock."""
    found = TaylorBar((4, 40), average=False).at(30e-6)
    assert found[0] < 0.97 * 6.811
