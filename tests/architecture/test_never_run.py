# SPDX-License-Identifier: MIT
"""What `make coverage` says of the reports of coverage and gcovr."""

import json
import subprocess
import sys

import never_run

PYTHON = {"files": {"python/pack/part/a.py": {"executed_lines": [1], "missing_lines": [3, 2]}}}
CPP = {
    "files": [
        {
            "file": "cpp/pack/stage/a.cpp",
            "lines": [
                {"line_number": 1, "count": 0},  # two instances of one template, of which one runs
                {"line_number": 1, "count": 4},
                {"line_number": 2, "count": 0},
                {"line_number": 3, "count": 0, "gcovr/noncode": True},
            ],
        }
    ]
}


def test_lines_are_counted_and_listed(tmp_path):
    for name, text in (("python/pack/part/a.py", "one\n  two\nthree\n"), ("cpp/pack/stage/a.cpp", "1\n2\n3\n")):
        (tmp_path / name).parent.mkdir(parents=True)
        (tmp_path / name).write_text(text)
    (tmp_path / "python.json").write_text(json.dumps(PYTHON))
    (tmp_path / "cpp.json").write_text(json.dumps(CPP))
    command = [sys.executable, never_run.__file__, "python.json", "cpp.json", "."]
    said = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True).stdout.splitlines()
    assert [line.split() for line in said[1:4]] == [
        ["python/pack/part", "3", "1", "33.3", "%"],
        ["cpp/pack/stage", "2", "1", "50.0", "%"],
        ["all", "5", "2", "40.0", "%"],
    ]
    assert (tmp_path / "never_run.txt").read_text().splitlines() == [
        "python/pack/part/a.py:2: two",
        "python/pack/part/a.py:3: three",
        "cpp/pack/stage/a.cpp:2: 2",
    ]
