# SPDX-License-Identifier: MIT
"""Meshes of spinning bodies: discs, rings and thin discs, with one cell tag."""

import gmsh
import numpy as np
from dolfinx import fem
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact import compat


def mesh_of(radius, size, inner=0.0, thickness=0.0, order=2):
    """Disc or ring with cell tag 1, extruded by one layer if it has a thickness; (mesh, cell tags)."""
    gmsh.initialize(interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    gdim = 3 if thickness else 2
    if MPI.COMM_WORLD.rank == 0:
        occ = gmsh.model.occ
        disc = [(2, occ.addDisk(0, 0, 0, radius, radius))]
        if inner:
            disc, _ = occ.cut(disc, [(2, occ.addDisk(0, 0, 0, inner, inner))])
        else:
            disc, _ = occ.fragment(disc, [(0, occ.addPoint(0, 0, 0))])
        faces = [pair for pair in disc if pair[0] == 2]
        if thickness:
            occ.extrude(faces, 0, 0, thickness, numElements=[1])
        occ.synchronize()
        gmsh.model.addPhysicalGroup(gdim, [tag for _, tag in gmsh.model.getEntities(gdim)], 1)
        gmsh.option.setNumber("Mesh.MeshSizeMax", size)
        gmsh.model.mesh.generate(gdim)
        gmsh.model.mesh.setOrder(order)
    mesh, cells, _ = compat.model_to_mesh(gmsh.model, MPI.COMM_WORLD, 0, gdim=gdim)
    gmsh.finalize()
    return mesh, cells


def centred(V, radius):
    """Supports of a disc: its centre, and one point of the rim against rotation."""
    centre = fem.locate_dofs_geometrical(V, lambda x: np.hypot(x[0], x[1]) < 1e-9)
    V1, _ = V.sub(1).collapse()
    rim = fem.locate_dofs_geometrical((V.sub(1), V1), lambda x: np.isclose(x[0], radius) & np.isclose(x[1], 0.0))
    return [fem.dirichletbc(np.zeros(2), centre, V), fem.dirichletbc(fem.Function(V1), rim, V.sub(1))]


def antiplane(V):
    """Supports that leave only the displacement along z, in space."""
    supports = []
    for axis in (0, 1):
        everywhere = fem.locate_dofs_geometrical((V.sub(axis), V.sub(axis).collapse()[0]), lambda x: x[0] == x[0])
        supports.append(fem.dirichletbc(fem.Function(V.sub(axis).collapse()[0]), everywhere, V.sub(axis)))
    return supports


def spin(omega, gdim=2):
    """Spin about z."""
    return di.Spin(point=(0.0,) * gdim, axis=(0.0, 0.0, 1.0), omega=omega)


def rim_growth(u, radius):
    """Mean radial displacement of the nodes on the rim [L]. Collective."""
    V = u.function_space
    owned = V.dofmap.index_map.size_local
    x, d = V.tabulate_dof_coordinates()[:owned, :2], u.x.array.reshape(-1, 2)[:owned]
    rim = np.isclose(np.linalg.norm(x, axis=1), radius, atol=1e-9)
    growth = np.einsum("ij,ij->i", d, x)[rim] / radius
    comm = V.mesh.comm
    return comm.allreduce(growth.sum(), MPI.SUM) / comm.allreduce(len(growth), MPI.SUM)
