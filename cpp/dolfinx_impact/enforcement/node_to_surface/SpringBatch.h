// SPDX-License-Identifier: MIT
#pragma once
#include "../../search/node_tracker/MasterNode.h"
#include "../../surface/FacetElement.h"
#include "NodalSum.h"
#include "spring.h"

namespace dolfinx_impact::enforcement
{
/// Springs of penalty contact at many nodes, whose forces are computed together. Layout: entry [...][lane], a lane is a
/// node. Values of nodes that turn out to be open mean nothing but where they are named.
struct SpringBatch
{
  static constexpr int size = 16, most = surface::FacetElement::max_nodes;

  // Of the contact.
  int gdim = 3, num_masters = 0; ///< num_masters: nodes of a facet of the master; none: it is rigid
  double friction = 0.0;         ///< coefficient [1]
  double given = 0.0;            ///< stiffness per area; 0: it follows from the compliances of the nodes [F/L^3]
  double share = 1.0;            ///< of the stiffness that follows from compliances [1]
  bool corrects_moments = false;

  // In, by node.
  int num = 0;                  ///< lanes in use
  double gap[size];             ///< with the offset of its spring [L]
  double normal[3][size];       ///< out of the master
  double beside[size];          ///< 1: outside the rim of the master, where gaps that are positive do not count; 0: not
  double oblique[size];         ///< 1: the normal force may have a moment about the point of the master; 0: it has none
  double begins[size];          ///< 1: the node was open; 0: it was closed
  double x[3][size];            ///< position; read where a moment correction is needed [L]
  double per_area[size];        ///< reciprocal of its area
  double compliance[size];      ///< of its own and of the master there [L/F]
  double area_compliance[size]; ///< of the master's nodes, times their areas, there [L^3/F, in the plane L^2/F]
  // Of the nodes of its facet.
  std::int32_t corners[most][size]; ///< positions among the nodes of the master
  double phi[most][size];           ///< shape functions
  // Read where a moment correction is needed; `read_masters` sets them.
  double X[most][3][size];  ///< positions [L]
  double du[most][3][size]; ///< increments in the step [L]

  // In and out.
  double motion[3][size];     ///< increment relative to the master; then also to a facet that turns [L]
  double tangential[3][size]; ///< force of friction [F]
  double force[size], spring_compliance[size], spring_gap[size], surplus[size], tangential_surplus[size]; ///< Spring

  // Out.
  double overlap[size];  ///< [L]; zero: the node is open
  double change[size];   ///< of the gap in the step, also of nodes that are open [L]
  double total[3][size]; ///< force on the node [F]
  double slip[3][size];  ///< added in the step [L]
  double normal_loss[size], friction_loss[size], stored[size]; ///< energies [F L]
  double sticks[size];                                         ///< 1: it does not slip; 0: it does
  double corrected[size];                                      ///< 1: `correction` counts; 0: it does not
  double correction[most][3][size];                            ///< moment correction on the nodes of the facet [F]

  Spring spring(int l) const
  {
    return {force[l], spring_compliance[l], spring_gap[l], surplus[l], tangential_surplus[l], 0.0};
  }
  void set_spring(int l, const Spring& spring)
  {
    force[l] = spring.force;
    spring_compliance[l] = spring.compliance;
    spring_gap[l] = spring.gap;
    surplus[l] = spring.surplus;
    tangential_surplus[l] = spring.tangential_surplus;
  }
};

/// Takes what a batch needs of the nodes of its facets: motions and compliances, which were those of the slave's nodes,
/// become those of the springs, and X and du are set where moments may need a correction.
/// @param[in] nodes of the master
void read_masters(SpringBatch& batch, const search::MasterNode* nodes);
/// Forces of the springs of a batch in the step (docs/explicit/penalty.md).
void evaluate(SpringBatch& batch);
/// Subtracts the forces of the closed nodes of a batch from the nodes of their facets, one after the other: nodes of
/// the slave may share them.
/// @param[in,out] sums of the forces on the nodes of the master [F]
void add_reactions(const SpringBatch& batch, NodalSum* sums);
} // namespace dolfinx_impact::enforcement
