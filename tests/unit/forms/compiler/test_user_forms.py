# SPDX-License-Identifier: MIT
"""A user's own forms: our kernels equal FFCx's where we support them, and there is an error where we do not."""

import basix.ufl
import numpy as np
import pytest
import ufl
import user_forms
from kernel_oracle import Oracle, difference, two_processes, write_ffcx, write_ours

from dolfinx_impact import _cpp, compat
from dolfinx_impact.forms.compiler import frontend

CELLS = ("triangle", "hexahedron")
EXTRA = [(user_forms.functions, "quadrilateral"), (user_forms.facet_geometry, "tetrahedron")]
EXTRA += [(user_forms.sizes_of_cells, "tetrahedron"), (user_forms.sizes_of_cells, "quadrilateral")]
EXTRA += [(user_forms.rule_at_the_vertices, "tetrahedron"), (user_forms.coefficients_of_all_kinds, "quadrilateral")]
CASES = [
    (f, c) for f in user_forms.FORMS for c in CELLS if c == "triangle" or f is not user_forms.second_derivatives
] + EXTRA

# Fields are of order one and nothing cancels by more than one digit; functions of vectors are up to two units in the
# last place off, and weighted with 24 terms that is the largest difference seen.
TOLERANCE = 2e-13
pytestmark = pytest.mark.filterwarnings("ignore:Applying str:UserWarning")  # UFL, about the points of custom rules


def label(case):
    return f"{case[0].__name__}-{case[1]}"


def _build(case, folder):
    parts = case[0](case[1])
    parts = parts if isinstance(parts, tuple) else (parts,)
    stem = label(case).replace("-", "_")
    path, names = write_ours(frontend.form_integrals(sum(parts), stem, {}), folder / f"ours_{stem}")
    return [write_ffcx(part, folder / f"ffcx_{stem}_{i}") for i, part in enumerate(parts)], path, names


@pytest.fixture(scope="module")
def libraries(tmp_path_factory, request):
    """Futures of the cases that are run, two at a time: a form that cannot be compiled fails its own test only."""
    folder = tmp_path_factory.mktemp("user_forms")
    wanted = [i for i in request.session.items if getattr(i, "function", None) is test_form_equals_ffcx]
    cases = [item.callspec.params["case"] for item in wanted]
    with two_processes() as pool:
        yield {case: pool.submit(_build, case, folder) for case in cases}


# Its compilation takes as long as that of all others; on triangles the form has the same operators.
@pytest.mark.long_rows(where=lambda case: case == (user_forms.taylor_hood, "hexahedron"))
@pytest.mark.parametrize("case", CASES, ids=label)
def test_form_equals_ffcx(case, libraries, rng):
    ffcx_libraries, path, names = libraries[case].result()
    kernels = _cpp.kernels.load(str(path), names)
    oracle = Oracle(*ffcx_libraries)
    for kernel in kernels:
        assert difference(kernel, oracle, rng, low=0.5) < TOLERANCE


def _scalar(cell="triangle"):
    mesh = user_forms.mesh_of(cell)
    V = user_forms.space(mesh)
    return mesh, ufl.Coefficient(V), ufl.TestFunction(V)


def _vertices():
    _, f, v = _scalar()
    return f * v * ufl.dP


def _bessel():
    _, f, v = _scalar()
    return ufl.bessel_J(1, f) * v * ufl.dx


def _facet_area():
    mesh, f, v = _scalar("hexahedron")
    return ufl.FacetArea(mesh) * f * v * ufl.ds


def _curved_diameter():
    mesh = user_forms.mesh_of("triangle", 2)
    return ufl.CellDiameter(mesh) * ufl.TestFunction(user_forms.space(mesh)) * ufl.dx


def _facet_average():
    _, f, v = _scalar()
    return ufl.facet_avg(f**2) * v * ufl.ds


def _volume_on_facets():
    mesh, f, v = _scalar("quadrilateral")
    return ufl.CellVolume(mesh) * f * v * ufl.ds


@pytest.mark.parametrize(
    "form, words",
    [
        (_vertices, r"over ufl.dP .*NewmarkProblem"),
        (_bessel, r"ufl.bessel_J\(1, .*\) is not supported in kernels"),
        (_facet_area, r"ufl.FacetArea\(mesh\).*hexahedron"),
        (_curved_diameter, r"ufl.CellDiameter\(mesh\).*degree 2"),
        (_facet_average, r"ufl.facet_avg\(.*\) is not supported"),
        (_volume_on_facets, r"ufl.CellVolume\(mesh\).*facets.*CellDiameter"),
    ],
)
@pytest.mark.filterwarnings("ignore:Only know how:UserWarning")
def test_unsupported_is_named_as_it_was_written(form, words, tmp_path):
    with pytest.raises(ValueError, match=words):
        write_ours(frontend.form_integrals(form(), "unsupported", {}), tmp_path / "unsupported")


@pytest.mark.parametrize("cell, degree", [("quadrilateral", 1), ("hexahedron", 1), ("triangle", 2)])
def test_volume_of_cells_that_are_not_affine(cell, degree, tmp_path, rng):
    """By a rule that is exact for det J: the vector of volume times test function sums up to the squared volume."""
    mesh = user_forms.mesh_of(cell, degree)
    v = ufl.TestFunction(user_forms.space(mesh))
    rule = {"quadrature_degree": 6}
    forms = [f * ufl.dx(metadata=rule) for f in (v, ufl.CellVolume(mesh) * v)]
    kernels = []
    for i, form in enumerate(forms):
        path, names = write_ours(frontend.form_integrals(form, "volume", {}), tmp_path / f"volume_{cell}_{i}")
        kernels += _cpp.kernels.load(str(path), names)
    x = np.zeros((mesh.ufl_coordinate_element().dim // compat.geometric_dimension(mesh), 3))
    x[:, : compat.geometric_dimension(mesh)] = mesh.ufl_coordinate_element().sub_elements[0].basix_element.points
    x[:, : compat.geometric_dimension(mesh)] += rng.uniform(-0.1, 0.1, (len(x), compat.geometric_dimension(mesh)))
    sums = []
    for kernel in kernels:
        A = np.zeros(kernel.shape[0])
        kernel.tabulate(A, np.zeros(0), np.zeros(0), x.ravel())
        sums.append(A.sum())
    assert sums[1] == pytest.approx(sums[0] ** 2, rel=1e-13)


def test_names_used_twice_are_an_error():
    mesh, f, v = _scalar()
    g = ufl.Coefficient(f.ufl_function_space())
    with pytest.raises(ValueError, match="two coefficients or constants of one name.*load"):
        frontend.form_integrals(f * g * v * ufl.dx, "twice", {f: "load", g: "load"})


def test_empty_form_is_an_error():
    with pytest.raises(ValueError, match="zero"):
        frontend.form_integrals(ufl.Form([]), "nothing", {})


def test_not_a_form_is_an_error():
    with pytest.raises(TypeError, match="UFL form.*str"):
        frontend.form_integrals("u*v*dx", "text", {})


POINTS = {"triangle": [[0.2, 0.3], [0.6, 0.1]], "hexahedron": [[0.2, 0.3, 0.9], [0.5, 0.5, 0.5], [1.0, 0.0, 0.25]]}


def _stress(cell):
    mesh = user_forms.mesh_of(cell, 2)
    u = ufl.Coefficient(user_forms.space(mesh, degree=2, shape=(compat.geometric_dimension(mesh),)))
    d, c = ufl.Coefficient(user_forms.space(mesh, "DG", 0)), ufl.Constant(mesh)
    unused = ufl.Coefficient(user_forms.space(mesh))
    F = 2 * ufl.Identity(compat.geometric_dimension(mesh)) + ufl.grad(u) + 0 * unused * ufl.grad(u)
    return d * ufl.inv(F).T + c * ufl.ln(ufl.det(F) ** 2) * F


def _scalar_of_points(cell):
    mesh = user_forms.mesh_of(cell)
    f = ufl.Coefficient(ufl.FunctionSpace(mesh, basix.ufl.element("Lagrange", cell, 2)))
    return ufl.sqrt(f) * ufl.SpatialCoordinate(mesh)[0]


@pytest.mark.parametrize("make", [_stress, _scalar_of_points])
@pytest.mark.parametrize("cell", POINTS)
def test_expression_equals_ffcx(make, cell, tmp_path, rng):
    expression, points = make(cell), np.array(POINTS[cell])
    integral = frontend.expression_integral(expression, points, "expression", {})
    path, names = write_ours([integral], tmp_path / "ours")
    (kernel,) = _cpp.kernels.load(str(path), names)
    assert kernel.shape == (len(points), int(np.prod(expression.ufl_shape, dtype=int)))
    oracle = Oracle(write_ffcx((expression, points), tmp_path / "ffcx"))
    assert difference(kernel, oracle, rng, low=0.5) < TOLERANCE


def test_expression_with_arguments_is_an_error():
    _, f, v = _scalar()
    with pytest.raises(ValueError, match="test or trial functions"):
        frontend.expression_integral(f * v, [[0.2, 0.2]], "expression", {})
