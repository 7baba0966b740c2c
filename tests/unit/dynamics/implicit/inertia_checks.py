# SPDX-License-Identifier: MIT
"""Mass matrices of implicit problems by the kinetic energy of motions that are known. See on_ranks.py."""

import numpy as np
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact.dynamics.implicit.inertia import Inertia
from dolfinx_impact.dynamics.implicit.mass_redistribution import MassRedistribution

COMM, DENSITY, WIDTH = MPI.COMM_WORLD, 3.0, 2.0
ROUND_OFF = 1e-13


class Strip:
    """A strip 0 <= x <= 2, 0 <= y <= 1 of squares whose lower side may come into contact."""

    def __init__(self, lumping=None, redistributed=False):
        domain = mesh.create_rectangle(COMM, [[0, 0], [WIDTH, 1]], [8, 4], mesh.CellType.quadrilateral)
        self.V = fem.functionspace(domain, ("Lagrange", 1, (2,)))
        bottom = mesh.locate_entities_boundary(domain, 1, lambda x: np.isclose(x[1], 0.0))
        tags = mesh.meshtags(domain, 1, np.sort(bottom), np.full(len(bottom), 1, dtype=np.int32))
        pair = di.ContactPair(tags, 1, di.RigidPlane((0.0, 0.0), (0.0, 1.0)))
        surface = MassRedistribution(self.V, [pair]) if redistributed else None
        self.owned = 2 * self.V.dofmap.index_map.size_local
        fixed = np.zeros(self.owned, dtype=bool)
        self.inertia = Inertia(self.V, [(None, DENSITY)], "plane_strain", None, lumping, surface, fixed)
        self.x = self.V.tabulate_dof_coordinates()[: self.owned // 2]

    def product(self, a, b):
        """a M b of two velocity fields, functions of the positions, of all ranks."""
        a, b = (np.asarray(field(self.x[:, 0], self.x[:, 1]), dtype=float).T.ravel() for field in (a, b))
        return COMM.allreduce(a @ self.inertia.times(b))


def along_x(x, y):
    return np.ones_like(x), np.zeros_like(x)


def along_y(x, y):
    return np.zeros_like(x), np.ones_like(x)


def stretching(x, y):
    return x, np.zeros_like(x)


def check_translations_have_the_whole_mass():
    """Lumped or consistent, with the mass of contact nodes or without; the directions do not mix."""
    for lumping in (None, "row_sum"):
        for redistributed in (False, True):
            strip = Strip(lumping, redistributed)
            for field in (along_x, along_y):
                assert abs(strip.product(field, field) / (DENSITY * WIDTH) - 1) < ROUND_OFF
            assert abs(strip.product(along_x, along_y)) < ROUND_OFF
            total = COMM.allreduce(strip.inertia.total.array[: strip.owned].sum())
            assert abs(total / (2 * DENSITY * WIDTH) - 1) < ROUND_OFF  # of both directions, wherever it goes


def check_a_consistent_mass_has_the_energy_of_a_stretching_motion():
    """The velocity (x, 0) is in the space: rho times the integral of x^2. Lumped masses have a trapezoidal sum."""
    exact = DENSITY * WIDTH**3 / 3
    assert abs(Strip().product(stretching, stretching) / exact - 1) < ROUND_OFF
    h = WIDTH / 8
    trapezoidal = DENSITY * (WIDTH**3 / 3 + WIDTH * h**2 / 6)
    assert abs(Strip("row_sum").product(stretching, stretching) / trapezoidal - 1) < ROUND_OFF


def check_contact_nodes_have_no_mass_and_the_momentum_stays():
    """A velocity of the lower nodes alone has no energy; what the cells move on with is what they had."""

    def lower(x, y):
        return np.zeros_like(x), np.isclose(y, 0.0).astype(float)

    for lumping in (None, "row_sum"):
        strip = Strip(lumping, redistributed=True)
        on_surface = np.repeat(np.isclose(strip.x[:, 1], 0.0), 2)
        np.testing.assert_array_equal(strip.inertia.massless, on_surface)
        assert abs(strip.product(lower, lower)) < ROUND_OFF
        assert abs(strip.product(lower, along_y)) < ROUND_OFF  # nor any momentum
        whole = Strip(lumping)
        assert whole.product(lower, lower) > 0.1 and not whole.inertia.massless.any()
