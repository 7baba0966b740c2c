# SPDX-License-Identifier: MIT
"""Seals of files: checksums against another implementation, and what a reader makes of bytes that differ."""

import hashlib
import struct

import numpy as np
import pytest

from dolfinx_impact import _cpp

LONGEST = 1 << 23  # bytes of a section
LENGTHS = (0, 1, 127, 128, 129, 255, 256, 4096, LONGEST - 1, LONGEST, LONGEST + 1)


def digest(data):
    return hashlib.blake2b(data, digest_size=16).digest()


@pytest.mark.parametrize("length", LENGTHS)
def test_a_seal_has_the_checksums_of_its_sections(length, rng, tmp_path):
    data = rng.bytes(length)
    sections = [data[begin : begin + LONGEST] for begin in range(0, length, LONGEST)]
    table = b"".join(struct.pack("<qq", len(part), 0) + digest(part) for part in sections)
    assert _cpp.files.seal(data) == table + struct.pack("<8sq", b"IMPACT\r\n", len(sections)) + digest(table)
    (tmp_path / "file").write_bytes(data + _cpp.files.seal(data))
    found = _cpp.files.SealedFile(str(tmp_path / "file"))
    assert found.size == length and found.mark == digest(table)
    assert found.sections == [(k * LONGEST, len(part), False) for k, part in enumerate(sections)]


def test_any_bit_that_differs_is_found(rng, tmp_path):
    data = rng.bytes(1000)
    whole, path = data + _cpp.files.seal(data), tmp_path / "file"
    for bit in rng.choice(8 * len(whole), 200, replace=False):
        changed = bytearray(whole)
        changed[bit // 8] ^= 1 << bit % 8
        path.write_bytes(changed)
        with pytest.raises(_cpp.files.Damaged, match="is damaged|no seal"):
            _cpp.files.SealedFile(str(path))
    for length in (0, 10, len(data), len(whole) - 1):
        path.write_bytes(whole[:length])
        with pytest.raises(_cpp.files.Damaged, match="no seal"):
            _cpp.files.SealedFile(str(path))
    # A footer whose number of sections no file has: nothing is allocated for them.
    path.write_bytes(struct.pack("<8sq", b"IMPACT\r\n", 2**62) + digest(b""))
    with pytest.raises(_cpp.files.Damaged, match="no seal"):
        _cpp.files.SealedFile(str(path))


def test_a_file_that_is_not_there_is_an_error_of_the_system(tmp_path):
    with pytest.raises(OSError, match="No such file") as error:
        _cpp.files.SealedFile(str(tmp_path / "none"))
    assert error.value.errno == 2


def test_blocks_take_whole_numbers_only():
    """Of every type of a state, by their limits."""
    for kind in (np.int8, np.int32, np.int64):
        state, values = _cpp.state.State(), np.zeros(2, dtype=kind)
        state.add("number", _cpp.state.Place.cell, values)
        (block,) = _cpp.files.blocks(state)
        low, high = np.iinfo(kind).min, np.iinfo(kind).max
        largest = float(high) if kind != np.int64 else float(2**63 - 1024)  # the largest real number below 2^63
        block.assign(np.array([[float(low)], [largest]]))
        assert values[0] == low and values[1] == int(largest)
        np.testing.assert_array_equal(block.values(), [[float(low)], [largest]])
        for wrong in (0.5, float(low) * 1.1, float(high) * 1.1 + 1.0, np.nan, np.inf, -np.inf):
            with pytest.raises(ValueError, match="no whole numbers"):
                block.assign(np.array([[1.0], [wrong]]))
