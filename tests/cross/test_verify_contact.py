# SPDX-License-Identifier: MIT
"""Level contact: healthy, and broken on either side."""

import impact_reference
import numpy as np
import pytest
from contact_fault_injection import PATCH, failed, of_theirs, patches, solutions, times
from fault_injection import assert_healthy

import dolfinx_impact as di
from dolfinx_impact import _cpp
from dolfinx_impact.contact.penalty.quadrature_penalty import QuadraturePenalty
from impact_verify import contact, contact_bodies, contact_patch
from impact_verify.report import Report

# Healthy.


@pytest.mark.parametrize("case", [PATCH, ("tetrahedron", "3d", 2, 2), ("hexahedron", "3d", 1, 2)], ids=lambda c: c[0])
def test_healthy_patches_pass(case):
    assert_healthy(patches(case), "contact", 112 + 8 * case[2])  # linear multipliers for degree 2 only


def test_healthy_axisymmetric_patches_pass():
    assert_healthy(patches(("quadrilateral", "axisymmetric", 2, 1)), "contact", 102)


def test_gaps_that_are_not_adjusted_fail(monkeypatch):
    """Rows with layers and adjusted gaps find a side that forgets them; the others do not mind."""
    monkeypatch.setattr(impact_reference.Contact, "_shift", lambda self, *given: np.zeros(self.num_points))
    rows = failed(patches(), ("gap", "pressure", "penalty_force"))
    found = [{part for part in contact_patch.ADJUSTMENTS if part in row.name} for row in rows]
    assert all(found) and set.union(*found) == set(contact_patch.ADJUSTMENTS)


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_healthy_solutions_pass(friction):
    assert_healthy(solutions(friction), "contact", 36 if friction else 15)


@pytest.mark.slow
@pytest.mark.alone
def test_the_whole_level_passes_in_the_time_it_may_take():
    import time

    start, report = time.time(), Report()
    contact.run(report)
    assert_healthy(report, "contact")
    assert time.time() - start < 120  # twice what it is meant to take at most, on a busy machine


def statuses(monkeypatch, compared):
    """What the rows called `compared` were given by the hand-written side while the level ran."""
    seen, right = [], contact_patch.Rows.__call__

    def spy(self, form, ours, theirs, *args, **kwargs):
        if form == compared or compared in self.name:
            seen.append((self.name, np.array(theirs)))
        right(self, form, ours, theirs, *args, **kwargs)

    monkeypatch.setattr(contact_patch.Rows, "__call__", spy)
    return seen


def test_points_are_open_stick_and_slip_on_patches(monkeypatch):
    """Or friction would be compared in part only."""
    seen = statuses(monkeypatch, "status")
    for cell, hypothesis in contact.CASES:
        for degree in (1, 2):
            seen.clear()
            patches((cell, hypothesis, degree, 1))
            assert len({s for name, v in seen if name == "deformable master" for s in v}) > 1
            assert {s for _, v in seen for s in v} == {0, 1, 2}


def test_points_stick_and_slip_in_solutions(monkeypatch):
    seen = statuses(monkeypatch, "status of")
    solutions(0.3)
    assert len(seen) == 6
    for part in (seen[:3], seen[3:]):  # penalty, multipliers
        assert {s for _, v in part for s in v} == {0, 1, 2}


def test_points_lie_on_facets_kinks_and_beside_the_edge_of_the_master():
    inside = kinks = beside = 0
    for seed in (1, 2, 3):
        body = contact.random_patch(*PATCH, seed=seed)
        u = contact_patch.displacements(body, seed)[1]
        points = body.theirs(contact_bodies.rule("interval", 4)).closest_points(body.to_theirs(u))
        found = np.isfinite(points.gap)
        corner = np.abs(np.abs(points.coordinate[found]) - 1) < 1e-12
        inside, kinks, beside = inside + np.sum(~corner), kinks + np.sum(corner), beside + np.sum(~found)
        assert np.any(points.gap[found] < 0) and np.any(points.gap > 0)
    assert inside and kinks and beside


@pytest.mark.parametrize("shape, integral", [("interval", 2 / 3), ("triangle", 1 / 12), ("quadrilateral", 4 / 3)])
def test_a_rule_handed_over_integrates_on_the_other_sides_facet(shape, integral):
    points, weights = contact_bodies.rule(shape, 4)
    assert np.sum(weights * points[:, 0] ** 2) == pytest.approx(integral, rel=1e-14)


# Broken, ours: what a class of ours gives is changed behind its back.


def scaled_property(monkeypatch, cls, name, change):
    right = getattr(cls, name).fget
    monkeypatch.setattr(cls, name, property(lambda self: change(right(self))))


def changed(monkeypatch, cls, name, change):
    """A property of a C++ class with other values."""
    right = getattr(cls, name).fget
    monkeypatch.setattr(cls, name, property(lambda self: change(right(self))), raising=False)


@pytest.mark.parametrize(
    "name, form, change",
    [
        ("gap", "gap", lambda v: v * (1 + 1e-8)),
        ("gap", "gap", lambda v: -v),
        ("normal", "normals", lambda v: -v),
        ("weight", "point_area", lambda v: v[::-1]),
        ("pressure", "pressure", lambda v: v * (1 + 1e-8)),
        ("status", "status", lambda v: np.where(v == 1, 2, v)),
    ],
)
def test_values_at_points_that_are_wrong(name, form, change, monkeypatch):
    scaled_property(monkeypatch, QuadraturePenalty, name, change)
    # Friction counts from where a point closes: gaps of the history decide forces as well.
    rows = failed(patches(), [form], ["mortar_D"] + ["penalty_force"] * (name != "gap"))
    assert "deformable master" in {r.name.split(",")[0] for r in rows}


def test_a_point_without_master_that_is_closed(monkeypatch):
    scaled_property(monkeypatch, QuadraturePenalty, "status", lambda v: np.where(v == 0, 2, v))
    failed(patches(), ["status"])


@pytest.mark.parametrize("factor", [-1.0, 1 + 1e-8, float("nan")])
def test_forces_of_the_penalty(factor, monkeypatch, contacts_in_python):
    right = QuadraturePenalty.contact_forces
    monkeypatch.setattr(QuadraturePenalty, "contact_forces", lambda self: factor * right(self))
    rows = failed(patches(), ["penalty_force"], ["penalty_tangent", "gap"])
    assert {r.name.split(",")[0] for r in rows} == {
        "deformable master",
        "rigid plane",
        "rigid sphere",
        "rigid cylinder",
    }
    assert all("UFL" in r.note for r in rows)


def test_a_radius_off_by_ten_to_the_minus_eight(monkeypatch):
    right = contact_bodies.obstacles

    def wrong(*args):
        made = right(*args)
        for _, _, theirs in made[1:]:
            theirs.radius *= 1 + 1e-8
        return made

    monkeypatch.setattr(contact, "obstacles", wrong)
    rows = failed(patches(), ["gap", "pressure", "mortar_gap"], ["mortar_D", "point_area"])
    assert {r.name.split(",")[0] for r in rows} == {"rigid sphere", "rigid cylinder"}


def test_friction_with_another_coefficient(monkeypatch):
    right = contact_bodies.TwoBodies.pair

    def wrong(self):
        pair = right(self)
        return pair._copy(friction=pair.friction * (1 + 1e-6))

    monkeypatch.setattr(contact_bodies.TwoBodies, "pair", wrong)
    failed(patches(), ["friction_traction", "penalty_force", "penalty_tangent"], ["gap", "normals", "pressure"])
    failed(solutions(0.3), ["friction_penalty", "friction_lagrange"])


def test_slip_that_open_points_keep(monkeypatch, contacts_in_python):
    right = QuadraturePenalty.accept_step

    def wrong(self):
        before = self.history.slip
        right(self)
        n = np.repeat(self.status == 0, self.gdim)
        self.history.slip = np.where(n, before + 1e-3, self.history.slip)

    monkeypatch.setattr(QuadraturePenalty, "accept_step", wrong)
    assert {r.form for r in failed(patches(), ["friction_slip"])} == {"contact.friction_slip"}


@pytest.mark.filterwarnings("ignore:invalid value")
@pytest.mark.parametrize(
    "name, change, forms",
    [
        ("normal", lambda v: -v, {"normals"}),
        ("gap", lambda v: v * (1 + 1e-8), {"mortar_gap"}),
        ("gap", lambda v: -v, {"mortar_gap"}),
        ("participates", lambda v: np.ones_like(v), {"mortar_participates"}),
    ],
)
def test_values_at_nodes_that_are_wrong(name, change, forms, monkeypatch):
    changed(monkeypatch, _cpp.multipliers.DeformableGeometry, name, change)
    rows = failed(patches(), forms, ["mortar_D", "mortar_M", "gap"])
    assert {r.name.split(",")[0] for r in rows} == {"deformable master"}


@pytest.mark.parametrize("bound, case", [(0.0, ("triangle", "plane_strain", 1, 1)), (1.0, PATCH)])
def test_normals_at_planes_of_symmetry(bound, case, monkeypatch):
    """1.9 degrees off the plane in the first case, 11.7 in the second: none, or all are put into the plane."""
    right = _cpp.multipliers.DeformableGeometry.update_gap

    def wrong(self, u):
        self.symmetry = bound
        right(self, u)

    monkeypatch.setattr(_cpp.multipliers.DeformableGeometry, "update_gap", wrong)
    assert {r.name.split(",")[0] for r in failed(patches(case), ["normals"], ["mortar_D"])} == {"deformable master"}


def test_nodes_against_obstacles(monkeypatch):
    changed(monkeypatch, _cpp.multipliers.RigidGeometry, "gap", lambda v: v + 1e-9)
    rows = failed(patches(), ["mortar_gap"], ["mortar_force"])
    assert {r.name.split(",")[0] for r in rows} == {"rigid plane", "rigid sphere", "rigid cylinder"}


# Broken, the other side.


@pytest.mark.parametrize("factor", [1 + 1e-8, -1.0])
@pytest.mark.parametrize(
    "method, name, form",
    [("mortar", "D", "mortar_D"), ("mortar", "M", "mortar_M"), ("penalty", "tangent", "penalty_tangent")],
)
def test_one_entry_of_a_matrix(method, name, form, factor, monkeypatch):
    of_theirs(monkeypatch, method, lambda answer: times(factor)(getattr(answer, name)))
    same = {form}  # the same method gives the matrices of all bases
    if method == "mortar":
        same |= {f"standard_{name}", "mortar_jump", "standard_jump"}
    assert {r.form for r in failed(patches(), [form])} == {f"contact.{f}" for f in same}


@pytest.mark.parametrize("name, forms", [("gamma", {"mortar_gamma", "mortar_gap"}), ("moved", {"mortar_slip"})])
def test_one_weighted_gap_or_slip(name, forms, monkeypatch):
    def change(answer):
        values = getattr(answer, name)
        k = np.unravel_index(np.argmax(np.abs(values)), values.shape)
        values[k] *= 1 + 1e-7

    of_theirs(monkeypatch, "mortar", change)
    failed(patches(), forms, ["mortar_D", "normals"])


def test_a_standard_basis_in_place_of_the_dual_one(monkeypatch):
    right = impact_reference.Contact.mortar

    def standard(self, u, basis="dual", *args, **kwargs):
        return right(self, u, "standard", *args, **kwargs)

    monkeypatch.setattr(impact_reference.Contact, "mortar", standard)
    failed(patches(), ["mortar_D", "mortar_M", "mortar_gamma"], ["normals", "gap"])


def test_normals_that_do_not_turn(monkeypatch):
    first = {}

    def change(answer):
        answer.normals = first.setdefault(len(answer.normals), answer.normals)

    of_theirs(monkeypatch, "mortar", change)
    failed(patches(), ["turning_tangent"], ["mortar_D"])


def test_another_rule(monkeypatch):
    """On curved facets another rule is another discretisation."""
    right = contact_bodies.rule
    monkeypatch.setattr(contact_patch, "rule", lambda shape, degree: right(shape, degree - 3))
    with pytest.raises(RuntimeError, match="do not match"):  # other points of the penalty method
        patches(("hexahedron", "3d", 1, 1))
    report = Report()
    contact_patch.mortar(report, contact.random_patch("hexahedron", "3d", 1, 2, seed=1), "deformable master", 1)
    failed(report, ["mortar_D", "mortar_M"], ["normals"])


# Other bases.


@pytest.mark.parametrize("basis", ["standard", "linear"])
@pytest.mark.parametrize("name", ["D", "M"])
def test_one_entry_of_a_matrix_of_another_basis(basis, name, monkeypatch):
    right = impact_reference.Contact.mortar

    def wrong(self, u, used="dual", *args, **kwargs):
        answer = right(self, u, used, *args, **kwargs)
        if used == basis:
            times(1 + 1e-8)(getattr(answer, name))
        return answer

    monkeypatch.setattr(impact_reference.Contact, "mortar", wrong)
    rows = failed(patches(("triangle", "plane_strain", 2, 1)), [f"{basis}_{name}", f"{basis}_jump"])
    assert {r.form for r in rows} == {f"contact.{basis}_{name}", f"contact.{basis}_jump"}


def test_linear_multipliers_in_place_of_standard_ones(monkeypatch):
    right = di.Lagrange.__init__

    def wrong(self, pair, degree=None, basis="dual"):
        right(self, pair, degree, "linear" if basis == "standard" else basis)

    monkeypatch.setattr(di.Lagrange, "__init__", wrong)
    forms = ["D", "M", "gamma", "gap", "participates", "slip", "force", "jump"]
    # The random forces differ as well, since there are fewer multipliers; shapes that differ are a failure.
    failed(patches(("hexahedron", "3d", 2, 1)), [f"standard_{f}" for f in forms], ["mortar_D", "linear_D"])


def test_functions_that_are_not_handed_over(monkeypatch):
    def all_carry(self):
        pair = self.search.slave, self.search.master
        everywhere = np.ones(self.map.size_local + self.map.num_ghosts, dtype=np.int8)
        return _cpp.gap.mortar(*pair, self.integrals.segments, self.basis, everywhere)

    monkeypatch.setattr(_cpp.multipliers.DeformableGeometry, "mortar", property(all_carry))
    rows = failed(patches(("quadrilateral", "plane_strain", 2, 1)), ["mortar_D", "standard_D"], ["normals", "gap"])
    assert {r.name.split(",")[0] for r in rows} == {"deformable master"}
