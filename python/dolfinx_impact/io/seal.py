# SPDX-License-Identifier: MIT
"""Seals of files: a checksum of every byte, in sections that several ranks may write and verify.

Behind the end of a file, where HDF5 does not look, stand a table of its sections and a footer. Sections follow each
other without a gap. Each has its length, a checksum, and whether it is structure, which everybody reads first, or data.
"""

import hashlib
import os
import struct

import numpy as np

SECTION = np.dtype([("length", "<i8"), ("data", "<i8"), ("sum", "V16")])
FOOTER = struct.Struct("<8sq16s")  # mark, number of sections, checksum of their table
MARK = b"IMPACT\r\n"  # a transfer as text would spoil it
BLOCK = 1 << 23  # bytes of a section at most: what is verified to read one row


def checksum(data):
    return hashlib.blake2b(data, digest_size=16).digest()


def sections(offset, data):
    """[(offset, length, is it data, checksum)] of data (bytes-like) that are to stand at an offset."""
    data = memoryview(data).cast("B")
    starts = range(0, len(data), BLOCK)
    return [(offset + s, len(data[s : s + BLOCK]), 1, checksum(data[s : s + BLOCK])) for s in starts]


def table(parts, structure, size):
    """The seal of a file, as bytes to be written behind its end.

    Args:
        parts: sections of data, of all ranks.
        structure: function (begin, end) -> bytes of what lies between them.
        size: of the file.
    """
    rows, at = [], 0
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

    Attributes:
        mark: checksum of all that is in it.

    Raises:
        OSError: it cannot be read. Damaged: it has no seal, or the seal or the structure is damaged.
    """

    _file = None

    def __init__(self, path):
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
            self._section(k, "the structure of the file")

    def close(self):
        if self._file is not None:
            os.close(self._file)
            self._file = None

    __del__ = close

    def _bytes(self, offset, length):
        parts = []
        while length > 0:
            part = os.pread(self._file, length, offset)
            if not part:
                raise Damaged("it ends too early")
            parts.append(part)
            offset, length = offset + len(part), length - len(part)
        return b"".join(parts)

    def _section(self, k, name):
        length = int(self._rows["length"][k])
        data = self._bytes(int(self._ends[k]) - length, length)
        if checksum(data) != self._rows["sum"][k].tobytes():
            raise Damaged(f"{name} is damaged")
        return data

    def read(self, name, offset, length):
        """Bytes of a range, whose sections are verified. Args: name: for messages."""
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
    """A file is not what was written."""
