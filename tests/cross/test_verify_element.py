# SPDX-License-Identifier: MIT
"""Level element: the healthy state passes, and every kind of fault on either side is caught."""

import impact_reference
import numpy as np
import pytest
from fault_injection import assert_caught, assert_healthy, element_report, one_entry, scaled

from dolfinx_impact.forms import ale, inertia, loads, materials, registry
from impact_verify import nodes

HEX = ("linear_elastic.tangent", "hexahedron", 1, 1, "3d")
QUAD = ("linear_elastic.force", "quadrilateral", 1, 1, "plane_strain")
TET2 = ("linear_elastic.tangent", "tetrahedron", 2, 1, "3d")


@pytest.mark.parametrize(
    "case",
    [
        HEX,
        QUAD,
        TET2,
        ("linear_elastic.force", "triangle", 1, 1, "axisymmetric"),
        ("neo_hookean.tangent", "quadrilateral", 1, 1, "plane_strain"),
        ("mass", "hexahedron", 2, 1, "3d"),
        ("nodal_mass", "quadrilateral", 2, 1, "plane_strain"),
        ("traction", "tetrahedron", 2, 1, "3d"),
        ("gyroscopic", "triangle", 2, 2, "plane_strain"),
    ],
    ids=lambda c: f"{c[0]}-{c[1]}{c[2]}-{c[4]}",
)
def test_the_healthy_state_passes(case):
    assert_healthy(element_report(case), "element", 1)


# On the UFL side. Kernels are cached by the form's signature: a changed form gets a kernel of its own.


def _slightly_stiffer(monkeypatch):
    lame = materials.lame
    monkeypatch.setattr(materials, "lame", lambda E, nu: (lame(E, nu)[0] * (1 + 1e-9), lame(E, nu)[1]))
    return QUAD


def _sign_of_the_shear(monkeypatch):
    stress = materials.LinearElastic.stress
    monkeypatch.setattr(materials.LinearElastic, "stress", lambda law, u: stress(law, u) - 4 * law.mu * law.strain(u))
    return HEX


def _plane_stress_forgotten(monkeypatch):
    monkeypatch.setattr(materials, "plane_stress_lambda", lambda lmbda, mu: lmbda)
    return ("linear_elastic.tangent", "triangle", 1, 1, "plane_stress")


def _radius_forgotten(monkeypatch):
    from dolfinx_impact.forms import elasticity

    monkeypatch.setattr(elasticity, "weight", lambda mesh, hypothesis: 1)
    return ("linear_elastic.force", "triangle", 1, 1, "axisymmetric")


def _geometric_stiffness_forgotten(monkeypatch):
    def wrong(law, u, du):
        F = materials.ufl.Identity(3) + law.gradient(u)
        dE = materials.ufl.sym(F.T * law.gradient(du))
        return F * (law._lambda * materials.ufl.tr(dE) * materials.ufl.Identity(3) + 2 * law.mu * dE)

    monkeypatch.setattr(materials.StVenantKirchhoff, "stress_derivative", wrong)
    return ("st_venant_kirchhoff.tangent", "triangle", 1, 1, "plane_strain")


def _gyroscopic_sign(monkeypatch):
    gyroscopic = ale.gyroscopic
    monkeypatch.setattr(ale, "gyroscopic", lambda du, v, density, w, dx: -gyroscopic(du, v, density, w, dx))
    return ("gyroscopic", "triangle", 1, 1, "plane_strain")


def _mass_too_small(monkeypatch):
    mass = inertia.mass
    monkeypatch.setattr(inertia, "mass", lambda u, v, rho, h, dx: (1 - 1e-10) * mass(u, v, rho, h, dx))
    return ("mass", "triangle", 1, 1, "plane_strain")


def _traction_sign(monkeypatch):
    traction = loads.traction
    monkeypatch.setattr(loads, "traction", lambda t, v, h, ds: -traction(t, v, h, ds))
    return ("traction", "triangle", 1, 1, "plane_strain")


def _coarse_rule(monkeypatch):
    build = registry.build
    monkeypatch.setattr(registry, "build", lambda *a, **k: build(*a, **{**k, "quadrature_degree": 1}))
    return ("mass", "triangle", 1, 1, "plane_strain")


UFL_FAULTS = [
    _slightly_stiffer, _sign_of_the_shear, _plane_stress_forgotten, _radius_forgotten, _geometric_stiffness_forgotten,
    _gyroscopic_sign, _mass_too_small, _traction_sign, _coarse_rule,
]  # fmt: skip


@pytest.mark.parametrize("fault", UFL_FAULTS, ids=lambda f: f.__name__.strip("_"))
def test_a_broken_form_is_caught(fault, monkeypatch, own_cache):
    case = fault(monkeypatch)
    found = assert_caught(element_report(case), "element", case[0])
    assert (found.cell, found.degree, found.geometry_degree, found.hypothesis) == case[1:]
    assert "node" in found.note and "UFL" in found.note and "hand-written" in found.note


def test_the_size_of_the_difference_is_the_size_of_the_fault(monkeypatch, own_cache):
    case = _mass_too_small(monkeypatch)
    difference = element_report(case).rows[0].difference
    assert abs(difference / 1e-10 - 1) < 1e-3  # the fault, up to round-off of 1e-15 in 1e-10


# On the hand-written side.


@pytest.mark.parametrize(
    "case, function, wrong",
    [
        (HEX, "element_stiffness", lambda f: scaled(f, 1 + 1e-11)),
        (QUAD, "element_internal_force", lambda f: scaled(f, -1)),
        (("mass", "hexahedron", 1, 1, "3d"), "element_mass", lambda f: scaled(f, 1 - 1e-10)),
        (("gyroscopic", "triangle", 2, 2, "plane_strain"), "element_gyroscopic", lambda f: scaled(f, -1)),
        (("row_sum", "hexahedron", 1, 1, "3d"), "element_lumped_mass", lambda f: one_entry(f, 4, 1 - 1e-10)),
        (("traction", "tetrahedron", 2, 1, "3d"), "element_traction", lambda f: scaled(f, -1)),
    ],
    ids=lambda x: x if isinstance(x, str) else x[0] if isinstance(x, tuple) else "",
)
def test_a_broken_hand_written_element_is_caught(case, function, wrong, monkeypatch):
    monkeypatch.setattr(impact_reference, function, wrong(getattr(impact_reference, function)))
    assert_caught(element_report(case), "element", case[0])


def test_the_note_names_the_entry_that_is_wrong(monkeypatch):
    """One entry of the stiffness is off: the note gives its nodes and components in DOLFINx's order."""
    theirs = nodes.dofs("hexahedron", 1, 3)
    i, j = 14, 6  # node 4 component 2 against node 2 component 0
    monkeypatch.setattr(
        impact_reference,
        "element_stiffness",
        one_entry(impact_reference.element_stiffness, (theirs[i], theirs[j]), 1 + 1e-6),
    )
    found = assert_caught(element_report(HEX), "element", HEX[0])
    assert found.note.startswith("node 4 component 2 against node 2 component 0, ")


@pytest.mark.filterwarnings("ignore:invalid value:RuntimeWarning")
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_nan_is_a_difference(value, monkeypatch):
    monkeypatch.setattr(
        impact_reference, "element_stiffness", one_entry(impact_reference.element_stiffness, (0, 0), value)
    )
    assert_caught(element_report(HEX), "element", HEX[0])


@pytest.mark.parametrize("what", ["weight", "point"])
@pytest.mark.parametrize("case", [HEX, TET2], ids=["hexahedron", "tetrahedron"])
def test_a_broken_quadrature_table_is_caught(what, case, monkeypatch):
    """One weight off by 1e-10 of itself, or one point moved by 1e-9."""
    right = impact_reference.rules.quadrature

    def wrong(cell, rule):
        points, weights = (np.array(a) for a in right(cell, rule))
        if what == "weight":
            weights[1] *= 1 + 1e-10
        else:
            points[1, 0] += 1e-9
        return points, weights

    monkeypatch.setattr(impact_reference.rules, "quadrature", wrong)
    assert_caught(element_report(case), "element", case[0])


# The map between the two node orders.


def _swapped(order, pair):
    order = order.copy()
    order[list(pair)] = order[list(pair[::-1])]
    return order


@pytest.mark.parametrize("pair", [(4, 5), (0, 1), (8, 9)])
def test_a_wrong_node_order_is_caught(pair, monkeypatch):
    right = nodes._permutation
    monkeypatch.setattr(nodes, "_permutation", lambda c, d: _swapped(right(c, d), pair) if d == 2 else right(c, d))
    assert_caught(element_report(TET2), "element", TET2[0])


@pytest.fixture
def fresh_permutations():
    nodes._permutation.cache_clear()
    yield
    nodes._permutation.cache_clear()


def test_wrong_positions_of_the_other_sides_nodes_are_caught(monkeypatch, fresh_permutations):
    right = impact_reference.reference_nodes
    monkeypatch.setattr(
        impact_reference,
        "reference_nodes",
        lambda c, d: right(c, d)[_swapped(np.arange(10), (4, 6))] if d == 2 else right(c, d),
    )
    assert_caught(element_report(TET2), "element", TET2[0])


def test_nodes_without_partner_are_a_failure_that_says_so(monkeypatch, fresh_permutations):
    right = impact_reference.reference_nodes
    monkeypatch.setattr(impact_reference, "reference_nodes", lambda c, d: right(c, d) + 1e-3)
    found = assert_caught(element_report(TET2), "element", TET2[0])
    assert "the nodes of the two sides do not match on tetrahedrons of degree" in found.note
