# SPDX-License-Identifier: MIT
"""Picture of a creep curve, and of stick, slip and tractions in the contact."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from dolfinx_impact.common.types import FilePath, FloatArray, IntArray
from dolfinx_impact.contact import ContactStatus
from dolfinx_impact.io import plots
from .model import CreepModel


@dataclass
class Tractions:
    """Nodes in contact of all ranks.

    Attributes:
        points: (n, 3) [m].
        traction: on the wheel, (n, 3) [Pa].
        status: ContactStatus, (n).
    """

    points: FloatArray
    traction: FloatArray
    status: IntArray


def gather(model: CreepModel) -> Tractions | None:
    """Nodes in contact in the last state, on rank 0; None on others. Collective.

    Args:
        model: solved model.
    """
    contact = model.contact
    on = contact.status != ContactStatus.open
    rows = contact.comm.gather((contact.points[on], contact.friction_traction[on], contact.status[on]))
    if rows is None:
        return None
    return Tractions(*(np.concatenate(column) for column in zip(*rows)))


def draw_contact(axes: Any, model: CreepModel, tractions: Tractions) -> None:
    """Draw areas of stick and slip, and the tractions as arrows.

    Args:
        axes: of matplotlib.
        model: solved model.
        tractions: of the nodes in contact.
    """
    x, y = 1e3 * tractions.points[:, 0], 1e3 * tractions.points[:, 1]
    t, status, hertz = tractions.traction, tractions.status, model.hertz
    if model.sides == 2:  # the other half
        off = y > 1e-6
        x, y = np.concatenate([x, x[off]]), np.concatenate([y, -y[off]])
        t = np.concatenate([t, t[off] * (1.0, -1.0, 1.0)])
        status = np.concatenate([status, status[off]])
    for kind, color, name in ((ContactStatus.stick, "C0", "stick"), (ContactStatus.slip, "C3", "slip")):
        at = status == kind
        axes.plot(x[at], y[at], "o", color=color, markersize=3, label=name)
    largest = float(np.linalg.norm(t, axis=1).max(initial=0.0)) or 1.0
    spacing = 1e3 * hertz.a / model.data.cells
    axes.quiver(x, y, t[:, 0], t[:, 1], angles="xy", scale_units="xy", scale=largest / (1.6 * spacing), width=0.004)
    angle = np.linspace(0.0, 2.0 * np.pi, 200)
    axes.plot(1e3 * hertz.a * np.cos(angle), 1e3 * hertz.b * np.sin(angle), "k:", label="ellipse of Hertz")
    axes.set(xlabel="x [mm], the wheel travels to the right", ylabel="y [mm]", aspect="equal")
    axes.set_title("tractions on the wheel, last point")
    axes.set_xlim(-1.7 * 1e3 * hertz.a, 1.7 * 1e3 * hertz.a)
    # Outside of the axes: how high they are depends on the shape of the contact.
    axes.figure.legend(*axes.get_legend_handles_labels(), loc="outside lower right", ncols=3, fontsize=8)


def draw(file: FilePath, model: CreepModel, curve: Mapping[str, FloatArray], tractions: Tractions | None) -> None:
    """Draw the curve and the contact of its last point. Called on rank 0.

    Args:
        file: PNG that is written.
        model: solved model.
        curve: as CreepModel.curve returns it.
        tractions: of the nodes in contact.
    """
    assert tractions is not None
    plt = plots.pyplot()
    picture, (left, right) = plt.subplots(1, 2, figsize=(10.5, 4.4), layout="constrained")
    varied = max(("creep", "lateral", "spin"), key=lambda name: float(np.ptp(curve[name])))
    unit = "1/m" if varied == "spin" else "1e-3"
    names = {"creep": "longitudinal creep", "lateral": "lateral creep", "spin": "spin creep"}
    along = curve[varied] * (1.0 if varied == "spin" else 1e3)
    limit = model.data.friction * curve["force"][:, 2]
    for k, name in ((0, "longitudinal"), (1, "lateral")):
        if k == 0 or model.sides == 1:
            left.plot(along, curve["force"][:, k] / limit, "o-", label=name)
    left.set(xlabel=f"{names[varied]} [{unit}]", ylabel="force over friction times load [1]")
    left.grid(alpha=0.3)
    left.legend()
    draw_contact(right, model, tractions)
    plots.save(picture, file)
