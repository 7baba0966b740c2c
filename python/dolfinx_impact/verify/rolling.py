# SPDX-License-Identifier: MIT
"""Level rolling: matrices of the flow, frequencies, and steady states with and without friction, on both sides."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any
from unittest.mock import patch

import dolfinx.fem.petsc as petsc
import impact_reference
import numpy as np
import ufl
from dolfinx import fem

from ..common.types import FloatArray, IntArray
from ..rolling import frequencies as eigensolver
from ..rolling import newton
from . import bodies
from .report import Report
from .rolling_bodies import HUB, OMEGA, RollingCase

MATRIX_TOLERANCE = 1e-12
MATRIX_REASON = "round-off"
FREQUENCY_TOLERANCE = 1e-9
FREQUENCY_REASON = "residuals of the eigensolvers"
TOLERANCE = 1e-9
REASON = "round-off times condition of the stiffness matrix"
VIOLATION = 1e-12  # at which our side stops, of contact and friction; of tractions it is 1e-10, below what rows allow
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
    plane = ((-1.5e-3, 0.0), (1e-3, 0.0), (8e-3, 0.0), (0.2, 0.0)) if friction else ((0.0, 0.0),)
    for cell, hypothesis, law in (
        ("quadrilateral", "plane_strain", "linear_elastic"),
        ("triangle", "plane_stress", "linear_elastic"),
        ("quadrilateral", "plane_strain", "neo_hookean"),
    ):
        name = f"{law.replace('_', '-')} cylinder on a rigid plane"
        yield RollingCase(name, cell, hypothesis, 20, friction=friction, creeps=plane, law=law)
    for cell in ("quadrilateral", "triangle"):
        yield RollingCase("wheel on a rail", cell, "plane_strain", 20, 0, (23, 6), friction, plane, 0.02)
    space = ((2e-3, 3e-3), (-4e-3, 1e-3), (0.1, 0.2)) if friction else ((0.0, 0.0),)
    for cell in ("hexahedron", "tetrahedron"):
        yield RollingCase("short cylinder on a rigid plane", cell, "3d", 12, 2, (), friction, space, 0.03)


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
        "K - W": (bodies.petsc_to_scipy(problem._equilibrium.tangent.assemble()), minus),
        "W": (_matrix(ufl.derivative(inertia, body.u, du)), body.matrix_to_ours(W)),
        "G": (_matrix(flow.gyroscopic(body.u, du, v)), body.matrix_to_ours(G)),
        "M": (_matrix(flow.mass(body.u, du, v)), body.matrix_to_ours(body.model.mass())),
        "load": (fem.assemble_vector(fem.form(inertia)).array, body.to_ours(load)),
    }
    for what, (a, b) in pairs.items():
        difference, note = bodies.largest_difference(body, a, b)
        _add(report, case, "matrices", what, difference, (MATRIX_TOLERANCE, MATRIX_REASON), note)


def _matrix(form: ufl.Form) -> Any:
    matrix = petsc.assemble_matrix(fem.form(form))
    matrix.assemble()
    return bodies.petsc_to_scipy(matrix)


def compare_frequencies(report: Report, case: RollingCase) -> None:
    """Add the rows of the lowest frequencies, with their signs, about the state without contact.

    Args:
        report: report to add to.
        case: bodies.
    """
    problem, _ = case.ours(with_contact=False)
    problem.solve(rtol=1e-13)
    with patch.object(eigensolver, "TOLERANCE", 1e-13):
        ours = problem.frequencies(COUNT)
    _, dofs, _ = case.supports()
    theirs = case.theirs().frequencies(COUNT, case.body.order[dofs], case.body.to_theirs(case.body.u.x.array))
    error = np.abs(ours / theirs - 1.0)
    k = int(np.argmax(np.where(np.isnan(error), np.inf, error)))
    note = f"frequency {k + 1}: UFL {ours[k]:.15g}, hand-written {theirs[k]:.15g}"
    limit = (FREQUENCY_TOLERANCE, FREQUENCY_REASON)
    _add(report, case, "frequencies", f"lowest {COUNT} frequencies", float(error[k]), limit, note)


def compare_solutions(report: Report, case: RollingCase) -> None:
    """Add the rows of all stages of a case: displacements, multipliers, gaps, forces; with friction slip velocities,
    status, torque and power.

    Args:
        report: report to add to.
        case: bodies.
    """
    problem, motions = case.ours()
    _, dofs, values = case.supports()
    body, theirs_contact = case.body, case.their_contact()
    found: impact_reference.RollingSolution | None = None
    for stage in range(len(case.creeps)):
        speed = case.speed(stage)
        if case.rail:
            motions[1].velocity = speed
        elif body.rigid is not None:
            ours_plane, their_plane = body.rigid
            ours_plane.displacement = their_plane.displacement = case.depth * np.eye(case.dim)[-1]
            ours_plane.velocity = speed
        with patch.object(newton, "VIOLATION", VIOLATION):
            problem.solve(rtol=1e-13, max_iterations=60)
        found = case.theirs(stage).solve(
            body.order[dofs], values, contact=theirs_contact, master_velocity=speed, start=found
        )
        name = f"{case.name}, stage {stage + 1}" if len(case.creeps) > 1 else case.name
        _rows(report, case, name, problem, found)


def _rows(
    report: Report, case: RollingCase, name: str, problem: Any, theirs: impact_reference.RollingSolution
) -> None:
    """Add the rows of one steady state."""
    body, ours = case.body, problem.contact[0]
    nodes = body.nodal_to_ours

    def at(x: FloatArray | IntArray) -> Any:
        return nodes(x)[ours.nodes]

    closed = at(theirs.status) > 0
    pairs: dict[str, tuple[Any, Any]] = {
        "u": (body.u.x.array, body.to_ours(theirs.u)),
        "multipliers": (ours.traction, at(theirs.multipliers)),
        "contact force": (ours.contact_forces(), body.to_ours(theirs.contact_force)),
    }
    if case.friction:
        pairs["status"] = ours.status, at(theirs.status)
        pairs["slip velocity"] = ours.slip_velocity[closed], at(theirs.slip_velocity)[closed]
        pairs["friction power"] = np.array([ours.friction_power]), np.array([theirs.friction_power])
    form = "friction" if case.friction else "frictionless"
    scales = {"slip velocity": OMEGA, "friction power": OMEGA * abs(float(theirs.contact_force.min()))}
    for what, (a, b) in pairs.items():
        difference, note = _difference(np.asarray(a, dtype=float), np.asarray(b, dtype=float), scales.get(what))
        element = (case.cell, 1, 1, case.hypothesis)
        limits = (TOLERANCE, REASON)
        report.add("rolling", f"rolling.{form}", *element, difference, *limits, f"{what} of the {name}", note)


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


__all__ = ["HUB", "cases", "compare_frequencies", "compare_matrices", "compare_solutions", "free_bodies", "run"]
