# SPDX-License-Identifier: MIT
"""Residuals with integrals over interior facets, and with stresses at quadrature points, on the ranks of COMM_WORLD:
what is assembled, with and without contact, and what is refused; see on_ranks.py."""

import basix.ufl
import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from mixed_spaces_checks import solve_plainly
from mpi4py import MPI
from problem_checks import clamp, facets_at, space

import dolfinx_impact as di

COMM = MPI.COMM_WORLD
SAME = 1e-10  # of the largest value: matrices with condition numbers up to some 1e5


class Bending:
    """A body that resists jumps of the slope between its cells (C0 interior penalty), held at x = 0 and pressed."""

    def __init__(self, place=False):
        self.mesh = mesh.create_unit_square(COMM, 4, 4)
        self.V = space(self.mesh, 2)
        self.u, self.v = fem.Function(self.V, name="u"), ufl.TestFunction(self.V)
        self.bc, self.place = clamp(self.V), place

    def residual(self):
        u, v, n = self.u, self.v, ufl.FacetNormal(self.mesh)
        h = ufl.CellDiameter(self.mesh)
        jump = ufl.inner(ufl.jump(ufl.grad(u), n), ufl.jump(ufl.grad(v), n)) / ufl.avg(h)
        weight = 1 + ufl.SpatialCoordinate(self.mesh)[0] if self.place else 1.0
        body = weight * ufl.inner(ufl.sym(ufl.grad(u)), ufl.grad(v)) + 0.05 * v[1]
        return body * ufl.dx(degree=4) + 0.1 * jump * ufl.dS(degree=3)


def assert_same(a, b):
    size = COMM.allreduce(np.abs(b).max(initial=0.0), MPI.MAX)
    difference = COMM.allreduce(np.abs(a - b).max(initial=0.0), MPI.MAX)
    assert 0.0 < size and difference < SAME * size, f"{difference:.1e} of {size:.1e}"


def check_static():
    """Against DOLFINx; integrands that depend on the place go the way of those that may be axisymmetric."""
    for place in (False, True):
        own, other = Bending(place), Bending(place)
        di.StaticProblem(own.u, residual=own.residual(), bcs=[own.bc]).solve()
        solve_plainly(other.residual(), other.u, [other.bc])
        assert_same(own.u.x.array, other.u.x.array)


def check_contact():
    """Penalty on a body with jumps is the residual with the penalty written into it, solved by DOLFINx; multipliers
    give its force but for the edge of the contact."""
    stiffness, forces = 1e4, []
    for method in ("penalty", "multipliers"):
        b = Bending()
        tags = facets_at(b.mesh, y=0.0)
        pair = di.ContactPair(tags, 1, di.RigidPlane((0.0, 0.0), (0.0, 1.0)))
        contact = di.Penalty(pair, penalty=stiffness, quadrature_degree=6) if method == "penalty" else di.Lagrange(pair)
        problem = di.StaticProblem(b.u, residual=b.residual(), bcs=[b.bc], contact=[contact])
        problem.solve(rtol=1e-12)
        forces.append(problem.contact[0].force[1])
        if method == "penalty":
            other = Bending()
            floor = ufl.ds(domain=other.mesh, subdomain_data=facets_at(other.mesh, y=0.0), degree=6)(1)
            depth = ufl.max_value(-other.u[1], 0.0)
            solve_plainly(other.residual() - stiffness * depth * other.v[1] * floor, other.u, [other.bc])
            assert_same(b.u.x.array, other.u.x.array)
    # The floor is touched on some of four facets, at whose edge points and nodes are in contact: not the same force.
    assert forces[0] > 0.0 and abs(forces[1] - forces[0]) < 5e-2 * forces[0], forces


def check_implicit():
    """Energy is conserved with the energy of the jumps."""
    b = Bending()
    problem = di.NewmarkProblem(b.u, residual=b.residual(), density=1.0, bcs=[b.bc])
    problem.advance(0.5, dt=0.05, progress=False)
    assert abs(problem.energy["drift"]) < 1e-9 and problem.energy["kinetic"] > 0.0


def check_what_is_refused():
    b = Bending()
    with pytest.raises(ValueError, match=r"the residual: the integral of .* over ufl.dS .*NewmarkProblem"):
        di.ExplicitProblem(b.u, residual=b.residual(), density=1.0, bcs=[b.bc])
    element = basix.ufl.quadrature_element("triangle", (2, 2), "default", 2)
    stress = fem.Function(fem.functionspace(b.mesh, element), name="stress")
    residual = ufl.inner(stress, ufl.grad(b.v)) * ufl.dx(degree=2)
    for kind, given in ((di.ExplicitProblem, {"density": 1.0}), (di.StaticProblem, {})):
        with pytest.raises(ValueError, match="stress, a function at quadrature points.*InelasticMaterial"):
            kind(b.u, residual=residual, bcs=[b.bc], **given)


def check_a_correction_at_points_set_in_a_callback():
    """The elastic part in u, a stress at the points beside it that a callback sets: an initial stress that the body
    bears at once, as if it were a constant."""
    runs = []
    for at_points in (True, False):
        b = Bending()
        element = basix.ufl.quadrature_element("triangle", (2, 2), "default", 2)
        stress = fem.Function(fem.functionspace(b.mesh, element), name="stress")
        number = fem.Constant(b.mesh, np.zeros((2, 2)))
        more = stress if at_points else number
        residual = ufl.inner(ufl.sym(ufl.grad(b.u)) + more, ufl.grad(b.v)) * ufl.dx(degree=2)
        problem = di.ExplicitProblem(b.u, residual=residual, density=1.0, bcs=[b.bc])

        def callback(p, stress=stress, number=number):
            value = p.time * np.array([[1.0, 0.2], [0.2, 0.5]])
            stress.x.array.reshape(-1, 4)[:] = value.ravel()
            number.value[:] = value

        problem.advance(0.2, dt=0.005, callback=callback, progress=False)
        runs.append(b.u.x.array.copy())
    assert_same(*runs)
