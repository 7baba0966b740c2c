// SPDX-License-Identifier: MIT
#pragma once
#include "../../common/prefetch.h"
#include "MomentCorrection.h"
#include "NodalSum.h"
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace dolfinx_impact::enforcement
{
/// Forces on the master's nodes in a step, by their position in NodeTracker's list of master nodes.
class MasterForces
{
public:
  void resize(std::size_t num) { _sums.assign(num, {}); }

  /// Ask the memory for the sums of a facet's nodes.
  void prefetch(int num, const std::int32_t* corners) const
  {
    for_nodes(num, [&](int j) { common::prefetch(_sums.data() + corners[j]); });
  }
  /// Subtract a force on a slave's node from the nodes of its facet.
  /// @param[in] corners positions of the nodes
  /// @param[in] phi shape functions at the master's point
  template <int D>
  void react(int num, const std::int32_t* corners, const double* phi, const double* force)
  {
    NodalSum* sums = _sums.data();
    for_nodes(num,
              [&](int j)
              {
                for (int c = 0; c < D; ++c)
                  sums[corners[j]].force[c] -= phi[j] * force[c];
              });
  }
  /// Add the moment correction of a force on a slave's node.
  /// @param[in] r as MomentCorrection::set returns
  /// @param[out] added by node of the facet, [j*D + c]; null: not wanted
  template <int D>
  void correct(const MomentCorrection& correction, int num, const std::int32_t* corners, const double* r,
               const double* force, double* added = nullptr)
  {
    NodalSum* sums = _sums.data();
    correction.forces<D>(num, r, force,
                         [&](int j, int c, double value)
                         {
                           sums[corners[j]].force[c] += value;
                           if (added)
                             added[j * D + c] = value;
                         });
  }
  /// Add all to the forces of the step; zero again for the next one.
  /// @param[in] nodes numbers of the master nodes
  /// @param[in,out] f forces, [node*gdim + c] [F]
  void add_to(std::span<const std::int32_t> nodes, int gdim, std::span<double> f)
  {
    for (std::size_t k = 0; k < nodes.size(); ++k)
      for (int c = 0; c < gdim; ++c)
        f[std::size_t(nodes[k]) * gdim + c] += std::exchange(_sums[k].force[c], 0.0);
  }

  /// The sums, by position of the nodes.
  NodalSum* data() { return _sums.data(); }

private:
  std::vector<NodalSum> _sums;
};
} // namespace dolfinx_impact::enforcement
