# SPDX-License-Identifier: MIT
"""Checks of forms without a counterpart: right forms pass, and each check finds the form that is broken in its way."""

import re

import own_forms
import pytest
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI
from own_forms import displacement, hooke, neo_hooke, strain

import dolfinx_impact as di
from dolfinx_impact.dynamics.implicit.newmark_problem import NewmarkProblem
from impact_verify import OwnForm, self_check
from impact_verify.selfcheck import file, kernels, parameters
from impact_verify.selfcheck.self_check import CHECKS


@pytest.fixture(autouse=True)
def _cache(own_cache):
    pass


def failed(form, *checks, cells=("triangle",), **options):
    """Sentences of the checks that failed, by their names."""
    report = self_check(form, cells=cells, checks=checks or None, **options)
    assert report.passed is (not report.failures())
    return {f.name: f.note for f in report.failures()}


# Right forms.


@pytest.mark.parametrize(
    "form",
    [f if f in (own_forms.viscoelastic, own_forms.plastic) else pytest.param(f, marks=pytest.mark.slow)
     for f in own_forms.RIGHT],
    ids=lambda f: getattr(f, "__name__", "plastic"),
)  # fmt: skip
def test_a_right_form_passes_all_checks_that_apply(form):
    report = self_check(form)
    assert report.passed, [(f.cell, f.name, f.note) for f in report.failures()]
    assert {f.cell for f in report.findings} == {"quadrilateral", "triangle"}
    assert len({f.name for f in report.findings}) == len(CHECKS) + 1  # balances of forces and of moments are two
    assert all(f.note for f in report.findings)


@pytest.mark.slow
def test_a_right_form_in_space():
    report = self_check(neo_hooke_in_space, cells=["hexahedron", "tetrahedron"])
    assert report.passed, [(f.cell, f.name, f.note) for f in report.failures()]


@pytest.mark.parametrize("law", [di.LinearElastic, di.StVenantKirchhoff, di.NeoHookean])
@pytest.mark.parametrize(
    "hypothesis, checks",
    [
        ("plane_stress", ["energy", "frame"]),
        *(pytest.param(h, None, marks=pytest.mark.slow) for h in ("plane_strain", "axisymmetric", None)),
    ],
)
def test_materials_of_the_package(law, hypothesis, checks):
    report = self_check(law(2.0, 0.3, hypothesis=hypothesis), checks=checks)
    assert report.passed, [(f.cell, f.name, f.note) for f in report.failures()]
    assert {f.cell for f in report.findings} == (
        {"quadrilateral", "triangle"} if hypothesis else {"hexahedron", "tetrahedron"}
    )


def neo_hooke_in_space(mesh):
    u, v = displacement(mesh)
    F = ufl.Identity(3) + ufl.grad(u)
    J = ufl.det(F)
    energy = (0.5 * (ufl.tr(F.T * F) - 3) - ufl.ln(J) + ufl.ln(J) ** 2) * ufl.dx(degree=2)
    return OwnForm(ufl.derivative(energy, u, v), u, energy)


# A form that is broken in one way, the check that finds it, and what it says.

BROKEN = [
    ("not_conservative", "symmetry", "differs from its transpose by .* not the derivative of an energy"),
    ("not_conservative", "energy", "on one path .* on another"),
    ("stress_at_rest", "rest", "internal forces at rest are .* say prestressed=True"),
    ("ground", "translation", "a translation by 0.3 .* something holds the body to the ground"),
    ("skew", "rotation", "strains bodies that only turn .* not symmetrised"),
    ("not_objective", "frame", "neither of finite nor of small strain"),
    ("force", "momentum", "balance of forces: internal forces along .* sum to"),
    ("moment", "momentum", "balance of moments: .*the stress is not symmetric"),
    ("sign", "definiteness", "negative directions, .* sign of the residual"),
]


@pytest.mark.parametrize("defect, check, says", BROKEN)
def test_a_broken_form_is_found_and_named(defect, check, says):
    assert failed(neo_hooke(), check) == {}
    notes = failed(neo_hooke(**{defect: 2.0 if defect == "sign" else 0.1}), check)
    assert re.search(says, "; ".join(f"{name}: {note}" for name, note in notes.items()))


@pytest.mark.parametrize(
    "factor, says", [(2.0, "0.5 times the derivative of the given energy"), (-1.0, "sign is wrong")]
)
def test_another_energy_is_found_and_the_factor_named(factor, says):
    def stretched(mesh):
        u, v = displacement(mesh)
        energy = 0.5 * ufl.inner(hooke(strain(u)), strain(u)) * ufl.dx(degree=2)
        return OwnForm(ufl.derivative(energy, u, v), u, factor * energy)

    assert says in failed(stretched, "energy")["energy"]


@pytest.mark.parametrize("wrong", [False, True])
def test_a_tangent_without_its_geometric_part(wrong):
    def st_venant(mesh):
        u, v = displacement(mesh)
        du = ufl.TrialFunction(u.function_space)
        F = ufl.Identity(2) + ufl.grad(u)
        S = hooke((F.T * F - ufl.Identity(2)) / 2)
        dS = hooke(ufl.sym(F.T * ufl.grad(du)))
        tangent = ufl.inner(F * dS, ufl.grad(v)) * ufl.dx(degree=2)
        if not wrong:
            tangent += ufl.inner(ufl.grad(du) * S, ufl.grad(v)) * ufl.dx(degree=2)
        return OwnForm(ufl.inner(F * S, ufl.grad(v)) * ufl.dx(degree=2), u, tangent=tangent)

    notes = failed(st_venant, "taylor")
    assert list(notes) == (["taylor"] if wrong else [])
    assert not wrong or ("in place of 2" in notes["taylor"] and "geometric" in notes["taylor"])


def test_a_rule_of_one_point_under_quadrilaterals():
    def one_point(mesh):
        u, v = displacement(mesh)
        return ufl.inner(hooke(strain(u)), strain(v)) * ufl.dx(degree=1), u

    notes = failed(one_point, "rule", "definiteness", cells=["quadrilateral"])
    assert "the rule of degree 1 is too coarse" in notes["quadrature rule"]
    assert "have no stiffness at rest" in notes["definiteness"]


def test_a_weight_that_depends_on_the_cell_fails_the_patch_test():
    def weighted(mesh):
        u, v = displacement(mesh)
        return ufl.CellVolume(mesh) * ufl.inner(hooke(strain(u)), strain(v)) * ufl.dx(degree=2), u

    assert "a uniform strain is no equilibrium of a distorted mesh" in failed(weighted, "patch")["patch test"]


def test_second_gradients_on_elements_without_continuous_slopes_do_not_converge():
    def strain_gradient(mesh):
        u, v = displacement(mesh, 2)
        first, second = ufl.inner(hooke(strain(u)), strain(v)), ufl.inner(ufl.grad(strain(u)), ufl.grad(strain(v)))
        return (first + 0.01 * second) * ufl.dx(degree=2), u

    note = failed(strain_gradient, "manufactured")["manufactured solution"]
    assert "theory 2 and 2" in note and "terms between cells are missing" in note


@pytest.mark.parametrize("consistent", [True, False])
def test_interior_penalties_without_the_stress_between_cells(consistent):
    """Solutions of the form itself would not tell: the loads come from the differential equations."""
    notes = failed(lambda mesh: own_forms.interior_penalty(mesh, consistent), "manufactured")
    assert list(notes) == ([] if consistent else ["manufactured solution"])
    assert consistent or "inconsistent" in notes["manufactured solution"]


def test_kernels_that_differ_are_found(monkeypatch):
    class Wrong(di.InternalForce):
        def apply(self, b=None):
            b = super().apply(b)
            b.array[:] *= 1 + 1e-9
            return b

    assert failed(neo_hooke(), "kernels") == {}
    monkeypatch.setattr(kernels, "InternalForce", Wrong)
    assert "differs from FFCx's by 1.0e-09" in failed(neo_hooke(), "kernels")["kernels"]


def test_a_parameter_that_was_read_when_the_form_was_written():
    def frozen(mesh):
        u, v = displacement(mesh)
        E = fem.Constant(mesh, 2.0)
        residual = float(E.value) * ufl.inner(hooke(strain(u)), strain(v)) * ufl.dx(degree=2)
        return OwnForm(residual, u, parameters={"E": E})

    assert "a change of E changes nothing" in failed(frozen, "parameters")["parameters"]


@pytest.mark.parametrize("late", [False, True])
@pytest.mark.filterwarnings("ignore")  # the problem warns of what comes late, too
def test_a_parameter_that_acts_a_step_late(late, monkeypatch):
    class Late(NewmarkProblem):
        def advance(self, until, update=None, **options):
            super().advance(until, callback=lambda p: update(p, p.time), **options)

    def stretched(mesh):
        u, v = displacement(mesh)
        E = fem.Constant(mesh, 2.0)
        residual = E * ufl.inner(hooke(strain(u)), strain(v)) * ufl.dx(degree=2)
        return OwnForm(residual, u, parameters={"E": E})

    if late:
        monkeypatch.setattr(parameters, "NewmarkProblem", Late)
    notes = failed(stretched, "parameters")
    assert list(notes) == (["parameters"] if late else [])
    assert not late or "in place of 2: its value acts late" in notes["parameters"]


# What a user says about a form changes what is expected of it.


@pytest.mark.parametrize(
    "defect, said, checks",
    [
        ("not_conservative", {"conservative": False}, ("symmetry", "energy")),
        ("ground", {"grounded": True}, ("translation", "rotation", "momentum", "patch")),
        ("sign", {"definite": False}, ("definiteness",)),
        ("stress_at_rest", {"prestressed": True}, ("rest",)),
    ],
)
def test_what_is_said_is_not_expected(defect, said, checks):
    broken = neo_hooke(**{defect: 2.0 if defect == "sign" else 0.1})

    def form(mesh):
        own = broken(mesh)
        for name, value in said.items():
            setattr(own, name, value)
        return own

    report = self_check(form, cells=["triangle"], checks=checks)
    assert not report.failures() and not any(f.applies for f in report.findings)
    assert not report.passed  # nothing was checked


def test_small_and_finite_strain_are_told_apart():
    (finite,) = self_check(neo_hooke(), cells=["triangle"], checks=["frame"]).findings
    (small,) = self_check(own_forms.viscoelastic, cells=["triangle"], checks=["frame"]).findings
    assert finite.note.startswith("finite strain") and small.note.startswith("small strain")


def test_a_costly_rule_gets_a_cheaper_one():
    def costly(mesh):
        u, v = displacement(mesh)
        return ufl.inner(hooke(strain(u)), strain(v)) * ufl.dx(degree=9), u

    (found,) = self_check(costly, cells=["triangle"], checks=["rule"]).findings
    assert found.passed and "write dx(degree=1)" in found.note


# A form on its own mesh, and symbolic ones.


def test_a_form_on_a_mesh_is_written_on_small_ones():
    large = mesh.create_unit_square(MPI.COMM_SELF, 30, 30)
    own = own_forms.mooney_rivlin(large)
    report = self_check(own.residual, u=own.u, energy=own.energy, name="mine", checks=["energy", "frame"])
    assert report.passed and {(f.form, f.cell) for f in report.findings} == {("mine", "triangle")}


def test_a_function_that_varies_cannot_be_written_on_another_mesh():
    square = mesh.create_unit_square(MPI.COMM_SELF, 2, 2)
    u, v = displacement(square)
    T = fem.Function(fem.functionspace(square, ("Lagrange", 1)), name="T")
    T.interpolate(lambda x: x[0])
    with pytest.raises(ValueError, match="contains the function 'T', which varies: give a function of a mesh"):
        self_check((1 + T) * ufl.inner(strain(u), strain(v)) * ufl.dx, u=u)
    with pytest.raises(ValueError, match="integrates over the tag 3 of its mesh"):
        self_check(ufl.inner(strain(u), strain(v)) * ufl.dx(3), u=u)


# Files.


def test_functions_of_a_mesh_may_have_a_degree_and_a_hypothesis(tmp_path):
    """With defaults; functions that need something else are tools of the file."""
    path = tmp_path / "laws.py"
    path.write_text(
        "def plain(mesh): ...\ndef both(mesh, degree=1, hypothesis=None): ...\ndef needs(mesh, degree): ...\n"
        "def other(mesh, color=1): ...\ndef nothing(): ...\ndef _own(mesh): ...\n"
    )
    assert list(file.sources(path)[0]) == ["plain", "both"]


def test_a_file_that_ends_the_program_does_not_end_the_check(tmp_path):
    (tmp_path / "script.py").write_text("import sys\nsys.exit(0)\n")
    with pytest.raises(ValueError, match=r"script.py ends the program, sys.exit\(0\): put what is to run alone"):
        self_check(str(tmp_path / "script.py"))


# Errors at the door.


@pytest.mark.parametrize(
    "form, error, message",
    [
        (3, TypeError, "form is of type int: give a function of a mesh"),
        ((lambda m: None), TypeError, r"returns NoneType: return dolfinx_impact.verify.OwnForm"),
        ((lambda m: 1 / 0), ValueError, "ends with ZeroDivisionError: division by zero; --cells"),
        ((lambda m: (None, displacement(m)[0])), ValueError, "give a residual, or a material"),
        ((lambda m: (displacement(m)[1][0] * ufl.dx, displacement(m)[0])), ValueError, "does not contain"),
        (
            (lambda m: OwnForm(*own_forms.viscoelastic(m), hypothesis="flat")),
            ValueError,
            "hypothesis 'flat' is unknown: use one of",
        ),
        (
            (lambda m: own_forms.viscoelastic(mesh.create_unit_square(MPI.COMM_SELF, 1, 1))),
            ValueError,
            "must write the form on the mesh that it is given",
        ),
        (
            (lambda m: OwnForm(*own_forms.viscoelastic(m), stress=ufl.Identity(2))),
            ValueError,
            "stress must be a UFL tensor of 3 x 3",
        ),
        (
            (lambda m: OwnForm(*own_forms.viscoelastic(m), parameters={"E": 3.0})),
            TypeError,
            "parameter 'E' must be a dolfinx.fem.Constant",
        ),
    ],
)
def test_what_cannot_be_checked(form, error, message):
    with pytest.raises(error, match=message):
        self_check(form)


@pytest.mark.parametrize(
    "options, message",
    [({"cells": ["hexa"]}, "cell 'hexa' is unknown: use"), ({"checks": ["all"]}, "check 'all' is unknown: use symm")],
)
def test_unknown_cells_and_checks(options, message):
    with pytest.raises(ValueError, match=message):
        self_check(neo_hooke(), **options)


# Several ranks.

RANKS = """
import ufl
from dolfinx import fem
from mpi4py import MPI
from impact_verify import self_check

def form(wrong):
    def elastic(mesh):
        V = fem.functionspace(mesh, ("Lagrange", 1, (2,)))
        u, v = fem.Function(V), ufl.TestFunction(V)
        E = fem.Constant(mesh, 1.0 + wrong * mesh.comm.rank)
        return E * ufl.inner(ufl.sym(ufl.grad(u)), ufl.sym(ufl.grad(v))) * ufl.dx(degree=2), u
    return elastic

for wrong in (False, True):
    (found,) = self_check(form(wrong), cells=["triangle"], checks=["ranks"]).findings
    assert found.applies and found.passed is not wrong, found.note
    assert not wrong or f"{MPI.COMM_WORLD.size} ranks give other forces than one" in found.note
print("compared")
"""


@pytest.mark.mpi
@pytest.mark.parametrize("ranks", [2])
def test_several_ranks_against_one(ranks, script_on_ranks):
    assert "compared" in script_on_ranks(ranks, RANKS)
