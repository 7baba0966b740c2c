# SPDX-License-Identifier: MIT
"""`dolfinx-impact verify my_form.py [NAME]`: exit status, table, page, JSON and JUnit; what a file may hold."""

import json
import textwrap
import xml.etree.ElementTree as ET

import pytest

from dolfinx_impact import cli

ELASTIC = """
import ufl
from dolfinx import fem

cells = ["triangle"]


def elastic(mesh, sign=1.0):
    V = fem.functionspace(mesh, ("Lagrange", 1, (mesh.geometry.dim,)))
    u, v = fem.Function(V, name="u"), ufl.TestFunction(V)
    strain = ufl.sym(ufl.grad(u))
    stress = ufl.tr(strain) * ufl.Identity(len(u)) + 2 * strain
    return sign * ufl.inner(stress, ufl.sym(ufl.grad(v))) * ufl.dx(degree=2), u


def rubber(mesh):
    return elastic(mesh)


def wrong(mesh):
    return elastic(mesh, -1.0)


def nothing(mesh):
    return None
"""
SYMBOLIC = """
import basix.ufl
from ufl import *

mesh = Mesh(basix.ufl.element("Lagrange", "triangle", 1, shape=(2,)))
V = FunctionSpace(mesh, basix.ufl.element("Lagrange", "triangle", 1, shape=(2,)))
u, v, du = Coefficient(V), TestFunction(V), TrialFunction(V)
E, nu = Constant(mesh), Constant(mesh)
stress = lambda u: E * nu / (1 - nu) * tr(sym(grad(u))) * Identity(2) + 2 * E * sym(grad(u))
"""
FEW = ["--checks", "symmetry", "frame", "definiteness"]


@pytest.fixture(autouse=True)
def _cache(own_cache):
    pass


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.py").write_text(ELASTIC)
    return tmp_path


def test_status_0_and_what_is_written(folder, capsys):
    files = ["--json", "out/o.json", "--junit", "out/o.xml", "--output", "page"]
    assert cli.main(["verify", "mine.py", "rubber", *FEW, "taylor", "manufactured", *files]) == 0
    rows = json.loads((folder / "out" / "o.json").read_text())["rows"]
    assert all(r["passed"] and r["applies"] and r["level"] == "self" and r["form"] == "rubber" for r in rows)
    assert {r["name"] for r in rows} >= {"symmetry", "taylor", "manufactured solution"}
    root = ET.parse(folder / "out" / "o.xml").getroot()
    assert (root.get("tests"), root.get("failures")) == (str(len(rows)), "0")
    page = (folder / "page" / "index.html").read_text()
    assert "every check that applies passed" in page and '<img src="rubber_on_triangles_of_degree_1.png"' in page
    assert (folder / "page" / "rubber_on_triangles_of_degree_1.png").read_bytes().startswith(b"\x89PNG")
    assert "all passed" in capsys.readouterr().out


def test_status_1_names_the_check_everywhere(folder, capsys):
    assert cli.main(["verify", "mine.py", "wrong", *FEW, "ranks", "--junit", "o.xml", "--json", "o.json"]) == 1
    out = capsys.readouterr().out
    assert "FAIL wrong triangle definiteness: the tangent at rest has" in out and "sign of the residual" in out
    cases = {c.get("name"): c for c in ET.parse(folder / "o.xml").getroot().iter("testcase")}
    assert "negative directions" in cases["triangle P1 definiteness"].find("failure").get("message")
    assert "mpirun" in cases["triangle P1 ranks"].find("skipped").get("message")
    data = json.loads((folder / "o.json").read_text())
    assert data["passed"] is False and [r["name"] for r in data["rows"] if not r["applies"]] == ["ranks"]
    page = (folder / "results" / "verify" / "mine" / "index.html").read_text()
    assert "What failed" in page and "1 of 3 checks failed" in page


def test_all_that_can_be_checked_without_a_name(folder, capsys):
    (folder / "mine.py").write_text(ELASTIC.partition("def nothing")[0])
    assert cli.main(["verify", "mine.py", *FEW, "--json", "o.json"]) == 1
    rows = json.loads((folder / "o.json").read_text())["rows"]
    assert {r["form"]: r["cell"] for r in rows} == {
        "rubber": "triangle",
        "wrong": "triangle",
    }  # elastic has two arguments


def test_symbolic_forms_of_rank_0_1_and_2(folder, capsys):
    lines = [
        "energy = inner(stress(u), grad(u)) / 2 * dx",
        "residual = inner(stress(u), grad(v)) * dx",
        "bilinear = inner(stress(du), grad(v)) * dx",
    ]
    for line in lines:
        (folder / "plain.py").write_text(SYMBOLIC + line)
        name = line.partition(" ")[0]
        assert cli.main(["verify", "plain.py", name, *FEW, "--cells", "triangle", "--json", "o.json"]) == 0
        rows = json.loads((folder / "o.json").read_text())["rows"]
        assert {(r["form"], r["cell"], r["passed"]) for r in rows} == {(name, "triangle", True)}


def test_an_operator_is_still_compared(folder, capsys):
    """By --as, or by a name that is an operator's: the hand-written solver says more than a self-check."""
    (folder / "plain.py").write_text(SYMBOLIC + "elasticity = inner(stress(u), grad(v)) * dx(degree=2)")
    for arguments in (["elasticity"], ["--as", "elasticity"], ["elasticity", "--as", "linear_elastic"]):
        assert cli.main(["verify", "plain.py", *arguments]) == 1  # wrong constants, which no self-check can know
        assert "UFL kernels against the hand-written solver" in capsys.readouterr().out
    assert cli.main(["verify", "plain.py", *FEW]) == 0
    assert "Checks of a form of one's own" in capsys.readouterr().out


@pytest.mark.parametrize(
    "arguments, message",
    [
        (["none.py"], "there is no file none.py"),
        (["mine.py", "rubbr"], "defines nothing called 'rubbr', and the hand-written solver has no operator 'rubbr'"),
        (["mine.py", "fem"], "fem is of type module: give a function of a mesh"),
        (["mine.py", "nothing"], r"nothing(mesh) returns NoneType: return dolfinx_impact.verify.OwnForm"),
        (["mine.py", "rubber", "--cells", "hexagon"], "cell 'hexagon' is unknown: use triangle"),
        (["mine.py", "rubber", "--checks", "all"], "check 'all' is unknown: use symmetry"),
        (["plain.py", "K", "--as", "mass"], "plain.py defines no UFL form called 'K'; its forms are F"),
        (["broken.py"], "broken.py, line 3: NameError: name 'x' is not defined"),
        (["empty.py"], "there is nothing to check in empty.py: write a function my_form(mesh)"),
    ],
)
def test_status_2_and_one_sentence(arguments, message, folder, capsys):
    (folder / "broken.py").write_text(textwrap.dedent("\n# a comment\ny = x\n"))
    (folder / "empty.py").write_text("y = 1\n")
    (folder / "plain.py").write_text(SYMBOLIC + "F = inner(stress(u), grad(v)) * dx(degree=2)")
    assert cli.main(["verify", *arguments]) == 2
    error = capsys.readouterr().err
    assert message in error and error.count("\n") == 1
