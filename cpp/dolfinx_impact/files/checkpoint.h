// SPDX-License-Identifier: MIT
#pragma once
#include "../state/State.h"
#include "Attribute.h"
#include <cstdint>
#include <dolfinx/fem/FunctionSpace.h>
#include <filesystem>
#include <string>
#include <vector>

/// Checkpoints: states in one HDF5 file, written by all ranks together, readable on any number of ranks. Nodal values
/// are stored by the global numbers that the nodes have when the file is written; a table has the nodes of each cell by
/// the cell's number in the mesh's input. A file is written under another name and renamed when it is complete, so that
/// the last checkpoint can always be opened. Checksums cover all bytes (Seal.h), and the whole file is checked before
/// any of it is used.
namespace dolfinx_impact::files
{
/// Of the files that are written and read.
inline constexpr std::int64_t format = 11;

/// Write a state. Collective.
/// @param[in] path of the file
/// @param[in] V displacement space; nodes are the blocks of its degrees of freedom
/// @param[in] state its parts at any depth have names of their own; see Block.h
/// @param[in] identity by what the problem is recognised, beside its mesh
/// @param[in] more texts, numbers and arrays by name
/// @throws common::Failure on all ranks: the file cannot be written, or no space is left; an earlier file is as it was
void write(const std::filesystem::path& path, const dolfinx::fem::FunctionSpace<double>& V, const state::State& state,
           const Identity& identity = {}, const Attributes& more = {});

/// What is wanted of a file, and what may be in it.
struct ReadOptions
{
  /// Names of attributes that must be there, beside those of the state.
  std::vector<std::string> more = {};
  /// Names of vectors of ranks that are equal on all ranks; others add up.
  std::vector<std::string> equal = {};
  /// Names, up to digits at their ends, of tables that may have infinite values.
  std::vector<std::string> infinite = {};
  /// Names, up to digits at their ends, of tables at some nodes that files of earlier versions lack: zeros are read.
  std::vector<std::string> later = {"other_spring"};
};

/// Contents of a file.
struct Saved
{
  state::State state;    ///< with values of its own
  Attributes attributes; ///< all that the file has
};

/// Read a state that `write` has written, on these ranks or on others. Collective.
/// @param[in] like state with the structure that is wanted; its values are not read
/// @throws common::Failure on all ranks: the file cannot be read, or is damaged
/// @throws common::BadValue on all ranks: the file belongs to another problem, or has values that no state has
Saved read(const std::filesystem::path& path, const dolfinx::fem::FunctionSpace<double>& V, const state::State& like,
           const Identity& identity = {}, const ReadOptions& options = {});
} // namespace dolfinx_impact::files
