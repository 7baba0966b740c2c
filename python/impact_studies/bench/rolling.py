# SPDX-License-Identifier: MIT
"""Cost of creep forces in 3D, as a multiple of one static contact solve without friction on the same mesh.

The three start from undeformed bodies whose hub has the displacement that bears the load, with nothing kept from
earlier solves: the static contact; one point of the creep curve; a curve of several points, each found from the one
before. Wall-clock times, one after the other in one process.
"""

import time
from collections.abc import Callable
from functools import partial

import numpy as np
from mpi4py import MPI

from ..creep.model import CreepModel, WheelOnRail
from .rows import Job, Row, row

CELLS = 4  # in each half-axis
LARGE = 6
POINTS = np.linspace(0.0, 3e-3, 13)
POINT = 1e-3
FEW = 4  # points of a curve where time is short
SAME = 1e-4  # of friction times load: the accuracy of the solver, which begins at other states


def rolling_rows(
    cells: int = CELLS, points: int = len(POINTS), reach: float = 5.0, largest: float = POINTS[-1]
) -> list[Row]:
    """Measure one point and a curve.

    Args:
        cells: in each half-axis of the contact.
        points: number of points of the curve.
        reach: size of the bodies in larger half-axes.
        largest: creep up to which points of the curve are found; POINT at least [1].

    Returns:
        Rows.

    Raises:
        RuntimeError: the point and the curve give different forces, or the load is not that of the static solve.
    """
    data = WheelOnRail(cells=cells, reach=reach)
    model = CreepModel(data, comm=MPI.COMM_SELF)
    free = model.problem.omega
    spin = model.wheel
    limit = data.friction * data.load

    def timed(work: Callable[[], float]) -> tuple[float, float]:
        """Time of a function that starts from undeformed bodies, and what it returns."""
        model.u.x.array[:] = 0.0
        start = time.perf_counter()
        value = work()
        return time.perf_counter() - start, value

    def static() -> float:
        problem = model.standing()
        problem.solve()
        force = problem.contact[0].force
        assert force is not None
        return model.sides * float(force[2])

    def point() -> float:
        problem, spin.omega = model.rolling(data.friction), free * (1.0 + POINT)
        problem.solve()
        force = problem.contact[0].force
        assert force is not None
        return model.sides * float(force[0]) / limit

    creeps = POINTS[:: max(1, (len(POINTS) - 1) // (points - 1))]
    creeps = creeps[creeps <= largest]

    def curve() -> float:
        problem, spin.omega = model.rolling(data.friction), free
        found = problem.sweep(creeps, progress=False)
        return model.sides * float(np.interp(POINT, found["creep"], found["force"][:, 0])) / limit

    standing, load = timed(static)
    one, at_point = timed(point)
    many, on_curve = timed(curve)
    if abs(load / data.load - 1.0) > 0.01 or abs(at_point - on_curve) > SAME:
        raise RuntimeError(
            f"the static solve bears {load:.6g} N of {data.load:.6g} N, the point gives {at_point:.4f} and the curve "
            f"{on_curve:.4f}: no timing counts"
        )
    label = f"hexahedron P1, {model.num_unknowns} unknowns"
    return [
        row("creep point / static frictionless solve", label, 1, one, "s", standing),
        row(f"creep curve of {len(creeps)} points / static frictionless solve", label, 1, many, "s", standing),
    ]


def jobs(large: bool) -> list[Job]:
    """Measurements of the command.

    Args:
        large: include a finer mesh.

    Returns:
        A text and a function that returns rows, for each measurement.
    """
    out: list[Job] = [(f"creep curve, {CELLS} cells", partial(rolling_rows, CELLS, FEW))]
    if large:  # no more points of the curve than tell that it has the point
        out.append((f"creep curve, {LARGE} cells", partial(rolling_rows, LARGE, FEW, largest=POINT)))
    return out
