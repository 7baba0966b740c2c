# SPDX-License-Identifier: MIT
"""Residuals with averages over cells in static, implicit and explicit problems, against DOLFINx's mixed formulation
with a pressure constant in each cell, on the ranks of COMM_WORLD; see on_ranks.py."""

import basix.ufl
import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from mixed_spaces_checks import clamp as clamp_mixed
from mixed_spaces_checks import solve_plainly
from mpi4py import MPI
from static_problem_checks import body, clamp, space

import dolfinx_impact as di
from dolfinx_impact.assembly.cell_matrices import CellMatrices

COMM = MPI.COMM_WORLD
SAME = 1e-10  # of the largest displacement: matrices with condition numbers up to some 1e5
BULK = 100.0


class Averaged:
    """A body whose pressure is that of the mean dilatation of each cell, linear or of finite strain.

    Args:
        domain: mesh, or the kind of its cells.
        finite: is the strain finite?
    """

    def __init__(self, domain, finite=False):
        self.mesh, self.finite = body(domain) if isinstance(domain, str) else domain, finite
        self.V, self.dim = space(self.mesh), self.mesh.geometry.dim
        self.u, self.v = fem.Function(self.V, name="u"), ufl.TestFunction(self.V)
        self.dx, self.bc = ufl.dx(domain=self.mesh, degree=4), clamp(self.V)

    def shear(self, u):
        """Energy of the shape."""
        if not self.finite:
            strain = ufl.dev(ufl.sym(ufl.grad(u)))
            return ufl.inner(strain, strain)
        F = ufl.Identity(self.dim) + ufl.grad(u)
        return 0.5 * ufl.inner(F, F) - ufl.ln(ufl.det(F))

    def dilatation(self, u):
        return ufl.det(ufl.Identity(self.dim) + ufl.grad(u)) - 1 if self.finite else ufl.div(u)

    def residual(self):
        energy = self.shear(self.u) + 0.5 * BULK * ufl.cell_avg(self.dilatation(self.u)) ** 2
        return ufl.derivative(energy * self.dx, self.u, self.v) - 0.3 * self.v[1] * self.dx

    def mixed(self):
        """The same with a pressure of its own: function, residual and conditions."""
        cell = self.mesh.topology.cell_name()
        elements = [self.V.ufl_element(), basix.ufl.element("DG", cell, 0)]
        W = fem.functionspace(self.mesh, basix.ufl.mixed_element(elements))
        w = fem.Function(W)
        u, p = ufl.split(w)
        v, _ = ufl.TestFunctions(W)
        energy = (self.shear(u) + p * self.dilatation(u) - 0.5 * p**2 / BULK) * self.dx
        return w, ufl.derivative(energy, w, ufl.TestFunction(W)) - 0.3 * v[1] * self.dx, [clamp_mixed(W)]


def assert_same(a, b):
    size = COMM.allreduce(np.abs(b).max(initial=0.0), MPI.MAX)
    difference = COMM.allreduce(np.abs(a - b).max(initial=0.0), MPI.MAX)
    assert 0.0 < size and difference < SAME * size, f"{difference:.1e} of {size:.1e}"


def check_static():
    """Linear bodies in one iteration, others by Newton's quadratic convergence: the tangent is exact."""
    cases = (("quadrilateral", True), ("quadrilateral", False), ("hexahedron", False), ("triangle", True))
    for cell, finite in cases if COMM.size == 1 else cases[:1]:
        b = Averaged(cell, finite)
        report = di.StaticProblem(b.u, residual=b.residual(), bcs=[b.bc]).solve(rtol=1e-12)
        norms = report.residual_norms[0]
        assert len(norms) == 2 if not finite else len(norms) <= 8 and norms[-2] < 1e-4 * norms[0], norms
        w, residual, bcs = b.mixed()
        solve_plainly(residual, w, bcs)
        u = fem.Function(b.V)
        u.interpolate(w.sub(0).collapse())
        assert_same(b.u.x.array, u.x.array)


def check_implicit():
    """Newmark's method with the mixed formulation, whose pressure has no inertia."""
    b = Averaged("quadrilateral", True)
    problem = di.NewmarkProblem(b.u, residual=b.residual(), density=1.5, bcs=[b.bc])
    problem.advance(0.3, dt=0.1, rtol=1e-13, progress=False)
    w, residual, bcs = b.mixed()
    other = di.NewmarkProblem(w, residual=residual, density=[1.5, 0.0], bcs=bcs)
    other.advance(0.3, dt=0.1, rtol=1e-13, progress=False)
    u = fem.Function(b.V)
    u.interpolate(w.sub(0).collapse())
    assert_same(b.u.x.array, u.x.array)


def check_explicit():
    """On linear triangles the dilatation is constant in each cell: with and without averages steps are the same, and
    so are the stable steps. On squares the pressure locks less, and the body is softer."""
    for cell in ("triangle", "quadrilateral"):
        runs, domain = [], body(cell)
        for averaged in (True, False):
            b = Averaged(domain, True)
            residual = b.residual()
            if not averaged:
                energy = b.shear(b.u) + 0.5 * BULK * b.dilatation(b.u) ** 2
                residual = ufl.derivative(energy * b.dx, b.u, b.v) - 0.3 * b.v[1] * b.dx
            problem = di.ExplicitProblem(b.u, residual=residual, density=1.0, bcs=[b.bc])
            steps = [problem.stable_step(method) for method in ("element", "eigenvalue")]
            assert steps[0] < 1.0001 * steps[1]
            problem.advance(0.05, dt=0.001, progress=False)
            assert abs(problem.energy["drift"]) < 1e-12
            runs.append((steps, b.u.x.array.copy()))
        if cell == "triangle":
            # The eigenvalue to SLEPc's 1e-8.
            np.testing.assert_allclose(runs[0][0], runs[1][0], rtol=1e-7)
            assert_same(runs[0][1], runs[1][1])
        else:
            assert np.all(np.array(runs[0][0]) >= np.array(runs[1][0]))
            with pytest.raises(AssertionError):
                assert_same(runs[0][1], runs[1][1])


def check_tangent_is_the_derivative():
    """Columns of averages, of volumes of cells that are not affine, with other integrals over facets; cell by cell and
    assembled, by central differences of the vector."""
    b = Averaged("hexahedron", True)
    springs = ufl.inner(b.u, b.v) * ufl.ds(domain=b.mesh, degree=2)
    volume = ufl.CellVolume(b.mesh) * ufl.inner(ufl.inner(b.u, b.u) * b.u, b.v) * b.dx
    residual = b.residual() + springs + volume
    rng = np.random.default_rng(5)
    b.u.interpolate(lambda x: 0.1 * np.sin(3 * x + 1))
    tangent = ufl.derivative(residual, b.u, ufl.TrialFunction(b.V))
    K, force = di.Tangent(tangent).assemble(), di.InternalForce(residual)
    direction = fem.Function(b.V)
    direction.interpolate(lambda x: np.cos(2 * x[[1, 2, 0]] + float(rng.uniform())))
    num, start, h, ends = b.V.dofmap.index_map.size_local * 3, b.u.x.array.copy(), 1e-5, []
    for sign in (1.0, -1.0):
        b.u.x.array[:] = start + sign * h * direction.x.array
        ends.append(force.apply().array[:num].copy())
    b.u.x.array[:] = start
    x, y = K.createVecs()
    x.array[:] = direction.x.array[:num]
    K.mult(x, y)
    expected = (ends[0] - ends[1]) / (2 * h)
    size = COMM.allreduce(np.abs(expected).max(initial=0.0), MPI.MAX)
    # Error of central differences: third derivative times h^2, and round-off over h.
    np.testing.assert_allclose(y.array, expected, rtol=0, atol=1e-8 * size)
    masses = np.ones((b.mesh.topology.index_map(3).size_local, 24))
    spectra = CellMatrices(b.u, tangent, ()).spectra(masses)
    highest = COMM.allreduce(spectra[:, 1].max(initial=0.0), MPI.MAX)
    quotient = COMM.allreduce(float(x.dot(y))) / COMM.size / x.norm() ** 2
    assert 0.0 < quotient < 8 * highest  # a node has eight cells at most


def check_words():
    """Averages that FFCx would have to compile are named."""
    b = Averaged("quadrilateral")
    velocity = fem.Function(b.V, name="velocity")
    damping = ufl.cell_avg(ufl.div(velocity)) * ufl.div(b.v) * b.dx
    with pytest.raises(ValueError, match=r"ufl.cell_avg\(..., velocity\).*explicit problems"):
        di.NewmarkProblem(b.u, residual=b.residual() + damping, density=1.0, velocity=velocity, bcs=[b.bc])
    problem = di.ExplicitProblem(b.u, residual=b.residual() + damping, density=1.0, velocity=velocity, bcs=[b.bc])
    problem.advance(3 * problem.stable_step(), progress=False)
    assert problem.energy["damping"] > 0.0
    area = ufl.CellVolume(b.mesh) * ufl.inner(b.u, b.v) * ufl.ds(domain=b.mesh)
    with pytest.raises(ValueError, match=r"ufl.CellVolume\(mesh\) of quadrilateral cells.*not over facets"):
        di.StaticProblem(b.u, residual=b.residual() + area, bcs=[b.bc])
    # Straight edges have an area: on squares the diameter over the root of two.
    results = []
    square = mesh.create_unit_square(COMM, 2, 2, mesh.CellType.quadrilateral)
    V = space(square)
    for kind in (ufl.FacetArea, lambda m: ufl.CellDiameter(m) / np.sqrt(2)):
        u, v = fem.Function(V, name="u"), ufl.TestFunction(V)
        springs = ufl.inner(u, v) / kind(square) * ufl.ds(degree=2)
        di.StaticProblem(u, residual=(ufl.inner(ufl.grad(u), ufl.grad(v)) - v[0]) * ufl.dx(degree=2) + springs).solve()
        results.append(u.x.array.copy())
    assert_same(*results)
