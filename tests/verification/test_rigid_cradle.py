# SPDX-License-Identifier: MIT
"""Newton's cradle: a deformable disc between two rigid ones of the same mass, one of which strikes it."""

import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di

RADIUS, VELOCITY = 1.0, 0.02


def round_disc(cells):
    """A disc of radius one from a square, and its boundary as the tag 1 (left half) and 2 (right half)."""
    domain = mesh.create_rectangle(MPI.COMM_SELF, [[-1, -1], [1, 1]], [cells] * 2, mesh.CellType.quadrilateral)
    x, y = domain.geometry.x[:, 0].copy(), domain.geometry.x[:, 1].copy()
    domain.geometry.x[:, 0], domain.geometry.x[:, 1] = x * np.sqrt(1 - y**2 / 2), y * np.sqrt(1 - x**2 / 2)
    domain.topology.create_connectivity(1, 2)
    rim = mesh.exterior_facet_indices(domain.topology)
    middle = mesh.compute_midpoints(domain, 1, rim)
    tags = mesh.meshtags(domain, 1, rim, np.where(middle[:, 0] < 0.0, 1, 2).astype(np.int32))
    return fem.functionspace(domain, ("Lagrange", 1, (2,))), tags


@pytest.mark.slow
def test_the_last_disc_takes_the_velocity_of_the_first():
    """Momentum to round-off, energy, and nearly all of the velocity goes to the last disc: it is slow against waves."""
    V, tags = round_disc(24)
    law = di.NeoHookean(E=1000.0, nu=0.3, density=1.0, hypothesis="plane_strain")
    u = fem.Function(V)
    mass = fem.assemble_scalar(fem.form(fem.Constant(V.mesh, 1.0) * ufl.dx(V.mesh)))
    discs = [
        di.RigidBody(
            di.RigidCylinder((side * 2.001, 0.0), RADIUS), mass=mass, inertia=0.5 * mass * RADIUS**2,
            velocity=(VELOCITY if side < 0 else 0.0, 0.0),
        )
        for side in (-1, 1)
    ]  # fmt: skip
    contacts = [di.Penalty(di.ContactPair(tags, tag, disc)) for tag, disc in zip((1, 2), discs)]
    run = di.ExplicitProblem(u, law, contact=contacts)
    run.advance(until=2.5, progress=False)
    m = run.mass.array[: run.num_owned].reshape(-1, 2)[:, 0]
    middle = m @ run.velocity.x.array.reshape(-1, 2)[:, 0] / m.sum()
    first, last = (disc.velocity[0] for disc in discs)
    total = mass * (first + last) + m.sum() * middle
    assert total == pytest.approx(mass * VELOCITY, rel=1e-11)
    assert abs(run.energy["drift"]) < 1e-3
    assert all(np.all(disc.force == 0.0) for disc in discs), "they have parted"
    assert last > 0.93 * VELOCITY and abs(first) < 0.07 * VELOCITY and abs(middle) < 0.07 * VELOCITY
    assert abs(discs[1].velocity[1]) < 1e-10 and abs(discs[1].spin[2]) < 1e-10
