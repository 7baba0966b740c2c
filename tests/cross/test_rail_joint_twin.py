# SPDX-License-Identifier: MIT
"""The wheel over the rail joint by both solvers, on the coarsest mesh, step by step."""

import impact_reference
import numpy as np
import pytest
from dolfinx import fem
from mpi4py import MPI

import dolfinx_impact as di
from impact_studies.rail_joint import JointModel, Passage, RailJoint
from impact_verify.matched_body import Body, foundation_rule

STEPS = 100
# Round-off of 100 steps over the largest value, which contact carries on; the limit of the level history of `verify`.
LIMIT = 1e-9
# Both sides have springs of one penalty, as stiff as those of `penalty="step"` in the middle of this contact.
JOINT = RailJoint().changed(
    cells=1, coarse=0.1, speed=80.0, begin=-6e-3, end=6e-3, rail_length=0.5, bar_length=0.3, yield_stress=np.inf,
    support="winkler", wheel_mass=700.0, penalty=4e13,
)  # fmt: skip


class Both:
    """The joint on both sides: ours, and the hand-written model with its own elements, laws and springs."""

    def __init__(self, support=1.0):
        self.ours = model = JointModel(JOINT, MPI.COMM_SELF)
        self.body = body = Body(model.mesh, 1, model.rail_law)
        tags = np.empty(len(body.cells), dtype=np.int64)
        tags[model.cell_tags.indices] = model.cell_tags.values
        laws = {"LinearElastic": "linear_elastic", "StVenantKirchhoff": "st_venant_kirchhoff"}
        materials = {
            tag: impact_reference.Material(law.E, law.nu, law.density, "3d", laws[type(law).__name__])
            for tag, law in model.material.materials.items()
        }
        self.model = impact_reference.Model(
            body.points, body.cells, "hexahedron", cell_tags=tags, materials=materials, facet_rule=foundation_rule(body)
        )
        self.order = body.order
        foot = 2 * 0.075 * JOINT.sleepers  # area of both halves that stands on a pad
        pads = support * JOINT.pad_stiffness / foot, JOINT.pad_damping / foot
        self.model.add_foundation(self.facets("bottom"), *(np.array([0.5, 0.5, 1.0]) * pad for pad in pads))

    def facets(self, name):
        """Their facets of a surface."""
        return self.body.their_facets(self.ours.facet_tags, self.ours.tags[name])

    def run(self, dt, u, v, friction, steps):
        """Their run from our start; states in our order, and contact forces."""
        model, hub = self.model, self.facets("hub")
        pressure = JOINT.load / JOINT.sides / model.flux_load(hub, 1.0).sum()
        fixed = np.unique(np.concatenate([bc.dof_indices()[0] for bc in self.ours.bcs]))
        sides = self.facets("slave_surface"), self.facets("master_surface")
        contact = impact_reference.NodalPenalty(*sides, friction, penalty=JOINT.penalty)
        return model.run_explicit(
            dt, steps, u0=self.body.to_theirs(u), v0=self.body.to_theirs(v), fixed_dofs=self.order[fixed],
            loads=model.traction(hub, np.array([0.0, 0.0, -pressure])), contacts=[contact],
        )  # fmt: skip


@pytest.fixture(scope="module")
def both():
    return Both()


@pytest.fixture(scope="module")
def ours(both):
    """Our run: springs with no more than their own penetration, as the other side has no offsets of the start."""
    passage = Passage(both.ours, False)
    start = passage.start(passage.preload())
    u = fem.Function(both.ours.V, name="u")
    u.x.array[:] = start.u.x.array
    run = di.ExplicitProblem(
        u, both.ours.material, velocity=start.velocity, bcs=both.ours.bcs, loads=[both.ours.press, both.ours.track],
        contact=[di.Penalty(both.ours.pair(JOINT.friction), penalty=JOINT.penalty)],
    )  # fmt: skip
    dt = 0.9 * run.stable_step()
    states = []
    run.advance(STEPS * dt, dt=dt, progress=False,
                callback=lambda p: states.append((p.u.x.array.copy(), p.velocity.x.array.copy())))  # fmt: skip
    return run, dt, np.array(states)


def differences(both, ours, friction=JOINT.friction, *, steps):
    """Largest differences of displacement, velocity and force of all steps, over their largest values."""
    run, dt, states = ours
    states = states[: steps + 1]
    u, v = states[0]
    theirs = both.run(dt, u, v, friction, steps)
    pairs = [(states[:, 0], theirs.u[:, both.order]), (states[:, 1], theirs.v[:, both.order])]
    pairs.append((run.force_history[0][:steps], theirs.contacts[0].total[:steps]))
    assert np.abs(pairs[2][1][:, 2]).min() > 0.3 * JOINT.load / JOINT.sides, "the wheel stands on the rail"
    return [float(np.abs(a - b).max() / np.abs(b).max()) for a, b in pairs]


@pytest.mark.parametrize("steps", [30, pytest.param(STEPS, marks=pytest.mark.slow)])
def test_two_solvers_make_the_same_passage(steps, both, ours):
    assert max(differences(both, ours, steps=steps)) < LIMIT


def test_another_friction_is_seen(both, ours):
    """Nodes at the edge of the contact slip soon."""
    assert max(differences(both, ours, friction=0.01, steps=30)) > 1e3 * LIMIT


def test_other_pads_are_seen(ours):
    assert max(differences(Both(support=1.01), ours, steps=10)) > LIMIT
