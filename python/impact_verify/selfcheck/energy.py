# SPDX-License-Identifier: MIT
"""Checks of derivatives: is the residual that of an energy, and the tangent that of the residual?"""

from __future__ import annotations

import numpy as np
import ufl
from dolfinx import fem

from dolfinx_impact.common.types import FloatArray
from .assembled import AssembledForm, quick_form
from .findings import Curve, Picture
from .parts import split_dead_loads
from .subject import ROUND_OFF, ROUND_OFF_REASON, Subject

STEPS = 2.0 ** -np.arange(2, 8)
SLOPE = 0.1  # as at the level "derivative" of cross_check
PATH = 1e-9  # of smooth forces Gauss's rule of 12 points along a path leaves 1e-12 and less


def symmetry(subject: Subject) -> None:
    """Is the tangent symmetric, so that the residual is the derivative of an energy?

    Args:
        subject: the form.
    """
    K = subject.scaled(subject.tangent)
    skew = np.abs(K - K.T)
    at = np.unravel_index(int(np.argmax(skew)), skew.shape)
    found = float(skew[at] / np.abs(K).max())
    if not subject.conservative and not found <= ROUND_OFF:
        text = (
            f"the tangent differs from its transpose by {found:.1e}: the residual has no energy, and none is expected"
        )
        subject.leave_out("symmetry", f"{text}; conservative=True would expect one")
        return
    subject.add(
        "symmetry", found, ROUND_OFF, ROUND_OFF_REASON,
        "the tangent is symmetric at a random state: the residual is the derivative of an energy",
        f"the tangent differs from its transpose by {found:.1e} of its largest entry, most between "
        f"{subject.place(int(at[0]))} and {subject.place(int(at[1]))}: the residual is not the derivative of an "
        "energy, its work depends on the path. Where this is meant (follower loads, friction, flow that is not "
        "associated) say conservative=False",
    )  # fmt: skip


def energy(subject: Subject) -> None:
    """Is the residual the derivative of the energy that is given, or does its work not depend on the path?

    Args:
        subject: the form.
    """
    if subject.own.energy is not None:
        _given_energy(subject)
        return
    if not subject.conservative:
        subject.leave_out("energy", "none is given, and none is expected")
        return
    direct, around, size = _works(subject, 12)
    again = _works(subject, 24)
    # Of laws with kinks (yield) the rule along the path makes an error, which a finer one shows.
    rule = (abs(direct - again[0]) + abs(around - again[1])) / size
    subject.add(
        "energy", abs(around - direct) / size, max(PATH, 10 * rule), "Gauss's rule along the paths",
        f"the work to a random state does not depend on the path: an energy exists, there it is {direct:.6g} above "
        "that of the state of rest (no energy is given to compare with)",
        f"the work to a random state is {direct:.6g} on one path and {around:.6g} on another: there is no energy that "
        "the residual is the derivative of",
    )  # fmt: skip


def _works(subject: Subject, points: int) -> tuple[float, float, float]:
    """Work to the random state on the straight path and around a corner, and the size of its parts."""
    corner = subject.rest + subject.other
    direct, size = _work(subject, subject.rest, subject.state, points)
    first, sizes = _work(subject, subject.rest, corner, points)
    second, more = _work(subject, corner, subject.state, points)
    return direct, first + second, max(size, sizes, more, 1e-300)


def _work(subject: Subject, start: FloatArray, end: FloatArray, count: int) -> tuple[float, float]:
    """Work of the internal forces along a straight path, and the size of its parts."""
    points, weights = np.polynomial.legendre.leggauss(count)
    parts = [
        0.5 * w * float(subject.assembled.vector(start + 0.5 * (1 + s) * (end - start)) @ (end - start))
        for s, w in zip(points, weights)
    ]
    return sum(parts), sum(abs(p) for p in parts)


def _given_energy(subject: Subject) -> None:
    own = subject.own
    assert own.energy is not None
    if own.residual is None:
        subject.leave_out("energy", "a material with internal variables: its energy is not a form")
        return
    v = ufl.TestFunction(subject.space)
    internal, dead = split_dead_loads(own.residual, own.u)
    slope = ufl.derivative(own.energy, own.u, v)
    stored, loads = split_dead_loads(slope, own.u) if slope.integrals() else (slope, None)
    subject.u.x.array[:] = subject.state
    gradient = np.array(fem.assemble_vector(quick_form(stored)).array)
    forces = subject.forces.copy()
    if loads is not None and dead is not None:  # the potential of dead loads is part of the energy
        gradient += fem.assemble_vector(quick_form(loads)).array
        forces += fem.assemble_vector(quick_form(dead)).array
    found = subject.size(forces - gradient) * subject.size(subject.forces) / max(subject.size(gradient), 1e-300)
    c = subject.scales()
    a, b = c * forces, c * gradient
    factor = float(a @ b / max(b @ b, 1e-300))
    rest = float(np.linalg.norm(a - factor * b)) / max(float(np.linalg.norm(b)), 1e-300)
    text = f"the residual differs from the derivative of the given energy by {found:.1e} of its largest entry"
    if rest < ROUND_OFF:
        text = f"the residual is {factor:.6g} times the derivative of the given energy"
        text += ": its sign is wrong" if factor < 0 else ": a factor is wrong or missing in one of them"
    elif found < 1e-2:
        text += "; a difference as small as this is that of two quadrature rules: write the same degree into both"
    subject.add(
        "energy", found, ROUND_OFF, ROUND_OFF_REASON,
        "the residual is the derivative of the given energy", text,
    )  # fmt: skip


def taylor(subject: Subject) -> None:
    """Is the remainder of Taylor's series with the tangent of second order?

    Args:
        subject: the form.
    """
    direction = subject.other
    c = subject.scales()
    slope = subject.tangent @ direction
    remainders = np.array(
        [
            np.linalg.norm(c * (subject.assembled.vector(subject.state + h * direction) - subject.forces - h * slope))
            for h in STEPS
        ]
    )
    scale = float(np.linalg.norm(c * slope))
    whose = "your tangent" if subject.own.tangent is not None else "the tangent"
    if remainders.max() < 1e-11 * scale:
        subject.add(
            "taylor", 0.0, SLOPE, "remainder is round-off", f"the residual is linear, and {whose} is its derivative",
            "",
        )  # fmt: skip
        return
    usable = remainders > 1e-11 * scale
    order = float(np.polyfit(np.log(STEPS[usable]), np.log(remainders[usable]), 1)[0]) if usable.sum() > 1 else np.nan
    subject.picture(
        Picture("Taylor remainder of the tangent", "step [1]", "remainder over first-order term",
                [Curve(STEPS, remainders / scale, f"order {order:.2f}", 2.0)])  # fmt: skip
    )
    whole = "of the first-order term at the smallest step"
    subject.add(
        "taylor", max(2.0 - order, 0.0) if order == order else np.nan, SLOPE, "order over six steps against 2",
        f"the remainder is of order {order:.2f}: {whose} is the derivative of the residual",
        f"the remainder is of order {order:.2f} in place of 2 ({remainders[-1] / scale:.1e} {whole}): {whose} is not "
        "the derivative of the residual, Newton's method will converge slowly or not at all. A part of it is missing "
        "(the geometric one?), taken at another state, or the residual has kinks",
    )  # fmt: skip


def has_form(subject: Subject) -> bool:
    """Whether the form is one of UFL (and no material)."""
    return isinstance(subject.assembled, AssembledForm)
