// SPDX-License-Identifier: MIT
#pragma once
#include "../state/State.h"
#include "ContactStatus.h"
#include <array>
#include <mpi.h>
#include <optional>
#include <span>
#include <vector>

namespace dolfinx_impact::enforcement
{
/// This rank's contact points at the end of an increment. Vectors per point: [i*gdim + c].
struct ContactPoints
{
  int gdim = 3;
  std::span<const double> x;        ///< positions [L]
  std::span<const double> traction; ///< on the slave [F/L^2]
  std::span<const double> slip;     ///< accumulated in contact [L]
  std::span<const ContactStatus> status;
  std::span<const double> weight;  ///< areas [L^2]
  std::span<const double> covered; ///< part of each area that is in contact [1]
};

/// Totals of a contact over all ranks and the same on all.
struct ContactTotals
{
  bool known = false;             ///< whether force and moment are: not before the first converged increment
  std::array<double, 3> force{};  ///< on the slave, gdim entries; on the master it is the opposite [F]
  std::array<double, 3> moment{}; ///< of these forces about the origin, one entry in the plane, three in space [F L]
  double area = 0.0;              ///< in contact; a length in the plane [L^2]
  double dissipated = 0.0;  ///< work of friction so far: in each increment, tractions at its end times its slip [F L]
  std::vector<double> slip; ///< slips of this rank's points whose work is counted; empty: zero [L]

  /// Force on the slave; nothing before the first converged increment [F].
  std::optional<std::array<double, 3>> known_force() const { return known ? std::optional(force) : std::nullopt; }
  /// Sum up a converged increment. Collective.
  void update(MPI_Comm comm, const ContactPoints& points);
  /// Add the totals to what a checkpoint holds, values of its own; not a number where they are not known.
  void add_to(state::State& saved, int gdim) const;
  /// Set the totals from such a state.
  /// @param[in] counted slips of this rank's points [i*gdim + c] [L]
  void resume(const state::State& saved, std::vector<double> counted);
};
} // namespace dolfinx_impact::enforcement
