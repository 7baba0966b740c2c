# SPDX-License-Identifier: MIT
"""Stable steps of bodies that change as they go, on any number of ranks. See on_ranks.py."""

import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact._cpp.problems import InputChanges

COMM = MPI.COMM_WORLD
CELLS = ("triangle", "quadrilateral", "tetrahedron", "hexahedron")
# Under dt="auto" the stable step may shrink by 0.1 between two looks. Cells that are struck deform a little more before
# the next look: a few steps this far beyond the limit do not grow into anything.
BEYOND = 1.05


class Block:
    """A unit block that may hit a plane below it; speeds are those relative to waves, of the order of one."""

    def __init__(self, cell, degree=1, comm=COMM):
        self.dim, kind = (2 if cell in CELLS[:2] else 3), getattr(mesh.CellType, cell)
        n = {2: 8, 3: 4}[self.dim] // degree
        make = mesh.create_unit_square if self.dim == 2 else mesh.create_unit_cube
        self.mesh = make(comm, *(n,) * self.dim, kind)
        self.V = fem.functionspace(self.mesh, ("Lagrange", degree, (self.dim,)))
        self.u, self.w, self.velocity = fem.Function(self.V), ufl.TestFunction(self.V), fem.Function(self.V)
        last = self.dim - 1
        below = mesh.locate_entities_boundary(self.mesh, last, lambda x: np.isclose(x[last], 0.0))
        tags = mesh.meshtags(self.mesh, last, np.sort(below), np.ones(len(below), dtype=np.int32))
        plane = di.RigidPlane((0.0,) * self.dim, (0.0,) * last + (1.0,))
        self.pair = di.ContactPair(tags, 1, plane)
        self.hypothesis = "plane_strain" if self.dim == 2 else None

    def stretch(self):
        """J, and the first invariant of F^T F in three dimensions."""
        F = ufl.Identity(self.dim) + ufl.grad(self.u)
        return ufl.det(F), ufl.tr(F.T * F) + 3 - self.dim


class Looks:
    """What a run's steps are to the stable step, every few steps, and how often that was found."""

    def __init__(self, problem, every=3, set_values=None):
        self.worst, self._every, self._set_values = 0.0, every, set_values
        self._problem = problem
        self._own = np.array(self._counted())  # before the run, and by this object

    def _counted(self):
        frequencies = self._problem._frequencies._cpp_object
        return frequencies.num_looks, frequencies.num_cells_looked_at

    @property
    def times(self):
        return self._counted()[0] - self._own[0]

    @property
    def cells(self):
        return self._problem.comm.allreduce(int(self._counted()[1] - self._own[1]))

    def __call__(self, problem):
        if self._set_values is not None:
            self._set_values(problem.time)
        if problem.step and problem.step % self._every == 0:
            before = np.array(self._counted())
            steps = problem.steps_by_cell(*problem.frequencies_by_cell())
            self._own += np.array(self._counted()) - before
            smallest = problem.comm.allreduce(float(np.min(steps, initial=np.inf)), MPI.MIN)
            self.worst = max(self.worst, problem._stepper.schedule.dt / smallest)


def check_steps_follow_a_body_that_is_struck():
    """At a fifth and two fifths of the speed of waves, far beyond what is real, steps stay stable; nothing fails."""
    for cell in CELLS:
        for speed in (0.2, 0.4):
            block = Block(cell, degree=2 if cell == "triangle" else 1)
            block.velocity.interpolate(lambda x, s=speed: np.vstack([0.0 * x[1 : block.dim], 0.0 * x[0] - s]))
            law = di.NeoHookean(1.0, 0.3, 1.0, block.hypothesis)
            contact = [di.Penalty(block.pair)]
            problem = di.ExplicitProblem(block.u, law, velocity=block.velocity, contact=contact)
            looks = Looks(problem)
            problem.advance(1.0, callback=looks, progress=False)
            assert 0.0 < looks.worst < BEYOND, (cell, speed, looks.worst)


def check_steps_follow_plastic_flow():
    """Plastic flow at 0.07 of the speed of waves flattens cells to half of their stable step; only those on their way
    to the limit are looked at again, whether steps are automatic or given."""
    for cell in CELLS[1::2]:
        for given in (False, True):
            block = Block(cell)
            block.velocity.interpolate(lambda x: np.vstack([0.0 * x[1 : block.dim], 0.0 * x[0] - 0.07]))
            law = di.J2Plasticity(
                1.0, 0.3, density=1.0, yield_stress=0.003, hardening=1e-3, finite_strain=True,
                hypothesis=block.hypothesis,
            )  # fmt: skip
            problem = di.ExplicitProblem(block.u, law, velocity=block.velocity, contact=[di.Penalty(block.pair)])
            looks, step = Looks(problem), 0.4 * problem.stable_step() if given else "auto"
            problem.advance(4.0, dt=step, callback=looks, progress=False)
            assert 0.0 < looks.worst < BEYOND, (cell, given, looks.worst)
            num_cells = block.mesh.topology.index_map(block.dim).size_global
            assert looks.times > 2 and looks.cells < looks.times * num_cells, (cell, given, looks.cells)


def check_steps_follow_a_law_that_stiffens():
    """Fung's law, whose stiffness grows exponentially: the steps fall below 0.8 of the first ones."""
    for cell in CELLS:
        block = Block(cell)
        J, I1 = block.stretch()
        energy = 0.1 * ufl.exp(2 * (I1 - 3)) - 0.4 * ufl.ln(J) + 0.3 * ufl.ln(J) ** 2
        residual = ufl.derivative(energy * ufl.dx(degree=3), block.u, block.w)
        last = block.dim - 1
        block.velocity.interpolate(lambda x: np.vstack([0.0 * x[1 : block.dim], 0.2 * np.sin(np.pi * (x[last] - 0.5))]))
        problem = di.ExplicitProblem(block.u, residual=residual, density=1.0, velocity=block.velocity)
        start, looks = problem.stable_step(), Looks(problem)
        problem.advance(2.0, callback=looks, progress=False)
        assert problem._stepper.nominal_step < 0.8 * start
        assert looks.worst < BEYOND, (cell, looks.worst)


def check_steps_follow_what_a_callback_sets():
    """A modulus that grows 25-fold within a call, as a constant or a function, in laws that are linear or not."""
    for cell in CELLS[1:3]:
        for nonlinear in (False, True):
            for space in (None, ("DG", 0)):
                block = Block(cell)
                k = (
                    fem.Constant(block.mesh, 1.0)
                    if space is None
                    else fem.Function(fem.functionspace(block.mesh, space))
                )
                values = k.value if space is None else k.x.array
                values[...] = 1.0
                e = ufl.sym(ufl.grad(block.u))
                energy = k * (ufl.inner(e, e) + 0.5 * ufl.tr(e) ** 2)
                if nonlinear:
                    energy = energy + k * ufl.tr(e) ** 4
                residual = ufl.derivative(energy * ufl.dx(degree=4), block.u, block.w)
                block.velocity.interpolate(lambda x: 0.1 * np.sin(3 * x[: block.dim]))
                problem = di.ExplicitProblem(block.u, residual=residual, density=1.0, velocity=block.velocity)

                def grow(time, values=values):
                    values[...] = 1.0 + 24.0 * time

                looks = Looks(problem, set_values=grow)
                problem.advance(1.0, callback=looks, progress=False, energy_limits=None)
                assert looks.worst < BEYOND and problem.step > 20, (cell, nonlinear, space, looks.worst)
                assert np.all(np.abs(problem.u.x.array) < 0.5)


def check_only_cells_that_deform_are_looked_at():
    """A bar whose end is struck: frequencies are found once for all cells, then for few of them, at every look."""
    bar = mesh.create_rectangle(COMM, [(0.0, 0.0), (20.0, 1.0)], [80, 4], mesh.CellType.quadrilateral)
    V = fem.functionspace(bar, ("Lagrange", 1, (2,)))
    velocity = fem.Function(V)
    velocity.interpolate(lambda x: np.array([-0.2 * (x[0] > 19.0), 0.0 * x[0]]))
    problem = di.ExplicitProblem(fem.Function(V), di.NeoHookean(1.0, 0.3, 1.0, "plane_strain"), velocity=velocity)
    looks = Looks(problem)
    problem.advance(4.0, callback=looks, progress=False)
    assert looks.worst < 1.0 and looks.times > 3
    assert looks.cells < 0.3 * looks.times * 320


def check_a_body_that_rests_is_not_looked_at_again():
    block = Block("hexahedron")
    problem = di.ExplicitProblem(block.u, di.NeoHookean(1.0, 0.3, 1.0))
    looks = Looks(problem)
    problem.advance(600 * problem.stable_step(), progress=False)
    assert problem.step > 600 and looks.times == 1  # of stable_step, called here


def check_ranks_without_cells_look_with_the_others():
    """One cell, which one of the ranks has: its masses are computed by all, and kept by all."""
    domain = mesh.create_unit_square(COMM, 1, 1, mesh.CellType.quadrilateral)
    u = fem.Function(fem.functionspace(domain, ("Lagrange", 1, (2,))))
    velocity = fem.Function(u.function_space)
    velocity.interpolate(lambda x: np.stack([10.0 * x[0], 0.0 * x[1]]))  # a quarter of the speed of waves
    law = di.NeoHookean(1e3, 0.3, density=1.0, hypothesis="plane_strain")
    problem = di.ExplicitProblem(u, law, velocity=velocity)
    problem.advance(until=1.0, progress=False)
    found = COMM.allgather((problem.step, problem._cpp_object.safe_step.num_found))
    assert found[0][1] > 1 and set(found) == {found[0]}


def check_what_is_allowed_follows_from_effects():
    """An input that changes nothing is looked at less and less; one that changes much more often; never less than every
    hundredth."""
    harmless, strong = InputChanges(), InputChanges()
    for _ in range(5):
        harmless.add(1.0)
        harmless.done(1.0, 1.0)
    assert harmless.allowed > 2.0 and not harmless.stale
    strong.add(0.4)
    assert strong.due
    strong.done(1.0, 0.5)
    assert strong.allowed == pytest.approx(InputChanges.effect * 0.4 / (1.5 * 2 * np.log(2)))
    strong.add(0.011)
    strong.done(1.0, 1e-9)
    assert strong.allowed == 0.01
    strong.add(np.inf)
    assert strong.due
    strong.done(1.0, 1.0)
    assert strong.allowed == 0.01
