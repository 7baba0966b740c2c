// SPDX-License-Identifier: MIT
#pragma once
#include "lanes.h"
#include <cstdint>
#include <dolfinx/fem/FunctionSpace.h>
#include <memory>
#include <vector>

namespace dolfinx_impact::operators
{
/// Positions of a mesh's nodes as kernels read them fast: four entries per node, the last of them padding, aligned.
/// They are by the nodes of a space where the space's first nodes of each cell are those of the mesh, as for Lagrange
/// elements on straight cells: kernels that test with the space then find positions, values and results by the same
/// numbers. Otherwise they are by the nodes of the mesh.
class NodePositions
{
public:
  using FunctionSpace = dolfinx::fem::FunctionSpace<double>;

  /// @param[in] V space on the mesh
  explicit NodePositions(std::shared_ptr<const FunctionSpace> V);
  /// Read the mesh's positions again: it may have been moved.
  void update();
  const AlignedVector& values() const { return _values; } ///< [L]
  /// Another number whenever positions are others, in this object or any.
  std::uint64_t version() const { return _version; }
  /// The space whose nodes they are by; null: by those of the mesh.
  const FunctionSpace* space() const { return _nodes.empty() ? nullptr : _V.get(); }

private:
  std::shared_ptr<const FunctionSpace> _V;
  std::vector<std::int32_t> _nodes; ///< the mesh's node of each node of the space, -1: none; empty: they do not agree
  AlignedVector _values;
  std::uint64_t _version = 0;
};
} // namespace dolfinx_impact::operators
