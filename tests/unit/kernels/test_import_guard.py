# SPDX-License-Identifier: MIT
"""The compiled module refuses to load beside a DOLFINx whose types it does not share, and says what to do."""

import subprocess
import sys
from pathlib import Path

import dolfinx_impact

# A stand-in for dolfinx.cpp without any of its classes looks to nanobind like one built with other internals.
CODE = """
import importlib.util, sys, types
for name in ("dolfinx", "dolfinx.cpp"):
    sys.modules[name] = types.ModuleType(name)
spec = importlib.util.spec_from_file_location("_cpp", sys.argv[1])
try:
    importlib.util.module_from_spec(spec)
except ImportError as e:
    print("refused:", e)
"""


def test_types_that_are_not_shared():
    (module,) = Path(dolfinx_impact.__file__).parent.glob("_cpp*.so")
    done = subprocess.run([sys.executable, "-c", CODE, str(module)], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("refused: dolfinx_impact was built with nanobind "), done.stdout
    assert "pip install --no-build-isolation" in done.stdout
