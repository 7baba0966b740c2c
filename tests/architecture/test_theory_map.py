# SPDX-License-Identifier: MIT
"""docs/theory.md: a row for each of the 83 equations, and every file, name and verify row it mentions is there."""

import pytest
import theory_map


@pytest.fixture(scope="module")
def forms():
    from dolfinx_impact.forms import registry

    return set(registry.NAMES)


@pytest.fixture
def text(checkout):
    return (checkout / "docs" / "theory.md").read_text()


def test_all_equations_and_all_places(text, checkout, forms):
    assert theory_map.complaints(text, checkout, forms) == []
    assert len(theory_map.rows(text)) == 83


@pytest.mark.parametrize(
    "old, new, complaint",
    [
        ("| 3.7 |", "| 3.07 |", "3.7'"),
        ("| 3.25 |", "| 3.24 |", "3.25'"),
        ("| later | later |", "| later | soon |", "names nothing"),
        ("`forms/galerkin.py::weighted_residual`", "`forms/galerkin.py::no_such_name`", "does not occur"),
        ("`forms/galerkin.py::weighted_residual`", "`forms/no_such_file.py`", "does not exist"),
        ("`verify:poisson`", "`verify:no_such_form`", "not in the catalogue"),
        ("`cpp/reference/shape.h`,", "`cpp/reference/shape.h` and partly later,", "more than a list"),
        ("| sign |", "| good |", "verdict"),
        ("\\lvert", "|", "columns"),
    ],
)
def test_the_check_complains(text, checkout, forms, old, new, complaint):
    assert old in text
    assert any(complaint in c for c in theory_map.complaints(text.replace(old, new, 1), checkout, forms))


def test_notation_names_every_contact_word(checkout):
    notation = (checkout / "docs" / "notation.md").read_text()
    words = (
        "slave master normal gap penetration pressure multiplier traction contact_force penalty active slip friction"
    )
    for word in words.split() + ["stable_step", "approach", "wave_speed", "spin", "non-mortar"]:
        assert word in notation
