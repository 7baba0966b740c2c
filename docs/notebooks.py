# SPDX-License-Identifier: MIT
"""The demos and applications as notebooks: `make notebooks`, or `python3 docs/notebooks.py FOLDER [NAME...]`.

They are run, so that they have outputs and pictures, and end with a cell that shows the pictures that were written;
`--no-run` leaves the outputs out. The largest applications take minutes each.
"""

import argparse
import os
import sys
import tempfile
import time
from pathlib import Path

import jupytext
import nbformat

DEMOS = Path(__file__).resolve().parents[1] / "demos"
KERNEL = {"name": "python3", "display_name": "Python 3", "language": "python"}
PICTURES = """\
# The pictures that were written:
from pathlib import Path

from IPython.display import Image, display

for picture in sorted(Path().rglob("*.png")):
    display(Image(picture))"""


def sources(names=()):
    """Files of the demos and applications: all, or those named."""
    found = sorted(DEMOS.glob("*.py")) + sorted(DEMOS.glob("applications/*.py"))
    found = [path for path in found if path.name != "__init__.py"]
    missing = set(names) - {path.stem for path in found}
    if missing:
        raise ValueError(f"there is no demo {', '.join(sorted(missing))}; there are {', '.join(p.stem for p in found)}")
    return [path for path in found if not names or path.stem in names]


def read(path):
    """The notebook of a demo, without outputs."""
    notebook = jupytext.read(path, fmt="py:light")
    notebook.metadata["kernelspec"] = KERNEL
    notebook.cells.append(nbformat.v4.new_code_cell(PICTURES, metadata={"tags": ["pictures"]}))
    return notebook


def run(notebook):
    """Run a notebook's cells by this Python, in a folder of its own that is removed afterwards.

    Raises:
        nbclient.exceptions.CellExecutionError: a cell fails.
    """
    import ipykernel.kernelspec
    from nbclient import NotebookClient

    with tempfile.TemporaryDirectory() as folder:
        # The kernel "python3" of the system need not be the Python that has this package.
        ipykernel.kernelspec.write_kernel_spec(Path(folder, "kernels", "python3"))
        results = Path(folder, "results")
        results.mkdir()
        os.environ |= {"JUPYTER_PATH": folder, "IMPACT_OUTPUT": str(results), "MPLBACKEND": "Agg"}
        NotebookClient(
            notebook, kernel_name="python3", timeout=3600, resources={"metadata": {"path": results}}
        ).execute()


def write(folder, names=(), outputs=True):
    """Write notebooks into a folder, which is made where it is missing.

    Args:
        folder: where to write.
        names: of the demos; all without.
        outputs: whether they are run.

    Returns:
        The demos' files.
    """
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    for path in sources(names):
        notebook, start = read(path), time.perf_counter()
        if outputs:
            run(notebook)
            print(f"{path.stem}: {time.perf_counter() - start:.0f} s", file=sys.stderr, flush=True)
        jupytext.write(notebook, folder / f"{path.stem}.ipynb")
    return sources(names)


def main():
    parser = argparse.ArgumentParser(description="The demos and applications as notebooks.")
    parser.add_argument("folder", nargs="?", default="build/notebooks")
    parser.add_argument("names", nargs="*", metavar="NAME", help="of a demo or application; all without")
    parser.add_argument("--no-run", action="store_true", help="without outputs")
    given = parser.parse_args()
    try:
        print(f"{len(write(given.folder, given.names, not given.no_run))} notebooks in {given.folder}")
    except ValueError as error:
        print(f"notebooks: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
