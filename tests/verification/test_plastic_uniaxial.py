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


def test_finite_strain_turns_with_the_body():
    """A bar that has yielded and is turned by 70 degrees as a whole: the stress turns with it, nothing yields."""
    bar = Bar("hexahedron", "3d", yield_stress=Y, hardening=H, finite_strain=True)
    bar.stress(0.05, steps=3)
    before, plastic = bar.problem.reactions().x.array.reshape(-1, 3), bar.plastic_strain
    x = bar.V.tabulate_dof_coordinates()
    c, s = np.cos(1.2), np.sin(1.2)
    R = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    bar.u.x.array[:] = ((x + bar.u.x.array.reshape(-1, 3)) @ R.T - x).ravel()
    after = bar.problem.reactions().x.array.reshape(-1, 3)
    np.testing.assert_allclose(after, before @ R.T, atol=1e-9 * np.abs(before).max())
    assert bar.plastic_strain == plastic
