# SPDX-License-Identifier: MIT
"""The command `dolfinx-impact joint`: a wheel rolls over an insulated rail joint."""

from __future__ import annotations

import argparse
import dataclasses
from collections.abc import Sequence
from typing import Any

from mpi4py import MPI

from .case import Case
from .parameters import END_POSTS, PRESETS, RailJoint


def parser() -> argparse.ArgumentParser:
    """Parser of the command."""
    out = argparse.ArgumentParser(
        "dolfinx-impact joint",
        description="A wheel rolls over an insulated rail joint: preload, explicit rolling, unloading, report.",
        epilog="Every parameter of the TOML file can be given as NAME=VALUE, for example speed='160 km/h' gap='6 mm'.",
    )
    out.add_argument("values", nargs="*", metavar="FILE.toml | NAME=VALUE", help="file of parameters, and single ones")
    out.add_argument("--preset", choices=PRESETS, help="mesh (default coarse)")
    out.add_argument("--end-post", choices=END_POSTS, help="material of the end post (default epoxy)")
    out.add_argument("--output", metavar="DIR", help="folder of the results (default results/rail_joint)")
    out.add_argument("--resume", action="store_true", help="go on from the checkpoint in the folder, if there is one")
    out.add_argument("--no-pictures", action="store_true", help="numbers only: no pictures, fields and report")
    out.add_argument("--quiet", action="store_true", help="no progress bars")
    out.add_argument("--template", action="store_true", help="print a TOML file with all parameters, and end")
    return out


def parameters(values: Sequence[str], **given: Any) -> RailJoint:
    """Parameters from a file and single values.

    Args:
        values: at most one file, and texts NAME=VALUE.
        given: further values by name; None: not given.

    Raises:
        ValueError: an unknown name, a bad value, or a file that cannot be read.
    """
    files = [text for text in values if "=" not in text]
    if len(files) > 1:
        raise ValueError(f"more than one file of parameters: {', '.join(files)}")
    data = RailJoint.from_toml(files[0]) if files else RailJoint()
    single: dict[str, Any] = dict(text.split("=", 1) for text in values if "=" in text)
    single |= {name: value for name, value in given.items() if value is not None}
    known = {item.name for item in dataclasses.fields(RailJoint)}
    unknown = sorted(set(single) - known)
    if unknown:
        raise ValueError(f"a RailJoint has no {', '.join(unknown)}; it has {', '.join(sorted(known))}")
    changed = RailJoint.from_mapping(single)
    return data.changed(**{name: getattr(changed, name) for name in single})


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command.

    Args:
        argv: arguments; None for those of the process.

    Returns:
        Exit status: 2 for arguments that cannot be used.
    """
    arguments = parser().parse_args(argv)
    comm = MPI.COMM_WORLD
    try:
        data = parameters(arguments.values, preset=arguments.preset, end_post=arguments.end_post)
        if arguments.template:
            print(data.to_toml(), end="")
            return 0
        case = Case(data, arguments.output, comm, not arguments.no_pictures, not arguments.quiet, arguments.resume)
    except ValueError as error:
        if comm.rank == 0:
            print(f"dolfinx-impact joint: {error}")
        return 2
    case.solve()
    case.run.print(f"results in {case.run.path}")
    return 0


__all__ = ["main", "parameters", "parser"]
