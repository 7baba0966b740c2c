# SPDX-License-Identifier: MIT
"""Nodal forces of loads that do not follow the body, in closed form. See on_ranks.py."""

import numpy as np
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact.loads import DeadLoad

COMM, CELLS, WIDTH = MPI.COMM_WORLD, 4, 2.0
ROUND_OFF = 1e-13


class Loaded:
    """A strip of 0 <= x <= 2, 0 <= y <= 1 whose upper side bears a traction."""

    def __init__(self, vector):
        domain = mesh.create_rectangle(COMM, [[0, 0], [WIDTH, 1]], [CELLS, 2], mesh.CellType.quadrilateral)
        self.V = fem.functionspace(domain, ("Lagrange", 1, (2,)))
        top = mesh.locate_entities_boundary(domain, 1, lambda x: np.isclose(x[1], 1.0))
        tags = mesh.meshtags(domain, 1, np.sort(top), np.full(len(top), 1, dtype=np.int32))
        self.load = di.Traction(tags, 1, vector(domain) if callable(vector) else vector)
        law = di.LinearElastic(1.0, 0.3, 1.0, "plane_strain")
        form = self.load.form(fem.Function(self.V), ufl.TestFunction(self.V), law)
        self.dead = DeadLoad(self.load, form, self.V)
        self.x = self.V.tabulate_dof_coordinates()[self.dead.dofs // 2]
        self.axis = self.dead.dofs % 2


def check_a_uniform_traction_acts_on_the_nodes_of_its_side():
    """With the length of two half cells at each node, of one at the ends; in directions without a load, too."""
    loaded = Loaded((3.0, 0.0))
    assert np.allclose(loaded.x[:, 1], 1.0)
    assert COMM.allreduce(len(loaded.dead.dofs)) == 2 * (CELLS + 1)  # any value of the load may be set later
    ends = np.isclose(loaded.x[:, 0], 0.0) | np.isclose(loaded.x[:, 0], WIDTH)
    inner = np.where(ends, 0.5, 1.0) * WIDTH / CELLS
    expected = np.where(loaded.axis == 0, 3.0 * inner, 0.0)
    np.testing.assert_allclose(loaded.dead.values(), expected, atol=3.0 * ROUND_OFF)


def check_a_traction_that_varies_has_its_resultant_and_moment():
    """q = x along y: the resultant is 2, its moment about the origin 8/3."""
    loaded = Loaded(lambda domain: ufl.as_vector([0.0, ufl.SpatialCoordinate(domain)[0]]))
    forces = loaded.dead.forces()
    up = loaded.axis == 1
    assert abs(COMM.allreduce(forces[up].sum()) - WIDTH**2 / 2) < ROUND_OFF * 10
    assert abs(COMM.allreduce((forces * loaded.x[:, 0])[up].sum()) - WIDTH**3 / 3) < ROUND_OFF * 10
    assert COMM.allreduce(np.abs(forces[~up]).sum()) < ROUND_OFF


def check_changes_are_seen_until_the_values_are_taken():
    loaded = Loaded((1.0, -2.0))
    dead, constant = loaded.dead, loaded.load.constant
    before = dead.values()
    assert not dead.changed()
    constant.value[:] = (2.0, -4.0)
    assert dead.changed()
    np.testing.assert_allclose(dead.forces(), 2.0 * before, rtol=ROUND_OFF)
    assert dead.changed()  # `forces` takes no note of them
    dead.values()
    assert not dead.changed()
