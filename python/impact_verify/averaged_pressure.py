# SPDX-License-Identifier: MIT
"""Bodies of linear simplices with averaged pressure or strain on both sides: equilibria and explicit runs.

Rows of the levels solution and history. The hand-written solver has no tangent of these bodies: its internal force at
our equilibria must be ours.
"""

from __future__ import annotations

from typing import Any

import basix
import impact_reference as ref
import numpy as np
from dolfinx import fem

from dolfinx_impact.materials import AVERAGED_PRESSURE, AVERAGED_STRAIN, LinearElastic, NeoHookean
from dolfinx_impact.own_forms import distorted_block
from dolfinx_impact.plasticity import J2Plasticity
from . import differences, matched_body, plastic_bodies
from .nodes import TheirRule
from .report import Report
from .solution import REASON, TOLERANCE

E, NU, Y, SLOPE, DENSITY = 2.0, 0.45, plastic_bodies.Y, 0.02, 1.5
NUM_STEPS = 200
LAWS = {"linear_elastic": LinearElastic, "neo_hookean": NeoHookean}

# cell, hypothesis, law, integration
BODIES = (
    ("tetrahedron", "3d", "linear_elastic", AVERAGED_PRESSURE),
    ("tetrahedron", "3d", "neo_hookean", AVERAGED_PRESSURE),
    ("tetrahedron", "3d", "j2.small", AVERAGED_PRESSURE),
    ("tetrahedron", "3d", "j2.finite", AVERAGED_PRESSURE),
    ("triangle", "plane_strain", "neo_hookean", AVERAGED_PRESSURE),
    ("triangle", "plane_strain", "j2.finite", AVERAGED_PRESSURE),
    ("tetrahedron", "3d", "linear_elastic", AVERAGED_STRAIN),
    ("tetrahedron", "3d", "neo_hookean", AVERAGED_STRAIN),
    ("triangle", "plane_strain", "linear_elastic", AVERAGED_STRAIN),
    ("triangle", "plane_strain", "neo_hookean", AVERAGED_STRAIN),
)


class AveragedBodies:
    """One body on both sides, as plastic_bodies.PlasticBodies.

    Args:
        cell: cell, of degree 1.
        hypothesis: hypothesis of the material.
        law: a name of LAWS, "j2.small" or "j2.finite".
        integration: what is averaged, of elastic laws AVERAGED_PRESSURE or AVERAGED_STRAIN.
        n: cells per side.
    """

    def __init__(self, cell: str, hypothesis: str, law: str, integration: str = AVERAGED_PRESSURE, n: int = 2) -> None:
        domain = distorted_block.block(cell, n)
        plastic, finite = law.startswith("j2"), law == "j2.finite"
        self.steel: Any
        if plastic:
            self.steel = J2Plasticity(
                E, NU, DENSITY, Y, SLOPE, finite_strain=finite, hypothesis=hypothesis, integration=AVERAGED_PRESSURE
            )
        else:
            self.steel = LAWS[law](E, NU, DENSITY, hypothesis, integration)
        rule: TheirRule = basix.make_quadrature(getattr(basix.CellType, cell), 0)
        rules: dict[str, TheirRule] = {"stiffness": rule, "finite_strain": rule}  # masses keep their default rule
        name = "linear_elastic" if plastic else law
        averaged = {} if plastic else {integration: True}
        self.body = matched_body.Body(domain, 1, self.steel, name, rules, **averaged)
        self.other: Any = self.body.model
        if plastic:
            parameters = ref.J2Parameters(E, NU, yield_stress=Y, hardening=SLOPE)
            strain = "simo" if finite else "small"
            self.other = ref.PlasticBody(self.body.model, parameters, strain, averaged_pressure=True)
        self.plastic = plastic
        self.u = fem.Function(self.body.V, name="u")
        self.form = f"{law}.{integration}"
        self.element = (cell, 1, 1, hypothesis)


def static(report: Report, *arguments: Any) -> None:
    """Add the row of a block that is stretched, sheared, and partly unloaded.

    Args:
        report: report to add to.
        arguments: of AveragedBodies.
    """
    both = AveragedBodies(*arguments)
    body, dim = both.body, both.body.gdim
    problem, pull, _ = plastic_bodies.held_block(both)
    size = 0.2 if "small" not in arguments[2] and "linear" not in arguments[2] else 0.02
    along, across = size * np.eye(dim)[-1], 0.5 * size * np.eye(dim)[0]
    worst, note = 0.0, ""
    for target in (0.5 * along, along, along + across, 0.6 * along):
        pull.value[:] = target
        problem.solve(rtol=1e-13)
        theirs = both.body.to_theirs(both.u.x.array)
        force = body.to_ours(both.other.internal_force(theirs))
        difference, where = differences.largest_difference(body, problem.reactions().x.array, force)
        if not difference <= worst:
            worst, note = difference, where
        if both.plastic:
            both.other.commit(theirs)
    what = "forces of the other side in our equilibria"
    report.add("solution", both.form, *both.element, worst, TOLERANCE, REASON, what, note)


def solution_rows(report: Report) -> None:
    """Add the rows of the level solution.

    Args:
        report: report to add to.
    """
    for case in BODIES:
        if report.wants(case[0], 1):
            static(report, *case)


def history_rows(report: Report) -> None:
    """Add the rows of the level history.

    Args:
        report: report to add to.
    """
    for case in BODIES:
        if report.wants(case[0], 1):
            plastic_bodies.compare_runs(report, AveragedBodies(*case), NUM_STEPS)
