# SPDX-License-Identifier: MIT
"""Warnings of a script that imports the package are seen, or go where the script wants them."""

import subprocess
import sys

import pytest

WARN = "import warnings, dolfinx_impact; warnings.warn('seen')"
LOGGED = "import logging; logging.basicConfig(format='logged %(message)s'); logging.captureWarnings(True); "
QUIET = "import dolfinx, warnings; warnings.warn('seen')"


@pytest.mark.parametrize(
    "script, words",
    [(WARN, "UserWarning: seen"), (LOGGED + WARN, "logged <string>:1: UserWarning: seen"), (QUIET, "")],
    ids=["alone", "with a handler", "DOLFINx alone drops them"],
)
def test_warnings(script, words):
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=100)
    assert done.returncode == 0, done.stderr
    assert words in done.stderr and ("seen" in done.stderr) == bool(words)
