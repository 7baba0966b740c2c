// SPDX-License-Identifier: MIT
#pragma once
#include "contact_mortar.h"

namespace impact_reference
{
/// Slip of a steady flow. Material that passes a surface node with the velocity V moves by T V in a time T. The slip of
/// friction is made of these displacements in place of increments since a converged state:
/// T V = T w + T B u, with the undeformed flow w and the derivative B along it.
class SteadySlip
{
public:
  /// @param flow T w, creepages included (num_dofs) [L]
  /// @param along T B between nodes (num_nodes, num_nodes) [1]
  /// @param obstacle T times the velocity of the rigid obstacle [L]
  /// @throws std::invalid_argument for wrong sizes
  SteadySlip(Vector flow, Csr along, Vec<double> obstacle, int gdim);

  Vector way(const Vector& u) const; ///< T V (num_dofs) [L]

  /// Puts the history back by the way, so that mortar() finds the slip of the flow in place of increments.
  void set_back(const ContactPair& pair, const Vector& u, ContactHistory& history) const;

  /// Corrects the derivatives of the slip, which mortar() makes as if the history were constant.
  void differentiate(Mortar& mortar) const;

private:
  Vector flow_;
  Csr along_;
  Vec<double> obstacle_;
  int gdim_;
};
} // namespace impact_reference
