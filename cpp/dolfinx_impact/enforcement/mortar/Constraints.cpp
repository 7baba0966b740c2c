// SPDX-License-Identifier: MIT
#include "Constraints.h"
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace dolfinx_impact::enforcement
{
NodalFrames frames_at(int gdim, std::span<const double> normals, std::span<const std::int8_t> fixed)
{
  if (normals.size() != fixed.size() || normals.size() % gdim)
    throw std::invalid_argument("a normal and prescribed components of every node are needed");
  const std::size_t num = normals.size() / gdim;
  NodalFrames out{std::vector<double>(num * gdim * gdim, 0.0), std::vector<std::int32_t>(num, -1),
                  std::vector<double>(num)};
  for (std::size_t i = 0; i < num; ++i)
  {
    double* frame = &out.frames[i * gdim * gdim];
    const std::int8_t* held = &fixed[i * gdim];
    for (int c = 0; c < gdim; ++c)
      frame[c * gdim + c] = 1.0;
    double free[3], squared = 0.0;
    for (int c = 0; c < gdim; ++c)
    {
      free[c] = held[c] ? 0.0 : normals[i * gdim + c];
      squared += free[c] * free[c];
    }
    const double length = out.length[i] = std::sqrt(squared);
    if (!(length > 1e-3))
      continue;
    int place = 0;
    for (int c = 0; c < gdim; ++c)
    {
      free[c] /= length;
      if (std::abs(free[c]) > std::abs(free[place]))
        place = c;
    }
    out.place[i] = place;
    for (int c = 0; c < gdim; ++c)
      frame[c * gdim + place] = free[c];
    // Gram-Schmidt over the other free axes, normal first.
    for (int d = 0; d < gdim; ++d)
    {
      if (d == place || held[d])
        continue;
      double vector[3] = {0.0, 0.0, 0.0}, size = 0.0;
      vector[d] = 1.0;
      for (int e = 0; e < gdim; ++e)
      {
        if (e == d || !(e == place || e < d || held[e]))
          continue;
        double along = 0.0;
        for (int c = 0; c < gdim; ++c)
          along += vector[c] * frame[c * gdim + e];
        for (int c = 0; c < gdim; ++c)
          vector[c] -= along * frame[c * gdim + e];
      }
      for (int c = 0; c < gdim; ++c)
        size += vector[c] * vector[c];
      for (int c = 0; c < gdim; ++c)
        frame[c * gdim + d] = vector[c] / std::sqrt(size);
    }
  }
  return out;
}
} // namespace dolfinx_impact::enforcement
