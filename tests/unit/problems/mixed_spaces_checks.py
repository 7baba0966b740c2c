# SPDX-License-Identifier: MIT
"""Residuals on mixed spaces in static, implicit and explicit problems, against DOLFINx and PETSc alone, on the ranks of
COMM_WORLD; see on_ranks.py."""

import basix.ufl
import dolfinx.fem.petsc as petsc
import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI
from petsc4py import PETSc
from static_problem_checks import CELLS, body

import dolfinx_impact as di
from dolfinx_impact import compat

COMM = MPI.COMM_WORLD
# Of the largest value of a field: both sides solve to round-off of matrices with condition numbers up to some 1e5.
SAME = 1e-10


def taylor_hood(domain, low=1):
    """Space of displacements of degree low + 1 and pressures of degree low; equal degrees for low = 0."""
    cell, dim = domain.topology.cell_name(), domain.geometry.dim
    u = basix.ufl.element("Lagrange", cell, low + 1, shape=(dim,))
    return fem.functionspace(domain, basix.ufl.mixed_element([u, basix.ufl.element("Lagrange", cell, low or 1)]))


def clamp(W, x=0.0, value=None):
    """Displacement held, or given, at a plane."""
    V, _ = W.sub(0).collapse()
    dim = W.mesh.topology.dim
    facets = mesh.locate_entities_boundary(W.mesh, dim - 1, lambda p: np.isclose(p[0], x))
    dofs = fem.locate_dofs_topological((W.sub(0), V), dim - 1, facets)
    g = fem.Function(V)
    if value is not None:
        g.interpolate(lambda p: np.outer(value, np.ones(p.shape[1])))
    return fem.dirichletbc(g, dofs, W.sub(0))


def solve_plainly(residual, w, bcs):
    """Newton's method of DOLFINx with LU, until the corrections are round-off."""
    a, L = fem.form(ufl.derivative(residual, w)), fem.form(residual)
    for _ in range(30):
        w.x.scatter_forward()
        b = petsc.assemble_vector(L)
        petsc.apply_lifting(b, [a], [bcs], [w.x.petsc_vec], alpha=-1.0)
        b.ghostUpdate(PETSc.InsertMode.ADD, PETSc.ScatterMode.REVERSE)
        petsc.set_bc(b, bcs, w.x.petsc_vec, alpha=-1.0)
        A = petsc.assemble_matrix(a, bcs)
        A.assemble()
        ksp = PETSc.KSP().create(COMM)
        ksp.setType("preonly")
        ksp.getPC().setType("lu")
        ksp.getPC().setFactorSolverType("mumps")
        ksp.setOperators(A)
        d = b.duplicate()
        ksp.solve(b, d)
        step, size = d.norm(), w.x.petsc_vec.norm()
        w.x.petsc_vec.axpy(-1.0, d)
        for thing in (ksp, A, b, d):
            thing.destroy()
        if step <= 1e-13 * size:
            break
    w.x.scatter_forward()


def assert_same_fields(w, other):
    """Every field to SAME of its own largest value."""
    for i in range(w.function_space.num_sub_spaces):
        a, b = (f.sub(i).collapse().x.array for f in (w, other))
        size = COMM.allreduce(np.abs(b).max(initial=0.0), MPI.MAX)
        difference = COMM.allreduce(np.abs(a - b).max(initial=0.0), MPI.MAX)
        assert size > 0.0 and difference < SAME * size, f"field {i}: {difference:.1e} of {size:.1e}"


def two_field(w, young=1.0, poisson=0.4999, finite=False):
    """Displacement and pressure of a nearly incompressible law, linear or neo-Hooke's, without loads."""
    u, p = ufl.split(w)
    v, q = ufl.TestFunctions(w.function_space)
    mu, bulk = young / (2 * (1 + poisson)), young / (3 * (1 - 2 * poisson))
    dx = ufl.dx(degree=4)
    if not finite:
        forces = 2 * mu * ufl.inner(ufl.sym(ufl.grad(u)), ufl.grad(v)) - p * ufl.div(v)
        return (forces - q * (ufl.div(u) + p / bulk)) * dx
    F = ufl.Identity(len(u)) + ufl.grad(u)
    J = ufl.det(F)
    energy = (mu / 2 * (ufl.inner(F, F) - len(u) - 2 * ufl.ln(J)) - p * (J - 1) - p**2 / (2 * bulk)) * dx
    return ufl.derivative(energy, w, ufl.TestFunction(w.function_space))


def check_pressure_and_displacement():
    """Taylor and Hood's elements in the units of steel, where the equation of the pressure is 1e-16 of the forces."""
    for cell in CELLS if COMM.size == 1 else ("triangle", "hexahedron"):
        domain = body(cell, 2)
        W = taylor_hood(domain)
        results = []
        for own in (True, False):
            w = fem.Function(W, name="w")
            v, _ = ufl.TestFunctions(W)
            residual = two_field(w, young=2e11) - 1e7 * v[1] * ufl.ds
            bcs = [clamp(W), clamp(W, 1.0, [1e-4] + [0.0] * (domain.geometry.dim - 1))]
            if own:
                # LU leaves round-off of forces in the equation of the pressure; a second iteration removes it.
                assert sum(di.StaticProblem(w, residual=residual, bcs=bcs).solve().iterations) <= 2, cell
            else:
                solve_plainly(residual, w, bcs)
            results.append(w)
        assert_same_fields(*results)


def check_finite_strain():
    """Every field converges, also where the equation of the pressure is small beside the forces."""
    for cell, young in (("triangle", 2e9), ("quadrilateral", 1.0)):
        domain = body(cell, 3)
        W = taylor_hood(domain)
        results = []
        for own in (True, False):
            w = fem.Function(W, name="w")
            bcs = [clamp(W), clamp(W, 1.0, [0.1, 0.05])]
            residual = two_field(w, young, finite=True)
            if own:
                di.StaticProblem(w, residual=residual, bcs=bcs).solve()
            else:
                solve_plainly(residual, w, bcs)
            results.append(w)
        assert_same_fields(*results)


def heated(w):
    """Heat that conducts the better the hotter it is, in a body whose forces are 1e12 times larger."""
    (u, T), (v, q) = ufl.split(w), ufl.TestFunctions(w.function_space)
    x = ufl.SpatialCoordinate(w.function_space.mesh)
    stress = 2e11 * (ufl.sym(ufl.grad(u)) - 1e-5 * T * ufl.Identity(2))
    heat = (1 + T**2) * ufl.dot(ufl.grad(T), ufl.grad(q)) + T * q - 10 * ufl.sin(5 * x[0]) * q
    return (ufl.inner(stress, ufl.grad(v)) + heat) * ufl.dx(degree=4)


def check_a_small_equation_beside_large_forces():
    """The equation of the heat must hold as well."""
    W = taylor_hood(body("triangle", 3), 0)
    results = []
    for own in (True, False):
        w = fem.Function(W, name="w")
        residual = heated(w)
        if own:
            report = di.StaticProblem(w, residual=residual, bcs=[clamp(W)]).solve()
            assert len(report.residual_norms[0]) > 4, report.residual_norms  # the mechanical part is linear
        else:
            solve_plainly(residual, w, [clamp(W)])
        results.append(w)
    assert_same_fields(*results)


def check_methods_of_petsc():
    """PETSc's methods have one norm of all fields: fields of one size are solved, an equation that is small beside the
    others is seen not to hold."""
    domain = body("quadrilateral", 3)
    W = taylor_hood(domain)
    results = []
    for own in (True, False):
        w = fem.Function(W, name="w")
        bcs = [clamp(W), clamp(W, 1.0, [0.1, 0.05])]
        residual = two_field(w, 1.0, finite=True)
        if own:
            problem = di.StaticProblem(w, residual=residual, bcs=bcs, options={"snes_type": "newtonls"})
            problem.solve(rtol=1e-13)
        else:
            solve_plainly(residual, w, bcs)
        results.append(w)
    assert_same_fields(*results)
    W = taylor_hood(body("triangle", 3), 0)
    w = fem.Function(W, name="w")
    start = w.x.array.copy()
    problem = di.StaticProblem(w, residual=heated(w), bcs=[clamp(W)], options={"snes_type": "newtonls"})
    with pytest.raises(RuntimeError, match="in which the equation of one does not hold yet"):
        problem.solve()
    assert np.array_equal(w.x.array, start)


def check_mixed_poisson():
    """Flux of Raviart and Thomas, potential constant by cell: elements that have no nodes."""
    domain = body("triangle", 4)
    elements = [basix.ufl.element("RT", "triangle", 1), basix.ufl.element("DG", "triangle", 0)]
    W = fem.functionspace(domain, basix.ufl.mixed_element(elements))
    x = ufl.SpatialCoordinate(domain)
    results = []
    for own in (True, False):
        w = fem.Function(W, name="w")
        (s, p), (t, q) = ufl.split(w), ufl.TestFunctions(W)
        residual = (ufl.inner(s, t) + p * ufl.div(t) + q * ufl.div(s) + ufl.exp(x[0]) * q) * ufl.dx
        if own:
            di.StaticProblem(w, residual=residual).solve()
        else:
            solve_plainly(residual, w, [])
        results.append(w)
    assert_same_fields(*results)


def cahn_hilliard(w, rate, before=None, theta=1.0):
    """Concentration and chemical potential; rate of the concentration, and the potential in the flux."""
    (c, m), (q, v) = ufl.split(w), ufl.TestFunctions(w.function_space)
    c = ufl.variable(c)
    well = ufl.diff(100.0 * c**2 * (1 - c) ** 2, c)
    flux = m if before is None else theta * m + (1 - theta) * ufl.split(before)[1]
    dx = ufl.dx(degree=4)
    return (rate * q + ufl.dot(ufl.grad(flux), ufl.grad(q)) + m * v - well * v) * dx - 1e-2 * ufl.dot(
        ufl.grad(c), ufl.grad(v)
    ) * dx


def check_cahn_hilliard():
    """Steps of Euler's implicit rule: written out, as static problems; by DOLFINx; and as an implicit problem whose
    fields have no inertia."""
    domain, h, steps = body("triangle", 6), 5e-6, 3
    P1 = basix.ufl.element("Lagrange", "triangle", 1)
    W = fem.functionspace(domain, basix.ufl.mixed_element([P1, P1]))

    def start():
        w = fem.Function(W, name="w")
        w.sub(0).interpolate(lambda x: 0.6 + 0.02 * np.sin(7 * x[0]) * np.cos(5 * x[1]))
        return w

    results = []
    for own in (True, False):
        w, before = start(), start()
        residual = cahn_hilliard(w, (ufl.split(w)[0] - ufl.split(before)[0]) / h)
        problem = di.StaticProblem(w, residual=residual) if own else None
        for _ in range(steps):
            before.x.array[:] = w.x.array
            if problem is not None:
                problem.solve(rtol=1e-13)
            else:
                solve_plainly(residual, w, [])
        results.append(w)
    w, velocity = start(), fem.Function(W, name="velocity")
    residual = cahn_hilliard(w, ufl.split(velocity)[0])
    problem = di.NewmarkProblem(w, residual=residual, density=[0, 0], velocity=velocity)
    problem.advance(steps * h, dt=h, rtol=1e-13, progress=False)
    assert_same_fields(results[0], results[1])
    assert_same_fields(w, results[1])


def check_implicit_steps():
    """Newmark's method on the displacement, whose pressure has no inertia, written out in UFL; energy is conserved."""
    domain, h, steps, rho = body("triangle", 3), 0.1, 5, 1.3
    W = taylor_hood(domain)
    v, _ = ufl.TestFunctions(W)
    weight = 0.1 * v[1] * ufl.dx
    w = fem.Function(W, name="w")
    bc = clamp(W)
    problem = di.NewmarkProblem(w, residual=two_field(w) - weight, density=[rho, 0.0], bcs=[bc])
    problem.advance(steps * h, dt=h, progress=False)
    assert abs(problem.energy["drift"]) < 1e-9

    other, u0, v0, a0 = (fem.Function(W) for _ in range(4))
    start = fem.Function(W)  # rho a = weight; the pressure takes part as an identity
    (a, p), (_, q) = ufl.split(start), ufl.TestFunctions(W)
    solve_plainly(rho * ufl.inner(a, v) * ufl.dx + p * q * ufl.dx - weight, start, [bc])
    a0.x.array[:] = start.x.array
    parts = [ufl.split(f)[0] for f in (other, u0, v0, a0)]
    acceleration = 4 / h**2 * (parts[0] - parts[1] - h * parts[2]) - parts[3]
    residual = rho * ufl.inner(acceleration, v) * ufl.dx + two_field(other) - weight
    for _ in range(steps):
        u0.x.array[:] = other.x.array
        solve_plainly(residual, other, [bc])
        a1 = 4 / h**2 * (other.x.array - u0.x.array - h * v0.x.array) - a0.x.array
        v0.x.array[:] += h / 2 * (a0.x.array + a1)
        a0.x.array[:] = a1
    assert_same_fields(w, other)


def coupled(w, c=0.3):
    """A displacement and a scalar that have stiffness of their own and share some."""
    (u, f), (v, q) = ufl.split(w), ufl.TestFunctions(w.function_space)
    strain, dx = ufl.sym(ufl.grad(u)), ufl.dx(degree=4)
    return (ufl.inner(strain + ufl.tr(strain) * ufl.Identity(len(u)) + c * f * ufl.Identity(len(u)), ufl.grad(v))
            + ufl.inner(ufl.grad(f), ufl.grad(q)) + (f + f**3 + c * ufl.div(u)) * q) * dx  # fmt: skip


def check_explicit_steps():
    """Central differences with a density for each field, against their formula with forces by DOLFINx; the sum of the
    masses of a field is that of its density."""
    for cell, low in (("triangle", 0), ("quadrilateral", 1)):
        domain = body(cell, 2)
        W = taylor_hood(domain, low)
        dim = domain.geometry.dim
        rng = np.random.default_rng(3)
        w = fem.Function(W, name="w")
        w.x.array[:] = 0.0
        w.sub(0).interpolate(lambda x: 0.1 * np.sin(3 * x[:dim] + 1))
        w.sub(1).interpolate(lambda x: 0.2 * np.cos(2 * x[0] + x[1]))
        start, steps = w.x.array.copy(), int(rng.integers(7, 9))
        residual = coupled(w)
        problem = di.ExplicitProblem(w, residual=residual, density=[2.0, 1.0 + ufl.SpatialCoordinate(domain)[0]])
        num = W.dofmap.index_map.size_local
        volume = COMM.allreduce(fem.assemble_scalar(fem.form(fem.Constant(domain, 1.0) * ufl.dx)))
        center = COMM.allreduce(fem.assemble_scalar(fem.form(ufl.SpatialCoordinate(domain)[0] * ufl.dx)))
        masses = []
        for i in range(2):
            _, dofs = compat.collapse(W.sub(i))
            dofs = np.asarray(dofs)
            masses.append(COMM.allreduce(problem.mass.array[dofs[dofs < num]].sum()))
        np.testing.assert_allclose(masses, [2.0 * volume * dim, volume + center], rtol=1e-12)
        stable = problem.stable_step()
        assert 0.3 * problem.stable_step("eigenvalue") < stable < 1.0001 * problem.stable_step("eigenvalue")
        h = 0.5 * stable
        problem.advance(steps * h, dt=h, progress=False)
        other, velocity, form = fem.Function(W), np.zeros(num), None
        other.x.array[:] = start
        form = fem.form(coupled(other))
        for step in range(steps):
            other.x.scatter_forward()
            b = petsc.assemble_vector(form)
            b.ghostUpdate(PETSc.InsertMode.ADD, PETSc.ScatterMode.REVERSE)
            velocity -= (0.5 if step == 0 else 1.0) * h * b.array / problem.mass.array[:num]
            other.x.array[:num] += h * velocity
            b.destroy()
        other.x.scatter_forward()
        assert_same_fields(w, other)
        assert abs(problem.energy["drift"]) < 1e-12


def check_what_is_refused():
    """One sentence, before any work."""
    domain = body("triangle", 2)
    W = taylor_hood(domain)
    w, bc = fem.Function(W, name="w"), clamp(W)
    residual = two_field(w)
    facets = mesh.locate_entities_boundary(domain, 1, lambda x: np.isclose(x[0], 1.0))
    tags = mesh.meshtags(domain, 1, np.sort(facets), np.ones(len(facets), dtype=np.int32))
    pair = di.ContactPair(tags, 1, di.RigidPlane((1.1, 0.0), (-1.0, 0.0)))
    both = {"density": [1.0, 0.0], "residual": residual}
    for kind, given, text in (
        (di.ExplicitProblem, both, "field 1 .*no inertia.*NewmarkProblem"),
        (di.ExplicitProblem, {**both, "density": 1.0}, "2 fields.*a density for each"),
        (di.NewmarkProblem, {**both, "density": 1.0}, "2 fields.*a density for each"),
        (di.NewmarkProblem, {**both, "density": [1.0]}, "2 fields.*a density for each"),
        (di.NewmarkProblem, {**both, "density": [-1.0, 0.0]}, "density is -1"),
        (di.NewmarkProblem, {**both, "contact": [di.Penalty(pair)]}, "mixed space.*contact"),
        (di.StaticProblem, {"residual": residual, "contact": [di.Lagrange(pair)]}, "mixed space.*contact"),
        (di.StaticProblem, {"residual": residual, "loads": [di.Traction(tags, 1, (1.0, 0.0))]}, "mixed.*ufl.inner"),
        (di.StaticProblem, {"material": di.LinearElastic(1.0, 0.3, hypothesis="plane_strain")}, "mixed space.*alone"),
    ):  # fmt: skip
        with pytest.raises(ValueError, match=text):
            kind(w, bcs=[bc], **given)
    problem = di.NewmarkProblem(w, residual=residual, density=[1.0, 0.0], bcs=[bc])
    for call in (lambda: problem.save("w.h5"), lambda: problem.restore("w.h5"), lambda: problem.record("w")):
        with pytest.raises(ValueError, match="mixed space"):
            call()
    with pytest.raises(ValueError, match="several fields"):
        problem.advance(1.0, dt=0.1, tolerance=1e-3)
    triangle = fem.functionspace(domain, basix.ufl.mixed_element([basix.ufl.element("RT", "triangle", 1)] * 2))
    f = fem.Function(triangle, name="f")
    flux = ufl.inner(f, ufl.TestFunction(triangle)) * ufl.dx
    with pytest.raises(ValueError, match="field 0 .*Lagrange"):
        di.ExplicitProblem(f, residual=flux, density=[1.0, 1.0])
