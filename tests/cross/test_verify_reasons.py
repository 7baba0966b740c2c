# SPDX-License-Identifier: MIT
"""What cross_check says is wrong with a form: mistakes that people make, each with its reason; right forms have none.

Forms with the factors of many mistakes are compiled once; a mistake is a set of values of these factors.
"""

import re

import basix.ufl
import numpy as np
import pytest
import ufl
from mpi4py import MPI
from ufl import Identity, det, dx, grad, inner, inv, ln, skew, sym, tr

from dolfinx_impact.assembly.jit import compile_form
from dolfinx_impact.forms.compiler import frontend
from impact_verify import catalogue, user_form
from impact_verify.reasons import numbers
from impact_verify.reasons.explain import Explanation
from impact_verify.report import Report

FACTORS = ("a", "b", "c", "d", "e")


@pytest.fixture(autouse=True)
def _cache(own_cache):
    pass


class Symbols:
    """Symbols of a file for a cell, with factors as further constants."""

    def __init__(self, cell, degree=1):
        dim = 2 if cell in ("triangle", "quadrilateral") else 3
        self.dim, vector = dim, basix.ufl.element("Lagrange", cell, degree, shape=(dim,))
        self.mesh = ufl.Mesh(basix.ufl.element("Lagrange", cell, 1, shape=(dim,)))
        V = ufl.FunctionSpace(self.mesh, vector)
        self.u, self.v, self.du = ufl.Coefficient(V), ufl.TestFunction(V), ufl.TrialFunction(V)
        self.lmbda, self.mu = ufl.Constant(self.mesh), ufl.Constant(self.mesh)
        self.factors = [ufl.Constant(self.mesh) for _ in FACTORS]
        self.r = ufl.SpatialCoordinate(self.mesh)[0]
        self.names = {self.u: "u", self.lmbda: "lambda", self.mu: "mu", **dict(zip(self.factors, FACTORS))}

    def explain(self, form, name, cell, hypothesis, **factors):
        """Reason for values of the factors; those that are not named are zero."""
        draws = []
        for seed in range(2):
            c = catalogue.parameters(np.random.default_rng(seed), name, self.dim)
            c["lambda"] = c["E"] * c["nu"] / ((1 + c["nu"]) * (1 - 2 * c["nu"]))
            c["mu"] = c["E"] / (2 * (1 + c["nu"]))
            values = {k: f(c) if callable(f) else f for k, f in factors.items()}
            draws.append({**c, **dict.fromkeys(FACTORS, 0.0), **values})
        compiled = compile_form(form, self.names, MPI.COMM_SELF)
        integrals = frontend.form_integrals(form, "form", self.names)
        theirs = {i.integral_type: user_form._rule(i, cell) for i in integrals}
        return Explanation((name, cell, 1, 1, hypothesis), compiled, self.names, draws, integrals, theirs).text()


# --- linear elasticity -----------------------------------------------------------------------------------------------


def swap(c):
    return c["mu"] / c["lambda"]


def plane(c):
    return 2 * c["mu"] / (c["lambda"] + 2 * c["mu"])


LINEAR = [
    ((1, 1, 1, 0), ""),
    ((-1, -1, -1, 0), "the sign is wrong"),
    ((4, 4, 4, 0), r"the 1/2 of sym\(grad u\) is missing \(volumetric part 4.00 times, shear 4.00 times\)"),
    ((1.25, 1.25, 1.25, 0), "every entry is 1.25 times that of the operator linear_elastic.force"),
    ((swap, lambda c: 1 / swap(c), lambda c: 1 / swap(c), 0), "lambda and mu are swapped"),
    ((1, 1, 1, 1), r"not symmetrised: grad\(u\) stands in the place of sym"),
    ((1, 1, 1, 0.5), "not symmetrised: rotations count 0.50 times as much as strains"),
    ((1, 1, 2, 0), "shear strains count 2.00 times, normal ones 1.00 times: shear angles"),
    ((1, 0.5, 0.5, 0), "shear counts 0.50 times"),
    ((0, 1, 1, 0), "the volumetric part is missing"),
    ((-1, 1, 1, 0), "the volumetric part has the wrong sign"),
    ((1, -1, -1, 0), "shear has the wrong sign"),
    ((plane, 1, 1, 0), r"in the place of lambda stands lambda of plane stress, E nu/\(1 - nu\^2\)"),
    ((swap, 1, 1, 0), "in the place of lambda stands mu"),
    ((lambda c: 1 + 2 * c["mu"] / (3 * c["lambda"]), 1, 1, 0), r"stands the bulk modulus lambda \+ 2 mu/3"),
    ((1, lambda c: c["E"] / c["mu"], lambda c: c["E"] / c["mu"], 0), "in the place of mu stands Young's modulus"),
]


@pytest.mark.parametrize("factors, reason", LINEAR)
@pytest.mark.parametrize("cell, rank", [("quadrilateral", 1), ("triangle", 2), ("quadrilateral", 0)])
def test_parts_of_linear_elasticity(cell, rank, factors, reason):
    s = Symbols(cell)
    a, b, c, d, _ = s.factors

    def work(u, v):
        e, f = sym(grad(u)), sym(grad(v))
        normal = sum(e[i, i] * f[i, i] for i in range(2))
        rotation = 2 * s.mu * inner(skew(grad(u)), skew(grad(v)))
        return a * s.lmbda * tr(e) * tr(f) + 2 * s.mu * (b * normal + c * (inner(e, f) - normal)) + d * rotation

    form = {0: work(s.u, s.u) / 2, 1: work(s.u, s.v), 2: work(s.du, s.v)}[rank] * dx(degree=2)
    name = ("linear_elastic.energy", "linear_elastic.force", "linear_elastic.tangent")[rank]
    found = s.explain(form, name, cell, "plane_strain", **dict(zip(FACTORS, factors)))
    if reason:
        assert re.search(reason.replace("force", name.split(".")[1]), found), found
    else:
        assert found == ""


@pytest.mark.parametrize(
    "measure, hoop, reason",
    [
        ("2 pi r", True, ""),
        ("2 pi r", False, "the hoop strain u_r/r is missing"),
        ("r", True, r"the factor 2 pi of the circumference is missing \(0.159 times\)"),
        ("r", False, "2 pi and the hoop strain u_r/r are missing"),
        ("1", True, "the weight 2 pi r is missing in the measure"),
        ("1", False, "the weight 2 pi r and the hoop strain u_r/r are missing: it is plane strain"),
    ],
)
def test_measures_and_hoops_of_bodies_of_revolution(measure, hoop, reason):
    s = Symbols("quadrilateral")
    a, b, c, d, _ = s.factors

    def strain(u):
        e = sym(grad(u))
        return ufl.as_tensor([[e[0, 0], e[0, 1], 0], [e[1, 0], e[1, 1], 0], [0, 0, d * u[0] / s.r]])

    e = strain(s.u)
    stress = s.lmbda * tr(e) * Identity(3) + 2 * s.mu * e
    form = (a * 2 * ufl.pi * s.r + b * s.r + c) * inner(stress, strain(s.v)) * dx(degree=4)
    factors = {{"2 pi r": "a", "r": "b", "1": "c"}[measure]: 1.0, "d": float(hoop)}
    found = s.explain(form, "linear_elastic.force", "quadrilateral", "axisymmetric", **factors)
    assert re.fullmatch(reason or "", found), found


# --- finite strain ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "factors, reason",
    [
        ({"a": 1}, ""),
        ({"b": 1}, "a transpose is missing: F^-1 stands in the place of F^-T"),
        ({"c": 1}, "det F is missing"),
        ({"d": 1}, "another energy of the volume: lambda/2 (J - 1)^2"),
        ({"e": 1}, "the term -mu ln J of the energy is missing"),
        ({"a": -1}, "the sign is wrong"),
    ],
)
@pytest.mark.parametrize("rank", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_neo_hookean_laws(factors, reason, rank):
    s = Symbols("quadrilateral")
    F = Identity(2) + grad(s.u)
    J, T = det(F), inv(F).T
    right = s.mu * (F - T) + s.lmbda * ln(J) * T
    laws = [
        right, s.mu * (F - T.T) + s.lmbda * ln(J) * T.T, right / J, s.mu * (F - T) + s.lmbda * (J - 1) * J * T,
        s.mu * F + s.lmbda * ln(J) * T,
    ]  # fmt: skip
    form = inner(sum(c * P for c, P in zip(s.factors, laws)), grad(s.v)) * dx(degree=2)
    name = "neo_hookean.force"
    if rank == 2:
        form, name = ufl.derivative(form, s.u, s.du), "neo_hookean.tangent"
    found = s.explain(form, name, "quadrilateral", "plane_strain", **factors)
    assert found.startswith(reason) and bool(found) is bool(reason), found


@pytest.mark.parametrize(
    "factors, reason",
    [
        ({"a": 1, "b": 1}, ""),
        ({"a": 1}, "the geometric tangent is missing"),
        ({"b": 1}, "the material tangent is missing"),
        ({"a": 1, "b": 0.5}, "the material tangent counts 1.00 times, the geometric one 0.50 times"),
        ({"c": 1}, "it is linear elasticity: the form is of small strain"),
    ],
)
def test_tangents_of_st_venant_kirchhoff(factors, reason):
    s = Symbols("quadrilateral")
    F = Identity(2) + grad(s.u)

    def hooke(e):
        return s.lmbda * tr(e) * Identity(2) + 2 * s.mu * e

    S, dS = hooke((F.T * F - Identity(2)) / 2), hooke(sym(F.T * grad(s.du)))
    a, b, c, *_ = s.factors
    form = inner(a * F * dS + b * grad(s.du) * S + c * hooke(sym(grad(s.du))), grad(s.v)) * dx(degree=2)
    found = s.explain(form, "st_venant_kirchhoff.tangent", "quadrilateral", "plane_strain", **factors)
    assert found.startswith(reason) and bool(found) is bool(reason), found


@pytest.mark.parametrize(
    "factors, reason",
    [
        ({"a": 1}, ""),
        ({"b": 1}, "F is missing in F S"),
        ({"c": 1}, "S F stands in the place of F S"),
        ({"d": 1}, "the strain lacks its quadratic part"),
        ({"a": 2}, "every entry is 2 times that of the operator"),
    ],
)
def test_stresses_of_st_venant_kirchhoff(factors, reason):
    s = Symbols("triangle")
    F = Identity(2) + grad(s.u)

    def hooke(e):
        return s.lmbda * tr(e) * Identity(2) + 2 * s.mu * e

    S = hooke((F.T * F - Identity(2)) / 2)
    laws = [F * S, S, S * F, F * hooke(sym(grad(s.u)))]
    form = inner(sum(c * P for c, P in zip(s.factors, laws)), grad(s.v)) * dx(degree=2)
    found = s.explain(form, "st_venant_kirchhoff.force", "triangle", "plane_strain", **factors)
    assert found.startswith(reason) and bool(found) is bool(reason), found


# --- what is no sum of parts -----------------------------------------------------------------------------------------


def test_what_nobody_knows_gets_no_reason():
    s = Symbols("quadrilateral")
    form = s.mu * inner(grad(s.u) * grad(s.u), grad(s.v)) * dx(degree=2)
    assert s.explain(form, "linear_elastic.force", "quadrilateral", "plane_strain") == ""


DRAWS = [{"density": 2.0, "k": 3.0, "p": 5.0, "E": 7.0}, {"density": 1.5, "k": 2.0, "p": 4.0, "E": 6.0}]


@pytest.mark.parametrize(
    "s, reason",
    [
        ((1.0, 1.0), ""),
        ((0.5, 1 / 1.5), "the density is missing"),
        ((2.0, 1.5), "the density occurs once too often"),
        ((2 * np.pi, 2 * np.pi), "a factor 2 pi too many"),
        ((0.3, 0.4), "the same number of times .* depends on the constants"),
    ],
)
def test_names_of_scales(s, reason):
    assert re.search(reason, numbers.scale(np.array(s), DRAWS, "mass", False, 1))


# --- files -----------------------------------------------------------------------------------------------------------

FILE = """
import re

import basix.ufl
import ufl
from ufl import *

cell, degree = "{cell}", {degree}
dim = 2 if cell in ("triangle", "quadrilateral") else 3
mesh = Mesh(basix.ufl.element("Lagrange", cell, 1, shape=(dim,)))
V = FunctionSpace(mesh, basix.ufl.element("Lagrange", cell, degree, shape=(dim,)))
u, v, du = Coefficient(V), TestFunction(V), TrialFunction(V)
E, nu, rho, p = (Constant(mesh) for _ in range(4))
t, f = Constant(mesh, shape=(dim,)), Constant(mesh, shape=(dim,))
lmbda, mu = E * nu / ((1 + nu) * (1 - 2 * nu)), E / (2 * (1 + nu))
F = Identity(dim) + grad(u)


def sigma(w, lmbda=lmbda):
    return lmbda * tr(sym(grad(w))) * Identity(dim) + 2 * mu * sym(grad(w))


"""
STRESS = "inner(sigma(u, 2 * lmbda * mu / (lmbda + 2 * mu)), grad(v)) * dx(degree=2)"
FILES = [
    ("elasticity", STRESS, "It agrees with plane_stress: write hypothesis = 'plane_stress'", {}),
    (
        "elasticity",
        STRESS + "\nhypothesis = 'plane_strain'",
        "It agrees with plane_stress: the file says 'plane_strain'; write",
        {},
    ),
    ("elasticity", "inner(sigma(u), grad(v)) * ds", "wrong measure: the form has integrals over facets", {}),
    (
        "elasticity",
        "inner(sigma(u), grad(v)) * dx(degree=2) - inner(t, v) * ds",
        "wrong measure: .*; loads are operators of their own",
        {},
    ),
    ("elasticity", "(inner(sigma(u), grad(v)) - inner(f, v)) * dx(degree=2)", "there is a body force beside", {}),
    ("elasticity", "(inner(sigma(u), grad(v)) + mu * inner(u, v)) * dx(degree=2)", "a term in the value of u", {}),
    ("elasticity", "inner(sigma(u), grad(v)) * dx(degree=1)", "the quadrature rule is too coarse", {"degree": 2}),
    ("mass", "inner(du, v) * dx(degree=2)", "the density is missing", {}),
    ("mass", "rho**2 * inner(du, v) * dx(degree=2)", "the density occurs once too often", {}),
    (
        "mass",
        "rho * SpatialCoordinate(mesh)[0] * inner(du, v) * dx(degree=4)\nhypothesis = 'axisymmetric'",
        "2 pi .* is missing",
        {},
    ),
    ("traction", "-inner(t, v) * ds(degree=2)", "the sign is wrong", {}),
    ("follower_pressure", "-p * det(F) * inner(inv(F) * FacetNormal(mesh), v) * ds(degree=3)", "a transpose is", {}),
    ("follower_pressure", "-p * inner(inv(F).T * FacetNormal(mesh), v) * ds(degree=3)", "det F is missing", {}),
    ("follower_pressure", "p * inner(FacetNormal(mesh), v) * ds(degree=3)", "does not follow the surface", {}),
]


@pytest.mark.parametrize("operator, form, reason, element", FILES)
@pytest.mark.parametrize(
    "cell", ["quadrilateral", *(pytest.param(c, marks=pytest.mark.slow) for c in ("triangle", "hexahedron"))]
)
def test_mistakes_in_files(cell, operator, form, reason, element, tmp_path):
    plane = "plane" in reason or "2 pi" in reason
    if cell == "hexahedron" and (plane or element):
        form = "inner(sigma(u), grad(v)) * dx(degree=4)"  # the right one: there is no such mistake in space
        reason = None
    path = tmp_path / "mine.py"
    path.write_text(FILE.format(cell=cell, **{"degree": 1, **element}) + f"form = {form}\n")
    report = Report()
    user_form.check(report, path, operator if reason else "elasticity")
    causes = [row.cause for row in report.rows if row.level == "element"]
    assert report.passed is (reason is None), report.rows
    if reason is None:
        assert not any(causes)
    else:
        assert any(re.search(reason, cause) for cause in causes), causes


@pytest.mark.parametrize("operator, form", [
    ("elasticity", "inner(sigma(u), grad(v)) * dx(degree=2)"),
    ("mass", "rho * inner(du, v) * dx(degree=2)"),
    ("traction", "inner(t, v) * ds(degree=2)"),
    ("follower_pressure", "-p * det(F) * inner(inv(F).T * FacetNormal(mesh), v) * ds(degree=3)"),
])  # fmt: skip
def test_right_forms_have_no_reason(operator, form, tmp_path):
    path = tmp_path / "mine.py"
    path.write_text(FILE.format(cell="quadrilateral", degree=1) + f"form = {form}\n")
    report = Report()
    user_form.check(report, path, operator)
    assert report.passed and not any(row.cause for row in report.rows)
