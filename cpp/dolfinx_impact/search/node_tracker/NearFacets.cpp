// SPDX-License-Identifier: MIT
#include "NearFacets.h"
#include <algorithm>

namespace dolfinx_impact::search
{
namespace
{
bool nearer(const NearFacets::Facet& a, const NearFacets::Facet& b)
{
  return a.distance < b.distance;
}
} // namespace

void NearFacets::add(std::int32_t facet, double distance)
{
  if (_num < max_facets)
  {
    _facets[_num++] = {facet, distance};
    return;
  }
  const auto farthest = std::max_element(_facets.begin(), _facets.end(), nearer);
  _dropped = std::min(_dropped, std::max(farthest->distance, distance));
  if (distance < farthest->distance)
    *farthest = {facet, distance};
}

void NearFacets::select(int most, double complete, double room)
{
  _complete = std::min(complete, _dropped);
  const double limit = _complete + room;
  _num = int(std::remove_if(begin(), end(), [&](const Facet& f) { return f.distance > limit; }) - begin());
  if (_num > most)
  {
    std::nth_element(begin(), begin() + most, end(), nearer);
    _complete = std::min(_complete, _facets[most].distance);
  }
}
} // namespace dolfinx_impact::search
