# SPDX-License-Identifier: MIT
"""Plastic flow under a rolling pressure: the steady state in the ALE frame against load steps; benchmark J-4."""

import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from meshes_and_supports import clamp, rectangle, tagged

import dolfinx_impact as di

Y = 780.0
PEAK, AT, PROFILE = 4.0 * Y / np.sqrt(3), 1.5, -1.5  # Hertz's pressure, half-width 1; where it is, and the profile


class Block:
    """A block in plane strain under Hertz's pressure, cells of 1/4 of the half-width down to twice of it."""

    def __init__(self, width, centre, n=4):
        y = np.concatenate([np.linspace(0, 2, 2 * n + 1), 2 + np.cumsum(1.5 ** np.arange(1, 4) / n)])
        m = len(y) - 1
        self.mesh = rectangle("quadrilateral", (0.0, 0.0), (1.0, 1.0), (int(width * n), m))
        x = self.mesh.geometry.x
        x[:, 0], x[:, 1] = width * (x[:, 0] - 0.5), -y[::-1][np.rint(x[:, 1] * m).astype(int)]
        tags = tagged(
            self.mesh,
            top=lambda x: np.isclose(x[1], 0),
            bottom=lambda x: np.isclose(x[1], -y[-1]),
            sides=lambda x: np.isclose(np.abs(x[0]), width / 2),
        )
        self.V = fem.functionspace(self.mesh, ("Lagrange", 1, (2,)))
        self.centre, self.factor = fem.Constant(self.mesh, centre), fem.Constant(self.mesh, 1.0)
        x = ufl.SpatialCoordinate(self.mesh)
        pressure = self.factor * PEAK * ufl.sqrt(ufl.max_value(1 - (x[0] - self.centre) ** 2, 0.0))
        self.loads = [di.Traction(tags, 1, ufl.as_vector([0.0 * x[0], -pressure]))]
        self.bcs = [clamp(self.V, tags, 2), clamp(self.V, tags, 3, 0)]
        self.steel = di.J2Plasticity(
            207e3, 0.3, yield_stress=Y, hardening=20e3, density=7.85e-9, hypothesis="plane_strain"
        )

    @staticmethod
    def profile(history):
        """Depths, plastic strain and stress along the profile, means over the two points of a cell at a depth."""
        out = []
        for name in ("plastic_strain", "stress"):
            field = history[name]
            space, values = field.function().function_space, field.values.reshape(len(field.values), -1, *field.shape)
            places = space.tabulate_dof_coordinates()[space.dofmap.list[: len(values)]]
            off = np.abs(places[..., 0] - PROFILE)
            near = off < off.min() + 1e-9
            order = np.argsort(-places[near][:, 1], kind="stable")
            out.append(values[near][order].reshape(-1, 2, *field.shape).mean(axis=1))
        return -places[near][order].reshape(-1, 2, 3).mean(axis=1)[:, 1], *out


@pytest.mark.slow
def test_a_rail_that_flows_under_hertz_pressure():
    """The profile of plastic strain and of stress behind the load against load steps of half a cell.

    The pressure rolls by 9 half-widths in load steps, and stays where that of the steady state is. Behind it a steady
    state has come about over so much of the length, not over all of it: 5 % of the largest plastic strain, 10 % of the
    yield stress. Above a depth of 0.7 half-widths, three cells, plastic strain depends on where the pressure lies
    against the cells, which changes in load steps only: 20 %.
    """
    width = 20.0
    block = Block(width, AT)
    num = block.mesh.topology.index_map(2).size_local
    cells = mesh.meshtags(block.mesh, 2, np.arange(num, dtype=np.int32), np.full(num, 1, np.int32))
    rolling = di.RollingProblem(
        fem.Function(block.V), block.steel, cells, {1: di.Translation((-1.0, 0.0))}, bcs=block.bcs, loads=block.loads
    )
    assert rolling.solve().converged
    depth, plastic, stress = block.profile(rolling.history)
    other, step = Block(width, AT - 9.0), 0.125
    problem = di.StaticProblem(fem.Function(other.V), other.steel, bcs=other.bcs, loads=other.loads)
    for other.factor.value in np.linspace(0.2, 1.0, 5):
        problem.solve()
    for other.centre.value in np.linspace(AT - 9.0 + step, AT, round(9.0 / step)):
        problem.solve()
    _, expected, wanted = other.profile(problem.history)
    largest, deep = expected.max(), depth > 0.7
    print(np.column_stack([depth, plastic, expected, stress[:, 0], wanted[:, 0]]))
    assert largest > 3e-3 and np.all(plastic[depth > 2.5] == 0.0)
    assert np.abs(plastic - expected)[deep].max() < 0.05 * largest
    assert np.abs(plastic - expected).max() < 0.2 * largest
    assert np.abs(stress - wanted)[deep].max() < 0.1 * Y
