// SPDX-License-Identifier: MIT
#include "node_edges.h"
#include "../../common/vectors.h"
#include <algorithm>
#include <cmath>

namespace dolfinx_impact::enforcement
{
namespace
{
/// Between two normals whose edge is a direction of its own [rad].
constexpr double least_angle = 0.1;
} // namespace

std::vector<double> held_by_others(const MortarContact& contact)
{
  if (contact.edges.empty() || !contact.has_friction())
    return {};
  const MortarGeometry& geometry = contact.geometry();
  const int g = geometry.gdim();
  std::vector<double> out(geometry.num_nodes() * g * g, 0.0);
  for (const MortarContact::Edge& e : contact.edges)
    for (std::size_t k = 0; k < e.mine.size(); ++k)
    {
      const std::size_t i = e.mine[k], j = e.theirs[k];
      const SlaveNodes& theirs = e.contact->geometry().now();
      if (!contact.active()[i] || !contact.usable()[i] || !e.contact->active()[j] || !theirs.participates[j])
        continue;
      // Gram-Schmidt: less the node's own normal, and what others hold.
      const double *own = &geometry.now().normal[i * g], *other = &theirs.normal[j * g];
      double *block = &out[i * g * g], part[3], rest[3];
      const double along = dot(own, other, g);
      for (int a = 0; a < g; ++a)
        part[a] = other[a] - along * own[a];
      for (int a = 0; a < g; ++a)
        rest[a] = part[a] - dot(&block[a * g], part, g);
      const double length = std::sqrt(dot(rest, rest, g));
      for (int a = 0; a < g && length > least_angle; ++a)
        for (int b = 0; b < g; ++b)
          block[a * g + b] += rest[a] / length * (rest[b] / length);
    }
  const std::vector<std::int8_t>& fixed = geometry.fixed();
  for (std::size_t i = 0; i < geometry.num_nodes(); ++i) // there prescribed components decide
    if (std::any_of(&fixed[i * g], &fixed[i * g] + g, [](std::int8_t f) { return f; }))
      std::fill_n(&out[i * g * g], g * g, 0.0);
  return out;
}

void align_frames(const MortarContact& contact, NodalFrames& frames)
{
  const MortarGeometry& geometry = contact.geometry();
  if (geometry.gdim() == 2 || !contact.has_friction())
    return;
  for (const MortarContact::Edge& e : contact.edges)
    for (std::size_t k = 0; k < e.mine.size(); ++k)
    {
      const std::size_t i = e.mine[k], j = e.theirs[k];
      const double* normal = &geometry.now().normal[3 * i];
      const std::int8_t* fixed = &geometry.fixed()[3 * i];
      double edge[3], across[3];
      cross(normal, &e.contact->geometry().now().normal[3 * j], edge);
      const double length = std::sqrt(dot(edge, edge, 3));
      if (!(length > least_angle) || fixed[0] || fixed[1] || fixed[2])
        continue;
      for (double& component : edge)
        component /= length;
      cross(edge, normal, across);
      for (int c = 0; c < 3; ++c)
      {
        frames.frames[(3 * i + c) * 3 + (frames.place[i] + 1) % 3] = edge[c];
        frames.frames[(3 * i + c) * 3 + (frames.place[i] + 2) % 3] = across[c];
      }
    }
}
} // namespace dolfinx_impact::enforcement
