# SPDX-License-Identifier: MIT
"""stub.py FOLDER: write the typed stub of the compiled module, one file for each of its submodules, into a folder.

nanobind writes it from the signatures of the bindings. What it does not know is put in here: arrays are NumPy's, with
the type of their values, and PETSc's and mpi4py's objects, which casters of DOLFINx convert, have names of their own.
`make stub` writes the stub into python/dolfinx_impact/_cpp, and a test says when that one is stale.
"""

import pathlib
import re
import sys
from typing import Any

import black
from nanobind.stubgen import StubGen

import dolfinx_impact._cpp as module

HEADER = "# SPDX-License-Identifier: MIT\n# Written by `make stub` from cpp/bindings: not to be changed by hand.\n"
CASTERS = {"mat": "petsc4py.PETSc.Mat", "vec": "petsc4py.PETSc.Vec", "MPICommWrapper": "mpi4py.MPI.Comm"}


class Stub(StubGen):
    """nanobind's writer of stubs, with types of arrays and of objects that casters convert."""

    def simplify_types(self, signature: str) -> str:
        names = "|".join(CASTERS)
        signature = re.sub(rf"(?<![\w.])({names})(?=[\s,)\]]|$)", lambda found: CASTERS[found[1]], signature)
        signature = self.ndarray_re.sub(self.array, signature)
        return super().simplify_types(signature)

    def array(self, found: re.Match[str]) -> str:
        """The annotation of an array: nanobind converts the values of those that are only read."""
        name = self.import_object("numpy.typing", "NDArray")
        values = re.search(r"dtype=(\w+)", found[2])
        if values is None:
            return f"{name}[typing.Any]"
        if values[1] == "bool":
            return f"{name}[numpy.bool_]"
        if "writable=False" in found[2]:
            return f"{name}[numpy.{'floating' if values[1].startswith('float') else 'integer'}[typing.Any]]"
        return f"{name}[numpy.{values[1]}]"

    def put_nb_static_property(self, name: str | None, prop: Any) -> None:
        """A static property; nanobind would give it its signature for a docstring."""
        signature = prop.fget.__nb_signature__[0][0]
        self.write_ln(f"{name}: {self.simplify_types(signature[signature.find('/) -> ') + 6 :])}")
        self.write("\n")


def text(part: Any) -> str:
    """The stub of a module or of one of its submodules."""
    stub = Stub(part, include_external_imports=False)
    stub.put(part)
    return black.format_str(HEADER + stub.get(), mode=black.Mode(line_length=120, is_pyi=True))


def stubs() -> dict[str, str]:
    """The text of each file of the stub, by its name."""
    parts = {name: part for name, part in vars(module).items() if type(part) is type(module)}
    return {"__init__.pyi": text(module)} | {f"{name}.pyi": text(part) for name, part in parts.items()}


def main(folder: str) -> None:
    target = pathlib.Path(folder)
    target.mkdir(parents=True, exist_ok=True)
    fresh = stubs()
    for old in target.glob("*.pyi"):
        if old.name not in fresh:
            old.unlink()
    for name, content in fresh.items():
        (target / name).write_text(content)


if __name__ == "__main__":
    main(*sys.argv[1:])
