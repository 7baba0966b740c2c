# SPDX-License-Identifier: MIT
"""The command `dolfinx-impact`: verify, compile, demo, creep, joint, study, bench, info."""

import argparse
import contextlib
import difflib
import os
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

from . import compat
from .common.end_with_parent import command_of
from .common.mpi_launcher import mpi_launcher

FORWARDED = {
    "verify": "generated kernels against the hand-written solver (its own options: dolfinx-impact verify --help)",
    "compile": "kernels of a UFL file for a C++ program (its own options: dolfinx-impact compile --help)",
    "creep": "creep curve of a wheel on a rail (its own options: dolfinx-impact creep --help)",
    "joint": "a wheel rolls over an insulated rail joint (its own options: dolfinx-impact joint --help)",
    "study": "a table of rail joints (its own options: dolfinx-impact study --help)",
    "bench": "the benchmarks (its own options: dolfinx-impact bench --help)",
}


def demos() -> dict[str, tuple[Path, str]]:
    """Find the demos and applications of the package.

    Returns:
        File and title by name; the title is the first heading of the file.
    """
    from . import demos as package  # type: ignore[attr-defined,unused-ignore]  # installed beside it

    folder, found = Path(package.__file__).parent, {}
    for path in sorted(folder.glob("*.py")) + sorted(folder.glob("applications/*.py")):
        if not path.name.startswith("_"):
            with open(path, encoding="utf-8") as file:
                first = file.readline()
            found[path.stem] = path, first.lstrip("# ").strip()
    return found


def is_application(path: Path | str) -> bool:
    """Is a file one of demos/applications? An application writes to a RunFolder, a demo to the current folder.

    Args:
        path: file of a demo or an application.

    Returns:
        Whether it is an application.
    """
    return Path(path).parent.name == "applications"


def _listing() -> str:
    lines = {False: ["demos, to copy from:"], True: ["applications:"]}
    for name, (path, title) in demos().items():
        lines[is_application(path)].append(f"  {name:20s} {title}")
    return "\n".join(lines[False] + lines[True])


def _environment(output: str | None) -> dict[str, str]:
    """Environment of a demo's process: output folder, one thread per rank, Open MPI as root and with few cores."""
    env = dict(os.environ)
    env.setdefault("OMP_NUM_THREADS", "1")
    env.setdefault("MPLBACKEND", "Agg")  # pictures go into files
    env.setdefault("OMPI_MCA_rmaps_base_oversubscribe", "1")
    env.setdefault("PRTE_MCA_rmaps_default_mapping_policy", ":oversubscribe")
    if hasattr(os, "geteuid") and os.geteuid() == 0:
        env.setdefault("OMPI_ALLOW_RUN_AS_ROOT", "1")
        env.setdefault("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1")
    libraries = compat.library_folder()
    if libraries is not None:
        env["LD_LIBRARY_PATH"] = os.pathsep.join(filter(None, (str(libraries), env.get("LD_LIBRARY_PATH"))))
    if output:
        env["IMPACT_OUTPUT"] = str(Path(output).absolute())
    return env


def _run(command: Sequence[str], env: Mapping[str, str], folder: Path | None = None) -> int:
    """Run a command in the foreground; returns its exit status, 128 + signal if a signal ended it."""
    sys.stdout.flush()
    with subprocess.Popen(command_of(command), env=env, cwd=folder) as process:
        while True:
            try:
                status = process.wait()
                break
            except KeyboardInterrupt:  # the demo receives it too and ends itself
                continue
    return 128 - status if status < 0 else status


def demo(arguments: argparse.Namespace) -> int:
    """Run one demo in a process of its own.

    Args:
        arguments: parsed arguments of the command `demo`.

    Returns:
        Exit status: that of the demo, or 2 for arguments that cannot be used.
    """
    known = demos()
    if arguments.list:
        print(_listing())
        return 0
    if arguments.name is None:
        print(f"which demo? There are:\n{_listing()}", file=sys.stderr)
        return 2
    if arguments.name not in known:
        near = difflib.get_close_matches(arguments.name, known, 1)
        hint = f" (did you mean {near[0]}?)" if near else ""
        print(f"there is no demo {arguments.name!r}{hint}; there are:\n{_listing()}", file=sys.stderr)
        return 2
    if arguments.ranks < 1:
        print(f"--ranks is {arguments.ranks}: give 1 or more", file=sys.stderr)
        return 2
    path = str(known[arguments.name][0])
    command = [sys.executable, path]
    if arguments.ranks > 1:
        launcher = mpi_launcher()
        if launcher is None:
            print("--ranks needs mpirun, which is not on the PATH (Debian: openmpi-bin)", file=sys.stderr)
            return 2
        # -m mpi4py: an exception on one rank ends all of them
        command = [launcher, "-n", str(arguments.ranks), sys.executable, "-m", "mpi4py", path]
    env = _environment(arguments.output)
    if is_application(path):
        return _run(command, env)
    folder = Path(arguments.output or Path("results", arguments.name))
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        print(f"results cannot be written to {folder}: {error.strerror}; give another --output DIR", file=sys.stderr)
        return 2
    status = _run(command, env, folder)
    if status == 0:
        print(f"results in {folder}")
    return status


def _size(folder: Path | str) -> tuple[int, float]:
    """Number of files in a folder and their size [MB]."""
    sizes = []
    for path in Path(folder).rglob("*") if Path(folder).is_dir() else ():
        with contextlib.suppress(FileNotFoundError):  # a running compiler may remove files of the cache
            if path.is_file():
                sizes.append(path.stat().st_size)
    return len(sizes), sum(sizes) / 1e6


def kernels_by_form() -> dict[str, dict[tuple[str, str], list[int]]]:
    """Kernels that were compiled with the package.

    Returns:
        Degrees of the displacement by form, then by cell and hypothesis.
    """
    from . import _cpp
    from .forms.registry import TABLE

    table: dict[str, dict[tuple[str, str], list[int]]] = {}
    for row in TABLE:
        if _cpp.kernels.find(row.name, row.cell, row.degree, row.geometry_degree, row.hypothesis):
            table.setdefault(row.name, {}).setdefault((row.cell, row.hypothesis), []).append(row.degree)
    return table


def info(arguments: argparse.Namespace) -> int:
    """Print versions, kernels, SIMD width and caches.

    Args:
        arguments: parsed arguments of the command `info`, which has none.

    Returns:
        Exit status 0.
    """
    from . import _cpp, compat
    from .assembly.jit import cache_folder
    from .io.run_folder import versions

    print("versions")
    for name, version in versions().items():
        print(f"  {name:16s} {version}")
    print(f"  tried on DOLFINx {compat.tried()}")
    table = kernels_by_form()
    columns = sorted({key for row in table.values() for key in row}, key=lambda key: (key[1], key[0]))
    count = len(_cpp.kernels.table())
    print(f"\nkernels compiled ahead of time: {count}; degrees of the displacement per form and cell")
    for hypothesis in sorted({h for _, h in columns}):
        cells = [cell for cell, h in columns if h == hypothesis]
        print(f"\n  {hypothesis:26s}" + "".join(f"{cell:>15s}" for cell in cells))
        for name, row in table.items():
            degrees = [" ".join(map(str, row.get((cell, hypothesis), ["-"]))) for cell in cells]
            if any(d != "-" for d in degrees):
                print(f"  {name:26s}" + "".join(f"{d:>15s}" for d in degrees))
    width = _cpp.kernels.processor_width()
    used = sorted({w for kernel in _cpp.kernels.table() for w in kernel.widths})
    print(f"\nSIMD: {width} cells at once on this processor (8: AVX-512, 4: AVX2, 1: none); kernels exist for {used}")
    cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    folders = {
        "kernels compiled at run time": cache_folder(),
        "FFCx (DOLFINx's own)": cache / "fenics",
        "environment (env/run)": os.environ.get("IMPACT_CACHE"),
        "compiler (ccache)": os.environ.get("CCACHE_DIR"),
    }
    print("\ncaches")
    for name, folder in folders.items():
        if folder is None:
            print(f"  {name:30s} not in use")
        elif name.startswith("environment"):
            print(f"  {name:30s} {folder}")  # a whole system: counting it takes too long
        else:
            count, size = _size(folder)
            print(f"  {name:30s} {folder} ({count} files, {size:.1f} MB)")
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser("dolfinx-impact", description="Contact and impact for DOLFINx.")
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)
    for name, text in FORWARDED.items():
        commands.add_parser(name, help=text.partition(" (")[0], add_help=False)
    sub = commands.add_parser("demo", help="run a demo; --list says which there are")
    sub.add_argument("name", nargs="?", metavar="NAME", help="of the demo")
    sub.add_argument("--list", action="store_true", help="list the demos and applications")
    sub.add_argument("--ranks", type=int, default=1, metavar="N", help="number of MPI processes (default 1)")
    sub.add_argument("--output", metavar="DIR", help="folder of the results (default results/NAME)")
    sub.set_defaults(run=demo)
    sub = commands.add_parser("info", help="versions, kernels, SIMD width, caches")
    sub.set_defaults(run=info)
    return parser


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command `dolfinx-impact`.

    Args:
        argv: arguments; None for those of the process.

    Returns:
        Exit status.
    """
    argv = sys.argv[1:] if argv is None else list(argv)
    if argv[:1] == ["verify"]:
        from impact_verify.verify_command import main as verify_main

        return verify_main(argv[1:])
    if argv[:1] == ["compile"]:
        from .compile.compile_command import main as compile_main

        return compile_main(argv[1:])
    if argv[:1] == ["creep"]:
        from impact_studies.creep.creep_command import main as creep_main

        return creep_main(argv[1:])
    if argv[:1] == ["joint"]:
        from impact_studies.rail_joint.joint_command import main as joint_main

        return joint_main(argv[1:])
    if argv[:1] == ["study"]:
        from impact_studies.rail_joint.study import main as study_main

        return study_main(argv[1:])
    if argv[:1] == ["bench"]:
        from impact_studies.bench.bench_command import main as bench_main

        return bench_main(argv[1:])
    arguments = _parser().parse_args(argv)
    return arguments.run(arguments)


if __name__ == "__main__":
    sys.exit(main())
