# SPDX-License-Identifier: MIT
"""Checks of a law of friction: derivatives, sign, and that nothing refers to a frame of its own."""

from __future__ import annotations

from typing import Any

import numpy as np
from mpi4py import MPI

from dolfinx_impact.common.types import FloatArray
from dolfinx_impact.interface import FrictionLaw
from .findings import Finding, SelfCheckReport

POINTS = 64
STEP = 1e-5
DIFFERENCE = 1e-6  # of central differences whose step is 1e-5 of the size: their error is 1e-10, round-off 1e-11
ROUND_OFF = 1e-11
Found = tuple[float, float, str, str]


class FrictionSubject:
    """A law of friction with random points.

    Args:
        law: the law.
        gdim: dimension of space [1].
        pressure: size of pressures [F/L^2].
        velocity: size of slip velocities [L/T].
    """

    def __init__(self, law: FrictionLaw, gdim: int, pressure: float, velocity: float) -> None:
        self.gdim, self.pressure, self.velocity = gdim, pressure, velocity
        self.kernel = law.compiled(gdim, MPI.COMM_SELF)
        rng = np.random.default_rng(36)
        normal = rng.normal(size=(POINTS, gdim))
        normal /= np.linalg.norm(normal, axis=1)[:, None]
        slip = rng.normal(size=(POINTS, gdim)) * velocity
        slip -= np.sum(slip * normal, axis=1)[:, None] * normal
        self.values: dict[str, FloatArray] = {
            "pressure": rng.uniform(0.0, 2.0, POINTS) * pressure, "slip_rate": slip, "normal": normal,
        }  # fmt: skip
        for name, function in law.fields.items():
            low, high = (float(f(function.x.array)) for f in (np.min, np.max))
            for side in ("slave", "master"):
                self.values[f"{name}_{side}"] = rng.uniform(low, high, POINTS)
        self.turn, _ = np.linalg.qr(rng.normal(size=(gdim, gdim)))

    def evaluate(self, **changes: FloatArray) -> Any:
        """Coefficients at the points, some of whose values are others."""
        return self.kernel.evaluate({name: np.ravel(value) for name, value in (self.values | changes).items()})


def check_friction_law(
    report: SelfCheckReport,
    law: FrictionLaw,
    name: str,
    pressure: float = 1.0,
    velocity: float = 1.0,
    isotropic: bool = True,
) -> None:
    """Check a law of friction in the plane and in space.

    Args:
        report: report to add to.
        law: the law.
        name: how findings call it.
        pressure: size of the pressures of the checks [F/L^2].
        velocity: size of the slip velocities [L/T].
        isotropic: whether the law has no direction of its own.
    """
    for gdim, cell in ((2, "plane"), (3, "space")):
        subject = FrictionSubject(law, gdim, pressure, velocity)
        for check, run in CHECKS.items():
            applies, (found, tolerance, reason, note) = True, run(subject)
            if check == "rotation" and not isotropic:
                applies, note = False, "the law has a direction of its own: isotropic=False"
            report.rows.append(
                Finding(
                    "self-check", name, cell, 0, 0, "", found if applies else 0.0, tolerance if applies else 0.0,
                    reason, check, note, applies=applies,
                )
            )  # fmt: skip


def derivative(subject: FrictionSubject) -> Found:
    """Are the derivatives those of the coefficient, by central differences?

    Args:
        subject: the law.
    """
    whole, worst = subject.evaluate(), 0.0
    inputs = (
        ("pressure", whole.by_pressure, subject.pressure, 1),
        ("slip_rate", whole.by_slip_rate, subject.velocity, subject.gdim),
    )
    for name, found, size, width in inputs:
        given = np.asarray(found)
        rows = given.reshape(POINTS, width) if given.size else np.zeros((POINTS, width))
        slopes, kinks = np.zeros((POINTS, width)), np.zeros((POINTS, width), dtype=bool)
        for c in range(width):

            def at(h: float) -> FloatArray:
                moved = subject.values[name].reshape(POINTS, width).copy()
                moved[:, c] += h * size
                return np.asarray(subject.evaluate(**{name: moved}).value)

            up, middle, down = at(STEP), at(0.0), at(-STEP)
            slopes[:, c] = (up - down) / (2 * STEP * size)
            kinks[:, c] = np.abs(up - 2 * middle + down) > 1e-2 * np.maximum(np.abs(up - down), 1e-9)
        scale = max(float(np.abs(slopes).max()), float(np.abs(rows).max()), 1e-12 / size)
        worst = max(worst, float(np.abs(np.where(kinks, 0.0, slopes - rows)).max()) / scale)
    good = worst <= DIFFERENCE
    return (
        worst, DIFFERENCE, "round-off and order of central differences",
        "derivatives are those of the coefficient" if good
        else f"a derivative differs by {worst:.1e} from the difference of two coefficients",
    )  # fmt: skip


def sign(subject: FrictionSubject) -> Found:
    """Is the coefficient a number, and not below zero? (Below zero it counts as zero.)

    Args:
        subject: the law.
    """
    value = np.asarray(subject.evaluate().value)
    bad = int(np.sum(~np.isfinite(value) | (value <= 0.0)))
    return (
        float(bad), 0.0, "a count",
        "coefficients are positive" if bad == 0
        else f"{bad} of {POINTS} coefficients are no numbers, zero, or below zero and taken for zero",
    )  # fmt: skip


def rotation(subject: FrictionSubject) -> Found:
    """Does the coefficient stay when the surfaces turn?

    Args:
        subject: the law.
    """
    turned = {name: subject.values[name] @ subject.turn.T for name in ("slip_rate", "normal")}
    plain, other = (np.asarray(subject.evaluate(**values).value) for values in ({}, turned))
    worst = float(np.abs(plain - other).max()) / max(float(np.abs(plain).max()), 1e-300)
    return (
        worst, ROUND_OFF, "round-off of a rotation",
        "the coefficient does not depend on the frame" if worst <= ROUND_OFF
        else f"the coefficient changes by {worst:.1e} when the surfaces turn: give isotropic=False if it shall",
    )  # fmt: skip


CHECKS = {"derivative": derivative, "sign": sign, "rotation": rotation}
