# SPDX-License-Identifier: MIT
"""Level order: rates of convergence, of both sides and both norms, each broken in turn."""

import impact_reference
import numpy as np
import pytest
from fault_injection import assert_healthy

from impact_verify import order
from impact_verify.report import Report

CASES = (("triangle", 1, "plane_strain", (4, 8, 16, 32)),)
FORM = "linear_elastic.tangent"


def run(folder=None, cases=CASES):
    report = Report()
    order.run(report, folder, False, cases)
    return report


def failed_sides(report):
    assert not report.passed
    assert {(r.level, r.form, r.cell, r.degree) for r in report.failures()} == {("order", FORM, "triangle", 1)}
    assert all(r.note.startswith("rates [") for r in report.failures())
    return {r.name.split(" rate ")[0] for r in report.failures()}


def test_healthy_rates_pass_and_are_drawn(tmp_path):
    report = run(tmp_path, (CASES[0], ("quadrilateral", 2, "axisymmetric", (4, 8, 16, 32))))
    assert_healthy(report, "order", 8)
    ((title, path),) = report.figures
    assert path.parent == tmp_path and path.read_bytes().startswith(b"\x89PNG")


@pytest.mark.slow
def test_every_case_of_the_level_passes():
    assert_healthy(run(cases=order.CASES), "order", 4 * len(order.CASES))


def test_a_wrong_source_stalls_both_sides(monkeypatch):
    right = order._source
    monkeypatch.setattr(order, "_source", lambda *a: 1.5 * right(*a))
    assert failed_sides(run()) == {"UFL: L2", "UFL: H1", "hand-written: L2", "hand-written: H1"}


def test_a_wrong_source_of_the_ufl_side_alone(monkeypatch):
    right = order._Source.form
    monkeypatch.setattr(order._Source, "form", lambda self, *a: 1.1 * right(self, *a))
    assert "UFL: L2" in failed_sides(run()) <= {"UFL: L2", "UFL: H1"}


def test_a_hand_written_stiffness_that_is_a_little_off(monkeypatch):
    right = impact_reference.Model.stiffness

    def solve(self, fixed, values, load):
        from scipy.sparse import csr_matrix
        from scipy.sparse.linalg import spsolve

        K = right(self)
        K = csr_matrix((K.data, K.indices, K.indptr), K.shape) * 1.1
        u = np.zeros(self.num_dofs)
        u[fixed] = values
        free = np.setdiff1d(np.arange(self.num_dofs), fixed)
        u[free] = spsolve(K[free][:, free].tocsc(), (load - K @ u)[free])
        return impact_reference.StaticSolution(u, u, [], [])

    monkeypatch.setattr(impact_reference.Model, "solve_static", solve)
    assert "hand-written: L2" in failed_sides(run()) <= {"hand-written: L2", "hand-written: H1"}


@pytest.mark.parametrize("column, name", enumerate(["UFL: L2", "UFL: H1", "hand-written: L2", "hand-written: H1"]))
@pytest.mark.parametrize("loss", [0.2, 1.0, np.nan])
def test_a_rate_below_theory_is_caught(column, name, loss, monkeypatch):
    def errors(cell, degree, hypothesis, n):
        rates = np.array([2.0, 1.0, 2.0, 1.0])
        rates[column] -= loss
        return [*(float(n) ** -rates)]

    monkeypatch.setattr(order, "_errors", errors)
    assert failed_sides(run()) == {name}


def test_a_rate_that_drops_on_the_last_mesh_only(monkeypatch):
    """Round-off or a wrong term shows on the finest meshes first."""

    def errors(cell, degree, hypothesis, n):
        return [max(n**-2.0, 1 / 16**2 * 0.9), n**-1.0, n**-2.0, n**-1.0]

    monkeypatch.setattr(order, "_errors", errors)
    assert failed_sides(run()) == {"UFL: L2"}
