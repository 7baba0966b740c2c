// SPDX-License-Identifier: MIT
#pragma once
#include "../../gap/GapAdjustment.h"
#include "../../gap/mortar.h"
#include "../interface/FrictionLaw.h"
#include <optional>
#include <string>

namespace dolfinx_impact::enforcement
{
/// Which slip a contact's law of friction is of.
enum class Slip
{
  of_increments, ///< displacements of slave against master in load steps
  of_flow        ///< velocities of bodies that flow through their meshes (rolling::RollingContact)
};

/// What may be chosen of a contact by multipliers.
struct MortarOptions
{
  std::string name = "contact";                        ///< for messages
  double friction = 0.0;                               ///< coefficient, without `friction_law` [1]
  gap::Multipliers basis = gap::Multipliers::dual;     ///< against rigid masters: dual
  std::optional<int> quadrature_degree = std::nullopt; ///< nothing: exact on flat, affine facets
  double search_distance = 0.0;                        ///< slave and master are paired within it; 0: twice a facet [L]
  bool axisymmetric = false;                           ///< x is the radius
  gap::GapAdjustment adjustment = {};                  ///< of gaps in the reference configuration
  bool may_share_nodes = true;                         ///< with other contacts
  Slip slip = Slip::of_increments;                     ///< that friction is of
  std::shared_ptr<const FrictionLaw> friction_law = nullptr; ///< null: a constant coefficient

  bool has_friction() const { return friction > 0.0 || friction_law; }
};
} // namespace dolfinx_impact::enforcement
