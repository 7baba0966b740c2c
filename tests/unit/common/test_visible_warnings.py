# SPDX-License-Identifier: MIT
"""Warnings of a script that imports the package, which DOLFINx 0.9 drops, are seen, or go where the script wants."""

import subprocess
import sys

import pytest

WARN = "import warnings, dolfinx_impact; warnings.warn('seen')"
LOGGED = "import logging; logging.basicConfig(format='logged %(message)s'); logging.captureWarnings(True); "


@pytest.mark.parametrize(
    "script, words",
    [(WARN, "UserWarning: seen"), (LOGGED + WARN, "logged <string>:1: UserWarning: seen")],
    ids=["alone", "with a handler"],
)
def test_warnings(script, words):
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=100)
    assert done.returncode == 0, done.stderr
    assert words in done.stderr
