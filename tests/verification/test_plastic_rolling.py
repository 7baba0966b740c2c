# SPDX-License-Identifier: MIT
"""Line rolling, benchmark J-4: Hertz's pressure moves over a block in plane strain, again and again (Johnson 9.2).

First yield at 3.11 k, elastic shakedown up to 4 k. Found with cells of an eighth of the half-width and steps of a
quarter: at 3.8 k plastic strain grows in the first passes only; at 4.2 k, with Armstrong and Frederick's back stress,
it grows by 1.3e-3 in every pass. Coarse cells lower the limit itself: at 3.8 k cells of 1/3 and 1/5 still find 1e-3
and 3e-4 per pass.
"""

import numpy as np
import pytest
import ufl
from dolfinx import fem
from meshes_and_supports import clamp, rectangle, tagged

import dolfinx_impact as di
from dolfinx_impact.theory import plasticity as theory

E, NU, Y = 207e3, 0.3, 780.0
K = Y / np.sqrt(3)
WIDTH, N, STEP, PASSES = 8.0, 8, 0.25, 20  # lengths over the half-width of the contact


def growth(peak, **steel):
    """Growth of the largest plastic strain in the middle of the block in each pass of a pressure with that peak."""
    y = np.concatenate([np.linspace(0, 2, 2 * N + 1), 2 + np.cumsum(1.5 ** np.arange(1, 7) / N)])
    m = len(y) - 1
    domain = rectangle("quadrilateral", (0.0, 0.0), (1.0, 1.0), (int(WIDTH * N), m))
    x = domain.geometry.x
    x[:, 0], x[:, 1] = WIDTH * (x[:, 0] - 0.5), -y[::-1][np.rint(x[:, 1] * m).astype(int)]
    tags = tagged(
        domain,
        top=lambda x: np.isclose(x[1], 0),
        bottom=lambda x: np.isclose(x[1], -y[-1]),
        sides=lambda x: np.isclose(np.abs(x[0]), WIDTH / 2),
    )
    V = fem.functionspace(domain, ("Lagrange", 1, (2,)))
    centre, place = fem.Constant(domain, 0.0), ufl.SpatialCoordinate(domain)
    pressure = peak * ufl.sqrt(ufl.max_value(1 - (place[0] - centre) ** 2, 0.0))
    load = di.Traction(tags, 1, ufl.as_vector([0.0 * place[0], -pressure]))
    law = di.J2Plasticity(E, NU, yield_stress=Y, hypothesis="plane_strain", **steel)
    problem = di.StaticProblem(
        fem.Function(V, name="u"), law, bcs=[clamp(V, tags, 2), clamp(V, tags, 3, 0)], loads=[load]
    )
    points = problem.history["plastic_strain"].function().function_space.tabulate_dof_coordinates()
    middle, largest = np.abs(points[:, 0]) < 1.0, [0.0]
    for _ in range(PASSES):
        for centre.value in np.arange(-WIDTH / 2 - 1 + STEP, WIDTH / 2 + 1 + STEP / 2, STEP):
            problem.solve()
        largest.append(problem.history["plastic_strain"].function().x.array[middle].max())
    print(f"{peak / K:.1f} k:", " ".join(f"{g:.1e}" for g in np.diff(largest)))
    return np.diff(largest)


@pytest.mark.slow
@pytest.mark.timeout(1200)
@pytest.mark.parametrize("kinematic", [None, di.ArmstrongFrederick(60e3, 300.0)], ids=["perfect", "back stress"])
def test_shakedown(kinematic):
    """Between first yield and 4 k: plastic strain in the first passes, none in the last ten."""
    limits = theory.line_shakedown(Y, NU)
    assert limits.first_yield / K < 3.8 < limits.shakedown / K == pytest.approx(4.0)
    found = growth(3.8 * K, kinematic=kinematic)
    assert found[0] > 1e-4
    assert np.all(found[-10:] < 1e-6)


@pytest.mark.slow
@pytest.mark.timeout(1200)
def test_ratcheting():
    """Above 4 k with a back stress that recovers: every pass adds as much as the one before."""
    found = growth(4.2 * K, kinematic=di.ArmstrongFrederick(60e3, 300.0))
    assert np.all(found > 1e-3) and found[-1] == pytest.approx(found[-2], rel=0.02)
