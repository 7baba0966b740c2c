# SPDX-License-Identifier: MIT
"""A run in time as data: bodies, motions, loads, contact, scheme, steps, what is compared and to what tolerance."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any, TypeAlias, Union

import numpy as np

from dolfinx_impact.common.types import FloatArray, IntArray
from ..contact_bodies import TwoBodies

# Velocities [L/T] at positions [L], both of shape (num_nodes, gdim), in our order.
VelocityField: TypeAlias = Callable[[FloatArray], FloatArray]

PENALTY, TANGENTIAL = 20.0, 15.0  # of implicit runs with penalty [F/L^3]
USUAL_FRACTION = 0.8  # of the time step in the stable step, where a run does not vary it [1]


@dataclass(frozen=True)
class Explicit:
    """Central differences, whose step is a fraction of the stable one.

    Args:
        velocities: "half_step" or "classical".
        viscosity: linear and quadratic bulk viscosity; None for none [1].
        precision: of our side's element forces, of ExplicitProblem.
    """

    velocities: str = "half_step"
    viscosity: tuple[float, float] | None = None
    precision: str = "double"


@dataclass(frozen=True)
class Implicit:
    """A scheme of Newmark's family, with the time step of a run that is not varied.

    Args:
        parameters: beta, gamma, rho_inf or hht of the scheme; empty for the trapezoidal rule [1].
        lumping: lumping scheme of the mass; None: consistent.
        dt: time step of a run with the usual fraction; others take it in proportion [T].
        impact: what is done about the mass of contact surfaces, of NewmarkProblem.
        error: local error by which our side chooses its steps, dt at most; None: they are equal [1].
    """

    parameters: dict[str, Any] = field(default_factory=dict)
    lumping: str | None = None
    dt: float = 0.05
    impact: str = "mass_redistribution"
    error: float | None = None


Scheme: TypeAlias = Union[Explicit, Implicit]


@dataclass(frozen=True)
class Accuracy:
    """How well both sides must agree.

    Args:
        tolerance: largest difference over the largest value; of energies over the largest energy of the run [1].
        reason: where the tolerance comes from.
    """

    tolerance: float
    reason: str


ACCURACY: dict[type[Scheme], Accuracy] = {
    Explicit: Accuracy(1e-9, "round-off of 500 steps, which waves and contact carry on"),
    Implicit: Accuracy(
        1e-9, "round-off of 200 steps, which waves and contact carry on, and what Newton's methods leave"
    ),
}
STEPS: dict[type[Scheme], int] = {Explicit: 500, Implicit: 200}


@dataclass
class Scenario:
    """A run: a body with its initial velocity, supports, loads, damping, contact and scheme.

    Args:
        name: name in the rows.
        body: bodies of both sides.
        velocity: initial velocity as a function of the positions of our nodes [L/T].
        scheme: how time is stepped.
        contact: "penalty", "kinematic", "general" (explicit), "lagrange" (implicit) or "" for no contact.
        options: keyword arguments of an explicit contact.
        fixed_nodes: our nodes with prescribed displacements.
        motion: displacement of these nodes along the last axis as a function of time; None for zero [L].
        gravity: acceleration, shape (gdim) [L/T^2], and amplitude over time [1].
        obstacle: displacement of the rigid obstacle as a function of time; None for zero [L].
        angle: rotation vector of the rigid obstacle as a function of time, (3); None: it does not turn [1].
        damping: Rayleigh damping alpha [1/T] and beta [T].
        foundation: stiffness [F/L^3] and damping [F T/L^3] of a Foundation under the facets SLAVE on our side; the
            other side's model has it already (`on_foundation`).
        added_mass: mass on the facets SLAVE on our side; the other side's model has it already [M].
        smooth: of a smooth master, function of positions, shape (gdim or more, n), that gives normals, (gdim, n).
        step_fraction: time step of explicit runs over the stable step, see Implicit.dt for others [1].
        steps: number of steps; None: those of all runs with this kind of scheme [1].
        agreement: how well both sides must agree; None: as all runs with this kind of scheme.
    """

    name: str
    body: TwoBodies
    velocity: VelocityField
    scheme: Scheme = Explicit()
    contact: str = ""
    options: dict[str, Any] = field(default_factory=dict)
    fixed_nodes: IntArray | tuple[int, ...] = ()
    motion: Callable[[float], float] | None = None
    gravity: tuple[FloatArray, Callable[[float], float]] | None = None
    obstacle: Callable[[float], FloatArray] | None = None
    angle: Callable[[float], FloatArray] | None = None
    damping: tuple[float, float] = (0.0, 0.0)
    foundation: tuple[Any, Any] | None = None
    added_mass: float | None = None
    smooth: Callable[[FloatArray], FloatArray] | None = None
    step_fraction: float = USUAL_FRACTION
    steps: int | None = None
    agreement: Accuracy | None = None

    @property
    def num_steps(self) -> int:
        """Number of steps [1]."""
        return STEPS[type(self.scheme)] if self.steps is None else self.steps

    @property
    def accuracy(self) -> Accuracy:
        """How well both sides must agree."""
        return ACCURACY[type(self.scheme)] if self.agreement is None else self.agreement

    @property
    def form(self) -> str:
        """Form of the rows."""
        return f"{'explicit' if isinstance(self.scheme, Explicit) else 'implicit'}.{self.contact or 'free'}"

    @property
    def compared(self) -> tuple[str, ...]:
        """Fields that are compared at all time levels, besides energies and the contact force."""
        if isinstance(self.scheme, Implicit):
            return "displacement", "velocity", "acceleration"
        # Forces of kinematic contact, and with them this velocity, are known one step later.
        return ("displacement",) if self.contact == "kinematic" else ("displacement", "velocity")

    @property
    def fixed_dofs(self) -> IntArray:
        """Our degrees of freedom with prescribed displacements, (n)."""
        gdim = self.body.gdim
        found: IntArray = (np.asarray(self.fixed_nodes, dtype=np.int64)[:, None] * gdim + np.arange(gdim)).ravel()
        return found


MakeScenarios: TypeAlias = Callable[..., Iterator[Scenario]]  # of cell, degree and variation
