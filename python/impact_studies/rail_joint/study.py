# SPDX-License-Identifier: MIT
"""The command `dolfinx-impact study`: many rail joints in a queue, a table and plots; it goes on after a kill."""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from mpi4py import MPI

from dolfinx_impact.common.end_with_parent import command_of
from dolfinx_impact.common.messages import progress_is_shown
from dolfinx_impact.common.terminal import console
from dolfinx_impact.io import plots
from dolfinx_impact.io.run_folder import RunFolder
from .parameters import END_POSTS, PRESETS, RailJoint, Study
from .joint_command import parameters

# Options of the command: parameter, factor to SI units, unit of bare numbers.
VARIED = {
    "gap": ("gap", 1e-3, "mm"),
    "speed": ("speed", 1 / 3.6, "km/h"),
    "load": ("load", 1e3, "kN"),
}
COLUMNS = (
    ("static_force", "N"), ("least_force", "1"), ("dynamic_factor", "1"), ("peak_place", "m"), ("peak_pressure", "Pa"),
    ("plastic_strain", "1"), ("deflection", "m"), ("step", "m"), ("energy_missed", "1"), ("seconds", "s"),
)  # fmt: skip


@dataclass
class Job:
    """One case of the queue.

    Attributes:
        data: the joint.
        folder: of its results.
        process: while it runs.
        started: when, of `time.perf_counter` [s].
    """

    data: RailJoint
    folder: Path
    process: subprocess.Popen[bytes] | None = None
    started: float = 0.0

    @property
    def summary(self) -> dict[str, Any] | None:
        """Its numbers, None before it is done."""
        with contextlib.suppress(OSError, ValueError, KeyError, TypeError):
            found = json.loads((self.folder / "summary.json").read_text(encoding="utf-8"))
            if found["identity"] == self.data.identity():
                return dict(found["summary"])
        return None

    def start(self) -> None:
        """Start it in a process of its own, from its checkpoint if it has one."""
        self.folder.mkdir(parents=True, exist_ok=True)
        file = self.folder / "case.toml"
        file.write_text(self.data.to_toml(), encoding="utf-8")
        command = [sys.executable, "-m", "dolfinx_impact.cli", "joint", "--parameters", str(file), "--output",
                   str(self.folder), "--resume", "--no-pictures", "--quiet"]  # fmt: skip
        with open(self.folder / "output.txt", "ab") as output:
            self.process = subprocess.Popen(
                command_of(command), stdout=output, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL,
                env={**os.environ, "OMP_NUM_THREADS": "1"},
            )  # fmt: skip
        self.started = time.perf_counter()


def name_of(data: RailJoint) -> str:
    """Name of a case's folder: what is varied, and a checksum of all parameters.

    Args:
        data: the joint.
    """
    checksum = data.identity()[:8]
    return (
        f"{data.end_post}_{1e3 * data.gap:g}mm_{3.6 * data.speed:.4g}kmh_{data.load / 1e3:g}kN_{data.preset}_{checksum}"
    )


def listed(text: str, unit: str = "") -> list[str]:
    """Parts of a text between commas, with a unit where they have none.

    Args:
        text: as on the command line.
        unit: of bare numbers.
    """
    parts = [part.strip() for part in text.split(",")]
    return [f"{part} {unit}" if unit and part[-1:].isdigit() else part for part in parts]


def parser() -> argparse.ArgumentParser:
    """Parser of the command."""
    out = argparse.ArgumentParser(
        "dolfinx-impact study",
        description="All combinations of the given values: a queue of rail joints, a table, plots.",
    )
    out.add_argument("what", choices=["rail_joint"], help="what is studied")
    out.add_argument("values", nargs="*", metavar="FILE.toml | NAME=VALUE", help="parameters of all cases")
    for option, (_, _, unit) in VARIED.items():
        out.add_argument(f"--{option}", metavar="X,Y,...", help=f"values in {unit}, or with units")
    out.add_argument("--end-post", metavar="NAME,...", help=f"of {', '.join(END_POSTS)}")
    out.add_argument("--preset", choices=PRESETS, help="mesh of all cases (default coarse)")
    out.add_argument("--jobs", default=str(max(1, (os.cpu_count() or 1))), metavar="N",
                     help="cases at once (default: number of processors, %(default)s)")  # fmt: skip
    out.add_argument("--output", metavar="DIR", help="folder of the results (default results/study)")
    return out


def study_of(arguments: argparse.Namespace) -> Study:
    """Parameters of a study.

    Args:
        arguments: of the command.

    Raises:
        ValueError: a bad value.
    """
    given: dict[str, Any] = {
        name: tuple(listed(getattr(arguments, name), unit))
        for name, unit in (*((name, unit) for name, (_, _, unit) in VARIED.items()), ("end_post", ""))
        if getattr(arguments, name) is not None
    }
    return Study(**given, jobs=arguments.jobs)


def run_queue(jobs: Sequence[Job], most: int) -> list[str]:
    """Run what is not done yet, some at once, with a progress bar.

    Args:
        jobs: all cases.
        most: cases at once [1].

    Returns:
        Names of cases that failed.
    """
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    waiting = [job for job in jobs if job.summary is None]
    running: list[Job] = []
    failed: list[str] = []
    terminal = console()
    columns = (TextColumn("cases"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), TimeRemainingColumn())
    with Progress(*columns, console=terminal, disable=not progress_is_shown()) as bar:
        task = bar.add_task("", total=len(jobs), completed=len(jobs) - len(waiting))
        try:
            while waiting or running:
                while waiting and len(running) < most:
                    job = waiting.pop(0)
                    job.start()
                    running.append(job)
                time.sleep(0.2)
                for job in [j for j in running if j.process is not None and j.process.poll() is not None]:
                    running.remove(job)
                    found = job.summary
                    took = time.perf_counter() - job.started
                    if found is None:
                        failed.append(job.folder.name)
                        terminal.print(f"{job.folder.name}: failed, see {job.folder / 'output.txt'}")
                    else:
                        terminal.print(f"{job.folder.name}: {found['dynamic_factor']:.3f} times the load, {took:.0f} s")
                    bar.advance(task)
        finally:
            for job in running:
                if job.process is not None:
                    job.process.terminate()
                    job.process.wait()
    return failed


def draw(path: Path, jobs: Sequence[Job]) -> None:
    """Largest forces over what was varied.

    Args:
        path: PNG that is written.
        jobs: cases that are done.
    """
    plt = plots.pyplot()
    axes_of = [
        (name, [factor for _, factor in rows])
        for name, rows in {
            "speed": [("km/h", 3.6)], "gap": [("mm", 1e3)], "load": [("kN", 1e-3)],
        }.items()
        if len({getattr(job.data, name) for job in jobs}) > 1
    ] or [("speed", [3.6])]  # fmt: skip
    units = {"speed": "km/h", "gap": "mm", "load": "kN"}
    figure, all_axes = plt.subplots(1, len(axes_of), figsize=(5.2 * len(axes_of), 4.2), layout="constrained",
                                    squeeze=False, sharey=True)  # fmt: skip
    for axes, (name, (factor,)) in zip(all_axes[0], axes_of):
        others = [n for n in ("end_post", "gap", "speed", "load") if n != name]
        curves: dict[tuple[Any, ...], list[tuple[float, float]]] = {}
        for job in jobs:
            found: Mapping[str, Any] = job.summary or {}
            key = tuple(getattr(job.data, n) for n in others)
            curves.setdefault(key, []).append((factor * getattr(job.data, name), found["dynamic_factor"]))
        varied = [k for k in range(len(others)) if len({key[k] for key in curves}) > 1]
        for key, rows in sorted(curves.items()):
            x, y = np.array(sorted(rows)).T
            label = ", ".join(_shown(others[k], key[k]) for k in varied)
            axes.plot(x, y, "o-", lw=1.2, ms=4, label=label or None)
        axes.set(xlabel=f"{name} [{units[name]}]")
        if varied and len(curves) <= 12:
            axes.legend(fontsize=8)
    all_axes[0, 0].set_ylabel("largest contact force / load [1]")
    plots.save(figure, path)


def _shown(name: str, value: Any) -> str:
    factor, unit = {"speed": (3.6, "km/h"), "gap": (1e3, "mm"), "load": (1e-3, "kN")}.get(name, (1.0, ""))
    return str(value) if name == "end_post" else f"{factor * value:.4g} {unit}"


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command.

    Args:
        argv: arguments; None for those of the process.

    Returns:
        Exit status: 1 if a case failed, 2 for arguments that cannot be used.
    """
    arguments = parser().parse_args(argv)
    if MPI.COMM_WORLD.size > 1:
        print("dolfinx-impact study: runs cases side by side by itself (--jobs); start it without mpirun")
        return 2
    try:
        study = study_of(arguments)
        data = study.cases(parameters(arguments.values, preset=arguments.preset))
        run = RunFolder(arguments.output, name="study", parameters={"cases": len(data)}, alone=True)
    except (ValueError, RuntimeError) as error:
        print(f"dolfinx-impact study: {error}")
        return 2
    with run:
        try:
            return _run(run, data, study.jobs)
        except RuntimeError as error:  # a full disk
            print(f"dolfinx-impact study: {error}")
            return 1


def _run(run: RunFolder, data: Sequence[RailJoint], at_once: int) -> int:
    """All cases, their table and picture; returns the exit status."""
    jobs = [Job(case, run.file(name_of(case))) for case in data]
    done = sum(job.summary is not None for job in jobs)
    run.print(f"{len(jobs)} cases, {done} done already, {at_once} at once; results in {run.path}")
    failed = run_queue(jobs, at_once)
    finished = [job for job in jobs if job.summary is not None]
    if finished:
        _write(run, finished)
    if failed:
        run.print(f"{len(failed)} of {len(jobs)} cases failed: {', '.join(failed)}")
        return 1
    return 0


def _write(run: RunFolder, jobs: Sequence[Job]) -> None:
    """Table and plot of the cases that are done."""
    columns: dict[str, Any] = {
        "end_post_modulus": (np.array([job.data.post.E for job in jobs]), "Pa"),
        "gap": (np.array([job.data.gap for job in jobs]), "m"),
        "speed": (np.array([job.data.speed for job in jobs]), "m/s"),
        "load": (np.array([job.data.load for job in jobs]), "N"),
    }
    for name, unit in COLUMNS:
        columns[name] = np.array([(job.summary or {})[name] for job in jobs], dtype=float), unit
    run.table("study", columns)
    run.pictures(draw, run.file("study.png"), jobs)
    run.print(f"{'end post':>9s} {'gap':>6s} {'speed':>9s} {'load':>7s} {'least':>7s} {'largest':>8s} {'at':>9s}")
    for job in jobs:
        s = job.summary or {}
        run.print(
            f"{job.data.end_post:>9s} {1e3 * job.data.gap:4.1f}mm {3.6 * job.data.speed:5.0f}km/h "
            f"{job.data.load / 1e3:5.0f}kN {s['least_force']:7.3f} {s['dynamic_factor']:8.3f} "
            f"{1e3 * s['peak_place']:+7.1f}mm"
        )
