# SPDX-License-Identifier: MIT
"""Levels solution and spectrum: healthy, and broken on either side."""

from dolfinx_impact.own_forms import distorted_block
import impact_reference
import numpy as np
import pytest
import ufl
from fault_injection import assert_caught, assert_healthy, scaled

import dolfinx_impact as di
from dolfinx_impact.statics import static_problem
from dolfinx_impact.forms import elasticity, materials, quadrature
from impact_verify import matched_body, solution, spectrum
from impact_verify.report import Report

FORM = "linear_elastic.tangent"


def block():
    report = Report()
    solution._block(report, "triangle", "plane_strain", 1)
    return report


def free_body(cell="triangle", degree=2, hypothesis="plane_stress"):
    report = Report()
    spectrum._free_body(report, cell, degree, hypothesis, 4)
    return report


def test_healthy_solutions_pass():
    report = Report()
    solution.wheel(report)
    solution.block(report)
    assert_healthy(report, "solution", 22)


@pytest.mark.slow
def test_healthy_rubber_passes():
    report = Report()
    solution.rubber(report)
    assert_healthy(report, "solution", 6)


def founded(cell="triangle", degree=2):
    report = Report()
    solution._founded(report, cell, degree)
    return report


@pytest.mark.parametrize("cell, degree", (("triangle", 2), ("hexahedron", 1)))
def test_a_block_on_springs_passes(cell, degree):
    assert_healthy(founded(cell, degree), "solution", 2)


def test_springs_off_by_one_millionth(monkeypatch):
    """On the hand-written side; the force, which the load prescribes, does not tell."""
    right = impact_reference.Model.add_foundation
    monkeypatch.setattr(
        impact_reference.Model, "add_foundation", lambda self, f, k, c=0.0: right(self, f, np.multiply(k, 1 + 1e-6), c)
    )
    assert_caught(founded(), "solution", "foundation", "u of the block on springs")


def test_a_force_of_springs_of_the_wrong_sign(monkeypatch):
    monkeypatch.setattr(di.Foundation, "force", scaled(di.Foundation.force, -1))
    assert_caught(founded(), "solution", "foundation", "force of the springs")


def test_a_load_off_by_one_millionth(monkeypatch):
    right = impact_reference.Model.traction
    monkeypatch.setattr(impact_reference.Model, "traction", scaled(right, 1 + 1e-6))
    found = assert_caught(block(), "solution", FORM, "u of the block")
    assert "node at [" in found.note and 1e-8 < found.difference < 1e-5


def test_a_reaction_of_the_wrong_sign(monkeypatch):
    right = static_problem.StaticProblem.reactions

    def wrong(self):
        r = right(self)
        r.x.array[:] *= -1
        return r

    monkeypatch.setattr(static_problem.StaticProblem, "reactions", wrong)
    found = assert_caught(block(), "solution", FORM, "reactions of the block")
    assert found.difference == pytest.approx(2.0)


def test_a_material_of_the_ufl_side_off_by_one_millionth(monkeypatch, own_cache):
    lame = materials.lame
    monkeypatch.setattr(materials, "lame", lambda E, nu: (lame(E, nu)[0] * (1 + 1e-6), lame(E, nu)[1]))
    assert_caught(block(), "solution", FORM, "u of the block")


# Spectrum.

FREE = [("triangle", 2, "plane_stress"), ("tetrahedron", 2, "3d"), ("quadrilateral", 2, "axisymmetric")]


@pytest.mark.parametrize("case", FREE, ids=lambda c: c[0])
def test_a_healthy_spectrum_passes(case):
    report = free_body(*case)
    assert_healthy(report, "spectrum", 3)
    assert [r.form for r in report.rows] == ["rigid_modes", "rigid_modes", "frequencies"]


def _theirs(monkeypatch, change):
    right = impact_reference.Model.frequencies

    def wrong(self, n, *args, **kwargs):
        w, modes = right(self, n, *args, **kwargs)
        return change(np.array(w)), modes

    monkeypatch.setattr(impact_reference.Model, "frequencies", wrong)


@pytest.mark.parametrize("mode", [0, 3])
def test_a_frequency_off_by_one_millionth(mode, monkeypatch):
    def change(w):
        w[3 + mode] *= 1 + 1e-6
        return w

    _theirs(monkeypatch, change)
    found = assert_caught(free_body(), "spectrum", "frequencies")
    assert found.note.startswith(f"elastic frequency {mode + 1}: ") and abs(found.difference / 1e-6 - 1) < 1e-3


def test_an_extra_zero_mode_of_the_hand_written_side(monkeypatch):
    _theirs(monkeypatch, lambda w: np.array([0.0, *w[:-1]]))
    report = free_body()
    counts = [r for r in report.failures() if r.form == "rigid_modes"]
    assert [r.name for r in counts] == ["hand-written side: 4 of 3"] and counts[0].note.startswith(
        "lowest frequencies 0, "
    )
    assert any(r.form == "frequencies" for r in report.failures())


def test_a_missing_rigid_mode(monkeypatch):
    def change(w):
        w[2] = 0.1 * w[3]
        return w

    _theirs(monkeypatch, change)
    found = [r.name for r in free_body().failures()]
    assert found == ["hand-written side: 2 of 3"]


def test_zero_modes_of_an_underintegrated_stiffness(monkeypatch):
    """Triangles of degree 2 with one point have zero-energy modes besides the rigid ones."""
    right = elasticity.tangent

    def coarse(u, du, v, law, dx):
        domain = ufl.domain.extract_unique_domain(v)
        return right(u, du, v, law, ufl.dx(domain=domain, metadata=quadrature.metadata(1)))

    monkeypatch.setattr(elasticity, "tangent", coarse)
    wrong = [r for r in free_body().failures() if r.form == "rigid_modes"]
    assert wrong and wrong[0].name.startswith("UFL side: ") and wrong[0].difference >= 1


@pytest.mark.parametrize("cell, n", [("quadrilateral", 2), ("quadrilateral", 3), ("triangle", 3), ("hexahedron", 2)])
def test_hand_written_frequencies_of_free_bodies_against_a_dense_solver(cell, n):
    import scipy.linalg

    from dolfinx_impact import LinearElastic

    hypothesis, rigid = ("3d", 6) if cell == "hexahedron" else ("plane_strain", 3)
    body = matched_body.Body(distorted_block.block(cell, n), 1, LinearElastic(2.0, 0.3, 1.5, hypothesis))
    K, M = body.model.stiffness().toarray(), body.model.mass().toarray()
    for count in (rigid + 1, rigid + 3, rigid + 4):
        exact = np.sqrt(np.maximum(scipy.linalg.eigvalsh(K, M), 0))[rigid:count]
        found = body.model.frequencies(count)[0][rigid:]
        np.testing.assert_allclose(found, exact, rtol=1e-8)  # eigenvalues to 1e-11 of the largest, 1e3 times the first
