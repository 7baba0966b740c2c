# SPDX-License-Identifier: MIT
"""The laws that the benchmark of plasticity compares with, by themselves: elastic below yield, radial return above."""

from types import SimpleNamespace

import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI

from impact_studies.bench.plastic import E, HARDENING, NU, UsualWay, _OwnResponse

G = E / (2 * (1 + NU))
YIELD = 1e-3


def cube(shear):
    domain = mesh.create_unit_cube(MPI.COMM_SELF, 1, 1, 1, mesh.CellType.hexahedron)
    u = fem.Function(fem.functionspace(domain, ("Lagrange", 1, (3,))))
    u.interpolate(lambda x: (shear * x[1], 0 * x[0], 0 * x[0]))
    return u


@pytest.mark.parametrize("shear", [0.5 * YIELD / G, 4 * YIELD / G], ids=["elastic", "plastic"])
def test_shear_of_a_cube_the_usual_way(shear):
    """Stress and plastic strain in closed form; the force on the upper face is the stress on its area of one."""
    u = cube(shear)
    way = UsualWay(u, YIELD, 2, np.zeros(24), np.ones(24))
    excess = np.sqrt(3) * G * shear - YIELD
    plastic = max(excess, 0.0) / (3 * G + HARDENING)
    stress = G * shear if excess < 0.0 else (YIELD + HARDENING * plastic) / np.sqrt(3)
    force = way.force().reshape(-1, 3)
    top = np.isclose(u.function_space.tabulate_dof_coordinates()[:, 1], 1.0)
    assert force[top].sum(axis=0) == pytest.approx([stress, 0.0, 0.0], rel=1e-9, abs=1e-12 * stress)
    assert way.alpha.x.array == pytest.approx(plastic, rel=1e-9, abs=1e-15)
    assert way.force().reshape(-1, 3)[top, 0].sum() == pytest.approx(stress, rel=1e-9)  # the history was committed


def test_a_step_of_central_differences():
    u = cube(0.1 * YIELD / G)
    before, velocity, mass = u.x.array.copy(), np.linspace(0.0, 1e-6, 24), np.linspace(1.0, 2.0, 24)
    way = UsualWay(u, YIELD, 2, velocity, mass)
    force = way.force().copy()
    way.step(0.5)
    assert way.v == pytest.approx(velocity - 0.5 * force / mass, abs=1e-16)
    assert u.x.array == pytest.approx(before + 0.5 * way.v, abs=1e-16)


def test_an_own_response_is_a_radial_return():
    """Strains as numbers: stress, new history and stored energy of one step from a history."""
    material = SimpleNamespace(constant=lambda mesh, name, value: ufl.as_ufl(value))
    response = _OwnResponse(material, None, YIELD)
    assert response.history == {"alpha": (), "eps_p": (5,)} and response.unknown is None
    alpha, shear = 0.5 * YIELD / HARDENING, 4 * YIELD / G
    strain = ufl.as_tensor([[0.0, shear / 2, 0.0], [shear / 2, 0.0, 0.0], [0.0, 0.0, 0.0]])
    update = response.respond(strain, {"alpha": ufl.as_ufl(alpha), "eps_p": ufl.as_vector([0.0] * 5)})
    step = (np.sqrt(3) * G * shear - 1.5 * YIELD) / (3 * G + HARDENING)
    found = float(update.outputs["alpha"](())) - alpha
    assert found == pytest.approx(step, rel=1e-9, abs=1e-15)
    stress = G * (shear - np.sqrt(3) * step)
    assert float(update.stress[0, 1](())) == pytest.approx(stress, rel=1e-9)
    assert float(ufl.as_ufl(update.stored)(())) == pytest.approx(stress**2 / (2 * G), rel=1e-9)
