# SPDX-License-Identifier: MIT
"""The generated text: the same every time and in every process; counts of operations; descriptors that say the
truth."""

import os
import subprocess
import sys

import basix.ufl
import pytest
import ufl
import user_forms

from dolfinx_impact import _cpp
from dolfinx_impact.forms import averaged_pressure, registry
from dolfinx_impact.forms.compiler import emit, frontend, kernel
from dolfinx_impact.forms.point_law import PointLaw

ROWS = [
    ("neo_hookean.force", "hexahedron", 2, 1, "3d"),
    ("linear_elastic.tangent", "tetrahedron", 2, 2, "3d"),
    ("neo_hookean.energy", "triangle", 1, 1, "plane_stress"),
    ("momentum_balance", "quadrilateral", 1, 2, "plane_strain"),
]
CODE = """
import sys
from dolfinx_impact.forms import registry
from dolfinx_impact.forms.compiler import emit, frontend
for row in {rows}:
    built = registry.build(*row)
    print(emit.source(frontend.form_integrals(built.form, row[0], built.names, row[4]), "impact_row")[0])
"""


def source(row):
    built = registry.build(*row)
    return emit.source(frontend.form_integrals(built.form, row[0], built.names, row[4], built.law), "impact_row")[0]


def test_same_text_twice():
    assert [source(r) for r in ROWS] == [source(r) for r in ROWS]


def test_same_text_in_processes_with_other_hashes():
    texts = set()
    for seed in ("1", "2"):
        environment = {**os.environ, "PYTHONHASHSEED": seed}
        code = CODE.format(rows=ROWS)
        done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
        texts.add(done.stdout)
    assert len(texts) == 1 and "impact_row_0_kernel" in texts.pop()


@pytest.mark.parametrize(
    "row, has_one",
    [
        (("linear_elastic.force", "tetrahedron", 1, 1, "3d"), True),
        (("neo_hookean.force", "triangle", 1, 1, "plane_strain"), True),
        (("linear_elastic.force", "tetrahedron", 2, 1, "3d"), True),  # positions have fewer nodes
        (("linear_elastic.force", "triangle", 2, 1, "axisymmetric"), True),
        (("linear_elastic.force", "tetrahedron", 2, 2, "3d"), False),  # sides are not straight
        (("linear_elastic.force", "hexahedron", 1, 1, "3d"), True),
        (("linear_elastic.reduced.force", "hexahedron", 1, 1, "3d"), True),
        (("linear_elastic.force", "hexahedron", 2, 1, "3d"), False),  # calls cost little beside 27 points
        (("linear_elastic.tangent", "tetrahedron", 1, 1, "3d"), False),
        (("gravity", "tetrahedron", 1, 1, "3d"), False),  # no coefficient
    ],
)
def test_kernels_of_linear_cells_have_a_sweep(row, has_one):
    text = source(row)
    assert ("impact_row_0_sweep_4(" in text) == has_one
    assert ("kernels/sweep.h" in text) == has_one
    assert ("rounded(" in text) == has_one


@pytest.mark.parametrize(
    "row, arrays, writes",
    [
        (
            ("j2.finite.voce.force", "hexahedron", 1, 1, "3d"),
            "PointArrays<3> points{{8, 48, 0}, 93, 1, 88, 89}",
            "in the branch",
        ),
        (
            ("j2.small.linear.force", "hexahedron", 1, 1, "3d"),
            "PointArrays<2> points{{8, 40}, 73, 1, 72, -1}",
            "if changed",
        ),
        (("linear_elastic.stress", "hexahedron", 1, 1, "3d"), "", ""),  # values that are no internal variables
    ],
)
def test_kernels_with_internal_variables_have_a_sweep_in_place(row, arrays, writes):
    text = source(row)
    assert text.count(arrays or "points>(*cells)") == (2 if arrays else 0)
    assert ("bool in_place" in text) == bool(arrays)
    assert ("changed = any_lane(" in text) == (writes == "if changed")
    assert "rounded(" not in text


def test_a_sweep_reads_a_scalar_beside_the_displacement():
    """Of means at the nodes and their measure: offsets and components (kernels/sweep.h: NodalArrays)."""
    mesh = ufl.Mesh(basix.ufl.element("P", "tetrahedron", 1, shape=(3,)))
    vector, scalar = (ufl.FunctionSpace(mesh, basix.ufl.element("P", "tetrahedron", 1, shape=s)) for s in ((3,), ()))
    u, mean = ufl.Coefficient(vector), ufl.Coefficient(scalar)
    law = averaged_pressure.NeoHookean(1.0, 0.3, "3d", mean)
    forms = {
        "{4, 4, 3, 0, 12, 3, 0, true, true}": ufl.inner(law.stress(u), ufl.grad(ufl.TestFunction(vector))) * ufl.dx,
        "{4, 4, 3, 0, -1, 1, 0, true, true}": averaged_pressure.average(
            law.measure(u), ufl.TestFunction(scalar), "3d", ufl.dx
        ),
    }
    for arrays, form in forms.items():
        text = emit.source(frontend.form_integrals(form, "form", {u: "u", mean: "mean"}), "impact_row")[0]
        assert text.count(f"NodalArrays{arrays}, 0>(*cells)") == 2
    by_element = ufl.Coefficient(ufl.FunctionSpace(mesh, basix.ufl.element("DG", "tetrahedron", 0)))
    form = by_element * ufl.inner(u, ufl.TestFunction(vector)) * ufl.dx
    assert (
        "_sweep_4(" not in emit.source(frontend.form_integrals(form, "f", {u: "u", by_element: "k"}), "impact_row")[0]
    )


@pytest.mark.parametrize(
    ("cell", "degree", "what", "expected"),
    (
        ("tetrahedron", 1, "gradient", "true, true"),
        ("triangle", 1, "gradient", "true, true"),
        ("tetrahedron", 1, "value", "true, false"),
        ("tetrahedron", 2, "gradient", "true, false"),
        ("hexahedron", 1, "gradient", "false, false"),
    ),
)
def test_sweeps_of_kernels_that_read_differences_to_the_first_node(cell, degree, what, expected):
    """Whether positions and whether values of the displacement are read so alone (kernels/sweep.h: NodalArrays)."""
    dim = 2 if cell == "triangle" else 3
    mesh = ufl.Mesh(basix.ufl.element("P", cell, 1, shape=(dim,)))
    space = ufl.FunctionSpace(mesh, basix.ufl.element("P", cell, degree, shape=(dim,)))
    u, v = ufl.Coefficient(space), ufl.TestFunction(space)
    strain = ufl.inner(ufl.sym(ufl.grad(u)), ufl.grad(v))
    form = (strain if what == "gradient" else strain + ufl.inner(u, v)) * ufl.dx
    text = emit.source(frontend.form_integrals(form, "form", {u: "u"}), "impact_row")[0]
    assert text.count(f", {expected}}}, 0>(*cells)") == 2


def test_laws_of_sums_alone_have_sweeps_and_stresses():
    """Elastic cells beside plastic ones sum their energy up: their kernels are those without a law but for it."""
    mesh = user_forms.mesh_of("hexahedron")
    V = user_forms.space(mesh, shape=(3,))
    u, v = ufl.Coefficient(V), ufl.TestFunction(V)
    F = ufl.variable(ufl.Identity(3) + ufl.grad(u))
    energy = ufl.tr(F.T * F) ** 2
    form = ufl.derivative(energy * ufl.dx(degree=2), u, v)
    laws = {"none": None, "a sum": PointLaw({}, sums={"elastic": energy}), "a value": PointLaw({"energy": energy})}
    for what, law in laws.items():
        (integral,) = frontend.form_integrals(form, "form", {u: "u"}, law=law)
        text = emit.source([integral], "impact_row")[0]
        assert text.count(f", {int(what == 'a sum')}>(*cells)") == 2 * (what != "a value")
        assert integral.has_sweep == (what != "a value")


@pytest.mark.parametrize("first_number", (0, 7, 8, 9, 10, 97, 98, 99, 100))
def test_signature_does_not_depend_on_names_or_numbers(first_number):
    """UFL orders operands by the printed numbers of constants: 9 and 10 change places where 8 and 9 do not."""
    reference = frontend.form_signature(products_of_constants(200))
    form = products_of_constants(first_number)
    assert frontend.form_signature(form) == reference
    assert [c.count() for c in frontend.canonical(form)[0].constants()] == [0, 1, 2]


@pytest.mark.parametrize("first_number", (0, 7, 8, 9, 10, 97, 98, 99, 100))
def test_signatures_of_expressions_do_not_depend_on_numbers(first_number):
    """Ranks may have made other numbers of constants before: they must find the same kernel."""

    def signature(first):
        mesh = user_forms.mesh_of("triangle")
        a, b, c = (ufl.Constant(mesh, count=first + i) for i in range(3))
        u = ufl.Coefficient(user_forms.space(mesh))
        return frontend.expression_signature((a * b + c * b * u) * c * u**2, [[0.2, 0.3]])

    assert signature(first_number) == signature(200)


def products_of_constants(first_number):
    mesh = user_forms.mesh_of("triangle")
    a, b, c = (ufl.Constant(mesh, count=first_number + i) for i in range(3))
    u, v = (f(user_forms.space(mesh)) for f in (ufl.Coefficient, ufl.TestFunction))
    return ufl.derivative((a * b + c * b * u) * c * u**2 * ufl.dx, u, v)


def test_signatures_of_the_table_are_found():
    rows = [*registry.TABLE[::7], *(row for row in registry.TABLE if row.name.startswith("j2."))]
    for row in rows:
        built = row.build()
        found = _cpp.kernels.find_signature(emit.signature(frontend.form_signature(built.form, built.law)))
        assert found and all((k.name, k.cell, k.hypothesis) == (row.name, row.cell, row.hypothesis) for k in found)


@pytest.mark.parametrize("row", ROWS, ids=lambda r: r[0])
def test_operations_are_counted(row):
    built = registry.build(*row)
    for integral in frontend.form_integrals(built.form, row[0], built.names, row[4]):
        assert emit.flops(kernel.KernelWriter(integral).write()) > 0


def test_operations_grow_with_the_element():
    flops = [_cpp.kernels.find("linear_elastic.force", "hexahedron", degree, 1, "3d")[0].flops for degree in (1, 2)]
    assert flops[1] > 2 * flops[0]


def test_kinds_of_coefficients():
    form = user_forms.coefficients_of_all_kinds("triangle")
    (integral,) = frontend.form_integrals(form, "kinds", {})
    kinds = [c.kind for c in integral.coefficients]
    assert kinds == ["node", "node", "cell", "cell", "other", "quadrature", "quadrature"]
    ends = [c.offset + c.num_dofs for c in integral.coefficients]
    assert [c.offset for c in integral.coefficients] == [0, *ends[:-1]]  # packed without gaps


def test_subdomains_are_kept():
    mesh = user_forms.mesh_of("triangle")
    V = user_forms.space(mesh)
    v = ufl.TestFunction(V)
    form = v * ufl.dx + 2 * v * ufl.dx((1, 4)) + 3 * v * ufl.ds(2)
    found = {(i.integral_type, s) for i in frontend.form_integrals(form, "tags", {}) for s in i.subdomains}
    assert found == {("cell", -1), ("cell", 1), ("cell", 4), ("exterior_facet", 2)}
