# SPDX-License-Identifier: MIT
"""Results do not depend on the processor beyond round-off: other SIMD widths of the kernels, other kernels of BLAS."""

import os
import pathlib
import subprocess
import sys

import numpy as np
import pytest
from dolfinx_impact import _cpp
from impact_verify.scenarios.explicit_runs import IN_FLOAT

SCRIPT = pathlib.Path(__file__).with_name("processor_checks.py")
# OpenBLAS takes the kernels of another processor when it is told to; another BLAS does not know the variable.
OTHERS = (("1", "Prescott"), ("4", "Haswell"))


def run(path, cells, **environment):
    done = subprocess.run(
        [sys.executable, SCRIPT, path, *cells],
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    with np.load(path) as file:
        return dict(file)


def tolerance_of(name):
    """Round-off of the steps, as at level history of `verify`; of the stable step that of its eigenvalue. Two runs in
    float may each have the whole of theirs."""
    if name.endswith(": step"):
        return 1e-14
    if "mixed precision" in name:
        (law,) = [law for law in IN_FLOAT if law in name.replace("-", "_")]
        return 2 * IN_FLOAT[law].tolerance
    return 1e-10


@pytest.fixture(scope="module", params=["quadrilateral", "hexahedron", "tetrahedron"])
def cell_and_default(request, tmp_path_factory):
    """A kind of cells, and what this processor computes on them."""
    return request.param, run(tmp_path_factory.mktemp("processor") / "default.npz", [request.param])


@pytest.mark.long_rows(where=lambda cell_and_default, blas: (blas, cell_and_default) != ("Prescott", "hexahedron"))
@pytest.mark.parametrize("width, blas", OTHERS)
def test_histories(width, blas, cell_and_default, tmp_path):
    """They agree with the hand-written solver in every process, and with each other."""
    cell, default = cell_and_default
    found = run(tmp_path / "other.npz", [cell], IMPACT_SIMD_WIDTH=width, OPENBLAS_CORETYPE=blas)
    assert found.pop("width") == min(int(width), _cpp.kernels.processor_width())
    assert set(found) == set(default) - {"width"} and len(found) > 10
    for name, values in found.items():
        tolerance = tolerance_of(name)
        largest = np.abs(default[name]).max()
        np.testing.assert_allclose(values, default[name], rtol=0, atol=tolerance * largest, err_msg=name)
        assert np.any(values), f"{name}: nothing happens"
