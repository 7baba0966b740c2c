# SPDX-License-Identifier: MIT
"""The command: exit status, what it restricts to, what it writes."""

import json

import pytest

from dolfinx_impact import cli, verify
from dolfinx_impact.forms import inertia
from impact_verify import catalogue, verify_command

FEW = ["--levels", "element", "--cells", "triangle", "--degree", "1", "--forms", "mass", "--count", "5"]
GOOD = """
import basix.ufl
from ufl import Constant, FunctionSpace, Mesh, TestFunction, TrialFunction, dx, inner

mesh = Mesh(basix.ufl.element("Lagrange", "triangle", 1, shape=(2,)))
V = FunctionSpace(mesh, basix.ufl.element("Lagrange", "triangle", 1, shape=(2,)))
u, v, density = TrialFunction(V), TestFunction(V), Constant(mesh)
m = density * inner(u, v) * dx(metadata={"quadrature_degree": 2})
"""


@pytest.fixture(autouse=True)
def _cache(own_cache):
    pass


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_status_0_page_picture_and_json(folder, capsys):
    assert verify_command.main([*FEW, "--json", "out.json", "--output", "page"]) == 0
    data = json.loads((folder / "out.json").read_text())
    assert data["rows"] and all(r["passed"] for r in data["rows"])
    assert {(r["level"], r["form"], r["cell"], r["degree"]) for r in data["rows"]} == {
        ("element", "mass", "triangle", 1)
    }
    page = (folder / "page" / "index.html").read_text()
    assert "every row passed" in page and '<img src="differences.png"' in page
    assert (folder / "page" / "differences.png").stat().st_size > 1000
    assert "all passed" in capsys.readouterr().out


def test_status_1_and_the_rows_that_failed(folder, capsys, monkeypatch):
    right = inertia.mass
    monkeypatch.setattr(inertia, "mass", lambda *a: 1.001 * right(*a))
    assert verify_command.main([*FEW, "--json", "out.json", "--output", "page"]) == 1
    data = json.loads((folder / "out.json").read_text())
    assert data["passed"] is False and not all(r["passed"] for r in data["rows"])
    page = (folder / "page" / "index.html").read_text()
    assert "Rows that failed" in page and "every row passed" not in page and "node 0 component 0" in page
    assert "FAIL element mass" in capsys.readouterr().out


@pytest.mark.parametrize(
    "arguments, message",
    [
        (["--cells", "pentagon"], "cell 'pentagon' is unknown: use triangle"),
        (["--degree", "3"], "degree 3 is not in the catalogue"),
        (["--levels", "elements"], "level 'elements' is unknown: use element"),
        (["--levels", "element", "--forms", "masses"], "form 'masses' is unknown"),
        (["none.py", "mass"], "there is no file none.py"),
    ],
)
def test_status_2_and_what_is_wrong(arguments, message, folder, capsys):
    assert verify_command.main(arguments) == 2
    assert message in capsys.readouterr().err


@pytest.mark.parametrize("arguments", [["--degree", "one"], ["--nonsense"], ["--cells"]])
def test_options_that_do_not_parse(arguments, capsys):
    with pytest.raises(SystemExit) as stop:
        verify_command.main(arguments)
    assert stop.value.code == 2 and "usage: dolfinx-impact verify" in capsys.readouterr().err


def test_nothing_compared_is_no_success(folder, capsys):
    """Simplices have no nodal mass: the request is fine, but there is nothing to compare."""
    nothing = ["--levels", "element", "--cells", "triangle", "--forms", "nodal_mass", "--output", "page"]
    assert verify_command.main(nothing) == 1
    assert "0 rows, nothing was compared" in capsys.readouterr().out
    assert "every row passed" not in (folder / "page" / "index.html").read_text()


@pytest.mark.parametrize(
    "line, name, status, message",
    [
        ("", "mass", 0, "all passed"),
        ("m = 1.001 * m", "mass", 1, "FAIL element mass"),
        ("m = (", "mass", 2, "own.py, line 9: "),
        ("", "masses", 2, "no operator 'masses'"),
        ("del m", "mass", 2, "defines no UFL form"),
    ],
    ids=["good", "factor", "syntax", "operator", "no form"],
)
def test_a_users_file_by_the_command_line(line, name, status, message, folder, capsys):
    (folder / "own.py").write_text(GOOD + line + "\n")
    assert cli.main(["verify", "own.py", name, "--json", "own.json"]) == status
    captured = capsys.readouterr()
    assert message in captured.out + captured.err
    assert (folder / "own.json").exists() is (status != 2)


def test_cross_check_of_a_name_and_of_a_file(folder):
    report = verify.cross_check("mass", cells=["triangle"], degrees=[1], count=5)
    assert report.passed and {(r.form, r.cell) for r in report.rows} == {("mass", "triangle")}
    (folder / "mass.py").write_text(GOOD)
    assert verify.cross_check(folder / "mass.py").passed


@pytest.mark.parametrize("bad", [{"cells": ["hex"]}, {"degrees": [0]}, {"levels": ["all"]}])
def test_cross_check_rejects_what_it_does_not_know(bad):
    with pytest.raises(ValueError, match="use "):
        verify.cross_check("mass", **bad)
    with pytest.raises(ValueError, match="form 'masss' is unknown"):
        verify.cross_check("masss")


def test_the_catalogue_leaves_no_form_cell_or_degree_out():
    from dolfinx_impact.forms import registry

    cases = catalogue.cases()
    found = {(name, cell, degree) for name, cell, degree, _, _ in cases}
    wanted = {(n, c, d) for n in registry.NAMES for c in registry.CELLS for d in registry.DEGREES}
    simplices = {("nodal_mass", c, d) for c in ("triangle", "tetrahedron") for d in (1, 2)}
    assert found == wanted - simplices
    assert len(set(cases)) == len(cases)
    hypotheses = {h for n, *_, h in cases if n == "neo_hookean.tangent"}
    assert hypotheses == {"3d", "plane_strain", "plane_stress", "axisymmetric"}
    assert {g for n, c, d, g, h in cases} == {1, 2}
