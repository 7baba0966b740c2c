// SPDX-License-Identifier: MIT
#include "PairSearch.h"
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace dolfinx_impact::search
{
namespace
{
/// Largest diagonal of the boxes around facets at rest.
double largest_facet(const surface::Facets& facets)
{
  double largest = 0.0;
  const int n = facets.geometry.num_nodes(), gdim = facets.gdim;
  for (std::size_t f = 0; f < facets.size(); ++f)
  {
    double squared = 0.0;
    for (int c = 0; c < gdim; ++c)
    {
      double low = facets.X_of(f)[c], high = low;
      for (int i = 1; i < n; ++i)
      {
        low = std::min(low, facets.X_of(f)[i * gdim + c]);
        high = std::max(high, facets.X_of(f)[i * gdim + c]);
      }
      squared += (high - low) * (high - low);
    }
    largest = std::max(largest, std::sqrt(squared));
  }
  return largest;
}

double maximum(MPI_Comm comm, double value)
{
  MPI_Allreduce(MPI_IN_PLACE, &value, 1, MPI_DOUBLE, MPI_MAX, comm);
  return value;
}
} // namespace

PairSearch::PairSearch(std::shared_ptr<const surface::FunctionSpace> V, surface::Facets slave, surface::Facets master,
                       double reach)
    : _space(std::move(V)), _slave(std::move(slave)), _master(std::move(master)), _rest_reach(reach)
{
  const double facet = maximum(_space->mesh()->comm(), std::max(largest_facet(_slave), largest_facet(_master)));
  if (_rest_reach <= 0.0)
    _rest_reach = 2.0 * facet;
}

/// Largest distance of a surface's node between two displacements, on this rank.
double PairSearch::largest_distance(std::span<const double> u, std::span<const double> from) const
{
  const int gdim = _slave.gdim;
  double largest = 0.0;
  for (const surface::Facets* side : {&_slave, &_master})
    for (std::int32_t node : side->nodes)
    {
      double squared = 0.0;
      for (int c = 0; c < gdim; ++c)
        squared += std::pow(u[node * gdim + c] - from[node * gdim + c], 2);
      largest = std::max(largest, squared);
    }
  return std::sqrt(largest);
}

void PairSearch::update(std::span<const double> u, std::span<const double> start)
{
  const auto& map = *_space->dofmap()->index_map;
  const std::size_t size = std::size_t(map.size_local() + map.num_ghosts()) * _slave.gdim;
  if (u.size() < size || start.size() < size)
    throw std::invalid_argument("displacements are those of all owned and ghost nodes of the space");
  double moved[2] = {largest_distance(u, start), std::numeric_limits<double>::infinity()};
  if (_exchange)
    moved[1] = largest_distance(u, _built);
  MPI_Allreduce(MPI_IN_PLACE, moved, 2, MPI_DOUBLE, MPI_MAX, map.comm());
  _motion = 2.0 * moved[0];
  _reach = std::max(_rest_reach, _motion);
  // Candidates were taken from half as far again: they hold while nothing moves by a quarter of the reach.
  _kept = _reach <= _built_reach && moved[1] < 0.25 * _rest_reach;
  _stale = true;
  if (_kept)
  {
    _exchange->move(u);
    return;
  }
  surface::move(_slave, u.data());
  surface::move(_master, u.data());
  _closest.reset();
  _exchange = std::make_shared<Exchange>(*_space, _slave, _master, 1.5 * _reach);
  _built.assign(u.begin(), u.begin() + size);
  _built_reach = _reach;
  ++_num_exchanges;
}

const SurfaceSearch& PairSearch::closest()
{
  if (!_exchange)
    throw std::logic_error("closest points are known after an update");
  if (!_closest)
    _closest = std::make_unique<SurfaceSearch>(_exchange->master());
  else if (_stale)
    _closest->update();
  _stale = false;
  return *_closest;
}
} // namespace dolfinx_impact::search
