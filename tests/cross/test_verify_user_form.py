# SPDX-License-Identifier: MIT
"""A user's own UFL file against the hand-written solver: good, subtly wrong, and of no use."""

import textwrap

import pytest
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI

from dolfinx_impact.forms import registry
from impact_verify import cross_check, user_form
from impact_verify.report import Report

ELASTICITY = """
import basix.ufl
import ufl
from ufl import Coefficient, Constant, FunctionSpace, Identity, Mesh, TestFunction, TrialFunction
from ufl import ds, dx, grad, inner, sym, tr

mesh = Mesh(basix.ufl.element("Lagrange", "{cell}", {geometry}, shape=({dim},)))
V = FunctionSpace(mesh, basix.ufl.element("Lagrange", "{cell}", {degree}, shape=({dim},)))
u, v, du = Coefficient(V), TestFunction(V), TrialFunction(V)
E, nu = Constant(mesh), Constant(mesh)
mu = E / (2 * (1 + nu))
lmbda = E * nu / ((1 + nu) * (1 - 2 * nu))
lmbda_plane = 2 * lmbda * mu / (lmbda + 2 * mu)


def sigma(w, lmbda=lmbda):
    return lmbda * tr(sym(grad(w))) * Identity({dim}) + 2 * mu * sym(grad(w))


dx = dx(metadata={{"quadrature_degree": {rule}}})
"""
BILINEAR = "a = inner(sigma(du), grad(v)) * dx"


@pytest.fixture
def write(tmp_path):
    """write(lines, name="own.py", **element) -> path of a file that starts with the definitions above."""

    def write(lines, name="own.py", cell="triangle", degree=1, geometry=1, rule=2):
        dim = 2 if cell in ("triangle", "quadrilateral") else 3
        text = ELASTICITY.format(cell=cell, degree=degree, geometry=geometry, dim=dim, rule=rule)
        path = tmp_path / name
        path.write_text(text + textwrap.dedent(lines) + "\n")
        return path

    return write


@pytest.fixture(autouse=True)
def _cache(own_cache):
    pass


def check(path, operator="elasticity"):
    report = Report()
    user_form.check(report, path, operator)
    return report


@pytest.mark.parametrize(
    "cell, degree, geometry, rule",
    [
        ("triangle", 1, 1, 2),
        ("triangle", 2, 1, 2),
        ("triangle", 2, 2, 4),
        ("quadrilateral", 1, 1, 2),
        ("hexahedron", 1, 1, 2),
    ],
)
def test_a_good_bilinear_form_passes(write, cell, degree, geometry, rule):
    report = check(write(BILINEAR, cell=cell, degree=degree, geometry=geometry, rule=rule))
    assert report.passed, report.failures()
    assert {r.level for r in report.rows} == {"element", "operator"}
    for r in report.rows:
        assert (r.form, r.cell, r.degree, r.geometry_degree) == ("linear_elastic.tangent", cell, degree, geometry)
        assert "a" in r.name.split()


def test_forms_of_rank_0_1_and_2_of_one_file(write):
    report = check(
        write(
            """
            energy = inner(sigma(u), grad(u)) / 2 * dx
            force = inner(sigma(u), grad(v)) * dx
            stiffness = inner(sigma(du), grad(v)) * dx
            """
        )
    )
    assert report.passed, report.failures()
    elements = {r.name.split()[0].rstrip(":"): r.form for r in report.rows if r.level == "element"}
    assert elements == {
        "energy": "linear_elastic.energy", "force": "linear_elastic.force", "stiffness": "linear_elastic.tangent",
    }  # fmt: skip


def test_numbers_in_the_place_of_constants(write):
    path = write("E, nu = 3.0, 0.2\n" + BILINEAR)
    text = path.read_text().replace("E, nu = Constant(mesh), Constant(mesh)", "E, nu = 3.0, 0.2")
    path.write_text(text)
    assert check(path).passed


def test_lame_constants_in_the_place_of_youngs_modulus(write):
    path = write("lmbda, mu = Constant(mesh), Constant(mesh)\na = inner(sigma(du, lmbda), grad(v)) * dx")
    assert check(path).passed


def test_the_name_of_the_file_is_the_operator(write):
    assert check(write(BILINEAR, name="elasticity.py"), None).passed


def test_a_mass_and_a_neo_hookean_energy(write):
    assert check(write("rho = Constant(mesh)\nm = rho * inner(du, v) * dx"), "mass").passed
    energy = """
        F = Identity(2) + grad(u)
        I1, lnJ = inner(F, F) + 1, ufl.ln(ufl.det(F))
        W = (mu / 2 * (I1 - 3) - mu * lnJ + lmbda / 2 * lnJ**2) * dx
        R = ufl.derivative(W, u, v)
        J = ufl.derivative(R, u, du)
        """
    report = check(write(energy), "neo_hookean")
    assert report.passed, report.failures()
    assert {r.form for r in report.rows} == {"neo_hookean.energy", "neo_hookean.force", "neo_hookean.tangent"}


# Subtly wrong.


@pytest.mark.parametrize(
    "line, size",
    [
        ("a = 1.001 * inner(sigma(du), grad(v)) * dx", 1e-3),
        ("a = -inner(sigma(du), grad(v)) * dx", 2.0),
        ("a = inner(lmbda * tr(grad(du)) * Identity(2) + 2 * mu * grad(du), grad(v)) * dx", None),
        ("a = inner(sigma(du), grad(v)) * dx + 1e-9 * mu * inner(du, v) * dx", None),
    ],
    ids=["factor 1.001", "sign", "no symmetric part", "a term too many"],
)
def test_a_wrong_form_fails_and_says_where(write, line, size):
    failures = check(write(line)).failures()
    assert [r.level for r in failures] == ["element", "operator"]
    for r in failures:
        assert r.form == "linear_elastic.tangent" and r.note.count("node") >= 2 and "hand-written" in r.note
        assert size is None or r.difference == pytest.approx(size, rel=1e-6)


def test_one_wrong_form_among_good_ones(write):
    report = check(write("good = inner(sigma(du), grad(v)) * dx\nbad = 1.001 * inner(sigma(u), grad(v)) * dx"))
    assert {r.name.split()[0] for r in report.failures()} == {"bad"}


PLANE_STRESS = "a = inner(sigma(du, lmbda_plane), grad(v)) * dx"


def test_plane_stress_in_the_place_of_plane_strain_gets_a_hint(write):
    found = check(write(PLANE_STRESS)).failures()[0]
    assert found.hypothesis == "plane_strain"
    assert "It agrees with plane_stress: write hypothesis = 'plane_stress' into the file" in found.note


def test_plane_stress_that_says_so_passes(write):
    assert check(write(PLANE_STRESS + "\nhypothesis = 'plane_stress'")).passed


def test_no_hint_where_no_hypothesis_fits(write):
    found = check(write("a = 1.001 * inner(sigma(du), grad(v)) * dx")).failures()[0]
    assert "agrees with" not in found.note


def test_a_rule_that_is_too_coarse_is_told(write):
    """One point under triangles of degree 2: the matrix has zero-energy modes, the solver's own has none."""
    report = check(write(BILINEAR, degree=2, rule=0))
    assert not report.passed or any("rule" in r.note or "quadrature" in r.note for r in report.rows)


# Files that cannot be used.


@pytest.mark.parametrize(
    "line, operator, message",
    [
        ("a = inner(sigma(du), grad(v) * dx", "elasticity", r"own.py, line \d+: "),
        ("a = inner(sigma(du), grad(w)) * dx", "elasticity", r"own.py, line 21: NameError: name 'w'"),
        (BILINEAR, "elastisity", "no operator 'elastisity'; it has .*elasticity"),
        (BILINEAR, "linear_elastic.force", "'linear_elastic.force' has rank 1, the form has rank 2"),
        ("a = inner(u, u) * dx", "mass", "operator 'mass' has no form of rank 0"),
        (
            "c = Constant(mesh)\na = c * inner(sigma(du), grad(v)) * dx",
            "elasticity",
            "the constant 'c' means nothing here",
        ),
        ("x = 3", "elasticity", "own.py defines no UFL form"),
        ("hypothesis = 'flat'\n" + BILINEAR, "elasticity", "hypothesis 'flat' is unknown"),
        ("vol = inner(1, 1) * ufl.dx(domain=mesh)", "elasticity", "holds neither u nor a test function"),
    ],
    ids=["syntax", "name", "operator", "rank of a name", "rank", "constant", "no form", "hypothesis", "no function"],
)
def test_what_cannot_be_compared_is_a_value_error(write, line, operator, message):
    with pytest.raises(ValueError, match=message):
        check(write(line), operator)


def test_a_missing_file(tmp_path):
    with pytest.raises(FileNotFoundError, match="there is no file .*none.py"):
        check(tmp_path / "none.py")


@pytest.mark.parametrize("degree", [3])
def test_a_degree_the_other_side_has_not(write, degree):
    with pytest.raises(ValueError, match="degree 3"):
        check(write(BILINEAR, degree=degree))


def test_a_poisson_residual_with_flux(tmp_path):
    path = tmp_path / "poisson.py"
    path.write_text(
        textwrap.dedent(
            """
            import basix.ufl
            from ufl import Coefficient, Constant, FunctionSpace, Mesh, TestFunction, ds, dx, grad, inner

            mesh = Mesh(basix.ufl.element("Lagrange", "triangle", 1, shape=(2,)))
            V = FunctionSpace(mesh, basix.ufl.element("Lagrange", "triangle", 1))
            u, v = Coefficient(V), TestFunction(V)
            k, f, q = Constant(mesh), Constant(mesh), Constant(mesh)
            F = (k * inner(grad(u), grad(v)) - f * v) * dx(metadata={"quadrature_degree": 2}) - q * v * ds(
                metadata={"quadrature_degree": 2}
            )
            """
        )
    )
    report = check(path, None)
    assert report.passed, report.failures()


@pytest.mark.parametrize("name", registry.NAMES)
def test_the_rank_of_every_name_is_that_of_its_form(name):
    rank = len(registry.build(name, "quadrilateral", 1).form.arguments())
    assert user_form._rank(name) == rank or name in user_form.ALIASES


@pytest.mark.parametrize("shear, passes", [(1, True), (2, False)])
def test_a_form_on_a_mesh_of_dolfinx(shear, passes):
    """cross_check takes the form itself; its constants have names, its displacement is the only coefficient."""
    square = mesh.create_unit_square(MPI.COMM_SELF, 2, 2, mesh.CellType.quadrilateral)
    V = fem.functionspace(square, ("Lagrange", 1, (2,)))
    u, v, mu, lmbda = fem.Function(V), ufl.TestFunction(V), fem.Constant(square, 0.0), fem.Constant(square, 0.0)
    F = ufl.Identity(2) + ufl.grad(u)
    first, J = shear * mu / 2 * (ufl.tr(F.T * F) - 2), ufl.det(F)
    energy = (first - mu * ufl.ln(J) + lmbda / 2 * ufl.ln(J) ** 2) * ufl.dx(degree=2)
    found = cross_check(ufl.derivative(energy, u, v), operator="neo_hookean", constants={"mu": mu, "lmbda": lmbda})
    assert {row.level for row in found.rows} == {"element", "operator"} and found.passed == passes


def test_a_form_needs_an_operator():
    square = mesh.create_unit_square(MPI.COMM_SELF, 1, 1)
    v = ufl.TestFunction(fem.functionspace(square, ("Lagrange", 1)))
    with pytest.raises(ValueError, match="operator is None: name one of elasticity"):
        cross_check(v * ufl.dx)
