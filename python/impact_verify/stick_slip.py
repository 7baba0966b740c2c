# SPDX-License-Identifier: MIT
"""Level contact: friction that falls with the slip velocity, by multipliers in time, against the hand-written mass."""

from __future__ import annotations

import math
from typing import Any

import impact_reference
import numpy as np
from dolfinx import fem, mesh
from mpi4py import MPI

from dolfinx_impact import (
    ContactPair, Foundation, FrictionLaw, Lagrange, LinearElastic, NewmarkProblem, RigidPlane, Traction, interface,
)  # fmt: skip
from .report import Report

# The block, its floor, and its steps.
HEIGHT, BLOCK, FLOOR, ROUND, ROUNDS = 0.25, 1e6, 0.4, 0.05, 60
# The block is 1e6 times stiffer than its springs. As it comes to rest on the floor it begins to shear to and fro, by
# 1e-3 of its motion's size at most, undamped; this decides when it slips again.
STICK_SLIP = 1e-3
STICK_SLIP_REASON = "the block, 1e6 times stiffer than its springs, shears to and fro while it sticks"


def run(report: Report) -> None:
    """Add the rows in the plane and in space.

    Args:
        report: report to add to.
    """
    for gdim, cell in ((2, "quadrilateral"), (3, "hexahedron")):
        if report.wants(cell, 1):
            compare(report, gdim, cell)


def compare(report: Report, gdim: int, cell: str) -> None:
    """Add the row of friction that falls with the slip velocity, by multipliers in time: a block on a moving floor,
    held by springs, against a mass on a floor. It slips at first, sticks, and slips back.

    Args:
        report: report to add to.
        gdim: dimension of space [1].
        cell: name of the row's cell.
    """
    count, size = np.ones(gdim, dtype=int), np.full(gdim, 1.0)
    size[-1] = HEIGHT
    domain: Any = mesh.create_rectangle if gdim == 2 else mesh.create_box
    block = domain(MPI.COMM_SELF, [np.zeros(gdim), size], count, mesh.CellType[cell])
    sides = [
        mesh.locate_entities_boundary(block, gdim - 1, lambda x, z=z: np.isclose(x[gdim - 1], z)) for z in (0, HEIGHT)
    ]
    facets, values = np.concatenate(sides), np.repeat([1, 2], [len(s) for s in sides]).astype(np.int32)
    order = np.argsort(facets)
    tags = mesh.meshtags(block, gdim - 1, facets[order], values[order])
    V = fem.functionspace(block, ("Lagrange", 1, (gdim,)))
    u = fem.Function(V)
    u.interpolate(lambda x: np.vstack([np.zeros((gdim - 1, x.shape[1])), -x[gdim - 1] / BLOCK]))
    hypothesis = "plane_strain" if gdim == 2 else "3d"
    material = LinearElastic(BLOCK, 0.0, density=1.0 / HEIGHT, hypothesis=hypothesis)
    along, up = np.eye(gdim)[0], np.eye(gdim)[-1]
    floor = RigidPlane(np.zeros(gdim), up)
    floor.motion = lambda t: (FLOOR * t, 0.0, 0.0)
    law = FrictionLaw(interface.falling_friction(0.5, 0.2, 0.3))
    held = []
    if gdim == 3:
        across, _ = V.sub(1).collapse()
        dofs = fem.locate_dofs_geometrical((V.sub(1), across), lambda x: np.full(x.shape[1], True))
        held = [fem.dirichletbc(fem.Function(across), dofs, V.sub(1))]
    problem = NewmarkProblem(
        u, material, bcs=held, loads=[Foundation(tags, 1, tuple(along)), Traction(tags, 2, tuple(-up))],
        contact=[Lagrange(ContactPair(tags, 1, floor, friction=law))],
    )  # fmt: skip
    found: list[float] = []
    problem.advance(
        ROUNDS * ROUND, dt=ROUND, progress=False, callback=lambda p: found.append(float(p.u.x.array[::gdim].mean()))
    )
    mass = impact_reference.SlidingMass(1.0, 1.0, 1.0, FLOOR, lambda v: 0.2 + 0.3 * math.exp(-v / 0.3))
    exact = mass.run(0.0, ROUND, ROUNDS)
    # The first record is the state before the first step; more of them are those of a step that was cut.
    worst = np.inf if len(found) != ROUNDS + 1 else float(np.abs(np.array(found[1:]) - exact).max() / exact.max())
    report.add(
        "contact", "contact.friction.stick_slip", cell, 1, 1, hypothesis, worst, STICK_SLIP, STICK_SLIP_REASON,
        name="displacement", note="" if worst <= STICK_SLIP else "the block does not stick and slip as the mass does",
    )  # fmt: skip
