# SPDX-License-Identifier: MIT
"""A rule that cannot complain proves nothing: each is shown a tree that breaks it, and one that does not."""

import pytest
import rules


@pytest.fixture
def tree(tmp_path):
    def write(files):
        for name, text in files.items():
            path = tmp_path / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text)
        return tmp_path

    return write


GOOD_LAYERS = {
    "cpp/plain/Mesh.h": "#include <vector>\n",
    "cpp/dolfinx_impact/common/mpi.h": "#include <mpi.h>\n",
    "cpp/dolfinx_impact/kernels/Kernel.h": '#include "../common/mpi.h"\n#include <plain/Mesh.h>\n',
    "cpp/dolfinx_impact/gap/update.h": '#include "../surface/normals.h"\n#include <dolfinx/mesh/Mesh.h>\n',
    "cpp/dolfinx_impact/surface/normals.h": "#include <dolfinx_impact/kernels/Kernel.h>\n",
    "cpp/reference/element.h": '#include "plain/Mesh.h"\n#include <Eigen/Dense>\n',
}


def test_layers_pass_a_good_tree(tree):
    root = tree(GOOD_LAYERS)
    assert rules.layer_violations(root) == [] and rules.reference_violations(root) == []


@pytest.mark.parametrize(
    "name, include",
    [
        ("surface/normals.h", '"../gap/update.h"'),  # a later stage, by a relative path
        ("kernels/Kernel.h", "<dolfinx_impact/gap/update.h>"),  # by the installed name
        ("kernels/Kernel.h", '"gap/made_by_the_build.h"'),  # a file that is not in the tree
        ("common/mpi.h", '"../kernels/Kernel.h"'),  # common stands before all stages
        ("gap/update.h", '"reference/element.h"'),  # the other solver
        ("gap/update.h", '"../../bindings/module.h"'),
        ("misc/helpers.h", "<vector>"),  # a folder that is no stage
    ],
)
def test_layers_complain(tree, name, include):
    root = tree({**GOOD_LAYERS, f"cpp/dolfinx_impact/{name}": f"#include {include}\n"})
    (complaint,) = rules.layer_violations(root)
    assert name in complaint


GOOD_IMPORTS = {
    "__init__.py": "from .io.folder import Folder\nfrom .loads import Load\n",
    "io/__init__.py": "",
    "io/folder.py": "from .. import _cpp\nfrom . import files\nfrom .frames import Frames\n",
    "io/frames.py": "def write():\n    from .files import File\n",
    "io/files.py": "import os\n",
    "loads.py": "from .io.folder import Folder\nfrom .contact import Pair\n",
    "contact/__init__.py": "from .pair import Pair\n",
    "contact/pair.py": "from dolfinx_impact.io import files\n",
}


def python_files(files):
    return {f"python/dolfinx_impact/{name}": text for name, text in files.items()}


def test_circles_pass_a_good_tree(tree):
    assert rules.import_circles(tree(python_files(GOOD_IMPORTS))) == []


@pytest.mark.parametrize(
    "name, text, circle",
    [
        ("io/files.py", "from .frames import Frames\n", ["io.files", "io.frames"]),
        ("io/frames.py", "if TYPE_CHECKING:\n    from .folder import Folder\n", ["io.folder", "io.frames"]),
        ("io/frames.py", "def write():\n    from .folder import Folder\n", ["io.folder", "io.frames"]),
        ("io/frames.py", "from ..loads import Load\n", ["io.folder", "io.frames", "loads"]),
        ("io/files.py", "from ..contact import Pair\n", ["contact", "contact.pair", "io.files"]),
        ("io/files.py", "import dolfinx_impact.contact.pair\n", ["contact.pair", "io.files"]),
        (
            "io/files.py",
            "from dolfinx_impact import Folder, loads\n",
            ["contact", "contact.pair", "io.files", "io.folder", "io.frames", "loads"],
        ),
    ],
)
def test_circles_complain(tree, name, text, circle):
    (complaint,) = rules.import_circles(tree(python_files({**GOOD_IMPORTS, name: text})))
    assert complaint == ", ".join(f"dolfinx_impact.{module}" for module in circle) + ": import each other"


GOOD_PACKAGES = {
    "__init__.py": "from .dynamics.explicit import ExplicitProblem\n",
    "contact/mortar/lagrange.py": "from ... import _cpp\nfrom ..pair import ContactPair\nfrom ...loads import tag\n",
    "dynamics/explicit.py": "from .. import forms\nfrom ..contact import ContactPair\nfrom .restart import Restart\n",
}


def test_packages_pass_a_good_tree(tree):
    root = tree({f"python/dolfinx_impact/{name}": text for name, text in GOOD_PACKAGES.items()})
    assert rules.package_violations(root) == []


@pytest.mark.parametrize(
    "name, line",
    [
        ("contact/pair.py", "from ..statics.load_steps import Report"),
        ("contact/pair.py", "def late():\n    from ..dynamics import explicit"),
        ("materials.py", "from .assembly import jit"),
        ("loads.py", "from . import io"),
        ("misc/helpers.py", "import numpy"),  # a package that has no place
    ],
)
def test_packages_complain(tree, name, line):
    files = {**GOOD_PACKAGES, "io/__init__.py": "", name: line + "\n"}
    root = tree({f"python/dolfinx_impact/{n}": text for n, text in files.items()})
    (complaint,) = rules.package_violations(root)
    assert name in complaint


GOOD_BESIDE = {
    "dolfinx_impact/__init__.py": "from . import verify\n",
    "dolfinx_impact/verify/__init__.py": "if TYPE_CHECKING:\n    from impact_verify import OwnForm\n",
    "dolfinx_impact/cli.py": "def main():\n    from impact_studies.creep.run import main\n",
    "impact_reference/__init__.py": "import numpy\n",
    "impact_verify/__init__.py": "def check():\n    from .run import check\n",
    "impact_verify/run.py": "import impact_reference\nfrom dolfinx_impact.verify_all import x\n",
    "impact_studies/__init__.py": "",
    "impact_studies/creep/run.py": "from dolfinx_impact import statics\n",
    "impact_studies/bench/rolling.py": "from ..creep.run import main\n",
}


def test_packages_beside_pass_a_good_tree(tree):
    root = tree({f"python/{name}": text for name, text in GOOD_BESIDE.items()})
    assert rules.beside_violations(root) == [] and rules.import_circles(root) == []


@pytest.mark.parametrize(
    "name, text",
    [
        ("dolfinx_impact/__init__.py", "import impact_verify"),
        ("dolfinx_impact/verify/__init__.py", "from impact_verify import OwnForm"),  # not late
        ("dolfinx_impact/cli.py", "from impact_studies.creep.run import main"),
        ("dolfinx_impact/cli.py", "def main():\n    import impact_reference"),
        ("dolfinx_impact/statics/problem.py", "def late():\n    from impact_verify import nodes"),
        ("impact_verify/run.py", "from impact_studies import bench"),
        ("impact_verify/run.py", "from dolfinx_impact.verify import OwnForm"),
        ("impact_verify/run.py", "from dolfinx_impact import cli"),
        ("impact_studies/creep/run.py", "import impact_reference"),
        ("impact_studies/creep/run.py", "def late():\n    from impact_verify import bodies"),
        ("impact_studies/creep/run.py", "from ..bench import rolling"),
        ("impact_studies/misc/run.py", "import numpy"),  # a study that has no place
    ],
)
def test_packages_beside_complain(tree, name, text):
    root = tree({f"python/{n}": t for n, t in {**GOOD_BESIDE, name: text + "\n"}.items()})
    (complaint,) = rules.beside_violations(root)
    assert name in complaint


@pytest.mark.parametrize("package", ["impact_verify", "impact_studies"])
def test_circles_are_found_in_packages_beside_the_library(tree, package):
    root = tree({f"python/{package}/{a}.py": f"from . import {b}\n" for a, b in ("xy", "yx")})
    assert rules.import_circles(root) == [f"{package}.x, {package}.y: import each other"]


GOOD_ROOMS = {
    "BoxTree.h": "#include <vector>\n",
    "Exchange.h": '#include "BoxTree.h"\n',
    "closest_point/SurfaceSearch.h": '#include "../BoxTree.h"\n#include "../../surface/Facets.h"\n',
    "node_tracker/NodeTracker.h": '#include "../closest_point/SurfaceSearch.h"\n#include "../Exchange.h"\n',
}


def test_rooms_pass_a_good_tree(tree):
    root = tree({f"cpp/dolfinx_impact/search/{name}": text for name, text in GOOD_ROOMS.items()})
    assert rules.room_violations(root) == []


@pytest.mark.parametrize(
    "name, include",
    [
        ("closest_point/edges.h", '"../node_tracker/NodeTracker.h"'),
        ("closest_point/edges.h", "<dolfinx_impact/search/node_tracker/NodeTracker.h>"),  # by the installed name
        ("Exchange.h", '"node_tracker/NodeTracker.h"'),
        ("pairs.cpp", '"closest_point/SurfaceSearch.h"'),
        ("elsewhere/file.h", "<vector>"),  # a folder that is no room
    ],
)
def test_rooms_complain(tree, name, include):
    files = {**GOOD_ROOMS, name: f"#include {include}\n"}
    (complaint,) = rules.room_violations(tree({f"cpp/dolfinx_impact/search/{n}": text for n, text in files.items()}))
    assert name in complaint


@pytest.mark.parametrize(
    "name, text",
    [
        ("cpp/reference/element.cpp", "#include <dolfinx/mesh/Mesh.h>\n"),
        ("cpp/reference/element.cpp", '#include "../dolfinx_impact/kernels/Kernel.h"\n'),
        ("cpp/reference/element.cpp", "#include <petscmat.h>\n"),
        ("cpp/reference/element.cpp", "  #  include <basix/finite-element.h>\n"),
        ("cpp/reference/element.cpp", "#include <nanobind/nanobind.h>\n"),  # in the bindings only
        ("cpp/reference/CMakeLists.txt", "impact_precompile(solver <vector> <Eigen/Dense> <dolfinx/mesh/Mesh.h>)\n"),
        ("cpp/plain/Mesh.h", "#include <Eigen/Dense>\n"),
        ("python/impact_reference/model.py", "import dolfinx\n"),
        ("python/impact_reference/model.py", "def f():\n    from basix import ufl\n"),
        ("python/impact_reference/model.py", "import importlib\nimportlib.import_module('ufl')\n"),
        ("python/impact_reference/model.py", "import scipy.sparse\n"),
    ],
)
def test_independence_complains(tree, name, text):
    root = tree({**GOOD_LAYERS, name: text})
    (complaint,) = rules.reference_violations(root)
    assert name in complaint


def test_independence_passes_what_it_may_see(tree):
    root = tree(
        {
            "cpp/reference/module.cpp": "#include <nanobind/nanobind.h>\n#include <cmath>\n",
            "python/impact_reference/__init__.py": "import os.path\nimport numpy as np\nfrom . import _reference\n",
        }
    )
    assert rules.reference_violations(root) == []


@pytest.mark.parametrize(
    "text", ["import dolfinx\n", "from dolfinx.fem import form\n", "import basix\n", "from petsc4py import PETSc\n"]
)
def test_forms_complain(tree, text):
    root = tree({"forms/elasticity.py": text, "forms/compiler/emit.py": "import ffcx\n"})
    (complaint,) = rules.forms_violations(root)
    assert "forms/elasticity.py:1" in complaint


def test_forms_pass_ufl(tree):
    text = "import ufl\nimport basix.ufl\nfrom basix.ufl import element\nfrom basix import ufl as b\nfrom . import x\n"
    assert rules.forms_violations(tree({"forms/a.py": text})) == []


GOOD_RELEASES = {
    "python/dolfinx_impact/compat.py": "import dolfinx\nNEW = dolfinx.__version__\nx = mesh.geometry.cmaps[0]\n",
    "python/dolfinx_impact/loads.py": "from .. import compat\np = compat.coordinate_element(mesh).degree\n",
    "forms/elasticity.py": "cell, dim = str(mesh.ufl_cell()), len(ufl.SpatialCoordinate(mesh))\n",
    "meshes/figures.py": "gdim, x = mesh.geometry.dim, mesh.geometry.x\nV, _ = W.collapse()\nV = W.collapse()[0]\n",
    "demos/hertz.py": "bars = mesh.create_mesh(comm, cells, x=points, e=element)\nV.dofmap.list\nimage.cmap\n",
    "tests/unit/a/test_a.py": "space, dofs = compat.collapse(W)\nIndexMap(comm, 3)\nnumpy.__version__\n",
    "docs/page.md": "of `dolfinx.io`\n\n    d = compat.geometric_dimension(mesh)\n",
    "cpp/dolfinx_impact/common/dolfinx_api.h": "return mesh.geometry().cmaps().front();\nv.mutable_array();\n",
    "cpp/bindings/casters.h": "#include <caster_mpi.h>\n",
    "cpp/dolfinx_impact/gap/gap.cpp": "std::span<const double> x = common::array(v);\nV.dofmap();\nf(v.array());\n",
}


def test_releases_pass_a_good_tree(tree):
    assert rules.release_violations(tree(GOOD_RELEASES)) == []


@pytest.mark.parametrize(
    "name, text",
    [
        ("python/dolfinx_impact/loads.py", "degree = V.mesh.geometry.cmap.degree\n"),
        ("python/impact_verify/a.py", "cells = domain.geometry.dofmaps[0]\n"),
        ("python/impact_verify/a.py", "(rule,) = integral.ir.integrand\n"),
        ("python/impact_studies/a.py", "geometry = mesh.geometry\ncells = geometry.dofmap\n"),
        ("python/dolfinx_impact/cli.py", "import dolfinx\nprint(dolfinx.__version__)\n"),
        ("python/dolfinx_impact/cli.py", "from ufl import __version__\n"),
        ("python/dolfinx_impact/cli.py", "found = importlib.metadata.version('fenics-dolfinx')\n"),
        ("python/dolfinx_impact/cli.py", "new = hasattr(mesh.geometry, 'cmaps')\n"),
        ("python/dolfinx_impact/cli.py", "new = getattr(dolfinx, '__version__') > '0.9'\n"),
        ("forms/elasticity.py", "cell = mesh.ufl_cell().cellname()\n"),
        ("forms/elasticity.py", "dim = mesh.geometric_dimension\n"),
        ("meshes/figures.py", "from dolfinx.io import gmshio\n"),
        ("meshes/figures.py", "import dolfinx.io.gmsh\n"),
        ("demos/hertz.py", "bars = mesh.create_mesh(comm, cells, points, element)\n"),
        ("demos/applications/foam.py", "from dolfinx.nls.petsc import NewtonSolver\n"),
        ("tests/unit/a/test_a.py", "linear = petsc.LinearProblem(a, L)\n"),
        ("tests/unit/a/test_a.py", "b = fem.petsc.create_vector(form)\n"),
        ("tests/unit/a/test_a.py", "f = fem.Expression(e, W.element.interpolation_points())\n"),
        ("tests/unit/a/test_a.py", "space, dofs = W.sub(0).collapse()\n"),
        ("tests/unit/a/test_a.py", "dofs = W.sub(0).collapse()[1]\n"),
        ("tests/unit/a/test_a.py", "numbers = IndexMap(comm, 3, ghosts, owners)\n"),
        ("tests/unit/a/test_a.py", "A = petsc.assemble_matrix(form, bcs=bcs, diagonal=0.0)\n"),
        ("tests/unit/a/test_a.py", "part = mesh.create_cell_partitioner(mesh.GhostMode.none)\n"),
        ("docs/figures.py", "cells = mesh.geometry.dofmap\n"),
        ("cpp/dolfinx_impact/gap/gap.cpp", "auto type = dolfinx::MPI::mpi_type<T>();\n"),
        ("cpp/dolfinx_impact/gap/gap.cpp", "v.mutable_array()[0] = 1.0;\n"),
        ("cpp/dolfinx_impact/gap/gap.cpp", "const auto u = function->x()->array();\n"),
        ("cpp/dolfinx_impact/gap/gap.cpp", "take(u.x()->array().first(n));\n"),
        ("cpp/dolfinx_impact/gap/gap.cpp", "sums.set(0.0);\n"),
        ("cpp/dolfinx_impact/gap/gap.cpp", "int p = mesh.geometry().cmap().degree();\n"),
        ("cpp/dolfinx_impact/gap/gap.h", "auto d = geometry.dofmap();\n"),
        ("cpp/dolfinx_impact/gap/gap.h", "bool b = V.value_shape().size();\n"),
        ("cpp/bindings/gap.cpp", "#include <caster_petsc.h>\n"),
        ("demos/cpp/impact.cpp", "const auto [field, dofs] = V.sub({0}).collapse();\n"),
        ("demos/cpp/impact.cpp", "auto V = dolfinx::fem::create_functionspace(mesh, element, {2});\n"),
        ("tests/cpp/test_a.cpp", "dolfinx::fem::sparsitybuild::cells(p, {c, c}, {d, d});\n"),
        ("docs/page.md", "    x = mesh.geometry.x[mesh.geometry.dofmap]\n"),
    ],
)
def test_releases_complain(tree, name, text):
    (complaint,) = rules.release_violations(tree({**GOOD_RELEASES, name: text}))
    assert complaint.startswith(f"{name}:") and "is not the same in all releases" in complaint


MPI_FIRST = "import numpy\nfrom mpi4py import MPI\nfrom dolfinx import fem\n\nimport dolfinx_impact as di\n"
MPI_LATER = "import numpy\nfrom dolfinx import fem\nfrom mpi4py import MPI\n"


@pytest.mark.parametrize(
    "name, block", [("demos/a/b.py", "{}"), ("docs/a/b.md", "x\n```python\n{}```\n"), ("README.md", "```\n{}```\n")]
)
def test_mpi_later_complains(tree, name, block):
    assert rules.mpi_later(tree({name: block.format(MPI_FIRST) + block.format("from dolfinx import mesh\n")})) == []
    (complaint,) = rules.mpi_later(tree({name: block.format(MPI_LATER)}))
    assert complaint.startswith(f"{name}: dolfinx is imported")


@pytest.mark.parametrize("flag", ["-f" + "fast-math", "-O" + "fast"])
@pytest.mark.parametrize("name", ["cpp/CMakeLists.txt", "pyproject.toml", "Makefile", "forms/compiler/driver.py"])
def test_unsafe_flags_complain(tree, name, flag):
    assert len(rules.unsafe_flags(tree({name: f"flags = '{flag}'\n"}))) == 1
    assert rules.unsafe_flags(tree({name: f"# never {flag}\n"})) == []


def test_plain_forms_complain(tree):
    code = "a = ffcx_form(u * v)\nb = fem.form(u * v)\n"
    root = tree({"python/dolfinx_impact/a.py": code, "python/dolfinx_impact/assembly/ffcx_form.py": code})
    assert rules.plain_forms(root) == ["python/dolfinx_impact/a.py:2: b = fem.form(u * v)"]


def test_unfinished_headers_complain(tree):
    root = tree({"cpp/dolfinx_impact/gap/update.h": "/// FIX" + "ME: sign\n", "cpp/a.cpp": "// TO" + "DO\n"})
    assert len(rules.unfinished_headers(root)) == 1


GOOD_UNIT = {
    "python/dolfinx_impact/__init__.py": "",
    "python/dolfinx_impact/loads.py": "",
    "python/dolfinx_impact/statics/__init__.py": "",
    "python/dolfinx_impact/verify/reasons/__init__.py": "",  # tested elsewhere
    "python/impact_reference/solver/__init__.py": "",
    "cpp/dolfinx_impact/search/closest_point/Projection.h": "",
    "tests/unit/conftest_of_nothing/made/mesh.h5": "",  # data of tests is no folder of tests
    "tests/unit/env/conftest.py": "",
    "tests/unit/forms/compiler/conftest.py": "",
    "tests/unit/loads/test_loads.py": "",
    "tests/unit/statics/test_problem.py": "",
    "tests/unit/search/closest_point/test_projection.py": "",
    "tests/unit/solver/test_solver.py": "",
}


def test_folders_of_unit_tests_pass_a_good_tree(tree):
    assert rules.unit_folder_violations(tree(GOOD_UNIT)) == []


@pytest.mark.parametrize(
    "name, words",
    [
        ("tests/unit/problem/test_a.py", "tests/unit/problem: neither a package, a module nor a stage"),
        ("tests/unit/search/node/test_a.py", "tests/unit/search/node: neither"),
        ("tests/unit/loads/test_projection.py", "has this name, too"),
        ("python/dolfinx_impact/io/__init__.py", "python/dolfinx_impact/io: no folder of tests/unit"),
        ("python/dolfinx_impact/statics/deep/__init__.py", "python/dolfinx_impact/statics/deep: no folder"),
    ],
)
def test_folders_of_unit_tests_complain(tree, name, words):
    (complaint,) = rules.unit_folder_violations(tree({**GOOD_UNIT, name: ""}))
    assert words in complaint


def test_classes_that_no_test_names_complain(tree):
    files = {
        "python/dolfinx_impact/body.py": """
class Body:
    def force(self): ...
class _Part:
    def force(self): ...
class Numbers:
    count = 3
class Asked(Protocol):
    def force(self): ...
""",
        "forms/law.py": "class Law:\n    def __init__(self): ...\n",
        "tests/unit/test_body.py": "from dolfinx_impact.body import Body\nLaws, Parts = 1, _Parted\n",
    }
    assert rules.unnamed_classes(tree(files)) == [
        "python/dolfinx_impact/body.py:4: no test names _Part",
        "forms/law.py:1: no test names Law",
    ]


GOOD_DOCSTRINGS = {
    "python/dolfinx_impact/body.py": '''
class Body(Protocol):
    """Bodies."""

    def residual(self):
        """Internal minus external forces. Collective."""

    @property
    def size(self):
        """Number of cells. Of all ranks."""
''',
    "python/dolfinx_impact/shapes.py": '''
class Shape:
    def area(self):
        """Area of the surface. Without its edges [L^2]."""

    def name(self): ...


class Ball(Shape):
    def area(self):
        """Exact [L^2]."""

    def name(self):
        """Name of the ball."""


class Elastic:  # meets Body
    def residual(self): ...

    @property
    def size(self):
        """Of this rank."""

    def area(self):
        """Area of the surface. No base has it."""
''',
    "python/impact_verify/body.py": '''
class Other:  # of another package
    def residual(self):
        """Internal minus external forces."""
''',
}


def test_docstrings_pass_a_good_tree(tree):
    assert rules.repeated_docstrings(tree(GOOD_DOCSTRINGS)) == []


@pytest.mark.parametrize(
    "name, text, complaint",
    [
        # An override, word for word, and with more around it; the base in another module, or one above it.
        ("shapes.py", "Exact [L^2].", "Area of the surface. Without its edges [L^2].", ),
        ("shapes.py", "Exact [L^2].", "Exact. Area of the surface."),
        ("disc.py", "", "Area of the surface."),
        ("dome.py", "", "Area of the surface."),
        # What meets a protocol without deriving from it: methods and properties.
        ("steel.py", "residual", "Internal minus external\n        forces. In closed form."),
        ("steel.py", "size", "Number of cells."),
    ],
)  # fmt: skip
def test_docstrings_complain(tree, name, text, complaint):
    path = f"python/dolfinx_impact/{name}"
    method = f'    def area(self):\n        """{complaint}"""\n'
    files = {
        "shapes.py": GOOD_DOCSTRINGS["python/dolfinx_impact/shapes.py"].replace(text or "nothing", complaint),
        "disc.py": f"from . import shapes\nclass Disc(shapes.Shape):\n{method}",
        "dome.py": f"from .shapes import Ball\nclass Dome(Ball):\n{method}",
        "steel.py": f"class Steel:\n{method}".replace("area", text),
    }
    (found,) = rules.repeated_docstrings(tree({**GOOD_DOCSTRINGS, path: files[name]}))
    asked = {"residual": "Body.residual", "size": "Body.size"}.get(text, "Shape.area")
    assert found.startswith(f"{path}:") and found.endswith(f"says what {asked} says")


GOOD_COMMENTS = {
    "cpp/dolfinx_impact/solve/Body.h": """
class Body
{
public:
  /// Internal minus external forces. Collective.
  /// @return vector of the body [F]
  virtual Vec residual() = 0;

  /// Number of cells.
  int size() const { return 3; }
};
""",
    "cpp/dolfinx_impact/solve/Own.h": """
class Own : public Body
{
  Vec residual() override;
  /// Of this rank.
  int size() const;
  /// Number of cells.
  int count() override;
};
""",
}


def test_comments_pass_a_good_tree(tree):
    assert rules.repeated_comments(tree(GOOD_COMMENTS)) == []


@pytest.mark.parametrize(
    "comment",
    ["/// Internal minus external forces. Collective.", "/// With springs. Internal minus\n  /// external forces."],
)
def test_comments_complain(tree, comment):
    text = f"class Other : public Body\n{{\n  {comment}\n  Vec residual() override\n  {{\n    return 0;\n  }}\n}};\n"
    (complaint,) = rules.repeated_comments(tree({**GOOD_COMMENTS, "cpp/dolfinx_impact/solve/Other.h": text}))
    assert complaint == "cpp/dolfinx_impact/solve/Other.h:3: the comment of residual is that of the base"


def test_line_counts(tree):
    counts = rules.line_counts(tree({"a.py": "\n" * 401, "docs/b.md": "\n" * 900, "Makefile": "x\n"}))
    assert {str(p): n for p, n in counts.items()} == {"a.py": 401, "Makefile": 1}


def test_long_lines_of_pages_complain(tree):
    root = tree({"docs/a.md": "x" * 120 + "\n" + "x" * 121 + "\n|" + "x" * 200 + "|\n", "a.py": "x" * 200})
    assert rules.long_lines(root) == ["docs/a.md:2: 121 characters"]


def test_missing_pages_complain(tree):
    root = tree({"docs/a.md": "text\n", "a.py": "# docs/a.md\n# docs/b.md, and build/docs/c.md\n"})
    assert rules.missing_pages(root) == ["a.py:2: docs/b.md does not exist"]


BAD_PATHS = ["/wo" + "rk/x/y", "see /ro" + "ot/.cache", '"/wo' + 'rk/main"', "/home/" + "ada/src", "cd /Us" + "ers/ada"]
BAD_PATHS += ["wget https://deb.debian" + ".org/debian"]


@pytest.mark.parametrize("text", BAD_PATHS)
def test_machine_paths_complain(tree, text):
    assert len(rules.machine_paths(tree({"docs/a.md": f"fine\n{text}\n"}))) == 1


def test_machine_paths_pass_ordinary_text(tree):
    text = "$HOME/wo" + "rk/x\nbuild/ro" + "ot/y\n~/.cache/dolfinx_impact\nframework/root\n/usr/lib\n"
    assert rules.machine_paths(tree({"docs/a.md": text, "a.bin": "\0/ro" + "ot/"})) == []


def test_bindings_that_nothing_calls_are_seen(tree):
    stub = """class Solver:
    def __init__(self) -> None: ...
    def run(self) -> None: ...
    @property
    def seconds(self) -> float: ...
class SolverOptions:
    @property
    def largest(self) -> int: ...
def norm() -> float: ...
"""
    files = {"python/dolfinx_impact/_cpp/solve.pyi": stub, "python/dolfinx_impact/a.py": "solver.run(); x = norm()\n"}
    assert rules.unused_bindings(tree(files)) == ["solve.Solver.seconds"]
    assert rules.unused_bindings(tree({**files, "tests/test_a.py": "assert solver.seconds > 0\n"})) == []


def test_what_a_run_left_at_the_top_is_seen(tree):
    good = {"README.md": "", "cpp/plain/Mesh.h": "", "results/bench.json": "", "tests/conftest.py": ""}
    assert rules.top_violations(tree(good)) == []
    assert rules.top_violations(tree({"report.json": "{}", "out/index.html": ""})) == ["out", "report.json"]


def test_versions_are_found(tree):
    root = tree(
        {"pyproject.toml": '[project]\nversion = "1.2.3"\n', "CITATION.cff": "cff-version: 1.2.0\nversion: 1.2.4\n"}
    )
    assert rules.versions(root) == {"pyproject.toml": "1.2.3", "CITATION.cff": "1.2.4"}


@pytest.mark.parametrize("name", ["demos/a.py", "demos/_a.py", "demos/applications/a.py"])
@pytest.mark.parametrize(
    "text", ["", "print(1)\n", "assert x\nprint(1)\n", "assert True\n", "def f():\n    assert x\n"]
)
def test_demos_complain(tree, text, name):
    assert len(rules.demos_without_assert(tree({name: text}))) == 1


def test_demos_pass(tree):
    good = {"demos/a.py": "x = 1\nassert x == 1\n", "demos/__init__.py": "", "demos/applications/models/m.py": ""}
    assert rules.demos_without_assert(tree(good)) == []
