# SPDX-License-Identifier: MIT
"""Augmented penalty contact of facets that the master covers in part, and what the automatic penalty costs."""

import numpy as np
import pytest
from dolfinx import fem, mesh
from plane_bodies import Bodies

import dolfinx_impact as di

APPROACH = 0.01


def pressed(bodies, method, slave, height=1.0):
    """Upper body pressed on the lower one by prescribed displacements of their outer sides: contact, force."""
    V, X = bodies.V, bodies.X
    low = np.flatnonzero(np.isclose(X[:, 1], 0.0)).astype(np.int32)
    high = np.flatnonzero(np.isclose(X[:, 1], height)).astype(np.int32)
    bcs = [fem.dirichletbc(np.array([0.0, d]), dofs, V) for d, dofs in ((0.0, low), (-APPROACH * height, high))]
    sides = (1, "bottom"), (0, "top")
    pair = bodies.pair(*sides) if slave == "upper" else bodies.pair(*reversed(sides))
    problem = di.StaticProblem(fem.Function(V), bodies.law, bcs=bcs, contact=[method(pair)])
    problem.solve()
    return problem.contact[0]


@pytest.mark.long_rows(
    where=lambda shift, slave: (shift, slave) not in ((0.1, "lower"), (0.37, "upper"), (0.9, "upper"))
)
@pytest.mark.parametrize("slave", ("lower", "upper"))
@pytest.mark.parametrize("shift", (0.03, 0.1, 0.37, 0.9))
def test_augmented_contact_of_blocks_that_overhang(shift, slave):
    """Forces are those of multipliers to 1 %: multipliers of both kinds are linear on facets of an eighth, a seventh.
    The penetration is within 1.5 % of the approach at all points, where the edge presses into a facet; it was 3 %."""
    boxes = ((0, 0), (1, 0.5), (8, 4), (0, 0)), ((shift, 0.5), (1 + shift, 1.0), (7, 4), (0, 0))
    forces = {}
    for name, method in (("multipliers", di.Lagrange), ("augmented", lambda p: di.Penalty(p, augmented=True))):
        contact = pressed(Bodies(*boxes, nu=0.3, law=di.LinearElastic), method, slave)
        forces[name] = abs(contact.force[1])
        if name == "augmented":
            assert contact.gap.min() > -0.015 * APPROACH and contact.uzawa.rounds < 100
    np.testing.assert_allclose(forces["augmented"], forces["multipliers"], rtol=0.01)


@pytest.mark.parametrize("cells", (1, 2, 6, 12))
@pytest.mark.parametrize("ratio", (1.0, 1e3))
def test_the_automatic_penalty_costs_little(cells, ratio):
    """Bars without lateral strain: the exact force is known, and the penetration takes less than a tenth of the softer
    body's outermost cells of it, with one cell through each body, too, and with bodies of different stiffness."""
    along = 2 * cells
    bodies = Bodies(((0, 0), (1, 0.5), (along, cells), (0, 0)), ((0, 0.5), (1, 1), (along + 1, cells), (0, 0)), E=1e3)
    E = np.array([1.0, ratio]) * 1e3
    where = mesh.compute_midpoints(bodies.mesh, 2, np.arange(len(bodies.V.dofmap.list), dtype=np.int32))[:, 1] > 0.5
    tags = mesh.meshtags(bodies.mesh, 2, np.arange(len(where), dtype=np.int32), where.astype(np.int32) + 1)
    laws = {k + 1: di.LinearElastic(E[k], 0.0, 1.0, "plane_strain") for k in range(2)}
    bodies.law = di.MaterialMap(tags, laws)
    contact = pressed(bodies, di.Penalty, "upper")
    exact = APPROACH / (0.5 / E[0] + 0.5 / E[1])
    assert (1.0 - 0.1 / cells) * exact < abs(contact.force[1]) <= exact * (1 + 1e-9)
