# SPDX-License-Identifier: MIT
"""One-page report of a run in HTML, with its pictures inside the file, and a state file for ParaView."""

from __future__ import annotations

import base64
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from dolfinx_impact.io.hdf5 import write_whole
from dolfinx_impact.io.html_page import write_page
from dolfinx_impact.io.run_folder import versions
from .parameters import RailJoint
from .results import SLOW, Summary


def rows_of(data: RailJoint, summary: Summary) -> list[tuple[str, str, str]]:
    """The numbers a reader asks for first: what, value, unit.

    Args:
        data: the joint.
        summary: numbers of the passage.
    """
    s = summary
    along, across = (f"{1e3 * a:.2f}" for a in s.static_half_axes)
    rows = [
        ("wheel load", f"{data.load / 1e3:.1f}", "kN"),
        ("contact force after the preload, over the load", f"{s.static_force / data.load:.6f}", ""),
        ("mean force before the joint, over the load", f"{s.mean_before:.4f}", ""),
        ("its ripple there", f"{100 * s.ripple_before:.2f}", "%"),
        ("least force, over the load", f"{s.least_force:.3f} at {1e3 * s.least_place:+.1f} mm", ""),
        ("largest force (P1), over the load", f"{s.dynamic_factor:.3f} at {1e3 * s.peak_place:+.1f} mm", ""),
        (
            f"largest force below {SLOW:.0f} Hz behind the joint, over the load",
            f"none: shorter than {1e3 / SLOW:.0f} ms" if math.isnan(s.low_frequency_peak)
            else f"{s.low_frequency_peak:.3f}", "",
        ),
        ("P2, over the load", _p2(data, s), ""),
        ("contact in mid-rail: half-axes along, across", f"{along}, {across}", "mm"),
        ("the same by Hertz", ", ".join(f"{1e3 * a:.2f}" for a in s.hertz_half_axes), "mm"),
        ("largest pressure: mid-rail; Hertz; of the passage",
         f"{s.static_pressure / 1e6:.0f}; {s.hertz_pressure / 1e6:.0f}; {s.peak_pressure / 1e6:.0f}", "MPa"),
        (f"largest equivalent plastic strain (depends on the mesh: {1e3 * data.cell_size:.2f} mm at the edge)",
         f"{100 * s.plastic_strain:.4f}", "%"),
        ("residual stress of the heads: along the rail from, to; von Mises", _residual(s), "MPa"),
        ("largest deflection of the rail ends since the start", f"{1e6 * s.deflection:.1f}", "um"),
        ("second rail end above the first with the wheel on the first", f"{1e6 * s.step:.1f}", "um"),
        ("energy exchanged; part that the balance misses", f"{s.energy_exchanged:.1f} J; {s.energy_missed:.1e}", ""),
        ("cells, ranks, time steps, step", f"{s.cells}, {s.ranks}, {s.steps}, {s.dt * 1e9:.0f} ns", ""),
        ("wall-clock time of rolling", f"{s.seconds:.0f}", "s"),
    ]  # fmt: skip
    return rows


def _p2(data: RailJoint, summary: Summary) -> str:
    """P2, or why there is none."""
    if not math.isnan(summary.p2):
        return f"{summary.p2:.3f}"
    behind, needed = data.end / data.speed, data.p2_period
    return (
        f"none: it takes {1e3 * needed:.1f} ms behind the joint (end = {1e3 * data.speed * needed:.0f} mm, "
        f"joint --p2), the run has {1e3 * behind:.1f} ms"
    )


def _residual(summary: Summary) -> str:
    if math.isnan(summary.residual_von_mises):
        return "not known"
    parts = (summary.residual_compression, summary.residual_tension, summary.residual_von_mises)
    along_from, along_to, von_mises = (f"{1e-6 * value:.0f}" for value in parts)
    return f"{along_from}, {along_to}; {von_mises}"


def text_table(rows: Sequence[tuple[str, str, str]]) -> str:
    """The numbers as text for a terminal.

    Args:
        rows: what, value, unit.
    """
    width = max(len(what) for what, _, _ in rows)
    return "\n".join(f"  {what:{width}s}  {value} {unit}".rstrip() for what, value, unit in rows)


@dataclass
class Picture:
    """A picture inside the file: its kind, its bytes in base 64, its caption."""

    kind: str
    content: str
    caption: str


def _picture(path: Path, caption: str) -> Picture:
    kind = "gif" if path.suffix == ".gif" else "png"
    return Picture(kind, base64.b64encode(path.read_bytes()).decode("ascii"), caption)


def write(
    path: Path,
    data: RailJoint,
    summary: Summary,
    pictures: Mapping[str, str],
    seconds: Mapping[str, float],
    passes: Sequence[Mapping[str, Any]] = (),
) -> None:
    """Write the report; on rank 0.

    Args:
        path: HTML file; pictures are in its folder.
        data: the joint.
        summary: numbers of the last passage.
        pictures: caption by file name; files that do not exist are left out.
        seconds: wall-clock time by stage [s].
        passes: numbers of each passage, if there were several.
    """
    shown = [_picture(path.parent / name, text) for name, text in pictures.items() if (path.parent / name).exists()]
    parameters = []
    for name, value in data.values().items():
        number = f"{value:.6g}" if isinstance(value, float) else str(value) if value != () else "none"
        unit = data.unit_of(name) if value != () else ""
        parameters.append((f"{name}: {data.what_of(name)}", f"{number} {unit}" if unit not in ("", "1") else number))
    several: list[tuple[str, ...]] = []
    if len(passes) > 1:
        several = [("pass", "largest force / load", "plastic strain [%]", "largest pressure [MPa]")]
        several += [
            (str(k + 1), f"{p['dynamic_factor']:.3f}", f"{100 * p['plastic_strain']:.4f}",
             "" if p["peak_pressure"] is None else f"{p['peak_pressure'] / 1e6:.0f}")
            for k, p in enumerate(passes)
        ]  # fmt: skip
    write_page(
        path, "impact_studies.rail_joint", "report.html.jinja",
        title=f"Insulated rail joint: {data.end_post} end post of {1e3 * data.gap:.0f} mm, {3.6 * data.speed:.0f} km/h",
        data=data, results=rows_of(data, summary), passes=several, pictures=shown, parameters=parameters,
        stages=[(name, f"{value:.1f} s") for name, value in seconds.items()], versions=sorted(versions().items()),
    )  # fmt: skip


STATE = """# ParaView (5.12 or newer): File, Load State..., or: paraview --state=paraview_state.py
# The passage around the joint: von Mises stress of the rails near the path, displacements as they are.
import os

from paraview.simple import *

folder = os.path.dirname(os.path.abspath(__file__)) if "__file__" in globals() else os.getcwd()
passage = OpenDataFile(os.path.join(folder, "frames.bp"))
view = GetActiveViewOrCreate("RenderView")
warped = WarpByVector(Input=passage)
warped.Vectors = ["POINTS", "displacement"]
box = Clip(Input=warped)
box.ClipType = "Box"
box.ClipType.Position = [-0.08, -0.0001, -0.05]
box.ClipType.Length = [0.16, 0.06, 0.10]
shown = Show(box, view)
ColorBy(shown, ("POINTS", "von_mises"))
scale = GetColorTransferFunction("von_mises")
scale.RescaleTransferFunction(0.0, 800e6)
shown.SetScalarBarVisibility(view, True)
view.CameraPosition = [-0.14, -0.42, 0.16]
view.CameraFocalPoint = [0.0, 0.01, -0.005]
view.CameraViewUp = [0.0, 0.0, 1.0]
view.CameraParallelProjection = 1
view.CameraParallelScale = 0.06
GetAnimationScene().UpdateAnimationUsingDataTimeSteps()
Render()
"""


def write_state(path: Path) -> None:
    """Write the state file for ParaView; on rank 0.

    Args:
        path: file beside frames.bp.
    """
    write_whole(path, STATE)
