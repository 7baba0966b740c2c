# SPDX-License-Identifier: MIT
"""What a killed case goes on from: its state, checkpoints and results so far, as one thing in a folder of its own.

`state.json` names the other files with the checksum of each, says which run they belong to, and is sealed itself. Files
get a new number each time and the state is replaced after they are complete: whenever a run is killed, the state that
is found is whole.
"""

from __future__ import annotations

import hashlib
import io
import json
import shutil
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from mpi4py import MPI

from dolfinx_impact.common.types import AnyArray
from dolfinx_impact import _cpp
from dolfinx_impact.io.gather import together
from dolfinx_impact.io.hdf5 import write_whole
from dolfinx_impact.io.run_folder import RunFolder

FORMAT = 1
FOLDER, STATE = "resume", "state.json"


class SavedCase:
    """State of a case in the folder `resume` of its run.

    Args:
        run: folder of the run.
        identity: what must be the same for a run to go on, by name: parameters, version, ...

    Attributes:
        state: numbers and texts by name as they were saved last; empty if nothing was; on all ranks.
        tables: arrays by name as they were saved last; on rank 0.
    """

    def __init__(self, run: RunFolder, identity: Mapping[str, Any]) -> None:
        self._run, self._identity = run, {"format": FORMAT, **identity}
        self.path = run.file(FOLDER)
        self.state: dict[str, Any] = {}
        self.tables: dict[str, AnyArray] = {}
        self._number = 0
        self._added: dict[str, str] = {}  # written since the last state

    @property
    def comm(self) -> MPI.Intracomm:
        """Communicator of the run."""
        return self._run.comm

    def clear(self) -> None:
        """Remove all that was saved. Collective."""
        self.state, self.tables, self._added = {}, {}, {}

        def remove() -> None:
            if self.path.exists():
                # Without it there is no state: a run that is killed here leaves nothing that looks damaged.
                (self.path / STATE).unlink(missing_ok=True)
                shutil.rmtree(self.path)

        self._run.write(FOLDER, remove)

    def read(self) -> bool:
        """Read what was saved, and check all of it. Collective.

        Returns:
            Whether there is anything.

        Raises:
            ValueError: it is of another run; on all ranks.
            RuntimeError: it is damaged; on all ranks.
        """

        def work() -> dict[str, Any]:
            if not (self.path / STATE).exists():
                return {}
            try:
                found = self._opened()
                self.tables = self._read_tables(found)
            except (OSError, ValueError, KeyError, TypeError, _cpp.files.Damaged) as error:
                if isinstance(error, _OtherRun):
                    raise ValueError(str(error)) from None
                raise RuntimeError(
                    f"{self.path} is damaged ({error}): remove it to begin anew, or give another folder"
                ) from None
            return found

        self.state = together(self.comm, work)
        if self.state:
            self._number = int(self.state["number of files"])
        return bool(self.state)

    def _opened(self) -> dict[str, Any]:
        text = (self.path / STATE).read_text(encoding="utf-8")
        found = json.loads(text)
        sealed = found.pop("seal")
        if sealed != seal(found):
            raise ValueError(f"the checksum of {STATE} is another one")
        for name, value in self._identity.items():
            if found["identity"].get(name) != value:
                raise _OtherRun(
                    f"{self._run.path} has a checkpoint of another joint or run, whose {name} differ: go on with what "
                    "it was begun with, give another folder, or begin anew without --resume"
                )
        for name, digest in found["files"].items():
            if _digest(self.path / name) != digest:
                raise ValueError(f"the checksum of {name} is another one")
        assert isinstance(found, dict)
        return found

    def _read_tables(self, found: Mapping[str, Any]) -> dict[str, AnyArray]:
        with np.load(self.path / found["tables"], allow_pickle=False) as file:
            return {name: file[name] for name in file.files}

    def file(self, what: str) -> Path:
        """File that was saved last.

        Args:
            what: name that it was saved under.
        """
        return self.path / str(self.state["kinds"][what])

    def add(self, what: str, work: Callable[[Path], object]) -> None:
        """Write a sealed file that belongs to the next state that is saved. Collective.

        Args:
            what: name that it is saved under.
            work: writes it to a path; collective.
        """
        self._run.write(FOLDER, lambda: self.path.mkdir(exist_ok=True))
        self._added[what] = f"{what}.h5"
        work(self.path / self._added[what])

    def save(
        self,
        state: Mapping[str, Any],
        tables: Callable[[], Mapping[str, AnyArray]],
        write: Mapping[str, Callable[[Path], object]],
        keep: tuple[str, ...] = (),
    ) -> None:
        """Save the state with its files; what was saved before is gone afterwards. Collective.

        Args:
            state: numbers and texts by name, for JSON.
            tables: makes arrays by name; called on rank 0 after `write`.
            write: by name, what writes a sealed file to a path; collective.
            keep: names of files that stay as they were saved before.

        Raises:
            RuntimeError: no room; on all ranks. What was saved before is untouched.
        """
        self._run.write(FOLDER, lambda: self.path.mkdir(exist_ok=True))
        self._number += 1
        kinds = {what: self.state["kinds"][what] for what in keep if what not in self._added} | self._added
        kinds |= {what: f"{what}_{self._number}.h5" for what in write}
        for what, work in write.items():
            work(self.path / kinds[what])

        def publish() -> dict[str, Any]:
            name = f"tables_{self._number}.npz"
            self.tables = dict(tables())
            content = io.BytesIO()
            np.savez(content, allow_pickle=False, **self.tables)
            write_whole(self.path / name, content.getvalue())
            files = {file: _digest(self.path / file) for file in (*kinds.values(), name)}
            new: dict[str, Any] = {
                **state, "identity": self._identity, "kinds": kinds, "tables": name, "files": files,
                "number of files": self._number,
            }  # fmt: skip
            new = json.loads(json.dumps(new))
            write_whole(self.path / STATE, json.dumps({**new, "seal": seal(new)}, indent=1) + "\n")
            for old in self.path.iterdir():
                if old.name not in {*files, STATE}:
                    old.unlink()
            return new

        self.state = self._run.write(FOLDER, publish)
        self._added = {}


class _OtherRun(ValueError):
    """The state belongs to a run with another identity."""


def seal(state: Mapping[str, Any]) -> str:
    """Checksum of a state.

    Args:
        state: numbers and texts by name, without the seal.
    """
    return hashlib.blake2b(json.dumps(state, sort_keys=True).encode(), digest_size=16).hexdigest()


def _digest(path: Path) -> str:
    """Checksum of a file; of a sealed one that of its seal, which has those of its sections."""
    if path.suffix == ".h5":
        return _cpp.files.SealedFile(str(path)).mark.hex()
    return hashlib.blake2b(path.read_bytes(), digest_size=16).hexdigest()


__all__ = ["SavedCase"]
