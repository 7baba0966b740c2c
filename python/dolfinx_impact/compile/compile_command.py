# SPDX-License-Identifier: MIT
"""`dolfinx-impact compile`: writes the kernels of a UFL file as C++, for programs that need no Python when they run."""

import argparse
import contextlib
import os
import shlex
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from ..common.end_with_parent import command_of
from ..common.progress_bar import transient_bar
from ..forms.materials import HYPOTHESES
from ..forms.registry import CELLS
from ..io.run_folder import versions
from .choice import Choice
from .file import laws_of
from .kernel_source import source_of_kernels
from .origin import Origin
from .output import output_of
from .own_law import KINDS, OwnLaw
from .text import texts

LIBRARIES = ("dolfinx_impact", "dolfinx", "basix", "ffcx", "ufl")  # that the text of kernels depends on


def parser() -> argparse.ArgumentParser:
    """Parser of the command line.

    Returns:
        Parser.
    """
    p = argparse.ArgumentParser(prog="dolfinx-impact compile", description=__doc__)
    p.add_argument("file", help="a file of your own, of the kind that dolfinx-impact verify takes")
    p.add_argument(
        "name", nargs="?", help="function of a mesh, material or form in the file; without it all that the file has"
    )
    p.add_argument(
        "-o",
        "--output",
        required=True,
        metavar="OUT",
        help="a header (my_law.h) with all in it, or a folder for header and source",
    )
    p.add_argument(
        "--cells", nargs="+", metavar="CELL", help=f"of {', '.join(CELLS)} (default: those of the file, or all)"
    )
    p.add_argument("--degree", nargs="+", type=int, metavar="P", help="of the displacement: 1, 2 or both (default 1)")
    p.add_argument("--geometry-degree", nargs="+", type=int, metavar="P", help="of the mesh: 1, 2 or both (default 1)")
    known = ", ".join(HYPOTHESES)
    p.add_argument(
        "--hypothesis", nargs="+", metavar="H", help=f"of {known} (default: that of the file, or 3d and plane_strain)"
    )
    kinds = ", ".join(KINDS)
    p.add_argument("--kernels", nargs="+", metavar="KIND", help=f"of {kinds} (default: all that there are)")
    return p


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command.

    Args:
        argv: arguments; None for those of the process.

    Returns:
        Exit status: 0 when the files are written, 2 for input that cannot be used.
    """
    given = sys.argv[1:] if argv is None else list(argv)
    args = parser().parse_args(given)
    if sys.flags.hash_randomization:
        # FFCx numbers tables of equal size by hashes, which chance changes: the same file must give the same header.
        command = [sys.executable, "-m", f"{__package__}.compile_command", *given]
        return subprocess.run(command_of(command), env={**os.environ, "PYTHONHASHSEED": "0"}).returncode
    return run(args)


def run(args: argparse.Namespace) -> int:
    """Write the kernels that are asked for, and say which files these are.

    Args:
        args: parsed arguments.

    Returns:
        Exit status: 0 when the files are written, 2 for input that cannot be used.
    """
    try:
        files = write(args)
    except (FileNotFoundError, TypeError, ValueError, RuntimeError) as e:
        print(f"dolfinx-impact compile: {' '.join(str(e).split())}", file=sys.stderr)
        return 2
    print("\n".join(map(str, files)))
    return 0


def write(args: argparse.Namespace) -> list[Path]:
    """Write the kernels that are asked for.

    Args:
        args: parsed arguments.

    Returns:
        The files.

    Raises:
        FileNotFoundError: there is no such file.
        TypeError: a name of the file is no law.
        ValueError: an argument or the file cannot be used, or a form is not supported.
    """
    choice = Choice(args.cells, args.degree, args.geometry_degree, args.hypothesis, args.kernels)
    choice.check()
    if not Path(args.file).is_file():
        raise FileNotFoundError(f"there is no file {args.file}")
    found = versions()
    origin = Origin(Path(args.file).name, _command(args), {name: found.get(name, "unknown") for name in LIBRARIES})
    origin.check()
    output = output_of(args.output, origin.stem)
    output.check()
    laws = list(laws_of(args.file, args.name, choice))
    jobs = [(law, kind) for law in laws for kind in KINDS if kind in law.forms and kind in (choice.kernels or KINDS)]
    _check_kinds(laws, choice)
    _check_values(laws)
    with _progress(2 * len(jobs)) as show:
        kernels = []
        for law, kind in jobs:
            show(law, kind)
            kernels.append(source_of_kernels(law, kind))
        separate = output.source is not None
        header, source = texts(origin, laws, kernels, separate, lambda kernel: show(kernel.law, kernel.kind))
    return output.write(header, source)


@contextlib.contextmanager
def _progress(total: int) -> Iterator[Callable[[OwnLaw, str], None]]:
    """Progress bar on a terminal: function that is called before each part of the work."""
    with transient_bar(True, stderr=True) as bar:
        task = bar.add_task("kernels", total=total)

        def show(law: OwnLaw, kind: str) -> None:
            bar.update(task, description=f"{law.name}.{kind} on {law.case.cell} cells", advance=1)

        yield show


def _check_kinds(laws: Sequence[OwnLaw], choice: Choice) -> None:
    """Refuse kinds of kernels that are asked for and that a law does not have."""
    for law in laws:
        for kind in choice.kernels or ():
            if kind not in law.forms:
                reason = law.missing.get(kind, "it is for laws with internal variables")
                raise ValueError(f"there is no kernel {law.name}.{kind}: {reason}")


def _check_values(laws: Sequence[OwnLaw]) -> None:
    """Refuse constants that have other values on other cells: a program gets one value by name."""
    first: dict[str, OwnLaw] = {}
    for law in laws:
        other = first.setdefault(law.name, law)
        if law.values != other.values:
            raise ValueError(
                f"constants of {law.name} have the values {law.values} on {law.case}, {other.values} on {other.case}: "
                "give them the same ones, or compile them one by one"
            )


def _command(args: argparse.Namespace) -> str:
    """The command as it is written into headers: without folders, which differ between machines."""
    words = ["dolfinx-impact", "compile", Path(args.file).name, *filter(None, [args.name])]
    options = (("--cells", args.cells), ("--degree", args.degree), ("--geometry-degree", args.geometry_degree))
    for option, values in (*options, ("--hypothesis", args.hypothesis), ("--kernels", args.kernels)):
        words += [option, *map(str, values)] if values else []
    return shlex.join([*words, "-o", Path(args.output).name])


if __name__ == "__main__":
    sys.exit(main())
