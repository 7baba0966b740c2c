# SPDX-License-Identifier: MIT
"""The rail joint by its parts: no joint, no impact; Hertz in mid-rail; mesh, step and penalty; trends.

No measured force of a passage over an insulated joint names all that the model needs, so nothing is compared with one.
"""

import numpy as np
import pytest
from mpi4py import MPI

from impact_studies.rail_joint import JointModel, Passage, RailJoint
from impact_studies.rail_joint.results import half_axes, summarise

pytestmark = pytest.mark.slow
COMM = MPI.COMM_WORLD
# Elastic, two cells in the half-axis; rails and bars short.
PLAIN = RailJoint().changed(
    cells=2, coarse=0.08, begin=-0.020, end=0.020, rail_length=0.7, bar_length=0.4, yield_stress=np.inf
)  # fmt: skip


def passage(joint, dt="auto"):
    """Numbers and history of a passage, and the Passage."""
    run = Passage(JointModel(joint, COMM), False)
    run.start(run.preload())
    history = run.roll(dt=dt)
    summary = summarise(joint, history, run.static_force, run.static_footprint, run.plastic_strain(), 0, COMM.size)
    return summary, history, run


@pytest.fixture(scope="module")
def plain():
    return passage(PLAIN)


def test_a_continuous_rail_makes_no_impact():
    """No joint, no bars, the same support everywhere: behind the first half-axis, in which the start settles, the force
    is the load within 1 %, with four cells in the half-axis as in the preset `coarse`."""
    joint = PLAIN.changed(cells=4, end_post="steel", support="winkler", rail_length=1.5, glue_modulus=1e5)
    _, history, _ = passage(joint)
    force = history.force[history.place > joint.begin + joint.hertz.a, 2] / joint.load
    assert 0.99 < force.min() and force.max() < 1.01, (force.min(), force.max())


def test_footprint_in_mid_rail():
    """Elastic: Hertz's ellipse within one cell, its pressure within 5 % with four cells in the half-axis."""
    joint = PLAIN.changed(cells=4, begin=-0.024)
    run = Passage(JointModel(joint, COMM), False)
    run.preload()
    footprint = run.static_footprint
    for size, theory in zip(half_axes(footprint, joint.sides), (joint.hertz.a, joint.hertz.b)):
        assert abs(size - theory) < joint.cell_size, (size, theory)
    assert footprint.pressure.max() == pytest.approx(joint.hertz.peak_pressure, rel=0.05)


def test_step_penalty_and_cells_do_not_matter(plain):
    """With four cells in the half-axis, as in the preset `coarse`: half the step with the same springs, twice the
    penalty and half as many cells change the largest and the least force by less than 3 %."""
    coarse, history, run = passage(PLAIN.changed(cells=4))
    contact = run.run.contact[0]
    closed = contact.stiffness > 0.0
    penalty = COMM.allreduce(float((contact.stiffness[closed] / contact.weight[closed]).max(initial=0.0)), MPI.MAX)
    half, _, _ = passage(PLAIN.changed(cells=4), dt=0.5 * history.dt)
    hard, _, _ = passage(PLAIN.changed(cells=4, penalty=2.0 * penalty))
    for other in (half, hard, plain[0]):
        assert other.dynamic_factor == pytest.approx(coarse.dynamic_factor, rel=0.03)
        assert other.least_force == pytest.approx(coarse.least_force, rel=0.03)


def test_published_trends(plain):
    """The peak grows with speed and gap. A softer end post makes the dip deeper; the first peak behind it does not
    follow what is published, and stays as it is within 2 % (found: 0.9 %), which docs/rail_joint.md discusses."""
    usual = plain[0]
    assert passage(PLAIN.changed(speed=160 / 3.6))[0].dynamic_factor > usual.dynamic_factor
    assert passage(PLAIN.changed(gap=10e-3))[0].dynamic_factor > usual.dynamic_factor
    soft = passage(PLAIN.changed(end_post="nylon"))[0]
    assert soft.least_force < usual.least_force - 0.02
    assert soft.dynamic_factor == pytest.approx(usual.dynamic_factor, abs=0.02)


def test_parts_meshed_apart():
    """Bars, or bars and end post, in meshes of their own and tied: the force is that of one mesh. The springs are
    given: by the step they are softer at the ends of tied parts, where a node has the mass of one part alone."""
    joint = PLAIN.changed(penalty=1e13)
    one, _, _ = passage(joint)
    for tied, size in (("bars", 1.5), ("all", 0.7)):
        apart, history, run = passage(joint.changed(tied=tied, tied_size=size))
        assert apart.static_force == pytest.approx(one.static_force, rel=1e-4)
        assert apart.dynamic_factor == pytest.approx(one.dynamic_factor, abs=0.01)
        assert apart.least_force == pytest.approx(one.least_force, abs=0.01)
        assert apart.energy_missed < 1e-3
        assert [c.kind for c in run.run.contact[1:]] == ["tie"] * (1 if tied == "bars" else 3)


@pytest.mark.parametrize("post", ("epoxy", "nylon", "ptfe", "steel"))
def test_stiff_and_soft_end_posts_find_their_preload(post, recwarn):
    """From 45 GPa to 0.4 GPa beside steel: multigrid converges, and no system is factorised instead."""
    run = Passage(JointModel(PLAIN.changed(end_post=post), COMM), False)
    static = run.preload()
    assert run.static_force == pytest.approx(PLAIN.load, rel=1e-4)
    assert not static.linear_solver.direct
    assert not any("factorised" in str(w.message) for w in recwarn)
