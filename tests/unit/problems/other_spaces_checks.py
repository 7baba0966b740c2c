# SPDX-License-Identifier: MIT
"""Residuals whose unknown is no displacement, or whose mesh is no body: membranes, heat, Cosserat continua, bars,
trusses and surfaces in space; static, implicit and explicit, against DOLFINx alone, on the ranks of COMM_WORLD; see
on_ranks.py."""

import functools

import basix.ufl
import dolfinx.fem.petsc as petsc
import h5py
import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from mixed_spaces_checks import clamp, solve_plainly, taylor_hood, two_field
from mpi4py import MPI
from petsc4py import PETSc
from static_problem_checks import body

import dolfinx_impact as di
from dolfinx_impact.statics import linear_solver

COMM = MPI.COMM_WORLD
SAME = 1e-10  # of the largest value: matrices with condition numbers up to some 1e4


def embedded(cell):
    """A crooked line, or a curved surface, in space."""
    n, kind = 4, ufl.Mesh(basix.ufl.element("Lagrange", cell, 1, shape=(3,)))
    if cell == "interval":
        s = np.linspace(0.0, 1.0, 2 * n + 1)
        x, cells = np.column_stack([s, 0.3 * s**2, 0.2 * np.sin(3 * s)]), np.arange(2 * n)[:, None] + [0, 1]
    else:
        i, j = np.meshgrid(np.arange(n + 1), np.arange(n + 1), indexing="ij")
        x = np.column_stack([i.ravel() / n, j.ravel() / n, 0.3 * (i.ravel() / n) ** 2])
        first = ((n + 1) * i[:-1, :-1] + j[:-1, :-1]).ravel()[:, None]
        cells = first + [0, n + 1, 1, n + 2]
        if cell == "triangle":
            cells = np.vstack([cells[:, :3], cells[:, 1:]])
    if COMM.rank > 0:
        x, cells = x[:0], cells[:0]
    return mesh.create_mesh(COMM, cells, x=x, e=kind)


MESHES = {
    "line": lambda: mesh.create_interval(COMM, 8, [0.0, 1.0]),
    "plane": lambda: body("triangle"),
    "squares": lambda: body("quadrilateral"),
    "line in space": lambda: embedded("interval"),
    "triangles in space": lambda: embedded("triangle"),
    "squares in space": lambda: embedded("quadrilateral"),
}
# Mesh, degree and shape of the unknown: bar; membrane; Cosserat; five species; heat in space; truss; surfaces.
ROWS = (
    ("line", 2, ()),
    ("squares", 1, ()),
    ("plane", 1, (3,)),
    ("plane", 1, (5,)),
    ("squares", 1, (2, 2)),
    ("line in space", 1, (3,)),
    ("triangles in space", 2, ()),
    ("squares in space", 1, (3,)),
)
# Kernels take the time: in `make test`, implicit runs take every second row, explicit ones the others, several ranks
# half of them.
STATIC, IMPLICIT, EXPLICIT = ROWS, ROWS[::2], ROWS[1::2]
if COMM.size > 1:
    STATIC, IMPLICIT, EXPLICIT = ROWS[2::2], ROWS[2::4], ROWS[3::4]


@functools.cache
def made(kind):
    """One mesh for all models that are compared by their arrays: DOLFINx may partition a second one otherwise."""
    return MESHES[kind]()


class Model:
    """An unknown with stiffness, springs in the body and at the ends, that is not linear, held at x = 0."""

    def __init__(self, kind, degree, shape):
        self.mesh = made(kind)
        self.V = fem.functionspace(self.mesh, ("Lagrange", degree, shape) if shape else ("Lagrange", degree))
        self.u, self.w = fem.Function(self.V, name="u"), ufl.TestFunction(self.V)
        self.shape, self.dx = shape, ufl.dx(domain=self.mesh, degree=3)
        zero = np.zeros(shape) if shape else 0.0
        self.bc = fem.dirichletbc(zero, fem.locate_dofs_geometrical(self.V, lambda x: np.isclose(x[0], 0.0)), self.V)

    def residual(self, u=None):
        u, w, x = self.u if u is None else u, self.w, ufl.SpatialCoordinate(self.mesh)
        one = ufl.as_tensor(np.ones(self.shape).tolist()) if self.shape else 1
        body = (1 + x[0]) * ufl.inner(ufl.grad(u), ufl.grad(w)) + (1 + ufl.inner(u, u)) * ufl.inner(u, w)
        return (body - (2 + x[0]) * ufl.inner(one, w)) * self.dx + ufl.inner(u, w) * ufl.ds(self.mesh, degree=2)


def assert_same(u, other):
    size = COMM.allreduce(np.abs(other.x.array).max(initial=0.0), MPI.MAX)
    difference = COMM.allreduce(np.abs(u.x.array - other.x.array).max(initial=0.0), MPI.MAX)
    assert 0.0 < size and difference < SAME * size, f"{difference:.1e} of {size:.1e}"


def check_static():
    for row in STATIC:
        own, other = Model(*row), Model(*row)
        di.StaticProblem(own.u, residual=own.residual(), bcs=[own.bc]).solve(rtol=1e-13)
        solve_plainly(other.residual(), other.u, [other.bc])
        assert_same(own.u, other.u)


def check_implicit():
    """Two steps of Newmark's method, with consistent mass, written out in UFL."""
    compare_implicit(IMPLICIT)


def check_implicit_on_the_other_rows():
    compare_implicit([row for row in ROWS if row not in IMPLICIT])


def compare_implicit(rows):
    h, rho = 0.1, 1.7
    for row in rows:
        own = Model(*row)
        problem = di.NewmarkProblem(own.u, residual=own.residual(), density=rho, bcs=[own.bc])
        problem.advance(2 * h, dt=h, rtol=1e-13, progress=False)
        m = Model(*row)
        u0, v0, a0 = (fem.Function(m.V) for _ in range(3))
        inertia = ufl.dx(domain=m.mesh, degree=6)
        solve_plainly(rho * ufl.inner(a0, m.w) * inertia + m.residual(), a0, [m.bc])  # u is zero
        for _ in range(2):
            u0.x.array[:] = m.u.x.array
            acceleration = 4 / h**2 * (m.u - u0 - h * v0) - a0
            solve_plainly(rho * ufl.inner(acceleration, m.w) * inertia + m.residual(), m.u, [m.bc])
            a1 = 4 / h**2 * (m.u.x.array - u0.x.array - h * v0.x.array) - a0.x.array
            v0.x.array[:] += h / 2 * (a0.x.array + a1)
            a0.x.array[:] = a1
        assert_same(own.u, m.u)


def check_explicit():
    """Central differences with forces by DOLFINx, on the lumped mass of the problem, whose sum is right."""
    compare_explicit(EXPLICIT)


def check_explicit_on_the_other_rows():
    compare_explicit([row for row in ROWS if row not in EXPLICIT])


def compare_explicit(rows):
    for row in rows:
        own, m = Model(*row), Model(*row)
        problem = di.ExplicitProblem(own.u, residual=own.residual(), density=1.7, bcs=[own.bc])
        num = problem.num_owned
        volume = COMM.allreduce(fem.assemble_scalar(fem.form(fem.Constant(m.mesh, 1.0) * ufl.dx)))
        mass = COMM.allreduce(problem.mass.array[:num].sum())
        assert np.isclose(mass, 1.7 * volume * int(np.prod(m.shape, dtype=int)), rtol=1e-12), row
        assert problem.stable_step() < 1.0001 * problem.stable_step("eigenvalue")
        h = 0.5 * problem.stable_step()
        problem.advance(5 * h, dt=h, progress=False)
        held, velocity, form = m.bc.dof_indices()[0], np.zeros(num), fem.form(m.residual())
        for step in range(5):
            m.u.x.scatter_forward()
            b = petsc.assemble_vector(form)
            b.ghostUpdate(PETSc.InsertMode.ADD, PETSc.ScatterMode.REVERSE)
            velocity -= (0.5 if step == 0 else 1.0) * h * b.array / problem.mass.array[:num]
            velocity[held[held < num]] = 0.0
            m.u.x.array[:num] += h * velocity
            b.destroy()
        m.u.x.scatter_forward()
        assert_same(own.u, m.u)
        assert abs(problem.energy["drift"]) < 1e-12


def check_density_by_component():
    """Displacement and micro-rotation have inertia of their own; the masses of each sum up, and motion is that of the
    density of each."""
    rho = [2.0, 2.0, 0.25]
    for kind, given in ((di.ExplicitProblem, {}), (di.NewmarkProblem, {"lumping": "auto"}), (di.NewmarkProblem, {})):
        m = Model("plane", 1, (3,))
        free = ufl.inner(m.u, m.w) * m.dx - ufl.inner(ufl.as_vector((1.0, 2.0, 3.0)), m.w) * m.dx
        problem = kind(m.u, residual=free, density=rho, **given)
        masses = problem.mass.array[: problem.num_owned].reshape(-1, 3).sum(axis=0)
        np.testing.assert_allclose(COMM.allreduce(masses), rho, rtol=1e-12)  # of a square of side 1
        if kind is di.ExplicitProblem:
            assert np.isclose(problem.stable_step("eigenvalue"), 2.0 * 0.25**0.5, rtol=0.5)
            problem.advance(1e-3, dt=1e-4, progress=False)
        else:
            problem.advance(1e-3, dt=1e-4, progress=False)
        u = m.u.x.array.reshape(-1, 3)
        # One mass on a spring each: u = f (1 - cos(t/sqrt(rho))), up to the error of ten steps.
        expected = np.array([1.0, 2.0, 3.0]) * (1 - np.cos(1e-3 / np.sqrt(rho)))
        np.testing.assert_allclose(u, np.broadcast_to(expected, u.shape), rtol=1e-2)
    m = Model("plane", 1, (3,))
    for given, text in (
        ([1.0, 2.0], "3 components: give a density for each"),
        ([1.0, 1.0, 0.0], "component 2 of u has no inertia"),
    ):
        with pytest.raises(ValueError, match=text):
            di.ExplicitProblem(m.u, residual=m.residual(), density=given)


def check_samples(folder="build/other_spaces"):
    """Recorders sample all components of a node, and nothing else."""
    for row in (("squares", 1, ()), ("plane", 2, (3,)), ("line", 1, ())):
        m = Model(*row)
        problem = di.ExplicitProblem(m.u, residual=m.residual(), density=1.0, bcs=[m.bc])
        place = np.zeros(m.mesh.geometry.dim)
        place[0] = 1.0
        recorder = problem.record(f"{folder}_{COMM.size}_{row[0]}", every=10, points=[place], points_every=2)
        problem.advance(4 * problem.stable_step(), dt=problem.stable_step(), progress=False, unsafe=True)
        recorder.close()
        x = m.V.tabulate_dof_coordinates()[: m.V.dofmap.index_map.size_local]
        node = np.flatnonzero(np.all(np.isclose(x[:, : len(place)], place), axis=1))
        bs = m.V.dofmap.bs
        here = m.u.x.array.reshape(-1, bs)[node[0]] if len(node) else None
        (value,) = [v for v in COMM.allgather(here) if v is not None]
        if COMM.rank == 0:
            with h5py.File(f"{folder}_{COMM.size}_{row[0]}/history.h5") as file:
                samples = file["points/displacement"][:]
            assert samples.shape[1:] == (1, bs)
            np.testing.assert_array_equal(samples[-1, 0], value)


def check_too_many_components():
    """Said with the number that there is code for."""
    m = Model("line", 1, (13,))
    with pytest.raises(RuntimeError, match="13 components per node.*use 1 to 12, or a mixed element"):
        di.ExplicitProblem(m.u, residual=m.residual(), density=1.0, bcs=[m.bc])


def check_large_problems():
    """Beyond the size of factorisations: conjugate gradients with multigrid, which knows no rigid motions of what does
    not move, and no saddle points."""
    sizes = linear_solver.LIMITS.largest_direct
    linear_solver.LIMITS.largest_direct = [0] * 4
    try:
        for row in (("squares", 1, ()), ("plane", 1, (3,)), ("line", 2, ())):
            own, other = Model(*row), Model(*row)
            problem = di.StaticProblem(own.u, residual=own.residual(), bcs=[own.bc])
            assert problem.linear_solver.ksp.getPC().getType() == "gamg"
            problem.solve(rtol=1e-13)
            solve_plainly(other.residual(), other.u, [other.bc])
            assert_same(own.u, other.u)
        w = fem.Function(taylor_hood(body("triangle")), name="w")
        mixed = di.StaticProblem(w, residual=two_field(w), bcs=[clamp(w.function_space)])
        assert mixed.linear_solver.direct
    finally:
        linear_solver.LIMITS.largest_direct = sizes
