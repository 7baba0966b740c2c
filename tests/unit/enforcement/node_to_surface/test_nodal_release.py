# SPDX-License-Identifier: MIT
"""Nodes that leave kinematic contact: the energy given back is bounded in arbitrary states, momentum is kept."""

import numpy as np
import pytest
from nodal_model import moved_obstacle, smooth, two_bodies

CELLS = pytest.mark.parametrize(
    "cell,degree",
    [("quadrilateral", 1), ("quadrilateral", 2), ("triangle", 1), ("hexahedron", 1), ("tetrahedron", 1)],
)


def leaving(model, rng, absorbed=1.0, impulse=1e9, share=1.0):
    """A step in which nodes that were closed move away at random speeds.

    Args:
        absorbed: upper bound of the energies that contact has absorbed. impulse: of the last normal forces.

    Returns:
        Displacements at the step's begin, increments, forces, energy the nodes may be given back.
    """
    start = smooth(model.x, 0.012, 0.4)
    if hasattr(model, "obstacle"):
        start[:, -1] -= 0.1
    model.correct(start, np.zeros_like(start))
    state = model.contact.saved_state()
    closed = model.contact.results()["status"] > 0
    assert np.count_nonzero(closed) >= 3
    state.array("absorbed_energy")[:] = np.where(closed, rng.uniform(0.0, absorbed, len(closed)), 0.0)
    state.array("impulse")[:] = np.where(closed, impulse, 0.0)
    model.contact.resume(state)
    du = rng.normal(0.0, 2e-3, start.shape)
    du[model.slave_body, -1] += 0.05 if not hasattr(model, "obstacle") else 0.3
    u, f = model.spread(start + du), np.zeros((model.halo.num_nodes, model.dim))
    model.contact.correct(
        model.halo, u.reshape(-1), model.spread(du).reshape(-1), model.inverse, model.dt**2, model.dt, f.reshape(-1),
        share,
    )  # fmt: skip
    return start, u[: model.num] - start, f[: model.num], share * state.array("absorbed_energy").sum()


@CELLS
@pytest.mark.parametrize("share", (1.0, 0.3))
def test_release_returns_at_most_the_absorbed_energy(cell, degree, share):
    """Work of the forces in the step's motion, before (none) and after: no more than the bound, and most of it where
    nodes share few masters."""
    rng = np.random.default_rng(5)
    given = []
    for _ in range(5):
        model = two_bodies(cell, degree, kinematic=True)
        start, du, f, bound = leaving(model, rng, share=share)
        work = 0.5 * np.sum(f * du)  # nothing moved in the step before
        assert 0.0 < work <= bound * (1 + 1e-12)
        given.append(work / bound)
        total = np.abs(f).sum()
        assert np.abs(f.sum(axis=0)).max() < 1e-14 * total
        x, flat = (np.pad(a, ((0, 0), (0, 3 - model.dim))) for a in (model.x + start, f))
        assert np.abs(np.cross(x, flat).sum(axis=0)).max() < 1e-13 * np.abs(x).max() * total
    assert max(given) > 0.3


def test_the_impulse_bounds_it_too():
    """The impulse of a release is bounded by that of the last steps, whatever energy was absorbed earlier."""
    model = moved_obstacle("quadrilateral", kinematic=True)
    impulse = 1e-6
    _, _, f, _ = leaving(model, np.random.default_rng(1), impulse=impulse)
    pushed = f[f[:, 1] > 0.0, 1]
    np.testing.assert_allclose(pushed * model.dt, impulse, rtol=1e-12)


def test_a_rigid_master_gives_all_back():
    """One node after the other: the kinetic energy of each rises by the energy absorbed from it."""
    model = moved_obstacle("quadrilateral", kinematic=True)
    start, du, f, bound = leaving(model, np.random.default_rng(2))
    assert np.isclose(0.5 * np.sum(f * du), bound, rtol=1e-12)


def test_it_is_given_back_once():
    model = moved_obstacle("quadrilateral", kinematic=True)
    start, du, f, _ = leaving(model, np.random.default_rng(3))
    assert np.abs(f).max() > 0.0
    state = model.contact.saved_state()
    assert not state.array("absorbed_energy").any() and not state.array("impulse").any()
    _, f = model.correct(start + 2 * du, du, search=False)
    assert not f.any() and not model.contact.results()["status"].any()
