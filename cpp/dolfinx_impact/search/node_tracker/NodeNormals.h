// SPDX-License-Identifier: MIT
#pragma once
#include "../../surface/Facets.h"
#include "Configuration.h"
#include <span>
#include <vector>

namespace dolfinx_impact::search
{
/// Normals of a surface at its nodes, in any configuration: the mean of the unit normals of the facets at the node,
/// every facet with the same weight. Node by node, when they are wanted; all facets of a node have to be here, also
/// those of other ranks.
class NodeNormals
{
public:
  /// @param[in] facets those at the nodes and maybe others, numbered as the displacements
  /// @param[in] nodes numbers of the nodes
  void reset(surface::Facets facets, std::span<const std::int32_t> nodes);
  /// Nodes of the facets that are not among `nodes`, ascending.
  std::span<const std::int32_t> others() const { return _others; }
  /// @param[in] i position in `nodes`
  /// @param[out] normal gdim components; zero where the facets' normals cancel
  /// @returns upper bound on its change per largest motion of a node of its facets: NormalRotation [1/L]
  double evaluate(std::size_t i, Configuration configuration, double* normal) const;

private:
  /// A facet at a node: the nodes at the ends of its two edges there (in the plane: of the one), and the edges in the
  /// reference configuration.
  struct Corner
  {
    std::int32_t nodes[2];
    double edges[2][3], sign; ///< times their product (in the plane: the edge turned clockwise) points out
  };
  template <int D>
  double linear(std::size_t i, Configuration configuration, double* normal) const;
  double general(std::size_t i, Configuration configuration, double* normal) const;

  surface::Facets _facets;
  bool _linear = true;
  double _slope = 0.0;
  std::vector<std::int32_t> _nodes, _others;
  std::vector<std::int32_t> _first; ///< of each node in what follows
  std::vector<Corner> _corners;     ///< of facets of degree 1
  struct Place
  {
    std::int32_t facet, node;
  };
  std::vector<Place> _places; ///< of other facets: with the node's position in the facet
  std::vector<double> _phi;   ///< shape functions of displacements at geometry nodes
};
} // namespace dolfinx_impact::search
