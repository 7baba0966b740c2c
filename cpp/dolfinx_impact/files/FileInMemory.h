// SPDX-License-Identifier: MIT
#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <vector>

namespace dolfinx_impact::files
{
/// A file in memory that stores the pages that were written, and no others, which are zero: HDF5 lays a file out in it
/// whose tables may be larger than the memory. After a write that fails inside HDF5 the file is damaged, and the
/// process may be aborted when it ends; so HDF5 never writes to a disk here.
class FileInMemory
{
public:
  std::uint64_t size() const { return _size; }
  void resize(std::uint64_t size) { _size = size; }
  void write(std::uint64_t offset, std::span<const std::byte> data);
  void read(std::uint64_t offset, std::span<std::byte> data) const;
  /// Bytes of a range.
  std::vector<std::byte> content(std::uint64_t begin, std::uint64_t end) const;
  /// Pages that were written, by their number; the last one may end behind the end of the file.
  const std::map<std::uint64_t, std::vector<std::byte>>& pages() const { return _pages; }

  static constexpr std::uint64_t page_size = 4096; ///< [bytes]

private:
  std::map<std::uint64_t, std::vector<std::byte>> _pages;
  std::uint64_t _size = 0;
};
} // namespace dolfinx_impact::files
