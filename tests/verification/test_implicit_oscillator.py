# SPDX-License-Identifier: MIT
"""One mode of a bar under the implicit schemes: periods, damping and order; benchmarks T-4 and T-5.

A row of cells that is held at one end swings in its lowest mode, for which the discrete problem is one oscillator: what
the program finds must be what the closed form of the scheme says, to round-off.
"""

import numpy as np
import pytest
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact._cpp.integrators import ImplicitScheme

CELLS = 4
ROD = di.LinearElastic(E=1.0, nu=0.0, density=1.0, hypothesis="plane_strain")


def omega(number):
    """Frequency of a mode on the uniform mesh with consistent mass: Hughes (2000), section 7.3."""
    h = 1.0 / CELLS
    c = np.cos((2 * number + 1) * np.pi / 2 * h)
    return np.sqrt(6.0 / h**2 * (1.0 - c) / (2.0 + c))


class Rod:
    """Bar of unit speed and length that swings along its axis, in a mode of the discrete problem.

    Args:
        number: number of the mode, from the lowest.
        options: arguments of NewmarkProblem.
    """

    def __init__(self, number=0, **options):
        domain = mesh.create_rectangle(
            MPI.COMM_WORLD, [[0.0, 0.0], [1.0, 0.25]], [CELLS, 1], mesh.CellType.quadrilateral
        )
        V = fem.functionspace(domain, ("Lagrange", 1, (2,)))
        x = V.tabulate_dof_coordinates()[:, 0]
        side = fem.locate_dofs_geometrical((V.sub(1), V.sub(1).collapse()[0]), lambda x: x[0] > -1.0)
        bcs = [
            fem.dirichletbc(
                fem.Function(V.sub(0).collapse()[0]),
                fem.locate_dofs_geometrical((V.sub(0), V.sub(0).collapse()[0]), lambda x: np.isclose(x[0], 0.0)),
                V.sub(0),
            ),
            fem.dirichletbc(fem.Function(V.sub(1).collapse()[0]), side, V.sub(1)),
        ]
        # Linear elements on a uniform mesh have sines as modes.
        self.shape = np.where(np.isclose(x, 0.0), 0.0, np.sin((2 * number + 1) * np.pi / 2 * x))
        self.omega = omega(number)
        self.u, velocity = fem.Function(V), fem.Function(V)
        self.u.x.array[0::2] = self.shape
        self.problem = di.NewmarkProblem(self.u, ROD, velocity=velocity, bcs=bcs, **options)

    def amplitudes(self, steps, product):
        """Amplitude of the mode at the start and after each step of the length product/omega."""
        found = [self.amplitude()]
        dt = product / self.omega
        self.problem.advance(steps * dt, dt, callback=lambda p: found.append(self.amplitude()), progress=False)
        return np.array(found[1:])

    def amplitude(self):
        return float(self.u.x.array[0::2] @ self.shape / (self.shape @ self.shape))


SCHEMES = {
    "trapezoidal rule": {}, "damped": {"beta": 0.3025, "gamma": 0.6}, "linear acceleration": {"beta": 1 / 6},
    "rho 0.8": {"rho_inf": 0.8}, "rho 0": {"rho_inf": 0.0}, "HHT": {"hht": -0.1},
}  # fmt: skip


@pytest.mark.parametrize("name", SCHEMES)
@pytest.mark.parametrize("product", [0.1, 1.0, 3.0])
def test_a_mode_is_an_oscillator_under_the_scheme(name, product):
    rod = Rod(**SCHEMES[name])
    scheme = rod.problem.scheme
    # Where the step is too large for the highest mode, it grows from round-off: 1e-16 must stay below the tolerance.
    growth = scheme.spectral_radius(product * omega(CELLS - 1) / rod.omega)
    steps = 20 if growth < 1.0 + 1e-6 else min(20, int(np.log(1e6) / np.log(growth)))
    assert steps >= 4
    found = rod.amplitudes(steps, product)
    state = np.array([1.0, 0.0, -(product**2)])
    step = scheme.amplification(product)
    expected = [state[0]]
    for _ in range(steps):
        state = step @ state
        expected.append(state[0])
    # Newton's method stops at 1e-10 of the largest force in a step.
    np.testing.assert_allclose(found, expected, atol=1e-9)


@pytest.mark.parametrize(("product", "error"), [(0.1, -8.32086e-4), (0.5, -2.00853e-2), (1.0, -7.27048e-2)])
def test_frequency_of_the_trapezoidal_rule(product, error):
    """Benchmark T-4: half a unit of the last digit that is given."""
    rod = Rod()
    steps = 40
    found = rod.amplitudes(steps, product)
    # u_{n+1} + u_{n-1} = 2 cos(w' h) u_n for an oscillator that is not damped.
    cosine = 0.5 * (found[2:] + found[:-2]) @ found[1:-1] / (found[1:-1] @ found[1:-1])
    assert np.arccos(cosine) / product - 1.0 == pytest.approx(error, abs=5e-8)


@pytest.mark.parametrize(
    ("parameters", "radius"), [((0.25, 0.5), 1.0), ((0.3025, 0.6), 0.818182), ((0.49, 0.9), 0.428571)]
)
def test_spectral_radius_at_infinity(parameters, radius):
    """Benchmark T-5; six digits are given. At w h = 1e5 the radius differs from its limit by 1e-10."""
    assert ImplicitScheme.newmark(*parameters).spectral_radius(1e5) == pytest.approx(radius, abs=1e-6)


@pytest.mark.parametrize("rho", [0.0, 0.3, 0.8, 1.0])
def test_spectral_radius_of_generalised_alpha_is_what_was_asked_for(rho):
    """The three eigenvalues meet at infinity: their mean is off by (w h)^-2, each of them by its cube root."""
    scheme = ImplicitScheme.generalised_alpha(rho)
    assert np.trace(scheme.amplification(1e6)) / 3 == pytest.approx(-rho, abs=1e-9)
    assert scheme.spectral_radius(1e6) == pytest.approx(rho, abs=2e-4)
    assert scheme.second_order


def test_the_radius_never_exceeds_one():
    """All products of frequency and step, with and without damping; 1e-7: double roots at the ends."""
    schemes = [ImplicitScheme.generalised_alpha(r) for r in (0.0, 0.5, 1.0)]
    schemes += [ImplicitScheme.hht(a) for a in (-1 / 3, -0.1, 0.0)] + [ImplicitScheme.newmark(0.3025, 0.6)]
    for scheme in schemes:
        for product in np.logspace(-3, 6, 60):
            for damping in (0.0, 0.1):
                assert scheme.spectral_radius(product, damping) <= 1.0 + 1e-7


def test_linear_acceleration_is_stable_up_to_the_benchmark():
    """Benchmark T-5: w h = 3.464102."""
    scheme = ImplicitScheme.newmark(1 / 6, 0.5)
    assert scheme.stable_frequency() == pytest.approx(3.464102, abs=1e-6)
    assert scheme.spectral_radius(0.999 * 3.464102) <= 1.0 + 1e-12
    assert scheme.spectral_radius(1.001 * 3.464102) > 1.01


def orders(first=10, **options):
    """Orders of convergence of the amplitude after one radian, from halved steps."""
    errors = []
    for steps in (first, 2 * first, 4 * first):
        rod = Rod(**options)
        errors.append(abs(rod.amplitudes(steps, 1.0 / steps)[-1] - np.cos(1.0)))
    return np.log2(np.array(errors[:-1]) / errors[1:])


@pytest.mark.parametrize("options", [{}, {"rho_inf": 0.8}, {"hht": -0.2}])
def test_second_order(options):
    # The next term of the error is smaller by the step, 1/20.
    np.testing.assert_allclose(orders(**options), 2.0, atol=0.1)


def test_first_order_for_another_gamma():
    """Benchmark T-5: order 2 for gamma = 1/2 only."""
    # The error of second order is that of first order times five times the step.
    np.testing.assert_allclose(orders(first=80, beta=0.3025, gamma=0.6), 1.0, atol=0.1)
