# SPDX-License-Identifier: MIT
"""Checks of a law of the interface: derivatives, dissipation, and that nothing refers to a frame of its own.

The law is evaluated by its kernel at points of its own, without a mesh, along random paths of gap and slip.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from mpi4py import MPI

from dolfinx_impact.common.types import FloatArray
from dolfinx_impact.interface import InterfaceLaw
from .findings import Finding, SelfCheckReport

POINTS = 64
STEPS = 40  # of a path
DIFFERENCE = 1e-6  # of central differences whose step is 1e-5 of the size: their error is 1e-10, round-off 1e-11
STEP = 1e-5
ROUND_OFF = 1e-11  # of a rotation and of a law's algebra


@dataclass
class State:
    """Points as the law sees them; vectors (n, gdim)."""

    gap: FloatArray
    slip: FloatArray
    gap_rate: FloatArray
    slip_rate: FloatArray
    normal: FloatArray
    history: dict[str, FloatArray]
    fields: dict[str, FloatArray] = field(default_factory=dict)

    def values(self) -> dict[str, FloatArray]:
        """Flat arrays by the names that the kernel has for them."""
        names = ("gap", "slip", "gap_rate", "slip_rate", "normal")
        out = {name: np.ravel(getattr(self, name)).astype(float) for name in names}
        out |= {f"history {name}": np.ravel(value) for name, value in self.history.items()}
        return out | self.fields


class LawSubject:
    """A law of the interface with random points.

    Args:
        law: the law.
        gdim: dimension of space [1].
        length: size of gaps and slips [L].
        velocity: size of their rates [L/T].
    """

    def __init__(self, law: InterfaceLaw, gdim: int, length: float, velocity: float) -> None:
        self.law, self.gdim, self.length, self.velocity = law, gdim, length, velocity
        self.kernel = law.compiled(gdim, MPI.COMM_SELF)
        self.rng = np.random.default_rng(35)
        n = self.rng.normal(size=(POINTS, gdim))
        self.normal = n / np.linalg.norm(n, axis=1)[:, None]
        self.fields: dict[str, FloatArray] = {}
        for name, function in law.fields.items():
            low, high = (float(f(function.x.array)) for f in (np.min, np.max))
            for side in ("slave", "master"):
                self.fields[f"{name}_{side}"] = self.rng.uniform(low, high, POINTS)

    def along(self, vectors: FloatArray) -> FloatArray:
        """Part of vectors in the tangent planes."""
        return vectors - np.sum(vectors * self.normal, axis=1)[:, None] * self.normal

    def start(self) -> State:
        """Points that just touch, without history."""
        zero = np.zeros((POINTS, self.gdim))
        history: dict[str, FloatArray] = {}
        for name, shape in self.law.history.items():
            width = self.gdim if isinstance(shape, str) else int(np.prod(shape, dtype=int))
            history[name] = np.zeros((POINTS, width))
        return State(np.zeros(POINTS), zero, np.zeros(POINTS), zero, self.normal, history, self.fields)

    def evaluate(self, state: State) -> Any:
        """What the law returns."""
        return self.kernel.evaluate(state.values())

    def shear(self, found: Any) -> FloatArray:
        """Shear tractions, (n, gdim)."""
        return np.asarray(found.shear).reshape(-1, self.gdim)

    def advanced(self, state: State, gap: FloatArray, slip: FloatArray, dt: float) -> tuple[State, Any]:
        """A state after an increment, and what the law returns there."""
        rates = (gap - state.gap) / dt, (slip - state.slip) / dt
        there = State(gap, slip, *rates, state.normal, state.history, state.fields)
        found = self.evaluate(there)
        shapes = {name: value.shape for name, value in state.history.items()}
        history = {name: np.asarray(found.history(name)).reshape(shape) for name, shape in shapes.items()}
        return State(gap, slip, *rates, state.normal, history, state.fields), found

    def path(self) -> tuple[FloatArray, FloatArray]:
        """Smooth random gaps and slips, (STEPS + 1, n) and (STEPS + 1, n, gdim), which begin at zero."""
        s = np.linspace(0.0, 1.0, STEPS + 1)
        waves = np.stack([np.sin(np.pi * k * s) for k in (1, 2, 3, 5)])
        gap = np.einsum("kt,kn->tn", waves, self.rng.normal(size=(4, POINTS))) * 0.5 * self.length
        slip = np.einsum("kt,knc->tnc", waves, self.rng.normal(size=(4, POINTS, self.gdim))) * 0.5 * self.length
        return gap, np.array([self.along(x) for x in slip])


def check_interface_law(
    report: SelfCheckReport,
    law: InterfaceLaw,
    name: str,
    length: float | None = None,
    velocity: float | None = None,
    isotropic: bool = True,
) -> None:
    """Check a law of the interface in the plane and in space.

    Args:
        report: report to add to.
        law: the law.
        name: how findings call it.
        length: size of the gaps and slips of the checks; None: a quarter of the law's reach, 1e-3 without [L].
        velocity: size of their rates; None: `length` in a unit of time [L/T].
        isotropic: whether the law has no direction of its own.
    """
    size = length or (law.reach / 4 if np.isfinite(law.reach) else 1e-3)
    for gdim, cell in ((2, "plane"), (3, "space")):
        if gdim == 2 and law.only_in_space:
            continue
        subject = LawSubject(law, gdim, size, velocity or size)
        for check, run in CHECKS.items():
            found, tolerance, reason, note = run(subject)
            applies = found is not None
            if check == "rotation" and not isotropic:
                applies, note = False, "the law has a direction of its own: isotropic=False"
            row = Finding(
                "self-check", name, cell, 0, 0, "", found if applies and found is not None else 0.0,
                tolerance if applies else 0.0, reason, check, note, applies=applies,
            )  # fmt: skip
            report.rows.append(row)


Found = tuple[float | None, float, str, str]


def _scale(*values: FloatArray) -> float:
    return max(max(float(np.abs(v).max(initial=0.0)) for v in values), 1e-300)


def derivative(subject: LawSubject) -> Found:
    """Are the derivatives those of pressure and shear traction, by central differences?

    Args:
        subject: the law.
    """
    gaps, slips = subject.path()
    dt = subject.length / subject.velocity / STEPS
    state = subject.start()
    for k in range(1, STEPS // 2):
        state, _ = subject.advanced(state, gaps[k], slips[k], dt)
    # In the middle of the next increment: at the end of one, points are on the limit that they have slipped at.
    half = 0.5 * dt
    gap, slip = (0.5 * (x[STEPS // 2 - 1] + x[STEPS // 2]) for x in (gaps, slips))
    rates = (gap - state.gap) / half, (slip - state.slip) / half
    state = State(gap, slip, *rates, state.normal, state.history, state.fields)
    inputs = {"gap": subject.length, "slip": subject.length, "gap_rate": subject.velocity}
    inputs |= {"slip_rate": subject.velocity}
    worst, whole = 0.0, subject.evaluate(state)
    kinks, checked = 0, 0
    for name, size in inputs.items():
        width = 1 if name.startswith("gap") else subject.gdim
        given = np.asarray(whole.by(name))
        rows = given.reshape(POINTS, 1 + subject.gdim, width) if given.size else None
        for c in range(width):

            def moved(h: float) -> FloatArray:
                values = state.values()
                array = values[name].reshape(POINTS, width).copy()
                array[:, c] += h * size
                values[name] = array.ravel()
                out = subject.kernel.evaluate(values)
                return np.column_stack([out.pressure, np.asarray(out.shear).reshape(POINTS, -1)])

            middle, up, down = moved(0.0), moved(STEP), moved(-STEP)
            slope = (up - down) / (2 * STEP * size)
            one_sided = np.abs(up - 2 * middle + down).max(axis=1) / (STEP * size)
            scale = _scale(slope, np.zeros(1) if rows is None else rows[:, :, c])
            smooth = one_sided < 1e-2 * np.maximum(np.abs(slope).max(axis=1), 1e-3 * scale)
            kinks += int(np.sum(~smooth))
            checked += POINTS
            if np.any(smooth):
                difference = slope[smooth] - (0.0 if rows is None else rows[smooth, :, c])
                worst = max(worst, float(np.abs(difference).max()) / scale)
    if kinks > checked // 2:
        worst = np.nan
    return (
        worst, DIFFERENCE, "round-off and order of central differences",
        f"derivatives are those of pressure and shear traction ({kinks} of {checked} differences are across a kink)"
        if worst <= DIFFERENCE
        else f"a derivative differs by {worst:.1e} from the difference of two tractions: the law has a part that UFL "
        "does not differentiate as it stands",
    )  # fmt: skip


def dissipation(subject: LawSubject) -> Found:
    """Is the work that is not stored never negative?

    Args:
        subject: the law.
    """
    if not subject.kernel.has_energy:
        return None, 0.0, "", "the law states no energy, so that what it dissipates is not known"
    gaps, slips = subject.path()

    def losses(parts: int) -> tuple[FloatArray, float]:
        """Dissipated in each increment of the path, halved so often, and the size of the work."""
        dt = subject.length / subject.velocity / STEPS / parts
        state = subject.start()
        found = subject.evaluate(state)
        lost, work_size = np.zeros((STEPS, POINTS)), 0.0
        for k in range(STEPS):
            for j in range(1, parts + 1):
                way = j / parts
                gap = gaps[k] + way * (gaps[k + 1] - gaps[k])
                slip = slips[k] + way * (slips[k + 1] - slips[k])
                before, last = state, found
                state, found = subject.advanced(before, gap, slip, dt)
                work = -0.5 * (last.pressure + found.pressure) * (gap - before.gap)
                work -= 0.5 * np.sum((subject.shear(last) + subject.shear(found)) * (slip - before.slip), axis=1)
                lost[k] += work - (found.energy - last.energy)
                work_size = max(work_size, _scale(work, found.energy))
        return lost, work_size

    coarse, size = losses(4)
    fine, _ = losses(8)
    # The trapezoidal rule leaves an error that falls by four from one to the other.
    error = np.abs(fine - coarse).max() / size
    worst = max(float(-fine.min() / size), 0.0)
    tolerance = max(ROUND_OFF, 2 * float(error))
    return (
        worst, tolerance, "the trapezoidal rule with half the increments",
        "no increment of a random path gives back more than is stored" if worst <= tolerance
        else f"an increment gives {worst:.1e} of the largest energy more than was stored: the law makes energy",
    )  # fmt: skip


def rotation(subject: LawSubject) -> Found:
    """Does the traction rotate with the surfaces?

    Args:
        subject: the law.
    """
    gaps, slips = subject.path()
    q, _ = np.linalg.qr(subject.rng.normal(size=(subject.gdim, subject.gdim)))
    q *= np.linalg.det(q)
    dt = subject.length / subject.velocity / STEPS
    plain = subject.start()
    turned = State(
        plain.gap, plain.slip, plain.gap_rate, plain.slip_rate, plain.normal @ q.T, dict(plain.history), plain.fields
    )
    worst = 0.0
    for k in range(1, STEPS):
        plain, found = subject.advanced(plain, gaps[k], slips[k], dt)
        turned, other = subject.advanced(turned, gaps[k], slips[k] @ q.T, dt)
        scale = _scale(found.pressure, found.shear)
        worst = max(worst, float(np.abs(found.pressure - other.pressure).max()) / scale)
        worst = max(worst, float(np.abs(subject.shear(found) @ q.T - subject.shear(other)).max()) / scale)
    return (
        worst, 1e-9, "round-off of a path whose history carries it on",
        "tractions rotate with the surfaces" if worst <= 1e-9
        else f"in rotated surfaces tractions differ by {worst:.1e}: the law refers to a direction of space. Where this "
        "is meant, say isotropic=False",
    )  # fmt: skip


def tangential(subject: LawSubject) -> Found:
    """Is the shear traction along the surface?

    Args:
        subject: the law.
    """
    gaps, slips = subject.path()
    state = subject.start()
    worst = 0.0
    for k in range(1, STEPS):
        state, found = subject.advanced(state, gaps[k], slips[k], subject.length / subject.velocity / STEPS)
        shear = subject.shear(found)
        worst = max(worst, float(np.abs(np.sum(shear * state.normal, axis=1)).max()) / _scale(found.pressure, shear))
    return (
        worst, ROUND_OFF, "round-off",
        "the shear traction is along the surface" if worst <= ROUND_OFF
        else f"the shear traction has a part along the normal, {worst:.1e} of the largest traction, which contact "
        "leaves out",
    )  # fmt: skip


CHECKS: dict[str, Callable[[LawSubject], Found]] = {
    "derivative": derivative,
    "dissipation": dissipation,
    "rotation": rotation,
    "tangential": tangential,
}
