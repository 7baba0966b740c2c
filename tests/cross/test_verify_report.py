# SPDX-License-Identifier: MIT
"""Rows and reports: what passes, what never does, and what is written to JSON."""

import json

import numpy as np
import pytest

from dolfinx_impact import compat
from dolfinx_impact.own_forms import distorted_block
from impact_verify import differences, html, matched_body
from impact_verify.report import Report, Row

ELEMENT = ("hexahedron", 1, 1, "3d")


def row(difference, tolerance=1e-12):
    return Row("element", "mass", *ELEMENT, difference, tolerance, "round-off", "element tensor", "node 3")


@pytest.mark.parametrize(
    "difference, tolerance, passed",
    [
        (0.0, 0.0, True),
        (1e-12, 1e-12, True),
        (np.nextafter(1e-12, 1), 1e-12, False),
        (np.nan, 1e-12, False),
        (np.nan, np.inf, False),
        (np.inf, 1e300, False),
        (0.0, np.nan, False),
        (np.float64(0.5), 1, True),
    ],
)
def test_a_row_passes_only_within_its_tolerance(difference, tolerance, passed):
    assert row(difference, tolerance).passed is passed


def test_an_empty_report_does_not_pass():
    report = Report()
    assert report.passed is False and report.failures() == [] and report.summary() == []


def test_one_bad_row_among_many_fails_the_report():
    report = Report()
    report.rows += [row(0.0) for _ in range(50)] + [row(np.nan)]
    assert not report.passed and len(report.failures()) == 1


@pytest.mark.parametrize("bad", [np.nan, 1e-3, np.inf])
@pytest.mark.parametrize("place", [0, 1, 2])
def test_the_summary_shows_the_worst_row(bad, place):
    report = Report()
    report.rows += [row(1e-13), row(1e-14)]
    report.rows.insert(place, row(bad))
    ((level, form, count, worst),) = report.summary()
    assert (level, form, count) == ("element", "mass", 3) and worst is report.rows[place] and not worst.passed


def test_a_count_that_is_off_is_worse_than_one_that_is_right():
    report = Report()
    report.rows += [row(0, 0), row(1, 0), row(0, 0)]
    assert report.summary()[0][3] is report.rows[1]


def test_json_has_the_rows_and_the_versions(tmp_path):
    report = Report()
    report.rows += [row(1e-13), row(1.0)]
    path = tmp_path / "new" / "out.json"
    report.write_json(path)
    data = json.loads(path.read_text())
    wanted = {"level", "form", "cell", "degree", "geometry_degree", "hypothesis", "difference", "tolerance", "passed"}
    assert {"rows", "versions"} <= set(data) and all(wanted <= set(r) for r in data["rows"])
    first = {k: data["rows"][0][k] for k in wanted}
    assert first == {
        "level": "element", "form": "mass", "cell": "hexahedron", "degree": 1, "geometry_degree": 1, "hypothesis": "3d",
        "difference": 1e-13, "tolerance": 1e-12, "passed": True,
    }  # fmt: skip
    assert [r["passed"] for r in data["rows"]] == [True, False] and data["passed"] is False
    assert data["versions"]["dolfinx"] == compat.installed() and data["versions"]["dolfinx_impact"]


def test_numbers_that_json_does_not_have_are_null(tmp_path):
    report = Report()
    report.rows += [row(np.nan), row(np.inf)]
    report.write_json(tmp_path / "out.json")
    text = (tmp_path / "out.json").read_text()
    assert "NaN" not in text and "Infinity" not in text
    assert [r["difference"] for r in json.loads(text)["rows"]] == [None, None]


def test_the_console_lists_every_failing_row(capsys):
    report = Report()
    report.rows += [row(1e-13), row(np.nan), row(2.0)]
    report.print()
    text = capsys.readouterr().out
    assert text.count("FAIL element mass") == 2 and "3 rows, 2 failed" in text and "all passed" not in text


def test_the_page_lists_the_failing_rows_and_shows_the_picture(tmp_path):
    report = Report()
    report.rows += [row(1e-13), row(np.nan), row(0.25)]
    report.figures.append(("Differences", html.differences_plot(report, tmp_path)))
    page = html.write(report, tmp_path / "index.html").read_text()
    bad, rest = page.split("Rows that failed")[1].split("Worst case of each form")
    assert bad.count('class="fail"') == 2 and "nan" in bad and "2.50e-01" in bad and bad.count("node 3") == 2
    assert "2 rows failed" in page and "every row passed" not in page
    assert 'src="differences.png"' in page and (tmp_path / "differences.png").read_bytes().startswith(b"\x89PNG")


def test_the_page_of_a_run_without_failures_says_so(tmp_path):
    report = Report()
    report.rows.append(row(1e-13))
    page = html.write(report, tmp_path / "index.html").read_text()
    assert "every row passed" in page and "Rows that failed" not in page


def test_an_empty_page_does_not_claim_success(tmp_path):
    page = html.write(Report(), tmp_path / "index.html").read_text()
    assert "every row passed" not in page


def test_a_nan_in_a_vector_or_matrix_is_found_and_placed():
    from dolfinx_impact import materials

    body = matched_body.Body(
        distorted_block.block("triangle", 2), 1, materials.LinearElastic(1.0, 0.3, 1.0, "plane_strain")
    )
    K = body.matrix_to_ours(body.model.stiffness())
    ours = K.copy()
    ours.data = ours.data.copy()
    ours.data[7] = np.nan
    difference, note = differences.largest_difference(body, ours, K)
    assert np.isnan(difference) and "UFL nan" in note and "against" in note
    b = np.arange(1.0, body.model.num_dofs + 1)
    a = b.copy()
    a[5] = np.nan
    difference, note = differences.largest_difference(body, a, b)
    place = np.round(body.V.tabulate_dof_coordinates()[2, :2], 4).tolist()
    assert np.isnan(difference) and note.startswith(f"node at {place} component 1: UFL nan")
