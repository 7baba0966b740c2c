# SPDX-License-Identifier: MIT
"""Residuals with integrals over interior facets, and with stresses at quadrature points, on the ranks of COMM_WORLD:
what is assembled, with and without contact, and what is refused; see on_ranks.py."""

import functools

import basix.ufl
import numpy as np
import pytest
import ufl
from dolfinx import fem, la, mesh
from mixed_spaces_checks import solve_plainly
from mpi4py import MPI
from static_problem_checks import clamp, facets_at, space, total
from shared_folder import shared_folder

import dolfinx_impact as di

COMM = MPI.COMM_WORLD
SAME = 1e-10  # of the largest value: matrices with condition numbers up to some 1e5


@functools.cache
def squares(triangles, alone=False):
    """One mesh for all bodies that are compared by their arrays: DOLFINx may partition a second one otherwise.

    Args:
        triangles: 4 x 4 squares of two triangles each; or 4 x 3 squares.
        alone: all of it on each rank.
    """
    comm = MPI.COMM_SELF if alone else COMM
    return (
        mesh.create_unit_square(comm, 4, 4)
        if triangles
        else mesh.create_unit_square(comm, 4, 3, mesh.CellType.quadrilateral)
    )


class Bending:
    """A body that resists jumps of the slope between its cells (C0 interior penalty), held at x = 0 and pressed."""

    def __init__(self, place=False, alone=False):
        self.mesh = squares(True, alone)
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


class Glued:
    """Two blocks of discontinuous cells, glued along x = 1/2 (tag 2) by a law that softens as they part; elsewhere
    symmetric interior penalty. A traction on ds."""

    def __init__(self):
        self.mesh = squares(False)
        self.mesh.topology.create_entities(1)
        tdim, numbers = 2, self.mesh.topology.index_map(1)
        self.mesh.topology.create_connectivity(1, tdim)
        facets = np.arange(numbers.size_local + numbers.num_ghosts, dtype=np.int32)
        place = mesh.compute_midpoints(self.mesh, 1, facets)[:, 0]
        joint = np.where(np.isclose(place, 0.5), 2, np.where(place < 0.5, 1, 3)).astype(np.int32)
        self.tags = mesh.meshtags(self.mesh, 1, facets, joint)
        self.V = fem.functionspace(self.mesh, ("DG", 1, (2,)))
        self.u, self.v = fem.Function(self.V, name="u"), ufl.TestFunction(self.V)
        self.glue, self.pull = fem.Constant(self.mesh, 1.0), fem.Constant(self.mesh, 0.02)

    def residual(self):
        u, v, n, h = self.u, self.v, ufl.FacetNormal(self.mesh), ufl.CellDiameter(self.mesh)
        rule, ends = {"quadrature_degree": 2}, ufl.SpatialCoordinate(self.mesh)[0] - 0.5
        dS = ufl.Measure("dS", self.mesh, subdomain_data=self.tags, metadata=rule)

        def stress(w):
            return ufl.tr(ufl.grad(w)) * ufl.Identity(2) + ufl.sym(ufl.grad(w))

        def flux(w):
            return ufl.avg(stress(w)) * n("+")

        opening = ufl.jump(u)
        body = ufl.inner(stress(u), ufl.grad(v)) * ufl.dx(metadata=rule)
        glued = self.glue * ufl.exp(-20 * ufl.inner(opening, opening)) * ufl.inner(opening, ufl.jump(v)) * dS(2)
        within = 8 / ufl.avg(h) * ufl.inner(opening, ufl.jump(v)) - ufl.inner(flux(u), ufl.jump(v))
        within -= ufl.inner(opening, flux(v))
        return body + glued + within * dS((1, 3)) - self.pull * ends * v[0] * ufl.ds(metadata=rule)


def leapfrog(residual, u, mass, dt, steps, free, callback=None):
    """Central differences with the assembly of DOLFINx, from rest."""
    form, velocity = fem.form(residual), np.zeros(len(u.x.array))
    for step in range(steps):
        if callback is not None:
            callback(step * dt)
        force = fem.assemble_vector(form)
        force.scatter_reverse(la.InsertMode.add)
        force.scatter_forward()
        velocity -= (0.5 if step == 0 else 1.0) * dt * free * force.array / mass
        u.x.array[:] += dt * velocity


def check_explicit():
    """Against a loop with DOLFINx's assembly: a body with jumps of the slope, held; two glued blocks that part, whose
    glue and load a callback changes. The step is bounded, by half at least."""
    b, other = Bending(), Bending()
    problem = di.ExplicitProblem(b.u, residual=b.residual(), density=1.0, bcs=[b.bc])
    assert 0.5 < problem.stable_step() / problem.stable_step(method="eigenvalue") < 1.0
    problem.advance(1.0, progress=False)
    leapfrog(other.residual(), other.u, problem.mass.array, 1.0 / problem.step, problem.step, ~problem.prescribed)
    assert_same(b.u.x.array, other.u.x.array)

    b, other = Glued(), Glued()
    problem = di.ExplicitProblem(b.u, residual=b.residual(), density=1.0)
    assert 0.5 < problem.stable_step() / problem.stable_step(method="eigenvalue") < 1.0

    def soften(of, time):
        of.glue.value, of.pull.value = 1 - 0.3 * time, 0.02 + 0.1 * time

    problem.advance(3.0, dt=0.02, callback=lambda p: soften(b, p.time), progress=False)
    leapfrog(other.residual(), other.u, problem.mass.array, 0.02, 150, 1.0, lambda time: soften(other, time))
    assert_same(b.u.x.array, other.u.x.array)
    assert abs(problem.energy["drift"]) < 1e-3
    momentum = total(b.V, problem.mass.array * problem.velocity.x.array)
    assert np.all(np.abs(momentum) < 1e-13)  # the loads are in balance, forces between cells must be


def check_explicit_contact():
    """A body with jumps of the slope that falls on a floor, and the same body on one rank alone."""
    found = []
    for alone in (False, True):
        b = Bending(alone=alone)
        velocity = fem.Function(b.V)
        velocity.interpolate(lambda x: np.array([0 * x[0], -0.1 + 0 * x[0]]))
        pair = di.ContactPair(facets_at(b.mesh, y=0.0), 1, di.RigidPlane((0.0, -0.01), (0.0, 1.0)))
        problem = di.ExplicitProblem(
            b.u, residual=b.residual(), density=1.0, velocity=velocity, contact=[di.Penalty(pair)]
        )
        problem.advance(0.8, dt=0.004, progress=False)
        found.append([problem.energy[name] for name in ("kinetic", "internal", "contact")])
        found[-1].append(problem.contact[0].force[1])
    assert found[0][3] > 0.0 and np.allclose(*found, rtol=1e-9), found


def check_explicit_restart():
    """Goes on bit for bit from a checkpoint."""
    b = Glued()
    problem = di.ExplicitProblem(b.u, residual=b.residual(), density=1.0)
    problem.advance(0.5, dt=0.02, progress=False)
    with shared_folder() as folder:
        problem.save(folder / "half.h5")
        problem.advance(1.0, dt=0.02, progress=False)
        straight = b.u.x.array.copy()
        problem.restore(folder / "half.h5")
        problem.advance(1.0, dt=0.02, progress=False)
    assert np.array_equal(b.u.x.array, straight)


def check_wrong_signs():
    """Springs and dashpots between cells that feed energy in."""
    for damped, words in ((False, "tangent of the residual is negative"), (True, "feeds energy in")):
        b = Glued()
        velocity, residual = fem.Function(b.V, name="velocity"), b.residual()
        if damped:
            residual -= ufl.inner(ufl.jump(velocity), ufl.jump(b.v)) * ufl.dS(degree=2)
        b.glue.value = 1.0 if damped else -50.0
        with pytest.raises(ValueError, match=words):
            di.ExplicitProblem(b.u, residual=residual, density=1.0, velocity=velocity)


def check_what_is_refused():
    b = Bending()
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
