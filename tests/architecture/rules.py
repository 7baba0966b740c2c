# SPDX-License-Identifier: MIT
"""The rules of the tree as functions of a folder that return complaints, so that a broken tree can be shown to them."""

import ast
import os
import pathlib
import re
import subprocess
import sys

STAGES = (
    "kernels",
    "operators",
    "surface",
    "search",
    "gap",
    "enforcement",
    "solve",
    "integrators",
    "rolling",
    "problems",
)
# What no stage is: small tools; the state as data, which every stage may describe its own in; files of states.
BELOW = ("common", "state", "files")
# Rooms inside a stage, each after those it may include; "." are the files directly in the stage's folder.
ROOMS = {"search": (".", "closest_point", "node_tracker", "general")}
# Python packages and modules in the order of the data flow; docs/architecture.md has the same order.
PACKAGES = ("common", "compat", "materials", "inelastic", "plasticity", "amplitude", "assembly", "loads", "foundation")
PACKAGES += ("added_mass", "io", "theory")
PACKAGES += (
    "interface",
    "contact",
    "recording",
    "statics",
    "rolling",
    "dynamics",
    "own_forms",
    "compile",
    "verify",
    "cli",
)
# Packages beside it, with those of ours that each may import; the library has a door to the first and commands of both.
BESIDE = {
    "impact_verify": ("dolfinx_impact", "impact_reference"),
    "impact_studies": ("dolfinx_impact",),
}
DOORS = ("verify/__init__.py", "cli.py")  # of the library: inside functions, or for types
STUDIES = ("creep", "rail_joint", "bench")  # of impact_studies, in the order in which they may import each other
CXX = (".h", ".cpp")
SOURCES = (".h", ".cpp", ".py", ".cmake", ".txt", ".sh", "")  # "": Makefile, env/run
LONG = 400  # lines of a file that are worth a look
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]', re.MULTILINE)
STANDARD_HEADER = re.compile(r"[a-z_0-9]+$")  # <vector>, <cmath>: no folder, no suffix


def project_files(root):
    """Files of the project: what git knows or would take in, or, without git, all but what builds write."""
    root = pathlib.Path(root)
    command = ["git", "-c", "safe.directory=*", "-C", str(root), "ls-files", "-z", "-co", "--exclude-standard"]
    try:
        names = subprocess.run(command, capture_output=True, check=True).stdout.decode().split("\0")
    except (OSError, subprocess.CalledProcessError):
        left_out = {".git", "build", "results", "__pycache__", ".pytest_cache", ".hypothesis"}
        names = []
        for folder, folders, files in os.walk(root):
            folders[:] = [f for f in folders if f not in left_out]
            names += [os.path.relpath(os.path.join(folder, f), root) for f in files]
    return sorted(root / name for name in set(names) if name and (root / name).is_file())


# What a checkout has at its top: folders, then files. Whatever else lies there was left by a run.
TOP = {".ci", ".github", "conda", "cpp", "demos", "docs", "env", "forms", "meshes", "python", "tests"}
TOP |= {
    ".clang-format",
    ".clang-tidy",
    ".flake8",
    ".gitignore",
    ".pre-commit-config.yaml",
    "Makefile",
    "pyproject.toml",
}
TOP |= {"CHANGELOG.md", "CITATION.cff", "CONTRIBUTING.md", "LICENSE", "README.md"}


def top_violations(root):
    """Files and folders at the top of the project that are none of its parts."""
    return sorted({path.relative_to(root).parts[0] for path in project_files(root)} - TOP)


def text_of(path):
    """Content of a text file; None for a binary one."""
    data = path.read_bytes()
    return None if b"\0" in data else data.decode(errors="replace")


def sources(folder, suffixes):
    return sorted(p for p in pathlib.Path(folder).rglob("*") if p.suffix in suffixes and p.is_file())


def includes(path):
    """(is it in angle brackets, name) of every include."""
    return [(bracket == "<", name) for bracket, name in INCLUDE.findall(path.read_text())]


def _resolve(path, name, roots):
    """Where an include leads inside the project, or None."""
    for folder in (path.parent, *roots):
        target = (folder / name).resolve()
        if target.is_file():
            return target
    return None


def layer_violations(root):
    """Rule 1: a stage of cpp/dolfinx_impact includes itself, earlier stages, common, state and plain."""
    cpp = pathlib.Path(root).resolve() / "cpp"
    library = cpp / "dolfinx_impact"
    complaints = []
    for path in sources(library, CXX):
        stage = path.relative_to(library).parts[0]
        if stage not in STAGES + BELOW:
            complaints.append(f"{path.relative_to(cpp)}: not in the folder of a stage")
            continue
        earlier = BELOW[: BELOW.index(stage) + 1] if stage in BELOW else BELOW + STAGES[: STAGES.index(stage) + 1]
        allowed = {"plain", *earlier}
        for _, name in includes(path):
            target = _resolve(path, name, (cpp, library))
            if target and target.is_relative_to(library):
                where = target.relative_to(library).parts[0]
            elif target and target.is_relative_to(cpp):
                where = target.relative_to(cpp).parts[0]
            else:  # a header not in the tree: foreign, or made by the build
                parts = [p for p in pathlib.PurePosixPath(name).parts if p not in ("..", ".")]
                parts = parts[1:] if parts[0] == "dolfinx_impact" else parts
                where = parts[0] if len(parts) > 1 and parts[0] in STAGES + ("bindings", "reference") else None
            if where is not None and where not in allowed:
                complaints.append(f"{path.relative_to(cpp)}: {stage} must not include {name}")
    return complaints


def room_violations(root):
    """Rule 1 inside a stage: a room includes itself and the rooms before it."""
    library = pathlib.Path(root).resolve() / "cpp" / "dolfinx_impact"
    complaints = []
    for stage, rooms in ROOMS.items():
        for path in sources(library / stage, CXX):
            room = path.parent.relative_to(library / stage).as_posix()
            if room not in rooms:
                complaints.append(f"{path.relative_to(library)}: not in a room of {stage}")
                continue
            for _, name in includes(path):
                target = _resolve(path, name, (library.parent, library))
                if target is None or not target.is_relative_to(library / stage):
                    continue
                where = target.parent.relative_to(library / stage).as_posix()
                if where not in rooms[: rooms.index(room) + 1]:
                    complaints.append(f"{path.relative_to(library)}: {room} must not include {name}")
    return complaints


def package_violations(root):
    """Rule 1 for python/dolfinx_impact: a package or module imports itself and those that come before it."""
    base = pathlib.Path(root).resolve() / "python" / "dolfinx_impact"
    last = len(PACKAGES)
    complaints = []
    for path in sources(base, (".py",)):
        parts = path.relative_to(base).with_suffix("").parts
        if parts == ("__init__",):  # the whole package is put together here
            continue
        if parts[0] not in PACKAGES:
            complaints.append(f"{path.relative_to(root)}: {parts[0]} has no place in the order of the packages")
            continue
        here = PACKAGES.index(parts[0])
        for node in ast.walk(ast.parse(path.read_text(), str(path))):
            if not isinstance(node, ast.ImportFrom) or node.level < len(parts):
                continue
            names = [node.module.split(".")[0]] if node.module else [alias.name for alias in node.names]
            for name in names:
                unlisted = any((base / name).glob("*.py"))  # _cpp has the stub of the compiled module only
                if (PACKAGES.index(name) if name in PACKAGES else last if unlisted else -1) > here:
                    complaints.append(f"{path.relative_to(root)}:{node.lineno}: {parts[0]} must not import {name}")
    return complaints


def _late_lines(tree):
    """Lines inside functions and under `if TYPE_CHECKING`: importing the file does not run what stands there."""
    lines = set()
    for node in ast.walk(tree):
        typing = isinstance(node, ast.If) and getattr(node.test, "id", None) == "TYPE_CHECKING"
        if typing or isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
            lines.update(line for part in node.body for line in range(part.lineno, part.end_lineno + 1))
    return lines


def beside_violations(root):
    """Rule 2 for the packages beside the library: what they import, and where the library may import them."""
    base = pathlib.Path(root).resolve() / "python"
    ours = {"dolfinx_impact", "impact_reference", *BESIDE}
    complaints = []
    for path in sources(base / "dolfinx_impact", (".py",)):
        name = path.relative_to(base / "dolfinx_impact").as_posix()
        late = _late_lines(ast.parse(path.read_text(), str(path))) if name in DOORS else set()
        for line, module in imported_modules(path):
            other = module.split(".")[0]
            if other in ours - {"dolfinx_impact"} and (other not in BESIDE or line not in late):
                complaints.append(f"{path.relative_to(root)}:{line}: the library imports {module}")
    for package, allowed in BESIDE.items():
        for path in sources(base / package, (".py",)):
            for line, module in imported_modules(path):
                parts = module.split(".")
                behind_door = parts[0] == "dolfinx_impact" and parts[1:2] in (["verify"], ["cli"])
                if behind_door or (parts[0] in ours and parts[0] not in (package, *allowed)):
                    complaints.append(f"{path.relative_to(root)}:{line}: {package} imports {module}")
    return complaints + _study_violations(base / "impact_studies", root)


def _study_violations(base, root):
    """Studies that import one that comes after them."""
    complaints = []
    for name, (path, _) in (modules := _modules(base.parent, base.name)).items():
        here = name.split(".")[1:2]
        if not here:
            continue
        if here[0] not in STUDIES:
            complaints.append(f"{path.relative_to(root)}: {here[0]} has no place in the order of the studies")
            continue
        for other in sorted(_imports(name, modules)):
            study = other.split(".")[1]
            if study in STUDIES and STUDIES.index(study) > STUDIES.index(here[0]):
                complaints.append(f"{path.relative_to(root)}: {here[0]} must not import {study}")
    return complaints


def _modules(base, package):
    """Modules of a package by dotted name, with their syntax trees; a package is its __init__."""
    found = {}
    for path in sources(base / package, (".py",)):
        parts = path.relative_to(base).with_suffix("").parts
        name = ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
        found[name] = path, ast.parse(path.read_text(), str(path))
    return found


def _imports(name, modules):
    """Modules that a module imports names of or from, wherever the import stands."""
    path, tree = modules[name]
    parts = name.split(".") + ["__init__"] * (path.name == "__init__.py")
    found = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            found.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            source = [*(parts[: -node.level] if node.level else []), *(node.module.split(".") if node.module else [])]
            for alias in node.names:
                inside = ".".join([*source, alias.name])
                if inside in modules:
                    found.add(inside)
                elif len(source) > 1:  # of the whole package: what is compiled, or installed beside it
                    found.add(".".join(source))
    return (found & set(modules)) - {name}


def import_circles(root):
    """Modules of the Python packages that lead back to themselves by imports, those for types and inside functions
    included: they can be read only all at once.
    """
    base = pathlib.Path(root).resolve() / "python"
    modules = {}
    for package in ("dolfinx_impact", "impact_reference", *BESIDE):
        modules |= _modules(base, package)
    imported = {name: _imports(name, modules) for name in modules}
    reached = {}
    for name in modules:
        reached[name], left = set(), list(imported[name])
        while left:
            other = left.pop()
            if other not in reached[name]:
                reached[name].add(other)
                left += imported[other]
    circles = {
        tuple(sorted(other for other in reached[name] if name in reached[other]))
        for name in modules
        if name in reached[name]
    }
    return [f"{', '.join(circle)}: import each other" for circle in sorted(circles)]


def reference_violations(root):
    """Rule 2 by includes and imports: what the hand-written solver may see."""
    root = pathlib.Path(root).resolve()
    reference, plain = root / "cpp" / "reference", root / "cpp" / "plain"
    complaints = []
    for path in sources(reference, CXX):
        binding = path.stem in ("module", "bindings") or path.stem.startswith("bind_")
        for angle, name in includes(path):
            target = _resolve(path, name, (root / "cpp", reference))
            own = target is not None and (target.is_relative_to(reference) or target.is_relative_to(plain))
            foreign = angle and (STANDARD_HEADER.match(name) or name.startswith("Eigen/"))
            if not (own or foreign or (binding and angle and name.startswith("nanobind/"))):
                complaints.append(f"{path.relative_to(root)}: includes {name}")
    for path in sources(plain, CXX):
        for angle, name in includes(path):
            own = (path.parent / name).is_file() or name.startswith("plain/")
            if not own and not (angle and STANDARD_HEADER.match(name)):
                complaints.append(f"{path.relative_to(root)}: includes {name}")
    recipe = reference / "CMakeLists.txt"
    precompiled = re.findall(r"<([\w./]+)>", recipe.read_text()) if recipe.is_file() else []
    for name in precompiled:
        if not (STANDARD_HEADER.match(name) or name.startswith(("Eigen/", "nanobind/"))):
            complaints.append(f"cpp/reference/CMakeLists.txt: precompiles {name}")
    allowed = {"numpy", "impact_reference", "__future__"} | set(sys.stdlib_module_names)
    return complaints + import_violations(root / "python" / "impact_reference", allowed, root)


def forms_violations(root):
    """forms/ speaks UFL: ufl, basix.ufl and numpy besides itself and the standard library; forms/compiler is free."""
    root = pathlib.Path(root).resolve()
    allowed = {"ufl", "basix.ufl", "numpy"} | set(sys.stdlib_module_names)
    return import_violations(root / "forms", allowed, root, left_out="compiler")


# The files that may ask for a release of DOLFINx, UFL, Basix or FFCx, or use what only some releases have.
RELEASE_LAYERS = ("python/dolfinx_impact/compat.py", "forms/compiler/integrands.py")
RELEASE_LAYERS_CPP = tuple(f"cpp/dolfinx_impact/common/{name}.h" for name in ("dolfinx_api", "create_functionspace"))
RELEASE_LAYERS_CPP += ("cpp/bindings/casters.h",)
# Names that only some releases have, or that are properties in one and functions in another, and where they are
# looked for: in any object but the module compat; in `geometry`; in the modules named.
OF_RELEASES = ("gmshio", "cellname", "geometric_dimension", "topological_dimension", "interpolation_points")
OF_RELEASES += ("create_cell_partitioner", "adjacencylist", "compute_integration_domains", "compile_ufl_objects")
OF_RELEASES += ("LinearProblem", "NonlinearProblem", "NewtonSolverNonlinearProblem", "NewtonSolver")
OF_GEOMETRY = ("cmap", "cmaps", "dofmap", "dofmaps")
OF_MODULES = {"io": ("gmsh",), "petsc": ("create_vector",), "la": ("create_petsc_vector",)}
LIBRARIES = ("dolfinx", "ufl", "basix", "ffcx")
_PAGE_SPELLING = re.compile(
    r"\.geometry\.(?:cmap|dofmap)s?\b|\bgmshio\b|(?<!compat)\.(?:interpolation_points|cellname|geometric_dimension)\b"
)
# The last one of a C++ file is a view in 0.9 and a copy in later releases.
_CPP_SPELLINGS = re.compile(
    r"dolfinx::MPI::mpi_(?:type|t)\b|\bmutable_array\(|(?:\.|->)cmaps?\(\)|geometry(?:\(\))?\.dofmaps?\(|"
    r"(?:\.|->)value_shape\(\)|(?:\.|->)collapse\(\)|sparsitybuild|(?:\.|->)set\(0|"
    r"(?:\.|->)array\(\)\.(?:first|last|subspan)|"
    r"fem::create_functionspace\(|DOLFINX_VERSION|caster_(?:mpi|petsc)\.h|auto&?&? \w+ = [^;\n]*(?:\.|->)array\(\);"
)


def release_violations(root):
    """What asks for a release of DOLFINx, or is spelt in a way that some releases do not know, outside the layers."""
    root = pathlib.Path(root).resolve()
    complaints = []
    for folder in ("python", "forms", "meshes", "demos", "tests", "docs"):
        for path in sources(root / folder, (".py",)):
            name = path.relative_to(root).as_posix()
            if name not in RELEASE_LAYERS:
                tree = ast.parse(path.read_text(), str(path))
                found = {(node.lineno, what) for node in ast.walk(tree) for what in _of_a_release(node)}
                complaints += [f"{name}:{line}: {what} is not the same in all releases" for line, what in sorted(found)]
    for folder in ("cpp/dolfinx_impact", "cpp/bindings", "tests/cpp", "demos/cpp"):
        for path in sources(root / folder, (".h", ".cpp")):
            name = path.relative_to(root).as_posix()
            for number, line in enumerate(path.read_text().splitlines() if name not in RELEASE_LAYERS_CPP else (), 1):
                for match in _CPP_SPELLINGS.finditer(line):
                    complaints.append(f"{name}:{number}: {match[0]} is not the same in all releases")
    for path in sources(root / "docs", (".md",)):
        for number, line in enumerate(path.read_text().splitlines(), 1):
            for match in _PAGE_SPELLING.finditer(line):
                where = f"{path.relative_to(root).as_posix()}:{number}"
                complaints.append(f"{where}: {match[0]} is not the same in all releases")
    return complaints


def mpi_later(root):
    """Demos and blocks of pages that import dolfinx before mpi4py's MPI: DOLFINx of a wheel does not find MPI then."""
    root = pathlib.Path(root).resolve()
    complaints = []
    for path in [root / "README.md", *sources(root / "docs", (".md",)), *sources(root / "demos", (".py",))]:
        text = path.read_text() if path.is_file() else ""
        for block in re.split(r"^```.*$", text, flags=re.M) if path.suffix == ".md" else [text]:
            first = re.search(r"^(?:from|import) dolfinx\b", block, re.M)
            if first and "\nfrom mpi4py import MPI\n" in block[first.start() :]:
                complaints.append(f"{path.relative_to(root).as_posix()}: dolfinx is imported before mpi4py's MPI")
    return complaints


def _last_name(node):
    """Name of a variable, or last part of a dotted one."""
    return getattr(node, "attr", getattr(node, "id", None))


def _of_a_release(node):
    """What a node of a syntax tree has that is not the same in all releases."""
    if isinstance(node, ast.Attribute):
        base = _last_name(node.value)
        if node.attr == "__version__" and base in LIBRARIES:
            yield f"{base}.__version__"
        elif node.attr in OF_RELEASES and base != "compat":
            yield node.attr
        elif node.attr == "integrand" and base == "ir":
            yield "FFCx's ir.integrand"
        elif node.attr in OF_GEOMETRY and base == "geometry":
            yield f"geometry.{node.attr}"
        elif node.attr in OF_MODULES.get(base, ()):
            yield f"{base}.{node.attr}"
    elif isinstance(node, (ast.Import, ast.ImportFrom)):
        module = getattr(node, "module", None)
        for alias in node.names:
            parts = [*((module or "").split(".") if module else ()), *alias.name.split(".")]
            if parts[0] in LIBRARIES and getattr(node, "level", 0) == 0:
                yield from (part for part in parts if part in OF_RELEASES or part == "__version__")
                yield from (f"{a}.{b}" for a, b in zip(parts, parts[1:]) if b in OF_MODULES.get(a, ()))
    elif isinstance(node, ast.Call):
        yield from _of_a_release_in_call(node)
    elif isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Tuple):
        called = isinstance(node.value, ast.Call) and getattr(node.value.func, "attr", None) == "collapse"
        used = [name.id for name in node.targets[0].elts[1:] if isinstance(name, ast.Name) and name.id[0] != "_"]
        if called and used and _last_name(node.value.func.value) != "compat":
            yield "the map of collapse()"
    elif isinstance(node, ast.Subscript) and isinstance(node.value, ast.Call):
        func, index = node.value.func, getattr(node.slice, "value", None)
        if getattr(func, "attr", None) == "collapse" and index != 0 and _last_name(func.value) != "compat":
            yield "the map of collapse()"


def _of_a_release_in_call(node):
    """The same of a call: a library's version, arguments by place, looking whether an object has a name."""
    name, texts = _last_name(node.func), [a.value for a in node.args if isinstance(a, ast.Constant)]
    if name in ("hasattr", "getattr"):
        yield from (text for text in texts if text in OF_RELEASES + OF_GEOMETRY)
        if "__version__" in texts and _last_name(node.args[0]) in LIBRARIES:
            yield "__version__"
    elif name == "version" and any(str(text).startswith(("fenics", "dolfinx-", *LIBRARIES[1:])) for text in texts):
        yield f"the version of {texts[0]}"
    elif name == "create_mesh" and len(node.args) > 2:
        yield "the order of create_mesh's arguments"
    elif name == "IndexMap" and len(node.args) > 2:
        yield "IndexMap with ghosts"
    elif name == "assemble_matrix":
        yield from (f"assemble_matrix({key.arg}=)" for key in node.keywords if key.arg in ("diagonal", "diag"))


def imported_modules(path):
    """Absolute imports of a file, anywhere in it, with their line."""
    for node in ast.walk(ast.parse(path.read_text(), str(path))):
        if isinstance(node, ast.Import):
            yield from ((node.lineno, alias.name) for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            # `from basix import ufl` and `from basix.ufl import element` both mean basix.ufl
            yield from ((node.lineno, f"{node.module}.{alias.name}") for alias in node.names)
        elif isinstance(node, ast.Call) and getattr(node.func, "id", getattr(node.func, "attr", "")) in (
            "__import__",
            "import_module",
        ):
            yield node.lineno, node.args[0].value if isinstance(node.args[0], ast.Constant) else "(computed)"


def import_violations(folder, allowed, root, left_out=None):
    complaints = []
    for path in sources(folder, (".py",)):
        if left_out and path.is_relative_to(folder / left_out):
            continue
        for line, module in imported_modules(path):
            if not any(module == a or module.startswith(a + ".") for a in allowed):
                complaints.append(f"{path.relative_to(root)}:{line}: imports {module}")
    return complaints


def unsafe_flags(root):
    """Compiler flags that break NaN checks and complementarity tests.

    The benchmark's second baseline compiles DOLFINx's kernel with one of them, on purpose: its bench/setup.py may.
    """
    flags = ("-f" + "fast-math", "-O" + "fast", "-f" + "finite-math-only", "-f" + "associative-math")
    complaints = []
    for path in project_files(root):
        if path.relative_to(root).as_posix() == "python/impact_studies/bench/setup.py":
            continue
        builds = path.suffix in (".cmake", ".json", ".toml", ".sh", ".py", "") or path.name == "CMakeLists.txt"
        text = text_of(path) if builds else None
        for number, line in enumerate((text or "").splitlines(), 1):
            code = line.partition("#")[0]
            complaints += [f"{path.relative_to(root)}:{number}: {flag}" for flag in flags if flag in code]
    return complaints


def plain_forms(root):
    """Forms of the package that are not compiled by assembly/ffcx_form.py, which mends what killed processes leave."""
    complaints = []
    for path in sources(pathlib.Path(root) / "python", (".py",)):
        for number, line in enumerate(path.read_text().splitlines(), 1):
            if re.search(r"\bfem\.form\(", line) and path.name != "ffcx_form.py":
                complaints.append(f"{path.relative_to(root)}:{number}: {line.strip()}")
    return complaints


def unfinished_headers(root):
    """Words that mark unfinished work, in headers a user includes."""
    words = re.compile(r"\b(TO" + r"DO|FIX" + r"ME|XX" + r"X)\b")
    complaints = []
    for path in sources(pathlib.Path(root) / "cpp", (".h",)):
        for number, line in enumerate(path.read_text().splitlines(), 1):
            if words.search(line):
                complaints.append(f"{path.relative_to(root)}:{number}: {line.strip()}")
    return complaints


def line_counts(root):
    """Number of lines of every source file."""
    files = [p for p in project_files(root) if p.suffix in SOURCES and p.suffix != ".txt" or p.name == "CMakeLists.txt"]
    files = [p for p in files if p.name not in ("LICENSE",)]
    return {p.relative_to(root): len(text.splitlines()) for p in files if (text := text_of(p)) is not None}


# Folders of tests/unit beside those of the packages and the stages: of what lies beside python/ and cpp/.
UNIT_BESIDE = {
    "forms": "the physics in UFL, forms/",
    "forms/compiler": "from UFL to C++, forms/compiler/",
    "meshes": "recipes and committed meshes, meshes/",
    "env": "how a machine gets its environment, env/",
}
# Packages whose tests are no unit tests of a folder of their own.
TESTED_ELSEWHERE = {
    "own_forms": "tests/cross, with the checks that take such forms",
    "verify": "tests/cross, with the solver that it compares with",
}


def unit_folder_violations(root):
    """Folders of tests/unit whose name is not where the tested code is, packages without a folder, names used twice."""
    root = pathlib.Path(root).resolve()
    unit, library = root / "tests" / "unit", root / "cpp" / "dolfinx_impact"
    packages = [path for path in (root / "python").glob("*") if path.is_dir()]
    folders, complaints, known = set(), [], {}
    for path in sources(unit, (".py",)):
        if path.name != "conftest.py" and path.name in known:
            complaints.append(f"{path.relative_to(root)}: {known[path.name].relative_to(root)} has this name, too")
        known[path.name] = path
        folders.add(path.parent.relative_to(unit).as_posix())
    for name in sorted(folders - set(UNIT_BESIDE)):
        python = any((package / name).is_dir() or (package / f"{name}.py").is_file() for package in packages)
        if not python and not (library / name).is_dir():
            complaints.append(f"tests/unit/{name}: neither a package, a module nor a stage has this name")
    for path in sorted((root / "python" / "dolfinx_impact").rglob("__init__.py")):
        name = path.parent.relative_to(root / "python" / "dolfinx_impact").as_posix()
        if name != "." and name.partition("/")[0] not in TESTED_ELSEWHERE and name not in folders:
            complaints.append(f"python/dolfinx_impact/{name}: no folder of tests/unit has the name of this package")
    return complaints


_FIRST_SENTENCE = re.compile(r"(.*?\.)(?:\s|$)")


def _docstring(node):
    return " ".join((ast.get_docstring(node) or "").split())


def _methods(cls):
    """Methods and properties of a class by name, without setters."""
    found = {}
    for node in cls.body:
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
            found.setdefault(node.name, node)  # the setter of a property comes after it
    return found


def _is_protocol(cls):
    return any("Protocol" in ast.unparse(base) for base in cls.bases)


def _package(path, root):
    """Package that a module is installed in; forms/ and meshes/ are parts of dolfinx_impact."""
    parts = path.relative_to(root).parts
    return parts[1] if parts[0] == "python" else "dolfinx_impact"


def _bases(path, cls, classes, root):
    """Base classes of a class and theirs, with their files, as far as they are in the tree."""
    for base in cls.bases:
        name = ast.unparse(base).split("[")[0].split(".")[-1]
        known = classes.get(name, [])
        here = [c for c in known if c[0] == path] or [c for c in known if _package(c[0], root) == _package(path, root)]
        for one in here or known:
            if one[1] is not cls:
                yield one
                yield from _bases(*one, classes, root)


def unnamed_classes(root):
    """Classes with methods that no test names. Protocols have no code; records of values have no methods."""
    root = pathlib.Path(root).resolve()
    words = {word for path in sources(root / "tests", (".py",)) for word in re.findall(r"\w+", path.read_text())}
    complaints = []
    for folder in ("python", "forms", "meshes"):
        for path in sources(root / folder, (".py",)):
            for node in ast.parse(path.read_text(), str(path)).body:
                if isinstance(node, ast.ClassDef) and not _is_protocol(node) and _methods(node):
                    if node.name not in words:
                        complaints.append(f"{path.relative_to(root)}:{node.lineno}: no test names {node.name}")
    return complaints


def repeated_docstrings(root):
    """Methods that say once more what the method of a base class or of a protocol says: a docstring that has its first
    sentence. An override says what is particular to it; where nothing is, it has no docstring, and help() and the site
    show that of the base. Of a protocol, which classes need not derive from, methods of the same name count.
    """
    root = pathlib.Path(root).resolve()
    classes = {}
    for folder in ("python", "forms", "meshes"):
        for path in sources(root / folder, (".py",)):
            for node in ast.parse(path.read_text(), str(path)).body:
                if isinstance(node, ast.ClassDef):
                    classes.setdefault(node.name, []).append((path, node))
    every = [one for group in classes.values() for one in group]
    protocols = [(path, cls) for path, cls in every if _is_protocol(cls)]
    complaints = []
    for path, cls in every:
        asked = [(p, c) for p, c in protocols if _package(p, root) == _package(path, root) and c is not cls]
        above = [*_bases(path, cls, classes, root), *([] if _is_protocol(cls) else asked)]
        for name, node in _methods(cls).items():
            own = _docstring(node)
            for _, base in above:
                said = _FIRST_SENTENCE.match(_docstring(_methods(base)[name])) if name in _methods(base) else None
                if said and said[1] in own:
                    where = f"{path.relative_to(root)}:{node.lineno}"
                    complaints.append(f"{where}: {cls.name}.{name} says what {base.name}.{name} says")
                    break
    return complaints


_COMMENTED = re.compile(r"((?:^[ \t]*///.*\n)+)([^;{}]*[;{])", re.MULTILINE)


def repeated_comments(root):
    """The same for C++: overrides whose comment has the first sentence of that of a virtual function of this name."""
    root = pathlib.Path(root).resolve()
    virtual, overrides = {}, []
    for path in sources(root / "cpp" / "dolfinx_impact", (".h",)):
        text = path.read_text()
        for match in _COMMENTED.finditer(text):
            comment, declaration = " ".join(match[1].replace("///", " ").split()), match[2]
            name = re.search(r"(\w+)\s*\(", declaration)
            if name and re.search(r"\boverride\b", declaration):
                overrides.append(
                    (f"{path.relative_to(root)}:{text.count(chr(10), 0, match.start()) + 1}", name[1], comment)
                )
            elif name and re.search(r"\bvirtual\b", declaration) and (said := _FIRST_SENTENCE.match(comment)):
                virtual.setdefault(name[1], []).append(said[1])
    return [
        f"{where}: the comment of {name} is that of the base"
        for where, name, comment in overrides
        if any(said in comment for said in virtual.get(name, ()))
    ]


LONGEST = 120  # characters of a line of a page; rows of tables are one line each, however long


def long_lines(root):
    """Lines of Markdown pages beyond column 120, tables left out."""
    complaints = []
    for path in project_files(root):
        if path.suffix == ".md":
            for number, line in enumerate(path.read_text().splitlines(), 1):
                if len(line) > LONGEST and not line.startswith("|"):
                    complaints.append(f"{path.relative_to(root)}:{number}: {len(line)} characters")
    return complaints


PAGE = re.compile(r"(?<![\w/])docs/[\w/]+\.md")


def missing_pages(root):
    """Pages of docs/ that a file names and that do not exist."""
    complaints = []
    for path in project_files(root):
        if path.relative_to(root).as_posix() == "tests/architecture/test_rules_complain.py":
            continue
        for number, line in enumerate((text_of(path) or "").splitlines(), 1):
            for name in PAGE.findall(line):
                if not (pathlib.Path(root) / name).is_file():
                    complaints.append(f"{path.relative_to(root)}:{number}: {name} does not exist")
    return complaints


def machine_paths(root):
    """Folders and hosts that exist on somebody's machine only."""
    folders = ("/wo" + "rk/", "/ro" + "ot/", "/home/" + r"\w", "/Us" + "ers/")
    hosts = (
        "deb.debian" + r"\.org",
        "py" + r"pi\.org",
        "pythonhosted" + r"\.org",
        "anaconda" + r"\.org",
        "gh" + r"cr\.io",
    )
    # A word before a folder makes it part of something else: build/root/x, $HOME/work/x.
    pattern = re.compile(r"(?<![\w.$}\"'*-])(?:" + "|".join(folders) + r")|[\"'](?:" + "|".join(folders[:2]) + ")")
    host = re.compile("|".join(hosts))
    complaints = []
    for path in project_files(root):
        for number, line in enumerate((text_of(path) or "").splitlines(), 1):
            if pattern.search(line) or host.search(line):
                complaints.append(f"{path.relative_to(root)}:{number}: {line.strip()[:100]}")
    return complaints


def versions(root):
    """The version as each file states it; only files that exist."""
    root = pathlib.Path(root)
    patterns = {
        "pyproject.toml": r'^version = "([^"]+)"',
        "CITATION.cff": r"^version: \"?([0-9][^\s\"]*)",
        "CHANGELOG.md": r"^## \[?v?([0-9]+\.[0-9]+\.[0-9]+)",
        "python/dolfinx_impact/__init__.py": r'^__version__ = "([^"]+)"',
        "python/impact_reference/__init__.py": r'^__version__ = "([^"]+)"',
    }
    found = {}
    for name, pattern in patterns.items():
        if (root / name).is_file():
            match = re.search(pattern, (root / name).read_text(), re.MULTILINE)
            if match:
                found[name] = match.group(1)
    return found


def demos_without_assert(root):
    """Demos and applications whose last statement asserts nothing. Models and figures are in folders below."""
    folder, complaints = pathlib.Path(root) / "demos", []
    for path in sorted(folder.glob("*.py")) + sorted(folder.glob("applications/*.py")):
        if path.name == "__init__.py":
            continue
        body = ast.parse(path.read_text(), str(path)).body
        if not body or not isinstance(body[-1], ast.Assert) or isinstance(body[-1].test, ast.Constant):
            complaints.append(f"{path.relative_to(root)}: the last statement is no assert")
    return complaints


def unused_bindings(root):
    """Names of the compiled module, by its stub, that no Python file has: neither the packages nor a test calls them.
    Classes are types of what is returned; members of Options and Limits are settings, which a user may change.
    """
    root = pathlib.Path(root)
    stub = root / "python" / "dolfinx_impact" / "_cpp"
    words = set()
    for folder in ("python", "tests", "demos", "docs"):
        for path in sources(root / folder, (".py",)):
            words |= set(re.findall(r"\w+", path.read_text()))

    def unused(body, owner):
        for node in body:
            if isinstance(node, ast.ClassDef):
                if not node.name.endswith(("Options", "Limits")):
                    yield from unused(node.body, f"{owner}.{node.name}")
            elif isinstance(node, ast.FunctionDef) and not node.name.startswith("__") and node.name not in words:
                yield f"{owner}.{node.name}"

    found = set()
    for path in sorted(stub.glob("*.pyi")):
        found |= set(unused(ast.parse(path.read_text()).body, path.stem))
    return sorted(found)
