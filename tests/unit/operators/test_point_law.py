# SPDX-License-Identifier: MIT
"""Internal variables in kernels: force and new history of elastic-plastic laws against return mapping in NumPy, for all
widths; an evaluation changes no committed value."""

import numpy as np
import operator_checks
import point_law_models as models
import pytest
from mpi4py import MPI

from dolfinx_impact.assembly.operators import InternalForce

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
@pytest.mark.parametrize("law", (models.closed_form, models.voce))
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
        yielding.append(np.mean(p.reshape(-1) > reference.p))
        history.commit()
        reference.commit()
        assert np.array_equal(history.values("p"), history.values("p", trial=True))
    assert force._cpp_object.failures()[0] == 0
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
