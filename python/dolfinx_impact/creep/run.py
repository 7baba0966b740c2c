# SPDX-License-Identifier: MIT
"""The command `dolfinx-impact creep`: table, HDF5 file and picture of a creep curve."""

from __future__ import annotations

import argparse
import math
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import numpy as np
from mpi4py import MPI

from ..common.types import FloatArray
from ..io.run_folder import RunFolder
from . import figure
from .model import CreepModel, WheelOnRail

UNITS = {"creep": "1", "lateral": "1", "spin": "1/m", "omega": "rad/s", "torque": "N m", "ratio": "1"}


def sequence(text: str) -> FloatArray:
    """Numbers from `first:last:count`, from a list with commas, or one number.

    Args:
        text: as on the command line.

    Returns:
        Numbers, (n).

    Raises:
        argparse.ArgumentTypeError: the text is none of these.
    """
    try:
        if ":" in text:
            first, last, count = text.split(":")
            if int(count) < 1:
                raise ValueError
            values = np.linspace(float(first), float(last), int(count))
        else:
            values = np.array([float(part) for part in text.split(",")])
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r}: a number, numbers with commas, or FIRST:LAST:COUNT") from None
    if not np.all(np.isfinite(values)):
        raise argparse.ArgumentTypeError(f"{text!r}: numbers must be finite")
    return values


def _positive(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not (math.isfinite(value) and value > 0.0):
        raise argparse.ArgumentTypeError(f"{text!r}: a number above zero is needed")
    return value


def parser() -> argparse.ArgumentParser:
    """Parser of the command."""
    out = argparse.ArgumentParser(
        "dolfinx-impact creep", description="Creep forces of a wheel that rolls on a rail, in 3D, with friction."
    )
    default = WheelOnRail()
    number: dict[str, Any] = {"type": _positive, "metavar": "X"}
    out.add_argument("--load", default=default.load, help="wheel load [N] (default %(default)g)", **number)
    out.add_argument("--friction", default=default.friction, help="coefficient [1] (default %(default)g)", **number)
    out.add_argument("--creep", type=sequence, default=sequence("0:3e-3:13"), metavar="FIRST:LAST:COUNT",
                     help="longitudinal creep [1] (default 0:3e-3:13)")  # fmt: skip
    out.add_argument("--lateral", type=sequence, metavar="FIRST:LAST:COUNT", help="lateral creep [1]")
    out.add_argument("--spin", type=sequence, metavar="FIRST:LAST:COUNT", help="spin creep [1/m]")
    out.add_argument("--radius", default=default.radius, help="of the wheel [m] (default %(default)g)", **number)
    out.add_argument("--crown-radius", default=default.crown_radius,
                     help="transverse radius of the rail head [m] (default %(default)g)", **number)  # fmt: skip
    out.add_argument("--wheel-crown-radius", type=float, default=default.wheel_crown_radius, metavar="X",
                     help="transverse radius of the tread [m], negative: hollow (default flat)")  # fmt: skip
    out.add_argument("--speed", default=default.speed, help="of travel [m/s] (default %(default)g)", **number)
    out.add_argument("--cells", type=int, default=default.cells, metavar="N",
                     help="cells in each half-axis of the contact (default %(default)s)")  # fmt: skip
    out.add_argument("--output", metavar="DIR", help="folder of the results (default results/creep)")
    return out


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command.

    Args:
        argv: arguments; None for those of the process.

    Returns:
        Exit status: 2 for arguments that cannot be used.
    """
    given = parser()
    arguments = given.parse_args(argv)
    comm = MPI.COMM_WORLD
    names = ("load", "friction", "radius", "crown_radius", "wheel_crown_radius", "speed", "cells")
    data = WheelOnRail(**{name: getattr(arguments, name) for name in names})
    whole = any(values is not None and np.any(values) for values in (arguments.lateral, arguments.spin))
    run = RunFolder(arguments.output, name="creep", parameters=asdict(data))
    try:
        model = CreepModel(data, whole, comm)
        hertz = model.hertz
        run.print(
            f"{model.num_unknowns} unknowns; by Hertz the contact has the half-axes {1e3 * hertz.a:.3g} mm along and "
            f"{1e3 * hertz.b:.3g} mm across the rail, and a pressure of {1e-6 * hertz.peak_pressure:.4g} MPa; free "
            f"rolling, from which creep counts, is {model.free_creep:+.2e} off speed/radius"
        )
        curve = model.curve(arguments.creep, arguments.lateral, arguments.spin, run.file("points.h5"))
    except ValueError as error:
        run.print(f"dolfinx-impact creep: {error}")
        return 2
    run.print(f"{'creep':>10s} {'lateral':>10s} {'spin [1/m]':>10s} {'Fx [N]':>10s} {'Fy [N]':>10s} {'Fz [N]':>10s} "
              f"{'torque [N m]':>12s} {'T/(f N)':>8s}")  # fmt: skip
    for k in range(len(curve["creep"])):
        fx, fy, fz = curve["force"][k]
        run.print(
            f"{curve['creep'][k]:10.3e} {curve['lateral'][k]:10.3e} {curve['spin'][k]:10.3e} {fx:10.1f} {fy:10.1f} "
            f"{fz:10.1f} {curve['torque'][k]:12.2f} {curve['ratio'][k]:8.4f}"
        )
    columns = {name: (curve[name], unit) for name, unit in UNITS.items()}
    columns |= {f"F{axis}": (curve["force"][:, k], "N") for k, axis in enumerate("xyz")}
    run.table("curve", columns)
    tractions = figure.gather(model)
    run.pictures(lambda: figure.draw(run.file("creep.png"), model, curve, tractions))
    run.print(f"results in {run.path}")
    return 0
