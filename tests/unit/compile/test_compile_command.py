# SPDX-License-Identifier: MIT
"""The command `dolfinx-impact compile`: its header in a program, the same text each time, errors in one sentence."""

import os
import pathlib
import shlex
import subprocess
import sys

import pytest

import dolfinx_impact
from dolfinx_impact import compat
from dolfinx_impact.compile import compile_command

PACKAGE = pathlib.Path(dolfinx_impact.__file__).parent

SPRING = """
import ufl
from dolfinx import fem

cells = "triangle"


def spring(mesh, hypothesis="plane_strain"):
    V = fem.functionspace(mesh, ("Lagrange", 1, (mesh.geometry.dim,)))
    u, v = fem.Function(V), ufl.TestFunction(V)
    k, unnamed = fem.Constant(mesh, (2.0, 3.0)), fem.Constant(mesh, 5.0)
    ring = 2 * ufl.pi * ufl.SpatialCoordinate(mesh)[0] if hypothesis == "axisymmetric" else 1
    from impact_verify import OwnForm

    residual = (k[0] * u[0] * v[0] + k[1] * u[1] * v[1] + unnamed * ufl.inner(u, v)) * ring * ufl.dx(degree=2)
    return OwnForm(residual, u, parameters={"k": k}, hypothesis=hypothesis)
"""

PROGRAM = """
#include "spring.h"
#include <cstdio>
#include <dolfinx_impact/kernels/KernelTable.h>
#include <dolfinx_impact/kernels/constants.h>
#include <stdexcept>

using namespace dolfinx_impact;

std::size_t number_elsewhere(); // of kernels, in another source with the same header

template <typename F>
void refused(F f)
{
  try
  {
    f();
    std::printf("taken\\n");
  }
  catch (const std::exception& e)
  {
    std::printf("refused: %s\\n", e.what());
  }
}

int main()
{
  refused([] { kernels::find({"spring.force", "triangle", 1, 1, "plane_strain"}); });
  kernels::add(spring::kernels());
  kernels::add(spring::kernels());
  const impact_kernel* force = kernels::find({"spring.force", "triangle", 1, 1, "plane_strain"}).at(0);
  std::printf("%zu %zu %d\\n", spring::kernels().size(), number_elsewhere(),
              kernels::find({"spring.tangent", "triangle", 1, 1, "plane_strain"}).at(0) == spring::kernels()[1]);
  auto values = spring::constants();
  for (double c : kernels::constants(*force, values))
    std::printf("%g ", c);
  double A[6] = {}, w[6] = {1, 1, 1, 1, 1, 1}, x[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  kernels::tabulate(*force, 1)(A, w, kernels::constants(*force, values).data(), x, 0);
  for (double a : A)
    std::printf("%.12f ", a);
  std::printf("\\n");
  values["k"] = {1.0};
  refused([&] { kernels::constants(*force, values); });
  values.erase("k");
  refused([&] { kernels::constants(*force, values); });
  refused([] { spring::constants("string"); });
  impact_kernel other = *force, old = *force;
  other.signature = "another form";
  old.abi = 1;
  const impact_kernel *others[] = {&other}, *olds[] = {&old};
  refused([&] { kernels::add(others); });
  refused([&] { kernels::add(olds); });
}
"""
ELSEWHERE = '#include "spring.h"\nstd::size_t number_elsewhere() { return spring::kernels().size(); }\n'


def compiled(folder, *arguments):
    return compile_command.run(
        compile_command.parser().parse_args([str(folder / arguments[0]), *map(str, arguments[1:])])
    )


def test_the_header_alone_in_a_program(tmp_path):
    """In two sources of it; without Python, without warnings."""
    (tmp_path / "spring.py").write_text(SPRING)
    assert compiled(tmp_path, "spring.py", "-o", tmp_path / "spring.h") == 0
    (tmp_path / "main.cpp").write_text(PROGRAM)
    (tmp_path / "elsewhere.cpp").write_text(ELSEWHERE)
    command = [*shlex.split(os.environ.get("CXX", "c++")), "-std=c++20", "-Wall", "-Wextra", "-Werror", "-o", "program"]
    command += ["main.cpp", "elsewhere.cpp", f"-I{PACKAGE / 'include'}", f"-L{PACKAGE / 'lib'}", "-ldolfinx_impact"]
    command += [f"-Wl,-rpath,{PACKAGE / 'lib'}", "-Wl,--allow-shlib-undefined"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-3000:]
    lines = subprocess.run([tmp_path / "program"], capture_output=True, text=True, check=True).stdout.splitlines()
    assert "the name is unknown" in lines[0] and "dolfinx-impact compile" in lines[0]
    assert lines[1] == "3 3 1"  # force, tangent, mass
    numbers = [float(n) for n in lines[2].split()]
    assert sorted(numbers[:3]) == [2.0, 3.0, 5.0]
    # A third of the area 1/2 times the stiffness, at each node.
    assert numbers[3:] == pytest.approx([7 / 6, 8 / 6] * 3, abs=1e-11)
    assert "constant k has 2 components, but 1 values" in lines[3] and "has the constant k, which" in lines[4]
    assert "spring.py has no law 'string': there is spring" in lines[5]
    assert "there is another form called spring.force for triangle degree 1" in lines[6]
    assert "another version of dolfinx_impact" in lines[7] and len(lines) == 8


def command(folder, seed, *arguments):
    return subprocess.run(
        [sys.executable, "-m", "dolfinx_impact.cli", "compile", *map(str, arguments)],
        cwd=folder, env={**os.environ, "PYTHONHASHSEED": seed}, capture_output=True, text=True, timeout=100,
    )  # fmt: skip


def test_the_same_file_gives_the_same_text(tmp_path, checkout):
    """By chance the hashes of names would not, which number tables. Nor do folders and the time count."""
    texts = []
    for seed, folder in (("0", "a"), ("1", "b")):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "foam.py").write_bytes((checkout / "demos" / "cpp" / "foam.py").read_bytes())
        options = ("--cells", "triangle", "--kernels", "tangent", "stress")
        done = command(tmp_path / folder, seed, "foam.py", "-o", "foam.h", *options)
        assert done.returncode == 0 and done.stdout == "foam.h\n" and done.stderr == ""
        texts.append((tmp_path / folder / "foam.h").read_text())
    assert texts[0] == texts[1] and str(tmp_path) not in texts[0]
    about = texts[0].partition("#pragma once")[0]
    assert "dolfinx-impact compile foam.py --cells triangle --kernels tangent stress -o foam.h" in about
    assert "dolfinx_impact 0." in about and f"ffcx {compat.RELEASE[0]}.{compat.RELEASE[1]}" in about
    assert "mu 300000.0" in about and "triangle, degree 1, geometry degree 1, plane_strain" in about


FILES = {
    "spring.py": SPRING,
    "empty.py": "x = 1\n",
    "broken.py": "import ufl\n1 / 0\n",
    "exits.py": "import sys\nsys.exit(0)\n",
    "my-law.py": SPRING,
    "double.py": SPRING,
    "taken.py": SPRING.replace("def spring", "def neo_hookean"),
    "steel.py": "import dolfinx_impact as di\n"
    'steel = di.LinearElastic(E=1.0, nu=0.3, hypothesis="plane_stress")\n'
    "plastic = di.J2Plasticity(E=1.0, nu=0.3, yield_stress=0.1, hardening=0.0)\n",
    "points.py": SPRING.replace("ufl.dx(degree=2)", "ufl.dP"),
    "infinite.py": SPRING.replace("5.0", "float('inf')"),
    "two_moduli.py": SPRING.replace("5.0", "1.0 + mesh.geometry.dim").replace('cells = "triangle"', ""),
    "nameless.py": SPRING.replace("residual = (", "residual = (fem.Function(V)[0] * v[0] + "),
    "string.py": "import ufl\nfrom dolfinx import fem, mesh\nfrom mpi4py import MPI\n"
    "line = mesh.create_unit_interval(MPI.COMM_SELF, 2)\nV = fem.functionspace(line, ('Lagrange', 1))\n"
    "u, v = fem.Function(V), ufl.TestFunction(V)\nF = u * v * ufl.dx(degree=2)\n",
}
# File, further arguments, and what the message says.
ERRORS = [
    ("nowhere.py", [], "there is no file"),
    ("empty.py", [], "there is nothing to check in"),
    ("broken.py", [], "line 2: ZeroDivisionError"),
    ("exits.py", [], "ends the program, sys.exit(0)"),
    ("my-law.py", [], "gives none in C++"),
    ("double.py", [], "gives none in C++"),
    ("taken.py", [], "is a name of the package's own forms"),
    ("spring.py", ["nothing"], "defines nothing called 'nothing'; what can be checked in it: spring"),
    ("spring.py", ["cells"], "cells is of type str"),
    ("spring.py", ["--cells", "prism"], "cell 'prism' is unknown: use triangle"),
    ("spring.py", ["--degree", "3"], "degree 3 is unknown: use 1, 2"),
    ("spring.py", ["--geometry-degree", "0"], "geometry degree 0 is unknown: use 1, 2"),
    ("spring.py", ["--hypothesis", "flat"], "hypothesis 'flat' is unknown: use 3d"),
    ("spring.py", ["--kernels", "forces"], "kind of kernel 'forces' is unknown: use force"),
    ("spring.py", ["--kernels", "energy"], "there is no kernel spring.energy: the file does not say"),
    ("spring.py", ["--degree", "2"], "is written for degree 1, not for 2: give it the parameter degree"),
    ("spring.py", ["--hypothesis", "3d"], "fits the cells ('triangle',) of the file"),
    ("spring.py", ["--cells", "hexahedron", "--hypothesis", "plane_strain"], "fits cells 'hexahedron'"),
    ("steel.py", ["steel", "--cells", "hexahedron"], "has the hypothesis plane_stress, which does not fit cells"),
    ("steel.py", ["steel", "--hypothesis", "axisymmetric"], "is written for hypothesis plane_stress"),
    ("steel.py", ["plastic", "--kernels", "energy"], "the kernel of the force sums it up"),
    ("points.py", [], "the integral over ufl.dP is not supported in kernels"),
    ("infinite.py", [], "is [inf]: give it a finite value"),
    ("two_moduli.py", ["--cells", "triangle", "hexahedron"], "constants of spring have the values"),
    ("nameless.py", [], "has a function without a name"),
    ("string.py", [], "is on cells 'interval' in 1 dimensions"),
]


@pytest.mark.parametrize("name, more, message", ERRORS, ids=lambda value: str(value)[:30])
def test_what_cannot_be_compiled(name, more, message, tmp_path, capsys):
    """One sentence, exit status 2, and no file."""
    if name in FILES:
        (tmp_path / name).write_text(FILES[name])
    (tmp_path / "out").mkdir()
    assert compiled(tmp_path, name, *more, "-o", tmp_path / "out" / "law.h") == 2
    output, errors = capsys.readouterr()
    assert message in errors and output == "" and errors.count("\n") == 1
    assert list((tmp_path / "out").iterdir()) == []


def test_targets_that_cannot_be_written(tmp_path, capsys, monkeypatch):
    (tmp_path / "spring.py").write_text(SPRING)
    (tmp_path / "file").write_text("in the way")
    (tmp_path / "folder" / "spring.h").mkdir(parents=True)
    for target in ("nowhere/spring.h", "file/spring.h", "file", "folder"):
        assert compiled(tmp_path, "spring.py", "-o", tmp_path / target) == 2
        assert "the kernels cannot be written to" in capsys.readouterr().err
    assert sorted(p.name for p in tmp_path.rglob("*")) == ["file", "folder", "spring.h", "spring.py"]

    # A full disk: the header of before stays whole, and nothing lies beside it.
    (tmp_path / "kept").mkdir()
    (tmp_path / "kept" / "spring.h").write_text("of before")

    def full(*args):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "replace", full)
    assert compiled(tmp_path, "spring.py", "-o", tmp_path / "kept" / "spring.h", "--kernels", "force") == 2
    assert "No space left on device" in capsys.readouterr().err
    assert [p.name for p in (tmp_path / "kept").iterdir()] == ["spring.h"]
    assert (tmp_path / "kept" / "spring.h").read_text() == "of before"


MIXED = """
import basix.ufl
import ufl
from dolfinx import fem


def flow(mesh):
    cell = mesh.basix_cell()
    fields = basix.ufl.element("Lagrange", cell, 2, shape=(2,)), basix.ufl.element("Lagrange", cell, 1)
    w = fem.Function(fem.functionspace(mesh, basix.ufl.mixed_element(fields)))
    (u, p), (v, q) = ufl.split(w), ufl.TestFunctions(w.function_space)
    return (ufl.inner(ufl.grad(u), ufl.grad(v)) - p * ufl.div(v) - q * ufl.div(u)) * ufl.dx(degree=2), w
"""


def test_mixed_spaces_have_a_density_for_each_field(tmp_path):
    (tmp_path / "flow.py").write_text(MIXED)
    assert compiled(tmp_path, "flow.py", "-o", tmp_path / "flow.h", "--cells", "triangle", "--kernels", "mass") == 0
    text = (tmp_path / "flow.h").read_text()
    assert "//     density (2 components, no value)\n" in text and '{"density", 2, 0}' in text
    assert "//     triangle, degree 2, geometry degree 1, plane_strain\n" in text and "{15, 15}" in text


def test_hypotheses_are_those_that_are_asked_for(tmp_path):
    """Each is given to the function, and stands in the kernel's description."""
    (tmp_path / "spring.py").write_text(SPRING)
    options = ("--hypothesis", "plane_strain", "axisymmetric", "--kernels", "force")
    assert compiled(tmp_path, "spring.py", "-o", tmp_path / "kernels", *options) == 0
    text = (tmp_path / "kernels" / "spring.cpp").read_text()
    descriptors = [line for line in text.splitlines() if line.startswith("const impact_kernel impact_")]
    assert [d.split('"')[9] for d in descriptors] == ["plane_strain", "axisymmetric"]
    assert descriptors[0].split('"')[3] != descriptors[1].split('"')[3]  # another form
