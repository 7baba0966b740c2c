# SPDX-License-Identifier: MIT
"""Kinematic contact of several pairs that share nodes, against the hand-written solver."""

import impact_reference
from kinematic_pairs_checks import CASES, boxes_of
import numpy as np
from plane_bodies import Bodies
import pytest
from dolfinx import fem

import dolfinx_impact as di
from impact_verify.matched_body import Body


STEPS = 80
ACCURACY = 1e-9  # of the displacements: round-off, which contact enlarges at each of some hundred closures


def facets(body, tags, tag):
    """Points of the facets of a tag, numbered as in the hand-written model."""
    m = body.mesh
    m.topology.create_connectivity(body.gdim - 1, body.gdim)
    from dolfinx.mesh import entities_to_geometry

    return entities_to_geometry(m, body.gdim - 1, tags.find(tag))


def both(domain, law, velocity, ours, theirs):
    """Displacements of all steps on both sides, and the contacts' forces."""
    body = Body(domain, 1, law)
    u, v = fem.Function(body.V), fem.Function(body.V)
    v.x.array[:] = velocity
    problem = di.ExplicitProblem(u, law, velocity=v, contact=ours)
    dt, levels = 0.7 * problem.stable_step(), []
    problem.advance(STEPS * dt, dt=dt, progress=False, callback=lambda p: levels.append(p.u.x.array.copy()))
    v0 = np.empty(len(body.order))
    v0[body.order] = velocity
    result = body.model.run_explicit(dt, STEPS, v0=v0, contacts=theirs(body))
    return np.array(levels), result.u[:, body.order], np.array(problem.force_history), result


def assert_agree(levels, their_levels, forces, result):
    assert np.max(np.abs(levels - their_levels)) < ACCURACY * np.abs(levels).max()
    for here, there in zip(forces, result.contacts):
        size = max(np.abs(here).max(), np.abs(there.total).max())
        assert np.max(np.abs(here - there.total[: len(here)])) < 1e-7 * size


@pytest.mark.parametrize("friction", (0.0, 0.3))
@pytest.mark.parametrize("dim", (2, 3))
@pytest.mark.parametrize("case", CASES)
@pytest.mark.covering(2)
def test_boxes(case, dim, friction):
    boxes, tags, pairs = boxes_of(case, dim)
    x = boxes.V.tabulate_dof_coordinates()
    velocity = np.zeros((len(x), dim))
    for box, (*_, speed) in enumerate(boxes.boxes):
        velocity[boxes.inside(x, box)] = speed
    ours = [di.Kinematic(di.ContactPair(tags, *pair, friction=friction)) for pair in pairs]

    def theirs(body):
        return [impact_reference.NodalKinematic(*(facets(body, tags, t) for t in pair), friction) for pair in pairs]

    found = both(boxes.mesh, boxes.law, velocity.ravel(), ours, theirs)
    assert all(np.any(force) for force in found[2]) or case == "tee"
    assert_agree(*found)


@pytest.mark.parametrize("friction", (0.0, 0.3))
@pytest.mark.parametrize("angle", (90, 120))
def test_groove(angle, friction):
    """Nodes that are slaves of two planes."""
    block = Bodies(((0.0, 0.02), (1.0, 1.02), (3, 3), (0.3, -1.0), np.pi / 4), E=1e3, nu=0.3, law=di.LinearElastic)
    c, s = np.cos(np.radians(angle / 2)), np.sin(np.radians(angle / 2))
    normals = [(sign * c, s) for sign in (1.0, -1.0)]
    pairs = [block.pair((0, "bottom", "left"), di.RigidPlane((0, 0), n), friction=friction) for n in normals]
    tags = pairs[0].facet_tags

    def theirs(body):
        slave = facets(body, tags, pairs[0].slave)
        planes = [impact_reference.RigidPlane((0.0, 0.0), n) for n in normals]
        return [impact_reference.NodalKinematic(slave, plane, friction) for plane in planes]

    found = both(block.mesh, block.law, block.velocity.x.array, [di.Kinematic(pair) for pair in pairs], theirs)
    assert all(np.any(force) for force in found[2])
    assert_agree(*found)
