# SPDX-License-Identifier: MIT
"""Numbers, report and study of rail joints, from made-up runs."""

import json
import re
import subprocess
import sys

import numpy as np
import pytest

from dolfinx_impact.io import plots
from impact_studies.rail_joint import RailJoint, figures, report, study
from impact_studies.rail_joint.passage import ENERGIES, Footprint, History
from impact_studies.rail_joint.results import SLOW, Summary, half_axes, low_pass, summarise

JOINT = RailJoint()


def history(force, joint=JOINT):
    """A passage with a force over the place of the wheel."""
    time = np.linspace(0.0, joint.duration, 2001)
    place = joint.begin + joint.speed * time
    up = joint.load * force(place)
    energy = {name: np.zeros_like(time) for name in ENERGIES}
    energy["internal"], energy["external"] = 2.0 * time / joint.duration, 1.99 * time / joint.duration
    rows = np.column_stack([0.1 * up, 0.0 * up, up])
    return History(time, place, rows, energy, 2000, float(time[1]), 1.0)


def footprint(a=7e-3, b=5e-3, n=60, half=True):
    """The pressure of Hertz on a grid."""
    x, y = np.meshgrid(np.linspace(-a, a, 2 * n + 1), np.linspace(0.0 if half else -b, b, n + 1))
    p = np.sqrt(np.maximum(0.0, 1.0 - (x / a) ** 2 - (y / b) ** 2))
    weight = np.full(x.shape, (a / n) * (b / n if half else 2 * b / n))
    weight[y == y.min()] *= 0.5 if half else 1.0
    on = p > 0.0
    return Footprint(0.0, np.column_stack([x[on], y[on], 0 * x[on]]), 1e9 * p[on], weight[on])


@pytest.mark.parametrize("half", [True, False])
def test_half_axes_of_an_ellipse(half):
    """Cells at the rim count as a whole or not at all: an error of the order of a cell, 1/60."""
    found = half_axes(footprint(half=half), 2 if half else 1)
    assert found == pytest.approx((7e-3, 5e-3), rel=0.02)


def test_numbers_of_a_passage():
    def force(x):
        return 1.0 - 0.2 * np.exp(-((x / 4e-3) ** 2)) + 0.3 * np.exp(-(((x - 15e-3) / 4e-3) ** 2))

    ends = np.array([[-0.035, -1e-4, -1e-4], [-0.004, -2e-4, -1.5e-4], [0.03, -1e-4, -1.2e-4]])
    s = summarise(JOINT, history(force), JOINT.load, footprint(), 1e-3, 100, 2, ends)
    assert s.mean_before == pytest.approx(1.0, abs=1e-3) and s.ripple_before < 1e-3
    assert s.least_force == pytest.approx(0.8, abs=1e-3) and s.least_place == pytest.approx(0.0, abs=1e-4)
    assert s.dynamic_factor == pytest.approx(1.3, abs=1e-3) and s.peak_place == pytest.approx(15e-3, abs=1e-4)
    assert s.peak_force == pytest.approx(1.3 * JOINT.load, rel=1e-3)
    assert s.deflection == pytest.approx(1e-4) and s.step == pytest.approx(5e-5)
    assert s.energy_exchanged == pytest.approx(2.0) and s.energy_missed == pytest.approx(0.005)


def test_numbers_survive_json():
    """Also those that are none, which JSON has no name for."""
    s = summarise(JOINT, history(lambda x: 1.0 + 0.0 * x), JOINT.load, None, 1e-3, 100, 2)
    assert np.isnan(s.static_half_axes).all() and np.isnan(s.p2)
    again = Summary.of_dict(json.loads(json.dumps(s.as_dict(), allow_nan=False)))
    assert repr(again) == repr(s)


def test_low_frequencies():
    """A fast part is taken away, a slow one stays."""
    joint = JOINT.changed(end=0.4)
    fast, slow = 10 * SLOW, 0.2 * SLOW

    def force(x):
        t = (x - joint.begin) / joint.speed
        return 1.0 + 0.1 * np.sin(2 * np.pi * slow * t) + 0.3 * np.sin(2 * np.pi * fast * t)

    run = history(force, joint)
    found = low_pass(run) / joint.load
    inside = slice(500, -500)  # a period and more of the cut-off from the ends
    assert np.abs(found - 1.0 - 0.1 * np.sin(2 * np.pi * slow * run.time))[inside].max() < 1e-3
    assert low_pass(history(force, JOINT.changed(end=0.01))) is None, "shorter than a period"


def test_the_report_holds_pictures_and_numbers(tmp_path):
    s = summarise(JOINT, history(lambda x: 1.0 + 0.2 * (x > 0)), JOINT.load, footprint(), 0.0, 100, 2)
    figure, axes = plots.pyplot().subplots()
    axes.plot([0, 1])
    plots.save(figure, tmp_path / "force.png")
    passes = [s.as_dict(), {**s.as_dict(), "dynamic_factor": 1.4321}]
    report.write(tmp_path / "r.html", JOINT, s, {"force.png": "the <force>", "none.png": ""}, {"rolling": 3.0}, passes)
    text = (tmp_path / "r.html").read_text(encoding="utf-8")
    assert "data:image/png;base64," in text and "the &lt;force&gt;" in text and "none.png" not in text
    assert "120 km/h" in text and "1.4321"[:5] in text and "friction: coefficient" in text and "dolfinx" in text
    report.write_state(tmp_path / "paraview_state.py")
    compile((tmp_path / "paraview_state.py").read_text(encoding="utf-8"), "state", "exec")


def test_picture_of_passages(tmp_path):
    """Each has a point in all three parts; one that adds nothing has none on the logarithmic axis."""
    s = summarise(JOINT, history(lambda x: 1.0 + 0.2 * (x > 0)), JOINT.load, footprint(), 0.0, 100, 2).as_dict()
    rows = [{**s, "plastic_strain": strain} for strain in (1e-3, 1.2e-3, 1.2e-3)]
    plt, drawn = plots.pyplot(), []
    save, plots.save = plots.save, lambda figure, path: drawn.append(figure)
    try:
        figures.passages(tmp_path / "passages.png", rows)
    finally:
        plots.save = save
    points = [axes.lines[0].get_xydata() for axes in drawn[0].axes]
    plt.close(drawn[0])
    assert points[0] == pytest.approx(np.array([[1, 0.1], [2, 0.12], [3, 0.12]]))
    assert points[1] == pytest.approx(np.array([[1, 0.1], [2, 0.02]])) and len(points[2]) == 3


class Quick(study.Job):
    """A case that takes no time, fails where the gap is 7 mm, and counts how often it was started."""

    def start(self):
        self.folder.mkdir(parents=True, exist_ok=True)
        s = summarise(self.data, history(lambda x: 1.0 + 10 * self.data.gap * (x > 0), self.data), self.data.load,
                      footprint(), 0.0, 100, 1)  # fmt: skip
        record = {"identity": self.data.identity(), "parameters": self.data.to_toml(), "summary": s.as_dict()}
        code = f"open({str(self.folder / 'count')!r}, 'a').write('x')\n"
        if round(1e3 * self.data.gap) != 7:
            code += f"open({str(self.folder / 'summary.json')!r}, 'w').write({json.dumps(record)!r})\n"
        self.process = subprocess.Popen([sys.executable, "-c", code])


def test_a_study_goes_on_where_it_was(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(study, "Job", Quick)
    command = ["rail_joint", "--gap", "5,6", "--speed", "80,120", "--end-post", "epoxy,nylon", "--jobs", "2",
               "--output", str(tmp_path)]  # fmt: skip
    assert study.main(command) == 0
    assert "8 cases, 0 done already" in capsys.readouterr().out
    table = (tmp_path / "study.csv").read_text().splitlines()
    assert len(table) == 9 and table[0].startswith("end_post_modulus [Pa],gap [m],speed [m/s]")
    assert (tmp_path / "study.png").stat().st_size > 10_000 and (tmp_path / "study.h5").exists()
    command[2] = "5,6,7"
    assert study.main(command) == 1, "one of the gaps fails"
    said = capsys.readouterr().out
    assert "12 cases, 8 done already" in said and "4 of 12 cases failed" in said and "output.txt" in said
    counts = [len(path.read_text()) for path in tmp_path.glob("*/count")]
    assert counts == [1] * 12, "what was done is not done again"


@pytest.mark.parametrize(
    "arguments, message",
    [
        (["--gap", "0,3"], "gap is '0 mm'|gap is 0.0"), (["--end-post", "oak"], "end_post is 'oak': give one of epoxy"),
        (["--jobs", "0"], "jobs is 0: give a whole number from 1"), (["--speed", "fast"], "speed is 'fast'"),
        (["gap=-3"], "gap is -3.0: give a number from"), (["--load", "100,,130"], "load is ''"),
        (["--gap", ",".join(map(str, range(1, 100))), "--speed", ",".join(map(str, range(1, 200)))], "19701 cases"),
    ],
)  # fmt: skip
def test_bad_options_of_a_study(arguments, message, capsys):
    assert study.main(["rail_joint", *arguments]) == 2
    assert re.search(message, capsys.readouterr().out)


def test_values_of_a_study_may_have_units_and_come_twice():
    arguments = ["rail_joint", "--gap", "5,0.6 mm,5.0", "--load", "1e2", "--jobs=2"]
    given = study.study_of(study.parser().parse_args(arguments))
    cases = given.cases(JOINT)
    assert [round(1e3 * case.gap, 9) for case in cases] == [5.0, 0.6] and cases[0].load == 1e5 and given.jobs == 2


def test_p2_is_told_where_the_way_is_long_enough():
    long = JOINT.for_p2()
    found = [
        summarise(joint, history(lambda x: 1.0 + 0.2 * (x > 0), joint), joint.load, footprint(), 0.0, 100, 2)
        for joint in (JOINT, long)
    ]
    assert np.isnan(found[0].p2) and found[1].p2 == found[1].low_frequency_peak
    told = [dict((what, value) for what, value, _ in report.rows_of(j, s))["P2, over the load"]
            for j, s in zip((JOINT, long), found)]  # fmt: skip
    assert told[0].startswith("none: it takes") and f"end = {1e3 * long.end:.0f} mm" in told[0]
    assert told[1] == f"{found[1].p2:.3f}"


def test_an_animation_keeps_the_hottest_colours(tmp_path, monkeypatch):
    """A few yellow pixels in a large dark picture stay yellow."""
    PIL = pytest.importorskip("PIL.Image")
    colours = np.asarray(plots.pyplot().get_cmap("viridis")(np.linspace(0.0, 1.0, 256)))[:, :3]

    def section(picture, *_):
        image = np.tile((255 * colours[np.arange(200) * 100 // 200]).astype(np.uint8), (100, 1, 1))
        image[40 : 40 + picture.place, 90:93] = np.round(255 * colours[-1])
        image[60:62, 90:93] = np.round(255 * colours[200])
        return image

    monkeypatch.setattr(figures, "section", section)
    figures.animation(tmp_path / "a.gif", JOINT, [figures.Picture(k, None, None) for k in (0, 1, 3)])
    with PIL.open(tmp_path / "a.gif") as animation:
        assert animation.n_frames == 3
        animation.seek(2)
        shown = np.asarray(animation.convert("RGB")).astype(int)
    for place, colour in (((41, 91), colours[-1]), ((61, 91), colours[200]), ((10, 10), colours[5])):
        assert np.abs(shown[place] - 255 * colour).max() < 16, place


def test_units_in_the_report(tmp_path):
    s = summarise(JOINT, history(lambda x: 1.0 + 0.0 * x), JOINT.load, footprint(), 0.0, 100, 2)
    report.write(tmp_path / "r.html", JOINT, s, {}, {})
    text = (tmp_path / "r.html").read_text(encoding="utf-8")
    assert '<td class="number">0.3</td>' in text and '<td class="number">0.008 m</td>' in text
    assert "0.3 1<" not in text and "() m" not in text
