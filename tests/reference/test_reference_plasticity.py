# SPDX-License-Identifier: MIT
"""J2 plasticity at points: closed forms, the discrete equations themselves, tangents, dissipation, objectivity."""

import dataclasses

import impact_reference as ir
import numpy as np
import pytest
from plastic_laws import (
    EYE,
    ISOTROPIC,
    KINEMATIC,
    LAWS,
    TABLE,
    E,
    G,
    K,
    NU,
    Y0,
    dev,
    inner,
    law,
    mises,
    norm,
    random_rotations,
    random_strains,
    residuals,
)

ELASTIC = np.diag([1.0, -NU, -NU])  # strain of a uniaxial stress E
PLASTIC = np.diag([1.0, -0.5, -0.5])
FINITE = ["simo", "hencky"]
FINITE_CASES = [(s, n) for s in FINITE for n in LAWS]
CASES = [("small", n) for n in LAWS] + FINITE_CASES
# Stress from strain: round-off of strains about 1e-16 times the stiffness 3 K + 2 G = 6e5 over Y0 = 250.
ROUND = 1e-11


@pytest.fixture
def rng():
    return np.random.default_rng(13)


def uniaxial(parameters, plastic_strains, stresses):
    """Axial stresses of a point that gets the strains of given uniaxial stresses and axial plastic strains."""
    point = ir.J2Point(parameters)
    found = []
    for e_p, sigma in zip(plastic_strains, stresses):
        answer = point.evaluate(sigma / E * ELASTIC + e_p * PLASTIC)
        point.commit(answer)
        found.append(answer.stress[0])
    return np.array(found), point.history


# -- closed forms ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ISOTROPIC)
def test_uniaxial_tension(name):
    """J-5: sigma = Y(eps_p); for the linear law Y + H eps_p."""
    e_p = np.array([0.0, 1e-4, 5e-4, 2.5e-3, 9e-3, 0.04, 0.06])
    keys = ISOTROPIC[name]
    if name == "table":
        expected = np.interp(e_p, *TABLE)
    else:
        expected = Y0 + keys.get("hardening", 0.0) * e_p
        if name == "voce":
            expected = expected + (400.0 - Y0) * (1 - np.exp(-60.0 * e_p))
    found, history = uniaxial(law(name), e_p, expected)
    assert np.abs(found - expected[:, None, None] * np.diag([1.0, 0, 0])).max() < ROUND * Y0
    assert abs(history.plastic_strain[0] - e_p[-1]) < 1e-14
    assert np.abs(law(name).yield_stress(e_p) - expected).max() < 1e-13 * Y0


def test_simple_shear():
    """J-5: tau = Y/sqrt(3), whatever the shear."""
    point = ir.J2Point(law("perfect"))
    for shear in (0.9, 1.5, 7.0):
        strain = np.zeros((3, 3))
        strain[0, 1] = strain[1, 0] = shear * Y0 / np.sqrt(3) / (2 * G)
        answer = point.evaluate(strain)
        point.commit(answer)
        tau = min(shear, 1.0) * Y0 / np.sqrt(3)
        assert np.abs(answer.stress[0] - tau * (np.eye(3)[[1, 0, 2]] - np.diag([0, 0, 1.0]))).max() < ROUND * Y0


def test_bauschinger_loop():
    """Prager's law: sigma = X +- Y0 with X = C eps_p, in cycles; one step for a whole branch is exact."""
    C = 2e4
    e_p = np.array([0.01, 0.01, -0.02, 0.03, 0.0])
    X = C * e_p
    sign = np.array([1, 0, -1, 1, -1])  # 0: inside the surface
    found, history = uniaxial(law("prager"), e_p, X + sign * Y0)
    assert np.abs(found[:, 0, 0] - X - sign * Y0).max() < 10 * ROUND * Y0
    assert np.abs(found[:, 1:, 1:]).max() < 10 * ROUND * Y0
    assert np.isclose(history.plastic_strain[0], 0.01 + 0.03 + 0.05 + 0.03, rtol=1e-12)
    assert np.abs(history.back_stress[0] - C * e_p[-1] * np.diag([2, -1, -1]) / 3).max() < ROUND * Y0


def armstrong_path(per_branch):
    """Axial plastic strain and the back stress of backward Euler, and the exponential of the differential equation."""
    C, gamma = 4e4, 200.0
    corners = [0.0, 0.05, -0.01, 0.02]
    e_p, X, exact, sign = [0.0], [0.0], [0.0], [0]
    for start, end in zip(corners[:-1], corners[1:]):
        direction = np.sign(end - start)
        at_start = exact[-1]
        for e in np.linspace(start, end, per_branch + 1)[1:]:
            step = abs(e - e_p[-1])
            X.append((X[-1] + C * (e - e_p[-1])) / (1 + gamma * step))
            limit = direction * C / gamma
            exact.append(limit + (at_start - limit) * np.exp(-gamma * abs(e - start)))
            e_p.append(e)
            sign.append(direction)
    return (np.array(a[1:]) for a in (e_p, X, exact, sign))


def test_armstrong_frederick_loop():
    """X = C/gamma (1 - exp(-gamma eps_p)) and its loop: backward Euler's recursion to round-off, itself of order 1."""
    errors = []
    for per_branch in (50, 100, 200):
        e_p, X, exact, sign = armstrong_path(per_branch)
        found, history = uniaxial(law("armstrong"), e_p, X + sign * Y0)
        assert np.abs(found[:, 0, 0] - X - sign * Y0).max() < 100 * ROUND * Y0  # hundreds of steps
        assert np.abs(history.back_stress[0, 0, 0] - 2 / 3 * X[-1]) < 100 * ROUND * Y0
        errors.append(np.abs(X - exact).max())
        # saturation at C/gamma = 200 within exp(-gamma 0.05), and the Euler steps' (1 + gamma da)^-n
        assert abs(X[per_branch - 1] - 200.0) < 200.0 * (1 + 200.0 * 0.05 / per_branch) ** -per_branch * 1.01
    assert np.allclose(np.log2(np.array(errors[:-1]) / errors[1:]), 1, atol=0.1)


def test_hencky_law_in_finite_tension():
    """Coaxial: Kirchhoff's stress over logarithmic strain is the small strain law, in one step of 40 %."""
    point = ir.J2Point(law("linear"), strain="hencky")
    for e_p in (0.4, 0.9, 0.2):
        sigma = Y0 + 5e3 * {0.4: 0.4, 0.9: 0.9, 0.2: 1.6}[e_p]
        sigma = -sigma if e_p == 0.2 else sigma
        F = np.diag(np.exp(np.diag(sigma / E * ELASTIC + e_p * PLASTIC)))
        answer = point.evaluate(F)
        point.commit(answer)
        tau = answer.stress[0] @ F.T
        assert np.abs(tau - np.diag([sigma, 0, 0])).max() < 1e-9 * Y0  # the stiffness times round-off of F about 1
        assert np.isclose(np.linalg.det(point.history.plastic_strain_tensor[0]), 1, rtol=1e-12)
    assert np.isclose(point.history.plastic_strain[0], 1.6, rtol=1e-9)


# -- the equations of backward Euler themselves ------------------------------------------------------------------------


@pytest.mark.parametrize("name", LAWS)
def test_equations_of_the_step(name, rng):
    """Random histories: every equation of the discrete law holds, and trials leave the committed history alone."""
    parameters, n = law(name), 100
    point = ir.J2Point(parameters, n)
    yielded = 0
    for strain in random_strains(rng, 20, n, Y0 / E):
        before = point.history
        copies = [getattr(before, f.name).copy() for f in dataclasses.fields(before)]
        answer = point.evaluate(strain)
        for f, copy in zip(dataclasses.fields(before), copies):
            assert np.array_equal(getattr(point.history, f.name), copy)
        bad = residuals(parameters, LAWS[name], strain, before, answer)
        # Strains walk to some 20 times that of yield, and round-off with them.
        assert max(bad.values()) < 100 * ROUND, bad
        yielded += np.sum(answer.history.plastic_strain > before.plastic_strain)
        point.commit(answer)
    assert 0.3 < yielded / (20 * n) < 1


def test_the_equations_notice_mistakes(rng):
    """Sabotage: wrong factors and a history that is committed twice."""
    parameters, keys = law("both"), LAWS["both"]
    point = ir.J2Point(parameters, 20)
    one, two = random_strains(rng, 2, 20, 8 * Y0 / E)
    point.commit(point.evaluate(one))
    before, answer = point.history, point.evaluate(two)
    assert max(residuals(parameters, keys, two, before, answer).values()) < ROUND

    def spoilt(**changes):
        return dataclasses.replace(answer, history=dataclasses.replace(answer.history, **changes))

    after = answer.history
    a = before.plastic_strain + 2 / 3 * (after.plastic_strain - before.plastic_strain)
    assert residuals(parameters, keys, two, before, spoilt(plastic_strain=a))["equivalent"] > 0.1
    twice = 2 * after.plastic_strain_tensor - before.plastic_strain_tensor
    assert residuals(parameters, keys, two, before, spoilt(plastic_strain_tensor=twice))["hooke"] > 0.1
    back = before.back_stress + 1.5 * (after.back_stress - before.back_stress)
    assert residuals(parameters, keys, two, before, spoilt(back_stress=back))["back stress"] > 0.1
    elastic = dataclasses.replace(answer, stress=answer.stress * 1.01)
    assert residuals(parameters, keys, two, before, elastic)["complementary"] > 1e-3


def test_energy_of_a_step(rng):
    """sigma : d eps_p = dissipation + change of 3/(4 C) beta : beta + 3/(4 C) |d beta|^2, and dissipation >= 0."""
    for name in KINEMATIC:
        point = ir.J2Point(law(name), 100)
        C = KINEMATIC[name]["kinematic"]
        for strain in random_strains(rng, 20, 100):
            before, answer = point.history, point.evaluate(strain)
            after = answer.history
            power = inner(answer.stress, after.plastic_strain_tensor - before.plastic_strain_tensor)
            stored = 0.75 / C * (norm(after.back_stress) ** 2 - norm(before.back_stress) ** 2)
            lost = 0.75 / C * norm(after.back_stress - before.back_stress) ** 2
            assert np.abs(power - answer.dissipation - stored - lost).max() < 100 * ROUND * Y0**2 / E
            assert np.all(answer.dissipation >= 0) and np.any(answer.dissipation > 0)
            point.commit(answer)


@pytest.mark.parametrize("strain, name", CASES)
def test_work_of_the_stress_is_stored_or_plastic(name, strain, rng):
    """Elastic energy and plastic work against the work of the stress by the trapezoidal rule.

    In small strain both rules are the same and the balance is exact. In finite strain steps of the path make errors of
    order 2, and the flow of Simo's law is off by the elastic strain, 1e-3.
    """
    end = rng.standard_normal((50, 3, 3)) * 10 * Y0 / E
    if strain == "small":
        end = (end + end.swapaxes(-1, -2)) / 2

    def imbalance(steps):
        point = ir.J2Point(law(name), 50, strain)
        last, work = np.zeros((50, 3, 3)), np.zeros(50)
        for k in range(1, steps + 1):
            here = k / steps * end * np.cos(2.5 * k / steps)
            there = (k - 1) / steps * end * np.cos(2.5 * (k - 1) / steps)
            answer = point.evaluate(here if strain == "small" else EYE + here)
            work += inner(answer.stress + last, here - there) / 2
            last = answer.stress
            point.commit(answer)
        assert np.all(point.history.work > 0)
        return np.abs(work - answer.energy - point.history.work).max() / work.max()

    if strain == "small":
        assert imbalance(20) < 1e-12
    else:
        assert imbalance(200) < 3e-3


@pytest.mark.parametrize("strain, name", CASES)
def test_dissipation_is_never_negative(name, strain, rng):
    """Heat of every step; without back stress, which stores energy and gives it back, the plastic work, too."""
    point = ir.J2Point(law(name), 200, strain)
    path = random_strains(rng, 30, 200, Y0 / E)
    for e in path:
        answer = point.evaluate(e if strain == "small" else EYE + e)
        assert np.all(answer.dissipation >= 0)
        if name in ISOTROPIC:
            assert np.all(answer.history.work >= point.history.work)
        point.commit(answer)


# -- tangents ----------------------------------------------------------------------------------------------------------


def orders(evaluate, tangent, at, direction, steps):
    """Orders of the Taylor remainders, at points."""
    change = np.einsum("pijkl,pkl->pij", tangent, direction)
    remainders = np.array([norm(evaluate(at + h * direction) - evaluate(at) - h * change) for h in steps])
    return np.log(remainders[:-1] / remainders[1:]) / np.log(np.array(steps[:-1]) / steps[1:])[:, None]


@pytest.mark.parametrize("strain, name", CASES)
def test_tangent_is_the_derivative(name, strain, rng):
    """Taylor remainders of order 2 where the point yields; elastic points have no remainder in small strain."""
    n = 40
    point = ir.J2Point(law(name), n, strain)
    size = Y0 / E if name == "softening" else 4 * Y0 / E
    answer = None
    for e in random_strains(rng, 3, n, size):
        at = e if strain == "small" else random_rotations(rng, n) @ (EYE + e)
        stale, answer = (None, point.evaluate(at)) if answer is None else (answer.tangent, point.evaluate(at))
        last = point.history
        point.commit(answer)
    point.history = last
    yields = answer.history.plastic_strain > last.plastic_strain
    direction = rng.standard_normal((n, 3, 3)) * Y0 / E
    if strain == "small":
        direction = (direction + direction.swapaxes(-1, -2)) / 2

    def evaluate(x):
        return point.evaluate(x, with_tangent=False).stress

    assert yields.sum() > 10
    found = orders(evaluate, answer.tangent, at, direction, [1e-2, 5e-3, 2.5e-3])
    # Median over the points: one of them may stop yielding, or cross a corner of a table, within a step of 1e-2.
    assert np.allclose(np.median(found[:, yields], axis=1), 2, atol=0.1), found[:, yields]
    assert np.sum(np.abs(found[:, yields] - 2).max(axis=0) > 0.3) <= 0.15 * yields.sum()
    if strain == "small" and not yields.all():
        remainder = norm(
            evaluate(at + 1e-3 * direction)
            - answer.stress
            - 1e-3 * np.einsum("pijkl,pkl->pij", answer.tangent, direction)
        )
        assert remainder[~yields].max() < ROUND * Y0
    # Sabotage: with the tangent of the step before, and with one that is 1 % too stiff, the order is 1.
    for wrong in (stale, 1.01 * answer.tangent):
        found = orders(evaluate, wrong, at, direction, [1e-3, 5e-4, 2.5e-4])
        assert np.allclose(np.median(found[:, yields], axis=1), 1, atol=0.1)


@pytest.mark.parametrize("strain", ["small", *FINITE])
def test_both_sides_of_the_corner(strain):
    """Just below the yield surface the tangent is elastic, just above it is not; both are derivatives on their side."""
    point = ir.J2Point(law("linear"), 1, strain)
    yields = Y0 / E * ELASTIC
    direction = np.array([[1.0, 0.3, 0], [0.3, -0.5, 0.2], [0, 0.2, 0.1]]) * Y0 / E
    base = np.zeros((3, 3)) if strain == "small" else EYE
    for side, scale in ((-1, 0.99), (1, 1.01)):
        answer = point.evaluate(base + scale * yields)
        assert (answer.history.plastic_strain[0] > 0) == (side > 0)
        change = np.einsum("ijkl,kl->ij", answer.tangent[0], direction)
        remainders = [
            norm(point.evaluate(base + scale * yields + h * direction).stress[0] - answer.stress[0] - h * change)
            for h in (2e-3, 1e-3)
        ]
        assert remainders[1] < 1e-10 * Y0 or abs(np.log2(remainders[0] / remainders[1]) - 2) < 0.1


# -- finite strain -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("strain, name", FINITE_CASES)
def test_objectivity(strain, name, rng):
    """Another random rotation after every step turns the stress and nothing else: P(Q F) = Q P(F)."""
    n = 50
    still, turned = (ir.J2Point(law(name), n, strain) for _ in range(2))
    for e in random_strains(rng, 8, n, Y0 / E if name == "softening" else 0.03):
        F = EYE + e + 0.02 * (Q0 := rng.standard_normal((n, 3, 3))) - 0.02 * Q0.swapaxes(-1, -2)
        Q = random_rotations(rng, n)
        one, two = still.evaluate(F), turned.evaluate(Q @ F)
        size = np.abs(one.stress).max()
        assert np.abs(two.stress - Q @ one.stress).max() < 1e-11 * size
        T = np.einsum("pim,pkn,pmjnl->pijkl", Q, Q, one.tangent)
        assert np.abs(two.tangent - T).max() < 1e-10 * np.abs(T).max()
        for field in ("plastic_strain", "plastic_strain_tensor", "back_stress", "stress", "work"):
            a, b = getattr(one.history, field), getattr(two.history, field)
            assert np.abs(a - b).max() <= 1e-11 * max(np.abs(a).max(), 1e-300), field
        still.commit(one)
        turned.commit(two)
    assert still.history.plastic_strain.min() > 0


@pytest.mark.parametrize("strain, name", FINITE_CASES)
def test_isotropy(strain, name, rng):
    """Another reference configuration, turned: P(F Q^T) = P(F) Q^T, with Prager's and all other back stresses."""
    still, turned = (ir.J2Point(law(name), 20, strain) for _ in range(2))
    Q = random_rotations(rng, 20)
    for e in random_strains(rng, 4, 20, Y0 / E if name == "softening" else 0.02):
        one = still.evaluate(EYE + e)
        two = turned.evaluate((EYE + e) @ Q.swapaxes(-1, -2))
        assert np.abs(two.stress - one.stress @ Q.swapaxes(-1, -2)).max() < 1e-11 * np.abs(one.stress).max()
        still.commit(one)
        turned.commit(two)


@pytest.mark.parametrize("strain, name", FINITE_CASES)
def test_small_strain_limit(strain, name, rng):
    """Yield stress and strains scaled by h: stresses over h differ from those of small strain by order h."""
    path = random_strains(rng, 5, 30, Y0 / E)
    errors = []
    for h in (1.0, 0.5, 0.25):
        keys = {key: value * h for key, value in LAWS[name].items() if key in ("yield_stress", "saturation_stress")}
        keys |= {key: LAWS[name][key] for key in ("hardening", "kinematic") if key in LAWS[name]}
        keys |= {key: LAWS[name][key] / h for key in ("saturation_rate", "recall") if key in LAWS[name]}
        if "table" in LAWS[name]:
            keys["table"] = h * np.array(TABLE)
        parameters = ir.J2Parameters(E, NU, **keys)
        small, finite = ir.J2Point(parameters, 30), ir.J2Point(parameters, 30, strain)
        for e in path:
            one, two = small.evaluate(h * e), finite.evaluate(EYE + h * e)
            small.commit(one)
            finite.commit(two)
        errors.append(np.abs(two.stress - one.stress).max() / (h * Y0))
    assert errors[-1] < 0.02 and np.allclose(np.log2(np.array(errors[:-1]) / errors[1:]), 1, atol=0.25)


def box_9_1(parameters, be, a, f, keep_trace=False):
    """Simo & Hughes Box 9.1 with the relative deformation gradient f, by bisection: dev tau, be_bar with determinant 1
    (or the trace of the trial, as in the box), a."""
    f_bar = f / np.cbrt(np.linalg.det(f))
    trial = f_bar @ be @ f_bar.T
    s = G * dev(trial)
    mu_bar = G * np.trace(trial) / 3

    def excess(gamma):
        return norm(s) - 2 * mu_bar * gamma - np.sqrt(2 / 3) * parameters.yield_stress(a + np.sqrt(2 / 3) * gamma)

    if excess(0.0) <= 0:
        return s, trial, a
    low, high = 0.0, norm(s) / (2 * mu_bar)
    for _ in range(200):
        middle = (low + high) / 2
        low, high = (middle, high) if excess(middle) > 0 else (low, middle)
    s = s - 2 * mu_bar * low * s / norm(s)
    third = np.trace(trial) / 3
    if not keep_trace:
        c = norm(s / G) ** 2 / 2
        third = np.roots([1, 0, -c, np.linalg.det(s / G) - 1]).real.max()
    return s, s / G + third * EYE, a + np.sqrt(2 / 3) * low


@pytest.mark.parametrize("name", ISOTROPIC)
def test_simo_against_the_box(name, rng):
    """Against the box with relative deformation gradients and bisection, at large strains and rotations."""
    parameters = law(name)
    point = ir.J2Point(parameters, 1, "simo")
    be, a, F = EYE, 0.0, EYE
    size = 0.003 if name == "softening" else 0.1
    for _ in range(30):
        f = random_rotations(rng) @ (EYE + size * rng.uniform(-1, 1, (3, 3)))
        s, be, a = box_9_1(parameters, be, a, f)
        F = f @ F
        J = np.linalg.det(F)
        answer = point.evaluate(F)
        point.commit(answer)
        tau = K / 2 * (J * J - 1) * EYE + s
        assert np.abs(answer.stress[0] @ F.T - tau).max() < 1e-9 * max(Y0, np.abs(tau).max())  # strains of several 1
        assert np.isclose(point.history.plastic_strain[0], a, rtol=1e-9, atol=1e-13)
        assert np.abs(F @ point.history.plastic_strain_tensor[0] @ F.T - J ** (2 / 3) * be).max() < 1e-8 * norm(be)
    assert a > 0.05


def test_simo_is_neo_hookean_below_yield(rng):
    """tau = dU/dJ J I + mu dev(J^(-2/3) F F^T) is the derivative of the energy that is reported."""
    point = ir.J2Point(ir.J2Parameters(E, NU, 1e9), 1, "simo")
    F = EYE + 0.2 * rng.uniform(-1, 1, (3, 3))
    dF = rng.uniform(-1, 1, (3, 3))
    answer = point.evaluate(F)
    J = np.linalg.det(F)
    isochoric = G / 2 * (np.trace(F @ F.T) * J ** (-2 / 3) - 3)
    assert np.isclose(answer.energy[0], K / 2 * ((J * J - 1) / 2 - np.log(J)) + isochoric, rtol=1e-12)
    h = 1e-5
    slope = (point.evaluate(F + h * dF).energy[0] - point.evaluate(F - h * dF).energy[0]) / (2 * h)
    assert np.isclose(slope, inner(answer.stress[0], dF), rtol=1e-7)


def test_elastic_energy_of_simo():
    """It stays that of s, q^2/(6 G), with a determinant of 1; with the trace of the trial, as in the box, it would grow
    by all of the work of s, and by mu/2 times the square of every step's shear besides."""
    point = ir.J2Point(law("perfect"), 1, "simo")
    be, a, steps = EYE, 0.0, 500
    for shear in 0.5 * np.arange(1, steps + 1) / steps:
        F = EYE.copy()
        F[0, 1] = shear
        answer = point.evaluate(F)
        point.commit(answer)
        step = EYE.copy()
        step[0, 1] = 0.5 / steps
        _, be, a = box_9_1(law("perfect"), be, a, step, keep_trace=True)
    assert np.isclose(answer.energy[0], Y0**2 / (6 * G), rtol=2e-3)  # a correction of the elastic strain
    assert np.isclose(np.linalg.det(point.history.plastic_strain_tensor[0]), 1, rtol=1e-12)
    work = Y0 / np.sqrt(3) * 0.5
    assert np.isclose(point.history.work[0], work, rtol=5e-3)
    trace = G / 2 * (np.trace(be) - 3)
    assert np.isclose(trace, work + G / 2 * (0.5 / steps) ** 2 * steps, rtol=5e-3)


# -- plane stress ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", LAWS)
def test_plane_stress(name, rng):
    """No stress across the plane; strain_33 that is given is not read; the condensed tangent is the derivative."""
    n = 60
    point = ir.J2Point(law(name), n, hypothesis="plane_stress")
    solid = ir.J2Point(law(name), n)
    size = Y0 / E if name == "softening" else 2 * Y0 / E
    for strain in random_strains(rng, 6, n, size):
        strain[:, 2, :2] = strain[:, :2, 2] = 0
        solid.history = last = point.history
        answer = point.evaluate(strain)
        assert np.abs(answer.stress[:, 2]).max() < 1e-10 * Y0
        other = strain.copy()
        other[:, 2, 2] = 7.0
        assert np.array_equal(point.evaluate(other).stress, answer.stress)
        # The solid law at the strain_33 that Hooke's law gives for the found stress and plastic strain.
        full, p = strain.copy(), answer.history.plastic_strain_tensor
        full[:, 2, 2] = p[:, 2, 2] - NU / E * (answer.stress[:, 0, 0] + answer.stress[:, 1, 1])
        assert np.abs(solid.evaluate(full).stress - answer.stress).max() < 1e-9 * Y0
        point.commit(answer)
    point.history = last
    direction = rng.standard_normal((n, 3, 3)) * Y0 / E
    direction = (direction + direction.swapaxes(-1, -2)) / 2
    direction[:, 2] = direction[:, :, 2] = 0

    def evaluate(x):
        return point.evaluate(x).stress

    yields = answer.history.plastic_strain > last.plastic_strain
    found = orders(evaluate, answer.tangent, strain, direction, [1e-2, 5e-3, 2.5e-3])
    assert yields.sum() > 15 and np.allclose(np.median(found[:, yields], axis=1), 2, atol=0.1)


def test_plane_stress_yields_on_the_ellipse():
    """Equal biaxial tension yields at Y: the plane section of von Mises' cylinder."""
    point = ir.J2Point(law("perfect"), hypothesis="plane_stress")
    for strain in (0.5, 2.0, 9.0):
        answer = point.evaluate(np.diag([1.0, 1.0, 0]) * strain * Y0 * (1 - NU) / E)
        point.commit(answer)
        expected = min(strain, 1.0) * Y0
        assert np.abs(answer.stress[0] - expected * np.diag([1.0, 1, 0])).max() < 1e-11 * Y0
        assert np.isclose(mises(answer.stress[0]), expected, rtol=1e-11)


# -- refusals ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "keys, message",
    [
        (dict(yield_stress=0.0), "yield stress is 0"),
        (dict(yield_stress=-1.0), "yield stress is -1"),
        (dict(yield_stress=np.nan), "yield stress is nan"),
        (dict(), "either yield_stress or table"),
        (dict(yield_stress=Y0, table=TABLE), "either yield_stress or table"),
        (dict(yield_stress=Y0, hardening=-3 * G), "above -3 G"),
        (dict(yield_stress=Y0, hardening=np.inf), "hardening modulus"),
        (dict(yield_stress=Y0, saturation_stress=300.0), "go together"),
        (dict(yield_stress=Y0, saturation_stress=-1.0, saturation_rate=1.0), "saturation stress"),
        (dict(yield_stress=Y0, saturation_stress=100.0, saturation_rate=1e5), "above -3 G"),
        (dict(yield_stress=Y0, saturation_stress=300.0, saturation_rate=-1.0), "saturation rate"),
        (dict(yield_stress=Y0, recall=10.0), "recall"),
        (dict(yield_stress=Y0, kinematic=-10.0), "kinematic"),
        (dict(table=[[0.0, 0.1, 0.1], [1.0, 2.0, 3.0]]), "do not increase in row 2"),
        (dict(table=[[0.1, 0.2], [1.0, 2.0]]), "begin at 0"),
        (dict(table=[[0.0, 0.2], [1.0, 0.0]]), "positive"),
        (dict(table=[[0.0, 0.2, 0.3]]), "shape"),
        (dict(table=TABLE, hardening=1.0), "leave out"),
        (dict(yield_stress=Y0, nu=0.5), "incompressible"),
        (dict(yield_stress=Y0, E=-1.0), "Young"),
    ],
)
def test_bad_parameters(keys, message):
    with pytest.raises(ValueError, match=message):
        ir.J2Parameters(**({"E": E, "nu": NU} | keys))


def test_bad_calls():
    parameters = law("prager")
    with pytest.raises(ValueError, match="unknown strain"):
        ir.J2Point(parameters, strain="green")
    for strain in FINITE:
        with pytest.raises(ValueError, match="13 and 23"):
            sheet = ir.J2Point(law("linear"), strain=strain, hypothesis="plane_stress")
            sheet.evaluate(EYE + 1e-3)
        with pytest.raises(ValueError, match="inside out"):
            ir.J2Point(law("linear"), strain=strain).evaluate(-EYE)
    with pytest.raises(ValueError, match="13 and 23"):
        ir.J2Point(parameters, hypothesis="plane_stress").evaluate(1e-3 * np.ones((3, 3)))
    with pytest.raises(ValueError, match="finite strains"):
        ir.J2Point(parameters).evaluate(np.full((3, 3), np.nan))
    soft = ir.J2Parameters(E, NU, Y0, hardening=-1e4)
    with pytest.raises(ValueError, match="softened to nothing"):
        ir.J2Point(soft).evaluate(PLASTIC * 0.1)
