# SPDX-License-Identifier: MIT
"""Impacts of implicit_or_explicit: three problems, each by explicit and implicit methods, with error and cost."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
from dolfinx import fem, mesh

import dolfinx_impact as di
from dolfinx_impact import meshes


@dataclass
class Method:
    """How time and contact are treated.

    Attributes:
        contact: class of the contact.
        scheme: arguments of NewmarkProblem; None: central differences.
    """

    contact: type
    scheme: dict | None = None


@dataclass
class Result:
    """One run.

    Attributes:
        error: relative to the exact solution, as the case defines it [1].
        seconds: CPU time of the steps on this rank, set-up left out [s].
        steps: number of steps [1].
        times: times of `forces`, in the case's unit of time [1].
        forces: force on the slave along the impact, over the exact one [1].
    """

    error: float
    seconds: float
    steps: int
    times: np.ndarray
    forces: np.ndarray


def _march(problem, until, dt, component):
    """Advance to a time; CPU time, times and forces of all steps."""
    begin = time.process_time()
    options = {} if dt is None else {"dt": dt}
    problem.advance(until, progress=False, **options)
    seconds = time.process_time() - begin
    return seconds, problem.energy_history[:, 0], problem.force_history[0][:, component]


class _Case:
    """A problem that is run at several levels of refinement.

    Attributes:
        title: of the case.
        clock: what `Result.times` count, and in what unit.
        levels: refinements, from coarse to fine.
    """

    def problem(self, method, pair, u, law, velocity, **options):
        """Explicit or implicit problem of a Method."""
        contact = [method.contact(pair)]
        if method.scheme is None:
            return di.ExplicitProblem(u, law, velocity=velocity, contact=contact, **options)
        return di.NewmarkProblem(u, law, velocity=velocity, contact=contact, **method.scheme, **options)


class Wave(_Case):
    """A bar strikes a rigid wall (Doyen, Ern and Piperno 2011): the force is a step of known size and length.

    The error is the root mean square of the force's deviation over the contact and half its length beyond, relative to
    the exact force. Implicit steps are as long as a wave takes through a cell.
    """

    title, clock = "waves: bar on a wall", "time after first touch / (2 L/c)"
    levels = (50, 100, 200)
    E, density, length, gap, speed = 900.0, 1.0, 10.0, 0.5, 10.0

    def __init__(self, comm):
        self.comm, self.c = comm, np.sqrt(self.E / self.density)

    def exact(self, times):
        first, last = self.gap / self.speed, self.gap / self.speed + 2 * self.length / self.c
        return np.where((times > first) & (times < last), self.density * self.c * self.speed, 0.0)

    def run(self, method, level):
        h = self.length / level
        corners = [[0.0, self.gap], [h, self.gap + self.length]]
        domain = mesh.create_rectangle(self.comm, corners, [1, level], mesh.CellType.quadrilateral)
        V = fem.functionspace(domain, ("Lagrange", 1, (2,)))
        u, velocity = fem.Function(V), fem.Function(V)
        velocity.interpolate(lambda x: np.vstack([0 * x[0], 0 * x[0] - self.speed]))
        zero = fem.Function(V.sub(0).collapse()[0])
        sides = fem.locate_dofs_geometrical((V.sub(0), zero.function_space), lambda x: x[0] > -1.0)
        foot = mesh.locate_entities_boundary(domain, 1, lambda x: np.isclose(x[1], self.gap))
        tags = mesh.meshtags(domain, 1, foot, np.full(len(foot), 1, dtype=np.int32))
        law = di.LinearElastic(self.E, 0.0, self.density, "plane_strain")
        pair = di.ContactPair(tags, 1, di.RigidPlane((0.0, 0.0), (0.0, 1.0)))
        problem = self.problem(method, pair, u, law, velocity, bcs=[fem.dirichletbc(zero, sides, V.sub(0))])
        until = self.gap / self.speed + 3 * self.length / self.c
        dt = None if method.scheme is None else h / self.c
        seconds, times, forces = _march(problem, until, dt, 1)
        forces = forces / h
        force = self.density * self.c * self.speed
        middle = 0.5 * (times[1:] + times[:-1])
        squares = (np.interp(middle, times, forces) - self.exact(middle)) ** 2 * np.diff(times)
        error = np.sqrt(squares.sum() / (3 * self.length / self.c)) / force
        clock = (times - self.gap / self.speed) / (2 * self.length / self.c)
        return Result(error, seconds, problem.step, clock, forces / force)


class Ball(_Case):
    """A steel ball falls on a rigid plane: Hertz's impact, in which the ball deforms as at rest.

    The error is that of the largest force. Implicit runs take 30 steps for the impact at the coarsest level.
    """

    title, clock = "Hertz's impact of a ball", "time after first touch / Hertz's duration"
    levels = (2, 4, 8)
    E, nu, density, radius, speed = 207e9, 0.3, 7800.0, 0.01, 0.5

    def __init__(self, comm):
        self.comm = comm
        mass = 4 / 3 * np.pi * self.radius**3 * self.density
        rigid = (np.inf, 0.0)
        self.hertz = di.theory.hertz_impact(self.speed, mass, np.inf, self.radius, np.inf, self.E, self.nu, *rigid)
        self.gap = 1e-7

    def run(self, method, level):
        a = self.hertz.max_radius
        made = meshes.make(
            "cylinder_on_half_plane", self.comm, radius=self.radius, a=a, h=a / level, gap=self.gap, whole=True,
            coarse=0.001, width=0.002, height=0.002,
        )  # fmt: skip
        V = fem.functionspace(made.mesh, ("Lagrange", 1, (2,)))
        u, velocity = fem.Function(V), fem.Function(V)
        velocity.interpolate(lambda x: np.vstack([0 * x[0], np.where(x[1] > 0.5 * self.gap, -self.speed, 0.0)]))
        tags, facets = made.tags, made.facet_tags
        zero = fem.Constant(made.mesh, 0.0)
        bcs = []
        for name, components in (("symmetry_x", (0,)), ("bottom", (0, 1))):
            for k in components:
                dofs = fem.locate_dofs_topological(V.sub(k), 1, facets.find(tags[name]))
                bcs.append(fem.dirichletbc(zero, dofs, V.sub(k)))
        law = di.LinearElastic(self.E, self.nu, self.density, "axisymmetric")
        pair = di.ContactPair(facets, tags["slave_surface"], di.RigidPlane((0.0, 0.0), (0.0, 1.0)))
        problem = self.problem(method, pair, u, law, velocity, bcs=bcs)
        dt = None if method.scheme is None else self.hertz.duration / (15 * level)
        until = self.gap / self.speed + 1.2 * self.hertz.duration
        seconds, times, forces = _march(problem, until, dt, 1)
        # Explicit contact forces chatter from step to step: means over a fiftieth of the impact, for all methods.
        smooth = self._means(times, forces)
        error = abs(smooth.max() / self.hertz.peak_force - 1.0)
        clock = (times - self.gap / self.speed) / self.hertz.duration
        return Result(error, seconds, problem.step, clock, forces / self.hertz.peak_force)

    def _means(self, times, forces):
        impulse = np.concatenate([[0.0], np.cumsum(0.5 * (forces[1:] + forces[:-1]) * np.diff(times))])
        window = self.hertz.duration / 50
        at = np.linspace(times[0] + window, times[-1], 400)
        return (np.interp(at, times, impulse) - np.interp(at - window, times, impulse)) / window


class Press(_Case):
    """A block is pressed down slowly on a rigid cylinder, in four hundred periods of its lowest vibration.

    The error is that of the force at the end against the static problem on the same mesh. Implicit runs take 20 steps
    at the coarsest level; explicit ones follow the waves all the way.
    """

    title, clock = "slow press-down of a block", "time / time of the press-down"
    levels = (8, 16, 32)
    E, nu, density, depth, periods = 1000.0, 0.3, 1.0, 0.05, 400.0

    def __init__(self, comm):
        self.comm = comm
        self.time = self.periods * 4.0 * np.sqrt(self.density / self.E)  # of a bar of length one, held at one end

    def _parts(self, level):
        corners = [[-0.5, 0.0], [0.5, 1.0]]
        domain = mesh.create_rectangle(self.comm, corners, [level, level], mesh.CellType.quadrilateral)
        V = fem.functionspace(domain, ("Lagrange", 1, (2,)))
        foot = mesh.locate_entities_boundary(domain, 1, lambda x: np.isclose(x[1], 0.0))
        tags = mesh.meshtags(domain, 1, foot, np.full(len(foot), 1, dtype=np.int32))
        top = fem.locate_dofs_geometrical(V, lambda x: np.isclose(x[1], 1.0))
        law = di.LinearElastic(self.E, self.nu, self.density, "plane_strain")
        pair = di.ContactPair(tags, 1, di.RigidCylinder((0.0, -1.0), 1.0))
        return V, fem.dirichletbc(np.array([0.0, -self.depth]), top, V), law, pair

    def run(self, method, level):
        V, bc, law, pair = self._parts(level)
        u = fem.Function(V)
        static = di.StaticProblem(u, law, bcs=[bc], contact=[di.Lagrange(pair)])
        static.solve()
        exact = static.contact[0].force[1]
        V, bc, law, pair = self._parts(level)
        motion = di.PrescribedMotion(bc, lambda t: np.sin(0.5 * np.pi * min(t / self.time, 1.0)) ** 2)
        problem = self.problem(method, pair, fem.Function(V), law, fem.Function(V), bcs=[motion])
        dt = None if method.scheme is None else self.time * 8 / (20 * level)
        seconds, times, forces = _march(problem, self.time, dt, 1)
        last = forces[times > 0.98 * self.time].mean()
        return Result(abs(last / exact - 1.0), seconds, problem.step, times / self.time, forces / exact)


CASES = {"wave": Wave, "ball": Ball, "press": Press}
