# SPDX-License-Identifier: MIT
"""Friction in explicit contact against rigid bodies under Coulomb's law: benchmark G-3 and oblique impact."""

import math

import numpy as np
import pytest
from dolfinx import mesh
from impact_model import BOTH, Impact, enforce, mass, momentum, spin
from mpi4py import MPI
from scipy.spatial import Delaunay

import basix.ufl
import ufl

import dolfinx_impact as di

FRICTION, G, V0 = 0.3, 9.81, 5.0
FLOOR = di.RigidPlane((0.0, 0.0), (0.0, 1.0))


class Disc(Impact):
    """A disc of radius 1 that touches the floor with a node at the origin; rings of triangles, 6 n facets around.

    Args:
        law: material. n: rings. gap: above the floor.
    """

    def __init__(self, law, n=10, gap=0.0):
        rings = [
            (k / n) * np.column_stack([np.sin(t), -np.cos(t)])
            for k in range(1, n + 1)
            for t in [2 * math.pi * np.arange(6 * k) / (6 * k)]
        ]
        x = np.vstack([np.zeros((1, 2)), *rings])
        element = basix.ufl.element("Lagrange", "triangle", 1, shape=(2,))
        cells = Delaunay(x).simplices
        domain = mesh.create_mesh(MPI.COMM_SELF, cells.astype(np.int64), x=x + [0.0, 1.0 + gap], e=ufl.Mesh(element))
        rim = mesh.exterior_facet_indices(domain.topology) if domain.topology.create_connectivity(1, 2) is None else []
        tags = mesh.meshtags(domain, 1, rim, np.full(len(rim), 3, dtype=np.int32))
        super().__init__(_Recipe(domain, tags, {"slave_surface": 3}), law)
        self.center = (0.0, 1.0 + gap)
        self.all = np.arange(len(self.X))


class _Recipe:
    """What Model wants of a recipe."""

    def __init__(self, domain, tags, names):
        self.mesh, self.facet_tags, self.tags, self.cell_tags = domain, tags, names, None


def soft(E, law=di.LinearElastic):
    return law(E, 0.3, 1000.0, "plane_strain")


@pytest.mark.parametrize("method", BOTH)
def test_a_sliding_block_stops(method):
    """v0/(mu g) = 1.698947 s and v0^2/(2 mu g) = 4.247367 m within 1 %.

    The block starts in equilibrium but for the friction, so that it shakes; damping calms it, which does not act on
    rigid motion (stiffness-proportional).
    """
    block = Impact("block", soft(5e5), size=(1.0, 0.25), cells=(8, 2))
    block.throw(np.arange(len(block.X)), (V0, 0.0))
    block.loads.append(di.BodyForce((0.0, -G)))
    pair = block.pair("bottom", FLOOR, friction=FRICTION)
    problem = block.explicit(enforce(method, pair), damping=di.Rayleigh(0.0, 6e-3))
    t, v, s = np.array([(t, *rigid_motion(problem)) for t in walk(problem, 2.0, 400)]).T[:3]
    stop = t[np.flatnonzero(v > 0.005 * V0)[-1]] / 0.995  # the last of it is shaking
    assert stop == pytest.approx(V0 / (FRICTION * G), rel=0.01) and stop == pytest.approx(1.698947, rel=0.01)
    assert s[-1] == pytest.approx(4.247367, rel=0.01)
    # It swings on the springs of sticking nodes, which are softer than the block: at 2 s by some per mill of V0.
    assert abs(v[-1]) < 2e-3 * V0
    assert abs(problem.energy["drift"]) < 0.01
    # Nearly all of the energy went into friction, the rest into damping.
    assert problem.energy["friction"] == pytest.approx(0.5 * mass(problem, slice(None)) * V0**2, rel=0.01)


def walk(problem, until, num):
    """Goes to a time in equal pieces; yields the times."""
    for t in problem.time + (until - problem.time) * np.arange(1, num + 1) / num:
        problem.advance(t, progress=False)
        yield t


def rigid_motion(problem):
    """Mean velocity and displacement along x, angular velocity (anticlockwise)."""
    m, (L, inertia) = mass(problem, slice(None)), spin(problem, slice(None))
    u = (problem.mass.array * problem.u.x.array)[::2].sum() / m
    return momentum(problem, slice(None))[0] / m, u, L / inertia


@pytest.mark.parametrize("method", BOTH)
def test_a_disc_thrown_without_spin_begins_to_roll(method):
    """At v0/(3 mu g) = 0.566316 s, with 2 v0/3. The disc has 72 corners: bouncing on
    them takes a little of the speed."""
    disc = Disc(soft(2e7, di.NeoHookean), n=12)
    disc.loads.append(di.BodyForce((0.0, -G)))
    contact = enforce(method, disc.pair("slave_surface", FLOOR, friction=FRICTION))
    # At rest under its weight first: dropped on the floor it would bounce, and bounces are what time is measured by.
    disc.explicit(contact, damping=di.Rayleigh(60.0, 0.0)).advance(0.5, progress=False)
    disc.throw(disc.all, (V0, 0.0))
    problem = disc.explicit(contact)
    t, v, s, w = np.array([(t, *rigid_motion(problem)) for t in walk(problem, 0.8, 400)]).T
    slip = np.polyfit(t[t < 0.5], (v + w)[t < 0.5], 1)
    assert -slip[1] / slip[0] == pytest.approx(V0 / (3 * FRICTION * G), rel=0.01)
    assert -slip[1] / slip[0] == pytest.approx(0.566316, rel=0.01)
    rolls = t > 0.6
    assert v[rolls].mean() == pytest.approx(2 * V0 / 3, rel=0.01) and -w[rolls].mean() == pytest.approx(
        2 * V0 / 3, rel=0.01
    )
    # Angular momentum about the floor is kept: friction has no lever there.
    np.testing.assert_allclose(v - 0.5 * w, V0, rtol=0.01)


@pytest.mark.covering(1)
@pytest.mark.parametrize("method", BOTH)
@pytest.mark.parametrize("backspin", (-1.0, 0.0, 1.0))
def test_oblique_impact_of_a_spinning_disc(method, backspin):
    """While it slides, the tangential impulse is mu times the normal one: change of v_t by -mu (1 + e) v_n, of the spin
    by that over k^2/R, with the restitution e that was measured."""
    disc = Disc(soft(1e11, di.NeoHookean), n=12, gap=1e-7)
    vt, vn, friction = 3.0, 1.0, 0.1
    disc.throw(disc.all, (vt, -vn), backspin, disc.center)
    problem = disc.explicit(enforce(method, disc.pair("slave_surface", FLOOR, friction=friction)))
    m, (L, inertia) = mass(problem, slice(None)), spin(problem, slice(None))
    start = L / inertia
    problem.advance(0.002, progress=False)
    assert problem.contact[0].area == 0.0
    vx, vy = momentum(problem, slice(None)) / m
    end, inertia = spin(problem, slice(None))
    e = vy / vn
    assert 0.95 < e < 1.0  # a few per cent go into vibration
    change = -friction * (1 + e) * vn
    assert vx - vt == pytest.approx(change, rel=1e-12)  # every node's force is on the cone, all the time
    # The corner that touches turns with the disc, by 1e-3, out of the line of the normal force.
    assert end / inertia - start == pytest.approx(change * m / inertia, rel=0.01)
    assert abs(problem.energy["drift"]) < 1e-3


@pytest.mark.long_rows(where=lambda method: method == "Penalty")
@pytest.mark.parametrize("method", BOTH)
def test_oblique_impact_of_a_spinning_sphere(method):
    """In space: as the disc, with 5/2 of the change of velocity in that of the spin, R dw = 5/2 dv_t; no other spin."""
    law = di.NeoHookean(1e13, 0.3, 1000.0)
    ball = Impact(
        "sphere_on_half_space", law, radius=1.0, a=0.2, h=0.08, gap=1e-7, symmetry="none", whole=True, coarse=0.3,
        width=0.5, height=0.5,
    )  # fmt: skip
    nodes, vn, friction = ball.body(lambda x: x[2] > 5e-8), 1.0, 0.1
    ball.throw(nodes, (3.0, 1.0, -vn))
    velocity = ball.velocity.x.array.reshape(-1, 3)
    center = np.array([0.0, 0.0, 1.0 + 1e-7])
    velocity[nodes] += np.cross([0.4, -0.8, 0.5], ball.X[nodes] - center)
    floor = di.RigidPlane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    problem = ball.explicit(enforce(method, ball.pair("slave_surface", floor, friction=friction)))
    m = problem.mass.array.reshape(-1, 3)[nodes, :1]

    def motion():
        x = ball.X[nodes] + problem.u.x.array.reshape(-1, 3)[nodes]
        v = problem.velocity.x.array.reshape(-1, 3)[nodes]
        r, mean = x - (m * x).sum(axis=0) / m.sum(), (m * v).sum(axis=0) / m.sum()
        inertia = (m[:, 0] * np.sum(r**2, axis=1)).sum() * np.eye(3) - np.einsum("n,na,nb->ab", m[:, 0], r, r)
        return mean, np.linalg.solve(inertia, (m * np.cross(r, v)).sum(axis=0))

    v0, w0 = motion()
    problem.advance(0.0008, progress=False)
    v1, w1 = motion()
    assert problem.contact[0].area == 0.0
    change, e = v1 - v0, v1[2] / vn
    assert 0.98 < e < 1.0
    # Every node's force is on its cone; their directions differ by the ball's spin about the normal.
    assert np.linalg.norm(change[:2]) == pytest.approx(friction * (1 + e) * vn, rel=1e-6)
    sliding = v0 + np.cross(w0, [0.0, 0.0, -1.0])
    np.testing.assert_allclose(
        change[:2] / np.linalg.norm(change[:2]), -sliding[:2] / np.linalg.norm(sliding[:2]), atol=1e-3
    )
    # The corner that touches turns with the ball, by some 1e-4; the ball of facets has k^2 = 0.402 R^2.
    np.testing.assert_allclose((w1 - w0)[:2], 2.5 * np.array([change[1], -change[0]]), atol=0.012 * 2.5 * 0.2)
    assert abs((w1 - w0)[2]) < 0.012 * 2.5 * 0.2
    assert abs(problem.energy["drift"]) < 1e-3
