# SPDX-License-Identifier: MIT
"""The command `dolfinx-impact creep`: table, HDF5 file and picture of a creep curve."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from functools import partial

import numpy as np
from mpi4py import MPI

from dolfinx_impact.assembly.ffcx_form import advice
from dolfinx_impact.common.types import FloatArray
from dolfinx_impact.io.run_folder import RunFolder
from . import figure
from .model import CreepModel
from .parameters import WheelOnRail

UNITS = {"creep": "1", "lateral": "1", "spin": "1/m", "omega": "rad/s", "torque": "N m", "ratio": "1"}
MOST_POINTS = 10_000  # of a curve
LARGEST_SPIN = 1000.0  # [1/m]


def sequence(text: str, largest: float = 1.0) -> FloatArray:
    """Numbers from `first:last:count`, from a list with commas, or one number.

    Args:
        text: as on the command line.
        largest: of their absolute values; wheels that slide by more do not roll.

    Returns:
        Numbers, (n).

    Raises:
        argparse.ArgumentTypeError: the text is none of these.
    """
    try:
        if ":" in text:
            first, last, count = text.split(":")
            if not 1 <= int(count) <= MOST_POINTS:
                raise ValueError
            values = np.linspace(float(first), float(last), int(count))
        else:
            values = np.array([float(part) for part in text.split(",")])
    except ValueError:
        raise argparse.ArgumentTypeError(
            f"{text!r}: a number, numbers with commas, or FIRST:LAST:COUNT of at most {MOST_POINTS}"
        ) from None
    if not np.all(np.isfinite(values)):
        raise argparse.ArgumentTypeError(f"{text!r}: numbers must be finite")
    if np.abs(values).max(initial=0.0) > largest:
        raise argparse.ArgumentTypeError(f"{text!r}: numbers from {-largest:g} to {largest:g}")
    return values


def parser() -> argparse.ArgumentParser:
    """Parser of the command."""
    out = argparse.ArgumentParser(
        "dolfinx-impact creep", description="Creep forces of a wheel that rolls on a rail, in 3D, with friction.",
        epilog="Parameters may have units: --load '100 kN'. They can be given as NAME=VALUE and in a TOML file, too.",
    )  # fmt: skip
    out.add_argument("values", nargs="*", metavar="FILE.toml | NAME=VALUE", help="file of parameters, and single ones")
    default = WheelOnRail()
    for name, value in default.values().items():
        text = f"{default.what_of(name)}; {default.expected(name)} (default {value:g})".replace("%", "%%")
        out.add_argument(f"--{name.replace('_', '-')}", dest=name, metavar="X", help=text)
    out.add_argument("--creep", type=sequence, default=sequence("0:3e-3:13"), metavar="FIRST:LAST:COUNT",
                     help="longitudinal creep [1] (default 0:3e-3:13)")  # fmt: skip
    out.add_argument("--lateral", type=sequence, metavar="FIRST:LAST:COUNT", help="lateral creep [1]")
    out.add_argument("--spin", type=partial(sequence, largest=LARGEST_SPIN), metavar="FIRST:LAST:COUNT",
                     help="spin creep [1/m]")  # fmt: skip
    out.add_argument("--output", metavar="DIR", help="folder of the results (default results/creep)")
    out.add_argument("--template", action="store_true", help="print a TOML file with all parameters, and end")
    return out


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command.

    Args:
        argv: arguments; None for those of the process.

    Returns:
        Exit status: 2 for arguments that cannot be used, 1 for a run that fails.
    """
    arguments = parser().parse_args(argv)
    comm = MPI.COMM_WORLD
    try:
        given = {name: getattr(arguments, name) for name in WheelOnRail.model_fields}
        data = WheelOnRail.from_command_line(arguments.values, **given)
        if arguments.template:
            if comm.rank == 0:
                print(data.to_toml(), end="")
            return 0
        run = RunFolder(arguments.output, name="creep", alone=True)
    except (ValueError, RuntimeError) as error:
        if comm.rank == 0:
            print(f"dolfinx-impact creep: {error}", flush=True)
        return 2
    with run:
        try:
            return _run(run, data, arguments)
        except ValueError as error:
            run.print(f"dolfinx-impact creep: {error}")
            return 2
        except TimeoutError as error:
            run.print(f"dolfinx-impact creep: {advice(error)}")
            return 1
        except RuntimeError as error:  # no equilibrium, a damaged file of points, a full disk: the text says what to do
            run.print(f"dolfinx-impact creep: {error}")
            return 1


def _run(run: RunFolder, data: WheelOnRail, arguments: argparse.Namespace) -> int:
    """The curve, its table and picture; returns the exit status."""
    whole = any(values is not None and np.any(values) for values in (arguments.lateral, arguments.spin))
    model = CreepModel(data, whole, run.comm)
    hertz = model.hertz
    run.print(
        f"{model.num_unknowns} unknowns; by Hertz the contact has the half-axes {1e3 * hertz.a:.3g} mm along and "
        f"{1e3 * hertz.b:.3g} mm across the rail, and a pressure of {1e-6 * hertz.peak_pressure:.4g} MPa; free "
        f"rolling, from which creep counts, is {model.free_creep:+.2e} off speed/radius"
    )
    curve = model.curve(arguments.creep, arguments.lateral, arguments.spin, run.file("points.h5"))
    run.write_parameters(data.values())  # only now: the points of another wheel, with its parameters, are refused
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
