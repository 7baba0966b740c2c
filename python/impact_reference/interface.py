# SPDX-License-Identifier: MIT
"""Laws of the interface, written point by point as in a textbook: one history of gap and slip after the other.

All laws take a history of one point: gaps, (n), positive if open, and slips in a plane with two axes, (n, 2), which
both begin at zero in the state before the first entry. They return the tractions at the end of each step.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from .array_types import FloatArray


@dataclass
class InterfaceHistory:
    """Tractions of a point along its history.

    Attributes:
        pressure: positive in compression, (n) [F/L^2].
        shear: traction on the slave, (n, 2) [F/L^2].
        energy: stored per area, (n) [F/L].
        state: internal variable after each step, what it is depends on the law.
    """

    pressure: FloatArray
    shear: FloatArray
    energy: FloatArray
    state: list[float] = field(default_factory=list)


def spring_pressure(gap: float, stiffness: float) -> tuple[float, float]:
    """Pressure of a spring that only pushes, and its energy.

    Args:
        gap: gap [L].
        stiffness: pressure per penetration [F/L^3].
    """
    if gap >= 0.0:
        return 0.0, 0.0
    return -stiffness * gap, 0.5 * stiffness * gap * gap


def exponential_pressure(gap: float, pressure: float, clearance: float) -> tuple[float, float]:
    """Exponential pressure-overclosure and its energy, the area under the curve from the gap to the clearance.

    Args:
        gap: gap [L].
        pressure: at zero gap [F/L^2].
        clearance: gap at which the pressure begins [L].
    """
    if gap >= clearance:
        return 0.0, 0.0
    factor = pressure / (float(np.e) - 1.0)

    def curve(at: float) -> float:
        part = (clearance - at) / clearance
        return factor * part * float(np.expm1(part))

    # Gauss's rule of ten points on parts of at most a tenth of the clearance: the curve is an exponential there.
    points, weights = np.polynomial.legendre.leggauss(10)
    parts = max(1, int(np.ceil((clearance - gap) / (0.1 * clearance))))
    ends = np.linspace(gap, clearance, parts + 1)
    area = 0.0
    for a, b in zip(ends[:-1], ends[1:]):
        for x, w in zip(points, weights):
            area += 0.5 * (b - a) * w * curve(0.5 * (a + b) + 0.5 * (b - a) * x)
    return curve(gap), area


def friction_history(
    gaps: FloatArray,
    slips: FloatArray,
    normal: Callable[[float], tuple[float, float]],
    tangential: float,
    coefficient: Callable[[float], float],
    time_step: float,
) -> InterfaceHistory:
    """Coulomb's law by increments: the traction of the last step, less the stiffness times the increment, cut to the
    limit.

    Args:
        gaps: (n) [L].
        slips: (n, 2) [L].
        normal: pressure and energy at a gap.
        tangential: traction per slip of sticking points [F/L^3].
        coefficient: friction coefficient at a slip velocity.
        time_step: length of a step [T].
    """
    out = InterfaceHistory(np.zeros(len(gaps)), np.zeros((len(gaps), 2)), np.zeros(len(gaps)))
    last: FloatArray = np.zeros(2)
    traction: FloatArray = np.zeros(2)
    for i in range(len(gaps)):
        slip: FloatArray = slips[i]
        pressure, stored = normal(float(gaps[i]))
        moved = slip - last
        traction = traction - tangential * moved
        limit = coefficient(float(np.hypot(moved[0], moved[1])) / time_step) * pressure
        size = float(np.hypot(traction[0], traction[1]))
        if size > limit:
            traction = traction * (limit / size) if limit > 0.0 else np.zeros(2)
        last = slip
        out.pressure[i], out.shear[i] = pressure, traction
        out.energy[i] = stored + 0.5 * float(traction @ traction) / tangential
    return out


def cohesive_history(
    gaps: FloatArray,
    slips: FloatArray,
    stiffness: float,
    strengths: tuple[float, float],
    energies: tuple[float, float],
    exponent: float,
) -> InterfaceHistory:
    """Bilinear cohesive zone of mixed mode: the traction is a straight line in the separation, up to the onset, down to
    the end, and back to zero where the bond is unloaded (Camanho and Davila 2002).

    Args:
        gaps: (n) [L].
        slips: (n, 2) [L].
        stiffness: of the bond [F/L^3].
        strengths: in opening and in shear [F/L^2].
        energies: of fracture in opening and in shear [F/L].
        exponent: of the criterion of Benzeggagh and Kenane [1].

    Returns:
        History; its state is the damage.
    """
    out = InterfaceHistory(np.zeros(len(gaps)), np.zeros((len(gaps), 2)), np.zeros(len(gaps)))
    damage = 0.0
    for i in range(len(gaps)):
        gap, slip = float(gaps[i]), slips[i]
        opening, sliding = max(gap, 0.0), float(np.hypot(slip[0], slip[1]))
        separation = float(np.hypot(opening, sliding))
        if separation > 0.0:
            mix = (sliding / separation) ** 2
            blend = mix**exponent if mix > 0.0 else 0.0
            # The energy at the onset, and the energy of fracture, follow the criterion.
            at_onset = [0.5 * t * t / stiffness for t in strengths]
            onset_energy = at_onset[0] + (at_onset[1] - at_onset[0]) * blend
            fracture = energies[0] + (energies[1] - energies[0]) * blend
            onset = float(np.sqrt(2.0 * onset_energy / stiffness))
            end = 2.0 * fracture / (stiffness * onset)
            if separation >= end:
                secant = 0.0
            elif separation > onset:
                secant = stiffness * onset * (end - separation) / (end - onset) / separation
            else:
                secant = stiffness
            damage = max(damage, 1.0 - secant / stiffness)
        held = (1.0 - damage) * stiffness
        overlap = min(gap, 0.0)
        out.pressure[i] = -held * opening - stiffness * overlap
        out.shear[i] = -held * slip
        out.energy[i] = 0.5 * held * separation**2 + 0.5 * stiffness * overlap**2
        out.state.append(damage)
    return out


def adhesive_pressure(gap: float, work: float, distance: float) -> tuple[float, float]:
    """Pressure of surfaces that attract each other, and its energy (Xu and Needleman 1993).

    Args:
        gap: gap [L].
        work: that separates a unit of area [F/L].
        distance: gap of the largest attraction [L].
    """
    y = gap / distance
    decay = float(np.exp(-y))
    return -work / distance * y * decay, -work * decay - work * y * decay


def damped_pressure(gap: float, gap_rate: float, stiffness: float, damping: float) -> tuple[float, float]:
    """Pressure of a spring with a damper that grows with the penetration (Hunt and Crossley 1975), and its energy.

    Args:
        gap: gap [L].
        gap_rate: its rate [L/T].
        stiffness: pressure per penetration [F/L^3].
        damping: [T/L].
    """
    depth, approach = max(-gap, 0.0), -gap_rate
    pressure = stiffness * depth + stiffness * damping * depth * approach
    return max(pressure, 0.0), 0.5 * stiffness * depth * depth
