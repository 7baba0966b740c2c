# SPDX-License-Identifier: MIT
"""What the catalogue holds, and what it says about the rest."""

import pytest
import ufl

from dolfinx_impact.forms import registry
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


def test_every_cell_and_degree_has_the_laws():
    held = {(r.name, r.cell, r.degree) for r in registry.TABLE}
    for law in LAWS:
        for cell in registry.CELLS:
            assert {(f"{law}.force", cell, degree) in held for degree in registry.DEGREES} == {True}


def test_given_rule_and_degree_are_used():
    built = registry.build("mass", "quadrilateral", 1, rule="GLL", quadrature_degree=1)
    (integral,) = built.form.integrals()
    assert built.rule == "GLL" and built.degree == 1
    assert integral.metadata() == {"quadrature_degree": 1, "quadrature_rule": "GLL"}


def test_hypotheses_of_laws():
    assert set(HYPOTHESES) == {"3d", "plane_strain", "plane_stress", "axisymmetric"}
    assert set(LAWS) == {"linear_elastic", "st_venant_kirchhoff", "neo_hookean"}
