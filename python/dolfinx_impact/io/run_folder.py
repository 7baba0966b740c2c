# SPDX-License-Identifier: MIT
"""Folder of one run: its parameters, fields for ParaView, tables with units, figures.

    with RunFolder("results/press", {"load": 4e6}) as run:
        run.print("solving")
        run.fields("solution", [u, mises])                       # solution.bp, opened by ParaView 5.12 or newer
        run.table("line", {"z": (z, "m"), "shear": (tau, "Pa")})  # line.csv and line.h5, units as attributes

All methods are collective over the folder's communicator, and an error on rank 0 is raised on every rank.
"""

from __future__ import annotations

import csv
import datetime
import json
import os
import platform
from collections.abc import Callable, Mapping, Sequence
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import ufl
from dolfinx import fem, la
from dolfinx.mesh import Mesh
from mpi4py import MPI

from .. import compat
from ..common.types import ArrayLike, FilePath
from . import hdf5
from .frames import write_once
from .output_folder import OutputFolder
from .xdmf_series import XdmfSeries

if TYPE_CHECKING:
    import h5py


def versions() -> dict[str, str]:
    """Versions of the package and of its dependencies.

    Returns:
        Versions by name; "unknown" for a library that does not have one.
    """
    import importlib.metadata
    import subprocess
    import sys

    import petsc4py.PETSc

    def of(distribution: str) -> str:
        try:
            return importlib.metadata.version(distribution)
        except importlib.metadata.PackageNotFoundError:
            return "unknown"

    def nanobind() -> str:
        """Version of nanobind; Debian's package has no metadata for importlib."""
        found = of("nanobind")
        if found == "unknown":
            command = [sys.executable, "-m", "nanobind", "--version"]
            done = subprocess.run(command, capture_output=True, text=True, timeout=20)
            found = done.stdout.strip() if done.returncode == 0 and done.stdout.strip() else found
        return found

    return {
        "dolfinx_impact": of("dolfinx_impact"),
        **compat.versions(),
        "petsc": ".".join(str(part) for part in petsc4py.PETSc.Sys.getVersion()),
        "nanobind": nanobind(),
        "mpi": MPI.Get_library_version().split(",")[0].split("\n")[0].strip("\0 "),
        "numpy": np.__version__,
        "python": platform.python_version(),
    }


class RunFolder(OutputFolder):
    """Folder of one run.

    Args:
        path: folder, created if it does not exist; None: IMPACT_OUTPUT, or results/<name>.
        parameters: parameters of the run by name; written to parameters.json with versions and ranks. None: the file
            is not written before `write_parameters` is called.
        comm: communicator of the run.
        name: name of the run, for the default folder and parameters.json.
        alone: lock the folder, until `close`, the end of a `with` block or of the process: no other run that does so
            writes there.

    Attributes:
        path: absolute path of the folder.

    Raises:
        RuntimeError: the folder cannot be created or written, or another run has locked it; on all ranks.
    """

    def __init__(
        self,
        path: FilePath | None = None,
        parameters: Mapping[str, Any] | None = None,
        comm: MPI.Intracomm = MPI.COMM_WORLD,
        name: str = "run",
        alone: bool = False,
    ) -> None:
        super().__init__(path or os.environ.get("IMPACT_OUTPUT") or Path("results") / name, comm, alone)
        self.name = name
        if parameters is not None:
            self.write_parameters(parameters)

    def __repr__(self) -> str:
        return f"RunFolder({str(self.path)!r}, name={self.name!r}, ranks={self.comm.size})"

    def print(self, *args: object, **kwargs: Any) -> None:
        """Print on rank 0, without buffering.

        Args:
            args: as for `print`.
            kwargs: as for `print`.
        """
        if self.comm.rank == 0:
            print(*args, **{"flush": True, **kwargs})

    def pictures(self, draw: Callable[..., object], *args: Any) -> None:
        """Draw figures on rank 0; without PyVista or a screen, print a message instead. Collective.

        Args:
            draw: function that draws and writes figures.
            args: its arguments.

        Raises:
            RuntimeError: a figure cannot be written; on all ranks.
        """

        def work() -> None:
            from .plots import NoScreen

            try:
                draw(*args)
            except (ImportError, NoScreen) as error:
                self.print(f"a picture is left out: {error}")

        self.write(self.path, work)

    def write_parameters(self, parameters: Mapping[str, Any]) -> Path:
        """Write parameters.json with parameters, versions, number of ranks and time of writing. Collective.

        Args:
            parameters: parameters of the run by name.

        Returns:
            Path of the file.

        Raises:
            RuntimeError: the file cannot be written; on all ranks.
        """
        path = self.file("parameters.json")
        record = {
            "run": self.name,
            "parameters": parameters,
            "ranks": self.comm.size,
            "written": datetime.datetime.now().astimezone().isoformat(timespec="seconds"),
        }

        def work() -> None:
            text = json.dumps({**record, "versions": versions()}, indent=2, default=_plain)
            hdf5.write_whole(path, text + "\n")

        self.write(path, work)
        return path

    def fields(self, name: str, functions: Sequence[fem.Function], time: float = 0.0, xdmf: bool = False) -> list[Path]:
        """Write functions for ParaView. Collective.

        Args:
            name: name of the file, without ending.
            functions: functions with names; those of other degrees than the first are written to files of their own,
                name_<degree>.bp.
            time: time of the fields [T].
            xdmf: write name.xdmf with HDF5 instead; fields are interpolated to the degree of the mesh.

        Returns:
            Paths of the files.

        Raises:
            RuntimeError: a file cannot be written; on all ranks.
        """
        paths = []
        if xdmf:
            series = XdmfSeries(self, f"{name}.xdmf", [_on_geometry(function) for function in functions])
            series.write(time)
            return [series.path]
        groups: dict[tuple[int, int, bool], list[fem.Function]] = {}
        for function in functions:
            mesh, element = function.function_space.mesh, function.function_space.element.basix_element
            groups.setdefault((id(mesh), element.degree, element.discontinuous), []).append(function)
        for k, ((_, degree, _), group) in enumerate(groups.items()):
            path = self.file(f"{name}.bp" if k == 0 else f"{name}_{degree}.bp")
            write_once(self, path.name, group, time)
            paths.append(path)
        return paths

    def table(self, name: str, columns: Mapping[str, tuple[ArrayLike, str]]) -> list[Path]:
        """Write name.csv and name.h5 on rank 0. Collective.

        Args:
            name: name of the files, without ending.
            columns: values and unit by name, with values of one length; those of rank 0 are written.

        Returns:
            Paths of the files.

        Raises:
            RuntimeError: a file cannot be written; on all ranks.
            ValueError: the columns have different lengths; on all ranks.
        """
        paths = [self.file(f"{name}.csv"), self.file(f"{name}.h5")]

        def work() -> None:
            arrays = {key: (np.atleast_1d(values), unit) for key, (values, unit) in columns.items()}
            lengths = {key: len(values) for key, (values, _) in arrays.items()}
            if len(set(lengths.values())) > 1:
                raise ValueError(f"table {name!r}: the columns have different lengths, {lengths}")
            text = StringIO(newline="")
            writer = csv.writer(text)
            writer.writerow([f"{key} [{unit}]" for key, (_, unit) in arrays.items()])
            writer.writerows(zip(*(values.tolist() for values, _ in arrays.values())))
            hdf5.write_whole(paths[0], text.getvalue())

            def fill(file: h5py.File) -> None:
                for key, (values, unit) in arrays.items():
                    file.create_dataset(key, data=values).attrs["units"] = unit

            hdf5.create(paths[1], fill)

        self.write(paths[0], work)
        return paths


def _plain(value: Any) -> Any:
    """NumPy numbers and arrays as Python numbers and lists for JSON, anything else as text."""
    return value.tolist() if hasattr(value, "tolist") else str(value)


def _on_geometry(function: fem.Function) -> fem.Function:
    """The function, interpolated to the degree of the mesh if it has another; XDMF needs that."""
    V = function.function_space
    degree, shape = compat.coordinate_element(V.mesh).degree, V.element.basix_element.degree
    if degree == shape and not V.element.basix_element.discontinuous:
        return function
    W = fem.functionspace(V.mesh, ("Lagrange", degree, V.value_shape))
    out = fem.Function(W, name=function.name)
    out.interpolate(function)
    return out


def vertex_average(expression: ufl.core.expr.Expr, mesh: Mesh, name: str) -> fem.Function:
    """Average a UFL expression, for example a stress, at the vertices over the cells that meet there. Collective.

    Bodies that share no nodes are not mixed. Within a body the values of different materials are averaged.

    Args:
        expression: scalar UFL expression of DOLFINx functions on `mesh`.
        mesh: mesh of the result.
        name: name of the result.

    Returns:
        Continuous function of degree 1.
    """
    from ..assembly.operators import PointValues

    V = fem.functionspace(mesh, ("Lagrange", 1))
    vertices = V.element.basix_element.points
    values = PointValues(expression, vertices).values()[..., 0]
    num_cells = values.shape[0]
    dofs = V.dofmap.list[:num_cells]
    out, count = fem.Function(V, name=name), fem.Function(V)
    np.add.at(out.x.array, dofs.ravel(), values.ravel())
    np.add.at(count.x.array, dofs.ravel(), 1.0)
    for part in (out, count):
        part.x.scatter_reverse(la.InsertMode.add)
        part.x.scatter_forward()
    out.x.array[:] /= np.maximum(count.x.array, 1.0)
    return out
