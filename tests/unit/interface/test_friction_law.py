# SPDX-License-Identifier: MIT
"""Laws of friction: Coulomb's coefficient in UFL, with multipliers, kinematic contact and rolling."""

import dolfinx_impact as di
import friction_checks
import numpy as np
import pytest
import ufl
from blocks import Blocks
from dolfinx import fem, mesh
from dolfinx_impact import interface
from dolfinx_impact.forms.friction import FrictionForm
from dolfinx_impact.interface.compiled_law import CompiledLaw
from mpi4py import MPI
from impact_verify.selfcheck.friction_law import FrictionSubject
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(friction_checks)

LAWS = {
    "falling": lambda: di.FrictionLaw(interface.falling_friction(0.5, 0.2, 0.3)),
    "pressure": lambda: di.FrictionLaw(lambda pressure: 0.3 / (1 + pressure)),
    "both": lambda: di.FrictionLaw(
        lambda pressure, slip_rate, parameters: parameters.mu
        * ufl.exp(-pressure / 3) / (1 + ufl.sqrt(1e-8 + ufl.dot(slip_rate, slip_rate))), parameters={"mu": 0.4},
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", LAWS)
def test_self_check(name):
    report = di.verify.self_check(LAWS[name](), velocity=0.4)
    assert report.passed and len(report.rows) == 6, [r.note for r in report.rows if not r.passed]


def test_self_check_sees_a_law_with_a_frame_or_without_a_sign():
    frame = di.FrictionLaw(lambda slip_rate: 0.3 + 0.1 * slip_rate[0] / ufl.sqrt(1 + slip_rate[0] ** 2))
    assert {r.name for r in di.verify.self_check(frame).failures()} == {"rotation"}
    assert di.verify.self_check(frame, isotropic=False).passed
    below = di.FrictionLaw(lambda pressure: 0.3 - pressure)
    assert "sign" in {r.name for r in di.verify.self_check(below).failures()}


def test_the_kernel_is_the_expression():
    law = LAWS["both"]()
    found = law.compiled(2, MPI.COMM_SELF).evaluate(
        {"pressure": np.array([0.0, 3.0]), "slip_rate": np.array([3.0, 4.0, 0.0, 0.0]),
         "normal": np.array([0.0, 1.0, 0.0, 1.0])}
    )  # fmt: skip
    assert found.value == pytest.approx([0.4 / 6.0, 0.4 / np.e / (1 + 1e-4)], rel=1e-9)
    assert law.compiled(2, MPI.COMM_SELF).has_rates and LAWS["pressure"]().compiled(2, MPI.COMM_SELF).has_pressure
    assert isinstance(law, CompiledLaw) and set(FrictionForm(law, 2, (), ("mu",)).point_law.outputs) == {
        "coefficient", "derivative by pressure", "derivative by slip_rate"
    }  # fmt: skip
    assert found.by_pressure == pytest.approx(-found.value / 3, rel=1e-12)
    law.set(mu=0.8)
    assert law.parameters == {"mu": 0.8}


def test_a_coefficient_below_zero_counts_as_none():
    law = di.FrictionLaw(lambda pressure: 0.3 - pressure)
    values = {"pressure": np.array([0.1, 2.0]), "slip_rate": np.zeros(4), "normal": np.array([0.0, 1.0, 0.0, 1.0])}
    found = law.compiled(2, MPI.COMM_SELF).evaluate(values)
    assert found.value == pytest.approx([0.2, 0.0]) and list(found.by_pressure) == [-1.0, 0.0]


def test_implicit_steps_are_of_first_order():
    """The slip velocity is that of a step, whose error halves with it (seen: 0.037, 0.018)."""
    coarse, fine = (friction_checks.deviation(di.NewmarkProblem, 6.0, dt=dt) for dt in (0.1, 0.05))
    assert coarse < 0.05 and 1.7 < coarse / fine < 2.4


def test_refusals():
    blocks = Blocks("quadrilateral", (2, 1), (2, 1))
    law = LAWS["falling"]()
    still = di.StaticProblem(blocks.u, friction_checks.steel(2), contact=[di.Lagrange(blocks.pair(friction=law))])
    with pytest.raises(ValueError, match="depends on the slip velocity.*NewmarkProblem"):
        still.solve()
    for kind in (di.StaticProblem, di.ExplicitProblem):
        with pytest.raises(ValueError, match=r"Penalty takes a number as its friction.*law="):
            kind(blocks.u, friction_checks.steel(2), contact=[di.Penalty(blocks.pair(friction=law))])
    with pytest.raises(ValueError, match="do not rub"):
        di.Tie(blocks.pair(friction=law))
    with pytest.raises(TypeError, match="must be a function"):
        di.FrictionLaw(0.3)
    wrong = {
        "asks for": lambda gap: 0.3, "is a number": lambda slip_rate: slip_rate,
        "contains the function": lambda pressure: blocks.u[0],
    }  # fmt: skip
    for match, function in wrong.items():
        with pytest.raises((TypeError, ValueError), match=match):
            di.FrictionLaw(function).compiled(2, MPI.COMM_SELF)
    field = fem.Function(fem.functionspace(blocks.mesh, ("Lagrange", 2)))
    warm = di.FrictionLaw(lambda fields: 0.01 * fields.T_slave, fields={"T": field})
    with pytest.raises(ValueError, match="degree of the displacement"):
        di.StaticProblem(blocks.u, friction_checks.steel(2), contact=[di.Lagrange(blocks.pair(friction=warm))])


def test_points_of_the_self_check():
    subject = FrictionSubject(LAWS["falling"](), 3, pressure=2.0, velocity=0.1)
    along = np.sum(subject.values["slip_rate"] * subject.values["normal"], axis=1)
    assert np.abs(along).max() < 1e-15 and np.asarray(subject.evaluate().value).shape == along.shape


def test_a_plain_function_is_a_law():
    pair = Blocks("quadrilateral", (1, 1), (1, 1)).pair(friction=lambda pressure: 0.1 + 0 * pressure)
    assert isinstance(pair.friction, di.FrictionLaw) and pair.has_friction and "FrictionLaw" in repr(pair)


def test_rolling_takes_laws_of_the_gap_alone():
    """Points of a mesh that the material flows through have no slip of their own, and no history."""
    blocks = Blocks("quadrilateral", (2, 1), (2, 1))
    cells = blocks.mesh.topology.index_map(2).size_local
    tags = mesh.meshtags(blocks.mesh, 2, np.arange(cells, dtype=np.int32), np.ones(cells, dtype=np.int32))
    motions = {1: di.Translation((0.1, 0.0))}

    def made(law):
        contact = [di.Penalty(blocks.pair(), law=law)]
        return di.RollingProblem(blocks.u, friction_checks.steel(2), tags, motions, contact=contact)

    made(interface.exponential_pressure(10.0, 0.01))
    for law in (interface.linear_pressure(1e3, friction=0.3), interface.cohesive_zone(1e4, 200.0, 8.0, 300.0, 12.0)):
        with pytest.raises(ValueError, match="which flows through the mesh.*law of friction"):
            made(law)
