// SPDX-License-Identifier: MIT
#pragma once
#include "../../surface/Facets.h"
#include <limits>
#include <span>
#include <vector>

namespace dolfinx_impact::search
{
/// How fast a unit normal can turn.
///
/// If every node of a facet moves by at most D (a common translation left out), tangents a and b at a place change by
/// at most C D, C the largest sum of the moduli of the shape functions' derivatives. With w = a x b, Q = C (|a| + |b|)
/// / (2 |w|) (in the plane Q = C / (2 |a|)) and q = Q D <= 0.2, e = |w' - w| / |w| <= 2 q + q^2, so that the unit
/// normal changes by at most e / sqrt(1 - e) <= 2.94 q. The normalised sum s of several unit normals changes by at most
/// x / sqrt(1 - x), x = 2.94 D sum(Q) / |s|: no more than 4.6 D sum(Q) / |s| as long as that is 0.9 at most.
struct Turning
{
  static constexpr double factor = 4.6; ///< change of a unit normal, or of the mean of some, per Q and D
  static constexpr double most = 0.9;   ///< changes up to this are bounded by `factor`
  /// The Q of a facet at a place [1/L].
  /// @param[in] a tangents
  /// @param[in] slope the C of its element [1]
  static double rate(int tdim, const double a[2][3], double slope);
  /// The C of an element of which positions are given by its nodes.
  static double slope(const surface::FacetElement& element);
};

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
  /// @param[in] u, du displacements; the configuration is u - back*du, u if du is null [L]
  /// @param[out] normal gdim components; zero where the facets' normals cancel
  /// @returns by how much it changes at most while no node of its facets moves by more than a unit of length: Turning
  /// [1/L]
  double evaluate(std::size_t i, const double* u, const double* du, double* normal, double back = 1.0) const;

private:
  /// A facet at a node: the nodes at the ends of its two edges there (in the plane: of the one), and the edges at rest.
  struct Corner
  {
    std::int32_t nodes[2];
    double edges[2][3], sign; ///< times their product (in the plane: the edge turned clockwise) points out
  };
  template <int D>
  double linear(std::size_t i, const double* u, const double* du, double* normal, double back) const;
  double general(std::size_t i, const double* u, const double* du, double* normal, double back) const;

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
