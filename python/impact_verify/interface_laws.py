# SPDX-License-Identifier: MIT
"""Level contact: the laws of the interface of the package against those of the hand-written solver, along histories."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import impact_reference
import numpy as np
from mpi4py import MPI

from dolfinx_impact import interface
from impact_reference import InterfaceHistory
from .report import Report

STEPS = 60
TIME_STEP = 0.01
# Sixty steps carry a history on: round-off of each is 1e-16 of the largest traction, and a return to the limit may
# double what came before. The energy of the exponential law is compared with Gauss's rule, whose error is below that.
TOLERANCE = 1e-12
REASON = "round-off of sixty steps"
LENGTH = 1e-3
STIFFNESS = 2e6


def run(report: Report) -> None:
    """Add a row for each law in the plane and in space.

    Args:
        report: report to add to.
    """
    for name, (law, theirs) in laws().items():
        for gdim, cell in ((2, "quadrilateral"), (3, "hexahedron")):
            if report.wants(cell, 1):
                compare(report, f"contact.interface.{name}", law, theirs, gdim, cell)


Theirs = Callable[[Any, Any], InterfaceHistory]


def laws() -> dict[str, tuple[interface.InterfaceLaw, Theirs]]:
    """The package's laws by name, each with the hand-written solver's on a history of one point."""
    falling = interface.falling_friction(0.6, 0.2, 0.02)

    def coefficient(v: float) -> float:
        return 0.2 + (0.6 - 0.2) * math.exp(-v / 0.02)

    def spring(gap: float) -> tuple[float, float]:
        return impact_reference.spring_pressure(gap, STIFFNESS)

    def normal_only(pressure: Callable[[float, float], tuple[float, float]]) -> Theirs:
        def history(gaps: Any, slips: Any) -> InterfaceHistory:
            rates = np.diff(gaps, prepend=0.0) / TIME_STEP
            found = np.array([pressure(float(g), float(r)) for g, r in zip(gaps, rates)])
            return InterfaceHistory(found[:, 0], np.zeros_like(slips), found[:, 1])

        return history

    def friction(of_velocity: Callable[[float], float]) -> Theirs:
        return lambda gaps, slips: impact_reference.friction_history(
            gaps, slips, spring, STIFFNESS, of_velocity, TIME_STEP
        )

    bond = dict(stiffness=STIFFNESS, strength=600.0, energy=0.4, shear_strength=900.0, shear_energy=0.7, exponent=1.8)
    return {
        "exponential_pressure": (
            interface.exponential_pressure(300.0, 0.7 * LENGTH),
            normal_only(lambda g, _: impact_reference.exponential_pressure(g, 300.0, 0.7 * LENGTH)),
        ),
        "adhesion": (
            interface.adhesion(0.3, 0.4 * LENGTH),
            normal_only(lambda g, _: impact_reference.adhesive_pressure(g, 0.3, 0.4 * LENGTH)),
        ),
        "damped_contact": (
            interface.damped_contact(STIFFNESS, 8.0),
            normal_only(lambda g, r: impact_reference.damped_pressure(g, r, STIFFNESS, 8.0)),
        ),
        "friction": (interface.linear_pressure(STIFFNESS, friction=0.4), friction(lambda _: 0.4)),
        "falling_friction": (interface.linear_pressure(STIFFNESS, friction=falling), friction(coefficient)),
        "cohesive_zone": (
            interface.cohesive_zone(**bond),
            lambda gaps, slips: impact_reference.cohesive_history(
                gaps, slips, STIFFNESS, (600.0, 900.0), (0.4, 0.7), 1.8
            ),
        ),
    }


def compare(
    report: Report, form: str, law: interface.InterfaceLaw, theirs: Theirs, gdim: int, cell: str, points: int = 20
) -> None:
    """Add the row of a law: tractions and energies along random histories of some points.

    Args:
        report: report to add to.
        form: name of the row's form.
        law: the package's law.
        theirs: the hand-written one.
        gdim: dimension of space [1].
        cell: name of the row's cell.
        points: number of points.
    """
    rng = np.random.default_rng(3500 + gdim)
    s = np.arange(1, STEPS + 1) / STEPS
    waves = np.stack([np.sin(np.pi * k * s) for k in (1, 2, 3, 4)])
    gaps = np.einsum("kt,kn->tn", waves, rng.normal(size=(4, points))) * 0.5 * LENGTH
    slips = np.einsum("kt,knc->tnc", waves, rng.normal(size=(4, points, 2))) * 0.5 * LENGTH
    if gdim == 2:
        slips[:, :, 1] = 0.0
    frames = np.array([np.linalg.qr(rng.normal(size=(gdim, gdim)))[0] for _ in range(points)])
    normal = frames[:, :, -1]
    axes = np.zeros((points, gdim, 2))
    axes[:, :, : gdim - 1] = frames[:, :, : gdim - 1]
    kernel = law.compiled(gdim, MPI.COMM_SELF)
    sizes = {name: gdim if shape == "tangential" else 1 for name, shape in law.history.items()}
    values: dict[str, Any] = {f"history {name}": np.zeros(points * size) for name, size in sizes.items()}
    pressure, shear, energy = np.zeros((STEPS, points)), np.zeros((STEPS, points, 2)), np.zeros((STEPS, points))
    last_gap, last_slip = np.zeros(points), np.zeros((points, gdim))
    for k in range(STEPS):
        slip = np.einsum("nca,na->nc", axes, slips[k])
        values |= {"gap": gaps[k], "slip": slip.ravel(), "normal": normal.ravel()}
        values |= {"gap_rate": (gaps[k] - last_gap) / TIME_STEP, "slip_rate": ((slip - last_slip) / TIME_STEP).ravel()}
        values = {name: np.ascontiguousarray(value, dtype=float) for name, value in values.items()}
        found = kernel.evaluate(values)
        pressure[k], energy[k] = found.pressure, found.energy
        shear[k] = np.einsum("nca,nc->na", axes, np.asarray(found.shear).reshape(points, gdim))
        values |= {f"history {name}": np.asarray(found.history(name)) for name in sizes}
        last_gap, last_slip = gaps[k], slip
    worst = 0.0
    for p in range(points):
        answer = theirs(gaps[:, p], slips[:, p])
        size = max(np.abs(answer.pressure).max(), np.abs(answer.shear).max(), 1e-300)
        worst = max(worst, np.abs(pressure[:, p] - answer.pressure).max() / size)
        worst = max(worst, np.abs(shear[:, p] - answer.shear).max() / size)
        worst = max(worst, np.abs(energy[:, p] - answer.energy).max() / max(np.abs(answer.energy).max(), 1e-300))
    note = "" if worst <= TOLERANCE else "tractions or energies of the law differ along a history of gap and slip"
    report.add(
        "contact", form, cell, 1, 1, "plane_strain" if gdim == 2 else "3d", worst, TOLERANCE, REASON,
        name="traction and energy", note=note,
    )  # fmt: skip
