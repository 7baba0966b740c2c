# SPDX-License-Identifier: MIT
"""The command `dolfinx-impact joint`: a wheel rolls over an insulated rail joint."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import Any

from mpi4py import MPI

from dolfinx_impact.assembly.ffcx_form import advice
from .case import Case, UnusableJoint
from .parameters import END_POSTS, PRESETS, RailJoint


def parser() -> argparse.ArgumentParser:
    """Parser of the command."""
    out = argparse.ArgumentParser(
        "dolfinx-impact joint",
        description="A wheel rolls over an insulated rail joint: preload, explicit rolling, unloading, report.",
        epilog="Every parameter of the TOML file can be given as NAME=VALUE, for example speed='160 km/h' gap='6 mm'.",
    )
    out.add_argument("values", nargs="*", metavar="FILE.toml | NAME=VALUE", help="file of parameters, and single ones")
    out.add_argument("--parameters", metavar="FILE", help="file of parameters, whatever its name looks like")
    out.add_argument("--preset", choices=PRESETS, help="mesh (default coarse)")
    out.add_argument("--end-post", choices=END_POSTS, help="material of the end post (default epoxy)")
    out.add_argument("--p2", action="store_true", help="a way that is long enough for the force P2 (takes much longer)")
    out.add_argument("--output", metavar="DIR", help="folder of the results (default results/rail_joint)")
    out.add_argument("--resume", action="store_true", help="go on from the checkpoint in the folder, if there is one")
    out.add_argument("--no-pictures", action="store_true", help="numbers only: no pictures, fields and report")
    out.add_argument("--quiet", action="store_true", help="no progress bars")
    out.add_argument("--template", action="store_true", help="print a TOML file with all parameters, and end")
    return out


def parameters(values: Sequence[str], file: str | None = None, **given: Any) -> RailJoint:
    """Parameters from a file and single values.

    Args:
        values: at most one file, and texts NAME=VALUE.
        file: TOML file; None: one of `values`, or none.
        given: further values by name; None: not given.

    Raises:
        ValueError: an unknown name, a bad value, or a file that cannot be read.
    """
    return RailJoint.from_command_line(values, file, **given)


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command.

    Args:
        argv: arguments; None for those of the process.

    Returns:
        Exit status: 2 for arguments that cannot be used, 1 for a run that fails.
    """
    arguments = parser().parse_args(argv)
    comm = MPI.COMM_WORLD

    def refuse(error: Exception | str, status: int) -> int:
        if comm.rank == 0:
            print(f"dolfinx-impact joint: {error}", flush=True)
        return status

    try:
        data = parameters(arguments.values, arguments.parameters, preset=arguments.preset, end_post=arguments.end_post)
        data = data.for_p2() if arguments.p2 else data
        if arguments.template:
            if comm.rank == 0:
                print(data.to_toml(), end="")
            return 0
        case = Case(data, arguments.output, comm, not arguments.no_pictures, not arguments.quiet, arguments.resume)
    except (ValueError, RuntimeError) as error:
        return refuse(error, 2)
    try:
        case.solve()
    except UnusableJoint as error:
        return refuse(error, 2)
    except TimeoutError as error:
        return refuse(advice(error), 1)
    except RuntimeError as error:  # no equilibrium, an unstable run, a full disk: the text says what to do
        return refuse(error, 1)
    case.run.print(f"results in {case.run.path}")
    return 0


__all__ = ["main", "parameters", "parser"]
