// SPDX-License-Identifier: MIT
#pragma once
#include <cstddef>

namespace dolfinx_impact::search
{
/// A configuration given by nodal displacements: u, or u - back*du.
struct Configuration
{
  const double* u;            ///< displacements, u[node*gdim + c] [L]
  const double* du = nullptr; ///< increments of the step, as u; null: the configuration is u [L]
  double back = 1.0;          ///< part of the step that is taken back [1]
  bool stored = false;        ///< the configuration of the last `advance`: positions are stored

  /// Displacement k = node*gdim + c.
  double at(std::size_t k) const { return u[k] - (du ? back * du[k] : 0.0); }
};
} // namespace dolfinx_impact::search
