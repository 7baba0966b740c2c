# SPDX-License-Identifier: MIT
"""Uses the module of exchange.cpp beside DOLFINx from the wheel, on any number of ranks: prints which facts hold."""

import dolfinx_solver  # noqa: F401  (first: it loads MPI by way of mpi4py)

# isort: split
import re

import basix
import dolfinx
import numpy as np
import ufl
from dolfinx import fem, mesh
from dolfinx.fem.petsc import assemble_matrix, create_vector
from mpi4py import MPI
from petsc4py import PETSc

from wheel_probe import _exchange as probe

LIBRARIES = ("mpi", "petsc", "slepc", "dolfinx", "basix", "spdlog", "fmt", "hdf5", "stdc++")


def mapped():
    """Files of this process that are libraries of one of the names, by name."""
    with open("/proc/self/maps") as maps:
        paths = {line.split(maxsplit=5)[5].strip() for line in maps if "/" in line}
    pattern = r"/lib{}(-[0-9a-f]{{8}})?\.so[0-9.]*$"
    return {name: sorted(p for p in paths if re.search(pattern.format(re.escape(name)), p)) for name in LIBRARIES}


def facts(comm):
    """Pairs (what, whether it holds), in the order in which they are tried."""
    square = mesh.create_unit_square(comm, 8, 8)
    space = fem.functionspace(square, ("Lagrange", 2))
    u, v = ufl.TrialFunction(space), ufl.TestFunction(space)
    linear = fem.form(ufl.inner(ufl.SpatialCoordinate(square)[0], v) * ufl.dx)
    bilinear = fem.form(ufl.inner(ufl.grad(u), ufl.grad(v)) * ufl.dx + ufl.inner(u, v) * ufl.dx)

    sizes = probe.sizes()
    yield f"sizes of {len(sizes)} classes: {sizes}", all(here == there for here, there in sizes.values())
    petsc = probe.petsc()
    yield f"PETSc of headers and library: {petsc}", all(here == there for here, there in petsc.values())

    count, same = probe.count_entities(square._cpp_object, 1)
    yield f"edges by MPI_Allreduce and by DOLFINx: {count}, {same}", count == same == 3 * 64 + 16
    yield "a mesh handed in and back is the same Python object", (
        probe.same_mesh(square._cpp_object) is square._cpp_object
    )

    vector = fem.assemble_vector(linear)
    vector.scatter_reverse(dolfinx.la.InsertMode.add)
    own, theirs = probe.assemble(linear._cpp_object), dolfinx.la.norm(vector)
    yield f"norm of a vector: {own:.15g}, DOLFINx's {theirs:.15g}", bool(np.isclose(own, theirs, rtol=1e-14))

    theirs = assemble_matrix(bilinear)
    theirs.assemble()
    own = probe.assemble_matrix(bilinear._cpp_object)
    difference = (own - theirs).norm()
    yield f"difference of two matrices of PETSc: {difference:.3g}", difference < 1e-14 * theirs.norm()
    x, y = own.createVecs()
    x.set(1.0)
    norm = probe.multiply(own, x, y)
    yield f"norm of y = A x: {norm:.15g} here, {y.norm():.15g} by petsc4py", norm == y.norm()
    yield "A 1 = M 1 sums to the area", abs(y.sum() - 1) < 1e-12
    value = probe.largest_eigenvalue(own)
    yield f"largest eigenvalue by SLEPc: {value:.6g}", 0 < value <= own.norm(PETSc.NormType.INFINITY)

    f = fem.Function(space)
    f.x.array[: space.dofmap.index_map.size_local] = comm.rank + 1
    probe.update_ghosts(f._cpp_object)
    owners = space.dofmap.index_map.owners
    yield f"{len(owners)} ghosts have their owners' values", bool(
        np.all(f.x.array[space.dofmap.index_map.size_local :] == owners + 1)
    )

    made = probe.rectangle(comm, 5)
    yield "a mesh made here is DOLFINx's class", type(made) is type(square._cpp_object)
    own_mesh = mesh.Mesh(made, square.ufl_domain())
    area = comm.allreduce(fem.assemble_scalar(fem.form(1.0 * ufl.dx(own_mesh))), MPI.SUM)
    yield f"its area: {area:.15g}", abs(area - 1) < 1e-13

    table = basix.create_element(basix.ElementFamily.P, basix.CellType.triangle, 2).tabulate(0, np.zeros((1, 2)))
    yield "shape functions of libbasix", bool(np.allclose(probe.tabulate_at_origin(), table.ravel(), atol=1e-15))

    levels = []
    for level in (dolfinx.log.LogLevel.INFO, dolfinx.log.LogLevel.ERROR):
        dolfinx.log.set_log_level(level)
        levels.append((probe.log_level(), int(level)))
    yield f"log levels here and there: {levels}", all(here == there for here, there in levels)

    try:
        probe.finalize_twice(square._cpp_object)
    except RuntimeError as error:
        yield f"an error of libdolfinx arrives: {str(error)[:60]}", True
    else:
        yield "an error of libdolfinx arrives", False

    create_vector(space).destroy()
    for name, paths in mapped().items():
        yield f"lib{name}: {len(paths)} mapped: {', '.join(paths)}", len(paths) == 1


def main():
    comm = MPI.COMM_WORLD
    failed = []
    for what, holds in facts(comm):
        holds = comm.allreduce(bool(holds), MPI.LAND)
        if comm.rank == 0:
            print(("holds  " if holds else "FAILS  ") + what, flush=True)
        if not holds:
            failed.append(what)
    if comm.rank == 0:
        print(f"{comm.size} ranks: {len(failed)} facts fail", flush=True)
    raise SystemExit(bool(failed))


if __name__ == "__main__":
    main()
