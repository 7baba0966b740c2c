# SPDX-License-Identifier: MIT
"""Kernels leave out what belongs to plastic flow where no cell of a batch yields: that must not be seen."""

import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact.assembly.inelastic_part import InelasticPart
from dolfinx_impact.assembly.operators import InternalForce, cells_measure

# Widths differ in the instructions that the compiler makes of one source, and in their vector functions, which are two
# units in the last place off: sums of some hundred terms.
ROUND_OFF = 1e-13
# In finite strain stress is mu times the difference of numbers of the size 1, with some five units of 2.2e-16 of each.
FINITE_ROUND_OFF = 1e-15 * 385.0 * 0.25  # mu times the area of a cell's largest facet
STRAIN = 0.008  # a half of the cells yields
LAWS = {
    "small-Voce": dict(hardening=di.Voce(2.0, 30.0, 10.0)),
    "small-recovery": dict(hardening=50.0, kinematic=di.ArmstrongFrederick(20.0, 5.0)),
    "finite-linear": dict(hardening=50.0, finite_strain=True),
    "finite-Voce": dict(hardening=di.Voce(2.0, 30.0, 10.0), finite_strain=True),
    "finite-back-stress": dict(hardening=50.0, kinematic=20.0, finite_strain=True),
}


def body(strain):
    """Displacement of a cube whose left half hardly deforms, whose right half does, with noise in between."""
    cube = mesh.create_unit_cube(MPI.COMM_SELF, 6, 2, 2, mesh.CellType.hexahedron)
    u = fem.Function(fem.functionspace(cube, ("Lagrange", 1, (3,))), name="u")
    rng = np.random.default_rng(5)
    u.interpolate(lambda x: strain * np.array([0.1 * x[1] * x[0], x[0] ** 6, 0.2 * x[0] ** 6]))
    u.x.array[:] += 1e-3 * strain * rng.uniform(-1.0, 1.0, u.x.array.shape)
    return u


def evaluate(width, law, strains):
    """Force, history and the share of the points of each cell that flow, for each of some increments."""
    u = body(0.0)
    material = di.J2Plasticity(1e3, 0.3, 1.0, yield_stress=1.0, **law)
    dx, degree = cells_measure(u, material)
    part = InelasticPart(u, material, dx, degree, None)
    form, point_law = part.force(ufl.TestFunction(u.function_space))
    operator = InternalForce(form, law=point_law, width=width)
    found = []
    for strain in strains:
        u.x.array[:] = body(strain).x.array
        before = operator.history.values("plastic_strain")
        force = operator.apply().array.copy()
        operator.history.commit()
        history = {name: operator.history.values(name) for name in operator.history.state_names}
        found.append((force, history, np.mean(history["plastic_strain"] > before, axis=(1, 2))))
    return found


@pytest.mark.parametrize("width", (4, 8))
@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_cells_that_yield_beside_cells_that_do_not(law, width):
    """Oracle: the cells one by one, where all that a cell needs is evaluated, and no other cell's."""
    strains = (STRAIN, 1.2 * STRAIN, 0.9 * STRAIN)  # the third unloads
    expected = evaluate(1, law, strains)
    batches = expected[1][2].reshape(-1, width)
    kinds = {(bool(np.any(b > 0.0)), bool(np.any(b < 1.0))) for b in batches}
    assert {(True, True), (False, True)} <= kinds  # batches in which some points flow, and in which none does
    for (force, history, share), (force_1, history_1, share_1) in zip(evaluate(width, law, strains), expected):
        limit = ROUND_OFF * np.max(np.abs(force_1))
        if law.get("finite_strain"):
            limit = max(limit, FINITE_ROUND_OFF)
        assert np.max(np.abs(force - force_1)) < limit
        for name, values in history.items():
            assert np.max(np.abs(values - history_1[name])) < ROUND_OFF * max(1.0, np.max(np.abs(history_1[name])))
        assert np.array_equal(share, share_1)


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_an_elastic_step_leaves_the_history_alone(law):
    """To the last bit, but for kinematic hardening of finite strain, which computes C_p anew in the frame of U."""
    (_, before, _), (_, after, share) = evaluate(0, law, (STRAIN, 0.99 * STRAIN))
    elastic = share == 0.0
    assert np.any(before["plastic_strain"][elastic] > 0.0)
    for name, values in after.items():
        largest = np.max(np.abs(values - before[name])[elastic])
        assert largest < ROUND_OFF if law.get("finite_strain") and "kinematic" in law else largest == 0.0, name
