// SPDX-License-Identifier: MIT
#pragma once
#include "../../search/node_tracker/MasterNode.h"
#include "../../surface/FacetElement.h"
#include "MomentCorrection.h"
#include <cstdint>

namespace dolfinx_impact::enforcement
{
/// What all closed nodes of a kinematic contact have in common.
struct ClosedRules
{
  int gdim = 3;
  int num_masters = 0;        ///< nodes of a facet of the master; none: it is rigid
  bool has_friction = false;  ///< do forces act in all directions?
  bool turns = false;         ///< do forces need a moment correction?
  bool linear_facets = false; ///< has the master facets of degree 1, whose shape num_masters and gdim tell?
};

/// Nodes that receive a force of kinematic contact in a step, computed together: KinematicContact. Layout:
/// entry [...][lane], a lane is a node; a row is a line of the cache. Rows of what a contact has not are not used.
struct alignas(64) ClosedBatch
{
  static constexpr int size = 8, most = surface::FacetElement::max_nodes;

  int num = 0;                           ///< lanes in use; the others repeat the last one, and nobody reads them
  std::int32_t node[size];               ///< number of the slave's node
  std::int32_t slave[size];              ///< its position among the slave's nodes
  double releases[size];                 ///< 1: it opens in this step, and its force is fixed before the sweeps; 0: not
  double overlap[size];                  ///< [L]
  double normal[3][size];                ///< out of the master
  double motion[3][size];                ///< increment of the prediction relative to the master's point [L]
  double turn[3][size];                  ///< what the facet's rotation adds to it; zero without friction [L]
  double normal_mass[size];              ///< reciprocal of what a unit force along the normal corrects, times h [M]
  double isotropic_mass[size];           ///< the same in the direction in which it corrects most [M]
  double friction[size];                 ///< coefficient [1]
  double force[3][size];                 ///< on the slave's node [F]
  double sticks[size];                   ///< of the last sweep: 1: it does not slip; 0: it does, or bears nothing
  double arm[3][size], inverse[6][size]; ///< of the correction of the moments: MomentCorrection
  /// A node of its facet.
  struct Master
  {
    std::int32_t node[size], corner[size]; ///< its number, and its position among the nodes of the master
    double phi[size];                      ///< shape function at the projection
    double from_mean[3][size];             ///< position from the mean of the facet's nodes: MomentCorrection::set [L]
    double correction[3][size];            ///< correction of the moments of `force` after the last sweep [F]
  };
  Master masters[most]; ///< last, so that what a contact uses lies together

  /// The correction of the moments of lane l alone.
  /// @param[out] r as MomentCorrection::set returns
  MomentCorrection moments(const ClosedRules& rules, int l, double* r) const;
};

/// What a batch of nodes in contact begins with.
struct alignas(64) ClosedInput
{
  double x[3][ClosedBatch::size];        ///< positions at the last time level [L]
  double xi[2][ClosedBatch::size];       ///< reference coordinates of their projections
  double orientation[ClosedBatch::size]; ///< of their facets
  double along_facet[ClosedBatch::size]; ///< 1: the normal becomes that of the facet at the last time level; 0: not
};

/// Motions and works of a batch after the last sweep.
struct alignas(64) ClosedResult
{
  double gap[ClosedBatch::size];                 ///< [L]
  double normal[ClosedBatch::size];              ///< normal force [F]
  double tangential[3][ClosedBatch::size];       ///< force [F]
  double slip[3][ClosedBatch::size];             ///< of the step [L]
  double work[ClosedBatch::size];                ///< half of the normal force's on the increment before it [F L]
  double later_work[ClosedBatch::size];          ///< half of it on the increment after it [F L]
  double friction_work[ClosedBatch::size];       ///< the same of friction [F L]
  double later_friction_work[ClosedBatch::size]; ///< [F L]
};

/// Let the lanes that are not in use repeat the last one that is.
void fill_lanes(const ClosedRules& rules, ClosedBatch& batch, ClosedInput& input);
/// Takes what a batch needs of the nodes of its facets: `motion`, which was the increment of the slave's nodes, becomes
/// relative to the master; `normal` of nodes along facets, `turn` and the moment corrections are set.
/// @param[in] nodes of the master
void read_masters(const ClosedRules& rules, ClosedBatch& batch, const ClosedInput& input,
                  const search::MasterNode* nodes);
/// One sweep: update the forces and project them on the admissible set (no tension, Coulomb's cone).
/// @param[in] correction displacements by the forces, by number, in space four numbers a node [L]
/// @param[in] h square of the step [T^2], factor: over-relaxation
/// @param[in] first nothing is corrected yet
void solve_forces(const ClosedRules& rules, ClosedBatch& batch, const double* correction, double h, double factor,
                  bool first);
/// Adds the forces and their reactions to those of the nodes.
/// @param[in,out] forces by number, in space four numbers a node [F]
/// @param[in] last after the last sweep: moment corrections are stored
void add_forces(const ClosedRules& rules, ClosedBatch& batch, double* forces, bool last);
/// @param[in] nodes of the master
/// @param[in] correction, before displacements by the forces, increments of the step before, by number, in space four
/// numbers a node [L]
/// @param[in] obstacle increment of a rigid master in the step before, 3 components [L]
void measure(const ClosedRules& rules, const ClosedBatch& batch, const search::MasterNode* nodes,
             const double* correction, const double* before, const double* obstacle, ClosedResult& result);
} // namespace dolfinx_impact::enforcement
