// SPDX-License-Identifier: MIT
#pragma once
#include "../operators/Halo.h"
#include "../operators/lanes.h"
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace dolfinx_impact::integrators
{
using operators::AlignedVector;
using operators::Halo;

/// Values at the nodes that a rank knows: owned nodes, the space's ghosts, then nodes of other ranks that contacts
/// need. Ghosts that nothing on this rank reads, of the layers of cells that a mesh came with, have places but take no
/// part in exchanges: their values are those of an earlier time level. Arrays have `stride` entries per node,
/// node*stride + component; those beyond the components are padding, zero.
struct NodalFields
{
  /// @param[in] map of the space's nodes
  /// @param[in] bs components per node
  /// @param[in] padded the stride is operators::padded_stride(bs), which kernels read fast; else bs
  /// @param[in] used nonzero for each ghost of the space that kernels read or add to; empty: all. Collective.
  NodalFields(const std::shared_ptr<const dolfinx::common::IndexMap>& map, int bs, bool padded = true,
              std::vector<std::int8_t> used = {});
  /// More of the space's nodes are read or added to: they are exchanged from now on. Collective.
  /// @param[in] nodes owned ones among them are left out
  void use(std::span<const std::int32_t> nodes);
  /// Take the space's ghosts and others in place of those before; all values but the residual are sent to them.
  /// Collective.
  /// @param[in] others global numbers and owners of nodes that are no ghosts of the space, ascending
  void add_ghosts(const std::vector<std::pair<std::int64_t, int>>& others);
  /// Exchange no more ghosts of the space than kernels and contacts read, after `add_ghosts` has made Halos of all.
  /// Collective.
  /// @param[in] nodes of contacts, in the order of the arrays
  void drop_ghosts(std::span<const std::int32_t> nodes);
  const dolfinx::common::IndexMap& space_map() const { return *_space_map; }

  /// Send the owners' displacements to the ghosts. Collective.
  void begin_exchange();
  /// Receive them, if any are on their way; ghosts' velocities follow from their displacements. Collective.
  /// @param[in] dt step that the displacements have made [T]
  void end_exchange(double dt);
  /// Set ghosts' velocities by their displacements, which were corrected since they were received.
  void update_ghost_velocities(double dt);

  /// Place of a degree of freedom, node*bs + component, in the arrays.
  std::size_t entry(std::size_t dof) const { return dof / bs * stride + dof % bs; }
  bool is_padded() const { return stride != bs; }
  /// Write values by degree of freedom, of whole nodes, into one of the arrays, from the first node on.
  void spread(std::span<const double> by_dof, AlignedVector& values) const;
  /// The first values of one of the arrays by degree of freedom, of whole nodes.
  void collect(std::span<const double> values, std::span<double> by_dof) const;
  /// Owned values of one of the arrays by degree of freedom.
  std::vector<double> owned_values(const AlignedVector& values) const;

  int bs, stride;
  std::size_t owned;                      ///< degrees of freedom that this rank owns
  std::size_t own;                        ///< these and the space's ghosts
  std::size_t owned_entries, own_entries; ///< of the arrays: likewise
  std::unique_ptr<Halo> halo;
  AlignedVector u, v, r;       ///< displacement [L], velocity half a step before [L/T], residual [F]
  AlignedVector mass, inverse; ///< inverse: zero where prescribed
  bool exchanging = false;     ///< are displacements on their way?
  Halo::Traffic traffic() const;

private:
  void set_halo(std::unique_ptr<Halo> halo);
  void refresh_ghosts();

  std::shared_ptr<const dolfinx::common::IndexMap> _space_map;
  std::vector<std::int8_t> _used;  ///< nonzero for each ghost of the space that kernels read
  bool _some_unused = false;       ///< has any rank ghosts that are not? The same on all ranks
  std::vector<double> _old_ghosts; ///< displacements of ghosts at the time level before
  Halo::Traffic _traffic;          ///< of Halos that are no more
};
} // namespace dolfinx_impact::integrators
