# SPDX-License-Identifier: MIT
"""Bodies of J2 plasticity on both sides: static problems with unloading, and the impact of a bar that yields.

Rows of the levels solution and history.
"""

from __future__ import annotations

from typing import Any, Protocol

import basix
from dolfinx_impact.own_forms import distorted_block
import impact_reference as ref
import numpy as np
from dolfinx import fem

from dolfinx_impact.common.types import FloatArray
from dolfinx_impact.dynamics.explicit import ExplicitProblem
from dolfinx_impact.dynamics.run_history import ENERGIES
from dolfinx_impact.forms import quadrature
from dolfinx_impact.plasticity import J2Plasticity
from dolfinx_impact.statics.static_problem import StaticProblem
from . import differences, matched_body
from .material import CASES, Case
from .nodes import TheirRule
from .report import Report
from .scenarios.scenario import ACCURACY, Explicit
from .solution import REASON, TOLERANCE, _tags

E, NU, Y = 2.0, 0.3, 0.01
NUM_STEPS = 500

# cell, degree, hypothesis, finite strain, mean dilatation or its linear fit, law
BODIES = (
    ("tetrahedron", 1, "3d", False, False, "linear"),
    ("tetrahedron", 2, "3d", True, False, "voce"),
    ("triangle", 2, "plane_stress", False, False, "table"),
    ("triangle", 1, "plane_strain", False, False, "armstrong_frederick"),
    ("quadrilateral", 1, "plane_strain", False, True, "prager"),
    ("quadrilateral", 1, "axisymmetric", True, True, "linear"),
    ("quadrilateral", 2, "plane_strain", True, False, "linear"),
    ("quadrilateral", 2, "plane_strain", False, "linear", "prager"),
    ("quadrilateral", 2, "axisymmetric", True, "linear", "linear"),
    ("hexahedron", 1, "3d", False, True, "armstrong_frederick"),
    ("hexahedron", 1, "3d", True, True, "voce"),
    ("hexahedron", 1, "3d", True, True, "armstrong_frederick"),
    ("quadrilateral", 1, "axisymmetric", True, True, "prager"),
    ("hexahedron", 2, "3d", False, "linear", "voce"),
    ("quadrilateral", 1, "plane_stress", True, False, "voce"),
    ("triangle", 1, "plane_stress", True, False, "armstrong_frederick"),
    ("triangle", 2, "plane_stress", True, False, "prager"),
)


def _scaled(case: Case) -> tuple[dict[str, Any], dict[str, Any]]:
    """Arguments of a law of the level material for the units of this file."""
    from .material import Y as other
    from dolfinx_impact.plasticity import ArmstrongFrederick, Table, Voce

    f = Y / other
    ours = dict(case.ours)
    h, k = ours.get("hardening", 0.0), ours.get("kinematic")
    if isinstance(h, Voce):
        ours["hardening"] = Voce(h.saturation * f, h.rate, h.modulus * f)
    elif isinstance(h, Table):
        ours["hardening"] = Table(list(h.strains), list(h.stresses * f))
    else:
        ours["hardening"] = h * f
    if isinstance(k, ArmstrongFrederick):
        ours["kinematic"] = ArmstrongFrederick(k.modulus * f, k.recovery)
    elif k is not None:
        ours["kinematic"] = k * f
    theirs = dict(case.theirs)
    for name in ("yield_stress", "hardening", "saturation_stress", "kinematic"):
        if name in theirs:
            theirs[name] *= f
    if "table" in theirs:
        theirs["table"] = [theirs["table"][0], [s * f for s in theirs["table"][1]]]
    return ours, theirs


class PlasticBodies:
    """One body on both sides.

    Args:
        cell: cell.
        degree: degree of the displacement.
        hypothesis: hypothesis of the material.
        finite: whether strains are finite.
        average: whether the dilatation is averaged over cells; "linear": projected on linear functions.
        law: name of one of material.CASES.
        n: cells per side.
    """

    def __init__(
        self, cell: str, degree: int, hypothesis: str, finite: bool, average: bool | str, law: str, n: int = 2
    ) -> None:
        domain = distorted_block.block(cell, n)
        if hypothesis == "axisymmetric":
            domain.geometry.x[:, 0] += 0.5
        ours, theirs = _scaled(next(c for c in CASES if c.name == law))
        self.steel = J2Plasticity(
            E, NU, 1.5, Y, finite_strain=finite, average=average, hypothesis=hypothesis, **ours
        )  # fmt: skip
        used = quadrature.stiffness_degree(cell, degree, 1, hypothesis)
        rule: TheirRule = f"gauss_jacobi:{used}"
        if cell in quadrature.SIMPLICES:
            rule = basix.make_quadrature(getattr(basix.CellType, cell), used)
        rules: dict[str, TheirRule] = {"stiffness": rule, "finite_strain": rule}  # masses keep their default rule
        self.body = matched_body.Body(domain, degree, self.steel, "linear_elastic", rules)
        self.other = ref.PlasticBody(
            self.body.model, ref.J2Parameters(E, NU, **theirs), "simo" if finite else "small", average
        )  # fmt: skip
        self.u = fem.Function(self.body.V, name="u")
        self.form = f"j2.{'finite' if finite else 'small'}.{law}"
        self.element = (cell, degree, 1, hypothesis)


def held_block(both: Any) -> tuple[StaticProblem, fem.Constant, list[Any]]:
    """Static problem of a block that is held at one end and moved at the other.

    Args:
        both: bodies of both sides, as PlasticBodies.

    Returns:
        The problem, the displacement of the moved end [L], and the nodes of both ends.
    """
    body, dim = both.body, both.body.gdim
    tags, V = _tags(body.mesh, dim - 1), body.V
    ends = [fem.locate_dofs_topological(V, dim - 1, tags.find(t)) for t in (1, 2)]
    pull = fem.Constant(body.mesh, np.zeros(dim))
    bcs = [fem.dirichletbc(np.zeros(dim), ends[0], V), fem.dirichletbc(pull, ends[1], V)]
    return StaticProblem(both.u, both.steel, bcs=bcs), pull, ends


def static(report: Report, *arguments: Any) -> None:
    """Add the rows of a block that is stretched beyond yield, sheared, and partly unloaded.

    Args:
        report: report to add to.
        arguments: of PlasticBodies.
    """
    both = PlasticBodies(*arguments)
    body, dim = both.body, both.body.gdim
    problem, pull, ends = held_block(both)
    hypothesis, finite, average, law = arguments[2:6]
    # A linear fit of J is soon negative on the way to a solution: increments that are cut back end elsewhere. Sheets of
    # a law that saturates neck, with Armstrong and Frederick's alone where the strain is above ln(C/Y)/gamma = 0.014.
    sheet = finite and hypothesis == "plane_stress"
    size = 0.02 if not finite or (sheet and law != "prager") else 0.05 if average == "linear" or sheet else 0.2
    stop = 1e-12 if sheet else 1e-13  # round-off of the stretch across the plane is a part of the residual
    way = [size * np.eye(dim)[-1], size * (np.eye(dim)[-1] + 0.5 * np.eye(dim)[0]), 0.6 * size * np.eye(dim)[-1]]
    fixed = np.concatenate([(dim * e[:, None] + np.arange(dim)).ravel() for e in ends])
    values, reached, found = [], np.zeros(dim), []
    for target in way:  # two increments each, the same on both sides
        for part in (0.5, 1.0):
            here = reached + part * (target - reached)
            pull.value[:] = here
            problem.solve(rtol=stop)
            values.append(np.concatenate([np.zeros(dim * len(ends[0])), np.tile(here, len(ends[1]))]))
            found.append((both.u.x.array.copy(), problem.reactions().x.array.copy()))
        reached = target
    theirs = both.other.solve_static(body.order[fixed], np.array(values), tolerance=stop)
    for what, index, expected in (("u", 0, theirs.u), ("reactions", 1, theirs.reactions)):
        worst, note = 0.0, ""
        for k, ours in enumerate(found):
            difference, where = differences.largest_difference(body, ours[index], body.to_ours(np.asarray(expected)[k]))
            if not difference <= worst:
                worst, note = difference, where
        report.add(
            "solution", both.form, *both.element, worst, TOLERANCE, REASON, f"{what} of the yielding block", note
        )
    a = problem.history["plastic_strain"].values
    difference = abs(float(a.max()) - float(both.other.history.plastic_strain.max())) / float(a.max())
    report.add("solution", both.form, *both.element, difference, TOLERANCE, REASON, "largest plastic strain")


def impact(report: Report, *arguments: Any) -> None:
    """Add the rows of a block that flies away from its clamped end, fast enough to yield.

    Args:
        report: report to add to.
        arguments: of PlasticBodies.
    """
    compare_runs(report, PlasticBodies(*arguments))


class Bodies(Protocol):
    """One body on both sides, as PlasticBodies and averaged_pressure.AveragedBodies have it.

    Attributes:
        steel: material of our side.
        body: mesh and spaces of both sides.
        other: the other side.
        u: displacement of our side.
        form: name of the law in rows.
        element: cell, degree, geometry degree and hypothesis.
    """

    steel: Any
    body: matched_body.Body
    other: Any
    u: fem.Function
    form: str
    element: tuple[str, int, int, str]


def compare_runs(report: Report, both: Bodies, num_steps: int = NUM_STEPS) -> None:
    """Add the rows of an explicit run of a block that flies away from its clamped end.

    Args:
        report: report to add to.
        both: both sides.
        num_steps: number of steps.
    """
    body, dim = both.body, both.body.gdim
    V = body.V
    x = V.tabulate_dof_coordinates()[:, :dim]
    v = fem.Function(V)
    speed = 4.0 * Y / np.sqrt(E * 1.5)
    v0 = speed * np.stack([x[:, -1] * (1.0 if a == dim - 1 else 0.3 * np.sin(3 * x[:, 0])) for a in range(dim)], axis=1)
    nodes = np.flatnonzero(np.isclose(x[:, -1], 0.0)).astype(np.int32)
    v0[nodes] = 0.0
    v.x.array[:] = v0.ravel()
    problem = ExplicitProblem(both.u, both.steel, velocity=v, bcs=[fem.dirichletbc(np.zeros(dim), nodes, V)])
    dt = 0.7 * problem.stable_step()
    states: list[tuple[FloatArray, FloatArray]] = []
    problem.advance(
        num_steps * dt, dt=dt, progress=False,
        callback=lambda p: states.append((p.u.x.array.copy(), p.velocity.x.array.copy())),
    )  # fmt: skip
    start = np.empty(len(body.order))
    start[body.order] = v0.ravel()
    fixed = (dim * nodes[:, None] + np.arange(dim)).ravel()
    other = both.other.run_explicit(dt, num_steps, v0=start, fixed_dofs=body.order[fixed])
    pairs: dict[str, tuple[FloatArray, FloatArray]] = {
        "displacement": (np.array([s[0] for s in states]), other.u[:, body.order]),
        "velocity": (np.array([s[1] for s in states]), other.v[:, body.order]),
    }
    energies = problem.energy_history[:, 1:].T
    size, accuracy = float(energies[0].max()), ACCURACY[Explicit]
    for k, name in enumerate(ENERGIES):
        if name in ("kinetic", "internal", "plastic"):
            pairs[f"{name} energy"] = (energies[k], other.energies[name][: energies.shape[1]])
    for what, (a, b) in pairs.items():
        scale = size if what.endswith("energy") else float(np.abs(b).max())
        difference = float(np.abs(a - b).max()) / scale if a.shape == b.shape else np.inf
        block = "yielding block" if energies[7].any() else "block"
        name = f"{what} of the {block}, {100 * energies[7, -1] / size:.0f} % dissipated"
        report.add("history", both.form, *both.element, difference, accuracy.tolerance, accuracy.reason, name)


def solution_rows(report: Report) -> None:
    """Add the rows of all bodies at the level solution.

    Args:
        report: report to add to.
    """
    for case in BODIES:
        if report.wants(case[0], case[1]):
            static(report, *case)


def history_rows(report: Report) -> None:
    """Add the rows of the level history; cells of degree 2 would need very many steps.

    Args:
        report: report to add to.
    """
    for case in BODIES:
        if case[1] == 1 and report.wants(case[0], case[1]):
            impact(report, *case)


__all__ = ["Bodies", "PlasticBodies", "compare_runs", "history_rows", "impact", "solution_rows", "static"]
