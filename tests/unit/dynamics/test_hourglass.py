# SPDX-License-Identifier: MIT
"""Energy of hourglass modes: when it is looked at, and what is warned of."""

import numpy as np
import pytest
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact.dynamics.hourglass import EVERY, HourglassEnergy, Hourglassing


def made(integration="reduced", mode=0.1):
    domain = mesh.create_unit_square(MPI.COMM_SELF, 1, 1, mesh.CellType.quadrilateral)
    u = fem.Function(fem.functionspace(domain, ("Lagrange", 1, (2,))))
    u.interpolate(lambda x: np.array([mode * (x[0] - 0.5) * (x[1] - 0.5), 0 * x[0]]))
    return HourglassEnergy(u, di.LinearElastic(1.0, 0.0, 1.0, "plane_stress", integration))


def test_energy_of_one_mode():
    """u = a z_1 z_2: strain a z_2, whose energy with E = 1 is a^2/24."""
    assert made().entry() == {"hourglass": pytest.approx(0.1**2 / 24, rel=1e-12)}


def test_it_is_looked_at_now_and_then():
    energy = made()
    assert energy.steps_left(10**6) == EVERY and not energy.due
    energy.add(1.0, EVERY)
    assert energy.due and energy.steps_left(10**6) == 0
    energy.entry()
    assert not energy.due and energy.steps_left(10**6) == EVERY


@pytest.mark.filterwarnings("error")
def test_much_is_warned_of_once():
    energy = made()
    energy.add(0.1**2 / 24 / 0.04)
    energy.entry()
    energy.warn()  # 4 %
    energy.begin_anew()
    energy.add(0.1**2 / 24 / 0.06)
    energy.entry()
    with pytest.warns(Hourglassing, match="6 % of the largest internal energy"):
        energy.warn()
    energy.warn()


def test_full_integration_has_none():
    energy = made("full")
    assert energy.entry() == {} and energy.steps_left(7) == 7 and not energy.due
