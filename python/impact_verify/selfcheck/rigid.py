# SPDX-License-Identifier: MIT
"""Checks of rigid motions: forces that they cause, balance of forces and moments, frame indifference."""

from __future__ import annotations

import numpy as np

from dolfinx_impact.common.types import FloatArray
from .fields import Field, rotation_matrix, spins
from .subject import ROUND_OFF, ROUND_OFF_REASON, Subject

SHIFT, ANGLE = 0.3, 0.5  # of the block, which has sides of length one [L], [rad]
GROUND = "where this is meant (springs to the ground, a term in the value of u) say grounded=True"


def _without(subject: Subject, check: str) -> bool:
    """Leave a check out where there is no displacement, or where the ground holds the body."""
    if subject.displacement is None:
        subject.leave_out(check, "the unknown is no displacement: rigid motions have no meaning for it")
        return True
    if subject.own.grounded:
        subject.leave_out(check, "grounded=True: the ground takes forces")
        return True
    return False


def _translations(subject: Subject) -> list[tuple[str, FloatArray]]:
    """Unit translations of the displacement: name, and degrees of freedom of the whole space."""
    f = subject.displacement
    assert f is not None
    axes = [1] if subject.axisymmetric else range(subject.gdim)
    return [(f"x[{a}]", subject.of(f, np.tile(np.eye(subject.gdim)[a], (len(f.nodes), 1)))) for a in axes]


def _spins(subject: Subject) -> list[tuple[str, FloatArray, FloatArray]]:
    """Infinitesimal rotations: name, generator, and degrees of freedom (with those of a micro-rotation)."""
    if subject.axisymmetric:
        return []
    f, r = subject.displacement, subject.rotation
    assert f is not None
    out = []
    for name, W in spins(subject.gdim):
        motion = subject.of(f, f.nodes @ W.T)
        if r is not None:
            axis = np.array([1.0]) if subject.gdim == 2 else np.array([W[2, 1], W[0, 2], W[1, 0]])
            motion += subject.of(r, np.tile(axis, (len(r.nodes), 1)))
        out.append((name, W, motion))
    return out


def turned(subject: Subject, values: FloatArray, W: FloatArray) -> FloatArray:
    """Nodal vectors of the displacement multiplied by a matrix; those of other fields are set to zero."""
    f = subject.displacement
    assert f is not None
    return subject.of(f, values[f.dofs].reshape(-1, subject.gdim) @ W.T)


def rotated(subject: Subject, values: FloatArray, R: FloatArray) -> FloatArray:
    """Degrees of freedom after the deformed body is turned about the origin; scalar fields are what they were.

    Args:
        subject: the form.
        values: degrees of freedom before.
        R: rotation.
    """
    f = subject.displacement
    assert f is not None
    out = values.copy()
    out[f.dofs] = ((values[f.dofs].reshape(-1, subject.gdim) + f.nodes) @ R.T - f.nodes).ravel()
    return out


def rest(subject: Subject) -> None:
    """Is the state of rest free of forces?

    Args:
        subject: the form.
    """
    if subject.displacement is None:
        subject.leave_out("rest", "the unknown is no displacement: its state of rest is what the problem says")
        return
    found = subject.size(subject.assembled.vector(subject.rest))
    if subject.own.prestressed:
        subject.leave_out("rest", f"prestressed=True; the forces at rest are {found:.1e} of those of a random state")
        return
    subject.add(
        "rest", found, ROUND_OFF, ROUND_OFF_REASON, "the state of rest is free of forces",
        f"internal forces at rest are {found:.1e} of those of a random state with strains of {subject.own.strain:g}: a "
        "body without loads would not stay as it is. Is a term of the energy missing (-mu ln J), or an invariant not "
        "reduced by its value at rest? Where this is meant say prestressed=True",
    )  # fmt: skip


def translation(subject: Subject) -> None:
    """Does a translation at a random state change the forces?

    Args:
        subject: the form.
    """
    if _without(subject, "translation"):
        return
    found, worst = 0.0, ""
    for name, motion in _translations(subject):
        change = subject.size(subject.assembled.vector(subject.state + SHIFT * motion) - subject.forces)
        if not change <= found:
            found, worst = change, name
    hint = ""
    if subject.gdim == 2 and worst == "x[0]" and not subject.axisymmetric:
        hint = "; if x[0] is the radius of a ring, say hypothesis='axisymmetric'"
    subject.add(
        "translation", found, ROUND_OFF, ROUND_OFF_REASON,
        "translations cause no forces" + (" (along the axis)" if subject.axisymmetric else ""),
        f"a translation by {SHIFT:g} along {worst} changes the forces by {found:.1e} of the largest: something holds "
        f"the body to the ground; {GROUND}{hint}",
    )  # fmt: skip


def rotation(subject: Subject) -> None:
    """Do small rotations from the state of rest cause forces?

    Args:
        subject: the form.
    """
    if _without(subject, "rotation"):
        return
    if subject.axisymmetric:
        subject.leave_out("rotation", "a body of revolution has no rotation in its plane")
        return
    f: Field = subject.displacement  # type: ignore[assignment]  # checked above
    K, forces = subject.assembled.matrix(subject.rest), subject.assembled.vector(subject.rest)
    c = subject.scales()
    found, worst = 0.0, ""
    for name, W, motion in _spins(subject):
        straining = subject.of(f, f.nodes @ abs(W).T)
        caused, size = c * (K @ motion), float(np.linalg.norm(c * (K @ straining)))
        # Forces of prestress turn with the body in finite strain, and stay in small strain.
        left = [float(np.linalg.norm(v)) for v in (caused, caused - c * turned(subject, forces, W))]
        change = min(left) / max(size, 1e-300)
        if not change <= found:
            found, worst = change, name
    subject.add(
        "rotation", found, ROUND_OFF, ROUND_OFF_REASON, "small rotations from rest cause no forces",
        f"a small rotation {worst} causes forces of {found:.1e} of those of a strain of its size: the form strains "
        "bodies that only turn (a gradient that is not symmetrised, a missing transpose?), or something holds the body",
    )  # fmt: skip


def frame(subject: Subject) -> None:
    """Is the form the same for an observer who turns? Says whether it is of small or of finite strain.

    Args:
        subject: the form.
    """
    if _without(subject, "frame indifference"):
        return
    if subject.axisymmetric:
        subject.leave_out("frame indifference", "a body of revolution has no rotation in its plane")
        return
    small, finite, worst = _observers(subject)
    if subject.rotation is None and any(len(f.shape) and f is not subject.displacement for f in subject.fields):
        if small > ROUND_OFF:
            subject.leave_out("frame indifference", "how the other vectors turn with an observer is not known")
            return
    found = min(small, finite)
    good = (
        "finite strain: forces turn with the body in rotations of any size"
        if finite <= small
        else "small strain: rotations cause no forces to first order, and strains of half their square in a body that "
        "turns far"
    )
    subject.add(
        "frame indifference", found, ROUND_OFF, ROUND_OFF_REASON, good,
        f"after a rotation {worst} by {ANGLE:g} rad of a deformed body the forces are not the turned ones (by "
        f"{finite:.1e} of the largest), and a small rotation adds forces (by {small:.1e}): the form is neither of "
        "finite nor of small strain. A nonlinear strain without its quadratic part, a stress that is not turned back, "
        "a missing transpose?",
    )  # fmt: skip


def _observers(subject: Subject) -> tuple[float, float, str]:
    """Largest change of forces for laws of small and of finite strain, and the worst axis."""
    small, finite, worst = 0.0, 0.0, ""
    for name, W, motion in _spins(subject):
        caused = subject.assembled.vector(subject.state + ANGLE * motion) - subject.forces
        small = max(small, subject.size(caused))
        R = rotation_matrix(W, ANGLE)
        after = subject.assembled.vector(rotated(subject, subject.state, R))
        expected = subject.forces.copy()
        f: Field = subject.displacement  # type: ignore[assignment]  # checked by the callers
        expected[f.dofs] = (subject.forces[f.dofs].reshape(-1, subject.gdim) @ R.T).ravel()
        change = subject.size(after - expected)
        if not change <= finite:
            finite, worst = change, name
    return small, finite, worst


def momentum(subject: Subject) -> None:
    """Do internal forces and their moments sum to zero?

    Args:
        subject: the form.
    """
    for check in ("balance of forces", "balance of moments"):
        if _without(subject, check):
            continue
        if check == "balance of moments" and subject.axisymmetric:
            subject.leave_out(check, "a body of revolution has no moment in its plane")
        else:
            _balance(subject, check)


def _balance(subject: Subject, check: str) -> None:
    f = subject.displacement
    assert f is not None
    forces = subject.forces
    nodal = forces[f.dofs].reshape(-1, subject.gdim)
    if check == "balance of forces":
        sums = [(abs(float(forces @ t)) / max(float(np.abs(forces) @ np.abs(t)), 1e-300), n) for n, t in
                _translations(subject)]  # fmt: skip
        found, worst = max(sums)
        subject.add(
            check, found, ROUND_OFF, ROUND_OFF_REASON, "internal forces sum to zero",
            f"internal forces along {worst} sum to {found:.1e} of their size: a body without loads would set itself in "
            f"motion; is the test function only in gradients? {GROUND[0].upper()}{GROUND[1:]}",
        )  # fmt: skip
        return
    deformed = f.nodes + subject.state[f.dofs].reshape(-1, subject.gdim)
    found, worst, about = np.inf, "", ""
    for text, arms in (("undeformed", f.nodes), ("deformed", deformed)):
        moments = []
        for name, W, motion in _spins(subject):
            arm = subject.of(f, arms @ W.T)
            if subject.rotation is not None:
                arm[subject.rotation.dofs] = motion[subject.rotation.dofs]
            size = float(np.abs(nodal).sum() * np.abs(arms).max())
            moments.append((abs(float(forces @ arm)) / max(size, 1e-300), name))
        largest = max(moments)
        if largest[0] < found:
            found, worst, about = *largest, text
    subject.add(
        check, found, ROUND_OFF, ROUND_OFF_REASON, f"moments of internal forces on the {about} body sum to zero",
        f"moments {worst} of internal forces sum to {found:.1e} of their size, on the undeformed as on the deformed "
        "body: the stress is not symmetric (a gradient that is not symmetrised, a missing transpose?), and a body "
        "without loads would begin to turn",
    )  # fmt: skip
