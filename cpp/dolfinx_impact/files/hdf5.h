// SPDX-License-Identifier: MIT
#pragma once
#include "Attribute.h"
#include "FileInMemory.h"
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

/// The structure of HDF5 files: attributes and contiguous tables. Rows are written and read beside HDF5.
namespace dolfinx_impact::files
{
enum class Kind
{
  real,  ///< double
  whole, ///< std::int64_t
  other
};

/// Shape and type of a table, and where its rows are.
struct Table
{
  std::vector<std::size_t> shape;
  Kind kind = Kind::real;
  std::int64_t offset = 0; ///< of the first row in the file; of no meaning without rows [bytes]

  std::size_t size() const;
};

/// Tables by the names of the groups that they are in, as nodes/u.
typedef std::map<std::string, Table> Tables;

/// What an HDF5 file has.
struct Structure
{
  Attributes attributes;
  Tables tables;

  /// Null if there is none of that name.
  const Value* attribute(const std::string& name) const;
};

/// Lay out a file with attributes and room for tables, whose offsets are set.
/// @throws std::runtime_error if HDF5 cannot
FileInMemory lay_out(const Attributes& attributes, Tables& tables);

/// @throws std::runtime_error if HDF5 cannot read the file
Structure read_structure(const std::filesystem::path& path);
} // namespace dolfinx_impact::files
