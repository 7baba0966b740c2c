# SPDX-License-Identifier: MIT
"""Node-to-surface penalty: forces against plain NumPy, what must be conserved, the bound of the stiffness."""

import numpy as np
import pytest
from mpi4py import MPI
from nodal_model import Nodal, partitioned_bodies, smooth
from nodal_oracle import Oracle

CELLS = [("quadrilateral", 1), ("triangle", 2), ("hexahedron", 1), ("tetrahedron", 1), ("hexahedron", 2)]
CELLS += [("tetrahedron", 2), ("quadrilateral", 2)]
SAME = 1e-11  # relative to the largest force: Newton's method ends within 1e-13 of the same point


def with_oracle(cell, degree, **options):
    dim = 2 if cell in ("triangle", "quadrilateral") else 3
    V, slave, master = partitioned_bodies.two_bodies(
        MPI.COMM_SELF, dim, cell, 1, degree, offset=(0.07,) * (dim - 1), gap=-0.004
    )
    model = Nodal(V, slave, master, **options)
    return model, Oracle(model, slave, master, **options)


def moments(x, f):
    """Resultant and moment."""
    x, f = np.pad(x, ((0, 0), (0, 3 - x.shape[1]))), np.pad(f, ((0, 0), (0, 3 - f.shape[1])))
    return f.sum(axis=0), np.cross(x, f).sum(axis=0)


@pytest.mark.parametrize("friction", (0.0, 0.4))
@pytest.mark.parametrize("cell,degree", CELLS)
def test_forces_are_those_of_the_oracle(cell, degree, friction):
    """Eight steps of a smooth motion in which nodes stick, slip, open and close."""
    model, oracle = with_oracle(cell, degree, friction=friction)
    before, statuses = smooth(model.x, 0.03), set()
    for step in range(8):
        u = smooth(model.x, 0.03, 0.4 * step)
        du = u - before
        before = u
        f, expected = model.forces(u, du), oracle.forces(u, du)
        size = np.abs(expected).max()
        assert size > 0 and np.abs(f - expected).max() < SAME * size
        results, energy = model.contact.results(), model.contact.energy()
        nodes = model.contact.nodes
        assert np.array_equal(nodes, oracle.nodes)
        assert np.allclose(model.contact.areas, oracle.A[nodes], rtol=1e-4)
        assert np.allclose(results["slip"], oracle.slip[nodes], atol=1e-12)
        assert np.allclose(results["stiffness"], oracle.k, rtol=1e-9)
        assert np.isclose(energy["stored"], oracle.stored, rtol=1e-9)
        assert np.isclose(energy["friction"], oracle.dissipated, rtol=1e-9)
        assert np.isclose(-energy["normal"], oracle.lost, rtol=1e-9)
        assert np.isclose(model.contact.force, oracle_force(f, nodes)).all()
        # Equal and opposite, also their moments.
        resultant, moment = moments(model.x + u, f)
        assert np.abs(resultant).max() < 1e-14 * np.abs(f).sum() and np.abs(moment).max() < 1e-13 * np.abs(f).sum()
        # In the cone.
        tangential = f[nodes] - np.sum(f[nodes] * results["normal"], axis=1)[:, None] * results["normal"]
        limit = friction * results["pressure"] * model.contact.areas
        assert np.all(np.linalg.norm(tangential, axis=1) <= limit * (1 + 1e-12) + 1e-13 * size)
        statuses |= set(results["status"])
    assert statuses == ({0, 1, 2} if friction else {0, 2}), statuses


def oracle_force(f, nodes):
    return f[nodes].sum(axis=0)


@pytest.mark.parametrize("cell,degree", (("triangle", 2), ("hexahedron", 1)))
def test_balanced_contact_is_two_contacts_of_half_the_penalty(cell, degree):
    """Forces and energies are the sums, the force on the slave is the difference of both sides' forces."""
    dim = 2 if cell == "triangle" else 3
    V, slave, master = partitioned_bodies.two_bodies(
        MPI.COMM_SELF, dim, cell, 1, degree, offset=(0.07,) * (dim - 1), gap=-0.004
    )
    both = Nodal(V, slave, master, balanced=True, penalty=2e4, friction=0.3)
    alone = [Nodal(V, *surfaces, penalty=1e4, friction=0.3) for surfaces in ((slave, master), (master, slave))]
    before = smooth(both.x, 0.03)
    for step in range(4):
        u = smooth(both.x, 0.03, 0.4 * step)
        f, parts = both.forces(u, u - before), [model.forces(u, u - before) for model in alone]
        before = u
        np.testing.assert_allclose(f, sum(parts), rtol=0, atol=1e-14 * np.abs(f).max())  # summed in another order
        for side, model in zip(both.sides, alone):
            assert not side.saved_state().difference_of_values(model.contact.saved_state())
    assert all(np.any(np.asarray(model.contact.force)) for model in alone)
    np.testing.assert_array_equal(both.pair.force[:dim], alone[0].contact.force - alone[1].contact.force)
    for name, value in both.pair.energy().items():
        assert value == sum(model.contact.energy()[name] for model in alone)
    assert both.pair.energy()["stored"] > 0.0


@pytest.mark.parametrize("share", (0.0, -0.5, 1.5, np.nan))
def test_a_share_of_the_stiffness_is_a_part(share):
    with pytest.raises(ValueError, match="share of a contact's stiffness"):
        with_oracle("quadrilateral", 1, share=share)
