# SPDX-License-Identifier: MIT
"""In pictures no text lies on another one, none is cut off, and axes have units; drawn from made-up results."""

import types

import numpy as np
import pytest
from figure_texts import figures, overlaps, without_unit

from dolfinx_impact.contact import ContactStatus
from impact_studies.creep import figure as creep
from impact_studies.creep.model import WheelOnRail
from dolfinx_impact.demos.applications.figures import methods
from dolfinx_impact.demos.applications.models.impacts import CASES, Result
from dolfinx_impact.io import plots
from impact_studies.rail_joint import RailJoint
from impact_studies.rail_joint import figures as joint
from impact_studies.rail_joint.passage import ENERGIES, History

JOINT = RailJoint()
TIME = np.linspace(0.0, JOINT.duration, 400)
PLACE = JOINT.begin + JOINT.speed * TIME
RUN = types.SimpleNamespace(file=lambda name: name)


def creep_curve(varied, crown, sides):
    """Curve and contact of a long, a round or a wide contact: how high its axes are differs."""
    data = WheelOnRail(crown_radius=crown)
    hertz = data.hertz
    x, y = (g.ravel() for g in np.meshgrid(np.linspace(-1, 1, 9), np.linspace(-1, 1, 9)))
    inside = x**2 + y**2 < 1
    points = np.column_stack([hertz.a * x, hertz.b * y, 0 * x])[inside]
    status = np.where(points[:, 0] > 0, ContactStatus.stick, ContactStatus.slip)
    curve = {name: np.zeros(5) for name in ("creep", "lateral", "spin")}
    curve[varied] = np.linspace(0.0, 3e-3, 5)
    curve["force"] = np.column_stack([np.linspace(0, 3e4, 5), np.zeros(5), np.full(5, 1e5)])
    model = types.SimpleNamespace(data=data, hertz=hertz, sides=sides)
    creep.draw("creep.png", model, curve, creep.Tractions(points, np.tile((1e8, 1e7, 0.0), (len(points), 1)), status))


def implicit_or_explicit():
    names = ("central differences, penalty", "central differences, kinematic", "Newmark", "generalised-alpha")
    results = {
        (case, name): [Result(0.1 / n * (k + 1), 0.01 * n, n, np.linspace(0, 1, 9), np.ones(9)) for n in (1, 2, 4)]
        for case in CASES
        for k, name in enumerate(names)
    }
    methods.work_and_error(RUN, CASES, names, results)


def waves(scale=0.02):
    stations = np.array((0.1, 0.25, 0.4))
    delay = TIME[:, None] - stations / 3000.0
    joint.waves("waves.png", JOINT, TIME, stations, -scale * np.exp(-(((delay - 5e-4) / 1e-4) ** 2)))


def history():
    force = np.column_stack([0 * PLACE, 0 * PLACE, 1.0 + 0.2 * np.exp(-((PLACE / 4e-3) ** 2))]) * JOINT.load
    energy = {name: np.sin(3 * TIME / JOINT.duration + k) for k, name in enumerate(ENERGIES)}
    return History(TIME, PLACE, force, energy, 400, 1e-6, 1.0)


DRAWN = {
    "creep, long": lambda: creep_curve("creep", 2.0, 2),
    "creep, round": lambda: creep_curve("lateral", 0.46, 1),
    "creep, wide": lambda: creep_curve("spin", 0.08, 1),
    "implicit_or_explicit": implicit_or_explicit,
    "waves": waves,
    "waves, weak": lambda: waves(3e-7),
    "rail ends": lambda: joint.rail_ends("ends.png", JOINT, np.column_stack([PLACE, 0.0 * PLACE, -1e-3 * PLACE])),
    "energies": lambda: joint.energies("energy.png", JOINT, history()),
    "passages": lambda: joint.passages(
        "passages.png",
        [{"plastic_strain": 1e-3 * (1.0 - 0.5**k), "dynamic_factor": 1.13 + 0.001 * k} for k in range(1, 6)],
    ),
}


@pytest.mark.parametrize("name", DRAWN)
def test_texts_keep_off_each_other_and_axes_have_units(name):
    with figures() as drawn:
        DRAWN[name]()
        assert len(drawn) == 1
        assert overlaps(drawn[0]) == []
        assert without_unit(drawn[0]) == []


def test_waves_have_a_scale_and_their_arrivals():
    """The lines begin where the first station is lowest, and pass the others later, by their distance over a speed."""
    with figures() as drawn:
        waves()
        axes = drawn[0].axes[0]
        assert "mm/s" in axes.get_title() and "time [ms]" == axes.get_xlabel()
        found = {line.get_label(): line.get_xdata() for line in axes.lines if "m/s" in str(line.get_label())}
        lowest = TIME[np.abs(TIME - 5e-4 - 0.1 / 3000.0).argmin()] * 1e3
        assert len(found) == 2
        for label, x in found.items():
            speed = float(label.split()[-2])
            assert x == pytest.approx(lowest + np.array((0.0, 0.15, 0.3)) / speed * 1e3, rel=1e-4)


def test_bad_figures_are_seen():
    plt = plots.pyplot()
    figure, (left, right) = plt.subplots(1, 2, figsize=(5, 3))
    left.set(xlabel="time", ylabel="force [N]")
    right.set_ylabel("a label that is longer than its axes are high: it is cut off [N]")
    left.text(0.5, 0.5, "one", transform=left.transAxes)
    left.text(0.5, 0.5, "other", transform=left.transAxes)
    pairs = overlaps(figure)
    assert ("other", "one") in pairs and any(rim == "the rim" for _, rim in pairs)
    assert without_unit(figure) == ["time"]
    plt.close(figure)
