// SPDX-License-Identifier: MIT
#pragma once
#include "../closest_point/BatchProjection.h"
#include "../closest_point/Projection.h"
#include "../closest_point/linear_facet.h"
#include "TrackedSurface.h"
#include <array>

namespace dolfinx_impact::search
{
/// Closest points of consecutive slave nodes that are expected to stay over their facets, projected together. It owns
/// the batch and the results of the nodes in it. First `select` all nodes, then `set` each of them, so that the memory
/// is asked for many nodes' data at once.
class NodeBatch
{
public:
  static constexpr std::size_t size = BatchProjection::size;
  struct Result
  {
    Projection at;         ///< without facet: the closest point was not found inside the expected facet
    double distance = 0.0; ///< [L]
    bool alone = false;    ///< no other facet can be nearer
  };

  /// Begin a batch of nodes `first` to `last` (excluded), at most `size`. None is selected.
  void begin(std::size_t first, std::size_t last)
  {
    _first = first;
    _last = last;
    _block.num = 0;
    for (std::size_t i = first; i < last; ++i)
      (*this)[i].at.facet = -1;
  }
  void clear() { _first = _last = 0; }
  bool contains(std::size_t i) const { return i >= _first && i < _last; }
  /// Result of a node of the batch.
  Result& operator[](std::size_t i) { return _results[i - _first]; }

  /// Add a node to those that are projected.
  /// @param[in] i node
  /// @param[in] facet expected, corners: positions of its nodes in TrackedSurface::nodes
  template <surface::FacetShape S>
  void select(std::size_t i, std::int32_t facet, const std::int32_t* corners)
  {
    for (int j = 0; j < linear::num_nodes<S>; ++j)
      _corners[j][_block.num] = corners[j];
    _facets[_block.num] = facet;
    _nodes[_block.num++] = i;
  }
  /// Number of selected nodes; the node and the facet of lane l.
  int num() const { return _block.num; }
  std::size_t node(int l) const { return _nodes[l]; }
  std::int32_t facet(int l) const { return _facets[l]; }

  /// Set the input of lane l.
  /// @param[in] x position of the node [L]
  /// @param[in] slave_normal with an upper bound on its error
  /// @param[in] start reference coordinates to start from
  template <surface::FacetShape S>
  void set(int l, const TrackedSurface& surface, const double* x, const double* slave_normal, double rotation,
           const double* start)
  {
    constexpr int D = linear::dimension<S>;
    for (int c = 0; c < D; ++c)
    {
      _block.point[c][l] = x[c];
      _block.slave_normal[c][l] = slave_normal[c];
    }
    _block.rotation[l] = rotation;
    for (int a = 0; a < 2; ++a)
      _block.xi[a][l] = start[a];
    _block.orientation[l] = surface.facets().orientation[_facets[l]];
  }
  /// Project all selected nodes, whose input has been set.
  void project(surface::FacetShape shape, const TrackedSurface& surface)
  {
    read_corners(shape, surface.node_data());
    project_batch(shape, _block);
  }

  /// Is the closest point of lane l inside its facet, which faces the node?
  bool found(int l) const { return _block.over[l] > 0.0; }
  /// Store the closest point of lane l as the result of its node.
  Result& take(int l)
  {
    Result& out = (*this)[_nodes[l]];
    out.distance = _block.distance[l];
    out.at.status = ProjectionStatus::converged;
    out.at.facet = _facets[l];
    out.at.gap = out.at.clearance = _block.gap[l];
    for (int a = 0; a < 2; ++a)
      out.at.xi[a] = _block.xi[a][l];
    for (int c = 0; c < 3; ++c)
      out.at.normal[c] = _block.normal[c][l];
    return out;
  }

private:
  void read_corners(surface::FacetShape shape, const MasterNode* nodes);

  BatchProjection _block;
  std::size_t _nodes[size];
  std::int32_t _facets[size], _corners[4][size];
  std::size_t _first = 0, _last = 0;
  std::array<Result, size> _results;
};
} // namespace dolfinx_impact::search
