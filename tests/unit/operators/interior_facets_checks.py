# SPDX-License-Identifier: MIT
"""Kernels of facets between two cells against DOLFINx's assembly, and bounds by such facets against dense eigenvalues,
on the ranks of COMM_WORLD; see on_ranks.py."""

import basix.ufl
import numpy as np
import pytest
import scipy.linalg
import ufl
from dolfinx import fem, la, mesh
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact import compat
from dolfinx_impact.assembly.cell_matrices import CellMatrices
from dolfinx_impact.assembly.operators import Tangent

COMM = MPI.COMM_WORLD
SAME = 1e-12  # of the largest entry: FFCx rounds its tables to some 1e-14
# Vertices of a square or cube in DOLFINx's order, as cells that are turned by quarters see them.
TURNS = {2: [[0, 1, 2, 3], [1, 3, 0, 2], [3, 2, 1, 0], [2, 0, 3, 1]]}
TURNS[3] = [[*t, *[v + 4 for v in t]] for t in TURNS[2]] + [[0, 2, 4, 6, 1, 3, 5, 7], [0, 4, 1, 5, 2, 6, 3, 7]]


def turned(cell, n):
    """A square or cube of cells that are not parallelograms and number their vertices each in its own way."""
    dim = 2 if cell in ("triangle", "quadrilateral") else 3
    create = mesh.create_unit_square if dim == 2 else mesh.create_unit_cube
    plain = create(MPI.COMM_SELF, *[n] * dim, getattr(mesh.CellType, cell))
    x, cells = plain.geometry.x[:, :dim].copy(), compat.geometry_dofmap(plain).astype(np.int64)
    x += 0.04 * np.sin(7 * x[:, ::-1] + 1)
    for number, nodes in enumerate(cells):
        turn = TURNS[dim][number % len(TURNS[dim])] if cell in ("quadrilateral", "hexahedron") else None
        cells[number] = nodes[turn] if turn else np.roll(nodes, number)
    element = basix.ufl.element("Lagrange", cell, 1, shape=(dim,))
    rows = np.array_split(np.arange(len(cells)), COMM.size)[COMM.rank]
    nodes = np.array_split(np.arange(len(x)), COMM.size)[COMM.rank]
    partition = compat.create_cell_partitioner(mesh.GhostMode.shared_facet)
    return mesh.create_mesh(COMM, cells[rows], x=x[nodes], e=element, partitioner=partition)


def facet_tags(domain):
    """1, 2 or 3 by the place of a facet."""
    tdim = domain.topology.dim
    domain.topology.create_entities(tdim - 1)
    domain.topology.create_connectivity(tdim - 1, tdim)
    numbers = domain.topology.index_map(tdim - 1)
    facets = np.arange(numbers.size_local + numbers.num_ghosts, dtype=np.int32)
    middle = mesh.compute_midpoints(domain, tdim - 1, facets)[:, 0]
    return mesh.meshtags(domain, tdim - 1, facets, np.clip(1 + np.floor(3 * middle), 1, 3).astype(np.int32))


def everything(u, v, stiffness, number, tags):
    """Integrals over cells and both kinds of facets, in which both sides have all that a side may have."""
    domain = u.function_space.mesh
    n, h, dS = ufl.FacetNormal(domain), ufl.CellDiameter(domain), ufl.dS(domain, subdomain_data=tags)
    stress, slope = (lambda w: ufl.sym(ufl.grad(w))), ufl.jump(ufl.grad(u), n)
    penalty = ufl.avg(stiffness) / ufl.avg(h) * ufl.inner(ufl.jump(u), ufl.jump(v))
    form = number * ufl.inner(stress(u), ufl.grad(v)) * ufl.dx(degree=2) + ufl.inner(u, v) * ufl.ds(degree=2)
    form += (penalty - ufl.inner(ufl.avg(stress(u)) * n("+"), ufl.jump(v))) * dS((1, 3), degree=4)
    if domain.topology.cell_name() == "hexahedron":  # other kernels are compiled in no time
        consistency = ufl.inner(ufl.avg(stress(u)) * n("+"), ufl.jump(v))
        return (penalty - consistency + ufl.inner(slope, ufl.jump(ufl.grad(v), n))) * ufl.dS(degree=2)
    form += number * ufl.inner(slope, ufl.jump(ufl.grad(v), n)) * (1 + ufl.SpatialCoordinate(domain)[0]) * dS(2)
    return form - ufl.inner(ufl.jump(u), ufl.avg(ufl.grad(v)) * n("-")) * dS(degree=3)


def _compare(cell, family, degree, width):
    domain = turned(cell, 3 if cell != "hexahedron" else 2)
    dim = domain.geometry.dim
    V = fem.functionspace(domain, (family, degree, (dim,)))
    u, v, stiffness = fem.Function(V, name="u"), ufl.TestFunction(V), fem.Function(fem.functionspace(domain, ("DG", 0)))
    u.interpolate(lambda x: np.sin(3 * x[:dim]) + x[:dim][::-1] ** 2)
    if family == "DG":
        u.x.array[:] += 0.1 * np.sin(V.dofmap.index_map.local_to_global(np.arange(len(u.x.array) // dim)).repeat(dim))
    stiffness.interpolate(lambda x: 1 + x[0])
    form = everything(u, v, stiffness, fem.Constant(domain, 2.5), facet_tags(domain))
    ours, theirs = di.InternalForce(form, width=width).apply(), fem.assemble_vector(fem.form(form))
    theirs.scatter_reverse(la.InsertMode.add)
    theirs.scatter_forward()
    size = COMM.allreduce(np.abs(theirs.array).max(), MPI.MAX)
    difference = COMM.allreduce(np.abs(ours.array - theirs.array).max(), MPI.MAX) / size
    assert difference < SAME, f"{cell} {family} {degree}, width {width}: {difference:.1e}"


def check_triangles():
    _compare("triangle", "Lagrange", 2, 0)
    _compare("triangle", "DG", 1, 1)


def check_quadrilaterals():
    _compare("quadrilateral", "Lagrange", 2, 0)


def check_tetrahedra():
    _compare("tetrahedron", "DG", 1, 0)


def check_hexahedra():
    _compare("hexahedron", "DG", 1, 0)


def check_value():
    """A form of rank 0: the area between cells."""
    domain = mesh.create_unit_square(COMM, 4, 2, mesh.CellType.quadrilateral)
    one = fem.Constant(domain, 1.0)
    assert di.Energy(ufl.avg(one) * ufl.dS(domain)).value() == pytest.approx(4.0, rel=1e-14)


def check_bounds():
    """Of two cells and the facet between them, the bounds are the extreme eigenvalues of the assembled matrix over the
    mass; of more cells, the bound holds."""
    for cell, family in (("triangle", "DG"), ("quadrilateral", "Lagrange"), ("tetrahedron", "Lagrange")):
        domain = mesh.create_unit_square(MPI.COMM_SELF, 1, 1) if cell == "triangle" else turned_pair(cell)
        V = fem.functionspace(domain, (family, 1))
        u, v, n = fem.Function(V, name="u"), ufl.TestFunction(V), ufl.FacetNormal(domain)
        du = ufl.TrialFunction(V)
        form = (3 * ufl.jump(du) * ufl.jump(v) - ufl.jump(du) * ufl.inner(ufl.avg(ufl.grad(v)), n("+"))) * ufl.dS
        form += ufl.inner(ufl.jump(ufl.grad(du), n), ufl.jump(ufl.grad(v), n)) * ufl.dS
        nodes, num = V.dofmap.list, V.dofmap.index_map.size_local
        own = 1.0 + 0.1 * np.arange(nodes.size).reshape(nodes.shape)
        mass = np.zeros(num)
        np.add.at(mass, nodes, own)
        A = Tangent(form).assemble()[:, :]
        expected = scipy.linalg.eigvalsh(0.5 * (A + A.T), np.diag(mass))
        found = CellMatrices(u, form, (u,)).spectra(own)
        assert np.allclose(found[:, :2], [expected[[0, -1]]] * 2, atol=1e-10 * expected[-1]), cell


def turned_pair(cell):
    """Two cells."""
    if cell == "quadrilateral":
        return mesh.create_unit_square(MPI.COMM_SELF, 2, 1, mesh.CellType.quadrilateral)
    x = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.1, 0.2, 1.0], [0.3, 0.1, -0.8]])
    element = basix.ufl.element("Lagrange", "tetrahedron", 1, shape=(3,))
    return mesh.create_mesh(MPI.COMM_SELF, np.array([[0, 1, 2, 3], [4, 2, 0, 1]]), x=x, e=element)


def check_ranks_without_cells():
    """Rank 0 has all cells: the run is that of one rank."""
    found = []
    for comm, partition in ((COMM, to_one_rank), (MPI.COMM_SELF, None)):
        plain = mesh.create_unit_square(MPI.COMM_SELF, 4, 4)
        x, cells = plain.geometry.x[:, :2].copy(), compat.geometry_dofmap(plain).astype(np.int64)
        x, cells = (x, cells) if comm.rank == 0 else (x[:0], cells[:0])
        element = basix.ufl.element("Lagrange", "triangle", 1, shape=(2,))
        domain = mesh.create_mesh(comm, cells, x=x, e=element, partitioner=partition)
        V = fem.functionspace(domain, ("DG", 1, (2,)))
        u, v = fem.Function(V, name="u"), ufl.TestFunction(V)
        u.interpolate(lambda x: 1e-3 * np.cos(np.pi * x[:2]))
        residual = ufl.inner(ufl.grad(u), ufl.grad(v)) * ufl.dx(degree=2)
        residual += 20 * ufl.inner(ufl.jump(u), ufl.jump(v)) * ufl.dS(degree=2)
        problem = di.ExplicitProblem(u, residual=residual, density=1.0)
        problem.advance(0.5, progress=False)
        found.append([problem.stable_step(), problem.energy["kinetic"], problem.energy["internal"]])
    assert np.allclose(*found, rtol=1e-10), found


def to_one_rank(comm, num_ranks, kinds, cells):
    return compat.adjacencylist(np.zeros((len(cells[0]) // 3, 1), dtype=np.int32))


def check_cells_of_other_ranks_are_needed():
    domain = mesh.create_unit_square(COMM, 4, 4, ghost_mode=mesh.GhostMode.none)
    V = fem.functionspace(domain, ("Lagrange", 1, (2,)))
    u, v = fem.Function(V, name="u"), ufl.TestFunction(V)
    residual = ufl.inner(ufl.grad(u), ufl.grad(v)) * ufl.dx + ufl.inner(ufl.jump(u), ufl.jump(v)) * ufl.dS
    makers = (
        lambda: di.InternalForce(residual),
        lambda: di.ExplicitProblem(u, residual=residual, density=1.0),
        lambda: di.NewmarkProblem(u, residual=residual, density=1.0).advance(0.1, dt=0.1, progress=False),
    )
    for make in makers:
        if COMM.size == 1:
            make()
            continue
        with pytest.raises(ValueError, match="ufl.dS, need the cells on both sides.*GhostMode.shared_facet"):
            make()
