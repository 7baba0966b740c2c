# SPDX-License-Identifier: MIT
"""Level rolling: matrices of the flow, frequencies, and steady states with and without friction, on both sides."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, cast

import dolfinx.fem.petsc as petsc
import numpy as np
import ufl
from dolfinx import fem
from impact_reference import RollingSolution

from dolfinx_impact.assembly.ffcx_form import ffcx_form
from dolfinx_impact.common.types import FloatArray, IntArray
from dolfinx_impact.rolling.rolling_problem import RollingProblem
from . import differences
from .report import Report
from .rolling_bodies import OMEGA, RollingCase

MATRIX_TOLERANCE = 1e-12
MATRIX_REASON = "round-off"
FREQUENCY_TOLERANCE = 1e-9
FREQUENCY_REASON = "residuals of the eigensolvers"
TOLERANCE = 1e-9
REASON = "round-off times condition of the stiffness matrix"
PLANE = ((-1.5e-3, 0.0), (1e-3, 0.0), (8e-3, 0.0), (0.2, 0.0))  # longitudinal and lateral creepage of the stages
SPACE = ((2e-3, 3e-3), (-4e-3, 1e-3), (0.1, 0.2))
COUNT = 6  # frequencies that are compared


def free_bodies() -> Iterator[RollingCase]:
    """Wheels with a rail below, and no contact: two kinds of flow in one mesh.

    Yields:
        Cases.
    """
    for cell, hypothesis in (("quadrilateral", "plane_strain"), ("triangle", "plane_stress")):
        yield RollingCase("wheel and rail", cell, hypothesis, 8, rail=(4, 3))
    for cell in ("hexahedron", "tetrahedron"):
        yield RollingCase("wheel and rail", cell, "3d", 5, 2, (3, 2, 2))


def cases(friction: float) -> Iterator[RollingCase]:
    """Wheels in contact. With friction each has stages of braking, partial slip and full slip.

    Args:
        friction: Coulomb's friction coefficient; 0 for one stage without friction [1].

    Yields:
        Cases.
    """
    plane = PLANE if friction else ((0.0, 0.0),)
    for cell, hypothesis, law in (
        ("quadrilateral", "plane_strain", "linear_elastic"),
        ("triangle", "plane_stress", "linear_elastic"),
        ("quadrilateral", "plane_strain", "neo_hookean"),
    ):
        name = f"{law.replace('_', '-')} cylinder on a rigid plane"
        yield RollingCase(name, cell, hypothesis, 20, friction=friction, creeps=plane, law=law)
    for cell in ("quadrilateral", "triangle"):
        yield RollingCase("wheel on a rail", cell, "plane_strain", 20, 0, (23, 6), friction, plane, 0.02)
    space = SPACE if friction else ((0.0, 0.0),)
    for cell in ("hexahedron", "tetrahedron"):
        yield RollingCase("short cylinder on a rigid plane", cell, "3d", 12, 2, (), friction, space, 0.03)
    yield RollingCase("wheel on a rail", "hexahedron", "3d", 12, 2, (7, 2, 2), friction, space[:1], 0.04)


def free_rolling() -> Iterator[RollingCase]:
    """Wheels whose spin follows from the torque: none, as in free rolling.

    Yields:
        Cases.
    """
    for cell in ("quadrilateral", "triangle"):
        yield RollingCase("cylinder on a rigid plane", cell, "plane_strain", 20, friction=0.3)
    yield RollingCase("wheel on a rail", "quadrilateral", "plane_strain", 20, 0, (23, 6), 0.3, depth=0.02)
    yield RollingCase("short cylinder on a rigid plane", "hexahedron", "3d", 12, 2, (), 0.3, ((0.0, 2e-3),), 0.03)


def run(report: Report, progress: bool = True) -> None:
    """Add the rows of this level.

    Args:
        report: report to add to.
        progress: not used; all levels share these arguments.
    """
    for case in free_bodies():
        if report.wants(case.cell, 1):
            compare_matrices(report, case)
            compare_frequencies(report, case)
    for friction in (0.0, 0.3):
        for case in cases(friction):
            if report.wants(case.cell, 1):
                compare_solutions(report, case)
    for case in free_rolling():
        if report.wants(case.cell, 1):
            compare_free_rolling(report, case)


def _add(
    report: Report, case: RollingCase, form: str, name: str, difference: float, limit: tuple[float, str], note: str
) -> None:
    element = (case.cell, 1, 1, case.hypothesis)
    report.add("rolling", f"rolling.{form}", *element, difference, *limit, f"{name} of the {case.name}", note)


def compare_matrices(report: Report, case: RollingCase) -> None:
    """Add the rows of K - W, G, M and the load, on the whole mesh.

    Args:
        report: report to add to.
        case: bodies.
    """
    body, model = case.body, case.theirs()
    problem, _ = case.ours(with_contact=False)
    flow, v, du = problem._flow, ufl.TestFunction(body.V), ufl.TrialFunction(body.V)
    flow.update()
    body.u.x.array[:] = 0.0
    inertia = flow.form(body.u, v, body.material)
    G, W, load = model.matrices()
    minus = body.matrix_to_ours(body.model.stiffness()) - body.matrix_to_ours(W)
    pairs: dict[str, tuple[Any, Any]] = {
        "K - W": (differences.petsc_to_scipy(problem._equilibrium.tangent.assemble()), minus),
        "W": (_matrix(ufl.derivative(inertia, body.u, du)), body.matrix_to_ours(W)),
        "G": (_matrix(flow.gyroscopic(body.u, du, v)), body.matrix_to_ours(G)),
        "M": (_matrix(flow.mass(body.u, du, v)), body.matrix_to_ours(body.model.mass())),
        "load": (fem.assemble_vector(ffcx_form(inertia)).array, body.to_ours(load)),
    }
    for what, (a, b) in pairs.items():
        difference, note = differences.largest_difference(body, a, b)
        _add(report, case, "matrices", what, difference, (MATRIX_TOLERANCE, MATRIX_REASON), note)


def _matrix(form: ufl.Form) -> Any:
    matrix = petsc.assemble_matrix(ffcx_form(form))
    matrix.assemble()
    return differences.petsc_to_scipy(matrix)


def compare_frequencies(report: Report, case: RollingCase) -> None:
    """Add the rows of the lowest frequencies, with their signs, about the state without contact.

    Args:
        report: report to add to.
        case: bodies.
    """
    problem, _ = case.ours(with_contact=False)
    problem.solve(rtol=1e-13)
    ours = problem.frequencies(COUNT, tolerance=1e-13)
    _, dofs, _ = case.supports()
    theirs = case.theirs().frequencies(COUNT, case.body.order[dofs], case.body.to_theirs(case.body.u.x.array))
    error = np.abs(ours / theirs - 1.0)
    k = int(np.argmax(np.where(np.isnan(error), np.inf, error)))
    note = f"frequency {k + 1}: UFL {ours[k]:.15g}, hand-written {theirs[k]:.15g}"
    limit = (FREQUENCY_TOLERANCE, FREQUENCY_REASON)
    _add(report, case, "frequencies", f"lowest {COUNT} frequencies", float(error[k]), limit, note)


def compare_solutions(report: Report, case: RollingCase) -> None:
    """Add the rows of all stages of a case: displacements, multipliers, gaps, forces, torque; with friction status,
    slip velocities and power.

    Args:
        report: report to add to.
        case: bodies.
    """
    problem, motions = case.ours()
    _, dofs, values = case.supports()
    body, theirs_contact = case.body, case.their_contact()
    found: RollingSolution | None = None
    for stage in range(len(case.creeps)):
        case.set_speed(stage, motions)
        _solve(problem)
        found = case.theirs(stage).solve(
            body.order[dofs], values, contact=theirs_contact, master_velocity=case.speed(stage), start=found
        )
        name = f"{case.name}, stage {stage + 1}" if len(case.creeps) > 1 else case.name
        _rows(report, case, "friction" if case.friction else "frictionless", name, problem, found)


def compare_free_rolling(report: Report, case: RollingCase, torque: float = 0.0) -> None:
    """Add the rows of a wheel with a given torque, whose angular velocity is unknown.

    Args:
        report: report to add to.
        case: bodies, with one stage.
        torque: driving torque [F L].
    """
    problem, motions = case.ours()
    _, dofs, values = case.supports()
    case.set_speed(0, motions)
    _solve(problem)
    _solve(problem, torque)
    model = case.theirs()
    found = model.solve_torque(
        torque, case.body.order[dofs], values=values, contact=case.their_contact(), master_velocity=case.speed(0)
    )  # fmt: skip
    _rows(report, case, "free_rolling", case.name, problem, found)
    difference = abs(problem.omega / found.omega - 1.0)
    note = f"UFL {problem.omega:.15g}, hand-written {found.omega:.15g}"
    _add(report, case, "free_rolling", "omega", difference, (TOLERANCE, REASON), note)


def _solve(problem: RollingProblem, torque: float | None = None) -> None:
    """Solve our side to what the rows need."""
    problem.solve(rtol=1e-13, max_iterations=40, cut_backs=1, torque=torque)


def _rows(
    report: Report, case: RollingCase, form: str, name: str, problem: RollingProblem, theirs: RollingSolution
) -> None:
    """Add the rows of one steady state."""
    body, ours = case.body, cast(Any, problem.contact[0])

    def at(x: FloatArray | IntArray) -> Any:
        return body.nodal_to_ours(x)[ours.nodes]

    closed, gap = at(theirs.status) > 0, at(theirs.gap)
    near = np.isfinite(gap) & np.isfinite(ours.gap)
    force = float(np.abs(theirs.contact_force).sum()) / 2
    # Values, and what their difference is relative to; None for the largest entry.
    pairs: dict[str, tuple[Any, Any, float | None]] = {
        "u": (body.u.x.array, body.to_ours(theirs.u), None),
        "multipliers": (ours.traction, at(theirs.multipliers), None),
        "gap": (ours.gap[near], gap[near], case.depth),
        "contact force": (ours.contact_forces(), body.to_ours(theirs.contact_force), None),
        "torque": ([problem.torque], [theirs.torque], force),
    }
    if case.friction:
        pairs["status"] = ours.status, at(theirs.status), None
        pairs["slip velocity"] = ours.slip_velocity[closed], at(theirs.slip_velocity)[closed], OMEGA
        pairs["friction power"] = [ours.friction_power], [theirs.friction_power], OMEGA * force
    element = (case.cell, 1, 1, case.hypothesis)
    for what, (a, b, scale) in pairs.items():
        difference, note = _difference(np.asarray(a, dtype=float), np.asarray(b, dtype=float), scale)
        report.add(
            "rolling", f"rolling.{form}", *element, difference, TOLERANCE, REASON, f"{what} of the {name}", note
        )  # fmt: skip


def _difference(a: FloatArray, b: FloatArray, scale: float | None) -> tuple[float, str]:
    """Largest difference over the largest entry, or over a scale, and where it is."""
    if a.shape != b.shape:
        return np.inf, f"UFL side {a.shape} values, hand-written side {b.shape}"
    size = float(np.max(np.abs(b), initial=0.0)) if scale is None else scale
    if not size > 0.0:
        return np.inf, "nothing happens on the hand-written side"
    error = np.where(np.isnan(a - b), np.inf, np.abs(a - b))
    k = np.unravel_index(np.argmax(error), error.shape)
    return float(error[k]) / size, f"entry {[int(i) for i in k]}: UFL {a[k]:.15g}, hand-written {b[k]:.15g}"
