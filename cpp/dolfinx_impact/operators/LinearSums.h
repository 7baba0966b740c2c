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
/// Laws of the stress of a mean gradient H of the displacement.
enum class MeanLaw
{
  linear_elastic, ///< lambda tr(eps) I + 2 mu eps, eps = sym H: means are those of the strain
  neo_hookean     ///< mu (F - F^-T), F = I + H: means are those of the gradient
};

/// A law with its constants [F/L^2].
struct MeanStress
{
  MeanLaw law = MeanLaw::linear_elastic;
  double lambda = 0.0; ///< of linear_elastic
  double mu = 0.0;
};

/// Sums over cells at nodes that are linear in a field, as those of tr(eps) N_a, of the strain eps N_a or of the
/// gradient (grad u) N_a: a row for each node with the integral of N_a grad N_b for each node b that shares a cell with
/// it. Strain and gradient have the entries of the trace. To multiply by it takes a third (in cache) to a half (from
/// memory) of the time of a sweep over linear tetrahedra, for 24 bytes and a node's number for each of these
/// neighbours: about 80 bytes a tetrahedron.
///
/// Strains are vectors of their normal components, then xy, in space yz and xz; gradients, of which component i is
/// derived by x_j, are vectors of their rows i.
class LinearSums
{
public:
  /// @param[in] integrals kernels of rank 1 without internal variables, linear in the field, of one value for each
  ///   node, or of the components of the field's strain or gradient
  /// @param[in] field name that the kernels have for it; other coefficients are taken as zero
  /// @throws std::invalid_argument if a kernel has no coefficient of that name or internal variables, kernels differ
  ///   in the number of its components, or several values of a node are neither strain nor gradient
  LinearSums(std::span<const Batches> integrals, const std::string& field);

  /// Sums of this rank's cells at all nodes of the rows' space, owned and ghosts; zero at nodes without cells.
  /// @param[in] values of the field
  /// @param[in] stride entries that a node has in them
  /// @param[out] sums one for each node, or each component of its strain or gradient
  void multiply(const double* values, int stride, std::span<double> sums) const;

  /// Of sums of a strain or gradient: nodal forces of the stress of each node's mean, in one pass where only this
  /// rank's cells count.
  /// @param[in] stress whose law has such means
  /// @param[in] inverse_volumes by which the sums of a node are multiplied to get its mean
  /// @param[in] shared is a node one of several ranks? What they have are sums, and no force yet.
  /// @param[out] sums at shared nodes; others are left as they are
  /// @param[in,out] b forces are added, with `stride` entries for each node of the field
  /// @throws std::invalid_argument if the law has other means
  void add_forces(const MeanStress& stress, std::span<const double> inverse_volumes,
                  std::span<const std::int8_t> shared, const double* values, int stride, std::span<double> sums,
                  double* b) const;
  /// The forces of some nodes.
  /// @param[in] means theirs, with those of all other nodes
  void add_forces_of(std::span<const std::int32_t> nodes, const MeanStress& stress, std::span<const double> means,
                     int stride, double* b) const;

private:
  void set_pattern(std::span<const Batches> integrals, const std::string& field);
  std::size_t entry(std::int32_t row, std::int32_t column) const;
  void add_gradients(std::span<const double> A, std::size_t row, std::size_t column, std::size_t num_columns,
                     double* to) const;
  void check_size(std::span<const double> sums) const;
  void check_law(const MeanStress& stress) const;

  int _components = 0;                ///< of the field
  int _measures = 1;                  ///< values of a node that are summed up
  std::vector<std::size_t> _ends;     ///< of each row among the columns
  std::vector<std::int32_t> _columns; ///< nodes of the field, in increasing order in each row
  std::vector<double> _entries;       ///< those of a column one after the other
};
} // namespace dolfinx_impact::operators
