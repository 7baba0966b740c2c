# SPDX-License-Identifier: MIT
"""Where the header goes: a file, or a folder for header and source. Files are whole or not there."""

from __future__ import annotations

import contextlib
import os
import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

HEADERS = (".h", ".hh", ".hpp", ".hxx")


@dataclass
class Output:
    """Where the kernels go.

    Attributes:
        folder: folder of the files.
        header: name of the header.
        source: name of the source, or None: all is in the header.
    """

    folder: Path
    header: str
    source: str | None

    def check(self) -> None:
        """Make the folder, and refuse one that cannot be written in, before kernels are written for minutes.

        Raises:
            ValueError: it cannot be.
        """
        with _plain(self.folder):
            if self.source is not None:
                self.folder.mkdir(parents=True, exist_ok=True)
            for name in filter(None, (self.header, self.source)):
                if (self.folder / name).is_dir():
                    raise IsADirectoryError(0, f"{name} is a folder")
            with tempfile.TemporaryFile(dir=self.folder):
                pass

    def write(self, header: str, source: str) -> list[Path]:
        """Write the files.

        Args:
            header: text of the header.
            source: text of the source; it is not written where all is in the header.

        Returns:
            The files.

        Raises:
            ValueError: they cannot be written; then those of before are still there.
        """
        texts = {self.header: header} | ({} if self.source is None else {self.source: source})
        with _plain(self.folder):
            _write(self.folder, texts)
        return [self.folder / name for name in texts]


def output_of(target: str, stem: str) -> Output:
    """Files that a user means.

    Args:
        target: a header (my_law.h), or a folder for header and source.
        stem: name of the files in a folder, without an ending.
    """
    path = Path(target)
    if path.suffix in HEADERS and not path.is_dir():
        return Output(path.parent, path.name, None)
    return Output(path, f"{stem}.h", f"{stem}.cpp")


@contextlib.contextmanager
def _plain(folder: Path) -> Iterator[None]:
    """Context in which an error of the file system is told as a bad -o."""
    try:
        yield
    except OSError as e:
        raise ValueError(f"the kernels cannot be written to {folder}: {e.strerror}; give another -o") from e


def _write(folder: Path, texts: Mapping[str, str]) -> None:
    """Write files beside their places, all of them, and then put them there."""
    fresh: dict[Path, str] = {}
    try:
        for name, text in texts.items():
            handle, part = tempfile.mkstemp(dir=folder, prefix=f".{name}.")
            fresh[folder / name] = part
            with os.fdopen(handle, "w", encoding="utf-8") as file:
                file.write(text)
            mask = os.umask(0)
            os.umask(mask)
            os.chmod(part, 0o666 & ~mask)  # as of any file; mkstemp's is for its owner only
        for place, part in fresh.items():
            os.replace(part, place)
    finally:
        for part in fresh.values():
            with contextlib.suppress(FileNotFoundError):
                os.remove(part)
