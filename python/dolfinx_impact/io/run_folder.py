# SPDX-License-Identifier: MIT
"""One run, one folder: the parameters that made it, fields for ParaView, tables with units, figures.

    with RunFolder("results/press", {"load": 4e6}) as run:
        run.print("solving")
        run.fields("solution", [u, mises])                       # solution.bp, opened by ParaView 5.12 or newer
        run.table("line", {"z": (z, "m"), "shear": (tau, "Pa")})  # line.csv and line.h5, units as attributes

All methods are collective over the folder's communicator, and an error on rank 0 is raised on every rank.
"""

import csv
import datetime
import json
import os
import platform
import tempfile
from io import StringIO
from pathlib import Path

import numpy as np
from dolfinx import fem, io, la
from mpi4py import MPI

from . import hdf5
from .frames import write_once
from .gather import together


def versions():
    """Name -> version of the package and of what it stands on; "unknown" where a library does not say."""
    import importlib.metadata
    import subprocess
    import sys

    import basix
    import dolfinx
    import petsc4py.PETSc
    import ufl

    def of(distribution, fallback=None):
        try:
            return importlib.metadata.version(distribution)
        except importlib.metadata.PackageNotFoundError:
            return fallback or "unknown"

    def nanobind():
        """Debian ships nanobind without the metadata pip would know."""
        found = of("nanobind")
        if found == "unknown":
            command = [sys.executable, "-m", "nanobind", "--version"]
            done = subprocess.run(command, capture_output=True, text=True, timeout=20)
            found = done.stdout.strip() if done.returncode == 0 and done.stdout.strip() else found
        return found

    return {
        "dolfinx_impact": of("dolfinx_impact"),
        "dolfinx": dolfinx.__version__,
        "ffcx": of("fenics-ffcx"),
        "basix": basix.__version__,
        "ufl": of("fenics-ufl", getattr(ufl, "__version__", None)),
        "petsc": ".".join(str(part) for part in petsc4py.PETSc.Sys.getVersion()),
        "nanobind": nanobind(),
        "mpi": MPI.Get_library_version().split(",")[0].split("\n")[0].strip("\0 "),
        "numpy": np.__version__,
        "python": platform.python_version(),
    }


class RunFolder:
    """Folder of one run.

    Args:
        path: folder, made if it is not there; None: IMPACT_OUTPUT, or results/<name>.
        parameters: what makes this run different from another; written to parameters.json with versions and ranks.
        comm: communicator of the run.
        name: of the run, for the default folder and parameters.json.

    Raises:
        RuntimeError: the folder cannot be made or written; on all ranks.
    """

    def __init__(self, path=None, parameters=None, comm=MPI.COMM_WORLD, name="run"):
        self.comm, self.name = comm, name
        self.path = Path(path or os.environ.get("IMPACT_OUTPUT") or Path("results") / name).absolute()
        self.path = Path(comm.bcast(str(self.path), root=0))
        together(comm, self._make)
        self.write_parameters(parameters or {})

    def __repr__(self):
        return f"RunFolder({str(self.path)!r}, name={self.name!r}, ranks={self.comm.size})"

    def __enter__(self):
        return self

    def __exit__(self, *error):
        return False

    def _make(self):
        try:
            self.path.mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryFile(dir=self.path) as probe:
                probe.write(b"probe")
        except OSError as error:
            raise RuntimeError(
                f"results cannot be written to {self.path} ({error.strerror or error}): make room there, or name a "
                "folder that can be written (demos: --output DIR or the variable IMPACT_OUTPUT)"
            ) from error

    def _write(self, what, work):
        """Run work() on rank 0; a failure to write is the same RuntimeError on all ranks."""

        def guarded():
            try:
                return work()
            except OSError as error:
                reason = error.strerror or error
                raise RuntimeError(
                    f"{self.path / what} cannot be written ({reason}): make room there, or name another folder; what "
                    "was written before is untouched"
                ) from error

        return together(self.comm, guarded)

    def print(self, *args, **kwargs):
        """Print on rank 0, at once."""
        if self.comm.rank == 0:
            print(*args, **{"flush": True, **kwargs})

    def file(self, name):
        """Full path of a file in the folder."""
        return self.path / name

    def pictures(self, draw, *args):
        """Run draw(*args) on rank 0; where PyVista or a screen is missing, say so and go on without the picture."""

        def work():
            from .plots import NoScreen

            try:
                draw(*args)
            except (ImportError, NoScreen) as error:
                self.print(f"a picture is left out: {error}")

        self._write(self.path, work)

    def write_parameters(self, parameters):
        """Write parameters.json: the parameters, the versions, the number of ranks, the time."""
        path = self.file("parameters.json")
        record = {
            "run": self.name,
            "parameters": parameters,
            "ranks": self.comm.size,
            "written": datetime.datetime.now().astimezone().isoformat(timespec="seconds"),
        }

        def work():
            text = json.dumps({**record, "versions": versions()}, indent=2, default=_plain)
            hdf5.write_whole(path, text + "\n")

        self._write(path, work)
        return path

    def fields(self, name, functions, time=0.0, xdmf=False):
        """Write functions for ParaView.

        Args:
            name: of the file, without ending.
            functions: list of fem.Function with a name each; those of other degrees go to a file of their own,
                name_<degree>.bp.
            time: written with the fields [T].
            xdmf: write name.xdmf with HDF5 instead; fields are interpolated at the vertices of the mesh.

        Returns:
            List of paths.
        """
        paths = []
        if xdmf:
            path = self.file(f"{name}.xdmf")
            with io.XDMFFile(self.comm, path, "w") as file:
                file.write_mesh(functions[0].function_space.mesh)
                for function in functions:
                    file.write_function(_on_geometry(function), time)
            return [path]
        groups = {}
        for function in functions:
            mesh, element = function.function_space.mesh, function.function_space.element.basix_element
            groups.setdefault((id(mesh), element.degree, element.discontinuous), []).append(function)
        for k, ((_, degree, _), group) in enumerate(groups.items()):
            path = self.file(f"{name}.bp" if k == 0 else f"{name}_{degree}.bp")
            write_once(self, path.name, group, time)
            paths.append(path)
        return paths

    def table(self, name, columns):
        """Write name.csv and name.h5 on rank 0.

        Args:
            columns: dict name -> (values, unit), values of one length; as known on rank 0.

        Raises:
            ValueError: columns of different lengths.
        """
        paths = [self.file(f"{name}.csv"), self.file(f"{name}.h5")]

        def work():
            arrays = {key: (np.atleast_1d(values), unit) for key, (values, unit) in columns.items()}
            lengths = {key: len(values) for key, (values, _) in arrays.items()}
            if len(set(lengths.values())) > 1:
                raise ValueError(f"table {name!r}: the columns have different lengths, {lengths}")
            text = StringIO(newline="")
            writer = csv.writer(text)
            writer.writerow([f"{key} [{unit}]" for key, (_, unit) in arrays.items()])
            writer.writerows(zip(*(values.tolist() for values, _ in arrays.values())))
            hdf5.write_whole(paths[0], text.getvalue())

            def fill(file):
                for key, (values, unit) in arrays.items():
                    file.create_dataset(key, data=values).attrs["units"] = unit

            hdf5.create(paths[1], fill)

        self._write(paths[0], work)
        return paths


def _plain(value):
    """JSON form of NumPy numbers and arrays; anything else by its text."""
    return value.tolist() if hasattr(value, "tolist") else str(value)


def _on_geometry(function):
    """XDMF holds fields of the mesh's own degree only."""
    V = function.function_space
    degree, shape = V.mesh.geometry.cmap.degree, V.element.basix_element.degree
    if degree == shape and not V.element.basix_element.discontinuous:
        return function
    W = fem.functionspace(V.mesh, ("Lagrange", degree, V.value_shape))
    out = fem.Function(W, name=function.name)
    out.interpolate(function)
    return out


def vertex_average(expression, mesh, name):
    """A UFL expression (a stress, say) at the vertices: each cell's own value there, averaged over the cells that meet.

    Bodies that share no nodes are not mixed; within a body a jump between two materials is.

    Args:
        expression: scalar UFL expression of DOLFINx functions on `mesh`.
        name: of the result.

    Returns:
        fem.Function, continuous of degree 1.
    """
    from ..assembly.operators import PointValues

    V = fem.functionspace(mesh, ("Lagrange", 1))
    corners = V.element.basix_element.points
    values = PointValues(expression, corners).values()[..., 0]
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
