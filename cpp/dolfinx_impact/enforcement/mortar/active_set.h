// SPDX-License-Identifier: MIT
#pragma once
#include "../../gap/MortarIntegrals.h"
#include "Constraints.h"

namespace dolfinx_impact::enforcement
{
/// State of the nodes of a contact by multipliers in one iteration: the active set, the multipliers, and the gaps and
/// slips that a linear problem has led to. Arrays are by node, vectors [i*gdim + c]; docs/contact.md has the
/// conditions. Without friction what belongs to it may be empty.
struct NodalMultipliers
{
  int gdim = 3;
  double friction = 0.0;                     ///< coefficient [1]
  std::span<const std::int8_t> usable = {};  ///< nodes that carry a multiplier and may be moved along the normal
  std::span<const std::int8_t> active = {};  ///< in contact
  std::span<const double> gap = {};          ///< [L]
  std::span<const double> multiplier = {};   ///< [F/L^2]
  std::span<const std::int8_t> sliding = {}; ///< active and slipping
  std::span<const double> slip = {};         ///< in this step [L]
  std::span<const double> traction = {};     ///< of friction [F/L^2]
  std::span<const double> direction = {};    ///< of the friction traction of sliding nodes, unit vectors
  std::span<const double> opening = {};      ///< gap at the start of the step where a node was open, else 0 [L]
  std::span<const double> stiffness = {};    ///< of the bodies per area [F/L^3]
  std::span<const double> lock = {}; ///< projector on directions without slip, [(i*gdim + a)*gdim + b]; empty: none
  std::span<const double> roughness = {}; ///< coefficient of a node over `friction` [1]; empty: one everywhere

  std::size_t size() const { return active.size(); }
  /// Coefficient of friction of a node [1].
  double coefficient(std::size_t i) const { return roughness.empty() ? friction : friction * roughness[i]; }
};

/// @throws std::invalid_argument for arrays of other sizes
void check_sizes(const NodalMultipliers& now);
/// Does node i stick where it is?
bool sticks(const NodalMultipliers& now, std::size_t i);
/// Has node i closed in this step, and does not slip?
bool grips(const NodalMultipliers& now, std::size_t i);

struct ActiveSet
{
  std::vector<std::int8_t> active, sliding;
  std::vector<double> direction;
};

/// The active set that gaps, multipliers and slips ask for: a primal-dual active set method for the normal conditions
/// and Coulomb's law.
/// @param[in] first the step has just begun: only gaps count
/// @param[in] tolerance gaps below it are none [L]
/// @param[in] largest multiplier of all ranks [F/L^2]
/// @throws std::invalid_argument for arrays of other sizes
ActiveSet update_active_set(const NodalMultipliers& now, bool first, double tolerance, double largest);

/// Friction traction per pressure of nodes that slip or have closed in this step, [i*gdim + c]; else zero.
std::vector<double> friction_tilt(const NodalMultipliers& now);

/// Geometry of the same nodes where the linear problem is linearised.
struct NodalGeometry
{
  std::span<const std::int32_t> nodes; ///< owned blocks of the space
  std::span<const double> normal;      ///< [i*gdim + c]
  std::span<const double> gap, slip;   ///< [L], [i*gdim + c] [L]
  std::span<const double> weight;      ///< diagonal of D [L^2]
  std::span<const double> cover;       ///< part that faces a master [L^2]
  std::span<const std::int8_t> fixed;  ///< prescribed components, [i*gdim + c]
  std::span<const double> ahead;       ///< what prescribed components have yet to move, [i*gdim + c] [L]
  const NodalFrames& frames;
};

/// Numbers of the nodes that are constrained: active and usable.
std::vector<std::int32_t> constrained_nodes(const NodalMultipliers& now);

/// Constraints of the active nodes in the linear problem.
/// @param[in] tilt of friction_tilt
/// @param[in] facing rows of D^-1 M of constrained_nodes
Constraints constrain(const NodalMultipliers& now, const NodalGeometry& geometry, std::span<const double> tilt,
                      gap::MasterRows facing);

/// Multipliers and friction tractions from equilibrium of the slave's nodes.
/// @param[in] residual of the nodes, without contact forces, [i*gdim + c] [F]
/// @param[in] tilt of friction_tilt in the state that the residual belongs to
/// @param[in] known tractions that neither equilibrium nor pressure tells, [i*gdim + c] [F/L^2]; empty: none
/// @param[in] follow projector on directions where tractions follow from the law, as `lock`; empty: none
/// @param[out] multiplier, traction by node
void evaluate_multipliers(const NodalMultipliers& now, const NodalGeometry& geometry, std::span<const double> residual,
                          std::span<const double> tilt, std::span<const double> known, std::span<const double> follow,
                          std::span<double> multiplier, std::span<double> traction);

/// Multipliers and friction tractions from the solution of a saddle point.
/// @param[in] forces along the directions of the frames, [i*gdim + d] [F]
/// @param[in] tilt of friction_tilt in the state that the linear problem belongs to
/// @param[in] known tractions besides, see evaluate_multipliers
/// @param[out] multiplier, traction by node
void take_multipliers(const NodalMultipliers& now, const NodalGeometry& geometry, std::span<const double> forces,
                      std::span<const double> tilt, std::span<const double> known, std::span<double> multiplier,
                      std::span<double> traction);

/// Friction tractions that follow the surface to its present normals with their size; those of nodes that have closed
/// in this step follow from the slip. [i*gdim + c] [F/L^2]
std::vector<double> rotate_friction_traction(const NodalMultipliers& now, std::span<const double> normal);

/// Gaps of active nodes, slips of those that stick; zero elsewhere.
struct Violations
{
  std::vector<double> gap, slip; ///< [L]
};
/// @param[in] gap in the state that is judged [L]
Violations violations(const NodalMultipliers& now, std::span<const double> gap);

/// Parts of vectors along the surface, [i*gdim + c].
std::vector<double> tangential(int gdim, std::span<const double> normal, std::span<const double> vectors);

/// Gaps and slips of the linearised problem: those of `geometry`, and what a jump adds.
/// @param[in] jump displacement of slave against master, [i*gdim + c] [L]
/// @param[out] gap, slip by node [L]
void add_jump(const NodalGeometry& geometry, std::span<const double> jump, std::span<double> gap,
              std::span<double> slip);

/// Parts of free nodal forces along the constrained normal directions per area, of all nodes: what multipliers gain by
/// forces, without friction [F/L^2].
/// @param[in] usable as in NodalMultipliers
/// @param[in] forces [i*gdim + c] [F]
std::vector<double> normal_tractions(std::span<const std::int8_t> usable, const NodalGeometry& geometry,
                                     std::span<const double> forces);

/// Second-order correction: add what gaps and slips differ from the linearised ones `now`, at usable nodes with a
/// master.
/// @param[in] gap, slip as they are [L]
/// @param[in,out] gap_at, slip_at in the state that the linear problem is linearised about [L]
void add_linearisation_error(const NodalMultipliers& now, const NodalGeometry& geometry, std::span<const double> gap,
                             std::span<const double> slip, std::span<double> gap_at, std::span<double> slip_at);
} // namespace dolfinx_impact::enforcement
