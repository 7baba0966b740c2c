// SPDX-License-Identifier: MIT
#include "NodeNormals.h"
#include "../../common/vectors.h"
#include "../../surface/normals.h"
#include "NormalRotation.h"
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace dolfinx_impact::search
{
using surface::FacetElement;
using surface::FacetShape;

void NodeNormals::reset(surface::Facets facets, std::span<const std::int32_t> nodes)
{
  _facets = std::move(facets);
  _nodes.assign(nodes.begin(), nodes.end());
  const FacetElement &element = _facets.displacement, &geometry = _facets.geometry;
  const int n_u = element.num_nodes(), n_x = geometry.num_nodes(), gdim = _facets.gdim;
  _linear = element.degree == 1 && geometry.degree == 1;
  _phi.assign(n_x * n_u, 0.0);
  double lebesgue = 0.0;
  for (int i = 0; i < n_x; ++i)
  {
    element.values(geometry.node(i).data(), _phi.data() + i * n_u);
    double sum = 0.0;
    for (int j = 0; j < n_u; ++j)
      sum += std::abs(_phi[i * n_u + j]);
    lebesgue = std::max(lebesgue, sum);
  }
  _slope = lebesgue * NormalRotation::slope(geometry);
  // Facets by node, in the order of the facets.
  std::vector<std::pair<std::int32_t, std::int32_t>> position;
  position.reserve(_nodes.size());
  for (std::size_t i = 0; i < _nodes.size(); ++i)
    position.emplace_back(_nodes[i], std::int32_t(i));
  std::sort(position.begin(), position.end());
  const auto find = [&](std::int32_t node)
  {
    const auto at = std::lower_bound(position.begin(), position.end(), std::pair(node, std::int32_t(-1)));
    return at != position.end() && at->first == node ? at->second : -1;
  };
  std::vector<std::vector<Place>> places(_nodes.size());
  _others.clear();
  for (std::size_t f = 0; f < _facets.size(); ++f)
    for (int k = 0; k < n_u; ++k)
    {
      const std::int32_t node = _facets.nodes_of(f)[k], i = find(node);
      if (i >= 0)
        places[i].push_back({std::int32_t(f), k});
      else
        _others.push_back(node);
    }
  std::sort(_others.begin(), _others.end());
  _others.erase(std::unique(_others.begin(), _others.end()), _others.end());
  _first.assign(1, 0);
  _corners.clear();
  _places.clear();
  // The ends of the two edges at a corner; the tangents of a bilinear facet at its corner are these edges.
  constexpr int ends[3][4][2] = {
      {{1, 1}, {0, 0}}, {{1, 2}, {2, 0}, {0, 1}}, {{1, 2}, {3, 0}, {0, 3}, {2, 1}}}; // as FacetShape
  for (const auto& of_node : places)
  {
    for (const auto [f, k] : of_node)
    {
      if (!_linear)
      {
        _places.push_back({f, k});
        continue;
      }
      const int* to = ends[int(element.shape)][k];
      Corner corner{{_facets.nodes_of(f)[to[0]], _facets.nodes_of(f)[to[1]]}, {}, double(_facets.orientation[f])};
      if (element.shape == FacetShape::interval && k == 1)
        corner.sign = -corner.sign;
      for (int e = 0; e < 2; ++e)
        for (int c = 0; c < gdim; ++c)
          corner.edges[e][c] = _facets.X_of(f)[to[e] * gdim + c] - _facets.X_of(f)[k * gdim + c];
      _corners.push_back(corner);
    }
    _first.push_back(std::int32_t(_linear ? _corners.size() : _places.size()));
  }
}

namespace
{
/// The mean of unit normals from their sum. @returns an upper bound on its rotation rate, from the sum of the facets' Q
double normalise(int gdim, const double* sum, double rates, double largest, double* normal)
{
  const double length = std::sqrt(dot(sum, sum, gdim));
  for (int c = 0; c < gdim; ++c)
    normal[c] = length > 0.0 ? sum[c] / length : 0.0;
  return length > 0.0 ? NormalRotation::factor * std::max(rates / length, largest)
                      : std::numeric_limits<double>::infinity();
}
} // namespace

template <int D>
double NodeNormals::linear(std::size_t i, Configuration at, double* normal) const
{
  const auto moved = [&](std::int32_t node, int c) { return at.at(std::size_t(node) * D + c); };
  double own[D], sum[3] = {}, rates = 0.0, largest = 0.0;
  for (int c = 0; c < D; ++c)
    own[c] = moved(_nodes[i], c);
  for (std::int32_t k = _first[i]; k < _first[i + 1]; ++k)
  {
    const Corner& corner = _corners[k];
    double a[2][3] = {}, n[3] = {};
    for (int e = 0; e < D - 1; ++e)
      for (int c = 0; c < D; ++c)
        a[e][c] = corner.edges[e][c] + (moved(corner.nodes[e], c) - own[c]);
    const double first = std::sqrt(dot(a[0], a[0], D));
    double size = first, ends = 1.0;
    surface::normal_vector(D, a, n);
    if constexpr (D == 3)
    {
      size = std::sqrt(dot(n, n, D));
      ends = first + std::sqrt(dot(a[1], a[1], D));
    }
    const double per_size = 1.0 / size;
    for (int c = 0; c < D; ++c)
      sum[c] += corner.sign * per_size * n[c];
    const double rate = 0.5 * _slope * ends * per_size;
    rates += rate;
    largest = std::max(largest, rate);
  }
  return normalise(D, sum, rates, largest, normal);
}

double NodeNormals::general(std::size_t i, Configuration at, double* normal) const
{
  const int gdim = _facets.gdim, n_u = _facets.displacement.num_nodes(), n_x = _facets.geometry.num_nodes();
  double sum[3] = {}, rates = 0.0, largest = 0.0, x[3 * FacetElement::max_nodes];
  for (std::int32_t k = _first[i]; k < _first[i + 1]; ++k)
  {
    const auto [f, node] = _places[k];
    for (int j = 0; j < n_x; ++j)
      for (int c = 0; c < gdim; ++c)
      {
        double place = _facets.X_of(f)[j * gdim + c];
        for (int l = 0; l < n_u; ++l)
        {
          const std::size_t k = std::size_t(_facets.nodes_of(f)[l]) * gdim + c;
          place += _phi[j * n_u + l] * at.at(k);
        }
        x[j * gdim + c] = place;
      }
    const surface::FacetPoint p = surface::evaluate(_facets, f, x, _facets.displacement.node(node).data());
    for (int c = 0; c < gdim; ++c)
      sum[c] += p.normal[c];
    const double rate = NormalRotation::rate(gdim - 1, p.tangents, _slope);
    rates += rate;
    largest = std::max(largest, rate);
  }
  return normalise(gdim, sum, rates, largest, normal);
}

double NodeNormals::evaluate(std::size_t i, Configuration configuration, double* normal) const
{
  if (!_linear)
    return general(i, configuration, normal);
  return _facets.gdim == 2 ? linear<2>(i, configuration, normal) : linear<3>(i, configuration, normal);
}
} // namespace dolfinx_impact::search
