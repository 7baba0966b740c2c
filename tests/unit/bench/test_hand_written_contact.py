# SPDX-License-Identifier: MIT
"""Contact that is written by hand has the gaps and the forces of penalty contact; other gaps are no row."""

import numpy as np
import pytest
from dolfinx_impact import _cpp
from impact_studies.bench import explicit

Contact = _cpp.bench.HandWrittenContact
pytestmark = pytest.mark.skipif(not Contact.available(), reason="the loop is for AVX2")


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_a_row_of_the_benchmark(friction):
    model = explicit.Blocks(6, 4, explicit.Penalty, friction)
    explicit.contact_seconds(model.problem, 10)
    assert np.mean(model.problem.contact[0].status > 0) > 0.5
    row = explicit.hand_written_contact_row(model, "penalty", friction, 100.0, rounds=2)
    assert row["value"] == 100.0 and row["baseline"] > 0.0


def test_other_gaps_are_no_row(monkeypatch):
    class Deeper:
        available = staticmethod(Contact.available)

        def __init__(self, *args):
            self.by_hand = Contact(*args)

        def evaluate(self, *args):
            return self.by_hand.evaluate(*args)

        def gap(self):
            return self.by_hand.gap() - 0.1

    class Bench:
        HandWrittenContact = Deeper

    class Module:
        bench = Bench

    model = explicit.Blocks(4, 1, explicit.Penalty, 0.0)
    explicit.contact_seconds(model.problem, 10)
    monkeypatch.setattr(explicit, "_cpp", Module)
    with pytest.raises(RuntimeError, match="gaps of contact differ"):
        explicit.hand_written_contact_row(model, "penalty", 0.0, 100.0, rounds=1)


def test_open_contact_is_no_row():
    model = explicit.Blocks(4, 1, explicit.Penalty, 0.0)
    with pytest.raises(RuntimeError, match="no node touches"):
        explicit.hand_written_contact_row(model, "penalty", 0.0, 100.0, rounds=1)


def one_facet(stiffness=2.0, friction=0.3):
    """Four nodes above a square, which tilts about the first axis."""
    x = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]])
    slaves = np.array([[0.2, 0.3, 0.1], [0.8, 0.3, 0.1], [0.2, 0.9, 0.1], [0.5, 0.5, 0.1]])
    facets = np.tile(np.arange(4, dtype=np.int32), 4)
    all_nodes = np.concatenate([x, slaves])
    return all_nodes, Contact(all_nodes.ravel(), np.arange(4, 8, dtype=np.int32), facets, stiffness, friction)


def test_forces_by_a_closed_form():
    """A rigid motion of the slave presses its nodes in by 0.05 and moves them along the first axis by 0.01."""
    x, contact = one_facet()
    u, du = np.zeros((8, 3)), np.zeros((8, 3))
    u[4:] = (0.01, 0.0, -0.15)
    du[4:] = (0.01, 0.0, -0.15)
    assert contact.evaluate(u.ravel(), du.ravel(), True) > 0.0
    assert np.allclose(contact.gap(), -0.05, rtol=0, atol=1e-15)
    forces = contact.forces().reshape(8, 3)
    # Sticks: 2 x 0.01 is less than 0.3 x 2 x 0.05.
    assert np.allclose(forces[4:], (-0.02, 0.0, 0.1), rtol=0, atol=1e-15)
    assert np.allclose(forces.sum(axis=0), 0.0, atol=1e-15)
    moments = np.cross(x + u, forces)[:, 2]  # about the normal, which the depth does not enter
    assert abs(moments.sum()) < 1e-15
    for _ in range(9):  # slips: no more than 0.3 of the normal force
        contact.evaluate(u.ravel(), du.ravel(), False)
    last = contact.forces().reshape(8, 3)
    contact.evaluate(u.ravel(), du.ravel(), False)
    assert np.allclose(contact.forces().reshape(8, 3)[4:] - last[4:], (-0.03, 0.0, 0.1), rtol=0, atol=1e-14)


def test_bad_input():
    x, contact = one_facet()
    nodes, facets = np.arange(4, dtype=np.int32), np.zeros(16, dtype=np.int32)
    with pytest.raises(ValueError, match="a multiple of four"):
        Contact(x.ravel(), nodes[:3], facets[:12], 1.0, 0.0)
    with pytest.raises(ValueError, match="not among the nodes"):
        Contact(x.ravel(), nodes + 5, facets, 1.0, 0.0)
    with pytest.raises(ValueError, match="three entries per node"):
        contact.evaluate(np.zeros(3), np.zeros(24), False)
