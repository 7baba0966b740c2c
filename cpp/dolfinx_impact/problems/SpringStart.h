// SPDX-License-Identifier: MIT
#pragma once
#include "../enforcement/StaticContact.h"
#include "ExplicitProblem.h"
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace dolfinx_impact::problems
{
/// Springs of an explicit contact that bear what a contact in equilibrium bears.
///
/// A contact by multipliers has no penetration, and springs need one. The slave body is moved against the master until
/// the springs bear the same force: what their compliance takes from the approach of the bodies is given back. The
/// tractions of friction become the tangential forces of the springs.
class SpringStart
{
public:
  /// Collective.
  /// @param[in] steady contact in equilibrium
  /// @param[in] problem explicit problem in the same state, started; outlives this object
  /// @param[in] contact its number there; its springs are NodePenalty
  /// @param[in] supports_move whether supports of the slave body move with it; otherwise it is moved in the directions
  /// in which none of its nodes is held
  /// @throws std::invalid_argument for a contact of another kind, or of another number
  SpringStart(std::shared_ptr<const enforcement::StaticContact> steady, ExplicitProblem& problem, std::size_t contact,
              bool supports_move);

  /// How far the slave body must be moved against the normal for the springs to bear the force, found to 1e-6 of it.
  /// Collective [L].
  /// @throws common::Failure if no approach was found
  double approach() const;
  /// May the slave body be moved? Not where supports hold it in each direction of the force.
  bool can_approach() const { return _force > 0.0; }
  /// Move the slave body against the normal.
  /// @param[in,out] u displacements, owned and ghosts [L]
  /// @param[in] distance by which it is moved [L]
  void move(std::span<double> u, double distance) const;
  /// Give springs to nodes that bear in equilibrium and have none, as bodies that supports hold cannot be moved: their
  /// gaps are zero but for round-off. The forces of the start are then to be computed anew. Collective.
  /// @returns whether there are such nodes on any rank
  bool close_nodes();
  /// Give the springs the nodal forces of the equilibrium; the forces of the start are then to be computed anew.
  /// Collective.
  ///
  /// Both sides of a balanced pair bear a half each: springs of either get half of the forces on their nodes.
  ///
  /// Bodies that are moved against each other penetrate everywhere by the same amount, pressures in equilibrium are not
  /// the same everywhere: what is left is an offset of the gap of each node, until the node opens.
  void hand_over();

private:
  double excess(double distance) const;
  bool close_nodes_of(enforcement::NodePenalty& springs) const;
  void hand_over_to(enforcement::NodePenalty& springs) const;

  std::shared_ptr<const enforcement::StaticContact> _steady;
  ExplicitProblem& _problem;
  enforcement::NodalPair _pair;
  /// Of the pair's slave; of a balanced pair of its master, too, each of which bears a part of the force.
  std::vector<std::shared_ptr<enforcement::NodePenalty>> _springs;
  int _gdim;
  std::vector<std::int32_t> _nodes; ///< of the slave body, owned and ghosts
  std::vector<double> _mass;        ///< of owned nodes [M]
  std::array<double, 3> _normal{};  ///< of the force on the slave body; zero without one
  double _force = 0.0;              ///< that presses the bodies together, of all ranks [F]
};
} // namespace dolfinx_impact::problems
