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
/// lambda and mu of an isotropic stress, lambda tr(eps) I + 2 mu eps [F/L^2].
struct IsotropicModuli
{
  double lambda = 0.0, mu = 0.0;
};

/// Sums over cells at nodes that are linear in a field, as those of tr(eps) N_a or of the strain eps N_a: a row for
/// each node with the integral of N_a grad N_b for each node b that shares a cell with it. The strain's sums have the
/// entries of those of its trace. To multiply by it takes a third (in cache) to a half (from memory) of the time of a
/// sweep over linear tetrahedra, for 24 bytes and a node's number for each of these neighbours: about 80 bytes a
/// tetrahedron.
///
/// Strains are vectors of their normal components, then xy, in space yz and xz.
class LinearSums
{
public:
  /// @param[in] integrals kernels of rank 1 without internal variables, linear in the field, of one value for each
  ///   node, or of the components of the field's strain
  /// @param[in] field name that the kernels have for it; other coefficients are taken as zero
  /// @throws std::invalid_argument if a kernel has no coefficient of that name or internal variables, kernels differ
  ///   in the number of its components, or several values of a node are not those of a strain
  LinearSums(std::span<const Batches> integrals, const std::string& field);

  /// Sums of this rank's cells at all nodes of the rows' space, owned and ghosts; zero at nodes without cells.
  /// @param[in] values of the field
  /// @param[in] stride entries that a node has in them
  /// @param[out] sums one for each node, or each component of its strain
  void multiply(const double* values, int stride, std::span<double> sums) const;

  /// Of sums of a strain: nodal forces of the stress of each node's mean strain, in one pass where only this rank's
  /// cells count.
  /// @param[in] inverse_volumes by which the sums of a node are multiplied to get its mean
  /// @param[in] shared is a node one of several ranks? What they have are sums, and no force yet.
  /// @param[out] sums of the strain at shared nodes; others are left as they are
  /// @param[in,out] b forces are added, with `stride` entries for each node of the field
  void add_forces(const IsotropicModuli& moduli, std::span<const double> inverse_volumes,
                  std::span<const std::int8_t> shared, const double* values, int stride, std::span<double> sums,
                  double* b) const;
  /// The forces of some nodes.
  /// @param[in] means their strains, with those of all other nodes
  void add_forces_of(std::span<const std::int32_t> nodes, const IsotropicModuli& moduli, std::span<const double> means,
                     int stride, double* b) const;

private:
  void set_pattern(std::span<const Batches> integrals, const std::string& field);
  std::size_t entry(std::int32_t row, std::int32_t column) const;
  void add_gradients(std::span<const double> A, std::size_t row, std::size_t column, std::size_t num_columns,
                     double* to) const;
  void check_size(std::span<const double> sums) const;

  int _components = 0;                ///< of the field
  int _measures = 1;                  ///< values of a node that are summed up
  std::vector<std::size_t> _ends;     ///< of each row among the columns
  std::vector<std::int32_t> _columns; ///< nodes of the field, in increasing order in each row
  std::vector<double> _entries;       ///< those of a column one after the other
};
} // namespace dolfinx_impact::operators
