# SPDX-License-Identifier: MIT
"""What the catalogue holds, and what it says about the rest."""

import pytest
import ufl

from dolfinx_impact.forms import registration, registry
from dolfinx_impact.forms.catalogue import damping, plasticity
from dolfinx_impact.forms.compiler import emit, frontend
from dolfinx_impact.forms.materials import HYPOTHESES, LAWS

RANKS = {
    "force": 1,
    "tangent": 2,
    "energy": 0,
    "mass": 2,
    "row_sum": 1,
    "traction": 1,
    "poisson": 2,
    "poisson_residual": 1,
}


@pytest.mark.parametrize("name", registry.NAMES)
@pytest.mark.parametrize("cell", registry.CELLS)
def test_every_name_builds_on_every_cell(name, cell):
    if name == "nodal_mass" and cell in ("triangle", "tetrahedron"):
        with pytest.raises(ValueError, match="simplices"):
            registry.build(name, cell, 1)
        return
    built = registry.build(name, cell, 2)
    assert isinstance(built.form, ufl.Form)
    rank = RANKS.get(name.split(".")[-1])
    assert rank is None or len(built.form.arguments()) == rank
    labels = set(built.names.values())
    assert set(built.names) >= set(built.form.coefficients()) | set(built.form.constants())
    if name in registry.LAW_FORMS:
        assert {"E", "nu"} <= labels


@pytest.mark.parametrize(
    "arguments, words",
    [
        (("mass", "prism", 1), "prism.*triangle, quadrilateral, tetrahedron, hexahedron"),
        (("mass", "triangle", 3), "degree 3.*1 or 2"),
        (("mass", "triangle", "1"), "degree '1'"),
        (("mass", "triangle", 1, 3), "geometry degree 3"),
        (("massive", "triangle", 1), "'massive' is unknown.*mass"),
        (("mass", "triangle", 1, 1, "plain_strain"), "plain_strain.*plane_strain"),
        (("mass", "triangle", 1, 1, "3d"), "does not fit.*dimension 2"),
        (("mass", "hexahedron", 1, 1, "axisymmetric"), "does not fit.*dimension 3"),
        (("gyroscopic", "triangle", 1, 1, "axisymmetric"), "not axisymmetric"),
    ],
)
def test_outside_the_catalogue_is_an_error(arguments, words):
    with pytest.raises(ValueError, match=words):
        registry.build(*arguments)


def test_table_rows_are_distinct_and_allowed():
    symbols = [row.symbol for row in registry.TABLE]
    assert len(set(symbols)) == len(symbols)
    for row in registry.TABLE:
        registry.check(row.name, row.cell, row.degree, row.geometry_degree, row.hypothesis)
        assert row.symbol.isidentifier()


def test_no_two_rows_are_the_same_form():
    """A form is found by its signature: two rows of one form would count twice."""
    forms = [row.build() for row in registry.TABLE]
    signatures = [frontend.form_signature(built.form, built.law) for built in forms]
    twice = [row.symbol for row, signature in zip(registry.TABLE, signatures) if signatures.count(signature) > 1]
    assert twice == []


def test_every_cell_and_degree_has_the_laws():
    held = {(r.name, r.cell, r.degree) for r in registry.TABLE}
    for law in LAWS:
        for cell in registry.CELLS:
            assert {(f"{law}.force", cell, degree) in held for degree in registry.DEGREES} == {True}


@pytest.mark.parametrize("name", plasticity.NAMES)
def test_forms_with_internal_variables_have_point_laws(name):
    """They are no part of what verify compares element by element."""
    built = registry.build(name, "hexahedron", 1)
    if name == "elastic_stiffness.finite":
        assert built.law is None and len(built.form.arguments()) == 2
        return
    assert name.startswith("j2.") and list(built.names.values())[:3] == ["E", "nu", "yield_stress"]
    variables = {"plastic_strain", "plastic_strain_tensor"}
    if name.endswith("tangent"):  # reads them beside the direction, and changes none
        unknown = set() if ".linear." in name else {"local_unknown"}
        assert built.law is None and len(built.form.arguments()) == 1
        assert variables | unknown | {"u", "direction of the tangent"} <= set(built.names.values())
    else:
        assert variables <= set(built.law.outputs) and set(built.law.sums) == {"elastic"}
        assert (built.law.unknown is None) == (".linear." in name)


@pytest.mark.parametrize("name", damping.OF_STEPS)
def test_forms_that_resist_a_motion(name):
    built = registry.build(name, "quadrilateral", 1)
    names = [built.names[c] for c in built.form.coefficients()]
    assert sorted(names) == (["velocity"] if name.startswith("linear") else ["u", "velocity"])
    assert len(built.form.arguments()) == 1 and name not in registry.NAMES


def test_given_rule_and_degree_are_used():
    built = registry.build("mass", "quadrilateral", 1, rule="GLL", quadrature_degree=1)
    (integral,) = built.form.integrals()
    assert built.rule == "GLL" and built.degree == 1
    assert integral.metadata() == {"quadrature_degree": 1, "quadrature_rule": "GLL"}


def test_hypotheses_of_laws():
    assert set(HYPOTHESES) == {"3d", "plane_strain", "plane_stress", "axisymmetric"}
    assert set(LAWS) == {"linear_elastic", "st_venant_kirchhoff", "neo_hookean"}


@pytest.fixture
def own_forms(monkeypatch):
    """Forms registered in a test are forgotten after it."""
    monkeypatch.setattr(registration, "FORMS", dict(registration.FORMS))
    return registration.FORMS


def spring_bed(on, stiffness, centre, u):
    x = ufl.SpatialCoordinate(on.mesh)
    return stiffness * ufl.inner(x - centre, x - centre) * ufl.inner(u, on.test) * on.dx


def test_a_form_of_ones_own_is_registered_and_built(own_forms):
    register = registry.registered(
        "spring_bed",
        quadrature=lambda cell, degree, geometry_degree, hypothesis: 2 * degree + geometry_degree,
        constants={"stiffness": registry.SCALAR, "centre": registry.VECTOR},
        coefficients=("u",),
        cells=("triangle", "hexahedron"),
        excluded={"plane_stress": "a spring bed has no thickness"},
    )
    assert register(spring_bed) is spring_bed
    built = registry.build("spring_bed", "hexahedron", 2)
    assert built.degree == 5 and built.rule is None
    assert [built.names[c] for c in built.form.constants()] == ["stiffness", "centre"]
    assert [c.ufl_shape for c in built.form.constants()] == [(), (3,)]
    assert [built.names[c] for c in built.form.coefficients()] == ["u"]
    (integral,) = built.form.integrals()
    assert integral.metadata() == {"quadrature_degree": 5}
    integrals = frontend.form_integrals(built.form, "spring_bed", built.names, "3d")
    text, names = emit.source(integrals, "own_spring_bed")
    assert len(names) == 1 and "own_spring_bed" in names[0] and names[0] in text
    with pytest.raises(ValueError, match="spring_bed: only for cells triangle, hexahedron"):
        registry.build("spring_bed", "tetrahedron", 1)
    with pytest.raises(ValueError, match="spring_bed: a spring bed has no thickness"):
        registry.build("spring_bed", "triangle", 1, hypothesis="plane_stress")
    with pytest.raises(ValueError, match="'spring' is unknown: .*poisson_residual, .*, spring_bed"):
        registry.build("spring", "triangle", 1)
    assert "spring_bed" not in registry.NAMES  # the catalogue of the package, which verify compares


def test_a_scalar_form_with_a_rule_of_its_own(own_forms):
    @registry.registered("nodes", quadrature=lambda *_: 1, scalar=True, rule="GLL", cells=("quadrilateral",))
    def nodes(on):
        return on.test * on.dx

    built = registry.build("nodes", "quadrilateral", 1, rule="default")
    assert built.rule == "GLL" and built.form.arguments()[0].ufl_shape == ()


def test_a_name_is_registered_once(own_forms):
    with pytest.raises(ValueError, match="'mass' is registered already, by .*catalogue.inertia.mass"):
        registry.registered("mass", quadrature=lambda *_: 1)(spring_bed)
    with pytest.raises(ValueError, match="cell 'prism' is unknown.*triangle"):
        registry.registered("spring_bed", quadrature=lambda *_: 1, cells=("prism",))
    assert "spring_bed" not in own_forms


def test_a_registered_form_is_in_the_table_as_it_was_told(monkeypatch):
    monkeypatch.setattr(registration, "FORMS", dict(registration.FORMS))

    @registration.registered("own.mass", quadrature=lambda *_: 3, constants={"k": ()}, coefficients=("w",))
    def own(case, u, v):
        return None

    entry = registration.FORMS["own.mass"]
    assert isinstance(entry, registration.RegisteredForm) and entry.function is own
    assert (entry.name, entry.constants, tuple(entry.coefficients), entry.excluded) == (
        "own.mass",
        {"k": ()},
        ("w",),
        {},
    )


def test_a_built_form_says_which_rule_it_has():
    built = registry.build("mass", "hexahedron", 2)
    assert isinstance(built, registration.Built) and built.law is None
    degrees = {i.metadata()["quadrature_degree"] for i in built.form.integrals()}
    assert degrees == {built.degree} and built.degree >= 4  # products of two functions of degree 2
