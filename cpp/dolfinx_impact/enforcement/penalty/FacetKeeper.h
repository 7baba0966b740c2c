// SPDX-License-Identifier: MIT
#pragma once
#include "../../gap/points.h"
#include <cstdint>
#include <deque>
#include <mpi.h>
#include <span>
#include <vector>

namespace dolfinx_impact::enforcement
{
/// Prevents quadrature points from alternating between two facets of the master that meet at a kink, in the iterations
/// of Newton's method.
class FacetKeeper
{
public:
  /// Distance from its facet, in reference coordinates, up to which a point is assigned to it, and its largest value.
  static constexpr double margin = 0.01, widest = 0.32;

  /// @param[in] comm communicator of the mesh
  explicit FacetKeeper(MPI_Comm comm) : _comm(comm) {}

  /// Whether points remain assigned to a facet whose boundary they have crossed by less than their margin.
  bool stay() const { return _stay; }

  /// Begin an increment.
  /// @param[out] margins of the points, all set to the given one [1]
  void begin(std::span<double> margins, double given = margin);

  /// Compare the facets of an iteration with those of earlier ones. The margin of points that return to an earlier
  /// facet is doubled while `stay`. Otherwise `stay` becomes true when a point returns, or after some iterations.
  /// Collective.
  /// @param[in] facets of the master of closed points, -1 for open ones
  /// @param[in] kept whether facets have the numbers of the last iteration
  /// @param[in,out] margins of the points
  /// @returns number of this rank's closed points that have changed their facet
  int watch(std::span<const std::int32_t> facets, bool kept, std::span<double> margins);

  /// Release the points from their facets after convergence, once in an increment.
  /// @returns whether they have been released now
  bool leave();

private:
  MPI_Comm _comm;
  bool _stay = true;
  int _free = 0;                                 ///< iterations left in which points may change facets freely
  std::deque<std::vector<std::int32_t>> _facets; ///< of earlier iterations
};
} // namespace dolfinx_impact::enforcement
