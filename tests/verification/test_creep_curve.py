# SPDX-License-Identifier: MIT
"""A wheel on a rail in 3D against the program CONTACT: F-5, the creep curve of the locomotive Eurosprinter."""

import numpy as np
import pytest

from dolfinx_impact.creep.model import CreepModel, WheelOnRail

G, NU = 82e9, 0.28
CREEP = np.array([4e-4, 1.2e-3, 2.0e-3, 2.8e-3])
CONTACT = np.array([0.2588, 0.6482, 0.8816, 0.9832])
SLOPE = 3.788  # of the curve at its beginning over G a b, C11; CONTACT


@pytest.fixture(scope="module")
def model():
    """The transverse radius makes the half-axis along the rail half of the one across."""
    data = WheelOnRail(106.7e3, 0.33, 0.625, 1.77672, E=2 * G * (1 + NU), nu=NU, speed=1.0, cells=5, reach=5.0)
    return CreepModel(data)


def test_eurosprinter(model):
    """Found: 1.8 % too large at the small creep, within 1 % above. The grid of CONTACT is 1 to 2 % high."""
    hertz = model.hertz
    assert hertz.a / hertz.b == pytest.approx(0.5, rel=1e-4)
    assert model.contact.force[2] * 2 == pytest.approx(106.7e3, rel=3e-4)
    assert model.contact.pressure.max() == pytest.approx(hertz.peak_pressure, rel=0.01)
    assert abs(model.free_creep) < 1e-4
    curve = model.curve(np.concatenate([[2e-5], CREEP]), progress=False)
    np.testing.assert_allclose(curve["ratio"][1:], CONTACT, rtol=0.03)
    slope = curve["force"][0, 0] / (2e-5 * G * hertz.a * hertz.b)
    assert slope == pytest.approx(SLOPE, rel=0.04)  # 3 %, and 1 % for the creep of 2e-5 that is not zero
    assert np.all(np.diff(curve["torque"]) > 0.0)
    np.testing.assert_allclose(curve["force"][:, 2], 106.7e3, rtol=1e-3)
