# SPDX-License-Identifier: MIT
"""The demos and applications as notebooks: `make notebooks`, or `python3 docs/notebooks.py FOLDER`."""

import sys
from pathlib import Path

import jupytext

DEMOS = Path(__file__).resolve().parents[1] / "demos"
KERNEL = {"name": "python3", "display_name": "Python 3", "language": "python"}


def sources():
    """Files of the demos and applications."""
    found = sorted(DEMOS.glob("*.py")) + sorted(DEMOS.glob("applications/*.py"))
    return [path for path in found if path.name != "__init__.py"]


def write(folder):
    """Write a notebook for each demo into a folder, which is made where it is missing; returns the demos' files."""
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    for path in sources():
        notebook = jupytext.read(path, fmt="py:light")
        notebook.metadata["kernelspec"] = KERNEL
        jupytext.write(notebook, folder / f"{path.stem}.ipynb")
    return sources()


if __name__ == "__main__":
    target = sys.argv[1] if len(sys.argv) > 1 else "build/notebooks"
    print(f"{len(write(target))} notebooks in {target}")
