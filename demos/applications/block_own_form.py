# # A foam drawn between plates: a residual of your own
#
# The package brings its materials as UFL; a user's own form goes the same way. Here it is the foam of Blatz and Ko
# (1962), which no catalogue of this package knows: strain energy per volume
#
# $$W = \frac{\mu}{2} \left( \frac{I_2}{J^2} + 2 J - 5 \right), \quad I_2 = \tfrac12 (\mathrm{tr}^2 C - \mathrm{tr}\,
# C^2), \quad J = \det F,$$
#
# which behaves like Poisson's ratio 1/4 at small strain. Its residual is compiled at run time into a C++ kernel that
# computes several cells at once, and is checked against DOLFINx's own assembly; the problem is solved and checked
# against Newton's method with DOLFINx's assembly and against a closed form.

import os
import time

import numpy as np
import ufl
from mpi4py import MPI
from dolfinx import fem, la, mesh
from dolfinx.fem import petsc
from petsc4py import PETSc

import dolfinx_impact as di
from dolfinx_impact.io import plots
from dolfinx_impact.io.run_folder import RunFolder

comm = MPI.COMM_WORLD
n = 4 if os.environ.get("IMPACT_DEMO_FAST") == "1" else 10
mu, stretch = 1.0e6, 1.5  # shear modulus [Pa], length after over length before [1]
run = RunFolder(name="block_own_form", parameters={"mu": mu, "stretch": stretch, "cells": n})

block = mesh.create_unit_cube(comm, n, n, n, mesh.CellType.hexahedron)
V = fem.functionspace(block, ("Lagrange", 1, (3,)))
u, v = fem.Function(V, name="displacement"), ufl.TestFunction(V)


def residual(u):
    """Derivative of the stored energy in the direction v."""
    F = ufl.Identity(3) + ufl.grad(u)
    C, J = F.T * F, ufl.det(F)
    second = (ufl.tr(C) ** 2 - ufl.tr(C * C)) / 2
    energy = mu / 2 * (second / J**2 + 2 * J - 5)
    return ufl.derivative(energy * ufl.dx(metadata={"quadrature_degree": 3}), u, v)


# ## The same vector twice
#
# Any displacement will do for the comparison; this one is smooth and far from zero. `InternalForce` finds no kernel of
# this form in the package, has one compiled, and keeps it in the cache for the next run.

u.interpolate(lambda x: 0.1 * np.array([np.sin(2 * x[0] + x[1]), x[0] * x[2], np.cos(x[1] - 2 * x[2])]))
began = time.perf_counter()
force = di.InternalForce(residual(u))
run.print(f"kernel of the own form: {force.width} cells at once, ready after {time.perf_counter() - began:.1f} s")
ours = force.apply()

assembled = fem.assemble_vector(fem.form(residual(u)))
assembled.scatter_reverse(la.InsertMode.add)
assembled.scatter_forward()
owned = V.dofmap.index_map.size_local * 3
scale = comm.allreduce(np.abs(assembled.array).max(), MPI.MAX)
kernels = comm.allreduce(np.abs(ours.array - assembled.array)[:owned].max(), MPI.MAX) / scale
run.print(f"InternalForce against fem.assemble_vector: {kernels:.1e} of the largest force")

# ## A bar that may contract: closed form
#
# Drawn along x between smooth plates, symmetry on three sides: the stretches are $\lambda$ and $\lambda^{-1/4}$, the
# nominal stress is $\mu (\lambda^{-1/2} - \lambda^{-3})$ (Blatz & Ko 1962, from $\partial W / \partial \lambda_i$ with
# free sides). The strain is the same everywhere, so the finite elements hit it exactly.


def on_side(axis, position):
    """Facets on a side of the cube."""
    return mesh.locate_entities_boundary(block, 2, lambda x: np.isclose(x[axis], position))


def held(axis, side_axis, position, value):
    """Displacement component prescribed on a side."""
    dofs = fem.locate_dofs_topological(V.sub(axis), 2, on_side(side_axis, position))
    return fem.dirichletbc(float(value), dofs, V.sub(axis))


u.x.array[:] = 0.0
smooth = [held(i, i, 0.0, 0.0) for i in range(3)] + [held(0, 0, 1.0, stretch - 1)]
problem = di.StaticProblem(u, residual=residual(u), bcs=smooth)
report = problem.solve()
pulled = fem.locate_dofs_topological(V, 2, on_side(0, 1.0))
pulled = pulled[pulled < owned // 3]
stress = comm.allreduce(problem.reactions().x.array[3 * pulled].sum())  # over an area of 1
theory = mu * (stretch**-0.5 - stretch**-3)
side = comm.allreduce(u.x.array.reshape(-1, 3)[: owned // 3, 1].min(), MPI.MIN)
run.print(
    f"drawn to {stretch}: {report.iterations[0]} Newton iterations, nominal stress {stress / mu:.9f} mu "
    f"(closed form {theory / mu:.9f}), width {1 + side:.9f} (closed form {stretch**-0.25:.9f})"
)

# ## Glued ends: against DOLFINx's assembly
#
# With both ends glued to rigid plates nothing is homogeneous, and there is no closed form; but there is DOLFINx.
# `StaticProblem` brings in the boundary values and stops its Newton iteration in its own way; forms are assembled with
# the same C kernels, so that the two solutions agree to round-off.


def glued(V):
    """Both ends held, one of them moved."""
    values = [fem.Constant(block, np.zeros(3)), fem.Constant(block, np.array([stretch - 1, 0.0, 0.0]))]
    return [
        fem.dirichletbc(value, fem.locate_dofs_topological(V, 2, on_side(0, x)), V) for x, value in enumerate(values)
    ]


u.x.array[:] = 0.0
report = di.StaticProblem(u, residual=residual(u), bcs=glued(V)).solve()
other, bcs = fem.Function(V), glued(V)
right, left = fem.form(residual(other)), fem.form(ufl.derivative(residual(other), other))
solver, norms, x = PETSc.KSP().create(comm), [], other.x.petsc_vec
solver.setType("preonly")
solver.getPC().setType("lu")
solver.getPC().setFactorSolverType("mumps")
while True:
    b = petsc.assemble_vector(right)
    petsc.apply_lifting(b, [left], [bcs], [x], alpha=-1.0)  # with boundary values less those of x
    b.ghostUpdate(PETSc.InsertMode.ADD, PETSc.ScatterMode.REVERSE)
    petsc.set_bc(b, bcs, x, alpha=-1.0)
    norms.append(b.norm())
    if norms[-1] <= 1e-10 * norms[0] or len(norms) > 20:
        break
    A, step = petsc.assemble_matrix(left, bcs), b.duplicate()
    A.assemble()
    solver.setOperators(A)
    solver.solve(b, step)
    x.axpy(-1.0, step)
    other.x.scatter_forward()
iterations = len(norms) - 1
solvers = comm.allreduce(np.abs(u.x.array - other.x.array).max(), MPI.MAX) / (stretch - 1)
run.print(
    f"glued ends: StaticProblem {report.iterations[0]} iterations, DOLFINx {iterations}; "
    f"solutions differ by {solvers:.1e} of the elongation"
)
run.fields("block", [u])

# ## Picture

picture = di.DeformedBody(u, ufl.sqrt(u[1] ** 2 + u[2] ** 2))


def draw():
    """Called on rank 0."""
    plt = plots.pyplot()
    figure, axes = plt.subplots(figsize=(6.4, 4.2), layout="constrained")
    view = ((1, -2.2, 1), (0, 0, 1), None)
    picture.draw(axes, "transverse displacement [m]", size=(840, 560), view=view, zoom=1.25)
    axes.set_title(f"foam, glued ends, drawn to {stretch} times its length", fontsize=10)
    plots.save(figure, run.file("block_own_form.png"))


run.pictures(draw)
run.print(f"results in {run.path}")

# ## What must hold

assert kernels < 1e-13
assert abs(stress / theory - 1) < 1e-9 and abs(1 + side - stretch**-0.25) < 1e-9
assert norms[-1] <= 1e-10 * norms[0] and solvers < 1e-8
# SPDX-License-Identifier: MIT
