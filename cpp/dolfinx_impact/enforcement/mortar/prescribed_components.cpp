// SPDX-License-Identifier: MIT
#include "prescribed_components.h"
#include "../../common/dolfinx_api.h"
#include <algorithm>
#include <cmath>
#include <dolfinx/la/Vector.h>
#include <functional>
#include <stdexcept>

namespace dolfinx_impact::enforcement
{
namespace
{
/// Prescribed displacements are the same up to this part of them: fractions of a way are rounded.
constexpr double equal = 1e-9;
/// Nodes lie on one plane of symmetry where they are apart across it by less than this part of the bodies' size.
constexpr double plane = 1e-6;

/// Are prescribed displacements the same but for round-off?
bool same(double a, double b, double tolerance)
{
  return std::abs(a - b) <= equal * std::max(std::abs(a), std::abs(b)) + 1e-2 * tolerance;
}

void check(const PrescribedComponents& p, std::span<const std::int32_t> nodes)
{
  if (p.fixed.size() != p.driven.size())
    throw std::invalid_argument("a mask and a motion of every degree of freedom are needed");
  for (std::int32_t node : nodes)
    if (node < 0 || std::size_t(node + 1) * p.gdim > p.fixed.size())
      throw std::invalid_argument("the degrees of freedom are fewer than the surface's nodes");
}
} // namespace

std::vector<double> remaining_motion(const PrescribedComponents& prescribed, std::span<const std::int32_t> nodes,
                                     std::span<const double> u, std::span<const double> start)
{
  check(prescribed, nodes);
  if (u.size() != prescribed.fixed.size() || start.size() != u.size())
    throw std::invalid_argument("a displacement of every degree of freedom is needed");
  const int g = prescribed.gdim;
  std::vector<double> out(nodes.size() * g, 0.0);
  for (std::size_t i = 0; i < nodes.size(); ++i)
    for (int c = 0; c < g; ++c)
    {
      const std::size_t dof = nodes[i] * g + c;
      if (prescribed.fixed[dof])
        out[i * g + c] = prescribed.driven[dof] - (u[dof] - start[dof]);
    }
  return out;
}

std::vector<std::int8_t> locked_components(const PrescribedComponents& prescribed, std::span<const std::int32_t> nodes,
                                           const std::array<double, 3>& motion)
{
  check(prescribed, nodes);
  const int g = prescribed.gdim;
  std::vector<std::int8_t> out(nodes.size() * g, 0);
  for (std::size_t i = 0; i < nodes.size(); ++i)
    for (int c = 0; c < g; ++c)
      out[i * g + c] = prescribed.fixed[nodes[i] * g + c] &&
                       same(prescribed.driven[nodes[i] * g + c], motion[c], prescribed.tolerance);
  return out;
}

std::vector<std::int8_t> locked_components(const PrescribedComponents& prescribed,
                                           const gap::MortarIntegrals& integrals, std::span<const double> x,
                                           double size)
{
  const auto& nodes = integrals.nodes().nodes;
  check(prescribed, nodes);
  const int g = prescribed.gdim;
  // Of the nodes that the facets number: prescribed or not, motion, position.
  dolfinx::la::Vector<double> known(integrals.map(), 3 * g), sums(integrals.map(), 2 * g);
  common::fill(known, 0.0);
  common::fill(sums, 0.0);
  const std::size_t owned = std::min(std::size_t(integrals.map()->size_local()), prescribed.fixed.size() / g);
  if (x.size() < owned * g)
    throw std::invalid_argument("positions of all owned nodes are needed");
  for (std::size_t node = 0; node < owned; ++node)
    for (int c = 0; c < g; ++c)
    {
      double* values = &common::array(known)[node * 3 * g];
      values[c] = prescribed.fixed[node * g + c];
      values[g + c] = prescribed.driven[node * g + c];
      values[2 * g + c] = x[node * g + c];
    }
  known.scatter_fwd();
  // Counts of facing nodes: those on one plane that move the same way, those that do not move the same way.
  const auto& entries = integrals.entries().M;
  for (std::size_t k = 0; k < entries.rows.size(); ++k)
  {
    const double *own = &known.array()[std::size_t(entries.rows[k]) * 3 * g],
                 *facing = &known.array()[std::size_t(entries.cols[k]) * 3 * g];
    if (std::none_of(own, own + g, [](double f) { return f > 0.0; }))
      continue;
    double* counts = &common::array(sums)[std::size_t(entries.rows[k]) * 2 * g];
    for (int c = 0; c < g; ++c)
    {
      const bool moves_alike = facing[c] > 0.0 && same(own[g + c], facing[g + c], prescribed.tolerance);
      counts[c] += moves_alike && std::abs(own[2 * g + c] - facing[2 * g + c]) < plane * size;
      counts[g + c] += !moves_alike;
    }
  }
  sums.scatter_rev(std::plus<double>());
  std::vector<std::int8_t> out(nodes.size() * g, 0);
  for (std::size_t i = 0; i < nodes.size(); ++i)
    for (int c = 0; c < g; ++c)
    {
      const double* counts = &sums.array()[std::size_t(nodes[i]) * 2 * g];
      out[i * g + c] = prescribed.fixed[nodes[i] * g + c] && (counts[c] > 0.0 || counts[g + c] == 0.0);
    }
  return out;
}
} // namespace dolfinx_impact::enforcement
