# SPDX-License-Identifier: MIT
"""Check of several ranks against one, where the process was started under mpirun."""

from __future__ import annotations

import numpy as np
from dolfinx import fem
from dolfinx import mesh as meshes
from dolfinx.la import InsertMode
from dolfinx.mesh import Mesh
from mpi4py import MPI

from dolfinx_impact.common.collective import agree, attempt
from dolfinx_impact.common.types import FloatArray
from dolfinx_impact.own_forms.distorted_block import distort
from .assembled import AssembledForm, quick_form
from .fields import fields_of
from dolfinx_impact.own_forms.own_form import made
from .subject import Subject

TOLERANCE, REASON = 1e-11, "sums in another order"


def whole_block(comm: MPI.Comm, cell: str, n: int) -> Mesh:
    """The block of the checks, distributed over ranks.

    Args:
        comm: communicator.
        cell: cell.
        n: cells per side.
    """
    kind = getattr(meshes.CellType, cell)
    if cell in ("triangle", "quadrilateral"):
        mesh = meshes.create_unit_square(comm, n, n, kind)
    else:
        mesh = meshes.create_unit_cube(comm, n, n, n, kind)
    distort(mesh, 0.08)
    mesh.geometry.x[:, 0] += 0.5
    return mesh


def _forces(subject: Subject, mesh: Mesh) -> tuple[FloatArray, FloatArray] | None:
    """Places and forces of all nodes, in the order of their places, on rank 0."""
    own, error = attempt(made, subject.make, subject.name, mesh)
    agree(mesh.comm, error, "self_check")  # an error of a user's function on one rank ends the check on all
    assert own.residual is not None
    V = own.u.function_space
    for f in fields_of(V):
        values = f.interpolate(
            lambda x: np.squeeze(np.array([0.02 * np.sin(2 * x[0] + x[1] + c) for c in range(f.num_components)]))
        )
        own.u.x.array[f.dofs] += values
    own.u.x.scatter_forward()
    b = fem.assemble_vector(quick_form(AssembledForm(own).internal))
    b.scatter_reverse(InsertMode.add)
    places, forces = [], []
    for f in fields_of(V):
        bs = f.space.dofmap.bs
        owned = f.space.dofmap.index_map.size_local
        x = np.repeat(f.space.tabulate_dof_coordinates()[:owned], bs, axis=0)
        places.append(np.column_stack([np.full(len(x), f.number), np.tile(np.arange(bs), owned), x]))
        forces.append(b.array[f.dofs[: bs * owned]])
    found = mesh.comm.gather((np.concatenate(places), np.concatenate(forces)), root=0)
    if found is None:
        return None
    place, force = (np.concatenate(part) for part in zip(*found))
    order = np.lexsort(np.round(place, 7).T)
    return place[order], force[order]


def ranks(subject: Subject, comm: MPI.Comm = MPI.COMM_WORLD) -> None:
    """Do several ranks give the forces of one? Collective; the finding is that of rank 0 on all.

    Args:
        subject: the form.
        comm: ranks to compare with one.
    """
    if comm.size == 1:
        subject.leave_out("ranks", "started on one rank: mpirun -n 2 dolfinx-impact verify ... compares them")
        return
    if not isinstance(subject.assembled, AssembledForm):
        subject.leave_out("ranks", "a material with internal variables: its forces are those of the package's tests")
        return
    if not all(f.nodal for f in subject.fields):
        subject.leave_out("ranks", "degrees of freedom that are not values at nodes have signs of the numbering")
        return
    several = _forces(subject, whole_block(comm, subject.cell, 4))
    found = np.inf
    if comm.rank == 0:
        one = _forces(subject, whole_block(MPI.COMM_SELF, subject.cell, 4))
        assert one is not None and several is not None
        if one[0].shape == several[0].shape:
            found = float(np.abs(one[1] - several[1]).max() / np.abs(one[1]).max())
    found = comm.bcast(found, root=0)
    subject.add(
        "ranks", found, TOLERANCE, REASON, f"{comm.size} ranks give the forces of one",
        f"{comm.size} ranks give other forces than one, by {found:.1e} of the largest: functions that only some ranks "
        "have set, ghosts that were not updated (x.scatter_forward), or numbers that differ between ranks",
    )  # fmt: skip
