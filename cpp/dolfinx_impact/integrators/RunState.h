// SPDX-License-Identifier: MIT
#pragma once
#include "../state/State.h"
#include "ContactForces.h"
#include "EnergyBalance.h"
#include "ForceTerm.h"
#include <vector>

namespace dolfinx_impact::integrators
{
/// All that explicit steps go on from beside the states of contacts and materials. Arrays have owned entries.
struct RunState
{
  /// A force and the work that it has done.
  struct Term
  {
    std::vector<double> force; ///< [F]
    Work work;
    double position = 0.0; ///< displacement times force [F L]
  };

  /// Zeros.
  /// @param[in] num_owned degrees of freedom
  /// @param[in] num_bodies rigid bodies
  RunState(std::size_t num_owned, std::size_t num_terms, std::size_t num_contacts, std::size_t num_bodies);

  /// As a tree of named arrays, views: those of nodes, and the parts "works", sums over ranks, "common", the
  /// same on all ranks, and "body0", ..., of no rank.
  /// @param[in] bs components of a node
  state::State state(std::size_t bs);

  std::vector<double> u, v, r; ///< displacement, velocity half a step ago, residual force
  std::vector<Term> terms;
  Term springs;                  ///< of contact
  std::vector<double> kinematic; ///< forces of kinematic contact [F]
  EnergyBalance::Saved energies;
  double obstacle_work = 0.0;                 ///< adds up over ranks [F L]
  double last_step = 0.0, contact_step = 0.0; ///< [T]
  double unwatched = 0.0;                     ///< steps since the last look at deformations [1]
  std::vector<ContactForces::Obstacle> obstacles;
  std::vector<RigidBodyState> bodies;
};
} // namespace dolfinx_impact::integrators
