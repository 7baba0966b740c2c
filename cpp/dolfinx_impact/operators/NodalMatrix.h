// SPDX-License-Identifier: MIT
#pragma once
#include <cstdint>
#include <dolfinx/common/IndexMap.h>
#include <memory>
#include <petscmat.h>
#include <span>
#include <vector>

namespace dolfinx_impact::operators
{
/// Square sparse matrix over the nodes of a map, filled block by block, ghost rows included. It is kept while the
/// blocks have a place in it and made anew, with the old places, when one has not.
class NodalMatrix
{
public:
  /// Rows and columns that are coupled: nodes of the map.
  struct Couplings
  {
    std::vector<std::int64_t> keys; ///< one number per coupling: the same number, the same nodes
    std::vector<std::int32_t> rows, columns;
    std::vector<std::size_t> row_ends, column_ends;
    void add(std::int64_t key, std::span<const std::int32_t> r, std::span<const std::int32_t> c);
  };

  NodalMatrix() = default;
  ~NodalMatrix();
  NodalMatrix(const NodalMatrix&) = delete;
  NodalMatrix& operator=(const NodalMatrix&) = delete;

  /// All entries zero, with places for the couplings. Collective.
  /// @param[in] map of the nodes; another one than the last time begins a new pattern
  /// @param[in] block_size entries per node
  void reset(const std::shared_ptr<const dolfinx::common::IndexMap>& map, int block_size, const Couplings& couplings);
  /// Add a dense block, block[(a*block_size + c)*columns.size()*block_size + b*block_size + d], where the couplings
  /// have a place for it.
  void add(std::span<const std::int32_t> rows, std::span<const std::int32_t> columns, std::span<const double> block);
  /// To be called after the last block; sends what belongs to other ranks. Collective.
  void finish();
  /// Begin a new pattern in the next reset.
  void forget() { _map.reset(); }
  /// Borrowed, valid until the next reset; null before the first.
  Mat matrix() const { return _matrix; }
  /// How many matrices were made so far.
  int num_created() const { return _num_created; }

private:
  bool fits(const Couplings& couplings) const;

  std::shared_ptr<const dolfinx::common::IndexMap> _map;
  int _block_size = 1, _num_created = 0;
  Couplings _known;                       ///< of the pattern
  std::vector<std::int64_t> _sorted_keys; ///< of _known
  Mat _matrix = nullptr;
};
} // namespace dolfinx_impact::operators
