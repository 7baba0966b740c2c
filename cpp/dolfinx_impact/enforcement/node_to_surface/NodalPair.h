// SPDX-License-Identifier: MIT
#pragma once
#include "NodePenalty.h"
#include <array>
#include <concepts>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace dolfinx_impact::enforcement
{
/// Contact of a pair as the explicit integrator has it: one direction, the slave's nodes against the master, or both.
/// In balanced (two-pass) contact the master's nodes are also pushed out of the slave.
class NodalPair
{
public:
  /// One direction.
  template <std::derived_from<NodalContact> T>
  NodalPair(std::shared_ptr<T> contact) : _directions{std::move(contact)}
  {
  }
  /// @param[in] directions the first one has the slave of the pair; the second one, if any, has both surfaces exchanged
  /// @throws std::invalid_argument for other numbers of directions
  explicit NodalPair(std::vector<std::shared_ptr<NodalContact>> directions);

  const std::vector<std::shared_ptr<NodalContact>>& directions() const { return _directions; }
  /// Sums of all directions, of this rank.
  ContactEnergy energy() const;
  /// Force on the slave of the pair in the last step, of this rank [F].
  std::array<double, 3> force() const;
  /// First moment of the forces on the slave, see NodalContact::force_moment [F L].
  gap::Matrix3 force_moment() const { return _directions.front()->force_moment(); }
  /// What the next step starts from, of each direction; the first one has the force of the pair, a second one none.
  std::vector<state::State> saved_states() const;
  /// Go on from what `saved_states` has returned, perhaps on other ranks.
  /// @throws std::invalid_argument for states of other nodes
  void resume(const std::vector<state::State>& saved);
  /// The node of this rank, on either surface, that passed through the other one farthest.
  Passage passage() const;

  /// Upper bound of the angular frequency that springs of given stiffness add, wherever the bodies meet. Collective
  /// [1/T].
  /// @param[in] mass of owned nodes of the space [M]
  double spring_frequency(std::span<const double> mass) const;
  /// Upper bound of the damping over the mass that contact adds. Collective [1/T].
  /// @param[in] mass of owned nodes of the space [M]
  double damping_rate(std::span<const double> mass) const;

private:
  std::vector<std::shared_ptr<NodalContact>> _directions;
};

/// Both directions of contact by penalty, each with half of the stiffness. Collective.
/// @param[in] V displacement space
/// @param[in] slave, master this rank's facets (make_surface)
/// @param[in] options of the pair; their share is divided between the directions
/// @throws std::invalid_argument as the constructor of NodePenalty
NodalPair balanced_penalty(const surface::FunctionSpace& V, const surface::Facets& slave, const surface::Facets& master,
                           NodePenaltyOptions options);
} // namespace dolfinx_impact::enforcement
