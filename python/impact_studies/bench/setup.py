# SPDX-License-Identifier: MIT
"""What the benchmarks of operators share: cases, a body with the operators of both sides, and a clock."""

import resource
import time
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import TypeAlias, Union

import numpy as np
import ufl
from dolfinx import cpp, fem, mesh
from mpi4py import MPI

from dolfinx_impact.assembly.ffcx_form import ffcx_form
from dolfinx_impact import _cpp, compat, materials
from dolfinx_impact.assembly import operators
from dolfinx_impact.common.types import Float64Array, FloatArray
from dolfinx_impact.io.partition import partition

# Cell, degree and cells per side.
Case: TypeAlias = tuple[str, int, int]
MaterialClass: TypeAlias = type[Union[materials.LinearElastic, materials.NeoHookean, materials.StVenantKirchhoff]]

STRICT = ["-O3", "-march=native"]
FAST = ["-O3", "-march=native", "-ffast-math"]
# Some hundred thousand degrees of freedom each: more than the caches hold.
CASES = (
    ("triangle", 1, 300),
    ("triangle", 2, 160),
    ("quadrilateral", 1, 400),
    ("quadrilateral", 2, 160),
    ("tetrahedron", 1, 32),
    ("tetrahedron", 2, 22),
    ("hexahedron", 1, 50),
    ("hexahedron", 2, 20),
)
PLANE = ("triangle", "quadrilateral")
FINITE = (("tetrahedron", 2, 22), ("hexahedron", 1, 50))


def best_time(function: Callable[[], object], at_least: float = 0.05, rounds: int = 3) -> tuple[float, float]:
    """Processor time of one call of a function.

    Args:
        function: function without arguments.
        at_least: duration of a round, which repeats the call [s].
        rounds: number of rounds.

    Returns:
        Best and median time of the rounds [s].
    """
    function()
    times: list[float] = []
    repeat = 1
    while len(times) < rounds:
        start = time.process_time()
        for _ in range(repeat):
            function()
        elapsed = time.process_time() - start
        if elapsed < at_least:
            repeat = max(repeat + 1, int(repeat * at_least / max(elapsed, 1e-6)))
            continue
        times.append(elapsed / repeat)
    return min(times), float(np.median(times))


def space(cell: str, degree: int, n: int, comm: MPI.Intracomm) -> fem.FunctionSpace:
    """Space of the displacement on a unit square or cube.

    Several ranks have equal numbers of cells, by `partition`: where DOLFINx's partitioner leaves one of them up to 3 %
    more, its time tells of that.

    Args:
        cell: cell of the mesh.
        degree: degree of the displacement.
        n: cells per side.
        comm: communicator of the mesh.

    Returns:
        The space.
    """
    kind = getattr(mesh.CellType, cell)
    plane = cell in PLANE
    domain = mesh.create_unit_square(comm, n, n, kind) if plane else mesh.create_unit_cube(comm, n, n, n, kind)
    domain = partition(domain).mesh if comm.size > 1 else domain
    return fem.functionspace(domain, ("Lagrange", degree, (2 if plane else 3,)))


@lru_cache(maxsize=1)
def cached_space(cell: str, degree: int, n: int) -> fem.FunctionSpace:
    """The same on one process, kept until another one is asked for: measurements that follow each other share it.

    Args:
        cell: see space.
        degree: see space.
        n: see space.

    Returns:
        The space.
    """
    return space(cell, degree, n, MPI.COMM_SELF)


def most_memory(status: Path = Path("/proc/self/status")) -> float:
    """Largest size of this process in memory since it began.

    Where the system does not tell it (a sandbox may lack the line), it is what getrusage tells, which counts the
    process that has started this one.

    Args:
        status: file of the system about this process.

    Returns:
        Resident set [B].
    """
    for line in status.read_text().splitlines() if status.exists() else ():
        if line.startswith("VmHWM:"):
            return 1024.0 * float(line.split()[1])
    return 1024.0 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


class Setup:
    """A unit square or cube with the form of its internal force, and the operators of both sides.

    Args:
        cell: cell of the mesh.
        degree: degree of the displacement, 1 or 2.
        n: cells per side.
        law: class of the material.
        comm: communicator of the mesh.
    """

    def __init__(
        self,
        cell: str,
        degree: int,
        n: int,
        law: MaterialClass = materials.LinearElastic,
        comm: MPI.Intracomm = MPI.COMM_SELF,
    ) -> None:
        self.V = cached_space(cell, degree, n) if comm == MPI.COMM_SELF else space(cell, degree, n, comm)
        self.mesh = self.V.mesh
        plane = cell in PLANE
        dim = 2 if plane else 3
        self.u = fem.Function(self.V, name="u")
        self.u.interpolate(lambda x: 0.01 * np.array([np.sin(3 * x[i] + x[(i + 1) % dim]) for i in range(dim)]))
        material = law(1e3, 0.3, 1.0, "plane_strain" if plane else "3d")
        self.form = operators.internal_force_form(self.u, ufl.TestFunction(self.V), material)
        self.num_cells: int = self.mesh.topology.index_map(self.mesh.topology.dim).size_local
        self.b: Float64Array = fem.Function(self.V).x.array
        self.pack_seconds: float | None = None

    def ours(self, width: int = 0) -> tuple[float, operators.InternalForce]:
        """Time our operator.

        Args:
            width: number of cells per kernel call; 0 takes the default.

        Returns:
            Time per application [s], and the operator.
        """
        operator = operators.InternalForce(self.form, width)
        return best_time(lambda: operator._cpp_object.assemble(self.b))[1], operator

    def baseline(self, flags: list[str]) -> tuple[float, FloatArray]:
        """Time assemble_vector of the installed DOLFINx, with coefficients packed into reused storage.

        Args:
            flags: compiler flags of FFCx's kernel.

        Returns:
            Time per application [s], and the assembled vector, shape (num_dofs) [F].
        """
        form = ffcx_form(self.form, jit_options={"cffi_extra_compile_args": flags})._cpp_object
        constants, coefficients = cpp.fem.pack_constants(form), cpp.fem.pack_coefficients(form)
        if self.pack_seconds is None:  # the same for all flags
            self.pack_seconds = best_time(_cpp.bench.Packed(form).pack)[1]
        apply = best_time(lambda: cpp.fem.assemble_vector(self.b, form, constants, coefficients))[1]
        self.b[:] = 0.0
        cpp.fem.assemble_vector(self.b, form, constants, coefficients)
        return self.pack_seconds + apply, self.b.copy()

    def bytes(self) -> int:
        """Memory traffic of one application if every node number and nodal value is transferred once.

        Returns:
            Traffic [B].
        """
        nodes = self.V.dofmap.list.shape[1]
        per_cell = 4 * (2 * nodes + compat.geometry_dofmap(self.mesh).shape[1])
        return self.num_cells * per_cell + 8 * 3 * len(self.b) + 24 * len(self.mesh.geometry.x)
