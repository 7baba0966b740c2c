# SPDX-License-Identifier: MIT
"""Checkpoints that an earlier version has written, on one rank: read, and written again as they were.

The files of the folder format_11 were written by `saved_problems.run_and_save`, before states were described as trees:
names of tables, order of their columns and the meaning of values are those of the format.
"""

from pathlib import Path

import h5py
import numpy as np
import pytest
import saved_problems

FOLDER = Path(__file__).parent / "format_11"


def content(path):
    """Attributes and tables of a checkpoint by name."""
    with h5py.File(path, "r") as file:
        found = {f"attribute {name}": np.asarray(value) for name, value in file.attrs.items()}
        file.visititems(lambda name, thing: found.update({name: thing[()]} if isinstance(thing, h5py.Dataset) else {}))
    return found


@pytest.mark.parametrize("make", (*saved_problems.EXPLICIT, *saved_problems.IMPLICIT), ids=lambda f: f.__name__)
def test_files_of_the_format_are_read_and_written_again(make, tmp_path):
    """Exactly, apart from sums by which the problem is recognised: another machine adds up otherwise."""
    problem, there = make(), FOLDER / f"{make.__name__}.h5"
    problem.restore(there)
    wanted = content(there)
    assert problem.step == wanted["attribute step"] > 0 and problem.time == wanted["attribute time"]
    problem.save(tmp_path / "again.h5")
    found = content(tmp_path / "again.h5")
    assert set(found) == set(wanted)
    for name, values in wanted.items():
        assert found[name].dtype == values.dtype and found[name].shape == values.shape, name
        if name.startswith(("attribute sums", "nodes/x", "attribute functions")):
            np.testing.assert_allclose(found[name], values, rtol=1e-9, atol=1e-9, err_msg=name)
        else:
            np.testing.assert_array_equal(found[name], values, err_msg=name)
    contact = problem.contact[0]
    assert np.any(np.asarray(contact.status)) and contact.dissipated > 0.0
    problem.advance(problem.time + (0.002 if make in saved_problems.IMPLICIT else 5 * problem.stable_step()),
                    **({"dt": 0.002} if make in saved_problems.IMPLICIT else {}), progress=False)  # fmt: skip
    assert np.all(np.isfinite(problem.u.x.array)) and problem.step > wanted["attribute step"]
