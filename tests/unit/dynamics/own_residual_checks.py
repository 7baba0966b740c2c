# SPDX-License-Identifier: MIT
"""Residuals of a user's own in explicit runs: what they read follows the run, on any number of ranks.
See on_ranks.py."""

import math

import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di

COMM = MPI.COMM_WORLD
YOUNG, NU = 1e3, 0.3
LAMBDA, MU = YOUNG * NU / ((1 + NU) * (1 - 2 * NU)), YOUNG / (2 * (1 + NU))
# Sums over cells and ranks in another order, over some hundred steps.
SAME = 1e-11


class Body:
    """A strip of squares in plane strain, or a box of cubes; u, v and test function w on it."""

    def __init__(self, comm=COMM, n=4, dim=2):
        if dim == 2:
            self.mesh = mesh.create_rectangle(comm, [[0.0, 0.0], [2.0, 1.0]], [2 * n, n], mesh.CellType.quadrilateral)
        else:
            self.mesh = mesh.create_unit_cube(comm, n, n, n, mesh.CellType.hexahedron)
        self.V = fem.functionspace(self.mesh, ("Lagrange", 1, (dim,)))
        self.u, self.v = fem.Function(self.V, name="u"), fem.Function(self.V, name="v")
        self.w, self.dim = ufl.TestFunction(self.V), dim
        self.dx = ufl.dx(domain=self.mesh, metadata={"quadrature_degree": 2})

    def elastic(self, factor=1.0, thermal=0.0):
        e = ufl.sym(ufl.grad(self.u))
        identity = ufl.Identity(self.dim)
        stress = LAMBDA * ufl.tr(e) * identity + 2 * MU * e - thermal * identity
        return factor * ufl.inner(stress, ufl.grad(self.w)) * self.dx

    def viscous(self, eta):
        """Kelvin and Voigt: stress eta times twice the strain rate."""
        return 2 * eta * ufl.inner(ufl.sym(ufl.grad(self.v)), ufl.grad(self.w)) * self.dx

    def shake(self):
        self.v.interpolate(lambda x: np.array([np.cos(3 * x[0]) + x[1], *(0.3 * np.sin(2 * x[0]),) * (self.dim - 1)]))
        return self

    def problem(self, residual, **options):
        options = {"density": 1.0, "velocity": self.v, **options}
        return di.ExplicitProblem(self.u, residual=residual, **options)

    def dot(self, f):
        """Sum of squares over all ranks."""
        owned = f.x.array[: self.V.dofmap.index_map.size_local * self.dim]
        return self.mesh.comm.allreduce(float(owned @ owned))


def check_a_constant_set_in_a_callback():
    """A free body under a weight that is switched on at time zero falls as it should."""
    for switch in (0, 5):
        b = Body()
        g = fem.Constant(b.mesh, 0.0)
        problem = b.problem(b.elastic() - g * b.w[0] * b.dx)
        dt = 0.9 * problem.stable_step()

        def callback(p, switch=switch, g=g):
            if p.step == switch:
                g.value = 1.0

        problem.advance(15 * dt, dt=dt, callback=callback, progress=False)
        # At constant acceleration from t_k on u_n is (n - k)^2 dt^2/2 for k = 0, else (n - k)(n - k + 1) dt^2/2.
        steps = 15 - switch
        expected = dt**2 * (steps**2 / 2 if switch == 0 else steps * (steps + 1) / 2)
        np.testing.assert_allclose(b.u.x.array[::2], expected, rtol=1e-12)
        assert abs(problem.energy["drift"]) < 1e-12


def check_ghosts_of_functions_set_in_a_callback():
    """A temperature of which a callback sets the owned entries: the same on any number of ranks."""
    energies = []
    for comm in (COMM, MPI.COMM_SELF):
        b = Body(comm, dim=3, n=3).shake()
        Q = fem.functionspace(b.mesh, ("Lagrange", 1))
        T = fem.Function(Q, name="T")
        x, num_owned = Q.tabulate_dof_coordinates(), Q.dofmap.index_map.size_local

        def callback(p, T=T, x=x, num_owned=num_owned):
            T.x.array[:num_owned] = 50 * np.sin(200 * p.time) * x[:num_owned, 2]

        problem = b.problem(b.elastic(thermal=T))
        dt = 0.5 * problem.stable_step()
        problem.advance(25 * dt, dt=dt, callback=callback, progress=False)
        energies.append([problem.energy[k] for k in ("kinetic", "internal")])
        assert abs(problem.energy["drift"]) < 1e-12
    np.testing.assert_allclose(energies[0], energies[1], rtol=SAME)


def check_viscosity_follows_the_run():
    """A residual with the velocity is Rayleigh's damping where that is the same law: motion, energies, stable step."""
    beta = 2e-3
    b, other = Body().shake(), Body().shake()
    e, identity = ufl.sym(ufl.grad(b.v)), ufl.Identity(2)
    stress = beta * (LAMBDA * ufl.tr(e) * identity + 2 * MU * e)
    problem = b.problem(b.elastic() + ufl.inner(stress, ufl.grad(b.w)) * b.dx)
    law = di.LinearElastic(YOUNG, NU, 1.0, "plane_strain")
    same = di.ExplicitProblem(other.u, law, velocity=other.v, damping=di.Rayleigh(0.0, beta))
    assert problem.velocity is b.v and same.velocity is not other.v
    for method in ("element", "eigenvalue"):
        # The eigenvalue to 1e-8 (tolerance of SLEPc).
        assert math.isclose(problem.stable_step(method), same.stable_step(method), rel_tol=1e-7), method
    dt = 0.9 * same.stable_step()
    problem.advance(40 * dt, dt=dt, progress=False)
    same.advance(40 * dt, dt=dt, progress=False)
    assert math.isclose(b.dot(problem.velocity), other.dot(same.velocity), rel_tol=SAME)
    assert math.isclose(b.dot(problem.u), other.dot(same.u), rel_tol=SAME)
    assert same.energy["damping"] > 0.1 * same.energy["total"]
    for name in ("kinetic", "internal", "damping"):
        assert abs(problem.energy[name] - same.energy[name]) < SAME * same.energy["total"], name
    assert abs(problem.energy["drift"]) < 1e-12


def check_a_density_that_varies():
    """By cell, by node, as an expression: the mass is the integral, and a positive one everywhere is asked for."""
    b = Body()
    for space in (("DG", 0), ("Lagrange", 1), None):
        if space is None:
            density = 1.0 + ufl.SpatialCoordinate(b.mesh)[0]
        else:
            density = fem.Function(fem.functionspace(b.mesh, space), name="density")
            density.interpolate(lambda x: 1.0 + x[0])
        problem = b.problem(b.elastic(), density=density)
        mass = COMM.allreduce(float(problem.mass.array[: problem.num_owned].sum())) / 2
        assert math.isclose(mass, 4.0, rel_tol=1e-12), space  # 1 + x over 2 by 1
    density = fem.Function(fem.functionspace(b.mesh, ("DG", 0)), name="density")
    for bad in (0.0, -1.0, np.nan):  # in one cell of one rank
        density.x.array[:] = 1.0
        if COMM.rank == COMM.size - 1:
            density.x.array[0] = bad
        with pytest.raises(ValueError, match="density"):
            b.problem(b.elastic(), density=density)
