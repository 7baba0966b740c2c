# SPDX-License-Identifier: MIT
"""The C++ library: found by CMake as a user finds it; the demo and a test program built, and run on 1 to 3 ranks."""

import os
import pathlib
import re
import shutil
import subprocess

import pytest

import dolfinx_impact

pytestmark = pytest.mark.alone


def run(command, **environment):
    surroundings = {
        "OMPI_ALLOW_RUN_AS_ROOT": "1",
        "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
        "OMPI_MCA_rmaps_base_oversubscribe": "1",
        "PRTE_MCA_rmaps_default_mapping_policy": ":oversubscribe",
        **os.environ,
        **environment,
    }
    done = subprocess.run([str(c) for c in command], env=surroundings, capture_output=True, text=True, timeout=200)
    assert done.returncode == 0, (done.stdout + done.stderr)[-4000:]
    return done.stdout


def build(source, folder):
    """Copy, configure and build a CMake project: nothing of the checkout but its own folder is seen."""
    package = pathlib.Path(dolfinx_impact.__file__).parent
    shutil.copytree(source, folder / "source")
    options = [f"-DCMAKE_PREFIX_PATH={package}"]
    if shutil.which("ccache"):
        options.append("-DCMAKE_CXX_COMPILER_LAUNCHER=ccache")
    if shutil.which("ninja"):
        options.append("-GNinja")
    run(["cmake", "-S", folder / "source", "-B", folder / "build", *options])
    run(["cmake", "--build", folder / "build"], CCACHE_BASEDIR=str(folder), CCACHE_NOHASHDIR="1")
    return folder / "build"


@pytest.fixture(scope="module")
def program(checkout, tmp_path_factory):
    return build(checkout / "demos" / "cpp", tmp_path_factory.mktemp("demo_cpp")) / "elastic_block"


@pytest.fixture(scope="module")
def checks(tmp_path_factory):
    return build(pathlib.Path(__file__).parent, tmp_path_factory.mktemp("tests_cpp"))


@pytest.mark.parametrize("ranks", [1, 2, 3])
def test_demo_runs(program, ranks):
    output = run(["mpirun", "-n", ranks, program]) if ranks > 1 else run([program])
    (error,) = re.findall(r"\|K u - f\(u\)\| / \|f\(u\)\| = (\S+)", output)
    assert float(error) < 1e-12 and "refused" in output


def test_widths_agree(program):
    for width in {"1", str(min(4, dolfinx_impact._cpp.kernels.processor_width()))}:
        assert f"cells per kernel call: {width}" in run([program], IMPACT_SIMD_WIDTH=width)


@pytest.mark.parametrize("ranks", [1, 2, 3])
def test_library(checks, ranks):
    """Tangent, energy and force against each other, boundary conditions, errors."""
    program = checks / "tangent_check"
    output = run(["mpirun", "-n", ranks, program]) if ranks > 1 else run([program])
    assert output.count("passed") == ranks


def test_units(checks):
    """Classes of the library, each alone (Catch2)."""
    assert "All tests passed" in run([checks / "unit_tests"])
