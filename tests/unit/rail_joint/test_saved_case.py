# SPDX-License-Identifier: MIT
"""What a case goes on from: whole or refused, whatever happens to its files."""

import json
import os

import h5py
import numpy as np
import pytest

from dolfinx_impact import _cpp
from dolfinx_impact.io import hdf5
from dolfinx_impact.io.run_folder import RunFolder
from impact_studies.rail_joint.saved_case import SavedCase

IDENTITY = {"parameters": "abc", "version": "1"}


def sealed_file(path, value):
    """A file with a seal, as checkpoints have one."""
    hdf5.create(path, lambda file: file.create_dataset("x", data=np.full(100, value)))
    content = path.read_bytes()
    path.write_bytes(content + _cpp.files.seal(content))


def saved(folder, identity=None):
    return SavedCase(RunFolder(folder), identity or IDENTITY)


@pytest.fixture
def folder(tmp_path):
    """A folder in which a state was saved twice."""
    case = saved(tmp_path)
    for value in (1.0, 2.0):
        case.save({"pass": int(value), "static_force": 1.5 * value}, lambda: {"time": np.arange(value)},
                  {"checkpoint": lambda path: sealed_file(path, value)})  # fmt: skip
    return tmp_path


def test_what_was_saved_last_is_read(folder):
    case = saved(folder)
    assert case.read() and case.state["pass"] == 2 and case.state["static_force"] == 3.0
    np.testing.assert_array_equal(case.tables["time"], [0.0, 1.0])
    with h5py.File(case.file("checkpoint")) as file:
        assert file["x"][0] == 2.0
    assert len(list((folder / "resume").iterdir())) == 3, "older files are gone"
    case.clear()
    assert not saved(folder).read() and not (folder / "resume").exists()


@pytest.mark.parametrize("name", [*IDENTITY, "format"])
def test_a_state_of_another_run_is_refused(folder, name):
    with pytest.raises(ValueError, match=f"whose {name} differ"):
        saved(folder, {**IDENTITY, name: "other"}).read()


@pytest.mark.parametrize(
    "change",
    [lambda d: {**d, "static_force": 1e9}, lambda d: {**d, "pass": 0}, lambda d: {"seal": d["seal"]}, lambda d: []],
)
def test_a_changed_state_is_refused(folder, change):
    path = folder / "resume" / "state.json"
    path.write_text(json.dumps(change(json.loads(path.read_text()))))
    with pytest.raises(RuntimeError, match="is damaged .*remove it to begin anew"):
        saved(folder).read()


@pytest.mark.parametrize(
    "ending, how",
    [
        *((ending, how) for ending in ("json", "npz", "h5") for how in ("flipped", "cut", "empty")),
        ("npz", "missing"),
        ("h5", "missing"),
    ],
)
def test_a_damaged_file_is_refused(folder, ending, how):
    (path,) = (folder / "resume").glob(f"*.{ending}")
    data = bytearray(path.read_bytes())
    if how == "flipped":
        data[len(data) // 2] ^= 1
    new = {"flipped": bytes(data), "cut": bytes(data[:-7]), "empty": b""}.get(how)
    if new is None:
        path.unlink()
    else:
        path.write_bytes(new)
    with pytest.raises(RuntimeError, match="is damaged"):
        saved(folder).read()


def test_a_file_of_an_older_state_is_refused(folder):
    """As after a copy of single files."""
    path = saved(folder).path
    (name,) = (p.name for p in path.glob("checkpoint*"))
    sealed_file(path / name, 1.0)
    with pytest.raises(RuntimeError, match=f"checksum of {name}"):
        saved(folder).read()


def test_a_run_that_is_killed_while_it_saves_has_the_state_before(folder):
    class Killed(BaseException):
        pass

    def killed(*_):
        raise Killed

    for work, tables in ((killed, dict), (lambda path: sealed_file(path, 3.0), killed)):
        case = saved(folder)
        case.read()
        case.add("frame_0", lambda path: sealed_file(path, 9.0))
        with pytest.raises(Killed):
            case.save({"pass": 3}, tables, {"checkpoint": work})
        again = saved(folder)
        assert again.read() and again.state["pass"] == 2


@pytest.mark.parametrize("removed", range(3))
def test_a_run_that_is_killed_while_it_clears_leaves_nothing_damaged(folder, removed, monkeypatch):
    """After each file that it removes, whatever their order."""

    class Killed(BaseException):
        pass

    unlink, count = os.unlink, []

    def killed(*args, **named):
        if len(count) == removed:
            raise Killed
        count.append(args)
        unlink(*args, **named)

    case = saved(folder)
    with monkeypatch.context() as patched:
        patched.setattr(os, "unlink", killed)
        with pytest.raises(Killed):
            case.clear()
    assert saved(folder).read() == (removed == 0)
