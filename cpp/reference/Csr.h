// SPDX-License-Identifier: MIT
#pragma once
#include "numbering.h"
#include <span>

namespace impact_reference
{
/// Square sparse matrix by rows; the column indices of a row increase.
struct Csr
{
  std::int64_t size = 0;
  std::vector<std::int64_t> indptr;  ///< (size + 1)
  std::vector<std::int64_t> indices; ///< (num_entries)
  std::vector<double> data;          ///< (num_entries)

  /// Matrix times vector.
  Vector dot(const Vector& x) const;
  /// Adds a matrix of the same pattern. @throws std::invalid_argument for another pattern
  void add(const Csr& other);
};

/// Nodes that share a cell with each node, sorted: the pattern of every matrix of a field.
class Pattern
{
public:
  explicit Pattern(const Field& field);

  /// Zero matrix with `block` x `block` entries per pair of neighbours.
  Csr matrix(int block) const;

  /// Adds an element matrix of the nodes `nodes` (block nodes.size() square), seed (3.26).
  void add(Csr& matrix, int block, const std::vector<std::int64_t>& nodes, const Matrix& element) const;

  /// Nodes that share a cell with `node`, itself included.
  std::span<const std::int64_t> neighbours(std::int64_t node) const
  {
    return {neighbours_.data() + offsets_[node], neighbours_.data() + offsets_[node + 1]};
  }

private:
  std::vector<std::int64_t> offsets_, neighbours_;
};
} // namespace impact_reference
