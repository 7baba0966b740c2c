# SPDX-License-Identifier: MIT
"""Level derivative: Taylor remainders tell a tangent from something that only looks like one."""

import numpy as np
import pytest
import ufl
from dolfinx import fem
from fault_injection import assert_caught, assert_healthy

from dolfinx_impact.own_forms import distorted_block
from dolfinx_impact import LinearElastic, NeoHookean, StVenantKirchhoff
from dolfinx_impact.forms import loads, materials
from impact_verify import derivative
from impact_verify.report import Report

ELEMENT = ("triangle", 1, 1, "plane_strain")


def law(kind):
    report = Report()
    V = fem.functionspace(distorted_block.block("triangle", 2), ("Lagrange", 1, (2,)))
    derivative._law(report, V, kind(1.0, 0.3, 1.0, "plane_strain"), ELEMENT)
    return report


def pressure():
    report = Report()
    derivative._pressure(
        report, fem.functionspace(distorted_block.block("triangle", 2), ("Lagrange", 1, (2,))), ELEMENT
    )
    return report


@pytest.mark.parametrize("kind", [LinearElastic, StVenantKirchhoff, NeoHookean])
def test_healthy_laws_pass(kind):
    assert_healthy(law(kind), "derivative", 2)


def test_a_healthy_follower_pressure_passes():
    assert_healthy(pressure(), "derivative", 1)


@pytest.mark.slow
def test_the_whole_level_passes():
    report = Report()
    derivative.run(report)
    assert_healthy(report, "derivative", 35)


@pytest.mark.parametrize("factor", [1.02, 0.9, -1.0])
def test_a_scaled_tangent_is_not_the_derivative(factor, monkeypatch, own_cache):
    right = materials.NeoHookean.stress_derivative
    monkeypatch.setattr(materials.NeoHookean, "stress_derivative", lambda law, u, du: factor * right(law, u, du))
    found = assert_caught(law(NeoHookean), "derivative", "neo_hookean.force", "tangent is the force's derivative")
    assert "remainders" in found.note


def test_a_tangent_without_geometric_stiffness(monkeypatch, own_cache):
    def wrong(self, u, du):
        H = self.gradient(u)
        F = ufl.Identity(3) + H
        dE = ufl.sym(F.T * self.gradient(du))
        return F * (self._lambda * ufl.tr(dE) * ufl.Identity(3) + 2 * self.mu * dE)

    monkeypatch.setattr(materials.StVenantKirchhoff, "stress_derivative", wrong)
    assert_caught(law(StVenantKirchhoff), "derivative", "st_venant_kirchhoff.force", "tangent")


def test_a_tangent_at_another_state(monkeypatch, own_cache):
    right = materials.NeoHookean.stress_derivative
    monkeypatch.setattr(materials.NeoHookean, "stress_derivative", lambda law, u, du: right(law, u / 2, du))
    assert_caught(law(NeoHookean), "derivative", "neo_hookean.force")


def test_an_energy_whose_derivative_is_not_the_force(monkeypatch, own_cache):
    right = materials.LinearElastic.energy_density
    monkeypatch.setattr(materials.LinearElastic, "energy_density", lambda law, u: 2 * right(law, u))
    assert_caught(law(LinearElastic), "derivative", "linear_elastic.energy", "force is the energy's derivative")


def test_a_linear_law_with_another_tangent(monkeypatch, own_cache):
    right = materials.LinearElastic.stress_derivative
    monkeypatch.setattr(materials.LinearElastic, "stress_derivative", lambda law, u, du: (1 + 1e-8) * right(law, u, du))
    assert_caught(law(LinearElastic), "derivative", "linear_elastic.force", "tangent")


def test_a_pressure_tangent_of_the_wrong_sign(monkeypatch, own_cache):
    right = loads.follower_pressure_tangent
    monkeypatch.setattr(loads, "follower_pressure_tangent", lambda *a: -right(*a))
    assert_caught(pressure(), "derivative", "follower_pressure")


@pytest.mark.parametrize(
    "power, passed", [(1.0, False), (1.5, False), (1.85, False), (2.0, True), (2.05, True), (3.0, False)]
)
def test_the_slope_decides(power, passed):
    report = Report()
    derivative._add(report, "form", ELEMENT, 3 * derivative.STEPS**power, 1.0, "name")
    assert report.passed is passed


@pytest.mark.parametrize("bad", [np.nan, np.inf, 0.0])
def test_a_remainder_that_is_no_number_does_not_pass(bad):
    remainders = derivative.STEPS**2
    remainders[2] = bad
    report = Report()
    derivative._add(report, "form", ELEMENT, remainders, 1.0, "name")
    assert not report.passed
