# SPDX-License-Identifier: MIT
"""J2 plasticity of one stress component: uniaxial loading and unloading, simple shear, cyclic loops, in closed form."""

import numpy as np
import pytest
from dolfinx import fem
from meshes_and_supports import block, clamp, tagged

from dolfinx_impact import ArmstrongFrederick, J2Plasticity, StaticProblem, Table, Voce
from dolfinx_impact.theory import plasticity as theory

E, NU, Y, H = 207e9, 0.3, 780e6, 20e9
# Newton's method of the problem ends at 1e-12 of the forces; the strain of a yielding point follows with E/H.
TOLERANCE = 1e-10


class Bar:
    """A block of unit size that is stretched along x, with free sides.

    Args:
        cell: cell.
        hypothesis: hypothesis of the material.
        steel: arguments of J2Plasticity.
        degree: degree of the displacement.
    """

    def __init__(self, cell, hypothesis, degree=1, **steel):
        domain = block(cell, 1)
        dim = domain.geometry.dim
        places = [lambda x, i=i: np.isclose(x[i], 0) for i in range(dim)]
        tags = tagged(domain, end=lambda x: np.isclose(x[0], 1), **{f"low{i}": p for i, p in enumerate(places)})
        self.V = V = fem.functionspace(domain, ("Lagrange", degree, (dim,)))
        self.u = fem.Function(V, name="u")
        self.stretch = fem.Constant(domain, 0.0)
        self.end = fem.locate_dofs_topological(V, dim - 1, tags.find(1))
        pulled = fem.dirichletbc(self.stretch, fem.locate_dofs_topological(V.sub(0), dim - 1, tags.find(1)), V.sub(0))
        bcs = [pulled] + [clamp(V, tags, 2 + i, i) for i in range(dim)]
        self.problem = StaticProblem(
            self.u, J2Plasticity(E, NU, hypothesis=hypothesis, average=False, **steel), bcs=bcs
        )

    def stress(self, strain, steps=1):
        """Stress at a strain [F/L^2], reached in equal steps from the last one."""
        self.stretch.value = strain
        self.report = self.problem.solve(steps=steps, rtol=1e-12)
        dim = self.V.mesh.geometry.dim
        return self.problem.reactions().x.array.reshape(-1, dim)[self.end, 0].sum()  # on a face of area 1

    @property
    def plastic_strain(self):
        values = self.problem.history["plastic_strain"].values
        np.testing.assert_allclose(values, values.mean(), rtol=1e-9, atol=1e-15)
        return values.mean()


BODIES = [("hexahedron", "3d"), ("tetrahedron", "3d"), ("quadrilateral", "plane_stress"), ("triangle", "plane_stress")]


@pytest.mark.parametrize("cell, hypothesis", BODIES)
def test_linear_hardening_and_unloading(cell, hypothesis):
    """J-5: sigma = Y + H eps_p; unloading is elastic, the plastic strain stays."""
    bar = Bar(cell, hypothesis, yield_stress=Y, hardening=H)
    assert bar.stress(0.9 * Y / E) == pytest.approx(0.9 * Y, rel=TOLERANCE)
    assert bar.plastic_strain == 0.0
    for strain in (0.01, 0.02):
        stress = (Y + H * strain) / (1 + H / E)
        assert bar.stress(strain) == pytest.approx(stress, rel=TOLERANCE)
        assert bar.plastic_strain == pytest.approx(strain - stress / E, rel=TOLERANCE)
    assert bar.stress(0.02 - Y / E) == pytest.approx(stress - Y, rel=TOLERANCE)
    assert bar.plastic_strain == pytest.approx(0.02 - stress / E, rel=TOLERANCE)
    assert bar.report.iterations[0] <= 2, "unloading is linear; the first tangent is that of the corner"


@pytest.mark.covering(1)
@pytest.mark.parametrize("cell, hypothesis", BODIES)
@pytest.mark.parametrize(
    "hardening, curve",
    [
        (Voce(1.5 * Y, 40.0, 0.2 * Y), lambda a: Y + 0.2 * Y * a + 0.5 * Y * (1 - np.exp(-40.0 * a))),
        (Table([0.0, 0.004, 0.02], [Y, 1.2 * Y, 1.5 * Y]), lambda a: Y * np.interp(a, [0, 0.004, 0.02], [1, 1.2, 1.5])),
    ],
    ids=["Voce", "Table"],
)
def test_nonlinear_hardening(cell, hypothesis, hardening, curve):
    """The stress is the yield stress at the plastic strain, whatever its form; Newton's method converges fast."""
    bar = Bar(cell, hypothesis, yield_stress=Y, hardening=hardening)
    for strain in (0.006, 0.012, 0.03):
        stress = bar.stress(strain)
        assert stress == pytest.approx(curve(bar.plastic_strain), rel=TOLERANCE)
        assert stress == pytest.approx(E * (strain - bar.plastic_strain), rel=TOLERANCE)
        assert bar.report.iterations[-1] <= 7, "the tangent is consistent"


def test_simple_shear_yields_at_the_shear_yield_stress():
    """J-5: a shear stress Y/sqrt(3)."""
    domain = block("hexahedron", 1)
    V = fem.functionspace(domain, ("Lagrange", 1, (3,)))
    u = fem.Function(V)
    u.interpolate(lambda x: np.vstack([0.05 * x[1], 0 * x[0], 0 * x[0]]))
    bc = fem.dirichletbc(u, np.arange(V.dofmap.index_map.size_local, dtype=np.int32))
    problem = StaticProblem(u, J2Plasticity(E, NU, yield_stress=Y, average=False), bcs=[bc])
    problem.solve()
    top = np.isclose(V.tabulate_dof_coordinates()[:, 1], 1)
    force = problem.reactions().x.array.reshape(-1, 3)[top, 0].sum()
    assert force == pytest.approx(Y / np.sqrt(3), rel=TOLERANCE)


@pytest.mark.parametrize("cell, hypothesis", [("hexahedron", "3d"), ("quadrilateral", "plane_stress")])
def test_prager_cycle(cell, hypothesis):
    """Linear kinematic hardening in closed form, exact for any step: pulled, then pushed (Bauschinger's effect)."""
    bar = Bar(cell, hypothesis, yield_stress=Y, kinematic=H)
    plastic = np.array([0.01, -0.01, 0.01])
    strains, stresses = theory.uniaxial_path(plastic, E, Y, kinematic=H)
    for strain, stress in zip(strains, stresses):
        assert bar.stress(strain) == pytest.approx(stress, rel=TOLERANCE)


def test_armstrong_frederick_loop_is_stable():
    """The loop's stress and back stress amplitudes in closed form; backward Euler is of first order in the step."""
    C, gamma, amplitude = 60e9, 300.0, 0.004
    exact = theory.plastic_cycle(amplitude, E, Y, C, gamma)
    errors = []
    for steps in (40, 80):
        bar = Bar("hexahedron", "3d", yield_stress=Y, kinematic=ArmstrongFrederick(C, gamma))
        for sign in (1, -1, 1):
            stress = bar.stress(sign * exact.strain_amplitude, steps=steps)
        errors.append(stress / exact.stress_amplitude - 1)
        back = bar.problem.history["back_stress"].values[..., 0] * 1.5  # the deviator's first component, times 3/2
        np.testing.assert_allclose(back, stress - Y, rtol=1e-6)
    assert abs(errors[1]) < 0.01 and abs(errors[1]) < 0.6 * abs(errors[0])


def test_finite_strain_is_the_small_one_where_strains_are_small():
    """Stretched by 1e-4 beyond yield at 1e-5 of the modulus, both laws differ by the strain."""
    stresses = []
    for finite in (False, True):
        bar = Bar("hexahedron", "3d", yield_stress=1e-5 * E, hardening=0.1 * E, finite_strain=finite)
        stresses.append(bar.stress(1e-4))
    assert stresses[1] == pytest.approx(stresses[0], rel=3e-4)
    assert stresses[1] != stresses[0]


@pytest.mark.parametrize("cell, hypothesis", [("hexahedron", "3d"), ("quadrilateral", "plane_stress")])
def test_finite_strain_turns_with_the_body(cell, hypothesis):
    """A bar that has yielded and is turned by 70 degrees as a whole: the stress turns with it, nothing yields."""
    bar = Bar(cell, hypothesis, yield_stress=Y, hardening=H, finite_strain=True)
    bar.stress(0.05, steps=3)
    dim = bar.V.mesh.geometry.dim
    before, plastic = bar.problem.reactions().x.array.reshape(-1, dim), bar.plastic_strain
    x = bar.V.tabulate_dof_coordinates()[:, :dim]
    c, s = np.cos(1.2), np.sin(1.2)
    R = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])[:dim, :dim]
    bar.u.x.array[:] = ((x + bar.u.x.array.reshape(-1, dim)) @ R.T - x).ravel()
    after = bar.problem.reactions().x.array.reshape(-1, dim)
    np.testing.assert_allclose(after, before @ R.T, atol=1e-9 * np.abs(before).max())
    assert bar.plastic_strain == plastic


# --- a sheet of finite strain -----------------------------------------------------------------------------------------

HARDENINGS = {
    "linear": (H, lambda a: Y + H * a),
    "Voce": (Voce(1.5 * Y, 40.0, 20 * Y), lambda a: Y + 20 * Y * a + 0.5 * Y * (1 - np.exp(-40.0 * a))),
    "Table": (Table([0.0, 0.1, 0.4], [Y, 3 * Y, 7 * Y]), lambda a: Y * np.interp(a, [0, 0.1, 0.4], [1, 3, 7])),
}  # they harden enough, so that no sheet necks


def elastic_tensor(tau):
    """a and m of the elastic left Cauchy-Green tensor diag(m + 2 a, m - a, m - a) of a uniaxial Kirchhoff stress.

    Its determinant is 1; tau = mu (3 a).
    """
    a = tau * 2 * (1 + NU) / (3 * E)
    return a, max(np.roots([1, 0, -3 * a**2, 2 * a**3 - 1]).real)


def elastic_stretches(tau):
    """Elastic stretches along and across a sheet under a uniaxial Kirchhoff stress: kappa/2 (J^2 - 1) = tau/3."""
    a, m = elastic_tensor(tau)
    third = (1 + 2 * tau * (1 - 2 * NU) / E) ** (1 / 6)  # J^(1/3)
    return third * np.sqrt(m + 2 * a), third * np.sqrt(m - a)


def plastic_stretch(alpha, curve):
    """Logarithm of the axial plastic stretch: flow along the stress takes 2 m d(alpha) from the deviator's 2 a, and the
    determinant stays 1, so that d ln(stretch) = m/(m + a) d(alpha)."""
    nodes, weights = np.polynomial.legendre.leggauss(8)
    total = 0.0
    for low, high in zip((0.0, 0.1), (0.1, alpha)):  # the table has a corner at 0.1
        for x, w in zip(nodes, weights):
            a, m = elastic_tensor(curve(0.5 * (low + high + (high - low) * x)))
            total += 0.5 * (high - low) * w * m / (m + a)
    return total


@pytest.mark.parametrize("name", HARDENINGS)
def test_a_sheet_that_is_stretched_by_a_third(name):
    """Kirchhoff stress over logarithmic strain, J-5 in plane stress. In every state, to the tolerance of the solver:
    tau is the yield stress, and the stretches are those of tau times the plastic ones, which keep the volume. In the
    limit of small steps, the axial plastic stretch is that of the flow rule."""
    hardening, curve = HARDENINGS[name]
    end, errors = 0.3, []
    for steps in (10, 20, 40):
        sheet = Bar("quadrilateral", "plane_stress", yield_stress=Y, hardening=hardening, finite_strain=True)
        stretch = np.exp(end)
        tau = sheet.stress(stretch - 1, steps=steps) * stretch
        alpha = sheet.plastic_strain
        assert tau == pytest.approx(curve(alpha), rel=TOLERANCE)
        along, across = elastic_stretches(tau)
        plastic = stretch / along
        width = 1 + sheet.u.x.array.reshape(-1, 2)[:, 1].min()
        thickness = np.exp(sheet.problem.history["thickness_strain"].values)
        assert width == pytest.approx(across / np.sqrt(plastic), rel=TOLERANCE)
        np.testing.assert_allclose(thickness, width, rtol=TOLERANCE)
        cauchy = sheet.problem.history["stress"].values
        expected = [tau / (stretch * width**2), 0, 0, 0]
        np.testing.assert_allclose(cauchy, np.broadcast_to(expected, cauchy.shape), atol=TOLERANCE * cauchy.max())
        errors.append(abs(np.log(plastic) - plastic_stretch(alpha, curve)))
        # A step of the logarithmic strain d begins with (exp(3 d) - 1)/(exp(3 d) + 2) = d + d^2/2 of alpha: half of
        # this for small elastic strains.
        assert errors[-1] < end * end / steps
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.all(np.abs(orders - 1) < 0.2), orders


def test_a_sheet_and_a_solid_with_free_sides_are_the_same():
    """Stretched, pushed back beyond yield, with back stress that saturates."""
    law = dict(yield_stress=Y, hardening=10 * Y, kinematic=ArmstrongFrederick(60e9, 30.0), finite_strain=True)
    sheet, solid = Bar("quadrilateral", "plane_stress", **law), Bar("hexahedron", "3d", **law)
    for stretch in (0.1, 0.05):
        assert sheet.stress(stretch, steps=5) == pytest.approx(solid.stress(stretch, steps=5), rel=TOLERANCE)
        assert sheet.plastic_strain == pytest.approx(solid.plastic_strain, rel=TOLERANCE)
    across = 1 + solid.u.x.array.reshape(-1, 3)[:, 2].min()
    values = np.exp(sheet.problem.history["thickness_strain"].values)
    np.testing.assert_allclose(values, across, rtol=TOLERANCE)
