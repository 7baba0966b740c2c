// SPDX-License-Identifier: MIT
#include "FileInMemory.h"
#include <algorithm>

namespace dolfinx_impact::files
{
namespace
{
/// Call act(number of a page, first byte in it, first byte of the range, length) for each page of a range.
template <typename Act>
void for_pages(std::uint64_t offset, std::uint64_t length, Act act)
{
  for (std::uint64_t done = 0; done < length;)
  {
    const std::uint64_t number = (offset + done) / FileInMemory::page_size;
    const std::uint64_t first = (offset + done) % FileInMemory::page_size;
    const std::uint64_t part = std::min(length - done, FileInMemory::page_size - first);
    act(number, first, done, part);
    done += part;
  }
}
} // namespace

void FileInMemory::write(std::uint64_t offset, std::span<const std::byte> data)
{
  for_pages(offset, data.size(),
            [&](std::uint64_t number, std::uint64_t first, std::uint64_t done, std::uint64_t length)
            {
              std::vector<std::byte>& page = _pages[number];
              page.resize(page_size);
              std::ranges::copy(data.subspan(done, length), page.begin() + std::ptrdiff_t(first));
            });
  _size = std::max(_size, offset + data.size());
}

void FileInMemory::read(std::uint64_t offset, std::span<std::byte> data) const
{
  for_pages(offset, data.size(),
            [&](std::uint64_t number, std::uint64_t first, std::uint64_t done, std::uint64_t length)
            {
              const auto page = _pages.find(number);
              const std::span<std::byte> part = data.subspan(done, length);
              if (page == _pages.end())
                std::ranges::fill(part, std::byte(0));
              else
                std::ranges::copy(std::span(page->second).subspan(first, length), part.begin());
            });
}

std::vector<std::byte> FileInMemory::content(std::uint64_t begin, std::uint64_t end) const
{
  std::vector<std::byte> out(end - begin);
  read(begin, out);
  return out;
}
} // namespace dolfinx_impact::files
