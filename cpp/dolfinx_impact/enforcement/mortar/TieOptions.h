// SPDX-License-Identifier: MIT
#pragma once
#include "../../gap/mortar.h"
#include <optional>
#include <string>

namespace dolfinx_impact::enforcement
{
/// What may be chosen of a tie.
struct TieOptions
{
  std::string name = "tie";                            ///< for messages
  bool normal_only = false;                            ///< tied along the normal alone: surfaces slide without friction
  bool partial = false;                                ///< slave nodes without a master are left free
  gap::Multipliers basis = gap::Multipliers::dual;     ///< of the tractions
  std::optional<int> quadrature_degree = std::nullopt; ///< nothing: exact on flat, affine facets
  double search_distance = 0.0;                        ///< slave and master are paired within it; 0: twice a facet [L]
  bool axisymmetric = false;                           ///< x is the radius
};
} // namespace dolfinx_impact::enforcement
