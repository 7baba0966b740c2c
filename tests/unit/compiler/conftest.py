# SPDX-License-Identifier: MIT
"""The comparison with FFCx (tests/unit/kernels/kernel_oracle.py) serves these tests too."""

import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "kernels"))
