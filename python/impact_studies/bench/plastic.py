# SPDX-License-Identifier: MIT
"""Cost of explicit steps with plasticity, against the neo-Hookean step, the usual way in DOLFINx and a user's law.

The usual way is what one writes without this package: forms of FFCx with the history in functions on quadrature
elements, and a fem.Expression per step for the new history. Processor times, in alternating rounds.
"""

import math
import time
from collections.abc import Callable
from functools import partial
from typing import Any

import basix
import basix.ufl
import numpy as np
import ufl
from dolfinx import default_scalar_type, fem
from dolfinx.fem import Function
from dolfinx.mesh import Mesh

from dolfinx_impact.assembly.ffcx_form import ffcx_form
from dolfinx_impact import materials  # type: ignore[attr-defined,unused-ignore]  # installed beside it
from dolfinx_impact.common.types import FloatArray
from dolfinx_impact.dynamics.explicit import ExplicitProblem
from dolfinx_impact.forms import inelastic, plasticity
from dolfinx_impact.inelastic import InelasticMaterial
from dolfinx_impact.materials import Material
from dolfinx_impact.plasticity import J2Plasticity, Voce
from . import explicit as bench_explicit
from .explicit import CELLS_PER_S
from .rows import Job, Row, row
from .setup import STRICT, Setup, best_time

CELL = "hexahedron P1"
E, NU, HARDENING = 1e3, 0.3, 1.0  # hardly any hardening: no waves that would unload points
YIELDING, ELASTIC = 1e-3, 1e6  # yield stresses: all points flow in every step, none does
FLOW = np.array([[0.5, 1.0, 0.3], [0.2, -0.8, 1.0], [1.0, 0.4, 0.3]])  # gradient of the velocity, trace 0 [1/T]
RATE = 0.1  # of that flow [1]
STEPS, ROUNDS = 20, 5
SHARE = 0.8  # of the first stable step that steps take [1]: it stays below the stable step while the body moves
SAME = 1e-11  # forces and histories are sums of some hundred terms, each with round-off of 1e-16 of the largest
AXES = ((0, 0), (1, 1), (0, 1), (1, 2), (0, 2))  # the components of a deviator that are kept
GOALS = {YIELDING: 0.8, ELASTIC: 0.9}
REDUCED_GOAL = 2.5  # speed of one point over that of full integration [1]
# Yield stress of all points yielding where the local equations are iterated: a step is some ten times its strain.
ITERATED_YIELDING = 0.005


class Body:
    """A unit cube of linear hexahedra in a uniform flow that keeps its volume: its strain grows everywhere.

    Args:
        n: cells per side.
        material: its material.
    """

    def __init__(self, n: int, material: Material) -> None:
        setup = Setup("hexahedron", 1, n)
        self.num_cells = setup.num_cells
        self.u = setup.u
        # Waves in the uniform strain, so that no number is zero or the same everywhere.
        self.u.interpolate(lambda x: 0.01 * FLOW @ x + 1e-5 * np.sin(3 * x + x[[1, 2, 0]]))
        self.start: FloatArray = self.u.x.array.copy()
        self.velocity = Function(setup.V)
        self.velocity.interpolate(lambda x: RATE * FLOW @ x)
        self.problem = ExplicitProblem(self.u, material, velocity=self.velocity)
        # Given steps: no deformation asks for a new stable step.
        self.dt: float = SHARE * self.problem._stepper.safe_step

    def advance(self, steps: int) -> float:
        """Take some steps.

        Args:
            steps: their number.

        Returns:
            Processor time [s].
        """
        begin = time.process_time()
        self.problem.advance(self.problem.time + steps * self.dt, dt=self.dt, progress=False)
        return time.process_time() - begin

    def seconds(self) -> float:
        """Processor time of a step alone [s].

        What an `advance` does once, energies and rotations, costs as much as some steps: it is the time of several
        steps less that of one. A stable step that is found anew costs as much as fifty. Where flow makes it due by the
        number of steps, it is found before.

        Raises:
            RuntimeError: the stable step was found anew, or steps became shorter.
        """
        problem, safe = self.problem, self.problem._cpp_object.safe_step
        while problem.step <= safe.check_step <= problem.step + STEPS + 2:
            self.advance(safe.check_step + 1 - problem.step)
        first, found = problem.step, safe.num_found
        once = self.advance(1)
        several = self.advance(1 + STEPS)
        if safe.num_found != found or problem.step != first + STEPS + 2:
            raise RuntimeError(
                f"{safe.num_found - found} stable steps were found in {problem.step - first} steps, {STEPS + 2} of "
                "which were to be timed alone: no timing counts"
            )
        return (several - once) / STEPS


def j2(
    yield_stress: float, hardening: str = "linear", finite_strain: bool = False, integration: str = materials.FULL
) -> J2Plasticity:
    """The law of the rows.

    Args:
        yield_stress: yield stress [F/L^2].
        hardening: "linear", or "Voce", with the same slope in the end.
        finite_strain: whether strains are finite.
        integration: "full" or "reduced".
    """
    law: float | Voce = HARDENING if hardening == "linear" else Voce(2 * yield_stress, 1.0, HARDENING)
    return J2Plasticity(
        E, NU, 1.0, yield_stress=yield_stress, hardening=law, finite_strain=finite_strain, integration=integration
    )


def flowing(problem: ExplicitProblem) -> float:
    """Share of the points that flow in the next step, which is taken [1].

    Args:
        problem: problem with plasticity.
    """
    field = problem.history[plasticity.PLASTIC_STRAIN]
    before = field.values.copy()
    dt = SHARE * problem._stepper.safe_step
    problem.advance(problem.time + dt, dt=dt, progress=False)
    return float(np.mean(field.values > before))


class UsualWay:
    """Explicit steps of J2 plasticity with linear hardening and mean dilatation, written for DOLFINx alone.

    Args:
        u: displacement, linear hexahedra [L].
        yield_stress: yield stress [F/L^2].
        degree: quadrature degree [1].
        velocity: initial velocity [L/T].
        mass: diagonal mass of the degrees of freedom [M].
    """

    def __init__(self, u: Function, yield_stress: float, degree: int, velocity: FloatArray, mass: FloatArray) -> None:
        V, mesh = u.function_space, u.function_space.mesh
        self.u, self.v, self.mass, self.mesh = u, velocity.copy(), mass, mesh
        dx = ufl.dx(domain=mesh, metadata={"quadrature_degree": degree})
        cell = mesh.basix_cell()
        spaces = [
            fem.functionspace(mesh, basix.ufl.quadrature_element(cell, value_shape=shape, degree=degree))
            for shape in ((), (5,))
        ]
        self.alpha, self.plastic = (Function(space) for space in spaces)
        self.theta = Function(fem.functionspace(mesh, ("DG", 0)))
        mu, kappa, Y, H = (
            fem.Constant(mesh, default_scalar_type(c))
            for c in (E / (2 * (1 + NU)), E / (3 * (1 - 2 * NU)), yield_stress, HARDENING)
        )
        p, identity = self.plastic, ufl.Identity(3)
        tensor = ufl.as_tensor([[p[0], p[2], p[4]], [p[2], p[1], p[3]], [p[4], p[3], -p[0] - p[1]]])
        trial = ufl.dev(ufl.sym(ufl.grad(u))) - tensor
        size = ufl.sqrt(1.5 * ufl.inner(trial, trial) + 1e-30)
        excess = 2 * mu * size - (Y + H * self.alpha)
        multiplier = ufl.conditional(ufl.gt(excess, 0), excess / (3 * mu + H), 0)
        step = 1.5 * multiplier / size * trial
        stress = 2 * mu * (trial - step) + kappa * self.theta * identity
        options = {"cffi_extra_compile_args": STRICT}
        q = ufl.TestFunction(self.theta.function_space)
        test = ufl.grad(ufl.TestFunction(V))
        self._dilatation = ffcx_form(ufl.tr(ufl.grad(u)) * q * dx, jit_options=options)
        self._force = ffcx_form(ufl.inner(stress, test) * dx, jit_options=options)
        self._volumes = fem.assemble_vector(ffcx_form(q * dx)).array.copy()
        new = [self.alpha + multiplier, *(p[i] + step[a] for i, a in enumerate(AXES))]
        points: FloatArray = np.asarray(basix.make_quadrature(cell, degree)[0])
        self._update = fem.Expression(ufl.as_vector(new), points, jit_options=options)
        self._cells = np.arange(mesh.topology.index_map(3).size_local, dtype=np.int32)
        self._means: FloatArray = self.theta.x.array

    def force(self) -> FloatArray:
        """Internal force at the present displacement; the history of the step is committed [F]."""
        self._means[:] = fem.assemble_vector(self._dilatation).array / self._volumes
        force: FloatArray = fem.assemble_vector(self._force).array
        values = self._update.eval(self.mesh, self._cells).reshape(-1, 6)
        self.alpha.x.array[:] = values[:, 0]
        self.plastic.x.array[:] = values[:, 1:].reshape(-1)
        return force

    def step(self, dt: float) -> None:
        """One step of the central difference method.

        Args:
            dt: time step [T].
        """
        self.v -= dt / self.mass * self.force()
        self.u.x.array[:] += dt * self.v


class _OwnResponse:
    """J2 plasticity with linear hardening as a user writes it (forms/inelastic.py: PointResponse)."""

    history: dict[str, tuple[int, ...]] = {"alpha": (), "eps_p": (5,)}
    unknown: tuple[int, ...] | None = None

    def __init__(self, material: InelasticMaterial, mesh: Mesh, yield_stress: float) -> None:
        self.G = material.constant(mesh, "shear_modulus", E / (2 * (1 + NU)))
        self.K = material.constant(mesh, "bulk_modulus", E / (3 * (1 - 2 * NU)))
        self.Y = material.constant(mesh, "own_yield_stress", yield_stress)
        self.H = material.constant(mesh, "own_hardening", HARDENING)

    def respond(self, strain: Any, history: dict[str, Any], unknown: Any = None) -> inelastic.Update:
        alpha, p = history["alpha"], history["eps_p"]
        deviator = inelastic.deviator(strain)
        d = [deviator[a] - p[i] for i, a in enumerate(AXES)]
        trial = ufl.as_tensor([[d[0], d[2], d[4]], [d[2], d[1], d[3]], [d[4], d[3], -d[0] - d[1]]])
        square = ufl.inner(trial, trial)
        size = ufl.sqrt(1.5 * square + 1e-30)
        excess = 2 * self.G * size - self.Y - self.H * alpha
        multiplier = ufl.conditional(ufl.gt(excess, 0), excess / (3 * self.G + self.H), 0)
        share = 1.5 * multiplier / size
        mean = self.K * inelastic.trace(strain)
        stress = 2 * self.G * (1 - share) * trial + mean * ufl.Identity(3)
        stored = self.G * (1 - share) ** 2 * square + mean * inelastic.trace(strain) / 2
        new = {"alpha": alpha + multiplier, "eps_p": p + share * ufl.as_vector(d)}
        return inelastic.Update(stress, new, stored, mean=mean)


class OwnJ2(InelasticMaterial):
    """A user's material of that law.

    Args:
        yield_stress: yield stress [F/L^2].
    """

    def __init__(self, yield_stress: float) -> None:
        super().__init__(E, NU, 1.0)
        self.yield_stress = yield_stress

    def response(self, mesh: Mesh) -> inelastic.PointResponse:
        return _OwnResponse(self, mesh, self.yield_stress)


def in_turn(*measures: Callable[[], float]) -> FloatArray:
    """Times of several measurements that take turns, so that the load of the machine is the same for all.

    Args:
        measures: functions that return a time [s].

    Returns:
        Times, (ROUNDS, number of functions) [s].
    """
    return np.array([[measure() for measure in measures] for _ in range(ROUNDS)])


def _against(name: str, times: FloatArray, num_cells: int) -> Row:
    """Row of a speed over that of the first of two measurements, by the median of the rounds' ratios."""
    base = float(np.median(times[:, 0]))
    ratio = float(np.median(times[:, 0] / times[:, 1]))
    speed = num_cells / base * 1e-6
    return row(name, CELL, 1, ratio * speed, CELLS_PER_S, speed)


def speed_rows(n: int = 40) -> list[Row]:
    """Measure steps with all points yielding, and with none, against the neo-Hookean step.

    Args:
        n: cells per side.

    Returns:
        Rows.

    Raises:
        RuntimeError: fewer than 99 % of the points flow where all should, or any does where none should.
    """
    elastic = Body(n, materials.NeoHookean(E, NU, 1.0, "3d"))
    rows = []
    for finite_strain in (False, True):
        for hardening in ("linear", "Voce"):
            for state, goal in GOALS.items():
                what = "all points yield" if state == YIELDING else "no point yields"
                yield_stress = ITERATED_YIELDING if (state, hardening) == (YIELDING, "Voce") else state
                body = Body(n, j2(yield_stress, hardening, finite_strain))
                check_flow(body.problem, state, "before the rounds")
                times = in_turn(elastic.seconds, body.seconds)
                check_flow(body.problem, state, "after the rounds")
                law = f"{'finite' if finite_strain else 'small'} strain, {hardening}"
                name = f"j2 step / neo_hookean, {law}, {what}, goal {goal}"
                rows.append(_against(name, times, body.num_cells))
    return rows


def reduced_rows(n: int = 40) -> list[Row]:
    """Measure steps with one point, whose hourglass modes flow, against those of full integration.

    Args:
        n: cells per side.

    Returns:
        Rows.

    Raises:
        RuntimeError: as speed_rows.
    """
    rows = []
    for finite_strain in (False, True):
        for state in GOALS:
            bodies = [
                Body(n, j2(state, "linear", finite_strain, integration))
                for integration in (materials.FULL, materials.REDUCED)
            ]
            for body in bodies:
                check_flow(body.problem, state, "before the rounds")
            times = in_turn(bodies[0].seconds, bodies[1].seconds)
            for body in bodies:
                check_flow(body.problem, state, "after the rounds")
            law = f"{'finite' if finite_strain else 'small'} strain, linear"
            what = "all points yield" if state == YIELDING else "no point yields"
            name = f"j2 reduced / full, {law}, {what}, goal {REDUCED_GOAL}"
            rows.append(_against(name, times, bodies[0].num_cells))
    return rows


def check_flow(problem: ExplicitProblem, yield_stress: float, when: str) -> None:
    """Refuse a timing in another state than the row says.

    Args:
        problem: problem with plasticity; a step is taken.
        yield_stress: YIELDING (all points shall flow) or ELASTIC (none) [F/L^2].
        when: time of the check, for the message.

    Raises:
        RuntimeError: see speed_rows.
    """
    share = flowing(problem)
    if (share < 0.99) if yield_stress == YIELDING else (share > 0.0):
        raise RuntimeError(
            f"{100 * share:.0f} % of the points flow {when} at a yield stress of {yield_stress}: the row would say "
            "something else than its name"
        )


def usual_row(n: int = 24, steps: int = 3) -> list[Row]:
    """Measure steps with all points yielding against the same law done the usual way in DOLFINx.

    Args:
        n: cells per side.
        steps: number of steps per round of the usual way.

    Returns:
        One row.

    Raises:
        RuntimeError: force or plastic strain of the two sides differ.
    """
    body = Body(n, j2(YIELDING))
    problem = body.problem
    start = Function(body.u.function_space)
    start.x.array[:] = body.start
    degree = problem.history[plasticity.PLASTIC_STRAIN].degree
    mass: FloatArray = problem.mass.array
    usual = UsualWay(start, YIELDING, degree, body.velocity.x.array, mass)
    compare("force", problem.acceleration.x.array * mass, -usual.force())
    compare("plastic strain", problem.history[plasticity.PLASTIC_STRAIN].values.reshape(-1), usual.alpha.x.array)
    dt = 0.9 * problem._stepper.safe_step

    def theirs() -> float:
        return best_time(lambda: usual.step(dt), at_least=0.0, rounds=steps)[1]

    times = in_turn(theirs, body.seconds)
    return [_against("j2 step / forms and Expression of DOLFINx, goal 5", times, body.num_cells)]


def compare(what: str, found: FloatArray, expected: FloatArray) -> None:
    """Refuse a timing of two sides that do not compute the same.

    Args:
        what: quantity.
        found: ours.
        expected: theirs, of the same shape.

    Raises:
        RuntimeError: they differ by more than round-off.
    """
    difference = float(np.max(np.abs(found - expected)) / np.max(np.abs(expected)))
    if not difference < SAME or math.isnan(difference):
        raise RuntimeError(f"{what} of the usual way differs by {difference:.1e}: no timing counts")


def own_row(n: int = 40) -> list[Row]:
    """Measure a user's law, compiled at run time, against J2Plasticity, whose kernels come with the package.

    Args:
        n: cells per side.

    Returns:
        One row.

    Raises:
        RuntimeError: the user's law was found among the package's kernels, or J2Plasticity was not.
    """
    package, own = Body(n, j2(YIELDING)), Body(n, OwnJ2(YIELDING))
    for body, packaged in ((package, True), (own, False)):
        if any((part.compiled.source == "package") != packaged for part in body.problem._bodies.internal._parts):
            raise RuntimeError(
                "the law of one's own was found in the package, or J2Plasticity was not: nothing is compared"
            )
    compare("acceleration", own.problem.acceleration.x.array, package.problem.acceleration.x.array)
    times = in_turn(package.seconds, own.seconds)
    return [_against("own law at run time / j2 of the package, goal 0.9 to 1.1", times, own.num_cells)]


def memory_rows(n: int = 40) -> list[Row]:
    """Measure the memory per cell of an explicit run with plasticity (explicit.memory_rows).

    Args:
        n: cells per side.

    Returns:
        Rows.
    """
    found = bench_explicit.run_on_ranks("history", 1, n)
    label = f"{CELL}, {found['cells']} cells"
    return [row("explicit run with j2: memory per cell, goal 1.4", label, 1, found["kB"], "kB", 1.4)]


def jobs(large: bool = False) -> list[Job]:
    """Measurements of plasticity.

    Args:
        large: take larger models.

    Returns:
        A text and a function that returns rows, for each measurement.
    """
    return [
        ("explicit step, j2", partial(speed_rows, 33 if large else 30)),
        ("explicit step, j2, one point", partial(reduced_rows, 33 if large else 30)),
        ("explicit step, j2, the usual way", usual_row),
        ("explicit step, law of one's own", own_row),
        ("explicit memory, j2", partial(memory_rows, 64 if large else 40)),
    ]
