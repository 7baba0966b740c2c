// SPDX-License-Identifier: MIT
#pragma once
#include "ContactLoop.h"
#include <span>
#include <vector>

namespace dolfinx_impact::hand_written
{
/// Penalty contact of nodes over quadrilaterals, written by hand for what every step of it must do and nothing else:
/// for comparison. Each slave node stays over its facet.
class HandWrittenContact
{
public:
  /// Does this processor have the vectors that it is written for (AVX2)?
  static bool available();
  /// @param[in] x positions of all nodes, shape (num_nodes, 3) [L]
  /// @param[in] slaves numbers of the slave nodes, a multiple of four of them
  /// @param[in] facets nodes of the facet below each of them, in DOLFINx's order, shape (num_slaves, 4); their
  /// tangents' product points to the slave
  /// @param[in] stiffness of each slave node [F/L]
  /// @param[in] friction coefficient [1]
  /// @throws std::invalid_argument for arrays whose sizes do not fit, nodes out of range, another processor
  HandWrittenContact(std::span<const double> x, std::span<const std::int32_t> slaves,
                     std::span<const std::int32_t> facets, double stiffness, double friction);
  /// Evaluate the forces of one step.
  /// @param[in] u displacements, shape (num_nodes, 3) [L]
  /// @param[in] du their increments, shape (num_nodes, 3) [L]
  /// @param[in] cold are the caches to be filled with other data before?
  /// @returns time that it takes [s]
  double evaluate(std::span<const double> u, std::span<const double> du, bool cold);
  /// Gaps of the slave nodes [L].
  std::vector<double> gap() const;
  /// Forces of all evaluations, shape (num_nodes, 3) [F].
  std::span<const double> forces() const { return _forces; }

private:
  std::vector<SlaveNode> _slaves;
  std::vector<FacetNode> _masters, _sums;
  std::vector<std::int32_t> _numbers;
  std::vector<double> _X, _forces, _others;
  double _stiffness, _friction;
};
} // namespace dolfinx_impact::hand_written
