# SPDX-License-Identifier: MIT
"""The hand-written solver shares nothing with what it verifies."""

import re
import subprocess
import sys
from pathlib import Path


FOREIGN = ["dolfinx", "basix", "ufl", "ffcx", "petsc4py", "mpi4py", "slepc4py", "scipy", "dolfinx_impact"]
ROOT = Path(__file__).resolve().parents[2]


def test_import_brings_nothing_foreign():
    code = "import sys, impact_reference as ir; ir.element_mass('triangle', ir.reference_nodes('triangle', 1), "
    code += "ir.Material(1, 0.3, 1, 'plane_strain')); print(' '.join({name.split('.')[0] for name in sys.modules}))"
    names = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert "impact_reference" in names and "numpy" in names
    assert not set(names) & set(FOREIGN)


def test_compiled_module_links_nothing_foreign():
    from impact_reference import _reference

    linked = subprocess.run(["ldd", _reference.__file__], capture_output=True, text=True, check=True).stdout
    assert "libc" in linked
    assert not re.search("dolfinx|basix|petsc|slepc|mpi|hdf5|ufcx", linked.replace(_reference.__file__, ""))


def sources(folder, *endings):
    files = [f for ending in endings for f in sorted((ROOT / folder).rglob(f"*{ending}"))]
    assert files
    return files


def test_sources_include_only_plain_eigen_nanobind_and_std():
    own = {f.name for f in sources("cpp/reference", ".h")}
    for file in sources("cpp/reference", ".h", ".cpp"):
        for line in file.read_text().splitlines():
            found = re.match(r'\s*#\s*include\s*([<"])([^>"]+)[>"]', line)
            if not found:
                continue
            kind, name = found.groups()
            if kind == '"':
                assert name in own or name.startswith("plain/"), f"{file.name} includes {name}"
            else:
                assert name.startswith(("Eigen/", "nanobind/")) or re.fullmatch("[a-z_]+", name), f"{file.name}: {name}"
    for file in sources("cpp/plain", ".h"):
        for name in re.findall(r"#include\s*[<\"]([^>\"]+)", file.read_text()):
            assert re.fullmatch("[a-z_]+", name), f"{file.name} includes {name}"


def test_python_sources_import_only_numpy():
    annotations = {"__future__", "collections", "typing"}
    allowed = {"numpy", "dataclasses", "", *annotations}
    for file in sources("python/impact_reference", ".py"):
        for module in re.findall(r"^\s*(?:from|import)\s+([\w.]*)", file.read_text(), re.MULTILINE):
            assert module.split(".")[0] in allowed, f"{file.name} imports {module}"


def test_build_links_nothing_foreign():
    text = (ROOT / "cpp" / "reference" / "CMakeLists.txt").read_text()
    commands = "\n".join(line for line in text.splitlines() if not line.lstrip().startswith("#"))
    assert not re.search(r"dolfinx|basix|petsc|\bmpi|ufcx", commands.lower())
