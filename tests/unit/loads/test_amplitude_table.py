# SPDX-License-Identifier: MIT
"""Amplitude tables; the checks on ranks are in amplitude_table_checks.py."""

import amplitude_table_checks
import numpy as np
import pytest
from amplitude_table_checks import *  # noqa: F401, F403
from on_ranks import rank_tests

import dolfinx_impact as di

test_one_rank, test_several_ranks = rank_tests(amplitude_table_checks)


def test_a_table_shows_what_it_has_and_cannot_be_changed():
    table = di.AmplitudeTable([0, 1, 4], [[0, 1], [1, 1], [2, 3]])
    assert repr(table) == "AmplitudeTable(3 vectors of 2 from 0 to 4, linear)"
    assert table.size == 2 and table(0.5).tolist() == [0.5, 1.0] and table.values.shape == (3, 2)
    assert table.sample([0.5, 4.0]).tolist() == [[0.5, 1.0], [2.0, 3.0]]
    assert isinstance(di.AmplitudeTable([0, 1], [0, 1])(0.5), float)
    with pytest.raises(AttributeError, match="cannot be changed"):
        table.before = "refuse"


def test_tables_from_files(tmp_path):
    file = tmp_path / "pulse.csv"
    np.savetxt(file, [[0.0, 0.0, 1.0], [1.0, 2.0, 5.0]], delimiter=",", header="time, x, y")
    table = di.AmplitudeTable.from_csv(file, "smooth", before="refuse")
    assert table(0.5).tolist() == [1.0, 3.0] and table.interpolation == "smooth" and "pulse.csv" in table.name
    with pytest.raises(ValueError, match="pulse.csv is asked for the time -1"):
        table(-1.0)
    with pytest.raises(AttributeError, match="cannot be changed"):
        table.name = "other"
    file.write_text("time;force\n0;1\n1;x\n")
    with pytest.raises(ValueError, match="line 3 of the table .*pulse.csv is no row"):
        di.AmplitudeTable.from_csv(file)
    with pytest.raises(RuntimeError, match="cannot be read"):
        di.AmplitudeTable.from_csv(tmp_path / "none.csv")
    with pytest.raises(TypeError, match="name of a file"):
        di.AmplitudeTable.from_csv(3)


@pytest.mark.parametrize(
    "wrong, error, text",
    [
        (([0, 1], [0]), ValueError, "increasing times and as many values"),
        (([0, 0], [0, 1]), ValueError, "0 follows 0"),
        (([0, 1], [0, np.nan]), ValueError, "finite"),
        (([0], [[1, 2, 3, 4]]), ValueError, "one, two or three values"),
        ((["a"], [0]), TypeError, "must be numbers"),
        (([0], [0], "cubic"), ValueError, "use 'linear' or 'smooth'"),
        (([0], [0], "linear", "zero"), ValueError, "use 'hold' or 'refuse'"),
    ],
)
def test_what_is_no_table(wrong, error, text):
    with pytest.raises(error, match=text):
        di.AmplitudeTable(*wrong)
