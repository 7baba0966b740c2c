# SPDX-License-Identifier: MIT
"""HDF5 files that a full disk cannot damage: HDF5 lays them out in memory, and plain writes copy them to the disk.

After a write that fails inside HDF5, the file is damaged and the process may be aborted when it ends. Therefore HDF5
never writes to a disk here. A new file is written under another name and renamed when it is complete. A file that grows
is changed in three steps: room is reserved, new bytes are written behind the end, and only then existing bytes are
changed in place. If the disk is full, the file stays as it was.

h5py on the disk itself, with Fletcher32 and a rename at the end, does not do the same. Where a file may not grow any
more, h5py 3.13 with HDF5 1.14 raises OSError, but cannot close the file, and Python ends with a segmentation fault
although the script has caught the error. Fletcher32 is a filter of chunks: it covers neither attributes nor the headers
and indices of the file, all of which the seal covers. A series that grows by one frame would be written anew as a whole
for each, as HDF5 changes headers in place.
"""

from __future__ import annotations

import io
import os
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from .. import _cpp
from ..common.types import FilePath

if TYPE_CHECKING:
    import h5py
    from _typeshed import ReadableBuffer, WriteableBuffer


class WrittenPages(io.RawIOBase):
    """File in memory that stores only the pages that were written.

    Args:
        base: descriptor of a file from which all other pages are read; None: other pages are zero.

    Attributes:
        pages: pages that were written, by number.
        size: size of the file [bytes].
    """

    page = 4096

    def __init__(self, base: int | None = None) -> None:
        super().__init__()
        self.pages: dict[int, bytearray] = {}
        self._base, self._at = base, 0
        self.size = 0 if base is None else os.fstat(base).st_size

    def seek(self, offset: int, whence: int = os.SEEK_SET, /) -> int:
        """Set the position; see io.RawIOBase."""
        self._at = offset + {os.SEEK_SET: 0, os.SEEK_CUR: self._at, os.SEEK_END: self.size}[whence]
        return self._at

    def tell(self) -> int:
        """Position; see io.RawIOBase."""
        return self._at

    def _parts(self, count: int) -> Iterator[tuple[int, int, int, int]]:
        """Split the next bytes into pages and move behind them.

        Args:
            count: number of bytes.

        Yields:
            Offset in the buffer, number of the page, offset in the page, length.
        """
        done = 0
        while done < count:
            number, first = divmod(self._at, self.page)
            length = min(count - done, self.page - first)
            yield done, number, first, length
            done, self._at = done + length, self._at + length

    def _below(self, number: int) -> bytes:
        """Content of a page before anything was written into it."""
        data = b"" if self._base is None else os.pread(self._base, self.page, number * self.page)
        return data.ljust(self.page, b"\0")

    def write(self, data: ReadableBuffer, /) -> int:
        """Write all of the data; see io.RawIOBase."""
        data = memoryview(data).cast("B")
        for place, number, first, length in self._parts(len(data)):
            page = self.pages.get(number)
            if page is None:
                page = self.pages[number] = bytearray(self._below(number))
            page[first : first + length] = data[place : place + length]
        self.size = max(self.size, self._at)
        return len(data)

    def readinto(self, data: WriteableBuffer, /) -> int:
        """Fill the data; see io.RawIOBase."""
        data = memoryview(data).cast("B")
        for place, number, first, length in self._parts(len(data)):
            page = self.pages.get(number)
            data[place : place + length] = (page or self._below(number))[first : first + length]
        return len(data)

    def truncate(self, size: int | None = None, /) -> int:
        """Set the size; see io.RawIOBase."""
        self.size = self._at if size is None else size
        return self.size

    def content(self, begin: int, end: int) -> bytes:
        """Content of a range.

        Args:
            begin: first byte.
            end: byte behind the last one.

        Returns:
            Bytes of the range.
        """
        self.seek(begin)
        data = bytearray(end - begin)
        self.readinto(data)
        return bytes(data)

    def writes(self) -> Iterator[tuple[int, bytes]]:
        """Pages that were written, in their order.

        Yields:
            Offset and bytes of a page.
        """
        for number in sorted(self.pages):
            offset = number * self.page
            if offset < self.size:
                yield offset, bytes(self.pages[number][: self.size - offset])


def write_at(file: int, data: ReadableBuffer, offset: int) -> None:
    """Write all of the data; a disk that becomes full takes a part of it first.

    Args:
        file: descriptor.
        data: bytes, or an array.
        offset: offset in the file [bytes].

    Raises:
        OSError: no room.
    """
    rest = memoryview(data).cast("B")
    while len(rest):
        count = os.pwrite(file, rest, offset)
        rest, offset = rest[count:], offset + count


def reserve(file: int, begin: int, end: int) -> None:
    """Reserve room on the disk for a range of a file.

    Args:
        file: descriptor.
        begin: first byte.
        end: byte behind the last one.

    Raises:
        OSError: no room; the file is not longer than before.
    """
    if end > begin:
        size = os.fstat(file).st_size
        try:
            os.posix_fallocate(file, begin, end - begin)
        except OSError:
            if os.fstat(file).st_size > size:
                os.ftruncate(file, size)
            raise


def write_whole(path: FilePath, content: str | bytes | Iterable[tuple[int, bytes]]) -> None:
    """Write a complete file, or leave an earlier one as it was.

    Args:
        path: file to write.
        content: text, bytes, or pairs of offset and bytes in order.

    Raises:
        OSError: no room, or another failure to write.
    """
    path = Path(path)
    part = path.with_name(path.name + ".part")
    if isinstance(content, str):
        content = content.encode()
    if isinstance(content, bytes):
        content = [(0, content)]
    try:
        with open(part, "wb") as file:
            for offset, data in content:
                write_at(file.fileno(), data, offset)
        os.replace(part, path)
    except BaseException:
        part.unlink(missing_ok=True)
        raise


def create(path: FilePath, fill: Callable[[h5py.File], object], sealed: bool = False) -> None:
    """Create an HDF5 file.

    Args:
        path: file to write.
        fill: function that fills the file.
        sealed: whether checksums of all bytes follow behind the end (cpp/dolfinx_impact/files/Seal.h).

    Raises:
        OSError: no room, or another failure to write; an earlier file is as it was.
    """
    import h5py

    pages = WrittenPages()
    with h5py.File(pages, "w") as file:
        fill(file)
    ends = [(pages.size, _cpp.files.seal(pages.content(0, pages.size)))] if sealed else []
    write_whole(path, [*pages.writes(), *ends])


def update(path: FilePath, change: Callable[[h5py.File], object]) -> None:
    """Change an HDF5 file.

    Args:
        path: file to change.
        change: function that changes the file.

    Raises:
        OSError: the file is no HDF5 file, or there is no room; the file is then as it was.
    """
    import h5py

    file = os.open(path, os.O_RDWR)
    try:
        pages = WrittenPages(file)
        end = pages.size
        with h5py.File(pages, "r+") as hdf5:
            change(hdf5)
        reserve(file, end, pages.size)
        try:
            for offset, data in pages.writes():
                if offset + len(data) > end:
                    first = max(0, end - offset)
                    write_at(file, data[first:], offset + first)
        except OSError:
            os.ftruncate(file, end)
            raise
        for offset, data in pages.writes():
            if offset < end:
                write_at(file, data[: end - offset], offset)
    finally:
        os.close(file)
