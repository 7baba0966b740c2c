# SPDX-License-Identifier: MIT
"""Seals of files: checksums of all bytes, in sections that several ranks may write and verify.

A table of the file's sections and a footer follow behind the end of the HDF5 data, which HDF5 ignores. Sections follow
each other without a gap. The table has the length and checksum of each section, and whether it is structure, which
every rank reads first, or data.
"""

from __future__ import annotations

import hashlib
import os
import struct
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from ..common.types import FilePath

if TYPE_CHECKING:
    from _typeshed import ReadableBuffer

SECTION = np.dtype([("length", "<i8"), ("data", "<i8"), ("sum", "V16")])
FOOTER = struct.Struct("<8sq16s")  # mark, number of sections, checksum of their table
MARK = b"IMPACT\r\n"  # with an end of line, so that a transfer as text changes it
BLOCK = 1 << 23  # largest section, which is verified to read one row [bytes]

Section: TypeAlias = tuple[int, int, int, bytes]  # offset, length, 1 for data or 0 for structure, checksum


def checksum(data: ReadableBuffer) -> bytes:
    """Checksum of data.

    Args:
        data: bytes, or a contiguous array.

    Returns:
        Checksum, 16 bytes.
    """
    return hashlib.blake2b(data, digest_size=16).digest()


def sections(offset: int, data: ReadableBuffer) -> list[Section]:
    """Sections of data that will be written at an offset.

    Args:
        offset: offset in the file [bytes].
        data: bytes, or a contiguous array.

    Returns:
        Sections in their order.
    """
    view = memoryview(data).cast("B")
    starts = range(0, len(view), BLOCK)
    return [(offset + s, len(view[s : s + BLOCK]), 1, checksum(view[s : s + BLOCK])) for s in starts]


def table(parts: Iterable[Section], structure: Callable[[int, int], bytes], size: int) -> bytes:
    """Seal of a file, to be written behind its end.

    Args:
        parts: sections of data, of all ranks.
        structure: function (begin, end) that returns the bytes between the sections.
        size: size of the file [bytes].

    Returns:
        Table of all sections, and footer.

    Raises:
        ValueError: sections overlap, or lie behind the end.
    """
    rows: list[tuple[int, int, bytes]] = []
    at = 0
    for offset, length, kind, digest in [*sorted(parts), (size, 0, 1, b"")]:
        for begin in range(at, offset, BLOCK):
            end = min(begin + BLOCK, offset)
            rows.append((end - begin, 0, checksum(structure(begin, end))))
        if length:
            rows.append((length, kind, digest))
        at = offset + length
    if at != size:
        raise ValueError("sections overlap or stand behind the end")
    data = np.array(rows, dtype=SECTION).tobytes()
    return data + FOOTER.pack(MARK, len(rows), checksum(data))


class Sealed:
    """A sealed file, open for reading.

    Args:
        path: file to open.

    Attributes:
        mark: checksum of the table of sections, and thereby of the whole file.

    Raises:
        OSError: the file cannot be read.
        Damaged: the file has no seal, or the seal or the structure is damaged.
    """

    _file: int | None = None
    mark: bytes

    def __init__(self, path: FilePath) -> None:
        self._file = os.open(path, os.O_RDONLY)
        size = os.fstat(self._file).st_size
        footer = os.pread(self._file, FOOTER.size, max(0, size - FOOTER.size))
        mark, count, self.mark = FOOTER.unpack(footer) if len(footer) == FOOTER.size else (b"", 0, b"")
        begin = size - FOOTER.size - SECTION.itemsize * count
        if mark != MARK or count < 0 or begin < 0:
            raise Damaged("it has no seal at its end: it was cut short, or another program has changed it")
        data = self._bytes(begin, SECTION.itemsize * count)
        rows = np.frombuffer(data, dtype=SECTION)
        if checksum(data) != self.mark or rows["length"].sum() != begin or np.any(rows["length"] < 0):
            raise Damaged("its seal is damaged")
        self._rows, self._ends = rows, np.cumsum(rows["length"])
        for k in np.flatnonzero(rows["data"] == 0):
            self._section(int(k), "the structure of the file")

    def close(self) -> None:
        """Close the file."""
        if self._file is not None:
            os.close(self._file)
            self._file = None

    __del__ = close

    def _bytes(self, offset: int, length: int) -> bytes:
        assert self._file is not None, "the file is closed"
        parts = []
        while length > 0:
            part = os.pread(self._file, length, offset)
            if not part:
                raise Damaged("it ends too early")
            parts.append(part)
            offset, length = offset + len(part), length - len(part)
        return b"".join(parts)

    def _section(self, k: int, name: str) -> bytes:
        """Content of section k, verified; `name` is for messages."""
        length = int(self._rows["length"][k])
        data = self._bytes(int(self._ends[k]) - length, length)
        if checksum(data) != self._rows["sum"][k].tobytes():
            raise Damaged(f"{name} is damaged")
        return data

    def read(self, name: str, offset: int, length: int) -> bytes:
        """Read a range and verify its sections.

        Args:
            name: name of the content, for messages.
            offset: first byte.
            length: number of bytes.

        Returns:
            Bytes of the range.

        Raises:
            OSError: the file cannot be read.
            Damaged: a section is damaged, or the range is not in the file.
        """
        end = offset + length
        if not 0 <= offset <= end <= (int(self._ends[-1]) if len(self._ends) else 0):
            raise Damaged(f"{name} lies outside the file")
        if not length:
            return b""
        first, last = np.searchsorted(self._ends, [offset, end - 1], side="right")
        data = b"".join(self._section(k, name) for k in range(first, last + 1))
        begin = int(self._ends[first] - self._rows["length"][first])
        return data[offset - begin : end - begin]


class Damaged(RuntimeError):
    """The content of a file is not what was written."""
