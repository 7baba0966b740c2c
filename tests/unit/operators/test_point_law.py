# SPDX-License-Identifier: MIT
"""Internal variables in kernels: force and new history of elastic-plastic laws against return mapping in NumPy, for all
widths; an evaluation changes no committed value."""

import numpy as np
import operator_checks
import point_law_models as models
import pytest
import ufl
from dolfinx import fem
from mpi4py import MPI

from dolfinx_impact.assembly.operators import Energy, InternalForce
from dolfinx_impact.forms.point_law import PointLaw

# Forces: element entries of both sides differ by some round-offs of the largest stress. History: the equivalent plastic
# strain is a difference of stresses divided by 3 G, so that its error is round-off of the trial stress, which in these
# tests is at most some ten times the yield stress. Bisection ends at round-off, too.
TOLERANCE = 1e-12
CELLS = ("hexahedron", "tetrahedron", "quadrilateral")


def _body(cell):
    domain = operator_checks.body(cell, comm=MPI.COMM_SELF)
    return operator_checks.displacement(domain, 1)


def _move(u, rng, size):
    """A random displacement, small at the first nodes: strains up to some times that at first yield."""
    u.x.array[:] = size * np.linspace(0.05, 2, u.x.array.size) * rng.standard_normal(u.x.array.size)


def _difference(a, b):
    return np.max(np.abs(a - b)) / np.max(np.abs(b))


@pytest.mark.parametrize("width", (1, 4, 8))
@pytest.mark.parametrize("cell", CELLS)
@pytest.mark.parametrize("law", models.HARDENING)
def test_force_and_history_equal_return_mapping(law, cell, width, rng):
    u = _body(cell)
    model, reference = law(u), models.Reference(u, models.HARDENING[law])
    force = InternalForce(model.form, width=width, law=model.law)
    history = force.history
    yielding = []
    for size in (4e-4, 2e-3, 6e-4, 4e-3):
        _move(u, rng, size)
        expected, plastic, p = reference.evaluate()
        assert _difference(force.apply().array, expected) < TOLERANCE
        assert np.max(np.abs(history.values("plastic_strain", trial=True) - plastic)) < TOLERANCE
        assert np.max(np.abs(history.values("p", trial=True) - p)) < TOLERANCE
        assert abs(force.sum("elastic") / reference.elastic_energy() - 1) < TOLERANCE
        yielding.append(np.mean(p.reshape(-1) > reference.p))
        history.commit()
        reference.commit()
        assert np.array_equal(history.values("p"), history.values("p", trial=True))
    assert force.fault() == ""
    assert any(0 < part < 1 for part in yielding)  # some points yield, others do not


def test_an_evaluation_changes_no_committed_value(rng):
    u = _body("hexahedron")
    model = models.voce(u)
    force = InternalForce(model.form, law=model.law)
    _move(u, rng, 2e-3)
    first = force.apply().array.copy()
    before = {name: force.history.values(name) for name in force.history.names}
    assert all(np.all(values == 0) for values in before.values())
    _move(u, rng, 5e-3)
    force.apply()
    assert all(np.array_equal(force.history.values(n), values) for n, values in before.items())
    force.history.revert()
    assert np.all(force.history.values("p", trial=True) == 0)
    force.history.commit()  # nothing was evaluated since: nothing changes
    assert np.all(force.history.values("p") == 0)
    assert np.any(first != 0)


def test_committed_values_are_read_and_can_be_set(rng):
    """A second operator with the values of the first continues with the same bits."""
    u = _body("hexahedron")
    model = models.closed_form(u)
    one, other = (InternalForce(model.form, law=model.law) for _ in range(2))
    _move(u, rng, 2e-3)
    one.apply()
    one.history.commit()
    assert one.history.state_names == ["plastic_strain", "p"]
    for name in one.history.state_names:
        other.history.set_values(name, one.history.values(name))
    _move(u, rng, 3e-3)
    assert np.array_equal(one.apply().array, other.apply().array)
    for name in one.history.state_names:
        assert np.array_equal(one.history.values(name, True), other.history.values(name, True))
    assert not np.array_equal(one.apply().array, InternalForce(model.form, law=model.law).apply().array)


def test_in_place_equals_commits_and_goes_back_to_its_snapshot(rng):
    u = _body("hexahedron")
    model = models.voce(u)
    steps, in_place = (InternalForce(model.form, law=model.law) for _ in range(2))
    in_place._cpp_object.set_in_place(True)
    states = [np.array(u.x.array) for _ in range(4)]
    for state in states:
        state[:] = 2e-3 * rng.standard_normal(state.size)

    def run(force, some):
        for state in some:
            u.x.array[:] = state
            b = force.apply().array.copy()
            force.history.commit()
        return b, force.history.values("p"), force.history.values("plastic_strain")

    run(steps, states[:2])
    run(in_place, states[:2])
    in_place.history.store_snapshot()
    expected = run(steps, states[2:])
    for _ in range(2):
        assert all(np.array_equal(a, b) for a, b in zip(run(in_place, states[2:]), expected))
        in_place.history.restore_snapshot()
    with pytest.raises(RuntimeError, match="in place only"):
        steps.history.store_snapshot()


def test_an_energy_reads_the_history_of_a_force(rng):
    """It solves the same local equations from the same committed values, and changes none of the force's."""
    u = _body("hexahedron")
    model = models.voce(u)
    force = InternalForce(model.form, law=model.law)
    energy = Energy(
        model.law.sums["elastic"] * models.measure(u.function_space.mesh), law=model.law, history=force.history
    )
    for _ in range(2):
        _move(u, rng, 3e-3)
        force.apply()
        trial = force.history.values("p", trial=True)
        assert abs(energy.value() / force.sum("elastic") - 1) < TOLERANCE
        assert np.array_equal(force.history.values("p", trial=True), trial)
        force.history.commit()


def _roots(rng):
    """x * x = p at every point: the number of Newton steps depends on p, and below zero there is no solution."""
    domain = operator_checks.body("hexahedron", comm=MPI.COMM_SELF)
    _, p, Q = models.symbols(domain)
    x = ufl.Coefficient(Q)
    V = fem.functionspace(domain, ("Lagrange", 1))
    form = x * ufl.TestFunction(V) * models.measure(domain)
    law = PointLaw({"p": p, "root": x}, {"p": p}, x, x * x - p, 1.0 + 0 * p, abs(p))
    force = InternalForce(form, law=law)
    return force, 10.0 ** rng.uniform(-6, 6, force.history.values("p").shape)


def test_lanes_do_not_depend_on_each_other(rng):
    """Points that converge after different numbers of steps have the bits that they have in the company of equals."""
    force, p = _roots(rng)
    force.history.set_values("p", p)
    force.apply()
    roots = force.history.values("root")
    assert force.fault() == ""
    # Quadratic convergence, and one correction beyond it: round-off of x * x is left.
    assert np.max(np.abs(roots / np.sqrt(p) - 1)) < 1e-15
    for cell in (0, 5, 11):
        force.history.set_values("p", np.broadcast_to(p[cell], p.shape))
        force.apply()
        assert np.array_equal(force.history.values("root"), np.broadcast_to(roots[cell], p.shape))


def test_a_point_without_solution_is_reported(rng):
    force, p = _roots(rng)
    force.history.set_values("p", p)
    force.apply()
    good = force.history.values("root")
    p[7, 3] = p[9, 1] = -4.0
    force.history.set_values("p", p)
    force.apply()
    count, cell, point, residual, unknowns = force._cpp_object.failures()
    assert (count, cell, point) == (2, 7, 3)
    # The minimum of |x * x + 4| is at zero, where the line search ends up: residual 4 of the scale 4.
    assert 1.0 <= residual < 1.5 and len(unknowns) == 1
    assert "at 2 points" in force.fault() and "point 3 of cell 7" in force.fault()
    others = np.ones(p.shape, dtype=bool)
    others[7, 3] = others[9, 1] = False
    assert np.array_equal(force.history.values("root")[others], good[others])
    force.history.set_values("p", np.abs(p))
    force.apply()
    assert force.fault() == ""
