# SPDX-License-Identifier: MIT
"""Materials of the catalogue, constant loads and contact need no compiler: their kernels come with the package."""

import os
import pathlib
import subprocess
import sys

import pytest

SCRIPT = pathlib.Path(__file__).with_name("without_compiler.py")
CASES = [(cell, 1, "plane_strain") for cell in ("triangle", "quadrilateral")]
CASES += [
    (cell, 1, hypothesis) for cell in ("triangle", "quadrilateral") for hypothesis in ("plane_stress", "axisymmetric")
]
CASES += [("triangle", 2, "plane_strain"), ("quadrilateral", 2, "plane_strain")]
CASES += [("tetrahedron", 1, "3d"), ("hexahedron", 1, "3d"), ("tetrahedron", 2, "3d"), ("hexahedron", 2, "3d")]


def run(folder, *arguments):
    environment = os.environ | {
        "XDG_CACHE_HOME": str(folder / "empty"),
        "IMPACT_JIT_CACHE": str(folder / "kernels"),
        "CC": "/nonexistent/cc",
        "CXX": "/nonexistent/c++",
    }
    command = [sys.executable, SCRIPT, *map(str, arguments)]
    return subprocess.run(command, env=environment, capture_output=True, text=True, timeout=300)


@pytest.mark.parametrize("cell, degree, hypothesis", CASES)
def test_static_implicit_and_explicit(cell, degree, hypothesis, tmp_path):
    done = run(tmp_path, cell, degree, hypothesis)
    assert done.returncode == 0, done.stderr[-2000:]
    assert [line.split()[0] for line in done.stdout.splitlines()] == ["static", "implicit", "explicit"]
    assert not (tmp_path / "kernels").exists()  # nothing was compiled
