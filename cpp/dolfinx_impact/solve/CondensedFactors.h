// SPDX-License-Identifier: MIT
#pragma once
#include "../enforcement/mortar/Condensation.h"
#include <cstdint>
#include <memory>
#include <petscmat.h>
#include <petscvec.h>
#include <span>
#include <vector>

namespace dolfinx_impact::solve
{
/// Factors of a condensed system (CondensedSystem) as a map from nodal forces to displacement increments, under the
/// conditions and supports of that system.
class CondensedFactors
{
public:
  /// Collective.
  /// @param[in] factors of the system's matrix, borrowed
  /// @param[in] condensation of that system, whose known increments are set to zero
  /// @param[in] pinned unknowns of that system
  CondensedFactors(Mat factors, std::shared_ptr<enforcement::Condensation> condensation,
                   std::vector<std::int8_t> pinned);
  ~CondensedFactors();
  CondensedFactors(const CondensedFactors&) = delete;
  CondensedFactors& operator=(const CondensedFactors&) = delete;

  const enforcement::Condensation& condensation() const { return *_condensation; }
  std::size_t num_owned() const { return _pinned.size(); }
  /// Displacement increments, owned [L], of nodal forces, owned [F]. Collective.
  std::vector<double> solve(std::span<const double> forces) const;
  /// The same of several forces, which are solved for together.
  /// @param[in] forces those of k at [k*num_owned, (k + 1)*num_owned)
  /// @param[in,out] increments are added to, likewise
  void add_solutions(int num, std::span<const double> forces, std::span<double> increments) const;

private:
  Mat _factors;
  std::shared_ptr<enforcement::Condensation> _condensation;
  std::vector<std::int8_t> _pinned;
  Vec _right = nullptr, _answer = nullptr; ///< work
};
} // namespace dolfinx_impact::solve
