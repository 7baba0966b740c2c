# SPDX-License-Identifier: MIT
"""Folders of tests/unit on the path: a module of checks or of bodies is imported by its name from any folder.

Each file name is used once in tests/unit (tests/architecture holds that), so that a name says which file it is.
"""

import pathlib
import sys

UNIT = pathlib.Path(__file__).resolve().parent / "unit"


def put_on_path():
    """Append every folder of tests/unit that holds Python files to sys.path; at the end, where they hide nothing."""
    for folder in sorted({str(file.parent) for file in UNIT.rglob("*.py")} - set(sys.path)):
        sys.path.append(folder)
