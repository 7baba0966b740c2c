# SPDX-License-Identifier: MIT
"""HDF5 files that no full disk can spoil: HDF5 lays them out in memory, plain writes bring them to the disk.

A write that fails inside HDF5 leaves the file, and with it the process, in no state to go on: at its end the process
may be aborted. So HDF5 never writes to a disk here. A new file is written under another name and renamed when it is
complete. Where a file grows, room is reserved first, then what is new is written behind its end, and only then what was
there is changed in place: a disk that is full leaves the file as it was.
"""

import io
import os
from pathlib import Path


class Sketch(io.RawIOBase):
    """A file in memory that has only what was written into it, page by page.

    Args:
        base: descriptor of a file whose content shows where nothing was written, or None: zeros.
    """

    page = 4096

    def __init__(self, base=None):
        super().__init__()
        self.pages, self._base, self._at = {}, base, 0
        self.size = 0 if base is None else os.fstat(base).st_size

    def seek(self, offset, whence=os.SEEK_SET):
        self._at = offset + {os.SEEK_SET: 0, os.SEEK_CUR: self._at, os.SEEK_END: self.size}[whence]
        return self._at

    def tell(self):
        return self._at

    def _parts(self, count):
        """(place in the buffer, page, place in the page, length) of a range from here on; moves behind it."""
        done = 0
        while done < count:
            number, first = divmod(self._at, self.page)
            length = min(count - done, self.page - first)
            yield done, number, first, length
            done, self._at = done + length, self._at + length

    def _below(self, number):
        """What a page was before anything was written into it."""
        data = b"" if self._base is None else os.pread(self._base, self.page, number * self.page)
        return data.ljust(self.page, b"\0")

    def write(self, data):
        data = memoryview(data).cast("B")
        for place, number, first, length in self._parts(len(data)):
            page = self.pages.get(number)
            if page is None:
                page = self.pages[number] = bytearray(self._below(number))
            page[first : first + length] = data[place : place + length]
        self.size = max(self.size, self._at)
        return len(data)

    def readinto(self, data):
        data = memoryview(data).cast("B")
        for place, number, first, length in self._parts(len(data)):
            page = self.pages.get(number)
            data[place : place + length] = (page or self._below(number))[first : first + length]
        return len(data)

    def truncate(self, size):
        self.size = size

    def bytes(self, begin, end):
        """Content of a range."""
        self.seek(begin)
        data = bytearray(end - begin)
        self.readinto(data)
        return bytes(data)

    def writes(self):
        """(offset, bytes) of what was written, in order."""
        for number in sorted(self.pages):
            offset = number * self.page
            if offset < self.size:
                yield offset, bytes(self.pages[number][: self.size - offset])


def write_at(file, data, offset):
    """All of the data (bytes-like) to a descriptor; a disk that is full takes a part first and says so at the next
    call."""
    data = memoryview(data).cast("B")
    while len(data):
        count = os.pwrite(file, data, offset)
        data, offset = data[count:], offset + count


def reserve(file, begin, end):
    """Room on the disk for a range of a file (a descriptor).

    Raises:
        OSError: there is none; the file is not longer than before.
    """
    if end > begin:
        size = os.fstat(file).st_size
        try:
            os.posix_fallocate(file, begin, end - begin)
        except OSError:
            if os.fstat(file).st_size > size:
                os.ftruncate(file, size)
            raise


def write_whole(path, content):
    """Write a file at once, or leave what was there.

    Args:
        content: text, bytes, or (offset, bytes) pairs in order.

    Raises:
        OSError: no room, ...
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


def create(path, fill):
    """Make an HDF5 file: fill(file) gets it as h5py.File.

    Raises:
        OSError: as write_whole.
    """
    import h5py

    sketch = Sketch()
    with h5py.File(sketch, "w") as file:
        fill(file)
    write_whole(path, sketch.writes())


def update(path, change):
    """Change an HDF5 file: change(file) gets it as h5py.File.

    Raises:
        OSError: it is no HDF5 file; no room, then it is as it was.
    """
    import h5py

    file = os.open(path, os.O_RDWR)
    try:
        sketch = Sketch(file)
        end = sketch.size
        with h5py.File(sketch, "r+") as hdf5:
            change(hdf5)
        reserve(file, end, sketch.size)
        try:
            for offset, data in sketch.writes():
                if offset + len(data) > end:
                    first = max(0, end - offset)
                    write_at(file, data[first:], offset + first)
        except OSError:
            os.ftruncate(file, end)
            raise
        for offset, data in sketch.writes():
            if offset < end:
                write_at(file, data[: end - offset], offset)
    finally:
        os.close(file)
