# SPDX-License-Identifier: MIT
"""What a passage over a rail joint shows, in numbers."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from scipy.signal import butter, sosfiltfilt

from dolfinx_impact.common.types import FloatArray
from .parameters import RailJoint
from .passage import Footprint, History

# Above the resonance of the unsprung mass on the track, some 30 to 100 Hz, and below that of the wheel on the contact,
# which makes P1, some 200 to 1000 Hz: what is slower than this [Hz].
SLOW = 500.0
QUIET = 1.0  # half-axes of the contact and more before the rail end: not yet the joint


@dataclass(frozen=True)
class Summary:
    """Numbers of a passage; forces are those of both sides of the rail.

    Attributes:
        static_force: after the preload [N].
        mean_before: mean force on the way to the joint over the static one; nan where the way begins at the joint [1].
        ripple_before: largest deviation of the force from its mean there, over the mean [1].
        least_force: over the static one [1].
        least_place: where it is least [m].
        dynamic_factor: largest force behind the joint's middle over the static one [1].
        peak_force: that force, as the P1 force of the literature [N].
        peak_place: where [m].
        low_frequency_peak: largest force below SLOW behind the joint's middle, over the static one; nan where the run
            is shorter than a period of it [1].
        p2: the same as the P2 force of the literature, over the static one; nan where the way behind the joint is
            shorter than a period of the wheel on the track (RailJoint.shows_p2) [1].
        hertz_pressure: largest pressure by Hertz [Pa].
        static_pressure: largest nodal pressure of the preload [Pa].
        hertz_half_axes: along and across the rail [m].
        static_half_axes: the same of the preload, from the area in contact and its ratio of extents [m].
        peak_pressure: largest nodal pressure of all footprints [Pa].
        plastic_strain: largest equivalent one of all points of quadrature; at the edge of the rail it grows without
            limit as cells get smaller [1].
        deflection: largest deflection of the rail ends below that at the start [m].
        step: difference of the heights of the rail ends when the wheel is on the first one's edge [m].
        steps: number of time steps [1].
        dt: the step [s].
        seconds: wall-clock time of rolling [s].
        cells: [1].
        ranks: [1].
        energy_exchanged: largest change of an energy [J].
        energy_missed: by the balance, over the energy exchanged [1].
        residual_tension: largest residual stress along the rail in its heads, averaged at nodes, without a wheel;
            nan before the wheel is lifted off [Pa].
        residual_compression: least one, negative in compression [Pa].
        residual_von_mises: largest von Mises stress of the residual stress there [Pa].
    """

    static_force: float
    mean_before: float
    ripple_before: float
    least_force: float
    least_place: float
    dynamic_factor: float
    peak_force: float
    peak_place: float
    low_frequency_peak: float
    p2: float
    hertz_pressure: float
    static_pressure: float
    hertz_half_axes: tuple[float, float]
    static_half_axes: tuple[float, float]
    peak_pressure: float
    plastic_strain: float
    deflection: float
    step: float
    steps: int
    dt: float
    seconds: float
    cells: int
    ranks: int
    energy_exchanged: float
    energy_missed: float
    residual_tension: float = math.nan
    residual_compression: float = math.nan
    residual_von_mises: float = math.nan

    def as_dict(self) -> dict[str, Any]:
        """Numbers by name, for JSON, which has no name for what is not a number: None."""

        def plain(value: Any) -> Any:
            return [plain(part) for part in value] if isinstance(value, tuple) else None if value != value else value

        return {name: plain(value) for name, value in asdict(self).items()}

    @classmethod
    def of_dict(cls, values: Mapping[str, Any]) -> Summary:
        """The summary whose `as_dict` these are.

        Args:
            values: numbers by name.

        Raises:
            TypeError: names are missing, or there are others.
        """

        def number(value: Any) -> Any:
            return tuple(map(number, value)) if isinstance(value, list) else math.nan if value is None else value

        return cls(**{name: number(value) for name, value in values.items()})


def low_pass(history: History, frequency: float = SLOW) -> FloatArray | None:
    """Vertical force without what is faster than a frequency; None if the passage is shorter than its period.

    Butterworth's filter of fourth order, run forward and backward, so that nothing is delayed.

    Args:
        history: of the passage.
        frequency: cut-off [Hz].
    """
    t = history.time
    if len(t) < 30 or (t[-1] - t[0]) * frequency < 1.0:
        return None
    even = np.linspace(t[0], t[-1], min(len(t), 4000))
    force = np.interp(even, t, history.force[:, 2])
    filtered = sosfiltfilt(butter(4, frequency, fs=1.0 / (even[1] - even[0]), output="sos"), force)
    return np.interp(t, even, filtered)


def half_axes(found: Footprint | None, sides: int) -> tuple[float, float]:
    """Half-axes of an ellipse with the area and the proportions of a footprint [m].

    Args:
        found: nodes in contact.
        sides: 2 if one half is computed.
    """
    if found is None or len(found.points) < 3:
        return math.nan, math.nan
    area = sides * float(found.weight.sum())
    load = found.weight * found.pressure
    middle = np.average(found.points[:, 0], weights=load)
    across = 0.0 if sides == 2 else np.average(found.points[:, 1], weights=load)
    # Second moments of an elliptic pressure are proportional to the squares of the half-axes.
    along2 = np.average((found.points[:, 0] - middle) ** 2, weights=load)
    across2 = np.average((found.points[:, 1] - across) ** 2, weights=load)
    ratio = math.sqrt(along2 / across2)
    b = math.sqrt(area / (math.pi * ratio))
    return ratio * b, b


def before_joint(data: RailJoint, place: FloatArray) -> Any:
    """Mask of places where the contact is not yet at the joint.

    Args:
        data: the joint.
        place: of the wheel [m].
    """
    return place < -0.5 * data.gap - (1.0 + QUIET) * data.hertz.a


def summarise(
    data: RailJoint,
    history: History,
    static_force: float,
    static_footprint: Footprint | None,
    plastic_strain: float,
    cells: int,
    ranks: int,
    ends: FloatArray | None = None,
) -> Summary:
    """Numbers of a passage; on rank 0.

    Args:
        data: the joint.
        history: of the passage.
        static_force: of the preload [N].
        static_footprint: of the preload.
        plastic_strain: largest equivalent one [1].
        cells: of the mesh.
        ranks: of the run.
        ends: place of the wheel and vertical displacements of the two rail ends, (n, 3) [m]; None: not recorded.
    """
    force, place = history.force[:, 2] / data.load, history.place
    quiet = before_joint(data, place)
    before = force[quiet] if np.any(quiet) else np.full(1, math.nan)
    behind = place > 0.0
    near = np.abs(place) < 0.5 * data.gap + 2 * data.hertz.a
    peak, least = np.flatnonzero(behind)[force[behind].argmax()], np.flatnonzero(near)[force[near].argmin()]
    slow = low_pass(history)
    changes = {name: values - values[0] for name, values in history.energy.items()}
    balance = sum(values for name, values in changes.items() if name != "external") - changes["external"]
    exchanged = max(float(np.abs(values).max()) for values in changes.values())
    deflection = step = math.nan
    if ends is not None and len(ends):
        deflection = float(-(ends[:, 1:] - ends[0, 1:]).min())
        at_edge = np.abs(ends[:, 0] + 0.5 * data.gap).argmin()
        step = float(ends[at_edge, 2] - ends[at_edge, 1])
    pressures = [float(f.pressure.max(initial=0.0)) for f in history.footprints]
    hertz = data.hertz
    slow_peak = math.nan if slow is None else float(slow[behind].max()) / data.load
    return Summary(
        static_force, float(before.mean()), float(np.abs(before / before.mean() - 1.0).max()), float(force[least]),
        float(place[least]), float(force[peak]), float(force[peak]) * data.load, float(place[peak]),
        slow_peak, slow_peak if data.shows_p2 else math.nan, hertz.peak_pressure,
        math.nan if static_footprint is None else float(static_footprint.pressure.max()), (hertz.a, hertz.b),
        half_axes(static_footprint, data.sides), max(pressures, default=math.nan), plastic_strain, deflection, step,
        history.steps, history.dt, history.seconds, cells, ranks, exchanged, float(np.abs(balance).max()) / exchanged,
    )  # fmt: skip
