# SPDX-License-Identifier: MIT
"""Level operator: assembled matrices and vectors, healthy and broken on either side."""

from dolfinx_impact.own_forms import distorted_block
import impact_reference
import numpy as np
import pytest
import ufl
from fault_injection import assert_caught, assert_healthy, one_entry, scaled

from dolfinx_impact.assembly import lumped_mass
from dolfinx_impact.forms import elasticity, foundation, loads, materials
from impact_verify import matched_body, operator
from impact_verify.report import Report


def linear(cell="triangle", degree=1, hypothesis="plane_strain", geometry_degree=1):
    report = Report()
    operator._linear(report, "block", distorted_block.block(cell, 2, geometry_degree), hypothesis, degree)
    return report


def finite(law="neo_hookean"):
    report = Report()
    operator._finite(report, "block", distorted_block.block("triangle", 2), "plane_strain", 1, law)
    return report


@pytest.mark.parametrize(
    "cell, degree, hypothesis, geometry_degree",
    [
        ("triangle", 1, "plane_strain", 1),
        ("triangle", 2, "plane_strain", 2),
        ("hexahedron", 1, "3d", 1),
        ("tetrahedron", 2, "3d", 1),
    ],
)
def test_healthy_linear_operators_pass(cell, degree, hypothesis, geometry_degree):
    report = linear(cell, degree, hypothesis, geometry_degree)
    assert_healthy(report, "operator", 6)
    assert {r.form for r in report.rows} == {
        "linear_elastic.tangent", "linear_elastic.force", "linear_elastic.energy", "mass", "lumped_mass", "body_force",
    }  # fmt: skip


@pytest.mark.parametrize("law", ["neo_hookean", "st_venant_kirchhoff"])
def test_healthy_finite_strain_operators_pass(law):
    assert_healthy(finite(law), "operator", 2)


def founded():
    report = Report()
    operator._foundation(report, "block", distorted_block.block("triangle", 2, 2), "plane_strain", 2)
    return report


def test_healthy_springs_pass():
    report = founded()
    assert_healthy(report, "operator", 2)
    assert {r.form for r in report.rows} == {"normal_foundation_tangent", "foundation_tangent"}


def test_one_spring_of_the_hand_written_side(monkeypatch):
    right = impact_reference.Model.foundation

    def wrong(self, facets, k):
        return right(self, facets, np.asarray(k) * (1 + 1e-9 * (np.ndim(k) == 1)))

    monkeypatch.setattr(impact_reference.Model, "foundation", wrong)
    assert_caught(founded(), "operator", "foundation_tangent", "springs under block")


def test_springs_along_the_wrong_normal(monkeypatch, own_cache):
    """Along the radius from the block's corner in place of the normal."""

    def wrong(k, u, v, hypothesis="3d", ds=ufl.ds):
        if k.ufl_shape != ():
            return right(k, u, v, hypothesis, ds)
        x = ufl.SpatialCoordinate(ufl.domain.extract_unique_domain(v))
        n = x / ufl.sqrt(ufl.dot(x, x))
        return k * ufl.dot(u, n) * ufl.dot(v, n) * ds

    right = foundation.foundation
    monkeypatch.setattr(foundation, "foundation", wrong)
    assert_caught(founded(), "operator", "normal_foundation_tangent", "springs under block")


@pytest.mark.slow
def test_every_mesh_of_the_level_passes():
    report = Report()
    operator.run(report)
    assert_healthy(report, "operator")
    assert {r.cell for r in report.rows} == {"triangle", "quadrilateral", "tetrahedron", "hexahedron"}


def _method(monkeypatch, name, change):
    monkeypatch.setattr(impact_reference.Model, name, change(getattr(impact_reference.Model, name)))


def _csr_entry(index, factor):
    def change(method):
        def wrong(self, *args, **kwargs):
            matrix = method(self, *args, **kwargs)
            matrix.data[index] *= factor
            return matrix

        return wrong

    return change


def test_one_entry_of_the_hand_written_stiffness(monkeypatch):
    _method(monkeypatch, "stiffness", _csr_entry(17, 1 + 1e-8))
    found = assert_caught(linear(), "operator", "linear_elastic.tangent", "K on block")
    assert found.note.count("node at [") == 2


def test_one_entry_of_the_hand_written_force_is_placed(monkeypatch):
    _method(monkeypatch, "internal_force", lambda f: one_entry(f, 11, 1 - 1e-6))
    found = assert_caught(linear(), "operator", "linear_elastic.force")
    body = matched_body.Body(
        distorted_block.block("triangle", 2), 1, operator.LAWS["linear_elastic"](1.0, 0.3, 1.0, "plane_strain")
    )
    place = np.round(body.model.field_points[5], 4).tolist()  # dof 11: node 5, component 1
    assert f"node at {place} component 1" in found.note


@pytest.mark.parametrize(
    "method, change, form",
    [
        ("energy", lambda f: scaled(f, 1 + 1e-11), "linear_elastic.energy"),
        (
            "mass",
            lambda f: lambda self, lumped=False: f(self, lumped=lumped) * (1 - 1e-10) if lumped else f(self),
            "lumped_mass",
        ),
        ("body_force", lambda f: scaled(f, -1), "body_force"),
    ],
    ids=["energy", "a lumped mass that loses 1e-10", "sign of a load"],
)
def test_a_broken_hand_written_operator(method, change, form, monkeypatch):
    _method(monkeypatch, method, change)
    assert_caught(linear(), "operator", form)


def test_a_broken_hand_written_tangent(monkeypatch):
    _method(monkeypatch, "tangent", _csr_entry(3, 1 + 1e-9))
    assert_caught(finite(), "operator", "neo_hookean.tangent", "K(u)")


def test_our_lumped_mass_loses_mass(monkeypatch):
    right = lumped_mass.lumped_mass

    def wrong(*args, **kwargs):
        diagonal = right(*args, **kwargs)
        diagonal.array[4] -= 1e-10 * diagonal.array.sum() / 2  # of the body's mass
        return diagonal

    monkeypatch.setattr(lumped_mass, "lumped_mass", wrong)
    assert_caught(linear(), "operator", "lumped_mass", "diagonal on block")


def test_a_broken_form_under_the_matrix_free_operator(monkeypatch, own_cache):
    right = elasticity.internal_force
    monkeypatch.setattr(elasticity, "internal_force", lambda *a: (1 + 1e-9) * right(*a))
    assert_caught(linear(), "operator", "linear_elastic.force", "f(u) on block")


def test_a_broken_load_form(monkeypatch, own_cache):
    right = loads.body_force
    monkeypatch.setattr(loads, "body_force", lambda *a: -right(*a))
    assert_caught(linear(), "operator", "body_force")


def test_a_broken_lame_constant_shows_in_stiffness_force_and_energy(monkeypatch, own_cache):
    lame = materials.lame
    monkeypatch.setattr(materials, "lame", lambda E, nu: (lame(E, nu)[0], lame(E, nu)[1] * (1 + 1e-9)))
    report = linear()
    kinds = ("tangent", "force", "energy")
    assert {r.form for r in report.failures()} == {f"linear_elastic.{k}" for k in kinds}


def test_a_broken_node_map_is_caught(monkeypatch):
    right = matched_body.match_nodes
    monkeypatch.setattr(matched_body, "match_nodes", lambda *a: right(*a)[[1, 0, *range(2, 9)]])
    report = linear()
    assert not report.passed
    assert {"linear_elastic.tangent", "linear_elastic.force", "mass", "lumped_mass"} <= {
        r.form for r in report.failures()
    }


@pytest.mark.parametrize("fault", ["moved", "twice", "missing"])
def test_nodes_that_do_not_match_are_an_error(fault):
    x = np.random.default_rng(1).random((6, 2))
    y = x[::-1].copy()
    if fault == "moved":
        y[2] += 1e-6
    elif fault == "twice":
        x[2] = x[1]
    else:
        y = y[:-1]
    with pytest.raises(RuntimeError, match="do not match"):
        matched_body.match_nodes(x, y, 1.0)
