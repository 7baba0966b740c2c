# SPDX-License-Identifier: MIT
"""How a Newton iteration settles contact: ways to one result, kept factors, active sets that go to and fro."""

from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest
from contact_checks import pressed
from mpi4py import MPI
from petsc4py import PETSc

import dolfinx_impact as di
from impact_studies.bench import contact_rows as bench_contact
from dolfinx_impact import _cpp
from dolfinx_impact.statics import linear_solver
from dolfinx_impact.contact.mortar.lagrange import LagrangeContact

# Newton's tolerance, 1e-12 of the largest force, over the part of the forces that one node carries, and over how much
# less a node that slips resists.
SAME, RTOL = 1e-8, 1e-12


def assert_same(one, other):
    for a, b in zip(one[0][:4], other[0][:4]):  # gaps are zero or, beside the contact, follow from the places
        np.testing.assert_allclose(a, b, rtol=0, atol=SAME * np.abs(b).max())
    np.testing.assert_allclose(one[1], other[1], rtol=0, atol=SAME * np.abs(other[1]).max())


@pytest.mark.parametrize("friction", (0.0, 0.3))
@pytest.mark.parametrize("dim", (2, 3))
def test_a_saddle_point_has_the_solution_of_the_condensed_system(dim, friction, monkeypatch, contacts_in_python):
    """The same dual multipliers, condensed and as unknowns, with nodes that stick, slip and open."""
    condensed = pressed(MPI.COMM_SELF, dim, di.Lagrange, friction, rtol=RTOL)
    taken, take = [], LagrangeContact.set_multipliers  # that saddle points alone call
    monkeypatch.setattr(LagrangeContact, "set_multipliers", lambda *args: taken.append(take(*args)))
    kept = {"contact_condense": False}
    assert_same(pressed(MPI.COMM_SELF, dim, di.Lagrange, friction, rtol=RTOL, options=kept), condensed)
    assert taken


@pytest.mark.parametrize("basis", ("standard", "linear"))
@pytest.mark.parametrize("degree", (1, 2))
def test_other_bases_are_near_the_dual_one(basis, degree):
    """Other multipliers, the same bodies: forces to 2 %, on a mesh of some hundred nodes; forces of the two bodies
    opposite; Coulomb's law at the nodes."""
    dual = pressed(MPI.COMM_SELF, 2, di.Lagrange, degree=degree)
    other = pressed(MPI.COMM_SELF, 2, lambda pair: di.Lagrange(pair, basis=basis), degree=degree)
    np.testing.assert_allclose(other[1], dual[1], rtol=0.02)
    assert np.abs(other[1] - dual[1]).max() > 1e-6 * np.abs(dual[1]).max()
    assert np.abs(other[3]).max() < 1e-12 * np.abs(other[1]).max()
    _, pressure, traction, status, gap = other[0]
    # Gaps are closed to 1e-11 of the size of the bodies, 1.7.
    assert np.all(pressure >= 0) and np.all(np.abs(gap[pressure > 0]) < 2e-11) and np.all(gap[status == 0] > -2e-11)
    # t^2 + p^2 = |traction|^2; the law holds to what Newton's method leaves at one node.
    friction = np.sqrt(np.maximum(0.0, np.sum(traction**2, axis=1) - pressure**2))
    assert np.any(status == di.ContactStatus.slip) and np.all(friction <= 0.3 * pressure * (1 + 1e-7))


def test_bases_that_do_not_fit():
    tags = type("Tags", (), {"find": None})()
    plane = di.RigidPlane((0, 0), (0, 1))
    with pytest.raises(ValueError, match="basis is 'cubic': give one of dual, standard, linear"):
        di.Lagrange(di.ContactPair(tags, 1, 2), basis="cubic")
    with pytest.raises(ValueError, match="against a rigid obstacle"):
        di.Lagrange(di.ContactPair(tags, 1, plane), basis="standard")


class Ball:
    """A round body pressed on a flat one in two steps, its contact growing."""

    def __init__(self, cell):
        plane = cell == "quadrilateral"
        model = bench_contact.PressedBodies(cell, 0.12 if plane else 0.3, 3.0 if plane else 12.0)
        self.report = model.problem.solve(steps=2)
        contact = model.problem.contact[0]
        self.answer = [contact.points, contact.pressure, contact.traction, contact.status], contact.force


@pytest.mark.long_rows(where=lambda cell: cell == "hexahedron")
@pytest.mark.parametrize("cell", ("quadrilateral", "hexahedron"))
def test_responses_of_the_bodies_lead_to_the_same_active_set(cell):
    """Settled on the dense problem of the nodes that change, and by linear solutions one after the other."""
    fast = Ball(cell)
    assert any(sum(c[1:]) > 0 for c in fast.report.contact_changes)  # the prediction is not all
    options = PETSc.Options()
    options["impact_static_contact_responses"] = False
    try:
        slow = Ball(cell)
    finally:
        options.delValue("impact_static_contact_responses")
    assert_same(fast.answer, slow.answer)


def test_wrong_responses_are_mended_by_the_next_solution(monkeypatch, contacts_in_python):
    """Columns of the dense problem half as large as they are: other nodes change, the result is the same."""
    right = Ball("quadrilateral")
    respond = LagrangeContact.linearised_response
    monkeypatch.setattr(LagrangeContact, "linearised_response", lambda *args: tuple(0.5 * v for v in respond(*args)))
    wrong = Ball("quadrilateral")
    assert_same(wrong.answer, right.answer)
    assert wrong.report.contact_changes != right.report.contact_changes


def test_factors_are_kept_while_they_serve(monkeypatch):
    """One linear law, few changes: fewer factorisations than linear solutions; and each pays where none is kept."""
    solvers = []
    view = linear_solver.LinearSolver.of

    def watched(solver):
        solvers.append(solver)
        return view(solver)

    monkeypatch.setattr(linear_solver.LinearSolver, "of", watched)
    kept = pressed(MPI.COMM_SELF, 3, di.Lagrange, rtol=RTOL)
    monkeypatch.setattr(linear_solver.LIMITS, "keep_preconditioner", False)
    fresh = pressed(MPI.COMM_SELF, 3, di.Lagrange, rtol=RTOL)
    assert solvers[0].num_set_ups < solvers[-1].num_set_ups  # problems are asked for theirs more than once
    assert_same(kept, fresh)


@pytest.mark.parametrize(
    "contact", (di.Lagrange, lambda pair: di.Penalty(pair, penalty=1e5)), ids=("Lagrange", "Penalty")
)
def test_conjugate_gradients_find_what_factors_find(contact, monkeypatch):
    """Blocks of some hundred unknowns by the solver of large problems: nothing of contact is left out."""
    direct = pressed(MPI.COMM_SELF, 3, contact, rtol=RTOL)
    monkeypatch.setattr(linear_solver.LIMITS, "largest_direct", [10] * 4)
    iterative = pressed(MPI.COMM_SELF, 3, contact, rtol=RTOL)
    assert_same(iterative, direct)
    assert iterative[-1].cut_backs == 0 and max(iterative[-1].iterations) <= max(direct[-1].iterations) + 2


@pytest.mark.parametrize("friction", (0.0, 0.3))
def test_factors_of_another_package(friction):
    """PETSc's own LU tells less of itself than MUMPS does."""
    mumps = pressed(MPI.COMM_SELF, 2, di.Lagrange, friction, rtol=RTOL)
    options = {"pc_type": "lu", "pc_factor_mat_solver_type": "petsc"}
    assert_same(pressed(MPI.COMM_SELF, 2, di.Lagrange, friction, rtol=RTOL, options=options), mumps)


def test_saddle_points_refuse_multigrid():
    with pytest.raises(ValueError, match="needs a direct solver"):
        pressed(MPI.COMM_SELF, 2, partial(di.Lagrange, basis="standard"), options={"pc_type": "gamg"})


def test_a_singular_dense_problem_is_left_to_linear_solutions(monkeypatch, contacts_in_python):
    """Responses that are zero: the dense problem has no solution, the contact has."""
    right = Ball("quadrilateral")
    respond = LagrangeContact.linearised_response
    monkeypatch.setattr(LagrangeContact, "linearised_response", lambda *args: tuple(0.0 * v for v in respond(*args)))
    assert_same(Ball("quadrilateral").answer, right.answer)


class Cycling:
    """A contact of three wrong nodes: changed together they stay wrong, changed one at a time they come right."""

    pair, has_multipliers = SimpleNamespace(name="cycling", friction=0.0), True

    def __init__(self):
        self.right = np.zeros(3, dtype=bool)

    def update_active_set(self, first, last=None):
        wrong = np.flatnonzero(~self.right)
        self.last_change = int(np.max(wrong, initial=-1))
        if last is None and len(wrong) == 1:
            self.right[:] = True
        elif last is not None and last >= 0:
            self.right[last] = True
        return len(wrong)


def test_nodes_that_go_to_and_fro_change_one_at_a_time():
    contact, settling = Cycling(), _cpp.solve.ActiveSetIteration()
    found = [settling.change([_cpp.solve.PythonContact(contact)]) for _ in range(20)]
    # Three times nothing gained, then a node by itself; less than ever before: together again.
    assert found[:6] == [3, 3, 3, 3, 3, 2] and found[-1] == 0
    assert np.all(np.diff(found) <= 0)
