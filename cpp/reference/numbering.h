// SPDX-License-Identifier: MIT
#pragma once
#include "Cell.h"
#include "plain/Mesh.h"
#include <cstdint>
#include <unordered_map>

namespace impact_reference
{
using Cells = Eigen::Matrix<std::int64_t, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Geometry of a model after its checks: the same numbers as impact_plain::Mesh, as matrices.
struct Geometry
{
  CellType cell;
  int degree;
  Matrix points; ///< (num_points, gdim) [L]
  Cells cells;   ///< (num_cells, nodes per cell), own node order
};

/// @throws std::invalid_argument for an unknown cell or degree, gdim that is not the cell's dimension, a wrong number
/// of nodes per cell, a node out of range or repeated in a cell, a point no cell uses, or NaN
Geometry geometry(const impact_plain::Mesh& mesh);

/// Nodes of a Lagrange field on the geometry.
struct Field
{
  int degree;
  Matrix points; ///< positions (num_nodes, gdim) [L]
  Cells cells;   ///< (num_cells, nodes per cell), own node order
};

/// Field nodes: those of the geometry if the degrees are the same; otherwise vertices in increasing order of their
/// geometry number, then mid-edges, mid-faces and centres in order of appearance, placed by the geometry map.
Field number_field(const Geometry& geometry, int degree);

/// Where a facet was found.
struct FacetPlace
{
  std::int64_t cell;
  int facet;
  int num_cells; ///< cells that share it: 1 on the boundary
};

/// Finds facets by the geometry numbers of their vertices.
class FacetIndex
{
public:
  explicit FacetIndex(const Geometry& geometry);
  /// @param nodes geometry nodes of one facet; those that are not vertices are ignored
  /// @throws std::invalid_argument if no cell has this facet
  FacetPlace find(const std::vector<std::int64_t>& nodes) const;

private:
  struct Hash
  {
    std::size_t operator()(const std::vector<std::int64_t>& key) const;
  };
  std::int64_t num_points_;
  std::vector<bool> is_vertex_;
  std::unordered_map<std::vector<std::int64_t>, FacetPlace, Hash> places_;
};
} // namespace impact_reference
