# SPDX-License-Identifier: MIT
"""The C++ library: found by CMake as a user finds it; the demos and a test program built, and run on 1 to 3 ranks."""

import pathlib
import re
import shutil
import subprocess
import sys

import pytest
from processes import mpi_environment

import dolfinx_impact
from dolfinx_impact._cpp.kernels import processor_width


def run(command, **environment):
    surroundings = mpi_environment(**environment)
    done = subprocess.run([str(c) for c in command], env=surroundings, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, (done.stdout + done.stderr)[-4000:]
    return done.stdout


def build(source, folder):
    """Copy, configure and build a CMake project outside of the checkout, with an install prefix outside of it, too:
    nothing of the checkout is seen.

    All is in one folder: ccache sees paths relative to it only, and knows the sources again in the next run and in
    another checkout. What uses a precompiled header it remembers only where it may overlook macros of date and time, of
    which there are none.
    """
    package = folder / "installed" / "dolfinx_impact"
    site = pathlib.Path(dolfinx_impact.__file__).parents[1]
    for name in ("dolfinx_impact", "impact_reference"):
        shutil.copytree(site / name, folder / "installed" / name, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copytree(source, folder / "source")
    # Not optimised, which takes a third less time; asserts hold as well.
    options = [f"-DCMAKE_PREFIX_PATH={package}", "-DCMAKE_BUILD_TYPE=None", f"-DPython_EXECUTABLE={sys.executable}"]
    if shutil.which("ccache"):
        options.append("-DCMAKE_CXX_COMPILER_LAUNCHER=ccache")
    if shutil.which("ninja"):
        options.append("-GNinja")
    run(["cmake", "-S", folder / "source", "-B", folder / "build", *options])
    ccache = {"CCACHE_BASEDIR": folder, "CCACHE_NOHASHDIR": 1, "CCACHE_NODIRECT": 1}
    ccache["CCACHE_SLOPPINESS"] = "pch_defines,time_macros"
    run(["cmake", "--build", folder / "build"], **{name: str(value) for name, value in ccache.items()})
    return folder / "build"


@pytest.fixture(scope="module")
def demos(checkout, tmp_path_factory):
    """Folder with the programs of demos/cpp."""
    return build(checkout / "demos" / "cpp", tmp_path_factory.mktemp("demo_cpp"))


@pytest.fixture(scope="module")
def program(demos):
    return demos / "elastic_block"


@pytest.fixture(scope="module")
def checks(tmp_path_factory):
    return build(pathlib.Path(__file__).parent, tmp_path_factory.mktemp("tests_cpp"))


@pytest.mark.mpi
@pytest.mark.long_rows(where=lambda ranks: ranks == 2)
@pytest.mark.parametrize("ranks", [1, 2, 3])
def test_demo_runs(program, ranks):
    output = run(["mpirun", "-n", ranks, program]) if ranks > 1 else run([program])
    (ratio,) = re.findall(r"stored energy / exact = (\S+)", output)
    assert abs(float(ratio) - 1.0) < 1e-9 and "degree 3: refused" in output


# What each prints, the number it must be, and how near: round-off of some hundred unknowns; Hertz's bodies are half
# spaces, those of the demo are ten half-widths large; waves on meshes of 200 and 100 cells.
CHECKS = {
    "penalty_friction": [
        (r"normal force / exact = (\S+)", 1.0, 1e-9),
        (r"friction / \(coefficient \* normal force\) = (\S+)", 1.0, 1e-9),
    ],
    "hertz_multipliers": [(r"peak pressure / Hertz = (\S+)", 1.0, 0.01)],
    "explicit_impact": [
        (r"force on the wall / \(density c v A\) = (\S+)", 1.0, 0.01),
        (r"impulse / \(2 m v\) = (\S+)", 1.0, 0.02),
        (r"energy after / before = (\S+)", 1.0, 0.02),
    ],
    # All of the contact slips, by Coulomb's law; the wheel's rolling radius is its own, less a part of the approach.
    "rolling_wheel": [
        (r"slipping: force / \(friction \* pressure\) = (\S+)", 1.0, 1e-8),
        (r"free rolling: omega R / V = (\S+)", 1.0, 0.01),
    ],
    "yielding_bar": [
        (r"force on the end / von Karman's = (\S+)", 1.0, 0.02),
        (r"plastic energy / von Karman's = (\S+)", 1.0, 0.03),
    ],
    "own_law": [(rf"{what} / exact = (\S+)", 1.0, 1e-12) for what in ("force", "energy", "stress")],
}


@pytest.mark.mpi
@pytest.mark.long_rows(where=lambda ranks: ranks == 3)
@pytest.mark.parametrize("ranks", [1, 2, 3])
@pytest.mark.parametrize("name", CHECKS)
def test_contact_demos_meet_closed_forms(demos, name, ranks):
    output = run(["mpirun", "-n", ranks, demos / name]) if ranks > 1 else run([demos / name])
    for pattern, expected, tolerance in CHECKS[name]:
        (value,) = re.findall(pattern, output)
        assert abs(float(value) - expected) < tolerance, output


def test_demos_are_short_and_use_public_headers(checkout):
    """At most 100 lines each; every header of the package that one names is installed with it."""
    installed = pathlib.Path(dolfinx_impact.__file__).parent / "include"
    sources = sorted((checkout / "demos" / "cpp").glob("*.cpp"))
    assert {s.stem for s in sources} == {*CHECKS, "elastic_block"}
    for source in sources:
        text = source.read_text()
        assert len(text.splitlines()) <= 100, source.name
        # What is not installed with a library is beside them, or the build has written it from a UFL file.
        own = re.findall(r'#include "(\w+)\.h"', text)
        assert "demo" in own and "return run_demo(" in text, source.name
        assert all(any((source.parent / f"{name}.{end}").is_file() for end in ("h", "py")) for name in own), source.name
        headers = re.findall(r"#include <(dolfinx_impact/[^>]+)>", text)
        assert headers and all((installed / header).is_file() for header in headers), source.name


def test_nothing_of_the_checkout_or_of_python_is_in_a_program(demos, checkout):
    """The package can be moved: programs find its library where it was installed, and need no Python when they run."""
    libraries = run(["ldd", demos / "own_law"])
    own = re.search(r"libdolfinx_impact\S* => (\S+)", libraries)
    assert own is not None and own[1].startswith(str(demos.parent / "installed")), libraries
    assert "libpython" not in libraries
    recipes = (demos.parent / "installed" / "dolfinx_impact" / "lib" / "cmake" / "dolfinx_impact").glob("*.cmake")
    assert [recipe.name for recipe in recipes if str(checkout) in recipe.read_text()] == []


def test_a_law_of_ones_own_is_written_again_when_it_changes(demos):
    law = demos.parent / "source" / "foam.py"
    law.write_text(law.read_text().replace("0.3e6", "0.6e6"))
    run(["cmake", "--build", demos, "--target", "own_law_foam_kernels"])
    assert '"mu", {600000.0}' in (demos / "own_law_kernels" / "foam.cpp").read_text()


@pytest.mark.parametrize("name", ["elastic_block", "own_law"])
def test_widths_agree(demos, name):
    """Kernels of the package, and those of a law of one's own, have all widths, whatever the flags of the program."""
    for width in {1, min(4, processor_width()), processor_width()}:
        assert f"cells per kernel call: {width}\n" in run([demos / name], IMPACT_SIMD_WIDTH=str(width))


@pytest.mark.mpi
@pytest.mark.long_rows(where=lambda ranks: ranks == 3)
@pytest.mark.parametrize("ranks", [1, 2, 3])
def test_library(checks, ranks):
    """Tangent, energy and force against each other, boundary conditions, errors."""
    program = checks / "tangent_check"
    output = run(["mpirun", "-n", ranks, program]) if ranks > 1 else run([program])
    assert output.count("passed") == ranks


def told(checks, ranks, mode, folder):
    """What checkpoint_check says of each problem, the same on all ranks."""
    program = ["mpirun", "-n", ranks] if ranks > 1 else []
    lines = re.findall(r"^(\d+) (\w+): (.*)$", run([*program, checks / "checkpoint_check", mode, folder]), re.M)
    of = [[(name, text) for rank, name, text in lines if int(rank) == r] for r in range(ranks)]
    assert of[0] and all(sorted(said) == sorted(of[0]) for said in of)
    return of[0]


@pytest.mark.mpi
def test_problems_go_on_from_their_files_on_other_ranks(checks, tmp_path):
    """To 1e-8 of the norm of the displacements: sums of other ranks differ in their last digits, Newton's method stops
    at 1e-10. A file of another mesh or identity is refused, and one with a byte that differs."""
    ends = dict(told(checks, 2, "write", tmp_path))
    assert sorted(ends) == ["explicit", "implicit", "static", "within"]
    for ranks in (1, 3):
        for name, text in told(checks, ranks, "read", tmp_path):
            assert abs(float(text) / float(ends[name]) - 1.0) < 1e-8, (name, text, ends[name])
    others = told(checks, 1, "other", tmp_path)
    for name, text in others:
        assert "is of another problem: num_cells is 24, here 30" in text or "steel is 1.0, here 2.0" in text, (
            name,
            text,
        )
    assert len(others) == 8 and sum("steel" in text for _, text in others) == 4
    for name in ends:
        data = bytearray((tmp_path / f"{name}.h5").read_bytes())
        data[len(data) // 2] ^= 1
        (tmp_path / f"{name}.h5").write_bytes(data)
    for name, text in told(checks, 2, "read", tmp_path):
        assert "cannot be read (rank" in text and "is damaged" in text, (name, text)


def test_units(checks):
    """Classes of the library, each alone (Catch2)."""
    assert "All tests passed" in run([checks / "unit_tests"])


def test_functions_of_kernels(checks):
    """Mathematical functions of vectors, compiled as kernels are, with those instructions that the processor has.
    Without any they are among the units above."""
    for instructions, width in (("avx2", 4), ("avx512", 8)):
        program = checks / f"functions_{instructions}"
        if program.exists() and width <= processor_width():
            assert "All tests passed" in run([program])
