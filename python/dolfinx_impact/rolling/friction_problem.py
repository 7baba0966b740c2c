# SPDX-License-Identifier: MIT
"""Contact and friction of the nodes of linear bodies, reduced to their multipliers: a dense problem; docs/rolling.md.

The equations of the nodes (Alart and Curnier 1991) are semi-smooth. The method of Levenberg and Marquardt solves them
where it starts near enough. Where it ends at a kink, it starts again from what some iterations of a splitting method
(Lions and Mercier 1979) make of the tractions, which are rough and come from anywhere.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..common.types import BoolArray, FloatArray
from .body_response import Compliance

STILL = 1e-12  # error of the equations, over the largest force, at which they are solved
NEARLY = 1e-10  # and this one, where round-off lets it not become smaller
ITERATIONS = 25  # of Levenberg and Marquardt's method, from one start
# What slip velocities count in the trial tractions, over what makes them as large as changes of traction: more of them
# keep the status of a solution that is nearly right, fewer find one from afar.
KEEPING, FINDING = 10.0, (1.0, 0.1)
SPLITTING = (1e5, 1e4, 1e6, 1e3)  # weights of the splitting method, over the norm of the compliance of velocities
SPLITTINGS = (200, 2000)
NOT_FOUND = "tractions that obey friction were not found"
LEAST_DECREASE = 1e-4
FIRST_DAMPING, LEAST_DAMPING = 1e-6, 1e-13


@dataclass
class State:
    """Bodies at given multipliers, of which all else is a linear function; arrays of the candidates.

    Attributes:
        forces: multipliers as nodal forces, (n, gdim) [F].
        gap: gaps, (n) [L].
        slip: velocities of slave against master, (n, gdim) [L/T].
    """

    forces: FloatArray
    gap: FloatArray
    slip: FloatArray

    def plus(self, factor: float, other: State) -> State:
        """This state and a multiple of another one's gaps and slip velocities."""
        return State(self.forces, self.gap + factor * other.gap, self.slip + factor * other.slip)


@dataclass
class Nodes:
    """Constants of the candidates.

    Attributes:
        frames: normal and tangents as rows, (n, gdim, gdim).
        friction: coefficients, (n).
        carriers: mask of nodes with a multiplier, (n).
        held: mask of normals and tangents along which nothing can move, (n, gdim).
    """

    frames: FloatArray
    friction: FloatArray
    carriers: BoolArray
    held: BoolArray


@dataclass
class _Equations:
    """The equations of the nodes at given forces, in frames.

    Attributes:
        forces: normal and tangential, (n, gdim) [F].
        error: of the equations, (n, gdim) [F].
        active: nodes in contact, (n).
        sliding: nodes that slip, (n).
        direction: of the trial tractions, (n, gdim - 1).
        kappa: friction times pressure over the length of the trial traction, at most 1, (n).
    """

    forces: FloatArray
    error: FloatArray
    active: BoolArray
    sliding: BoolArray
    direction: FloatArray
    kappa: FloatArray

    @property
    def size(self) -> float:
        """Sum of the squares of the errors [F^2]."""
        return float(np.sum(self.error**2))

    def solved(self, tolerance: float) -> bool:
        """Is the largest error below a part of the largest force?"""
        largest = float(np.abs(self.forces).max(initial=0.0))
        return bool(np.abs(self.error).max(initial=0.0) <= tolerance * largest)


class FrictionProblem:
    """Find nodal forces in contact with the law of Coulomb, for bodies that answer linearly.

    Args:
        nodes: constants of the candidates.
        compliance: of the bodies.
    """

    def __init__(self, nodes: Nodes, compliance: Compliance) -> None:
        self._nodes = nodes
        n, gdim = nodes.frames.shape[:2]
        self._n, self._gdim = n, gdim
        F = nodes.frames
        jump = np.einsum("iab,ibjc,jdc->iajd", F, compliance.jump, F, optimize=True)
        velocity = np.einsum("iab,ibjc,jdc->iajd", F, compliance.velocity, F, optimize=True)
        own = np.abs(np.einsum("iaia->ia", jump))
        self._free = nodes.carriers[:, None] & ~nodes.held
        typical = float(own[self._free].mean()) if self._free.any() else 1.0
        self._normal_stiffness = 1.0 / np.where(self._free[:, 0] & (own[:, 0] > 0.0), own[:, 0], typical)
        softness = np.where(own[:, 1:] > 0.0, own[:, 1:], typical).mean(axis=1)
        drift = np.abs(np.einsum("iaia->ia", velocity))[:, 1:].max(axis=1, initial=0.0)
        self._resistance = 1.0 / (softness * (float(np.max(drift / softness, initial=0.0)) or 1.0))
        self._gaps = jump[:, 0].reshape(n, n * gdim)
        self._slips = velocity[:, 1:].reshape(n, gdim - 1, n * gdim)
        self.iterations = 0

    def solve(self, state: State, start: FloatArray | None = None) -> tuple[FloatArray, str]:
        """Forces that obey contact and friction.

        Args:
            state: of the bodies.
            start: forces to start from; None: those of the state, (n, gdim) [F].

        Returns:
            Forces, (n, gdim) [F]; what went wrong, or an empty text.
        """
        turned = [np.einsum("iab,ib->ia", self._nodes.frames, v) for v in (state.forces, state.slip)]
        base = State(turned[0], state.gap, turned[1])
        first = base.forces if start is None else np.einsum("iab,ib->ia", self._nodes.frames, start)
        found, done = self._newton(base, first, KEEPING)
        starts = ((weight, count) for count in SPLITTINGS for weight in SPLITTING)
        while not done:
            weight, count = next(starts, (0.0, 0))
            if not count:
                break
            rough = self._split(base, found, weight, count)
            for caution in FINDING:
                if not done:
                    found, done = self._newton(base, rough, caution)
        return np.einsum("iab,ia->ib", self._nodes.frames, found), "" if done else NOT_FOUND

    def _equations(self, base: State, forces: FloatArray, caution: float) -> _Equations:
        """Equations of all nodes; `base` is in frames, `caution` as KEEPING and FINDING."""
        change, friction = (forces - base.forces).ravel(), self._nodes.friction
        gap = base.gap + self._gaps @ change
        slip = base.slip[:, 1:] + self._slips @ change
        pressure = np.where(self._free[:, 0], forces[:, 0] - self._normal_stiffness * gap, 0.0)
        active, pressure = pressure > 0.0, np.maximum(pressure, 0.0)
        trial = forces[:, 1:] - (caution * self._resistance)[:, None] * slip
        trial = np.where(self._free[:, 1:] & active[:, None], trial, 0.0)
        size, limit = np.linalg.norm(trial, axis=1), friction * pressure
        sliding = active & (size > limit)
        safe = np.where(size > 0.0, size, 1.0)
        kappa = np.where(sliding, limit / safe, 1.0)
        error = forces - np.concatenate([pressure[:, None], kappa[:, None] * trial], axis=1)
        return _Equations(forces, error, active, sliding, trial / safe[:, None], kappa)

    def _newton(self, base: State, forces: FloatArray, caution: float) -> tuple[FloatArray, bool]:
        """Method of Levenberg and Marquardt, without damping where it is not needed; forces and whether they solve."""
        here, damping = self._equations(base, forces, caution), 0.0
        for _ in range(ITERATIONS):
            if here.solved(STILL):
                return here.forces, True
            self.iterations += 1
            matrix, on = self._derivative(here, caution)
            forces = np.where(here.active[:, None], here.forces, 0.0)
            right = -self._equations(base, forces, caution).error[on].ravel()
            better = None
            while better is None and damping < 1.0:
                step = _damped_step(matrix, right, damping)
                if step is not None:
                    trial = forces.copy()
                    trial[on] += step.reshape(-1, self._gdim)
                    found = self._equations(base, trial, caution)
                    better = found if found.size <= (1.0 - LEAST_DECREASE) * here.size else None
                if better is None:
                    damping = max(10.0 * damping, FIRST_DAMPING)
            if better is None:
                return here.forces, here.solved(NEARLY)
            here, damping = better, damping * 0.1 if damping > LEAST_DAMPING else 0.0
        return here.forces, here.solved(NEARLY)

    def _derivative(self, at: _Equations, caution: float) -> tuple[FloatArray, BoolArray]:
        """Derivative of the errors of the active nodes by their forces, and these nodes; (m gdim, m gdim)."""
        gdim, on = self._gdim, np.flatnonzero(at.active)
        m = len(on)
        columns = (gdim * on[:, None] + np.arange(gdim)).ravel()
        own = np.eye(m * gdim).reshape(m, gdim, m * gdim)
        by_gap = self._normal_stiffness[on, None] * self._gaps[np.ix_(on, columns)]
        pressure = own[:, 0] - by_gap
        weight = (caution * self._resistance[on])[:, None, None]
        trial = own[:, 1:] - weight * self._slips[on][:, :, columns]
        trial = np.where(self._free[on, 1:, None], trial, 0.0)
        out = own.copy()
        out[:, 0] = by_gap
        sliding, d = at.sliding[on], at.direction[on]
        along = np.einsum("na,nam->nm", d, trial)
        limited = at.kappa[on, None, None] * (trial - d[:, :, None] * along[:, None])
        limited += self._nodes.friction[on, None, None] * d[:, :, None] * pressure[:, None]
        out[:, 1:] -= np.where(sliding[:, None, None], limited, trial)
        return out.reshape(m * gdim, m * gdim), at.active

    def _split(self, base: State, forces: FloatArray, weight: float, count: int) -> FloatArray:
        """Tractions after some iterations of the splitting method, with the pressures as they are."""
        n, gdim = self._n, self._gdim
        pressed = np.where(self._free[:, 0], np.maximum(forces[:, 0], 0.0), 0.0)
        used = np.flatnonzero((self._free[:, 1:] & (pressed > 0.0)[:, None]).ravel())
        if not len(used):
            return forces
        columns = (gdim * np.arange(n)[:, None] + 1 + np.arange(gdim - 1)).ravel()[used]
        without = np.zeros_like(forces)
        without[:, 0] = pressed
        change = (without - base.forces).ravel()
        slip = (base.slip[:, 1:] + self._slips @ change).ravel()[used]
        A = self._slips.reshape(n * (gdim - 1), -1)[np.ix_(used, columns)]
        size = float(np.linalg.norm(A, 2))
        if size == 0.0:
            return forces
        weight = weight / size
        resolvent = np.linalg.inv(np.eye(len(used)) + weight * A)
        limit, z, out = self._nodes.friction * pressed, forces[:, 1:].ravel()[used], np.zeros((n, gdim - 1))
        for _ in range(count):
            x = resolvent @ (z - weight * slip)
            out.ravel()[used] = 2.0 * x - z
            length = np.linalg.norm(out, axis=1)
            out *= np.minimum(1.0, limit / np.where(length > 0.0, length, 1.0))[:, None]
            z = z + out.ravel()[used] - x
        without[:, 1:] = out
        return without


def _damped_step(matrix: FloatArray, right: FloatArray, damping: float) -> FloatArray | None:
    """Solution of matrix x = right, damped; None where the matrix is singular."""
    if not len(right):  # nothing touches
        return right
    try:
        if damping == 0.0:
            return np.linalg.solve(matrix, right)
        normal = matrix.T @ matrix
        normal[np.diag_indices(len(normal))] += damping * np.trace(normal) / len(normal)
        return np.linalg.solve(normal, matrix.T @ right)
    except np.linalg.LinAlgError:
        return None
