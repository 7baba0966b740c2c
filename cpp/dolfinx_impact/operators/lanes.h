// SPDX-License-Identifier: MIT
#pragma once
#include <cstddef>
#include <cstdint>

/// Memory of kernels, whose vectors of several lanes are aligned to cache lines.
namespace dolfinx_impact::operators
{
inline constexpr std::size_t alignment = 64; ///< [bytes]
inline constexpr std::size_t doubles_per_line = alignment / sizeof(double);

/// First aligned place from p on, at most doubles_per_line - 1 entries behind it.
inline double* aligned(double* p)
{
  const std::size_t beyond = reinterpret_cast<std::uintptr_t>(p) % alignment;
  return beyond == 0 ? p : p + (alignment - beyond) / sizeof(double);
}

/// Entries of an array rounded up to whole cache lines.
inline std::size_t whole_lines(std::size_t n)
{
  return (n + doubles_per_line - 1) / doubles_per_line * doubles_per_line;
}
} // namespace dolfinx_impact::operators
