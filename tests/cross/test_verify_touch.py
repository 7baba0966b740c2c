# SPDX-License-Identifier: MIT
"""Every run with contact of the level history touches, in every variation.

A run that misses fails in `dolfinx-impact verify`, which takes minutes. Here nodes fly freely, each with its velocity
at the start, until one passes through a facet of the other surface. Nothing is solved; no code of contact is used.
"""

import itertools

import impact_reference
import numpy as np
import pytest
from dolfinx import mesh
from scipy.spatial import cKDTree

from dolfinx_impact import compat
from impact_verify.contact_bodies import MASTER, SLAVE
from impact_verify.scenarios import explicit_runs, implicit_runs
from impact_verify.scenarios.our_adapter import time_step
from impact_verify.scenarios.placed_bodies import upper_nodes

LEVELS = {"explicit": explicit_runs, "implicit": implicit_runs}
TIMES = 60  # at which nodes are looked at


def every_run(level, seeds=None):
    """Runs with contact: as they are and varied, those that differ in the method alone once."""
    seen = set()
    for cell, degree, make in level.RUNS:
        if make is level.without_contact:
            continue
        for case in itertools.chain(make(cell, degree), level.varied_runs(cell, degree, make, seeds)):
            x = case.body.V.tabulate_dof_coordinates()
            known = x.tobytes(), case.velocity(x[:, : case.body.gdim]).tobytes(), case.step_fraction
            if known not in seen:
                seen.add(known)
                yield case


def run_time(level, case):
    """Least time that a run takes. The stable step is at least 0.9 (degree 2: 0.4) of the shortest distance of a cell's
    nodes over the speed of a wave and root of dim, for its direction: of these cells it is 1.02 to 1.9 times that."""
    if level is implicit_runs:
        return case.num_steps * time_step(case)
    domain = case.body.mesh
    nodes = domain.geometry.x[compat.geometry_dofmap(domain)]
    i, j = np.triu_indices(nodes.shape[1], 1)
    shortest = np.linalg.norm(nodes[:, i] - nodes[:, j], axis=2).min()
    wave_speed = np.sqrt(0.7 / (1.3 * 0.4))  # E = 1, density 1, nu = 0.3 at most
    factor = {1: 0.9, 2: 0.4}[case.body.degree]
    return case.num_steps * case.step_fraction * factor * shortest / (wave_speed * np.sqrt(case.body.gdim))


def simplices(case, tag):
    """Vertices of a surface's facets, quadrilaterals cut in two."""
    domain = case.body.mesh
    domain.topology.create_connectivity(case.body.gdim - 1, case.body.gdim)
    facets = mesh.entities_to_geometry(domain, case.body.gdim - 1, case.body.tags.find(tag))
    return np.vstack([facets[:, [0, 1, 2]], facets[:, [1, 3, 2]]]) if facets.shape[1] == 4 else facets


def heights(points, surface):
    """Height of each point above a surface of simplices, (num_points); NaN beside it."""
    dim = points.shape[1]
    corners = surface.transpose(0, 2, 1)  # (num_simplices, dim, dim), a column for each corner
    corners = np.concatenate([corners[:, :-1], np.ones_like(corners[:, :1]), corners[:, -1:]], axis=1)
    places = np.column_stack([points[:, :-1], np.ones(len(points))])
    weights = np.einsum("sab,pb->psa", np.linalg.inv(corners[:, :dim]), places)
    above = points[:, None, -1] - np.einsum("sa,psa->ps", corners[:, dim], weights)
    above[weights.min(axis=2) < 0.0] = np.inf
    found = above.min(axis=1)
    return np.where(np.isfinite(found), found, np.nan)


def gaps(case, x, t):
    """Of slave nodes to a rigid obstacle or to facets of the master, of master nodes to those of the slave."""
    slave = simplices(case, SLAVE)
    if case.body.rigid:
        obstacle, motion = case.body.rigid[1], np.zeros(x.shape[1]) if case.obstacle is None else case.obstacle(t)
        if isinstance(obstacle, impact_reference.RigidBall):  # it flies on
            motion = obstacle.velocity[: x.shape[1]] * t
        elif case.body.moving is not None:
            motion = np.asarray(case.body.moving.velocity)[: x.shape[1]] * t
        points = x[np.unique(slave)] - motion
        if hasattr(obstacle, "radius"):
            return np.linalg.norm(points - obstacle.center[: x.shape[1]], axis=1) - obstacle.radius
        return (points - obstacle.point) @ obstacle.normal
    master = simplices(case, MASTER)
    return heights(x[np.unique(slave)], x[master])


def first_touch(case, time):
    """When a node passes through a surface; infinite if none does by `time`."""
    positions = case.body.V.tabulate_dof_coordinates()[:, : case.body.gdim]
    x = case.body.mesh.geometry.x[:, : case.body.gdim]
    v = case.velocity(positions)[cKDTree(positions).query(x)[1]]
    before = gaps(case, x, 0.0)
    for t in np.linspace(0.0, time, TIMES)[1:]:
        now = gaps(case, x + t * v, t)
        if np.any((before >= 0.0) & (now < 0.0)):
            return t
        before = now
    return np.inf


@pytest.mark.parametrize("name", LEVELS)
def test_every_run_touches(name):
    level, late = LEVELS[name], []
    # Runs without pairs have no slave and no master; test_verify_general asks for their forces.
    cases = [case for case in every_run(level) if case.contact != "general"]
    for case in cases:
        if not first_touch(case, run_time(level, case)) < np.inf:
            late.append(f"{case.body.cell}, degree {case.body.degree}: {case.name}")
    assert len(cases) >= {"explicit": 60, "implicit": 15}[name]
    assert not late


def test_a_body_that_misses_is_seen():
    """Also one that passes beside the other body, below its surface; and each run by itself, upwards."""
    for cell, degree, make in (("hexahedron", 1, explicit_runs.smooth_hill), ("quadrilateral", 1, explicit_runs.rigid)):
        case = next(iter(make(cell, degree)))
        time, velocity = run_time(explicit_runs, case), case.velocity
        assert first_touch(case, time) < time
        case.velocity = lambda x: -velocity(x)
        assert first_touch(case, time) == np.inf
    case = next(iter(explicit_runs.overhang("quadrilateral", 1)))
    velocity, x = case.velocity, case.body.mesh.geometry.x
    x[upper_nodes(case.body.mesh), 0] += 0.4
    case.velocity = lambda x: velocity(x) * [0.0, 1.0]
    assert first_touch(case, run_time(explicit_runs, case)) == np.inf
