# SPDX-License-Identifier: MIT
"""Laws of the interface by themselves: what is refused, parameters, and what must hold of any law."""

import dolfinx_impact as di
import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from dolfinx_impact import interface
from dolfinx_impact.forms.compiler.frontend import form_signature
from dolfinx_impact.forms.interface import InterfaceForm
from impact_verify.selfcheck.interface_law import CHECKS, LawSubject
from mpi4py import MPI

LAWS = {
    "linear": lambda: interface.linear_pressure(1e6),
    "exponential": lambda: interface.exponential_pressure(200.0, 1e-3),
    "damped": lambda: interface.damped_contact(1e6, 5.0),
    "adhesion": lambda: interface.adhesion(0.3, 1e-4),
    "friction": lambda: interface.linear_pressure(1e6, friction=0.4),
    "falling friction": lambda: interface.exponential_pressure(
        200.0, 1e-3, friction=interface.falling_friction(0.5, 0.2, 1e-3)
    ),
    "cohesive": lambda: interface.cohesive_zone(1e6, 300.0, 0.2, 500.0, 0.4),
    "anisotropic": lambda: interface.anisotropic_friction(1e6, (0.6, 0.2), (1.0, 1.0, 0.3)),
}


@pytest.mark.parametrize("name", LAWS)
def test_laws_of_the_package_hold_their_checks(name):
    # Gaps of the adhesion's range: its energy is round-off at a quarter of its reach.
    length = 2e-4 if name == "adhesion" else None
    report = di.verify.self_check(LAWS[name](), name=name, length=length, isotropic=name != "anisotropic")
    made = [f for f in report.findings if f.applies]
    assert report.passed, [f"{f.cell} {f.name}: {f.note}" for f in made if not f.passed]
    left_out = {f.name for f in report.findings if not f.applies}
    assert left_out == ({"rotation"} if name == "anisotropic" else set())


def energy_from_nothing():
    return di.InterfaceLaw(
        pressure=lambda gap: -1e6 * gap, shear=lambda slip: 1e6 * slip, energy=lambda gap: 5e5 * gap**2
    )


def wrong_energy():
    return di.InterfaceLaw(pressure=lambda gap: -1e6 * gap, energy=lambda gap: 9e5 * gap**2)


def frame_of_its_own():
    return di.InterfaceLaw(pressure=lambda gap, slip: -1e6 * gap + 2e5 * slip[0], energy=lambda gap: 5e5 * gap**2)


def out_of_the_surface():
    return di.InterfaceLaw(
        pressure=lambda gap: -1e6 * gap, shear=lambda gap, normal: gap * normal, energy=lambda gap: 5e5 * gap**2
    )


@pytest.mark.parametrize(
    "law, check",
    [
        (energy_from_nothing, "dissipation"),
        (wrong_energy, "dissipation"),
        (frame_of_its_own, "rotation"),
        (out_of_the_surface, "tangential"),
    ],
)
def test_wrong_laws_are_caught(law, check):
    report = di.verify.self_check(law(), length=1e-3)
    assert not report.passed
    failed = [f for f in report.of(check) if not f.passed]
    assert failed and all(f.note for f in failed)


def test_a_wrong_derivative_is_caught(monkeypatch):
    right = InterfaceForm._derivative

    def wrong(z, x, update, unknown):
        return [1.01 * e for e in right(z, x, update, unknown)]

    monkeypatch.setattr(InterfaceForm, "_derivative", staticmethod(wrong))
    report = di.verify.self_check(interface.exponential_pressure(211.0, 1e-3), name="wrong")
    assert [f.name for f in report.findings if f.applies and not f.passed] == ["derivative"] * 2
    assert set(CHECKS) == {f.name for f in report.findings}


def test_paths_of_the_checks_lie_in_the_tangent_planes():
    subject = LawSubject(interface.linear_pressure(1.0), 3, 1e-3, 1.0)
    gaps, slips = subject.path()
    assert not gaps[0].any() and not slips[0].any() and 1e-4 < np.abs(gaps).max() < 1e-2
    assert np.abs(np.einsum("tnc,nc->tn", slips, subject.normal)).max() < 1e-17


@pytest.mark.parametrize("name", LAWS)
def test_a_law_that_is_written_again_is_the_same(name):
    """Kernels are found in the cache, and checkpoints know the law again, whatever UFL has counted in between."""
    found = set()
    for _ in range(3):
        law = LAWS[name]()
        form = InterfaceForm(law, 3, tuple(law.fields), tuple(law.parameters))
        found.add(form_signature(form.form, form.point_law))
    assert len(found) == 1


def of_points(law, gdim, gap, slip, **more):
    n = len(gap)
    values = {"gap": gap, "slip": slip, "gap_rate": np.zeros(n), "slip_rate": np.zeros(n * gdim)}
    values |= {"normal": np.tile([0.0] * (gdim - 1) + [1.0], n)} | more
    values = {name: np.ascontiguousarray(np.ravel(v), dtype=float) for name, v in values.items()}
    return law.compiled(gdim, MPI.COMM_SELF).evaluate(values)


@pytest.mark.parametrize("count", [1, 3, 8, 9, 17])
def test_points_that_do_not_fill_the_lanes(count):
    gap = np.linspace(-1e-3, 1e-3, count)
    law = di.InterfaceLaw(pressure=lambda gap: 3.0 * gap**2, shear=lambda slip, gap: gap * slip)
    slip = np.random.default_rng(1).normal(size=(count, 2))
    found = of_points(law, 2, gap, slip)
    assert np.allclose(found.pressure, 3.0 * gap**2, rtol=1e-15)
    assert np.allclose(np.reshape(found.shear, (-1, 2)), gap[:, None] * slip, rtol=1e-15)
    by = np.reshape(found.by("slip"), (count, 3, 2))
    assert np.allclose(by[:, 1:], gap[:, None, None] * np.eye(2), rtol=1e-15) and not by[:, 0].any()
    assert not np.size(found.by("gap_rate"))


def test_local_equations_and_what_is_said_if_they_fail():
    def respond(point):
        x = point.unknown
        return di.InterfaceUpdate(x, residual=x + x**3 - point.gap, start=ufl.as_ufl(0.0), scale=1.0)

    law = di.InterfaceLaw(response=respond, unknown=())
    gap = np.linspace(-1.0, 1.0, 11)
    found = of_points(law, 2, gap, np.zeros((11, 2)))
    x = np.asarray(found.pressure)
    assert found.num_unsolved == 0 and np.allclose(x + x**3, gap, atol=1e-12)
    # dx/dg = 1/(1 + 3 x^2), by the implicit function theorem.
    assert np.allclose(np.reshape(found.by("gap"), (11, 3))[:, 0], 1 / (1 + 3 * x**2), rtol=1e-12)

    def without_solution(point):
        x = point.unknown
        return di.InterfaceUpdate(x, residual=x**2 + 1 + point.gap, start=ufl.as_ufl(1.0), scale=1.0)

    found = of_points(di.InterfaceLaw(response=without_solution, unknown=()), 2, gap, np.zeros((11, 2)))
    assert found.num_unsolved == 10  # all but the gap of -1


def test_parameters_change_without_compiling():
    law = interface.linear_pressure(2.0)
    made = law.compiled(2, MPI.COMM_SELF)
    law._made_for[2] = made
    values = {"gap": [-1.0], "slip": np.zeros(2), "gap_rate": [0.0], "slip_rate": np.zeros(2), "normal": [0.0, 1.0]}
    values = {name: np.ascontiguousarray(v, dtype=float) for name, v in values.items()}
    assert made.evaluate(values).pressure == [2.0]
    law.set(stiffness=5.0)
    assert made.evaluate(values).pressure == [5.0] and law.parameters == {"stiffness": 5.0}
    with pytest.raises(ValueError, match="no parameter 'k'"):
        law.set(k=1.0)


@pytest.mark.parametrize(
    "options, message",
    [
        ({}, "one of `pressure`"),
        (dict(pressure=lambda gap: gap, traction=lambda gap: gap), "one of `pressure`"),
        (dict(energy=lambda gap: gap, shear=lambda slip: slip), "`shear` goes with `pressure`"),
        (dict(energy=lambda gap: gap, friction=0.3), "`friction` goes with `pressure`"),
        (dict(response=lambda p: None, update=lambda gap: {}), "returns energy and history itself"),
        (dict(pressure=lambda gap: gap, history={"a": (2, 2)}), "history 'a' has shape"),
        (dict(pressure=lambda gap: gap, reach=-1.0), "reach"),
    ],
)
def test_parts_that_do_not_fit_are_refused(options, message):
    with pytest.raises(ValueError, match=message):
        di.InterfaceLaw(**options)


def test_what_functions_ask_for_and_return():
    with pytest.raises(TypeError, match="`pressure` of a law asks for \\['g'\\]"):
        di.InterfaceLaw(pressure=lambda g: g).compiled(2, MPI.COMM_SELF)
    with pytest.raises(TypeError, match="must be a function"):
        di.InterfaceLaw(pressure=3.0)
    with pytest.raises(ValueError, match="history \\[\\], it has \\['a'\\]"):
        di.InterfaceLaw(pressure=lambda gap: gap, history={"a": ()}).compiled(2, MPI.COMM_SELF)
    with pytest.raises(ValueError, match="shape"):
        di.InterfaceLaw(pressure=lambda slip: slip).compiled(2, MPI.COMM_SELF)
    with pytest.raises(TypeError, match="not an InterfaceUpdate"):
        di.InterfaceLaw(response=lambda point: 3).compiled(2, MPI.COMM_SELF)
    square = mesh.create_unit_square(MPI.COMM_SELF, 1, 1)
    f = fem.Function(fem.functionspace(square, ("Lagrange", 1)), name="theta")
    with pytest.raises(ValueError, match="the function theta: give it in `fields`"):
        di.InterfaceLaw(pressure=lambda gap: f * gap).compiled(2, MPI.COMM_SELF)
    c = fem.Constant(square, 1.0)
    with pytest.raises(ValueError, match="give its value in `parameters`"):
        di.InterfaceLaw(pressure=lambda gap: c * gap).compiled(2, MPI.COMM_SELF)


def test_cohesive_zone_refuses_a_bond_that_cannot_break():
    with pytest.raises(ValueError, match="in shear the bond stores"):
        interface.cohesive_zone(1e3, 10.0, 1.0, shear_strength=100.0)
