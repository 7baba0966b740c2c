# SPDX-License-Identifier: MIT
"""Results do not depend on the processor beyond round-off: other SIMD widths of the kernels, other kernels of BLAS."""

import os
import pathlib
import subprocess
import sys

import numpy as np
import pytest
from dolfinx_impact import _cpp

SCRIPT = pathlib.Path(__file__).with_name("processor_checks.py")
# OpenBLAS takes the kernels of another processor when it is told to; another BLAS does not know the variable.
OTHERS = (("1", "Prescott"), ("4", "Haswell"))


def run(path, **environment):
    done = subprocess.run(
        [sys.executable, SCRIPT, path], env={**os.environ, **environment}, capture_output=True, text=True, timeout=300
    )
    assert done.returncode == 0, done.stdout + done.stderr
    with np.load(path) as file:
        return dict(file)


@pytest.fixture(scope="module")
def default(tmp_path_factory):
    return run(tmp_path_factory.mktemp("processor") / "default.npz")


@pytest.mark.long_rows(where=lambda blas: blas == "Haswell")
@pytest.mark.parametrize("width, blas", OTHERS)
def test_histories(width, blas, default, tmp_path):
    """They agree with the hand-written solver in every process, and with each other."""
    found = run(tmp_path / "other.npz", IMPACT_SIMD_WIDTH=width, OPENBLAS_CORETYPE=blas)
    assert found.pop("width") == min(int(width), _cpp.kernels.processor_width())
    assert set(found) == set(default) - {"width"} and len(found) > 30
    for name, values in found.items():
        # Round-off of the steps, as at level history of `verify`; of the stable step that of its eigenvalue.
        tolerance = 1e-14 if name.endswith(": step") else 1e-10
        np.testing.assert_allclose(
            values, default[name], rtol=0, atol=tolerance * np.abs(default[name]).max(), err_msg=name
        )
        assert np.any(values), f"{name}: nothing happens"
