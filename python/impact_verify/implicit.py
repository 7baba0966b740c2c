# SPDX-License-Identifier: MIT
"""Level history, implicit runs of 200 steps on both sides: state, forces and energies of every step.

Runs with contact are repeated with random variations, as explicit ones are.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any, TypeAlias, cast

from dolfinx_impact.own_forms import distorted_block
import impact_reference
import numpy as np
from dolfinx import fem
from impact_reference import NewmarkResult, NewmarkScheme

from dolfinx_impact import contact, materials
from dolfinx_impact.amplitude import PrescribedMotion
from dolfinx_impact.common.types import FloatArray, IntArray
from dolfinx_impact.dynamics.implicit.problem import NewmarkProblem
from dolfinx_impact.dynamics.run_history import ENERGIES
from dolfinx_impact.materials import _Material
from . import history, plastic_bodies
from .contact_bodies import rule, two_bodies
from .history import GAP, RandomVariation, falling
from .report import Report

STEPS = 200
TOLERANCE = 1e-9
REASON = "round-off of 200 steps, which waves and contact carry on, and what Newton's methods leave"
# Seeds and steps of the variations of runs of two bodies, by dimension.
VARIATION_SEEDS = {2: (1, 2), 3: (1,)}
VARIATION_STEPS = {2: 100, 3: 60}
PENALTY, TANGENTIAL = 20.0, 15.0  # [F/L^3]
# Gap of an active node that is left in sizes of the bodies: 1e-11, which problems leave by themselves, is 1e-8 of the
# velocity of a node without mass, (u1 - u0)/h.
VIOLATION = 1e-13


@dataclass
class Run(history.Run):
    """An implicit run. `contact` is "penalty", "lagrange" or ""; `options`, `viscosity` and `scheme` are not used.

    Args:
        parameters: beta, gamma, rho_inf or hht of the scheme; empty for the trapezoidal rule [1].
        lumping: lumping scheme of the mass; None: consistent.
        dt: time step of a run without variation; others take step_fraction / 0.8 of it [T].
        impact: what is done about the mass of contact surfaces, of NewmarkProblem.
        error: local error by which our side chooses its steps, dt at most; None: they are equal [1].
    """

    parameters: dict[str, Any] = field(default_factory=dict)
    lumping: str | None = None
    dt: float = 0.05
    impact: str = "mass_redistribution"
    error: float | None = None


def run(report: Report) -> None:
    """Add the rows of implicit runs.

    Args:
        report: report to add to.
    """
    for cell, degree, make in RUNS:
        if report.wants(cell, degree):
            for case in make(cell, degree):
                compare(report, case)
            for case in varied_runs(cell, degree, make):
                compare(report, case, VARIATION_STEPS[case.body.gdim])
    for arguments in YIELDING:
        if report.wants(arguments[0], arguments[1]):
            compare_yielding(report, *arguments)


def varied_runs(cell: str, degree: int, make: "MakeRuns", seeds: tuple[int, ...] | None = None) -> Iterator[Run]:
    """Random variations of runs of two bodies.

    Args:
        cell: cell.
        degree: degree of the displacement, 1 or 2.
        make: function of cell, degree and variation that makes runs.
        seeds: seeds of the variations; None takes those of the level.

    Yields:
        Varied runs.
    """
    dim = 2 if cell in ("triangle", "quadrilateral") else 3
    for seed in VARIATION_SEEDS[dim] if seeds is None else seeds:
        variation = RandomVariation(seed)
        for case in make(cell, degree, variation):
            if case.contact and not case.body.rigid:
                yield cast(Run, variation.apply(case))


# cell, degree, hypothesis, finite strain, mean dilatation, law; see plastic_bodies
YIELDING: tuple[tuple[str, int, str, bool, bool, str], ...] = (
    ("quadrilateral", 1, "plane_strain", False, True, "prager"),
    ("quadrilateral", 1, "axisymmetric", True, True, "linear"),
    ("triangle", 2, "plane_stress", False, False, "table"),
    ("hexahedron", 1, "3d", True, True, "voce"),
)


def compare_yielding(report: Report, *arguments: Any, steps: int = STEPS) -> None:
    """Add the rows of a block that flies away from its clamped end, fast enough to yield.

    Args:
        report: report to add to.
        arguments: of plastic_bodies.PlasticBodies.
        steps: number of steps.
    """
    both = plastic_bodies.PlasticBodies(*arguments)
    damping = (0.0, 0.0) if arguments[3] else (0.05, 0.02)  # in small strain
    body, dim = both.body, both.body.gdim
    x = body.V.tabulate_dof_coordinates()[:, :dim]
    speed = 4.0 * plastic_bodies.Y / np.sqrt(plastic_bodies.E * 1.5)
    v0 = np.stack([speed * x[:, -1] * (1.0 if a == dim - 1 else 0.3 * np.sin(3 * x[:, 0])) for a in range(dim)], axis=1)
    nodes = np.flatnonzero(np.isclose(x[:, -1], 0.0)).astype(np.int32)
    v0[nodes] = 0.0
    v = fem.Function(body.V)
    v.x.array[:] = v0.ravel()
    clamp = fem.dirichletbc(np.zeros(dim), nodes, body.V)
    problem = NewmarkProblem(
        both.u, both.steel, velocity=v, bcs=[clamp], rho_inf=0.8, damping=materials.Rayleigh(*damping)
    )
    states = advance(problem, 0.1, steps)
    start: FloatArray = np.empty(len(body.order))
    start[body.order] = v0.ravel()
    fixed = (dim * nodes[:, None] + np.arange(dim)).ravel()
    other = both.other.run_newmark(
        np.diff(states.time), scheme=NewmarkScheme.chung_hulbert(0.8), v0=start, fixed_dofs=body.order[fixed],
        damping=damping,
    )  # fmt: skip
    dissipated = 100 * other.energies["plastic"][-1] / other.energies["kinetic"][0]
    name = f"yielding block, {dissipated:.0f} % dissipated"
    add_rows(report, f"implicit.{both.form}", both.element, name, steps, (problem, states), other, body.order)


# --- runs ------------------------------------------------------------------------------------------------------------


def without_contact(cell: str, degree: int, variation: RandomVariation | None = None) -> Iterator[Run]:
    """A clamped body: schemes, masses, damping, loads, a support that moves; one hinged at a corner, which swings.

    Args:
        cell: cell.
        degree: degree of the displacement, 1 or 2.
        variation: not used.

    Yields:
        Runs.
    """
    plane = cell in ("triangle", "quadrilateral")
    hypothesis = "plane_strain" if plane else "3d"
    domain = distorted_block.block(cell, 4 if plane else 2)
    tags = history._face_tags(domain, 0.0)
    body = {law: history._body(domain, tags, degree, hypothesis, law) for law in ("linear_elastic", "neo_hookean")}
    linear, large = body["linear_elastic"], body["neo_hookean"]
    x = linear.V.tabulate_dof_coordinates()
    low = np.flatnonzero(np.isclose(x[:, linear.gdim - 1], 0.0))
    corner = np.flatnonzero(np.all(np.isclose(x, 0.0), axis=1))

    def shaken(x: FloatArray) -> FloatArray:
        v = np.zeros_like(x)
        v[:, 0] = 0.05 * x[:, -1]
        v[:, -1] = -0.1 * x[:, -1] ** 2
        return v

    def swinging(x: FloatArray) -> FloatArray:
        v = np.zeros_like(x)
        v[:, 0], v[:, -1] = 0.3 * x[:, -1], -0.3 * x[:, 0]
        return v

    down = np.zeros(linear.gdim)
    down[-1] = -0.1
    gravity = (down, lambda t: 1.0 - np.cos(2 * t))
    clamped: dict[str, Any] = {"fixed_nodes": low}
    yield Run("shaken block", linear, shaken, **clamped)
    yield Run(
        "damped block under a load, generalised-alpha", linear, shaken, **clamped, damping=(0.1, 0.004),
        gravity=gravity, parameters={"rho_inf": 0.6},
    )  # fmt: skip
    yield from (
        Run(**{**vars(case), "name": f"{case.name}, HHT" if k else case.name}, parameters={"hht": -0.1} if k else {})
        for k, case in enumerate(history.founded(domain, degree, shaken, gravity))
    )
    yield Run("hinged block that swings, neo-Hookean", large, swinging, fixed_nodes=corner, parameters={"rho_inf": 0.8})
    if not plane:
        return
    yield Run(
        "block under a load, steps by their error", large, shaken, **clamped, gravity=gravity,
        parameters={"rho_inf": 0.7}, dt=0.06, error=1e-4,
    )  # fmt: skip
    yield Run("shaken block, HHT, lumped", linear, shaken, **clamped, lumping="auto", parameters={"hht": -0.1})
    yield Run(
        "support that moves, first order", linear, shaken, **clamped, motion=lambda t: 0.02 * np.sin(3 * t),
        parameters={"beta": 0.3025, "gamma": 0.6},
    )  # fmt: skip
    yield Run(
        "damped block under a load, neo-Hookean, lumped", large, shaken, **clamped, damping=(0.1, 0.004),
        gravity=gravity, lumping="auto",
    )  # fmt: skip


def bars(cell: str, degree: int, variation: RandomVariation = RandomVariation()) -> Iterator[Run]:
    """Two bars that meet end to end.

    Args:
        cell: cell.
        degree: degree of the displacement, 1 or 2.
        variation: random variation of the runs.

    Yields:
        Runs.
    """
    for kind, impact in (("penalty", "mass_redistribution"), ("penalty", "none"), ("lagrange", "mass_redistribution")):
        domain, tags = two_bodies(cell, (2, 8), (2, 5), start=(0.04,), length=(0.92,))  # no edges coincide
        history._open_gap(domain, 0.003)
        variation.rotate_upper_body(domain)
        body = history._body(domain, tags, degree, "plane_strain")
        name = f"two bars, {kind}{'' if impact != 'none' else ', masses kept'}"
        yield Run(name, body, falling(0.02), kind, parameters={"rho_inf": 0.8}, impact=impact)


def disc(cell: str, degree: int, variation: RandomVariation = RandomVariation()) -> Iterator[Run]:
    """A disc that falls on a block at an angle, with friction: it starts to roll.

    Args:
        cell: cell.
        degree: degree of the displacement, 1 or 2.
        variation: random variation of the runs.

    Yields:
        Runs.
    """
    for kind, lumping in (("penalty", None), ("lagrange", None), ("lagrange", "auto")):
        domain, tags = two_bodies(cell, (9, 4), (6, 6), start=(0.2,), length=(0.5,))
        x, upper = domain.geometry.x, history._open_gap(domain, 0.0)
        a, b = (x[upper, 0] - 0.45) / 0.25, (x[upper, 1] - 1.25) / 0.25
        x[upper, 0] = 0.45 + 0.25 * a * np.sqrt(1 - b**2 / 2)
        x[upper, 1] = 1.252 + 0.25 * b * np.sqrt(1 - a**2 / 2)
        variation.rotate_upper_body(domain)
        body = history._body(domain, tags, degree, "plane_strain", friction=0.3)
        low = np.flatnonzero(np.isclose(body.V.tabulate_dof_coordinates()[:, 1], 0.0))
        name = f"disc on a block, {kind}{', lumped' if lumping else ''}"
        yield Run(name, body, falling(0.03, 0.02), kind, fixed_nodes=low, lumping=lumping, dt=0.04,
                  parameters={"rho_inf": 0.8})  # fmt: skip


def blocks(cell: str, degree: int, variation: RandomVariation = RandomVariation()) -> Iterator[Run]:
    """A block thrown on another one in space, with friction.

    Args:
        cell: cell.
        degree: degree of the displacement, 1 or 2.
        variation: random variation of the runs.

    Yields:
        Runs.
    """
    methods = (("penalty", "neo_hookean"), ("lagrange", "linear_elastic"))
    for kind, law in methods if cell == "hexahedron" else methods[:1]:
        domain, tags = two_bodies(cell, (3, 2, 2), (2, 2, 2), start=(0.17, 0.13))
        x, upper = domain.geometry.x, history._open_gap(domain, GAP)
        x[upper, 2] += 0.1 * ((x[upper, :2] - 0.5) ** 2).sum(axis=1)  # round below
        variation.rotate_upper_body(domain)
        body = history._body(domain, tags, degree, "3d", law, friction=0.2)
        name = f"block on a block, {law.replace('_', '-')}, {kind}"
        yield Run(name, body, falling(0.05, 0.03), kind, parameters={"rho_inf": 0.7})


def rigid(cell: str, degree: int, variation: RandomVariation | None = None) -> Iterator[Run]:
    """A body of revolution thrown on a rigid plane, and a block hit by a moving rigid cylinder, with friction.

    Args:
        cell: cell.
        degree: degree of the displacement, 1 or 2.
        variation: not used.

    Yields:
        Runs.
    """
    domain = distorted_block.block(cell, 5)
    domain.geometry.x[:, 0] += 0.2
    for kind in ("penalty", "lagrange"):
        point, normal = np.array([0.0, -0.01]), np.array([0.0, 1.0])
        plane = contact.RigidPlane(point, normal), impact_reference.RigidPlane(point, normal)
        body = history._body(domain, history._face_tags(domain, 0.0), degree, "axisymmetric", rigid=plane)
        name = f"ring on a rigid plane, {kind}"
        yield Run(name, body, lambda x: np.tile([0.0, -0.05], (len(x), 1)), kind, parameters={"hht": -0.2})
    domain = distorted_block.block(cell, 6)
    for kind, friction in (("penalty", 0.3), ("lagrange", 0.3), ("lagrange", 0.0)):
        center = np.array([0.47, 1.805])
        cylinder = contact.RigidCylinder(center, 0.8), impact_reference.RigidCylinder(center, 0.8)
        tags = history._face_tags(domain, 1.0)
        body = history._body(domain, tags, degree, "plane_strain", friction=friction, rigid=cylinder)
        low = np.flatnonzero(np.isclose(body.V.tabulate_dof_coordinates()[:, 1], 0.0))
        yield Run(
            f"block under a rigid cylinder that moves, {kind}{'' if friction else ', smooth'}", body,
            lambda x: np.zeros_like(x), kind, fixed_nodes=low, parameters={"rho_inf": 0.5},
            obstacle=lambda t: np.array([0.01 * t, -0.03 * np.sin(t / 4)]),
        )  # fmt: skip


MakeRuns: TypeAlias = Callable[..., Iterator[Run]]  # of cell, degree and variation
RUNS: tuple[tuple[str, int, MakeRuns], ...] = (
    ("quadrilateral", 1, without_contact),
    ("triangle", 2, without_contact),
    ("hexahedron", 1, without_contact),
    ("tetrahedron", 2, without_contact),
    ("quadrilateral", 1, bars),
    ("triangle", 1, bars),
    ("quadrilateral", 2, bars),
    ("quadrilateral", 1, disc),
    ("hexahedron", 1, blocks),
    ("tetrahedron", 1, blocks),
    ("quadrilateral", 1, rigid),
)


# --- both sides ------------------------------------------------------------------------------------------------------


@dataclass
class States:
    """States of our side at all time levels."""

    time: FloatArray  # (num_levels) [T]
    u: FloatArray  # (num_levels, num_dofs) [L]
    v: FloatArray  # (num_levels, num_dofs) [L/T]
    a: FloatArray  # (num_levels, num_dofs) [L/T^2]


def advance(problem: NewmarkProblem, dt: float, steps: int, error: float | None = None) -> States:
    """Advance a problem and keep its states.

    Args:
        problem: problem at its start.
        dt: time step [T].
        steps: number of steps, if all are equal.
        error: local error by which steps are chosen, dt at most; None: all are equal [1].

    Returns:
        States of all time levels.
    """
    rows: list[tuple[Any, ...]] = []
    problem.advance(
        steps * dt, dt=dt, tolerance=error, progress=False, rtol=1e-13, max_iterations=40,
        callback=lambda p: rows.append((p.time, *(f.x.array.copy() for f in (p.u, p.velocity, p.acceleration)))),
    )  # fmt: skip
    return States(*(np.array(values) for values in zip(*rows)))


def ours(case: Run, steps: int) -> tuple[NewmarkProblem, States]:
    """Make a run on our side.

    Args:
        case: run.
        steps: number of steps.

    Returns:
        Problem and states.
    """
    body = case.body
    V = body.V
    u, v = fem.Function(V, name="u"), fem.Function(V)
    v.x.array[:] = case.velocity(V.tabulate_dof_coordinates()[:, : body.gdim]).ravel()
    bcs: list[fem.DirichletBC | PrescribedMotion] = []
    if len(case.fixed_nodes):
        nodes = np.asarray(case.fixed_nodes, dtype=np.int32)
        if case.motion is None:
            bcs = [fem.dirichletbc(np.zeros(body.gdim), nodes, V)]
        else:
            bcs = [PrescribedMotion(fem.dirichletbc(np.eye(body.gdim)[-1], nodes, V), case.motion)]
    contacts: list[contact.Penalty | contact.Lagrange] = []
    if case.contact:
        if body.rigid:
            motion = case.obstacle
            body.rigid[0].motion = None if motion is None else lambda t: np.pad(motion(t), (0, 3 - body.gdim))
        pair = body.pair()
        if case.contact == "penalty":
            contacts = [contact.Penalty(pair, PENALTY, TANGENTIAL, quadrature_degree=2 * body.degree + 2)]
        else:
            contacts = [contact.Lagrange(pair, quadrature_degree=3 * body.degree + 4)]
    problem = NewmarkProblem(
        u, cast(_Material, body.material), velocity=v, bcs=bcs, loads=history.loads_of(case), contact=contacts,
        lumping=case.lumping, damping=materials.Rayleigh(*case.damping) if any(case.damping) else None,
        impact=case.impact, options={"contact_tolerance": VIOLATION} if contacts else None, **case.parameters,
    )  # fmt: skip
    return problem, advance(problem, time_step(case), steps, case.error)


def time_step(case: Run) -> float:
    """Time step of a run.

    Args:
        case: run.

    Returns:
        Step [T].
    """
    return case.dt * case.step_fraction / 0.8


def their_scheme(parameters: dict[str, Any]) -> NewmarkScheme:
    """Scheme of the other side.

    Args:
        parameters: of NewmarkProblem.

    Returns:
        Scheme with these parameters.
    """
    if "rho_inf" in parameters:
        return NewmarkScheme.chung_hulbert(parameters["rho_inf"])
    if "hht" in parameters:
        return NewmarkScheme.hht(parameters["hht"])
    return NewmarkScheme(**parameters)


def motion_tables(motion: Callable[[float], float], time: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """A motion and its derivatives at time levels, by central differences over a hundredth of a step to either side; at
    the start a hundredth of the first step later, because there is no time before it.

    Args:
        motion: displacement as a function of time [L].
        time: time levels, shape (num_levels) [T].

    Returns:
        Displacements [L], velocities [L/T] and accelerations [L/T^2], shape (num_levels, 1) each.
    """
    steps = np.diff(time, prepend=time[0] - (time[1] - time[0]))
    rows = []
    for t, h in zip(time, steps):
        d = float(h) / 100
        middle = max(float(t), d)
        before, now, after = motion(middle - d), motion(middle), motion(middle + d)
        rows.append((motion(float(t)), (after - before) / (2 * d), (after - 2 * now + before) / d**2))
    u, v, a = (np.array(column)[:, None] for column in zip(*rows))
    return u, v, a


def theirs(case: Run, time: FloatArray) -> NewmarkResult:
    """Make a run on the other side.

    Args:
        case: run.
        time: time levels of our side, shape (num_levels) [T].

    Returns:
        States, energies and contact history.
    """
    body = case.body
    v0 = np.empty(len(body.order))
    v0[body.order] = case.velocity(body.V.tabulate_dof_coordinates()[:, : body.gdim]).ravel()
    nodes = np.asarray(case.fixed_nodes, dtype=np.int64)
    fixed: IntArray = (nodes[:, None] * body.gdim + np.arange(body.gdim)).ravel()
    body.prescribed = fixed
    motion = None
    if case.motion is not None:
        along_last_axis = (fixed % body.gdim == body.gdim - 1).astype(float)
        u, v, a = (table * along_last_axis for table in motion_tables(case.motion, time))
        motion = u, v, a
    loads = None
    if case.gravity is not None:
        loads = [(body.model.body_force(np.asarray(case.gravity[0])), case.gravity[1])]
    touching = None
    if case.contact:
        facet = rule(body.facet, 2 * body.degree + 2)
        if case.contact == "penalty":
            touching = impact_reference.ImplicitContact(body.theirs(facet), PENALTY, TANGENTIAL)
        else:
            points = facet if body.rigid else rule(body.segment, 3 * body.degree + 4)
            touching = impact_reference.ImplicitContact(body.theirs(points))
        if body.rigid:
            touching.motion = case.obstacle
    return body.model.run_newmark(
        np.diff(time), scheme=their_scheme(case.parameters), v0=v0, fixed_dofs=body.order[fixed], motion=motion,
        loads=loads, damping=case.damping, lumping=case.lumping or "consistent", contact=touching,
        redistribute=case.impact != "none",
    )  # fmt: skip


def compare(report: Report, case: Run, steps: int = STEPS) -> None:
    """Add the rows of one run: displacements, velocities, accelerations, contact forces and energies of all levels.

    Args:
        report: report to add to.
        case: run.
        steps: number of steps.
    """
    problem, states = ours(case, steps)
    other = theirs(case, states.time)
    element = (case.body.cell, case.body.degree, case.body.geometry_degree, case.body.hypothesis)
    force = None
    if case.contact and other.contact is not None:
        force = problem.force_history[0], other.contact.total
    form = f"implicit.{case.contact or 'free'}"
    expected = steps if case.error is None else len(states.time) - 1
    add_rows(report, form, element, case.name, expected, (problem, states), other, case.body.order, force)


def add_rows(
    report: Report,
    form: str,
    element: tuple[str, int, int, str],
    name: str,
    steps: int,
    ours: tuple[NewmarkProblem, States],
    other: NewmarkResult,
    order: IntArray,
    force: tuple[FloatArray, FloatArray] | None = None,
) -> None:
    """Add the rows of one run.

    Args:
        report: report to add to.
        form: form of the rows.
        element: cell, degree, degree of the geometry and hypothesis.
        name: name of the run.
        steps: number of steps that were asked for.
        ours: problem and states of our side.
        other: result of the other side.
        order: number of the other side's degree of freedom of each of ours.
        force: force on the slave at all levels on our side and the other's, shape (num_levels, gdim) each [F].
    """
    problem, states = ours
    pairs: dict[str, tuple[FloatArray, FloatArray]] = {
        "displacement": (states.u, other.u[:, order]),
        "velocity": (states.v, other.v[:, order]),
        "acceleration": (states.a, other.a[:, order]),
    }
    for k, energy in enumerate(ENERGIES):
        values = problem.energy_history[:, 1 + k]
        their_values = other.energies.get(energy, np.zeros(len(other.time)))
        if np.any(values) or np.any(their_values):
            pairs[f"{energy} energy"] = values, their_values
    if force is not None:
        pairs["contact force"] = force
    size = max(float(np.abs(other.energies[e]).max()) for e in ("kinetic", "internal"))
    for what, (a, b) in pairs.items():
        scale = size if what.endswith("energy") else float(np.abs(b).max())
        difference, note = _difference(np.asarray(a), np.asarray(b), scale)
        if len(states.time) != steps + 1:
            difference, note = np.inf, f"the UFL side took {len(states.time) - 1} steps instead of {steps}"
        report.add("history", form, *element, difference, TOLERANCE, REASON, f"{what} of the {name}", note)


def _difference(a: FloatArray, b: FloatArray, scale: float) -> tuple[float, str]:
    """Largest difference of two histories over a scale, and where it is."""
    if a.shape != b.shape:
        return np.inf, f"UFL side {a.shape} values, hand-written side {b.shape}"
    if not scale > 0.0:
        return np.inf, "nothing happens on the hand-written side"
    error = np.where(np.isnan(a - b), np.inf, np.abs(a - b))
    k = np.unravel_index(np.argmax(error), error.shape)
    return float(error[k]) / scale, f"step {int(k[0])}: UFL {a[k]:.15g}, hand-written {b[k]:.15g}"
