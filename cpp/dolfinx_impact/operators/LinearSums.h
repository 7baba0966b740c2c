// SPDX-License-Identifier: MIT
#pragma once
#include "Batches.h"
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace dolfinx_impact::operators
{
/// Sums over cells at the nodes of a scalar space that are linear in a field, as those of tr(eps) N_a: a row for each
/// node with an entry for each component of each node that shares a cell with it. To multiply by it takes a third (in
/// cache) to a half (from memory) of the time of a sweep over linear tetrahedra, for 24 bytes and a node's number for
/// each of these neighbours: about 80 bytes a tetrahedron.
class LinearSums
{
public:
  /// @param[in] integrals kernels of rank 1 with one value for each node, without internal variables, linear in the
  ///   field
  /// @param[in] field name that the kernels have for it; other coefficients are taken as zero
  /// @throws std::invalid_argument if a kernel has no coefficient of that name or internal variables, or kernels differ
  ///   in the number of its components
  LinearSums(std::span<const Batches> integrals, const std::string& field);

  /// Sums of this rank's cells at all nodes of the rows' space, owned and ghosts; zero at nodes without cells.
  /// @param[in] values of the field
  /// @param[in] stride entries that a node has in them
  /// @param[out] sums one for each node
  void multiply(const double* values, int stride, std::span<double> sums) const;

private:
  void set_pattern(std::span<const Batches> integrals, const std::string& field);
  std::size_t entry(std::int32_t row, std::int32_t column) const;

  int _components = 0;
  std::vector<std::size_t> _ends;     ///< of each row among the columns
  std::vector<std::int32_t> _columns; ///< nodes of the field, in increasing order in each row
  std::vector<double> _entries;       ///< those of a column one after the other
};
} // namespace dolfinx_impact::operators
