// SPDX-License-Identifier: MIT
#pragma once
#include "NodalPair.h"
#include <array>
#include <memory>
#include <petscmat.h>
#include <span>
#include <vector>

namespace dolfinx_impact::enforcement
{
/// Springs between the surfaces of a pair in a configuration of its own, outside of time stepping: the contact of the
/// run does not change. They are those of the run, all nodes open before; in place of kinematic contact, springs that
/// follow from masses.
class TrialSprings
{
public:
  /// Collective.
  /// @param[in] V displacement space
  /// @param[in] pair contact of the run; its rigid master is where it is now
  /// @param[in] u displacements, of which those of owned nodes are read [L]
  /// @param[in] mass of owned nodes; empty: one [M]
  /// @throws std::invalid_argument for a contact that has no surfaces (NodeToSurface)
  TrialSprings(const surface::FunctionSpace& V, const NodalPair& pair, std::span<const double> u,
               std::span<const double> mass = {});

  /// Force on the slave, of all ranks, if the bodies are at rest. Collective [F].
  /// @param[in] step that stiffness is made for where it follows from one [T]
  std::array<double, 3> force(double step);
  /// Number of nodes of this rank that `force` has found so deep that they stay open.
  std::int64_t implausible() const;
  /// Add the springs of given stiffness at all slave nodes that have a master, closed or not, to a matrix: along the
  /// normal, or in all directions if friction may make nodes stick. Collective.
  /// @param[in,out] matrix assembled, over owned degrees of freedom of V [F/L]
  /// @throws std::invalid_argument without a given penalty
  void add_to(Mat matrix) const;

private:
  std::vector<std::shared_ptr<NodePenalty>> _directions;
  std::unique_ptr<operators::Halo> _halo;
  std::vector<double> _u; ///< displacements of the Halo's nodes [L]
  int _gdim;
};
} // namespace dolfinx_impact::enforcement
