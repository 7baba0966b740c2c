#include "NodeToSurface.h"
#include <algorithm>
#include <cmath>
#include <numeric>

// Which nodes come through the surface: docs/explicit/penalty.md, "Through the surface".
namespace impact::enforcement
{
using search::Projection;

namespace
{
constexpr double shallow = 0.05; ///< of the facet: as deep a node may be met at first, as it may be beside the rim
constexpr int most_parts = 1000; ///< of a step's way: who moves by more than 500 facets is found out somewhere

/// Below the surface, not beside its rim.
bool is_below(const Projection& at)
{
  return at.gap < 0.0 && at.rim != Projection::Rim::beside && at.rim != Projection::Rim::below;
}
} // namespace

/// Is a node marked: below the surface without having come through it, from beside the rim or found deep inside? A node
/// without master keeps its mark, as nothing tells on which side it is.
bool NodeToSurface::barred(const Touch& touch, const double* u, const double* du)
{
  const Projection& at = touch.at;
  std::int8_t& closed = _closed[touch.i];
  if (_rigid || !std::isfinite(at.gap))
    return closed == came_in;
  const double diameter = _tracking.diameter(at.facet);
  if (at.rim == Projection::Rim::below)
    closed = came_in;
  else if (at.rim == Projection::Rim::beside || !(at.gap < 0.0))
    closed = closed == came_in ? 0 : closed;
  else if (closed == 0 && -at.gap > shallow * diameter)
  {
    const Projection before = _tracking.locate_before(touch.i, u, du);
    const bool met = std::isfinite(before.gap) && before.rim != Projection::Rim::below;
    const double depth = 0.5 * diameter;
    if (!met || (-at.gap > depth && !(before.gap > -depth)))
    {
      closed = came_in;
      _implausible += -at.gap > depth;
    }
  }
  return closed == came_in;
}

Projection NodeToSurface::point_before(std::size_t i, const double* u, const double* du, double back) const
{
  return _rigid ? rigid_point(i, u, du, back) : _tracking.locate_before(i, u, du, back);
}

void NodeToSurface::relative_motion(std::size_t i, const Projection& at, const double* du, double* motion) const
{
  const std::size_t node = _candidates.numbers()[i];
  for (int c = 0; c < _gdim; ++c)
    motion[c] = du[node * _gdim + c] - (_rigid ? _obstacle_increment[c] : 0.0);
  if (_rigid)
    return;
  const surface::Facets& master = _tracking.master();
  double phi[surface::FacetElement::max_nodes];
  master.displacement.values(at.xi, phi);
  for (int j = 0; j < master.displacement.num_nodes(); ++j)
    for (int c = 0; c < _gdim; ++c)
      motion[c] -= phi[j] * du[std::size_t(master.nodes_of(at.facet)[j]) * _gdim + c];
}

bool NodeToSurface::passes(Touch& touch, const double* u, const double* du)
{
  const std::size_t i = touch.i;
  const bool open = _closed[i] == 0;
  const double smallest = _candidates.smallest();
  double motion[3];
  const auto length = [&] { return std::sqrt(std::inner_product(motion, motion + _gdim, motion, 0.0)); };
  if (_rigid)
  {
    relative_motion(i, touch.at, du, motion);
    if (!(length() > 0.5 * smallest))
      return false;
  }
  const Projection before = point_before(i, u, du, 1.0);
  if ((open && !(before.gap > 0.0)) || !std::isfinite(before.gap))
    return false;
  relative_motion(i, before, du, motion);
  const double way = length();
  if (!(way > 0.5 * smallest))
    return false;
  const int parts = int(std::min(std::ceil(2.0 * way / smallest), double(most_parts)));
  Projection first = touch.at;
  double back = 0.0;
  for (int k = 1; k < parts && back == 0.0; ++k)
    if (const Projection at = point_before(i, u, du, 1.0 - double(k) / parts); is_below(at))
    {
      first = at;
      back = 1.0 - double(k) / parts;
    }
  if (!is_below(first))
    return false;
  const double along = std::inner_product(motion, motion + _gdim, first.normal, 0.0);
  const double diameter = _rigid ? smallest : _tracking.diameter(first.facet), facets = -along / diameter;
  if (open && facets > 1.0)
  {
    if (facets > _passage.facets)
      _passage = {_candidates.nodes()[i], facets};
    return true;
  }
  first.gap += back * along;
  if (back > 0.0 && first.gap < 0.0 && !(is_below(touch.at) && touch.at.gap < first.gap + 0.5 * diameter))
    touch.at = first;
  return false;
}
} // namespace impact::enforcement
