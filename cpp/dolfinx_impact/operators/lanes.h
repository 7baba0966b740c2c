// SPDX-License-Identifier: MIT
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

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

/// Memory that begins with a cache line. From 4 MB on it begins with a large page, which the system is asked for
/// (Linux's transparent huge pages): of the internal variables of plasticity, a batch of cells is about a page of 4 KB,
/// so that nearly every batch would wait for the address of its page.
/// @param[in] bytes
void* allocate_lines(std::size_t bytes);
/// Gives such memory back.
/// @param[in] p as allocated
/// @param[in] bytes as allocated
void free_lines(void* p, std::size_t bytes);

/// Memory of `allocate_lines`.
template <typename T>
struct AlignedAllocator
{
  typedef T value_type;
  AlignedAllocator() = default;
  template <typename U>
  AlignedAllocator(const AlignedAllocator<U>&)
  {
  }
  T* allocate(std::size_t n) { return static_cast<T*>(allocate_lines(n * sizeof(T))); }
  void deallocate(T* p, std::size_t n) { free_lines(p, n * sizeof(T)); }
  bool operator==(const AlignedAllocator&) const = default;
};
using AlignedVector = std::vector<double, AlignedAllocator<double>>;

/// Entries that a node takes in arrays which kernels read often: four for three components, so that a node is one
/// aligned load.
inline int padded_stride(int bs)
{
  return bs == 3 ? 4 : bs;
}

/// Entries of an array rounded up to whole cache lines.
inline std::size_t whole_lines(std::size_t n)
{
  return (n + doubles_per_line - 1) / doubles_per_line * doubles_per_line;
}
} // namespace dolfinx_impact::operators
