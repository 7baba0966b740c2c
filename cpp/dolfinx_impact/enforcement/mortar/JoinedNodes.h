// SPDX-License-Identifier: MIT
#pragma once
#include "MortarGeometry.h"

namespace dolfinx_impact::enforcement
{
/// Slave nodes that several pairs have in common and whose normals agree: one constraint for all; docs/contact.md.
/// Pairs number the nodes that they join alike: nodes of one number are one node of the mesh with one normal. Its
/// weight, weighted gap, weighted jump and row of M are the sums over the pairs, so that it has one constraint and one
/// multiplier; each pair's force is its own part of it. Calls are collective but those that say otherwise.
class JoinedNodes
{
public:
  /// Join nodes; the geometries refer to the object from then on, and it to them: all of them live as long as one is
  /// used.
  /// @param[in] numbers of the nodes of each pair
  /// @param[in] count of the numbers
  static void join(std::vector<MortarGeometry*> geometries, std::vector<std::vector<std::int32_t>> numbers,
                   std::size_t count);

  JoinedNodes(std::vector<MortarGeometry*> geometries, std::vector<std::vector<std::int32_t>> numbers,
              std::size_t count);

  /// Gaps of all pairs, unless they are those of this state already.
  /// @param[in] u displacements, owned and ghosts [L]
  void update(std::span<const double> u);
  /// As MortarGeometry::evaluate_at.
  /// @param[in] k number of the pair, also below
  GapAndSlip evaluate_at(int k, std::span<const double> u);
  /// Forget the states that gaps are known of. Not collective.
  void forget();

  /// As MortarGeometry::jump.
  std::vector<double> jump(int k, std::span<const double> moved) const;
  /// Sum of M times values over the pairs, at the nodes of one.
  std::vector<double> over_master(int k, std::span<const double> values) const;
  /// Rows of the sum of D over the sum of M. Not collective.
  gap::MasterRows master_rows(int k, std::span<const std::int32_t> rows) const;
  /// Nodal forces of the tractions at a pair's carriers, of all pairs that share them, owned [F].
  std::vector<double> forces(int k, std::span<const double> traction) const;
  /// Mean over the pairs, weighted with their covers, at the nodes of one. Not collective.
  /// @param[in] values one of each pair
  std::vector<double> mean(int k, std::span<const double> values) const;
  /// Index among another pair's nodes of each node of a pair, -1 without. Not collective.
  std::vector<std::int32_t> rows_in(int k, int other) const;
  std::vector<const MortarGeometry*> members() const { return {_geometries.begin(), _geometries.end()}; }

private:
  /// All that gaps depend on, as one array.
  std::vector<double> known(std::span<const double> u) const;
  bool differs(const std::vector<double>& state, const std::vector<double>& before) const;
  void update_all(std::span<const double> u);
  void keep_nearest(std::vector<std::vector<std::int8_t>>& parts, std::span<const double> around) const;
  std::vector<std::vector<std::int8_t>> carriers(const std::vector<std::vector<std::int8_t>>& parts) const;
  /// Add values of a pair's nodes to sums by number.
  void add(std::size_t k, std::span<const double> values, std::vector<double>& sums) const;
  std::vector<std::size_t> distinct() const;

  std::vector<MortarGeometry*> _geometries;
  std::vector<std::vector<std::int32_t>> _numbers;
  std::size_t _count;
  std::vector<std::size_t> _sums_of; ///< of pairs with the same slave facets the first
  std::vector<double> _share;        ///< integrals of the nodes' functions over whole facets, by number [L^2]
  std::vector<double> _updated, _evaluated;
};
} // namespace dolfinx_impact::enforcement
