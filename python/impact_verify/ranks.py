# SPDX-License-Identifier: MIT
"""Level g: the UFL side gives the same results on several ranks as on one.

As a module under mpirun it writes the values of one number of ranks; `run` starts it for each number and compares.
"""

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from dolfinx_impact.common.mpi_launcher import on_ranks
from dolfinx_impact.common.types import FloatArray
from . import contact_ranks, explicit_ranks
from .report import Report

if TYPE_CHECKING:
    from dolfinx.fem import FunctionSpace
    from dolfinx.mesh import Mesh, MeshTags

TOLERANCE = 1e-12
SOLUTION_TOLERANCE = 1e-9
REASON = "sums in another order"
CASES = (
    ("triangle", 2, "plane_strain"),
    ("quadrilateral", 1, "axisymmetric"),
    ("tetrahedron", 1, "3d"),
    ("tetrahedron", 2, "3d"),
    ("hexahedron", 1, "3d"),
    ("hexahedron", 2, "3d"),
)


def run(report: Report, ranks: Sequence[int] = (1, 2, 3), progress: bool = True, timeout: float = 600) -> None:
    """Add the rows of this level.

    Args:
        report: report to add to.
        ranks: numbers of ranks; 1 is always run.
        progress: not used; all levels share these arguments.
        timeout: longest duration of one run [s].

    Raises:
        RuntimeError: a run failed.
    """
    counts = sorted({1, *ranks})
    values: dict[int, dict[str, list[Any]]] = {}  # numbers in nested lists, as JSON has them
    with tempfile.TemporaryDirectory() as folder:
        for n in counts:
            path = Path(folder) / f"{n}.json"
            command = [*on_ranks(n), sys.executable, "-m", "impact_verify.ranks", str(path)]
            done = subprocess.run(command, capture_output=True, text=True, timeout=timeout, env=_environment())
            if done.returncode != 0:
                raise RuntimeError(f"the run on {n} ranks failed:\n{done.stdout[-2000:]}\n{done.stderr[-2000:]}")
            values[n] = json.loads(path.read_text())
    for key, reference in values[1].items():
        cell, degree, hypothesis, form = key.split("|")
        for n in counts[1:]:
            a, b = np.array(values[n].get(key, [])), np.array(reference)
            difference: float = np.inf
            note = f"{n} ranks give {a.shape} values, one gives {b.shape}"
            if a.shape == b.shape:
                error = np.where(np.isnan(a - b), np.inf, np.abs(a - b))
                k = np.unravel_index(np.argmax(error), error.shape)
                difference = error[k] / np.max(np.abs(b))
                note = f"entry {[int(i) for i in k]} by position: {a[k]:.15g} on {n} ranks, {b[k]:.15g} on 1"
            tolerance, reason = TOLERANCE, REASON
            if form == "solution" or form.startswith("contact."):
                tolerance, reason = SOLUTION_TOLERANCE, "round-off times condition number"
            elif form.startswith("explicit."):
                tolerance, reason = SOLUTION_TOLERANCE, explicit_ranks.REASON
            report.add(
                "ranks", form, cell, int(degree), 1, hypothesis, difference, tolerance, reason,
                f"{n} ranks against 1", note,
            )  # fmt: skip


def _environment() -> dict[str, str]:
    """Environment for mpirun, which otherwise refuses root, and more ranks than cores. Ranks that wait for each other
    leave their core to others."""
    extra = {"OMP_NUM_THREADS": "1", "PRTE_MCA_rmaps_default_mapping_policy": ":oversubscribe"}
    extra["OMPI_MCA_mpi_yield_when_idle"] = "1"
    if os.geteuid() == 0:
        extra |= {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
    return {**extra, **os.environ}


def _values() -> dict[str, Any]:
    """Results by "cell|degree|hypothesis|form" on rank 0, sorted by position so that no numbering matters."""
    import ufl
    from dolfinx import fem, mesh
    from mpi4py import MPI

    from dolfinx_impact import loads, materials
    from dolfinx_impact.assembly import lumped_mass, operators
    from dolfinx_impact.statics.static_problem import StaticProblem

    comm = MPI.COMM_WORLD
    out = contact_ranks.values(comm, _gather) | explicit_ranks.values(comm, _gather)
    for cell, degree, hypothesis in CASES:
        kind = getattr(mesh.CellType, cell)
        if hypothesis == "3d":
            domain = mesh.create_box(comm, [[0, 0, 0], [1, 1.1, 1.2]], [4, 4, 4], kind)
        else:
            domain = mesh.create_rectangle(comm, [[0.5, 0], [1.5, 1.1]], [7, 6], kind)
        dim = domain.geometry.dim
        x = domain.geometry.x
        x[:, :dim] += 0.02 * np.sin(5 * x[:, :dim][:, ::-1] + np.arange(dim))
        V = fem.functionspace(domain, ("Lagrange", degree, (dim,)))
        u = fem.Function(V, name="u")
        u.interpolate(lambda p: 0.03 * np.array([np.sin(2 * p[i] + p[(i + 1) % dim]) for i in range(dim)]))
        v = ufl.TestFunction(V)
        for material_class in (materials.LinearElastic, materials.NeoHookean):
            material = material_class(1.0, 0.3, 1.0, hypothesis)
            law = material_class.law_class.name
            f = operators.InternalForce(operators.internal_force_form(u, v, material)).apply().array
            out[f"{cell}|{degree}|{hypothesis}|{law}.force"] = _gather(V, f)
            energy = operators.Energy(operators.strain_energy_form(u, material)).value()
            out[f"{cell}|{degree}|{hypothesis}|{law}.energy"] = [energy]
        steel = materials.LinearElastic(1.0, 0.3, 1.0, hypothesis)
        out[f"{cell}|{degree}|{hypothesis}|lumped_mass"] = _gather(V, lumped_mass.lumped_mass(V, steel).array)
        tags = _ends(domain, dim)
        clamped = fem.locate_dofs_topological(V, dim - 1, tags.find(1))
        w = fem.Function(V, name="u")
        pull = loads.Traction(tags, 2, np.arange(1.0, dim + 1) / 100)
        StaticProblem(w, steel, bcs=[fem.dirichletbc(np.zeros(dim), clamped, V)], loads=[pull]).solve()
        out[f"{cell}|{degree}|{hypothesis}|solution"] = _gather(V, w.x.array)
    return out


def _ends(domain: "Mesh", dim: int) -> "MeshTags":
    """Facets of the lower end, tag 1, and of the upper end, tag 2."""
    from dolfinx import mesh

    low = mesh.locate_entities_boundary(domain, dim - 1, lambda p: p[dim - 1] < 0.05)
    high = mesh.locate_entities_boundary(domain, dim - 1, lambda p: p[dim - 1] > (1.05 if dim == 2 else 1.15))
    facets = np.concatenate([low, high])
    values = np.repeat([1, 2], [len(low), len(high)]).astype(np.int32)
    order = np.argsort(facets)
    return mesh.meshtags(domain, dim - 1, facets[order], values[order])


def _gather(V: "FunctionSpace", array: FloatArray) -> list[Any] | None:
    """Nodal values of all ranks on rank 0, sorted by the position of their nodes."""
    comm, bs = V.mesh.comm, V.dofmap.index_map_bs
    owned = V.dofmap.index_map.size_local
    x = comm.gather(V.tabulate_dof_coordinates()[:owned], root=0)
    values = comm.gather(np.array(array[: bs * owned]).reshape(owned, bs), root=0)
    if comm.rank != 0:
        return None
    x, values = np.concatenate(x), np.concatenate(values)
    order = np.lexsort(np.round(x, 8).T)
    return values[order].tolist()


def main() -> None:
    """Write the results of the ranks of this process to the file that the first argument names."""
    from mpi4py import MPI

    values = _values()
    if MPI.COMM_WORLD.rank == 0:
        Path(sys.argv[1]).write_text(json.dumps(values))


if __name__ == "__main__":
    main()
