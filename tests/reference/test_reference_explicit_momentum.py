# SPDX-License-Identifier: MIT
"""Linear and angular momentum in explicit contact of the hand-written solver, over the master and beside its rim."""

import impact_reference as ir
import numpy as np
import pytest
from contact_bodies import DEGREES
from contact_tip import DIMS, Tip
from reference_meshes import CELLS
from test_reference_explicit_contact import collision, spin_of

STICK, SLIP = 1, 2
# Nearly flush: nodes at one end are beside the rim, within a twentieth of a facet, and some pass it as they slide.
RIM = {"shift": -0.02, "speed": 0.5}


def beside(model, master, run):
    """How often a closed node is beside the master's ends along the first axis, by more than round-off."""
    d = model.points.shape[1]
    x = model.field_points[:, 0] + run.u.reshape(len(run.time), -1, d)[..., 0]
    contact, facets = run.contacts[0], np.unique(master)  # geometry nodes; at degree 1 field nodes
    ends = x[:, facets].min(1)[:, None], x[:, facets].max(1)[:, None]
    slave = x[:, contact.nodes]
    return np.sum((contact.status > 0) & ((slave < ends[0] - 1e-6) | (slave > ends[1] + 1e-6)))


@pytest.mark.covering(2)
@pytest.mark.parametrize("cell", CELLS)
@pytest.mark.parametrize("friction", [0.0, 0.4])
@pytest.mark.parametrize("kind", ["penalty", "balanced", "kinematic", "kinematic, 1 sweep"])
@pytest.mark.parametrize("where", ["inner", "rim"])
def test_momenta_are_kept(cell, friction, kind, where):
    model, slave, master, v0 = collision(cell, spin=1.0, **(RIM if where == "rim" else {"inner": True, "speed": 0.4}))
    contact = {
        "penalty": lambda: ir.NodalPenalty(slave, master, friction=friction),
        "balanced": lambda: ir.NodalPenalty(slave, master, friction=friction, balanced=True),
        "kinematic": lambda: ir.NodalKinematic(slave, master, friction=friction),
        "kinematic, 1 sweep": lambda: ir.NodalKinematic(slave, master, friction=friction, sweeps=1),
    }[kind]()
    run = model.run_explicit(0.8 * model.stable_step(), 200, v0=v0, contacts=[contact])
    spin, momentum, size = spin_of(model, run)
    # Round-off of 200 steps.
    assert np.abs(momentum - momentum[0]).max() < 1e-12 * size
    assert np.abs(spin - spin[0]).max() < 1e-12 * size
    assert (beside(model, master, run) > 0) == (where == "rim")
    status = run.contacts[0].status
    assert (status > 0).any() and (status == 0).any()
    assert friction == 0 or (status == STICK).any() and (status == SLIP).any()
    # The work of c_j is not friction.
    assert (run.energies["friction"][-1] > 0) if friction else (run.energies["friction"] == 0).all()
    # Penalty: closing and opening between two steps costs up to a tenth of the nodes' kinetic energy, nodes are up to a
    # third of the mass; those that pass the rim below the master take their spring's energy. Kinematic: round-off.
    assert np.abs(run.energies["drift"]).max() < (1e-12 if "kinematic" in kind else 0.05)


@pytest.mark.parametrize("cell", CELLS)
@pytest.mark.parametrize("degree, geometry_degree", DEGREES)
@pytest.mark.parametrize("kind", [ir.NodalPenalty, ir.NodalKinematic])
def test_forces_balance_at_every_degree(cell, degree, geometry_degree, kind):
    """Resultant and moment of every state about current positions, beside the rim; degree 1 on quadratic cells that
    are straight."""
    model, slave, master, v0 = collision(cell, "linear_elastic", degree, geometry_degree, gap=-0.01, spin=1.0, **RIM)
    rng = np.random.default_rng(0)
    u0 = 0.003 * rng.standard_normal(model.num_dofs)
    run = model.run_explicit(0.3 * model.stable_step(), 3, u0=u0, v0=v0, contacts=[kind(slave, master, friction=0.2)])
    d = model.points.shape[1]
    f = run.contacts[0].force.reshape(len(run.time), -1, d)
    x = model.field_points + run.u.reshape(f.shape)
    size = np.abs(f).sum()
    assert np.abs(run.contacts[0].traction).max() > 1e-3 * np.abs(f).max() > 0
    assert np.abs(f.sum(1)).max() < 1e-13 * size
    moments = x[..., 0] * f[..., 1] - x[..., 1] * f[..., 0] if d == 2 else np.cross(x, f)
    assert np.abs(moments.sum(1)).max() < 1e-13 * size
    assert np.allclose(run.contacts[0].total, f[:, run.contacts[0].nodes].sum(1), rtol=0, atol=1e-13 * size)


def interpolation(X, x):
    """Values at x of the Lagrange functions of the nodes X (m, k) of a facet: lines, triangles, quadrilaterals."""
    m, size = len(X), int(round(len(X) ** 0.5))
    if X.shape[1] == 1:
        powers = [(p,) for p in range(m)]
    elif m in (3, 6):
        powers = [(a, b) for a in range(m // 3 + 1) for b in range(m // 3 + 1 - a)]
    else:
        powers = [(a, b) for a in range(size) for b in range(size)]

    def monomials(y):
        return np.array([np.prod(y ** np.array(p)) for p in powers])

    return np.linalg.solve(np.array([monomials(y) for y in X]).T, monomials(x))


CASES = [(c, p, where) for c in CELLS for p in (1, 2) for where in ("inside", "beside", "axisymmetric")]
CASES = [case for case in CASES if case[2] != "axisymmetric" or DIMS[case[0]] == 2]


@pytest.mark.parametrize("cell, degree, where", CASES)
@pytest.mark.parametrize("kind", [ir.NodalPenalty, ir.NodalKinematic])
def test_forces_on_the_facet(cell, degree, where, kind):
    """c_j are the smallest forces that take the moment: by the pseudo-inverse of resultant and moment."""
    d, axisymmetric = DIMS[cell], where == "axisymmetric"
    place = {"inside": [0.7, 0.2, 0.0], "beside": [1.01, 0.3, 0.0], "axisymmetric": [1.7, 0.0, 0.0]}[where]
    path = np.tile(place[: d - 1] + [0.0], (3, 1))
    path[:, -1] = [-0.01, -0.02, -0.02]
    path[1:, 0] += [0.01, 0.025]
    tip, places = Tip(cell, path, degree, axisymmetric, start=float(axisymmetric), E=1e-18), path
    contact = kind(tip.slave, tip.master, friction=0.3)
    if kind is ir.NodalPenalty:
        run = tip.run(contact)
    else:
        run, places = tip.press(contact, [1, 1])
    n = 1  # with the motion of a step
    f, X = run.contacts[0].force[n].reshape(-1, d), tip.model.field_points
    masters = np.flatnonzero((np.abs(X[:, -1]) < 1e-12) & (tip.moves[:, 0] == 0))
    if cell == "tetrahedron":  # two triangles on top
        masters = masters[np.abs(f[masters]).max(1) > 0]
    foot = np.clip(path[n + (kind is ir.NodalKinematic)], axisymmetric, 1 + axisymmetric)[:-1]
    phi = interpolation(X[masters][:, :-1], foot)
    force, at = f[tip.node], places[n]
    assert force[-1] > 0 and force[0] < 0  # pushed up, held back by friction
    arm = phi @ X[masters] - at
    turn = [np.array([[-y[1], y[0]]]) if d == 2 else _cross(y) for y in X[masters]]
    matrix = np.vstack([np.tile(np.eye(d), len(masters)), np.hstack(turn)])
    moment = np.cross(arm, force) if d == 3 else [arm[0] * force[1] - arm[1] * force[0]]
    c = np.linalg.pinv(matrix) @ np.concatenate([np.zeros(d), moment])
    if axisymmetric:
        c[:] = 0
    else:
        assert np.abs(c).max() > 1e-3 * np.abs(force).max()
    assert np.allclose(f[masters], c.reshape(-1, d) - np.outer(phi, force), rtol=0, atol=1e-13 * np.abs(force).max())
    assert np.allclose(np.delete(f, [*masters, tip.node], axis=0), 0)


def _cross(y):
    """Matrix of y x."""
    return np.array([[0, -y[2], y[1]], [y[2], 0, -y[0]], [-y[1], y[0], 0]])
