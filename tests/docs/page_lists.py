# SPDX-License-Identifier: MIT
"""Counts and lists that pages state, against the tree: functions of a checkout's folder that return complaints."""

import ast
import pathlib
import re

NUMBERS = "zero one two three four five six seven eight nine ten eleven twelve thirteen fourteen fifteen sixteen"
NUMBERS = (NUMBERS + " seventeen eighteen nineteen twenty").split()
# Problems by the words that pages use for them.
PROBLEMS = {
    "static": ("statics/static_problem.py", "StaticProblem"),
    "explicit": ("dynamics/explicit.py", "ExplicitProblem"),
    "implicit": ("dynamics/implicit/newmark_problem.py", "NewmarkProblem"),
    "rolling": ("rolling/rolling_problem.py", "RollingProblem"),
}


def _page(root, name):
    return (pathlib.Path(root) / name).read_text()


def _names(root, pattern, without=("__init__",)):
    return {path.stem for path in pathlib.Path(root).glob(pattern)} - set(without)


def _count(root, page, sentence, number):
    """The page must have the sentence, in which {} is the number in words."""
    wanted = sentence.format(NUMBERS[number])
    text = " ".join(_page(root, page).split())
    return [] if wanted.lower() in text.lower() else [f"{page}: does not say {wanted!r}"]


def _same(where, listed, there):
    """Complaints about names that are listed and not there, or the other way round."""
    listed, there = set(listed), set(there)
    return [f"{where}: lists {name}, which is not there" for name in sorted(listed - there)] + [
        f"{where}: does not list {name}" for name in sorted(there - listed)
    ]


def _table(text, heading):
    """Rows of the table whose first cells are `heading`: lists of cells."""
    part = text.split(f"| {heading} |", 1)[1].split("\n\n", 1)[0]
    return [[cell.strip() for cell in line.split("|")[1:-1]] for line in part.split("\n")[2:]]


def _constant(root, name, places):
    """Value of a constant `name = (...)` of the one module of `places`, patterns of paths, that has it."""
    for path in (path for place in places for path in sorted(pathlib.Path(root).glob(place))):
        for node in ast.parse(path.read_text()).body:
            if isinstance(node, ast.Assign) and getattr(node.targets[0], "id", None) == name:
                return ast.literal_eval(node.value)
    raise AssertionError(f"no module has the constant {name}")


def demos(root):
    """Numbers and names of demos, applications and programs in C++."""
    short, large = _names(root, "demos/*.py"), _names(root, "demos/applications/*.py")
    programs = _names(root, "demos/cpp/*.cpp")
    gallery, readme = _page(root, "docs/gallery.md"), _page(root, "README.md")
    program_rows = _table(_page(root, "docs/howto/cpp.md"), "program of `demos/cpp/`")
    return [
        *_count(root, "README.md", "## Demos {} files to copy from", len(short)),
        *_count(root, "README.md", "| {} files to copy from", len(short)),
        *_count(root, "README.md", "`demos/cpp/`: {} programs", len(programs)),
        *_count(root, "docs/gallery.md", "## {} demos to copy from", len(short)),
        *_count(root, "docs/architecture.md", "| {} short files to copy from", len(short)),
        *_count(root, "docs/architecture.md", "`cpp/` has {} programs", len(programs)),
        *_same("README.md", re.findall(r"^- \[`(\w+)`\]\(docs/demos/", readme, re.M), short),
        *_same("docs/gallery.md", re.findall(r"^ +env/run dolfinx-impact demo (\w+)", gallery, re.M), short | large),
        *_same("docs/howto/cpp.md", [row[0].strip("`") for row in program_rows], programs),
    ]


def pages(root):
    """Tables of pages: how-tos, the API, the pages of explicit and implicit schemes."""
    howto = _table(_page(root, "docs/howto/index.md"), "page")
    linked = [re.search(r"\((\w+)\.md\)", row[0])[1] for row in howto]
    complaints = _same("docs/howto/index.md", linked, _names(root, "docs/howto/*.md", ("index",)))
    api = _page(root, "docs/api/index.md")
    listed = re.findall(r"^\| \[[^]]*\]\((\w+)\.md\)", api, re.M)
    complaints += _same("docs/api/index.md", listed, _names(root, "docs/api/*.md", ("index",)))
    for folder in ("explicit", "implicit"):
        rows = _table(_page(root, f"docs/{folder}/scheme.md"), "page")
        linked = [found[1] for row in rows if (found := re.search(r"\((\w+)\.md\)", row[0]))]
        complaints += _same(f"docs/{folder}/scheme.md", linked, _names(root, f"docs/{folder}/*.md", ("scheme",)))
    return complaints


def stages(root):
    """Stages of the C++ library: in the text and the figure of the architecture; folders of tests in the README."""
    library = pathlib.Path(root) / "cpp" / "dolfinx_impact"
    there = {header.relative_to(library).parts[0] for header in library.glob("*/*.h")} - {"common"}
    architecture, readme = _page(root, "docs/architecture.md"), _page(root, "README.md")
    complaints = _same("docs/architecture.md", there & set(re.findall(r"^- \*\*(\w+)\*\*", architecture, re.M)), there)
    figures = [re.search(r"^    form in UFL .*?(?=^\S|\Z)", text, re.M | re.S) for text in (readme, architecture)]
    if not all(figures) or figures[0][0].rstrip() != figures[1][0].rstrip():
        complaints.append("README.md and docs/architecture.md do not show the same figure")
    elif missing := sorted(name for name in there - {"state", "files"} if name not in figures[0][0]):
        complaints.append(f"README.md: the figure does not show {', '.join(missing)}")
    tests = re.search(r"^\| `tests/` \|(.*)\|$", readme, re.M)[1]
    folders = {path.name for path in (pathlib.Path(root) / "tests").iterdir() if any(path.glob("test_*.py"))} | {"unit"}
    return complaints + _same("README.md, tests/", re.findall(r"`(\w+)/`", tests), folders)


def methods(root):
    """Which problem takes which contact, in the table of methods, against the types of the argument `contact`."""
    taken = {}
    for word, (file, name) in PROBLEMS.items():
        tree = ast.parse(_page(root, f"python/dolfinx_impact/{file}"))
        (problem,) = (node for node in tree.body if isinstance(node, ast.ClassDef) and node.name == name)
        (init,) = (node for node in problem.body if getattr(node, "name", None) == "__init__")
        (contact,) = (a for a in (*init.args.args, *init.args.kwonlyargs) if a.arg == "contact")
        taken[word] = set(re.findall(r"\w+", ast.unparse(contact.annotation))) - {"Sequence"}
    page = _page(root, "docs/contact_theory.md").split("## Which method for which problem", 1)[1]
    columns = re.findall(r"`(\w+)`", page.split("\n\n")[1].split("\n")[0])
    cells = next(line for line in page.split("\n") if line.startswith("| problems |")).split("|")[2:-1]
    complaints = _same("docs/contact_theory.md, methods", columns, set().union(*taken.values()))
    for method, cell in zip(columns, cells):
        there = [word for word in PROBLEMS if method in taken[word]]
        complaints += _same(f"docs/contact_theory.md, {method}", [w for w in PROBLEMS if w in cell], there)
    return complaints


def kernels(root):
    """Kernels of J2 plasticity that come with the package, in the table of the page on plasticity."""
    law = {"linear": "linear", "voce": "`Voce`"}
    expected = set()
    for cell, degree, hypothesis, names in _constant(root, "PLASTIC", ["forms/registry.py"]):
        plural = {"hexahedron": "hexahedra", "tetrahedron": "tetrahedra"}.get(cell, f"{cell}s")
        strains = [
            ", ".join(law[name.partition(".")[2]] for name in names if name.startswith(strain))
            for strain in ("small", "finite")
        ]
        expected.add(" | ".join([f"{plural} of degree {degree}", hypothesis.replace("_", " "), *strains]))
    rows = _table(_page(root, "docs/plasticity.md"), "cells | hypothesis | small strain | finite strain")
    return _same("docs/plasticity.md", [" | ".join(row) for row in rows], expected)


def levels(root):
    """Levels of the verification report, in the order in which they are run."""
    there = _constant(root, "LEVELS", ["python/impact_verify/levels.py"])
    listed = [row[0] for row in _table(_page(root, "docs/verify.md"), "level | what is compared | tolerance")]
    complaints = _same("docs/verify.md", listed, there)
    return complaints or ([] if listed == list(there) else ["docs/verify.md: levels in another order"])


def commands(root):
    """Commands of `dolfinx-impact`, in the README."""
    there = set(_constant(root, "FORWARDED", ["python/dolfinx_impact/cli.py"]))
    there |= set(re.findall(r'add_parser\("(\w+)"', _page(root, "python/dolfinx_impact/cli.py")))
    block = _page(root, "README.md").split("## The command", 1)[1].split("## ", 1)[0]
    return _same("README.md, commands", re.findall(r"^    dolfinx-impact (\w+)", block, re.M), there)


def classes(root):
    """Classes and headers in the tables of the developer's guide, where the guide says that they are."""
    guide, cpp, complaints = _page(root, "docs/developer_guide.md"), pathlib.Path(root) / "cpp" / "dolfinx_impact", []
    python = "".join(path.read_text() for path in (pathlib.Path(root) / "python/dolfinx_impact/dynamics").glob("*.py"))
    for row in _table(guide, "class | does"):
        complaints += [
            f"docs/developer_guide.md: dynamics has no class {name}"
            for name in re.findall(r"`(\w+)`", row[0])
            if f"\nclass {name}" not in python
        ]
    for heading, folder in (
        ("class of C++ | does", ""),
        ("class of `search/node_tracker/` | owns", "search/node_tracker"),
    ):
        for row in _table(guide, heading):
            for name in re.findall(r"`([\w/]+)`", row[0]):
                # A second name of a row is in the folder of the first, or has its own.
                folder, name = name.rpartition("/")[0] or folder, name.rpartition("/")[2]
                headers = (cpp / folder).glob("*.h")
                if not any(h.stem == name or re.search(rf"\b{name}\b[^;]*{{", h.read_text()) for h in headers):
                    complaints.append(f"docs/developer_guide.md: {folder} has no {name}")
    return complaints


ALL = (demos, pages, stages, methods, kernels, levels, commands, classes)
