// SPDX-License-Identifier: MIT
#pragma once
#include "checksum.h"
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

/// Seals: checksums of all bytes of a file, in sections that several ranks may write and verify. A table of the
/// sections and a footer follow behind the end of the HDF5 data, which HDF5 ignores. Sections follow each other without
/// a gap. The table has the length and checksum of each, and whether it is structure, which every rank reads first, or
/// data.
namespace dolfinx_impact::files
{
struct Section
{
  std::int64_t offset = 0; ///< in the file [bytes]
  std::int64_t length = 0; ///< [bytes]
  bool data = false;       ///< or structure
  Checksum sum = {};
};

/// Sections of data that will be written at an offset.
std::vector<Section> sections(std::int64_t offset, std::span<const std::byte> data);

/// Table of all sections, and footer, to be written behind the end of a file.
/// @param[in] data sections of data, of all ranks
/// @param[in] structure (begin, end) returns the bytes between them
/// @param[in] size of the file [bytes]
/// @throws std::invalid_argument if sections overlap, or lie behind the end
std::vector<std::byte> seal(std::vector<Section> data,
                            const std::function<std::vector<std::byte>(std::int64_t, std::int64_t)>& structure,
                            std::int64_t size);

/// A sealed file, open for reading.
class SealedFile
{
public:
  /// @throws std::system_error if the file cannot be read
  /// @throws Damaged if it has no seal, or the seal or the structure is damaged
  explicit SealedFile(const std::filesystem::path& path);
  ~SealedFile();
  SealedFile(const SealedFile&) = delete;
  SealedFile& operator=(const SealedFile&) = delete;

  /// Checksum of the table of sections, and thereby of the whole file.
  const Checksum& mark() const { return _mark; }
  const std::vector<Section>& sections() const { return _sections; }
  /// Bytes before the seal.
  std::int64_t size() const { return _size; }

  /// Read a range and verify its sections.
  /// @param[in] name of the content, for messages
  /// @throws std::system_error if the file cannot be read
  /// @throws Damaged if a section is damaged, or the range is not in the file
  std::vector<std::byte> read(const std::string& name, std::int64_t offset, std::int64_t length) const;

private:
  void read_table();
  std::vector<std::byte> bytes(std::int64_t offset, std::int64_t length) const;
  std::vector<std::byte> section(const Section& s, const std::string& name) const;

  std::string _path;
  int _file = -1;
  std::vector<Section> _sections;
  std::int64_t _size = 0;
  Checksum _mark = {};
};
} // namespace dolfinx_impact::files
