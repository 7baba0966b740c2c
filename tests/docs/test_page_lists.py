# SPDX-License-Identifier: MIT
"""Counts and lists that pages state are those of the tree; and each rule complains of a tree that breaks it."""

import shutil

import page_lists
import pytest

PARTS = ("README.md", "cpp/dolfinx_impact", "demos", "docs", "forms", "python", "tests")


@pytest.mark.parametrize("rule", page_lists.ALL, ids=lambda rule: rule.__name__)
def test_pages_list_what_there_is(rule, checkout):
    assert rule(checkout) == []


@pytest.fixture(scope="module")
def copy(checkout, tmp_path_factory):
    root = tmp_path_factory.mktemp("tree")
    for part in PARTS:
        if (checkout / part).is_dir():
            shutil.copytree(checkout / part, root / part, ignore=shutil.ignore_patterns("__pycache__", "figures"))
        else:
            shutil.copy(checkout / part, root / part)
    return root


@pytest.mark.parametrize(
    "rule, file, old, new, complaint",
    [
        ("demos", "README.md", "## Demos\n\nFifteen", "## Demos\n\nTen", "README.md: does not say"),
        ("demos", "README.md", "- [`hertz`]", "- [`herz`]", "README.md: does not list hertz"),
        ("demos", "demos/new.py", None, "assert x\n", "docs/gallery.md: does not list new"),
        ("demos", "demos/applications/new.py", None, "assert x\n", "docs/gallery.md: does not list new"),
        ("demos", "demos/cpp/new.cpp", None, "", "docs/howto/cpp.md: does not list new"),
        (
            "demos",
            "docs/architecture.md",
            "fifteen short files",
            "five short files",
            "docs/architecture.md: does not say",
        ),
        ("pages", "docs/howto/" + "new.md", None, "# New\n", "docs/howto/index.md: does not list new"),
        ("pages", "docs/api/index.md", "(cpp_files.md)", "(cpp_file.md)", "docs/api/index.md: does not list cpp_files"),
        ("pages", "docs/implicit/" + "new.md", None, "# New\n", "docs/implicit/scheme.md: does not list new"),
        ("stages", "cpp/dolfinx_impact/rest/Rest.h", None, "", "docs/architecture.md: does not list rest"),
        ("stages", "README.md", "kernels, C++", "kernel, C++", "do not show the same figure"),
        ("stages", "tests/new/test_new.py", None, "", "README.md, tests/: does not list new"),
        ("methods", "docs/contact_theory.md", "| static, implicit, rolling |", "| static |", "does not list implicit"),
        (
            "methods",
            "python/dolfinx_impact/dynamics/explicit.py",
            "contact: Penalty | Kinematic |",
            "contact: Penalty | Lagrange | Kinematic |",
            "docs/contact_theory.md, Lagrange: does not list explicit",
        ),
        (
            "kernels",
            "forms/registry.py",
            '("small.linear", "small.voce")',
            '("small.voce",)',
            "quadrilaterals of degree 1",
        ),
        ("levels", "docs/verify.md", "| ranks |", "| rank |", "docs/verify.md: does not list ranks"),
        ("commands", "README.md", "    dolfinx-impact info ", "    dolfinx-impact inform ", "does not list info"),
        ("classes", "docs/developer_guide.md", "| `CurrentState` |", "| `PresentState` |", "no class PresentState"),
        (
            "classes",
            "docs/developer_guide.md",
            "`StableStepWatch` |",
            "`StepWatch` |",
            "integrators has no StepWatch",
        ),
        ("classes", "docs/developer_guide.md", "`SkipBound` |", "`SkipLimit` |", "node_tracker has no SkipLimit"),
    ],
)
def test_rules_complain(rule, file, old, new, complaint, copy):
    path = copy / file
    before = path.read_text() if path.exists() else None
    path.parent.mkdir(parents=True, exist_ok=True)
    assert old is None or old in before
    path.write_text(new if old is None else before.replace(old, new))
    try:
        found = getattr(page_lists, rule)(copy)
    finally:
        path.write_text(before) if before is not None else path.unlink()
    assert any(complaint in line for line in found), found
