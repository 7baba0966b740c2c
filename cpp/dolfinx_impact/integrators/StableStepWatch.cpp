// SPDX-License-Identifier: MIT
#include "StableStepWatch.h"
#include "../common/dolfinx_api.h"
#include "../common/gather.h"
#include <algorithm>
#include <cmath>
#include <dolfinx/la/Vector.h>
#include <stdexcept>

namespace dolfinx_impact::integrators
{
namespace
{
constexpr double start = 6.0;  // change of ln(omega^2) by a deformation of one, expected at first; rubber has 4
constexpr double least = 0.6;  // that is always expected: a rotation changes nothing, what follows it may
constexpr double margin = 1.5; // by which what was seen may be exceeded
constexpr double decay = 0.7;  // of what was seen, from one look to the next
constexpr double share = 0.5;  // of the way to the limit that a cell may be expected to go between two looks
constexpr double close = 0.02; // least distance from the limit, in ln(omega^2): a given step may be the stable one
constexpr double told = 0.002; // deformation from which on a change of frequency says something
constexpr double infinity = std::numeric_limits<double>::infinity();
} // namespace

StableStepWatch::StableStepWatch(const operators::FunctionSpace& V, std::shared_ptr<CellFrequencies> frequencies,
                                 CellSteps steps, CentralDifference& integrator)
    : _map(V.dofmap()->index_map), _bs(V.dofmap()->index_map_bs()), _frequencies(std::move(frequencies)),
      _steps(std::move(steps)), _integrator(integrator), _sizes(cell_sizes(*V.mesh()))
{
  const std::size_t num = _sizes.size();
  _seen = {std::vector<double>(num, 0.0), std::vector<double>(num, 0.0), std::vector<double>(num, 0.0),
           std::vector<double>(std::size_t(_map->size_local() + _map->num_ghosts()) * _bs, 0.0), start};
  std::vector<std::int32_t> nodes;
  for (std::size_t cell = 0; cell < num; ++cell)
    nodes.insert(nodes.end(), V.dofmap()->cell_dofs(cell).begin(), V.dofmap()->cell_dofs(cell).end());
  _integrator.add_watch(nodes, int(V.dofmap()->element_dof_layout().num_dofs()));
}

double StableStepWatch::find_all(std::span<const double> u)
{
  auto found = _frequencies->by_cell();
  _seen.squares = std::move(found.squares);
  _seen.rates = std::move(found.rates);
  _seen.since.assign(_seen.squares.size(), 0.0);
  _seen.reference.assign(u.begin(), u.end());
  return step();
}

double StableStepWatch::find_changed(std::span<const double> u)
{
  const std::vector<double> moved = _integrator.deformations(u);
  for (std::size_t cell = 0; cell < moved.size(); ++cell)
    _seen.since[cell] += moved[cell] / _sizes[cell];
  _seen.reference.assign(u.begin(), u.end());
  const std::vector<double> may = allowed(_nominal);
  std::vector<std::int8_t> chosen(may.size());
  std::vector<double> before, deformed;
  for (std::size_t cell = 0; cell < may.size(); ++cell)
  {
    chosen[cell] = _seen.since[cell] > 0.5 * may[cell];
    if (chosen[cell])
    {
      before.push_back(_seen.squares[cell]);
      deformed.push_back(_seen.since[cell]);
    }
  }
  const auto found = _frequencies->by_cell(chosen);
  learn(before, found.squares, deformed);
  for (std::size_t cell = 0, k = 0; cell < may.size(); ++cell)
    if (chosen[cell])
    {
      _seen.squares[cell] = found.squares[k];
      _seen.rates[cell] = found.rates[k++];
      _seen.since[cell] = 0.0;
    }
  return step();
}

void StableStepWatch::begin(double nominal)
{
  std::vector<double> left(_sizes.size(), infinity);
  if (nominal > 0.0)
  {
    _nominal = nominal;
    left = allowed(nominal);
    for (std::size_t cell = 0; cell < left.size(); ++cell)
      left[cell] = std::max(left[cell] - _seen.since[cell], 0.0) * _sizes[cell];
  }
  _integrator.set_watch(_seen.reference, left);
}

void StableStepWatch::restore(Seen seen)
{
  const std::size_t owned = std::size_t(_map->size_local()) * _bs, num = _sizes.size();
  if (seen.squares.size() != num || seen.rates.size() != num || seen.since.size() != num ||
      seen.reference.size() != owned)
    throw std::invalid_argument("what the watch of the stable step has seen is that of another problem");
  dolfinx::la::Vector<double> reference(_map, _bs);
  std::ranges::copy(seen.reference, common::array(reference).begin());
  reference.scatter_fwd();
  seen.reference.assign(reference.array().begin(), reference.array().end());
  _seen = std::move(seen);
}

/// Deformations that cells may have before their frequency is computed again [1]. Cells without stiffness have no
/// distance: they may get some.
std::vector<double> StableStepWatch::allowed(double nominal) const
{
  std::vector<double> out = _steps(_seen.squares, _seen.rates);
  for (double& step : out)
  {
    const double distance = std::isfinite(step) ? 2.0 * std::log(step / nominal) : 0.0;
    step = share * std::max(distance, close) / _seen.sensitivity;
  }
  return out;
}

double StableStepWatch::step() const
{
  const std::vector<double> steps = _steps(_seen.squares, _seen.rates);
  double smallest = infinity;
  for (const double step : steps)
    smallest = std::min(smallest, step);
  MPI_Allreduce(MPI_IN_PLACE, &smallest, 1, MPI_DOUBLE, MPI_MIN, _map->comm());
  return smallest;
}

/// Adapt the sensitivity to changes of frequencies that were seen. Collective.
void StableStepWatch::learn(std::span<const double> before, std::span<const double> after,
                            std::span<const double> deformed)
{
  double seen = 0.0;
  for (std::size_t k = 0; k < before.size(); ++k)
    if (deformed[k] > told && before[k] > 0.0 && after[k] > 0.0)
      seen = std::max(seen, std::abs(std::log(after[k] / before[k])) / deformed[k]);
  seen = common::largest(_map->comm(), seen);
  _seen.sensitivity = std::max({margin * seen, decay * _seen.sensitivity, least});
}
} // namespace dolfinx_impact::integrators
