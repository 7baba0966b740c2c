# SPDX-License-Identifier: MIT
"""Penalty forces: balance, energy, tangent by finite differences; every facet, degree, obstacle and status."""

import numpy as np
import pytest
from petsc4py import PETSc
from penalty_model import CHI, Deformable, Rigid, dense, remember, smooth

# Cell, degree of the geometry, degree of the displacements.
KINDS = [
    ("quadrilateral", 1, 1),
    ("triangle", 1, 2),
    ("quadrilateral", 2, 1),
    ("triangle", 2, 2),
    ("tetrahedron", 1, 1),
    ("tetrahedron", 2, 2),
    ("tetrahedron", 2, 1),
    ("hexahedron", 1, 1),
    ("hexahedron", 1, 2),
    ("hexahedron", 2, 2),
    ("hexahedron", 2, 1),
]
OPEN, STICK, SLIP = range(3)
INSIDE, EDGE, VERTEX = range(3)  # of the master's facet
# A central difference with step h errs by h^2 times third derivatives, which are some 1e4 times the first near edges
# (1/gap^2), and by 1e-16/h of the force: h = 1e-6 leaves 1e-8 and 1e-10.
STEP, DIFFERENCE = 1e-6, 1e-6
ROUND_OFF = 1e-13  # sums of some hundred terms


def smooth_spot(model, rng, roughness, wanted):
    """A state and a direction along which no point changes its status within the step, with wanted kinds of points."""
    for _ in range(50):
        u = smooth(model.V, 0.03) + rng.uniform(-roughness, roughness, size=model.num)
        direction = rng.uniform(-1, 1, size=u.size)
        kinks = [model.kinks(u + s * STEP * direction) for s in (-1, 0, 1)]
        if (
            np.array_equal(kinks[0], kinks[1])
            and np.array_equal(kinks[2], kinks[1])
            and wanted <= set(model.points.status)
        ):
            return u, direction
    raise AssertionError("no smooth spot")


def check_derivatives(model, rng, potential, roughness=0.01, wanted=frozenset()):
    u, direction = smooth_spot(model, rng, roughness, wanted)
    K = dense(model, u)
    forces = [model.force(u + s * STEP * direction) for s in (-1, 1)]
    expected = -(forces[1] - forces[0]) / (2 * STEP)
    found = K @ direction
    assert np.abs(expected).max() > 0.1
    assert np.abs(found - expected).max() < DIFFERENCE * np.abs(expected).max()
    if potential:
        energies = [model.energy(u + s * STEP * direction) for s in (-1, 1)]
        slope = (energies[1] - energies[0]) / (2 * STEP)
        # 1e-16/h of the energy, which is about the size of the penetration times the force.
        assert abs(slope + model.force(u) @ direction) < 1e-8 * np.abs(model.force(u)).sum()
        assert np.abs(K - K.T).max() < ROUND_OFF * np.abs(K).max()
    return model.state(u)


@pytest.mark.parametrize("kind", KINDS, ids=lambda k: f"{k[0]}{k[1]}{k[2]}")
def test_frictionless(kind, rng):
    model = Deformable(*kind)
    state = check_derivatives(model, rng, potential=True)
    assert SLIP in state.status and STICK not in state.status


@pytest.mark.parametrize("kind", KINDS, ids=lambda k: f"{k[0]}{k[1]}{k[2]}")
@pytest.mark.parametrize("friction, status", [(100.0, STICK), (0.1, SLIP)])
def test_friction(kind, friction, status, rng):
    model = Deformable(*kind, friction=friction)
    remember(model, rng)
    state = check_derivatives(model, rng, potential=False)
    assert np.mean(state.status[state.status != OPEN] == status) > 0.6


@pytest.mark.parametrize("friction", (0.0, 0.5))
@pytest.mark.parametrize("kind", KINDS, ids=lambda k: f"{k[0]}{k[1]}{k[2]}")
def test_edges_and_vertices(kind, friction, rng):
    """With multipliers that close every point, many lie on edges and vertices of the master."""
    quadrature = 20 if kind[0] in ("quadrilateral", "triangle") else 4
    model = Deformable(*kind, friction=friction, gap=0.25, quadrature=quadrature)
    remember(model, rng, pressure=20.0)
    wanted = {INSIDE, VERTEX} if model.dim == 2 else {INSIDE, EDGE, VERTEX}
    check_derivatives(model, rng, potential=friction == 0.0, roughness=0.06, wanted=wanted)


@pytest.mark.parametrize("cell", ("quadrilateral", "hexahedron"))
@pytest.mark.parametrize("obstacle", ("plane", "sphere", "cylinder", "bore"))
@pytest.mark.parametrize("friction", (0.0, 0.3, 100.0))
def test_rigid(cell, obstacle, friction, rng):
    model = Rigid(cell, 2, obstacle, friction)
    if friction:
        remember(model, rng)
    state = check_derivatives(model, rng, potential=friction == 0.0)
    assert np.any(state.status != OPEN)


@pytest.mark.parametrize("friction", (0.0, 0.4))
@pytest.mark.parametrize("kind", KINDS, ids=lambda k: f"{k[0]}{k[1]}{k[2]}")
def test_balance(kind, friction, rng):
    """The master gets the opposite of the slave's force; without friction no moment is left."""
    model = Deformable(*kind, friction=friction)
    remember(model, rng, pressure=0.5)
    u = smooth(model.V, 0.03)
    state, force = model.state(u), model.force(u).reshape(-1, model.dim)
    slave, master = np.unique(model.slave.nodes), np.unique(model.master.nodes)
    total = model.points.weight @ state.traction
    scale = np.abs(force).sum()
    assert scale > 0.1
    assert np.abs(force[slave].sum(axis=0) - total).max() < ROUND_OFF * scale
    assert np.abs(force[master].sum(axis=0) + total).max() < ROUND_OFF * scale
    if friction == 0.0 and kind[1] <= kind[2]:
        x = model.V.tabulate_dof_coordinates()[:, : model.dim] + u.reshape(-1, model.dim)
        moments = np.cross(np.pad(x, ((0, 0), (0, 3 - model.dim))), np.pad(force, ((0, 0), (0, 3 - model.dim))))
        # The closest point is found to 1e-13 in its parameters: that times the pressure is the tangential defect.
        assert np.abs(moments.sum(axis=0)).max() < 1e-11 * scale


def test_values_of_a_point():
    """Pressure, traction, slip and status by hand: one flat pair, slid by a known amount."""
    model = Rigid("quadrilateral", 1, "plane", friction=0.2)
    u = np.zeros(model.num)
    weight = model.points.weight
    slide = 1e-5
    u[0::2] = slide
    model.rigid_increment = (0.0, 0.0, 0.0)
    state = model.state(u)
    gap = model.points.gap
    closed = gap < 0
    assert closed.any() and np.array_equal(state.status != OPEN, closed)
    assert np.allclose(state.pressure[closed], -CHI * gap[closed], rtol=1e-12)
    trial, limit = 0.7 * CHI * slide, 0.2 * state.pressure[closed]
    assert np.allclose(-state.tangential[closed, 0], np.minimum(trial, limit), rtol=1e-12)
    assert np.array_equal(state.status[closed] == STICK, trial <= limit)
    assert np.allclose(state.slip[closed, 0], slide - np.minimum(trial, limit) / (0.7 * CHI), atol=1e-18)
    assert np.all(state.traction[~closed] == 0) and np.all(state.slip[~closed] == 0)
    assert weight.sum() > 0.9  # the slave's length


def test_motion_counts_from_closing():
    """Points that were open stick to the part -g/(g_n - g) of their motion; closed ones to all of it."""
    model = Rigid("quadrilateral", 1, "plane", friction=100.0)
    u = np.zeros(model.num)
    u[0::2] = 1e-5
    model.rigid_increment = (0.0, 0.0, 0.0)
    model.state(u)
    gap = model.points.gap
    closed = gap < 0
    assert closed.any()
    for before, part in ((0.03, gap / (gap - 0.03)), (0.0, 1.0), (-0.01, 1.0), (np.inf, 0.0)):
        model.history.gap = np.full(gap.size, before)
        found = -model.state(u).tangential[:, 0] / (0.7 * CHI * 1e-5)
        assert np.allclose(found[closed], np.broadcast_to(part, gap.shape)[closed], rtol=1e-12, atol=1e-15)
    # With a multiplier the trial pressure grows evenly: from 0.2 - chi 0.03 to 0.2 - chi g.
    model.history.multiplier, model.history.gap = np.full(gap.size, 0.2), np.full(gap.size, 0.03)
    state = model.state(u)
    part = state.pressure / (state.pressure + CHI * 0.03 - 0.2)
    closed = state.pressure > 0
    assert np.allclose(-state.tangential[closed, 0], 0.7 * CHI * 1e-5 * part[closed], rtol=1e-12)


def test_offset_is_a_gap():
    """What is added to the gaps takes penalty times as much from the pressure."""
    model = Rigid("quadrilateral", 1, "plane")
    before = model.state(np.zeros(model.num)).pressure
    model.history.offset = np.linspace(0.001, 0.02, model.points.size)
    after = model.state(np.zeros(model.num)).pressure
    lost = CHI * model.history.offset
    assert np.any(before > lost)
    assert np.allclose(after[before > 0], np.maximum(before - lost, 0.0)[before > 0], rtol=1e-10, atol=1e-12)


class Values:
    """Arrays of a state: the object itself is of the present one."""

    def __init__(self, state):
        for name in ("status", "pressure", "tangential", "traction", "slip"):
            setattr(self, name, getattr(state, name))


def test_history():
    """advance copies the state; saved arrays restore it; an open point forgets."""
    model = Rigid("quadrilateral", 1, "plane", friction=0.2)
    u = np.zeros(model.num)
    u[0::2] = 0.01
    first = Values(model.state(u))
    model.penalty.accept_step()
    model.history.multiplier = first.pressure
    assert np.array_equal(model.history.traction, first.tangential.ravel())
    assert np.array_equal(model.history.slip, first.slip.ravel())
    saved = model.history.traction, model.history.slip, model.history.multiplier
    model.u_n = u.copy()
    second = Values(model.state(1.1 * u))
    model.history.traction = model.history.traction * 0
    model.history.traction, model.history.slip, model.history.multiplier = saved
    again = model.state(1.1 * u)
    assert np.array_equal(second.traction, again.traction) and np.array_equal(second.slip, again.slip)
    closed = first.pressure > 0
    assert np.allclose(second.pressure[closed], 2 * first.pressure[closed], rtol=1e-12)
    u[1::2] = 1.0
    lifted = model.state(u)
    assert np.all(lifted.status == OPEN) and np.all(lifted.tangential == 0)


def test_refused():
    model = Deformable("quadrilateral", 1, 1, friction=0.2)
    u = np.zeros(model.num)
    model.state(u)
    given = model.penalty.parameters
    for values, text in (((0.0, 0.0, 0.0), "penalty is positive"), ((1.0, 0.0, 0.3), "tangential")):
        given.normal, given.tangential, given.friction = values
        with pytest.raises(ValueError, match=text):
            model.penalty.evaluate()
    with pytest.raises(ValueError, match="multiplier"):
        model.history.multiplier = np.zeros(3)
    with pytest.raises(ValueError, match="an entry for every owned"):
        model.penalty.add_residual(PETSc.Vec().createSeq(3))
    rigid = Rigid("quadrilateral", 1, "plane", 0.3)
    rigid.state(u)
    with pytest.raises(ValueError, match="increments of displacement of all nodes"):
        rigid.penalty.evaluate(np.zeros(3), rigid.rigid_increment)
    with pytest.raises(ValueError, match="fewer than the surface's nodes"):
        rigid.penalty.update_gap(np.zeros(3), np.zeros(3), False)


@pytest.mark.parametrize("cell, geometry_degree, degree", KINDS)
def test_the_convex_part_of_the_tangent(cell, geometry_degree, degree, rng):
    """It is symmetric, positive semi-definite, and v . K v = chi sum w dg^2, dg the change of a point's gap along v."""
    model = Deformable(cell, geometry_degree, degree)
    u, direction = smooth_spot(model, rng, 1e-3, {INSIDE})
    state = model.state(u)
    K = dense(model, u, convex=True)
    scale = np.abs(K).max()
    assert np.abs(K - K.T).max() < ROUND_OFF * scale
    assert np.linalg.eigvalsh(K).min() > -1e-12 * scale
    closed, weight = state.status > OPEN, model.points.weight
    gaps = []
    for sign in (-1, 1):
        model.state(u + sign * STEP * direction)
        gaps.append(model.points.gap[closed])
    slope = (gaps[1] - gaps[0]) / (2 * STEP)
    assert direction @ K @ direction == pytest.approx(CHI * np.sum(weight[closed] * slope**2), rel=DIFFERENCE)
