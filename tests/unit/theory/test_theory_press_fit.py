# SPDX-License-Identifier: MIT
"""Press fit of a shaft in a ring."""

import numpy as np
import pytest

from dolfinx_impact import theory

STEEL = (210e3, 0.3, 210e3, 0.3)  # [N/mm^2]


def test_solid_shaft():
    fit = theory.press_fit(0.05, 50.0, 100.0, *STEEL)
    assert fit.pressure == pytest.approx(78.75, rel=1e-14)  # exact
    assert fit.radial_stress(np.array([0.0, 20.0])) == pytest.approx(-78.75, rel=1e-14)
    assert fit.hoop_stress(0.0) == pytest.approx(-78.75, rel=1e-14)
    assert fit.hoop_stress(50.0) == pytest.approx(78.75 * 5 / 3, rel=1e-14)  # (c^2 + b^2)/(c^2 - b^2)
    assert np.isnan(fit.hoop_stress(101.0))


@pytest.mark.parametrize("hypothesis", ["plane_stress", "plane_strain"])
@pytest.mark.parametrize("inner", [0.0, 20.0])
def test_strains_add_up_to_the_interference(hypothesis, inner):
    """u = r (sigma_theta - nu sigma_r)/E from Hooke's law on both sides; equilibrium by differences."""
    fit = theory.press_fit(0.05, 50.0, 100.0, 210e3, 0.3, 70e3, 0.2, inner_radius=inner, hypothesis=hypothesis)
    jump = 0.0
    for sign, E, nu, r in ((-1, 210e3, 0.3, 50.0 * (1 - 1e-12)), (1, 70e3, 0.2, 50.0)):
        radial, hoop = fit.radial_stress(r), fit.hoop_stress(r)
        axial = nu * (radial + hoop) if hypothesis == "plane_strain" else 0.0
        jump += sign * 50.0 * (hoop - nu * (radial + axial)) / E
    assert jump == pytest.approx(0.05, rel=1e-10)  # 1e-12 inside the interface
    assert fit.radial_stress(50.0) == pytest.approx(-fit.pressure, rel=1e-14)
    assert fit.radial_stress(100.0) == pytest.approx(0.0, abs=1e-13 * fit.pressure)
    if inner:
        assert fit.radial_stress(inner) == pytest.approx(0.0, abs=1e-13 * fit.pressure)
    for r in (35.0, 80.0):
        h = 1e-3  # error of central differences ~ h^2/r^2
        slope = (fit.radial_stress(r + h) - fit.radial_stress(r - h)) / (2 * h)
        difference = (fit.hoop_stress(r) - fit.radial_stress(r)) / r
        assert slope == pytest.approx(difference, abs=1e-8 * fit.pressure)


def test_limits():
    plate = theory.press_fit(0.05, 50.0, np.inf, *STEEL)
    assert plate.pressure == pytest.approx(theory.press_fit(0.05, 50.0, 1e9, *STEEL).pressure, rel=1e-13)
    rigid = theory.press_fit(0.05, 50.0, 100.0, np.inf, 0.3, 210e3, 0.3)
    assert rigid.pressure == pytest.approx(0.05 / 50 * 210e3 / (5 / 3 + 0.3), rel=1e-14)
    for radii in ({"outer_radius": 50.0}, {"outer_radius": 100.0, "inner_radius": 50.0}):
        with pytest.raises(ValueError, match="radius"):
            theory.press_fit(0.05, 50.0, E1=1.0, nu1=0.3, E2=1.0, nu2=0.3, **radii)
