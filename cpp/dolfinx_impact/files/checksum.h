// SPDX-License-Identifier: MIT
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

/// Files that a run goes on from: states written by all ranks together, readable on any number of ranks, every byte
/// under a checksum.
namespace dolfinx_impact::files
{
typedef std::array<std::uint8_t, 16> Checksum;

/// BLAKE2b with a digest of 16 bytes and without a key (RFC 7693).
Checksum checksum(std::span<const std::byte> data);
} // namespace dolfinx_impact::files
