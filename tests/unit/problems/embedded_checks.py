# SPDX-License-Identifier: MIT
"""Trusses and shells, meshes of lines and surfaces in space: closed forms in all problems, and what is refused, on the
ranks of COMM_WORLD; see on_ranks.py."""

import basix.ufl
import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from mixed_spaces_checks import solve_plainly
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact import compat

COMM = MPI.COMM_WORLD


def to_one_rank(comm, num_ranks, kinds, cells):
    """All cells to rank 0: where three bars meet, DOLFINx must have them on one rank."""
    return compat.adjacencylist(np.zeros((len(cells[0]) // 2, 1), dtype=np.int32))


def lines(x, cells, partition=None):
    """Mesh of lines between points."""
    x, cells = np.asarray(x, dtype=float), np.asarray(cells)
    element = basix.ufl.element("Lagrange", "interval", 1, shape=(x.shape[1],))
    x, cells = (x, cells) if COMM.rank == 0 else (x[:0], cells[:0])
    partition = partition or compat.create_cell_partitioner(mesh.GhostMode.shared_facet)
    return mesh.create_mesh(COMM, cells, x=x, e=element, partitioner=partition)


class Truss:
    """Bars of unit stiffness that resist their stretch alone, with Green's strain: UFL's gradient is along the bar."""

    def __init__(self, x, cells, held, partition=None):
        self.mesh = lines(x, cells, partition)
        self.gdim = self.mesh.geometry.dim
        self.V = fem.functionspace(self.mesh, ("Lagrange", 1, (self.gdim,)))
        self.u, self.v = fem.Function(self.V, name="u"), ufl.TestFunction(self.V)
        self.bc = fem.dirichletbc(np.zeros(self.gdim), fem.locate_dofs_geometrical(self.V, held), self.V)

    def residual(self):
        J = ufl.Jacobian(self.mesh)
        along = ufl.as_vector([J[i, 0] for i in range(self.gdim)])
        along = along / ufl.sqrt(ufl.inner(along, along))
        slope = ufl.dot(ufl.grad(self.u), along)
        strain = ufl.inner(slope, along) + ufl.inner(slope, slope) / 2
        return ufl.derivative(strain**2 / 2 * ufl.dx(self.mesh, degree=2), self.u, self.v)

    def at(self, array, *place):
        """Values at a node."""
        found = np.all(np.isclose(self.V.tabulate_dof_coordinates()[:, : self.gdim], place), axis=1)
        owned = found[: self.V.dofmap.index_map.size_local]
        return COMM.allreduce(array[: len(owned) * self.gdim].reshape(-1, self.gdim)[owned].sum(axis=0))


def check_truss():
    """Three bars that meet at a node which is pulled: Green's strain of each by its length, a node's force by hand."""
    feet, top = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]), np.array([0.3, 0.2, 1.0])
    truss = Truss([*feet, top], [[0, 3], [1, 3], [2, 3]], lambda x: np.isclose(x[2], 0.0), to_one_rank)
    moved = np.array([0.05, -0.02, 0.1])  # where it is to go: the force that holds it there
    force = np.zeros(3)
    for foot in feet:
        before, after = top - foot, top + moved - foot
        length = np.linalg.norm(before)
        force += 0.5 * (after @ after / length**2 - 1) * after / length
    dead = fem.Function(truss.V)
    dead.interpolate(lambda x: np.outer(force, np.isclose(x[2], 1.0) / np.sum(np.linalg.norm(top - feet, axis=1)) * 2))
    pull = ufl.inner(dead, truss.v) * ufl.dx(truss.mesh, metadata={"quadrature_rule": "vertex", "quadrature_degree": 1})
    di.StaticProblem(truss.u, residual=truss.residual() - pull, bcs=[truss.bc]).solve(rtol=1e-13)
    assert np.allclose(truss.at(truss.u.x.array, *top), moved, atol=1e-10)


def check_waves_in_a_bar():
    """A straight bar in space, held at one end: the first mode's period, 4 L / c, explicit and implicit. With 16 cells
    of lumped or consistent mass the frequency is wrong by (pi/32)^2 / 24 = 4e-4, lower or higher."""
    end, n = np.array([0.6, 0.8, 0.0]), 16
    x = np.linspace(0.0, 1.0, n + 1)[:, None] * end
    for kind, given in ((di.ExplicitProblem, {}), (di.NewmarkProblem, {"dt": 1.0 / 128})):
        bar = Truss(x, np.arange(n)[:, None] + [0, 1], lambda x: np.isclose(x[0], 0.0))
        velocity = fem.Function(bar.V)
        velocity.interpolate(lambda x: 1e-4 * np.outer(end, np.sin(0.5 * np.pi * x[0] / 0.6)))
        problem = kind(bar.u, residual=bar.residual(), density=1.0, velocity=velocity, bcs=[bar.bc])
        problem.advance(2.0, progress=False, **given)  # half a period: the velocity is turned
        assert np.allclose(bar.at(problem.velocity.x.array, *end), -1e-4 * end, atol=4e-8)
        assert np.abs(bar.at(bar.u.x.array, *end)).max() < 2e-3 * 1e-4


class Shell:
    """A strip with displacement and rotations (Reissner and Mindlin), bent to a cylinder or flat, held at x = 0."""

    thickness, modulus = 0.1, 1e3

    def __init__(self, flat=False):
        n, m = 8, 2
        i, j = (k.ravel() for k in np.meshgrid(np.arange(n + 1), np.arange(m + 1), indexing="ij"))
        x = np.column_stack([i / n, 0.25 * j / m, 0 * i if flat else 0.2 * np.sin(2 * i / n)])
        first = ((m + 1) * np.arange(n)[:, None] + np.arange(m)).ravel()[:, None]
        cells = np.vstack([first + [0, m + 1, 1], first + [m + 1, 1, m + 2]])
        element = basix.ufl.element("Lagrange", "triangle", 1, shape=(3,))
        x, cells = (x, cells) if COMM.rank == 0 else (x[:0], cells[:0])
        self.mesh = mesh.create_mesh(COMM, cells, x=x, e=element)
        parts = [basix.ufl.element("Lagrange", "triangle", degree, shape=(3,)) for degree in (2, 1)]
        self.W = fem.functionspace(self.mesh, basix.ufl.mixed_element(parts))
        self.w, self.bcs = fem.Function(self.W, name="w"), []
        for k in range(2):
            V, _ = self.W.sub(k).collapse()
            held = fem.locate_dofs_geometrical((self.W.sub(k), V), lambda x: np.isclose(x[0], 0.0))
            self.bcs.append(fem.dirichletbc(fem.Function(V), held, self.W.sub(k)))

    def residual(self, load=1e-3):
        (u, r), (v, s), t = ufl.split(self.w), ufl.TestFunctions(self.W), self.thickness
        n, dx = ufl.CellNormal(self.mesh), ufl.dx(self.mesh, degree=2)
        plane = ufl.Identity(3) - ufl.outer(n, n)

        def stretch(u):
            return plane * ufl.sym(ufl.grad(u)) * plane

        def shear(u, r):
            return plane * ufl.dot(ufl.grad(u).T, n) + ufl.cross(r, n)

        def bending(r):
            return stretch(ufl.cross(r, n))

        forces = t * ufl.inner(stretch(u), stretch(v)) + 5 / 12 * t * ufl.inner(shear(u, r), shear(v, s))
        forces += t**3 / 12 * ufl.inner(bending(r), bending(s)) + t**3 * ufl.inner(r, n) * ufl.inner(s, n)
        return (self.modulus * forces - load * ufl.inner(ufl.as_vector((0, 0, 1)), v)) * dx

    def tip(self):
        """Largest displacement across."""
        V, numbers = compat.collapse(self.W.sub(0).sub(2))
        return COMM.allreduce(np.abs(self.w.x.array[numbers]).max(initial=0.0), MPI.MAX)


def check_shells():
    """A flat strip is a cantilever of Timoshenko's: w = q/(8 D) + q/(2 G); of a curved one the static answer is that of
    DOLFINx, and an explicit run goes the way of an implicit one."""
    flat = Shell(flat=True)
    di.StaticProblem(flat.w, residual=flat.residual(), bcs=flat.bcs).solve()
    bending, shear = flat.modulus * flat.thickness**3 / 12, 5 / 12 * flat.modulus * flat.thickness
    exact = 1e-3 * (1 / (8 * bending) + 1 / (2 * shear))
    assert abs(flat.tip() / exact - 1) < 0.02  # 8 cells: linear rotations

    own, other = Shell(), Shell()
    di.StaticProblem(own.w, residual=own.residual(), bcs=own.bcs).solve()
    solve_plainly(other.residual(), other.w, other.bcs)
    size = COMM.allreduce(np.abs(other.w.x.array).max(), MPI.MAX)
    assert COMM.allreduce(np.abs(own.w.x.array - other.w.x.array).max(), MPI.MAX) < 1e-9 * size

    runs = []
    for kind, given in ((di.ExplicitProblem, {}), (di.NewmarkProblem, {"dt": 0.01})):
        shell = Shell()
        t = shell.thickness
        problem = kind(shell.w, residual=shell.residual(), density=[t, t**3 / 12], bcs=shell.bcs)
        problem.advance(0.4, progress=False, **given)
        runs.append(shell.tip())
    assert abs(runs[0] / runs[1] - 1) < 0.05, runs  # masses are lumped in one and consistent in the other


def star_of(partition):
    """Three bars in a plane."""
    nodes, bars = [[0.0, 0.0], [1.0, 0.0], [0.5, 1.0], [0.5, 0.5]], [[0, 3], [1, 3], [2, 3]]
    return Truss(nodes, bars, lambda x: np.isclose(x[1], 0.0), partition)


def check_torn_nodes_are_refused():
    """Where DOLFINx has made two nodes of one, problems say so; where it has not, they work."""
    star = star_of(None)
    if star.V.dofmap.index_map.size_global == 4:
        di.StaticProblem(star.u, residual=star.residual(), bcs=[star.bc])
        assert COMM.size != 2  # or the check is none: take another mesh
        return
    for make in (
        lambda: di.StaticProblem(star.u, residual=star.residual(), bcs=[star.bc]),
        lambda: di.ExplicitProblem(star.u, residual=star.residual(), density=1.0),
        lambda: di.NewmarkProblem(star.u, residual=star.residual(), density=1.0),
    ):
        with pytest.raises(ValueError, match=r"1 nodes at which more than two bars.*\(0.5, 0.5\).*Run on one rank"):
            make()


def check_what_is_refused():
    """Says what works instead."""
    truss = Truss([[0.0, 0.0], [1.0, 0.0], [0.5, 1.0]], [[0, 2], [1, 2]], lambda x: np.isclose(x[1], 0.0))
    load = di.BodyForce((0.0, -1.0), per_mass=False)
    shell = Shell()
    u = fem.Function(fem.functionspace(shell.mesh, ("Lagrange", 1, (3,))))
    for make, words in (
        (lambda: di.StaticProblem(truss.u, residual=truss.residual(), loads=[load]), "bars.*write the load into the"),
        (
            lambda: di.ExplicitProblem(u, di.LinearElastic(1.0, 0.3, 1.0)),
            "shells.*residual of your own and its density",
        ),
        (lambda: di.verify.cross_check(truss.residual(), operator="elasticity"), "dimension 1 in 2.*InternalForce"),
        (lambda: di.verify.self_check((truss.residual(), truss.u)), "dimension 1 in 2.*InternalForce"),
    ):
        with pytest.raises(ValueError, match=words):
            make()
    star = star_of(to_one_rank)
    kink = ufl.inner(ufl.jump(ufl.grad(star.u)), ufl.jump(ufl.grad(star.v))) * ufl.dS
    for kind in (di.StaticProblem, di.ExplicitProblem):
        with pytest.raises(ValueError, match="3 cells meet at one node"):
            kind(star.u, residual=star.residual() + kink, **({} if kind is di.StaticProblem else {"density": 1.0}))
