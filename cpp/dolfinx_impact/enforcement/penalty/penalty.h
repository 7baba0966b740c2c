// SPDX-License-Identifier: MIT
#pragma once
#include "../../gap/RigidMotion.h"
#include "../../gap/points.h"
#include "../ContactStatus.h"
#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace dolfinx_impact::enforcement
{
/// Penalty method at the slave's quadrature points (docs/contact.md; seed (3.48), corrected), augmented or not, with or
/// without Coulomb's friction (seed (3.43)).
struct PenaltyParameters
{
  double normal = 0.0;     ///< chi_N, pressure per penetration [F/L^3]
  double tangential = 0.0; ///< chi_T [F/L^3]; not used without friction
  double friction = 0.0;   ///< coefficient [1]
  /// Points whose pressure would be above minus this are closed, with no pressure: bodies that just touch [F/L^2].
  double touch = 0.0;
};

/// What points remember of the last converged state. Plain data: save it, and a run goes on where it was.
struct PenaltyHistory
{
  std::vector<double> multiplier; ///< lambda_q; zero in the pure penalty method [F/L^2]
  std::vector<double> traction;   ///< tangential, traction[q*gdim + c] [F/L^2]
  std::vector<double> slip;       ///< tangential, added up over the steps, slip[q*gdim + c] [L]
  std::vector<double> gap;        ///< of points that were open: infinite without master; of others not positive [L]
  std::vector<double> offset;     ///< added to the gaps: penetrations of the start that are removed [L]
  std::vector<double> depth;      ///< penetration, zero of points that were open [L]
};

/// The points in one state of displacements. Vectors per point: [q*gdim + c].
struct PenaltyState
{
  std::vector<ContactStatus> status;
  std::vector<double> pressure;   ///< [F/L^2]
  std::vector<double> tangential; ///< tangential traction on the slave [F/L^2]
  std::vector<double> traction;   ///< the whole traction on the slave: pressure * normal + tangential [F/L^2]
  std::vector<double> slip;       ///< the history's slip and this step's [L]
};

class LawPoints;

/// Motion of a rigid master since the last converged state: the point that is now at x has moved by
/// displacement + turn (x - centre).
struct RigidIncrement
{
  std::array<double, 3> displacement{}; ///< of the centre [L]
  gap::Matrix3 turn{};                  ///< see gap::RigidMotion [1]
  std::array<double, 3> centre{};       ///< now [L]
};

/// The pair in its present configuration. All refer to arrays that live elsewhere.
struct PenaltyPair
{
  const gap::Points& points;
  const surface::Facets& slave;
  const surface::Facets* master; ///< null: rigid
  PenaltyParameters parameters;
  const PenaltyHistory& history;
  /// Displacements since the last converged state at the nodes that the facets number, [node*gdim + c]; may be empty
  /// without friction [L].
  std::span<const double> increment;
  RigidIncrement rigid_increment{}; ///< the same of a rigid master
  /// A law of the interface in the place of the penalties and of friction, as it was evaluated last; null: none.
  const LawPoints* law = nullptr;
  /// Part of both penalties that each point has; empty: all of them [1].
  std::span<const double> share = {};

  double share_of(std::size_t q) const { return share.empty() ? 1.0 : share[q]; }
  double normal_penalty(std::size_t q) const { return parameters.normal * share_of(q); }
};

/// Takes a dense block of a matrix: nodes of its rows and columns, as the facets number them, and
/// block[(a*gdim + c)*nodes.size()*gdim + b*gdim + d].
typedef std::function<void(std::span<const std::int32_t> nodes, std::span<const double> block)> InsertBlock;

/// @returns history of points that just touched: gaps, tractions and multipliers are zero
PenaltyHistory make_history(const gap::Points& points);

/// Displacements of slave against master since the last converged state at the points that have a master, [q*gdim + c]
/// [L].
std::vector<double> relative_increments(const PenaltyPair& pair);

/// Pressures, tractions, slips and status. Of a law of the interface, whose points have been evaluated, they are its.
/// @throws std::invalid_argument for arrays of wrong sizes, friction without tangential stiffness
PenaltyState evaluate(const PenaltyPair& pair);

/// The tractions that would pull the closed points that are apart (see PenaltyParameters::touch) on the master: those
/// of springs, negative trial pressures; zero elsewhere.
PenaltyState stretched(const PenaltyPair& pair, const PenaltyState& state);

/// Sum of w p^2 / (2 chi_N) over this rank's points: its gradient is minus the contact force, without friction and
/// multipliers [F L].
double energy(const PenaltyPair& pair, const PenaltyState& state);

/// Add the contact force to the nodes that the facets number.
/// @param[in,out] force [node*gdim + c] [F]
void add_force(const PenaltyPair& pair, const PenaltyState& state, std::span<double> force);

/// Minus the derivative of the contact force, what the stiffness matrix gains: one block per pair of facets that touch.
/// @param[in] convex without what follows from points that slide and normals that turn, and without friction: positive
/// semi-definite, so that a step with it goes down
/// @param[in] insert is called with every block
void tangent(const PenaltyPair& pair, const PenaltyState& state, bool convex, const InsertBlock& insert);

/// Nodes of the slave and master facet of a point: those that its block couples. @returns their number
int coupled_nodes(const PenaltyPair& pair, std::size_t q, std::int32_t* nodes);

/// The state is the last converged one from now on. (`gap` is for the caller to set.)
void advance(const PenaltyState& state, PenaltyHistory& history);
} // namespace dolfinx_impact::enforcement
