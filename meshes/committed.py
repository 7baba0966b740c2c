# SPDX-License-Identifier: MIT
"""The small meshes kept in meshes/files with their checksums: what made them, and where they are.

`python -m dolfinx_impact.meshes.committed` writes them again (another gmsh may number the nodes differently) together
with checksums.txt.
"""

import hashlib
from pathlib import Path

FOLDER = Path(__file__).parent / "files"
CHECKSUMS = Path(__file__).parent / "checksums.txt"

FILES = {
    "distorted_hexahedra.msh": (
        "block",
        {"size": (1.0, 1.0, 1.0), "cells": (4, 4, 4), "distortion": 0.25},
    ),
    "wheel_on_rail_2d.msh": (
        "wheel_on_rail_2d",
        {"a": 6.0e-3, "h": 3.0e-3, "core": 9.0e-3, "rail_length": 0.8, "coarse": 0.08},
    ),
    "sphere_tetrahedra.msh": (
        "sphere_on_half_space",
        {"cell": "tetrahedron", "a": 2.0e-3, "h": 1.5e-3, "core": 3.0e-3, "coarse": 4.0e-3},
    ),
}


def path(name):
    """Full path of a committed mesh."""
    if name not in FILES:
        raise ValueError(f"no committed mesh {name!r}; there are: {', '.join(FILES)}")
    return FOLDER / name


def checksum(file):
    """SHA-256 of a file, in hexadecimal."""
    return hashlib.sha256(Path(file).read_bytes()).hexdigest()


def checksums():
    """File name -> SHA-256 as written in checksums.txt."""
    return {name: digest for digest, name in (line.split() for line in CHECKSUMS.read_text().splitlines() if line)}


def main():
    """Write all committed meshes and checksums.txt."""
    from . import write

    FOLDER.mkdir(exist_ok=True)
    for name, (recipe, parameters) in FILES.items():
        write(recipe, FOLDER / name, **parameters)
    CHECKSUMS.write_text("".join(f"{checksum(FOLDER / name)}  {name}\n" for name in FILES))


if __name__ == "__main__":
    main()
