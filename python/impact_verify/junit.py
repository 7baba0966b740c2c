# SPDX-License-Identifier: MIT
"""Reports as JUnit XML, which continuous integration shows as tests."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

from dolfinx_impact.io.hdf5 import write_whole
from .report import Report, row_label


def write(report: Report, path: Path | str, suite: str) -> Path:
    """Write one test case per row; rows that do not apply are skipped ones.

    Args:
        report: report.
        path: file to write; its folder is made.
        suite: name of the test suite.

    Returns:
        The file.
    """
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    skipped = [not getattr(r, "applies", True) for r in report.rows]
    failures = sum(not r.passed and not s for r, s in zip(report.rows, skipped))
    counts = {"tests": str(len(report.rows)), "failures": str(failures), "errors": "0", "skipped": str(sum(skipped))}
    root = ET.Element("testsuites", counts)
    cases = ET.SubElement(root, "testsuite", {"name": suite, **counts})
    for r, skip in zip(report.rows, skipped):
        case = ET.SubElement(cases, "testcase", {"classname": f"{suite}.{r.form}", "name": row_label(r) or r.level})
        if skip:
            ET.SubElement(case, "skipped", {"message": r.note})
        elif not r.passed:
            text = f"{r.name}: {r.difference:.3e} > {r.tolerance:.1e} ({r.reason})"
            ET.SubElement(case, "failure", {"message": r.note or text, "type": r.name or r.level}).text = text
    ET.indent(root)
    write_whole(path, ET.tostring(root, encoding="unicode", xml_declaration=True) + "\n")
    return path
