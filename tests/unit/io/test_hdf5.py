# SPDX-License-Identifier: MIT
"""A file in memory by pages, against a plain file with the same calls."""

import io
import os

import pytest

from dolfinx_impact.io.hdf5 import WrittenPages


@pytest.mark.parametrize("below", [0, 10000])
def test_pages_are_a_file(below, rng, tmp_path):
    """Random calls on both."""
    (tmp_path / "base").write_bytes(content := rng.bytes(below))
    with open(tmp_path / "base", "rb") as base:
        pages, plain = WrittenPages(base.fileno() if below else None), io.BytesIO(content)
        for _ in range(60):
            at, length = (int(n) for n in rng.integers(0, [15000, 6000]))
            assert pages.seek(at) == plain.seek(at)
            if rng.random() < 0.5:
                data = rng.bytes(length)
                assert pages.write(data) == plain.write(data)
            else:
                found, expected = bytearray(length), bytearray(length)
                pages.readinto(found)
                plain.readinto(expected)
                assert found == expected
                pages.seek(plain.tell())  # a plain file ends; a page goes on with zeros
            assert pages.tell() == plain.tell()
        expected = plain.getvalue()
        assert pages.size == len(expected) == pages.seek(0, os.SEEK_END)
        assert pages.content(0, pages.size) == expected
        assert pages.seek(-10, os.SEEK_CUR) == pages.size - 10
        rebuilt = bytearray(content.ljust(len(expected), b"\0"))
        for offset, data in pages.writes():
            rebuilt[offset : offset + len(data)] = data
        assert bytes(rebuilt) == expected
        assert pages.truncate(100) == 100 == pages.size
        assert sum(len(data) for _, data in pages.writes()) <= 100
    assert (tmp_path / "base").read_bytes() == content
