# SPDX-License-Identifier: MIT
"""Single states of explicit penalty contact: stiffness by the formula, Coulomb's law with history, rigid masters."""

import impact_reference as ir
import numpy as np
import pytest
from reference_meshes import box, boundary, facets_where, nodes_where
from spring_energy_balance import SpringEnergyBalance

OPEN, STICK, SLIP = 0, 1, 2


def ring_or_plane(degree, axisymmetric, n_low=3, n_up=4):
    """Two blocks on [1, 2] x [-1, 0] and [1, 2] x [0, 1]: model, slave, master and the nodes' sides."""
    low, c_low = box("quadrilateral", (n_low, 2), mapping=lambda x: x + [1, -1])
    up, c_up = box("quadrilateral", (n_up, 2), mapping=lambda x: x + [1, 0])
    law = ir.Material(1.0, 0.3, 2.0, "axisymmetric" if axisymmetric else "plane_strain")
    points, cells = np.vstack([low, up]), np.vstack([c_low, c_up + len(low)])
    model = ir.Model(points, cells, "quadrilateral", law, degree=degree)
    slave = facets_where(up, c_up, "quadrilateral", lambda x: x[1] == 0) + len(low)
    master = facets_where(low, c_low, "quadrilateral", lambda x: x[1] == 0)
    upper = np.zeros(len(model.field_points), dtype=bool)
    upper[np.unique(model.field_cells[len(c_low) :])] = True
    return model, slave, master, upper


def line_areas(x, degree, axisymmetric):
    """Areas of the nodes x (increasing) of a line of facets of equal length."""
    areas = np.zeros(len(x))
    for a in range(0, len(x) - 1, degree):
        s, e = x[a], x[a + degree]
        if degree == 1:
            share = np.array([(2 * s + e) / 6, (s + 2 * e) / 6]) * 2 * np.pi if axisymmetric else np.array([0.5, 0.5])
        else:
            # int phi^2 of the three functions over the reference facet [-1, 1]: 4/15, 16/15, 4/15.
            share = np.array([1, 4, 1]) / 6 * (np.pi * (s + e) if axisymmetric else 1)
        areas[a : a + degree + 1] += (e - s) * share
    return areas


def offered(model, degree, areas, mass, dt):
    """Stiffness that each node with an area offers: half a layer of cells of height 1/2, what the frequencies of the
    cells around leave to contact, and what the step bears."""
    room = 0.19 / 0.81
    modulus = 0.7 / (1.3 * 0.4)
    by_cell = np.zeros(len(model.field_points))
    for geometry, nodes in zip(model.cells, model.field_cells):
        X, law = model.points[geometry], next(iter(model.materials.values()))
        K = ir.element_stiffness("quadrilateral", X, law, degree)
        m = ir.element_lumped_mass("quadrilateral", X, law, "auto", degree)
        highest = np.linalg.eigvalsh(K / np.sqrt(np.outer(m, m)))[-1]
        by_cell[nodes] += m[::2] * highest
    return {
        i: min(0.5 * modulus * degree * a / 0.5, room * by_cell[i], 4 * room * mass[i] / dt**2)
        for i, a in areas.items()
    }


@pytest.mark.parametrize("dt", [0.03, 0.9])
@pytest.mark.parametrize("degree", [1, 2])
@pytest.mark.parametrize("axisymmetric", [False, True])
@pytest.mark.parametrize("balanced", [False, True])
def test_stiffness_by_the_formula(degree, axisymmetric, balanced, dt):
    model, slave, master, upper = ring_or_plane(degree, axisymmetric)
    x, mass, depth = model.field_points, model.mass(lumped=True)[::2], 0.01
    u0 = np.zeros_like(x)
    u0[upper, 1] = -depth
    run = model.run_explicit(dt, 1, u0=u0.reshape(-1), contacts=[ir.NodalPenalty(slave, master, balanced=balanced)])
    expected = np.zeros(len(x))
    sides = [np.flatnonzero(side & (x[:, 1] == 0)) for side in (upper, ~upper)]
    sides = [nodes[np.argsort(x[nodes, 0])] for nodes in sides]
    for one, other in [sides, sides[::-1]][: 1 + balanced]:
        areas = {}
        for nodes in (one, other):
            areas.update(zip(nodes, line_areas(x[nodes, 0], degree, axisymmetric)))
        stiff = offered(model, degree, areas, mass, dt)
        for i in one:
            facet = min(int((x[i, 0] - 1) * (len(other) - 1) / degree + 1e-12), (len(other) - 1) // degree - 1)
            masters = other[degree * facet : degree * (facet + 1) + 1]
            X = x[masters, 0]
            phi = [np.prod([(x[i, 0] - X[b]) / (X[a] - X[b]) for b in range(len(X)) if b != a]) for a in range(len(X))]
            series = 1 / stiff[i] + sum(abs(p) * (1 + areas[j] / areas[i]) / stiff[j] for p, j in zip(phi, masters))
            k = 1 / series / (1 + balanced)
            direction = 1 if upper[i] else -1
            expected[i] += k * depth * direction
            expected[masters] -= k * depth * direction * np.array(phi)
    force = run.contacts[0].force[0]
    assert np.allclose(force[1::2], expected, rtol=0, atol=1e-12 * np.abs(expected).max())
    assert np.abs(force[::2]).max() < 1e-12 * np.abs(expected).max()
    assert np.isclose(run.contacts[0].total[0, 1], force[1::2][upper].sum()) and force[1::2][upper].min() >= 0
    # A given penalty is a pressure per depth: its total is that of the whole area.
    run = model.run_explicit(
        dt, 1, u0=u0.reshape(-1), contacts=[ir.NodalPenalty(slave, master, penalty=7.0, balanced=balanced)]
    )
    area = 3 * np.pi if axisymmetric else 1.0
    assert np.isclose(run.contacts[0].total[0, 1], 7.0 * depth * area, rtol=1e-12)
    assert np.isclose(run.energies["contact"][0], 7.0 * depth**2 * area / 2, rtol=1e-12)


@pytest.mark.parametrize("degree", [1, 2])
def test_contact_keeps_the_step(degree):
    """Contact adds to the square of the highest frequency what 0.9 of the stable step leaves: (1/0.81 - 1) of it."""
    model, slave, master, upper = ring_or_plane(degree, False, 3, 5)
    dt = 0.9 * model.stable_step()
    room = 0.19 / 0.81 * (2 / model.stable_step()) ** 2
    u0 = np.zeros_like(model.field_points)
    u0[upper, 1] = -1e-6
    columns = []
    contact = ir.NodalPenalty(slave, master, balanced=True)
    # Columns of the spring matrix by differences of forces; all nodes stay closed.
    base = model.run_explicit(dt, 1, u0=u0.reshape(-1), contacts=[contact]).contacts[0].force[0]
    for i in range(model.num_dofs):
        moved = u0.reshape(-1).copy()
        moved[i] += 1e-8
        columns.append(base - model.run_explicit(dt, 1, u0=moved, contacts=[contact]).contacts[0].force[0])
    K = np.array(columns).T / 1e-8
    K = (K + K.T)[1::2, 1::2] / 2
    root = 1 / np.sqrt(model.mass(lumped=True)[1::2])
    highest = np.linalg.eigvalsh(root[:, None] * K * root)[-1]
    assert 0.1 * room < highest < room * (1 + 1e-4)


def dragged(gdim, master, path, friction, chi, motion=None):
    """A prescribed unit block on path (num_steps + 2, gdim): the run and the stiffness of its lower nodes."""
    cell = "quadrilateral" if gdim == 2 else "hexahedron"
    points, cells = box(cell, (1,) * gdim)
    model = ir.Model(points, cells, cell, ir.Material(1.0, 0.3, 1.0, "plane_strain" if gdim == 2 else "3d"))
    low = facets_where(points, cells, cell, lambda x: x[-1] == 0)
    times = np.arange(len(path), dtype=float)
    contact = ir.NodalPenalty(low, master, friction=friction, penalty=chi, motion=motion and (times, motion(times)))
    values = (times, np.tile(path, (1, len(points))))
    every = np.arange(model.num_dofs)
    u0 = np.tile(path[0], len(points))
    return model, model.run_explicit(1.0, len(path) - 2, u0=u0, fixed_dofs=every, values=values, contacts=[contact])


@pytest.mark.parametrize("moving", [False, True])
def test_coulomb_step_by_step(moving):
    """Closing within a step, sticking, being cut back, sticking the other way, a step that leaves the wall, closing
    again: by hand; k = chi / 2 = 1. Overlaps: r = -0.2, g = -0.1: 0.1; r = 0.16, g = -0.04: 0.12^2 / 0.32; r = 0.06,
    g = 0.02: 0.01^2 / 0.12."""
    path = np.array(
        [
            [0, 0.1],
            [1, -0.1],
            [1.5, -0.2],
            [1.5, -0.04],
            [1.3, -0.04],
            [1.3, 0.02],
            [1.3, 0.1],
            [1.3, -0.1],
            [1.3, -0.1],
        ]
    )
    plane = ir.RigidPlane([0, 0], [0, 1.0])
    if moving:  # half of the motion by the plane, the other way
        _, run = dragged(2, plane, path / 2, 10.0, 2.0, motion=lambda t: -path / 2)
    else:
        _, run = dragged(2, plane, path, 10.0, 2.0)
    contact = run.contacts[0]
    traction, slip, status = contact.traction[:, 0, 0], contact.slip[:, 0, 0], contact.status[:, 0]
    overlaps = np.array([0, 0.1, 0.2, 0.045, 0.04, 1 / 1200, 0, 0.1])
    assert np.allclose(contact.total[:, 1], 2 * overlaps, rtol=0, atol=1e-14)
    assert np.allclose(traction, [0, -0.5, -1.0, -0.45, -0.25, -1 / 120, 0, 0], rtol=0, atol=1e-14)
    last = 0.25 - 1 / 120
    assert np.allclose(slip, [0, 0, 0, 0.55, 0.55, 0.55 + last, 0, 0], rtol=0, atol=1e-14)
    assert status.tolist() == [OPEN, STICK, STICK, SLIP, STICK, SLIP, OPEN, STICK]
    # t^2 / 2 before - (t before + t) / 2 . motion - t^2 / 2 after: half of the first step's way is free.
    lost = np.cumsum([0, 1 / 8, 0, (1 - 0.45**2) / 2, 0, 1 / 32 - 1 / 28800, 1 / 28800, 0])
    assert np.allclose(run.energies["friction"], 2 * lost, atol=1e-14)
    assert np.allclose(run.energies["contact"], overlaps**2 + traction**2, atol=1e-14)
    assert np.abs(run.energies["drift"]).max() < 1e-14
    # The nodes do not move freely: supports, or the plane, do what contact takes, to the rule of the trapezium.
    force = contact.total
    work = np.cumsum(np.sum((force[1:] + force[:-1]) * np.diff(path[:-1], axis=0), 1)) / 2
    inertia = run.energies["kinetic"] - run.energies["kinetic"][0]
    assert np.allclose((run.energies["external"] - inertia)[1:], -work, atol=1e-12)


@pytest.mark.parametrize("gdim", [2, 3])
@pytest.mark.parametrize("shape", ["plane", "sphere", "facets"])
def test_coulomb_along_a_random_path(gdim, shape):
    """The recurrence of the document written once more, on planes, balls and a fixed body; k = chi A."""
    rng = np.random.default_rng(gdim)
    path = np.cumsum(0.02 * rng.standard_normal((60, gdim)), 0)
    path[:, -1] = 0.02 * rng.standard_normal(60) - 0.005
    normal = np.eye(gdim)[-1]
    chi, mu = 3.0, 0.5
    k = chi / 2 ** (gdim - 1)
    if shape == "facets":
        cell = "quadrilateral" if gdim == 2 else "hexahedron"
        p, c = box(cell, (1,) * gdim)
        q, e = box(cell, (1,) * gdim, mapping=lambda x: 3 * (x - 0.5) - 1.5 * normal)
        points, cells = np.vstack([p, q]), np.vstack([c, e + len(p)])
        model = ir.Model(points, cells, cell, ir.Material(1.0, 0.3, 1.0, "plane_strain" if gdim == 2 else "3d"))
        low = facets_where(p, c, cell, lambda x: x[-1] == 0)
        top = facets_where(q, e, cell, lambda x: x[-1] == 0) + len(p)
        where = np.hstack([np.tile(path, (1, len(p))), np.zeros((60, q.size))])
        contact = ir.NodalPenalty(low, top, friction=mu, penalty=chi)
        run = model.run_explicit(
            1.0,
            58,
            u0=where[0],
            fixed_dofs=np.arange(model.num_dofs),
            values=(np.arange(60.0), where),
            contacts=[contact],
        )
    elif shape == "plane":
        normal = np.array([0.1, 0.2, 1.0])[-gdim:] / np.linalg.norm([0.1, 0.2, 1.0][-gdim:])
        model, run = dragged(gdim, ir.RigidPlane(np.zeros(gdim), normal), path, mu, chi)
    else:
        model, run = dragged(gdim, ir.RigidSphere(-2.0 * np.eye(gdim)[-1], 2.0), path, mu, chi)

    def overlap(g, r):
        """By an antiderivative of <-g>."""
        ends = np.minimum([g - abs(r) / 2, g + abs(r) / 2], 0)
        return (ends[0] ** 2 - ends[1] ** 2) / (2 * abs(r)) if r else max(-g, 0.0)

    def gap_of(x):
        if shape == "sphere":
            d = x + 2.0 * np.eye(gdim)[-1]
            return np.linalg.norm(d) - 2.0, d / np.linalg.norm(d)
        return x @ normal, normal

    contact = run.contacts[0]
    seen, beyond, limited, dissipated, taken = set(), 0, [0, 0], 0.0, 0.0
    for a, node in enumerate(contact.nodes):
        x = model.field_points[node]
        t, spring, g_before = np.zeros(gdim), SpringEnergyBalance(k), 0.0
        for n in range(59):
            g, nrm = gap_of(x + path[n])
            assert np.isclose(contact.gap[n, a], g, atol=1e-13)
            moved = path[n] - path[n - 1] if n else np.zeros(gdim)
            r = moved @ nrm
            delta, status = overlap(g, r), OPEN
            beyond += delta > 0 and g > 0
            P = np.eye(gdim) - np.outer(nrm, nrm)
            gamma = r
            if spring.closed:
                gamma = np.clip(g - g_before, -2 * np.linalg.norm(moved), 2 * np.linalg.norm(moved))
            g_before, old = g, P @ t
            if np.linalg.norm(old):
                old *= np.linalg.norm(t) / np.linalg.norm(old)
            N = spring.normal_force(g, gamma, delta)
            limited[0] += N < k * delta * (1 - 1e-9)
            if delta == 0:
                t = spring.friction_force(np.zeros(gdim), old, P @ moved)
            else:
                psi = np.clip(max(-g, r - g) / abs(r), 0, 1) if n else float(g < 0)  # of gaps g - r to g
                trial = old - k * psi * P @ moved
                t, status = trial, STICK
                if np.linalg.norm(t) > mu * N:
                    t, status = mu * N * t / np.linalg.norm(t), SLIP
                cone = t
                t = spring.friction_force(t, old, P @ moved, mu * N)
                if not np.array_equal(t, cone):
                    limited[1] += 1
                    status = SLIP
            # On facets nodes of the master are held, and the slave's are not in the master.
            f = contact.force[n].reshape(-1, gdim)[node]
            assert np.allclose(f, N * nrm + t, rtol=0, atol=1e-13)
            seen.add(status)
            assert contact.status[n, a] == status
            assert np.allclose(contact.traction[n, a], t, rtol=0, atol=1e-13)
        dissipated, taken = dissipated + spring.friction_loss, taken + spring.normal_loss
    assert seen == {OPEN, STICK, SLIP} and beyond > 0 and min(limited) > 0
    assert np.isclose(run.energies["friction"][-1], dissipated, rtol=1e-12)
    assert np.isclose(run.energies["impact"][-1], taken, rtol=1e-12)
    if shape != "sphere":  # whose normal turns: gamma is not n . Delta
        assert np.abs(run.energies["drift"]).max() < 1e-12


def test_moving_wall_is_a_moving_body():
    """A wall that comes to a body at rest, and a body that comes to a wall at rest: the same forces."""
    points, cells = box("triangle", (3, 3))
    model = ir.Model(points, cells, "triangle", ir.Material(100.0, 0.3, 1.0, "plane_strain"))
    right = facets_where(points, cells, "triangle", lambda x: x[0] == 1)
    dt, v = 0.5 * model.stable_step(), np.tile([1.0, 0.2], len(points))
    runs = []
    for kind in (ir.NodalPenalty, ir.NodalKinematic):
        still = kind(right, ir.RigidPlane([1.05, 0], [-1.0, 0]), friction=0.3)
        coming = kind(right, ir.RigidPlane([1.05, 0], [-1.0, 0]), friction=0.3, motion=lambda t: [-t, -0.2 * t])
        a = model.run_explicit(dt, 150, v0=v, contacts=[still])
        b = model.run_explicit(dt, 150, contacts=[coming])
        assert np.abs(a.contacts[0].force).max() > 0
        assert np.allclose(a.contacts[0].force, b.contacts[0].force, rtol=0, atol=1e-9)
        assert np.allclose(a.u, b.u + b.time[:, None] * v, rtol=0, atol=1e-12)
        # Springs that open and close between steps: the drift is the same in both systems.
        scale = [np.abs(r.energies["total"] - r.energies["total"][0]) for r in (a, b)]
        assert np.allclose(scale[0], scale[1], atol=1e-9)
        assert b.energies["external"][-1] > 0.5
        runs.append(a)
    assert np.abs(runs[1].energies["drift"]).max() < 1e-12


def test_contacts_that_do_not_fit_are_refused():
    points, cells = box("triangle", (2, 2))
    model = ir.Model(points, cells, "triangle", ir.Material(1.0, 0.3, 1.0, "plane_strain"))
    low = facets_where(points, cells, "triangle", lambda x: x[1] == 0)
    top = facets_where(points, cells, "triangle", lambda x: x[1] == 1)
    plane = ir.RigidPlane([0, 0], [0, 1.0])
    with pytest.raises(ValueError, match="penalty"):
        ir.NodalPenalty(low, plane, penalty=-1.0)
    with pytest.raises(ValueError, match="rigid"):
        ir.NodalPenalty(low, top, motion=[0, 1.0])
    for contact, message in [
        (ir.NodalPenalty(low, plane, balanced=True), "balanced"),
        (ir.NodalPenalty(low, plane, friction=-0.1), "friction"),
        (ir.NodalKinematic(low, plane, sweeps=0), "sweep"),
        (ir.NodalKinematic(np.vstack([low, low]), plane), "twice"),
    ]:
        with pytest.raises(ValueError, match=message):
            model.run_explicit(0.01, 1, contacts=[contact])
    assert boundary(cells, "triangle").shape[1] == 2 and len(nodes_where(points, lambda x: x[1] == 0)) == 3
