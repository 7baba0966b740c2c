# SPDX-License-Identifier: MIT
"""Which cells kernels are written for, where they come from and go: objects without the command."""

import itertools
from pathlib import Path

import pytest
import ufl

from dolfinx_impact.compile.case import Case
from dolfinx_impact.compile.choice import Choice
from dolfinx_impact.compile.form_law import Terms
from dolfinx_impact.compile.kernel_source import KernelSource, source_of_kernels
from dolfinx_impact.compile.origin import RESERVED, Origin
from dolfinx_impact.compile.output import Output, output_of
from dolfinx_impact.compile.own_law import KernelForm, OwnLaw
from dolfinx_impact.forms.registry import CELLS

CASE = Case("triangle", 2, 1, "plane_strain")


def test_nothing_said_is_every_cell_of_degree_one():
    cases = list(Choice().cases(None))
    assert [c.cell for c in cases] == list(CELLS)
    assert all(
        (c.degree, c.geometry_degree) == (1, 1) and (c.hypothesis == "3d") == (CELLS[c.cell] == 3) for c in cases
    )
    assert [c.cell for c in Choice().cases(["hexahedron"])] == ["hexahedron"]


def test_all_combinations_that_fit():
    choice = Choice(["triangle", "hexahedron"], [1, 2], [1, 2], ["3d", "plane_stress", "axisymmetric"])
    choice.check()
    plane = itertools.product(["triangle"], [1, 2], [1, 2], ["plane_stress", "axisymmetric"])
    space = itertools.product(["hexahedron"], [1, 2], [1, 2], ["3d"])
    found = list(choice.cases(["tetrahedron"]))
    assert set(found) == {Case(*c) for c in (*plane, *space)} and len(found) == 12


def test_what_is_asked_for_a_case():
    choice = Choice(degrees=[1, 2], kernels=["force"])
    assert choice.only(CASE) == Choice(degrees=[2])
    assert choice.contradiction(CASE) == ""
    assert Choice(degrees=[1]).contradiction(CASE) == "degree 2, not for 1"
    assert (
        Choice(["quadrilateral", "hexahedron"]).contradiction(CASE)
        == "cell triangle, not for quadrilateral, hexahedron"
    )


@pytest.mark.parametrize(
    "choice, words",
    [
        (Choice(["wedge"]), "cell 'wedge' is unknown"),
        (Choice(degrees=[9]), "degree 9 is unknown"),
        (Choice(geometry_degrees=[9]), "geometry degree 9"),
        (Choice(hypotheses=["2d"]), "hypothesis '2d'"),
        (Choice(kernels=["power"]), "kind of kernel 'power'"),
        (Choice(["hexahedron"], hypotheses=["plane_stress"]), "none of the hypotheses plane_stress fits"),
    ],
)
def test_what_no_kernels_are_written_for(choice, words):
    with pytest.raises(ValueError, match=words):
        choice.check()


@pytest.mark.parametrize("file", ["1law.py", "my-law.py", "my.law.py", "class.py", "a__b.py", "law", *("std.py",)])
def test_files_whose_name_is_none_in_cxx(file):
    with pytest.raises(ValueError, match="rename it"):
        Origin(file, "", {}).check()


def test_the_name_of_a_file_names_header_and_namespace():
    origin = Origin("my_law.py", "dolfinx-impact compile my_law.py", {})
    origin.check()
    assert origin.stem == "my_law" and "my_law" not in RESERVED


def test_where_the_kernels_go(tmp_path):
    assert output_of("a/my.hpp", "law") == Output(Path("a"), "my.hpp", None)
    assert output_of("a/my", "law") == Output(Path("a/my"), "law.h", "law.cpp")
    both = output_of(str(tmp_path / "new"), "law")
    both.check()
    assert both.write("header", "source") == [tmp_path / "new" / "law.h", tmp_path / "new" / "law.cpp"]
    assert [p.read_text() for p in sorted((tmp_path / "new").iterdir())] == ["source", "header"]  # nothing else is left
    alone = Output(tmp_path, "law.h", None)
    assert alone.write("one file", "") == [tmp_path / "law.h"] and not (tmp_path / "law.cpp").exists()


def test_a_folder_in_the_place_of_a_file(tmp_path):
    (tmp_path / "law.h").mkdir()
    with pytest.raises(ValueError, match="law.h is a folder|cannot be written"):
        Output(tmp_path, "law.h", None).check()
    (tmp_path / "file").write_text("")
    with pytest.raises(ValueError, match="give another -o"):
        Output(tmp_path / "file", "law.h", "law.cpp").check()


def law_of(form):
    terms = Terms(form, None)
    assert terms.tangent is None and terms.names == {}
    return OwnLaw("my", CASE, {"force": KernelForm(terms.residual)}, terms.names, {})


def test_names_of_kernels():
    source = KernelSource(law_of(ufl.Form([])), "force", [])
    assert source.name == "my.force"
    assert source.prefix("file") == "impact_file_my_force_triangle_2_1_plane_strain"


def test_a_form_without_a_kernel_says_which():
    with pytest.raises(ValueError, match="no kernel can be written of my.force on .*--kernels leaves a kind out"):
        source_of_kernels(law_of(ufl.Form([])), "force")
