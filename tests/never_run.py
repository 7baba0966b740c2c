# SPDX-License-Identifier: MIT
"""never_run.py PYTHON.json CPP.json FOLDER: which lines no test ran, from the reports of coverage and gcovr.

`make coverage` calls it in the checkout. It prints, for each package of python/ and each stage of cpp/, how many lines
there are and how many ran; FOLDER/never_run.txt has every line that none ran, with its text.
"""

import json
import pathlib
import sys
from typing import NamedTuple


class FileLines(NamedTuple):
    """The lines of one file that hold code, by number: those that ran, and those that never did."""

    path: pathlib.Path
    run: set[int]
    missed: set[int]


def python_files(report):
    """Files of a report that `coverage json` wrote."""
    return [
        FileLines(pathlib.Path(path), set(of["executed_lines"]), set(of["missing_lines"]))
        for path, of in sorted(report["files"].items())
    ]


def cpp_files(report):
    """Files of a report that `gcovr --json` wrote. A line of a template runs when one of its instances does."""
    found = []
    for of in sorted(report["files"], key=lambda of: of["file"]):
        lines = [line for line in of["lines"] if not line.get("gcovr/noncode")]
        run = {line["line_number"] for line in lines if line["count"] > 0}
        found.append(FileLines(pathlib.Path(of["file"]), run, {line["line_number"] for line in lines} - run))
    return found


def part_of(path):
    """The package or stage that a file belongs to: two folders of python/ and cpp/, one of the others."""
    folders = path.parts[:-1]
    return "/".join(folders[:3] if folders[0] in ("python", "cpp") else folders[:1])


def table(files):
    """One line of text for each part, and one for the sum: its lines, how many of them ran, and the share in per
    cent."""
    parts = {}
    for file in files:
        part = parts.setdefault(part_of(file.path), [0, 0])
        part[0] += len(file.run) + len(file.missed)
        part[1] += len(file.run)
    parts["all"] = [sum(counts) for counts in zip(*parts.values(), strict=True)]
    return [f"{name:44} {n:7,d} {run:7,d} {100 * run / max(n, 1):6.1f} %" for name, (n, run) in parts.items()]


def never_run(files, root):
    """One line of text for each line of the sources that never ran: path, number and text."""
    found = []
    for file in files:
        if file.missed:
            text = (root / file.path).read_text().splitlines()
            found += [f"{file.path}:{number}: {text[number - 1].strip()}" for number in sorted(file.missed)]
    return found


def main(python, cpp, folder):
    files = python_files(json.loads(pathlib.Path(python).read_text()))
    files += cpp_files(json.loads(pathlib.Path(cpp).read_text()))
    missed = never_run(files, pathlib.Path.cwd())
    target = pathlib.Path(folder) / "never_run.txt"
    target.write_text("".join(f"{line}\n" for line in missed))
    print(f"{'':44} {'lines':>7} {'ran':>7}")
    print("\n".join(table(files)))
    print(f"{len(missed):,d} lines never ran: {target}")


if __name__ == "__main__":
    main(*sys.argv[1:])
