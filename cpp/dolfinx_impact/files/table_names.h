// SPDX-License-Identifier: MIT
#pragma once
#include "Block.h"
#include <mpi.h>
#include <string>
#include <vector>

/// Names of tables in files.
namespace dolfinx_impact::files
{
inline constexpr const char* input_table = "cells/input"; ///< number of every cell in the mesh's input
inline constexpr const char* nodes_table = "cells/nodes"; ///< nodes of every cell
inline constexpr const char* x_table = "nodes/x";         ///< undeformed coordinates of all nodes

/// Table of the values of a block, which is no attribute.
std::string values_table(const Block& block);
/// Table of the nodes or facets of a block, which has some.
std::string numbers_table(const Block& block);

/// Refuse states that have other fields or parts on another rank: its rows would be mixed up. Collective.
/// @throws common::Failure on all ranks
void check_same(MPI_Comm comm, const std::vector<Block>& blocks);
} // namespace dolfinx_impact::files
