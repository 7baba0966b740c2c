# SPDX-License-Identifier: MIT
"""Forms with point laws: descriptors, both routes to a kernel, signatures, and errors that say what does not fit."""

from types import SimpleNamespace

import basix.ufl
import ffcx.codegeneration.lnodes as L
import pytest
import ufl

from dolfinx_impact.forms import registration
from dolfinx_impact.forms.compiler import algebra, emit, frontend, kernel
from dolfinx_impact.forms.compiler.arguments import ElementTensor
from dolfinx_impact.forms.compiler.cxx import CxxFormatter
from dolfinx_impact.forms.compiler.local import LocalPart
from dolfinx_impact.forms.point_law import PointLaw


def _setting(cell="hexahedron", degree=2):
    mesh = ufl.Mesh(basix.ufl.element("Lagrange", cell, 1, shape=(registration.CELLS[cell],)))
    V = ufl.FunctionSpace(mesh, basix.ufl.element("Lagrange", cell, 1))
    Q = ufl.FunctionSpace(mesh, basix.ufl.quadrature_element(cell, degree=degree))
    return mesh, ufl.Coefficient(V), ufl.TestFunction(V), Q


def _creep(rate=2.0, name="p"):
    """x + rate x^3 = u - p; the form holds x, the history grows by x."""
    mesh, u, v, Q = _setting()
    p, x = ufl.Coefficient(Q), ufl.Coefficient(Q)
    law = PointLaw({name: p + x}, {name: p}, x, x + rate * x**3 - (u - p), 0 * p)
    return x * v * ufl.dx(domain=mesh, metadata={"quadrature_degree": 2}), law, u


def _build(form, law, **names):
    return frontend.form_integrals(form, "test", names, law=law)


def test_description_of_a_kernel():
    form, law, u = _creep()
    (integral,) = _build(form, law)
    assert [c.kind for c in integral.coefficients] == ["node", "quadrature"]
    assert [(o.name, o.num_components, o.history) for o in integral.law.outputs] == [("p", 1, 1)]
    # 8 entries of the element vector, 8 points, and the report: count, point, residual and one unknown.
    assert (integral.num_points, integral.num_unknowns, integral.size_A) == (8, 1, 8 + 8 + 4)
    text, _ = emit.source([integral], "test")
    assert text.count("local_newton<") == 1


def test_what_does_not_depend_on_the_iterate_stands_before_the_iteration():
    """The equations inside the loop of Newton's method read no coefficient: u - p is computed once."""
    form, law, _ = _creep()
    text, _ = emit.source(_build(form, law), "test")
    begin = text.index("[&](const T* __restrict iterate")
    equations = text[begin : text.index("});", begin)]
    assert "iterate[0]" in equations
    assert "w[" not in equations and "w0_" not in equations


def test_a_form_without_law_has_no_room_for_outputs():
    mesh, u, v, _ = _setting()
    (integral,) = frontend.form_integrals(u * v * ufl.dx, "test", {})
    assert (integral.size_A, integral.num_points, integral.num_unknowns) == (8, 0, 0)


def test_signatures_tell_laws_apart_and_do_not_depend_on_object_numbers():
    def signature(**changes):
        form, law, _ = _creep(**changes)
        return frontend.form_signature(form, law)

    same, again = signature(), signature()
    assert same == again
    assert len({same, signature(rate=3.0), signature(name="q")}) == 3
    form, law, _ = _creep()
    assert frontend.form_signature(form, law) != frontend.form_signature(form)


def test_a_registered_form_returns_its_law(monkeypatch):
    monkeypatch.setattr(registration, "FORMS", {})

    @registration.registered("creep.force", quadrature=lambda *_: 2, coefficients=("u",), scalar=True)
    def force(on, u):
        Q = ufl.FunctionSpace(on.mesh, basix.ufl.quadrature_element(on.cell, degree=2))
        p, x = ufl.Coefficient(Q), ufl.Coefficient(Q)
        return x * on.test * on.dx, PointLaw({"p": p + x}, {"p": p}, x, x + 2.0 * x**3 - (u - p), 0 * p)

    built = registration.build("creep.force", "hexahedron", 1)
    form, law, _ = _creep()
    (integral,) = frontend.form_integrals(built.form, "creep.force", built.names, "3d", built.law)
    # The run-time route finds the kernel that was built with the package by this signature.
    assert integral.signature == frontend.form_signature(form, law)
    assert [c.name for c in integral.coefficients] == ["u", "p"]


def _two_rules():
    form, law, u = _creep()
    v = form.arguments()[0]
    return form + u * v * ufl.dx(metadata={"quadrature_degree": 4}), law


def _rank_two():
    form, law, _ = _creep()
    (v,) = form.arguments()
    du = ufl.TrialFunction(v.ufl_function_space())
    (x,) = form.coefficients()
    return x * du * v * ufl.dx(metadata={"quadrature_degree": 2}), law


def _other_cells():
    form, law, _ = _creep()
    return form, {7: law}


def _other_points():
    """Nothing in the form has points of its own, so that the rule is the measure's."""
    mesh, u, v, Q = _setting(degree=4)
    p = ufl.Coefficient(Q)
    return u * v * ufl.dx(metadata={"quadrature_degree": 2}), PointLaw({"p": p + u}, {"p": p})


def _other_mesh():
    return _creep()[0], _creep()[1]


def _same_name():
    form, law, u = _creep()
    w = ufl.Coefficient(u.ufl_function_space())
    v = form.arguments()[0]
    return form + w * v * ufl.dx(metadata={"quadrature_degree": 2}), law, {w: "p"}


@pytest.mark.parametrize(
    "case, words",
    [
        (_two_rules, "one quadrature rule"),
        (_other_points, "27 points of a quadrature rule"),
        (_other_mesh, "another mesh"),
        (_rank_two, "rank 0 or 1"),
        (_other_cells, "law of other cells"),
        (_same_name, "one name"),
    ],
)
def test_what_does_not_fit_says_so(case, words):
    form, law, *names = case()
    with pytest.raises(ValueError, match=words):
        frontend.form_integrals(form, "test", names[0] if names else {}, law=law)


def test_arguments_of_a_law_are_checked():
    _, u, _, Q = _setting()
    p, x = ufl.Coefficient(Q), ufl.Coefficient(Q)
    for error, words, arguments in (
        (ValueError, "no output of its name", dict(outputs={"a": p}, history={"b": p})),
        (ValueError, "the same", dict(outputs={"a": ufl.grad(u)}, history={"a": p})),
        (ValueError, "quadrature element", dict(outputs={"a": u}, history={"a": u})),
        (ValueError, "one equation", dict(outputs={"a": p}, unknown=x, residual=ufl.grad(u), start=0 * p)),
        (TypeError, "start must be", dict(outputs={"a": p}, unknown=x, residual=x)),
        (ValueError, "must not depend", dict(outputs={"a": p}, unknown=x, residual=x, start=2 * x)),
        (ValueError, "belong to an unknown", dict(outputs={"a": p}, residual=p)),
        (ValueError, "cannot be history", dict(outputs={"a": p}, history={"a": p}, unknown=p, residual=p, start=0 * x)),
        (ValueError, "scalar density", dict(outputs={}, sums={"a": ufl.grad(u)})),
        (ValueError, "an output or a sum", dict(outputs={})),
        (TypeError, "UFL expression", dict(outputs={"a": 1.0})),
    ):
        with pytest.raises(error, match=words):
            PointLaw(**arguments)


def test_symbols_of_the_local_equations_in_a_kernel():
    """The iterate inside Newton's method, its solution behind it; a law in closed form has neither."""
    form, law, _ = _creep()
    local = kernel.KernelWriter(_build(form, law)[0]).local
    assert isinstance(local, LocalPart) and local.solves_last and not local.kept
    levels = [local.unknown(0, iterating)[1].level for iterating in (True, False)]
    assert levels == [algebra.ITERATE, algebra.SOLVED]
    text = [CxxFormatter()(local.access(key)) for key in (("iterate", 0), ("solution", 0), ("average", 2, 1))]
    assert text == ["iterate[0]", "local_x[0]", "average_2[1]"]


def test_sums_over_the_points_of_a_form_of_rank_0():
    """Set to zero before the loop, added to at each point, and written once behind it."""
    writer = SimpleNamespace(
        integral=SimpleNamespace(rank=0, integral_type="cell"), schedule=SimpleNamespace(expression=lambda v: v)
    )
    x = L.Symbol("x", L.DataType.SCALAR)
    element = ElementTensor(writer, SimpleNamespace(number=3, num_points=4), [((None, 0), x)])
    (before,), (inside,), (after,) = element.before(), element.inside(), element.after()
    texts = [[CxxFormatter()(s).strip() for s in part] for part in (before.declarations, [inside], after.statements)]
    assert texts[0][0].startswith("T sum_3[1]") and texts[1:] == [["sum_3[0] += x;"], ["A[0] += sum_3[0];"]]
    writer.integral.integral_type = "expression"  # values at points are no sums
    assert element.before() == element.after() == []
