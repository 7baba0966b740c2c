// SPDX-License-Identifier: MIT
#pragma once
#include "../enforcement/StaticContact.h"
#include "LinearSystem.h"
#include "UpdatedFactors.h"
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

namespace dolfinx_impact::solve
{
/// Updates of an active set on a small dense problem, from responses of the bodies to unit changes at single nodes.
///
/// If the factors for one active set are known, the solution for another set is the sum of the solution for the first
/// set, the responses to normal forces at the nodes that have closed, and the responses to gaps at the nodes that have
/// opened. All responses are columns of one linear solution with several right-hand sides. The active set is then
/// updated without further linear solutions.
class LinearisedActiveSet
{
public:
  /// Forces of displacement increments, owned [F] of owned [L]. Collective.
  typedef std::function<std::vector<double>(std::span<const double>)> Product;

  /// Collective.
  /// @param[in] contact with linearised gap and multipliers of the solution, without friction
  /// @param[in] system of the solution, condensed
  /// @param[in] factors of the system's matrix
  /// @param[in] nodes of the displacement space
  LinearisedActiveSet(enforcement::MultiplierContact& contact, CondensedSystem& system, Mat factors, Product product,
                      const dolfinx::common::IndexMap& nodes);

  /// Update the contact's active set until no node is wrong. Collective.
  /// @returns displacement increments that are added to the solution, owned [L], and number of changes; nothing if the
  /// updates do not end or there are too many columns: the contact is then unchanged
  std::optional<std::pair<std::vector<double>, int>> update();
  /// Give away the responses, for further systems with the same factors. Collective.
  /// @param[in] condensation of the system that was solved
  std::unique_ptr<UpdatedFactors> updated_factors(std::shared_ptr<enforcement::Condensation> condensation);

private:
  void add(const std::vector<std::int64_t>& numbers);
  std::optional<std::vector<double>> solve(const std::vector<std::int64_t>& wanted) const;
  double column_value(std::int64_t number, const std::vector<double>& z) const;

  enforcement::MultiplierContact& _contact;
  CondensedSystem& _system;
  Mat _factors;
  Product _product;
  MPI_Comm _comm;
  std::vector<std::int8_t> _base;                                    ///< active set of the solution
  std::vector<double> _gap, _multiplier;                             ///< of the solution
  std::vector<std::int64_t> _columns;                                ///< global numbers of the nodes with responses
  std::vector<std::vector<double>> _increments, _gaps, _multipliers; ///< by column
  std::vector<int> _opened;                                          ///< by column: the node was active
};
} // namespace dolfinx_impact::solve
