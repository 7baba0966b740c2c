# SPDX-License-Identifier: MIT
"""The hand-written mass on a moving floor by itself, against closed forms."""

import math

import impact_reference as ref
import numpy as np
import pytest


def test_constant_friction_shifts_the_oscillation():
    """While the mass slips one way, x = mu P/k (1 - cos(w t)); on a floor that is always faster."""
    mass = ref.SlidingMass(2.0, 8.0, 3.0, 50.0, lambda v: 0.4)
    h, w, far = 1e-3, 2.0, 0.4 * 3.0 / 8.0
    found = mass.run(0.0, h, 4000)
    t = h * np.arange(1, 4001)
    # The friction is there from the first step's end on: half a step is missing.
    assert np.abs(found - far * (1 - np.cos(w * t))).max() < 2 * far * w * h


def test_it_sticks_up_to_the_coefficient_at_rest():
    mass = ref.SlidingMass(1.0, 1.0, 1.0, 0.1, lambda v: 0.2 + 0.3 * math.exp(-v / 0.01))
    h = 1e-3
    found = mass.run(0.0, h, 7000)
    rates = np.diff(found) / h
    stuck = np.abs(rates - 0.1) < 1e-9
    assert stuck.sum() > 3000 and found[1:][stuck].max() == pytest.approx(0.5, abs=1e-3)


def test_friction_that_falls_gives_the_mass_energy():
    """Small oscillations about steady slip grow by exp(-mu'(V) P t/(2 m)); steady at x = mu(V) P/k."""
    slope, floor = -0.3, 1.0
    mass = ref.SlidingMass(1.0, 25.0, 1.0, floor, lambda v: 0.5 + slope * (v - floor))
    found = mass.run(0.5 / 25.0 + 1e-4, 1e-3, 20000) - 0.5 / 25.0
    t = 1e-3 * np.arange(1, 20001)
    tops = [k for k in range(1, len(found) - 1) if found[k - 1] < found[k] > found[k + 1]]
    rate = np.polyfit(t[tops], np.log(found[tops]), 1)[0]
    # The backward difference of the slip velocity takes w^2 h/2 of 0.15 (seen: 0.15 - 0.002).
    assert rate == pytest.approx(0.15, rel=0.02)
