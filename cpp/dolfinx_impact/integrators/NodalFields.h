// SPDX-License-Identifier: MIT
#pragma once
#include "../operators/Halo.h"
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

namespace dolfinx_impact::integrators
{
using operators::Halo;

/// Values at the nodes that a rank knows: owned nodes, the space's ghosts, then nodes of other ranks that contacts
/// need. Arrays have an entry for each degree of freedom, node*bs + component.
struct NodalFields
{
  /// @param[in] map of the space's nodes
  /// @param[in] bs components per node
  NodalFields(const std::shared_ptr<const dolfinx::common::IndexMap>& map, int bs);
  /// Take the space's ghosts and others in place of those before; all values but the residual are sent to them.
  /// Collective.
  /// @param[in] others global numbers and owners of nodes that are no ghosts of the space, ascending
  void add_ghosts(const std::vector<std::pair<std::int64_t, int>>& others);
  const dolfinx::common::IndexMap& space_map() const { return *_space_map; }

  /// Send the owners' displacements to the ghosts. Collective.
  void begin_exchange();
  /// Receive them, if any are on their way; ghosts' velocities follow from their displacements. Collective.
  /// @param[in] dt step that the displacements have made [T]
  void end_exchange(double dt);
  /// Set ghosts' velocities by their displacements, which were corrected since they were received.
  void update_ghost_velocities(double dt);

  int bs;
  std::size_t owned; ///< degrees of freedom that this rank owns
  std::size_t own;   ///< these and the space's ghosts
  std::unique_ptr<Halo> halo;
  std::vector<double> u, v, r;       ///< displacement [L], velocity half a step before [L/T], residual [F]
  std::vector<double> mass, inverse; ///< inverse: zero where prescribed
  bool exchanging = false;           ///< are displacements on their way?
  Halo::Traffic traffic() const;

private:
  void resize(const std::shared_ptr<const dolfinx::common::IndexMap>& map);

  std::shared_ptr<const dolfinx::common::IndexMap> _space_map;
  std::vector<double> _old_ghosts; ///< displacements of ghosts at the time level before
  Halo::Traffic _traffic;          ///< of Halos that are no more
};
} // namespace dolfinx_impact::integrators
