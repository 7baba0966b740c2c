// SPDX-License-Identifier: MIT
#include "Seal.h"
#include "Damaged.h"
#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <stdexcept>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>

namespace dolfinx_impact::files
{
namespace
{
constexpr std::int64_t row_size = 32;                // length, whether data, checksum
constexpr std::int64_t footer_size = 32;             // mark, number of sections, checksum of their table
constexpr std::int64_t longest = 1 << 23;            // section, which is verified to read one row [bytes]
constexpr char seal_mark[9] = "IMPACT\r\n";          // with an end of line, so that a transfer as text changes it
constexpr std::int64_t most = std::int64_t(1) << 62; // bytes of a file

void put_number(std::vector<std::byte>& out, std::int64_t value)
{
  for (int i = 0; i < 8; ++i)
    out.push_back(std::byte(std::uint64_t(value) >> (8 * i)));
}

std::int64_t get_number(const std::byte* at)
{
  std::uint64_t out = 0;
  for (int i = 0; i < 8; ++i)
    out |= std::uint64_t(at[i]) << (8 * i);
  return std::int64_t(out);
}

void put_sum(std::vector<std::byte>& out, const Checksum& sum)
{
  const auto bytes = std::as_bytes(std::span(sum));
  out.insert(out.end(), bytes.begin(), bytes.end());
}

Checksum get_sum(const std::byte* at)
{
  Checksum out;
  std::memcpy(out.data(), at, out.size());
  return out;
}
} // namespace

std::vector<Section> sections(std::int64_t offset, std::span<const std::byte> data)
{
  std::vector<Section> out;
  for (std::int64_t at = 0, size = std::int64_t(data.size()); at < size; at += longest)
  {
    const std::int64_t length = std::min(longest, size - at);
    out.push_back({offset + at, length, true, checksum(data.subspan(at, length))});
  }
  return out;
}

std::vector<std::byte> seal(std::vector<Section> data,
                            const std::function<std::vector<std::byte>(std::int64_t, std::int64_t)>& structure,
                            std::int64_t size)
{
  std::ranges::sort(data, {}, &Section::offset);
  data.push_back({size, 0, true, {}});
  std::vector<std::byte> out;
  std::int64_t at = 0, count = 0;
  const auto add = [&](std::int64_t length, bool is_data, const Checksum& sum)
  {
    put_number(out, length);
    put_number(out, is_data);
    put_sum(out, sum);
    ++count;
  };
  for (const Section& s : data)
  {
    for (std::int64_t begin = at; begin < s.offset; begin += longest)
    {
      const std::int64_t end = std::min(begin + longest, s.offset);
      add(end - begin, false, checksum(structure(begin, end)));
    }
    if (s.offset < at)
      throw std::invalid_argument("sections of a file overlap or stand behind its end");
    if (s.length > 0)
      add(s.length, s.data, s.sum);
    at = s.offset + s.length;
  }
  const Checksum whole = checksum(out);
  const auto mark = std::as_bytes(std::span(seal_mark, 8));
  out.insert(out.end(), mark.begin(), mark.end());
  put_number(out, count);
  put_sum(out, whole);
  return out;
}

SealedFile::SealedFile(const std::filesystem::path& path) : _path(path)
{
  _file = ::open(_path.c_str(), O_RDONLY | O_CLOEXEC);
  if (_file < 0)
    throw std::system_error(errno, std::generic_category(), _path);
  try
  {
    read_table();
  }
  catch (...)
  {
    ::close(_file);
    throw;
  }
}

SealedFile::~SealedFile()
{
  ::close(_file);
}

void SealedFile::read_table()
{
  struct stat status = {};
  if (::fstat(_file, &status) != 0)
    throw std::system_error(errno, std::generic_category(), _path);
  const std::int64_t whole = status.st_size;
  std::int64_t count = -1;
  if (whole >= footer_size)
  {
    const std::vector<std::byte> footer = bytes(whole - footer_size, footer_size);
    if (std::memcmp(footer.data(), seal_mark, 8) == 0)
      count = get_number(footer.data() + 8);
    _mark = get_sum(footer.data() + 16);
  }
  if (count < 0 || count > (whole - footer_size) / row_size)
    throw Damaged("it has no seal at its end: it was cut short, or another program has changed it");
  _size = whole - footer_size - row_size * count;
  const std::vector<std::byte> table = bytes(_size, row_size * count);
  std::int64_t at = 0;
  bool right = checksum(table) == _mark;
  for (std::int64_t k = 0; right && k < count; ++k)
  {
    const std::byte* row = table.data() + k * row_size;
    const Section s{at, get_number(row), get_number(row + 8) != 0, get_sum(row + 16)};
    right = s.length >= 0 && s.length < most - at;
    at += s.length;
    _sections.push_back(s);
  }
  if (!right || at != _size)
    throw Damaged("its seal is damaged");
  for (const Section& s : _sections)
    if (!s.data)
      section(s, "the structure of the file");
}

std::vector<std::byte> SealedFile::bytes(std::int64_t offset, std::int64_t length) const
{
  std::vector<std::byte> out(length);
  for (std::int64_t done = 0; done < length;)
  {
    const ssize_t count = ::pread(_file, out.data() + done, length - done, offset + done);
    if (count < 0 && errno == EINTR)
      continue;
    if (count < 0)
      throw std::system_error(errno, std::generic_category(), _path);
    if (count == 0)
      throw Damaged("it ends too early");
    done += count;
  }
  return out;
}

std::vector<std::byte> SealedFile::section(const Section& s, const std::string& name) const
{
  std::vector<std::byte> out = bytes(s.offset, s.length);
  if (checksum(out) != s.sum)
    throw Damaged(name + " is damaged");
  return out;
}

std::vector<std::byte> SealedFile::read(const std::string& name, std::int64_t offset, std::int64_t length) const
{
  if (offset < 0 || length < 0 || offset > _size || length > _size - offset)
    throw Damaged(name + " lies outside the file");
  std::vector<std::byte> out;
  if (length == 0)
    return out;
  out.reserve(length);
  // Sections are in the order of their offsets: the last one that begins at or before the range.
  auto s = std::ranges::upper_bound(_sections, offset, {}, &Section::offset) - 1;
  for (; s != _sections.end() && s->offset < offset + length; ++s)
  {
    const std::vector<std::byte> part = section(*s, name);
    const std::int64_t first = std::max(offset - s->offset, std::int64_t(0));
    const std::int64_t last = std::min(offset + length - s->offset, s->length);
    if (first < last) // a section may be empty
      out.insert(out.end(), part.begin() + first, part.begin() + last);
  }
  return out;
}
} // namespace dolfinx_impact::files
