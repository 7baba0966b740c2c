// SPDX-License-Identifier: MIT
#include "InternalForce.h"
#include "../common/dolfinx_api.h"
#include "../common/text.h"
#include "AveragedNeoHookean.h"
#include "NodalAverage.h"
#include "lanes.h"
#include <algorithm>
#include <dolfinx/fem/DofMap.h>
#include <functional>
#include <limits>
#include <stdexcept>

namespace dolfinx_impact::operators
{
namespace
{
/// Have the nodes of an array of forces four entries?
bool is_padded(int stride)
{
  return stride == 4;
}

/// Number that a cell has in the input of its mesh; without an input, as submeshes are, its global number.
std::int64_t input_cell_number(const dolfinx::mesh::Topology& topology, std::int32_t cell)
{
  if (topology.original_cell_index.size() == 1 && std::size_t(cell) < topology.original_cell_index[0].size())
    return topology.original_cell_index[0][cell];
  return topology.index_map(topology.dim())->local_range()[0] + cell;
}
} // namespace

InternalForce::InternalForce(const std::shared_ptr<const Mesh>& mesh, std::shared_ptr<const FunctionSpace> test,
                             const std::vector<Integral>& integrals,
                             const std::map<std::string, std::shared_ptr<const Function>>& coefficients, int width)
    : _mesh(mesh), _test(std::move(test))
{
  if (width != 0 && width != 1 && width != 4 && width != 8)
    throw std::invalid_argument("width is " + std::to_string(width) +
                                ": use 1, 4 or 8 cells per call, or 0 for the default");
  for (const Integral& i : integrals)
    _batches.emplace_back(i, mesh, _test, coefficients, width);
}

void InternalForce::assemble(std::span<double> b, bool padded) const
{
  if (!_test)
    throw std::invalid_argument("a form of rank 0 has a value, not a vector");
  const auto& map = *_test->dofmap();
  const int bs = map.index_map_bs(), stride = padded ? padded_stride(bs) : bs;
  const std::size_t size = std::size_t(map.index_map->size_local() + map.index_map->num_ghosts()) * stride;
  if (b.size() != size)
    throw std::invalid_argument("the vector has " + std::to_string(b.size()) +
                                " entries on this rank, the test space has " + std::to_string(size));
  update_averages(stride);
  for (std::size_t i = 0; i < _batches.size(); ++i)
    if (!is_together(i, stride))
      _batches[i].run(b.data(), padded ? padded_stride(_batches[i].block_size()) : _batches[i].block_size());
  for (const Averaged& one : _averages)
    if (one.stress && !is_together(*one.average, stride))
      one.average->add_forces(*one.stress, b, stride);
  for (const auto& forces : _together)
    if (is_padded(stride) && forces->can_run(_batches))
      forces->add_forces(_batches, b);
}

/// Is an integral, by its number, or an average a part of forces that are added together?
/// @param stride entries of a node in their array
bool InternalForce::is_together(const auto& part, int stride) const
{
  return is_padded(stride) && std::ranges::any_of(_together, [&](const auto& forces)
                                                  { return forces->can_run(_batches) && forces->is_for(part); });
}

void InternalForce::assemble(std::span<double> b) const
{
  assemble(b, false);
}

void InternalForce::assemble_padded(std::span<double> b) const
{
  assemble(b, true);
}

void InternalForce::read(const std::string& name, const double* values, int stride)
{
  for (Batches& batches : _batches)
    batches.read(name, values, stride);
  for (const Averaged& one : _averages)
    if (one.displacement == name)
      one.average->read(values, stride);
  for (const auto& forces : _together)
    forces->set_changed();
}

void InternalForce::read_positions(const NodePositions* positions)
{
  for (Batches& batches : _batches)
    batches.read_positions(positions);
  for (const Averaged& one : _averages)
    one.average->read_positions(positions);
  for (const auto& forces : _together)
    forces->set_changed();
}

void InternalForce::add_average(std::shared_ptr<NodalAverage> average, std::string displacement,
                                const std::optional<MeanStress>& stress)
{
  _averages.push_back({std::move(displacement), std::move(average), stress});
}

void InternalForce::update_averages(int stride) const
{
  for (const Averaged& one : _averages)
    if (!one.stress && !is_together(*one.average, stride))
      one.average->update();
}

void InternalForce::apply(dolfinx::la::Vector<double>& b) const
{
  common::fill(b, 0.0);
  assemble(common::array(b));
  b.scatter_rev(std::plus<double>());
  b.scatter_fwd();
}

double InternalForce::value() const
{
  if (_test)
    throw std::invalid_argument("a form of rank 1 has no value: use apply or assemble");
  update_averages(0);
  double sum = 0.0;
  for (const Batches& batches : _batches)
    sum += batches.run(nullptr, 0);
  return sum;
}

std::vector<std::int32_t> InternalForce::reached_dofs() const
{
  if (!_test)
    return {};
  std::vector<std::int32_t> nodes;
  for (const Batches& batches : _batches)
    nodes.insert(nodes.end(), batches.test_nodes().begin(), batches.test_nodes().end());
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  const int bs = _test->dofmap()->index_map_bs();
  std::vector<std::int32_t> dofs;
  dofs.reserve(nodes.size() * bs);
  for (const std::int32_t node : nodes)
    for (int c = 0; c < bs; ++c)
      dofs.push_back(bs * node + c);
  return dofs;
}

void InternalForce::each_history(auto&& work)
{
  for (const Batches& batches : _batches)
    if (batches.stores())
      work(*batches.history());
}

void InternalForce::commit()
{
  each_history([](PointHistory& history) { history.commit(); });
}

void InternalForce::revert()
{
  each_history([](PointHistory& history) { history.revert(); });
}

void InternalForce::set_in_place(bool in_place)
{
  each_history([=](PointHistory& history) { history.set_in_place(in_place); });
}

void InternalForce::store_snapshot()
{
  each_history([](PointHistory& history) { history.store_snapshot(); });
}

void InternalForce::restore_snapshot()
{
  each_history([](PointHistory& history) { history.restore_snapshot(); });
}

double InternalForce::sum(const std::string& name) const
{
  double total = 0.0;
  for (const Batches& batches : _batches)
    total += batches.sum(name);
  return total;
}

PointFailures InternalForce::failures() const
{
  PointFailures all;
  for (const Batches& batches : _batches)
  {
    const PointFailures& own = batches.failures();
    if (own.count == 0)
      continue;
    const std::size_t before = all.count;
    if (before == 0)
      all = own;
    all.count = before + own.count;
  }
  return all;
}

std::string InternalForce::fault() const
{
  if (std::ranges::none_of(_batches, [](const Batches& batches) { return batches.kernel().local_unknowns > 0; }))
    return "";
  const PointFailures own = failures();
  std::int64_t total = std::int64_t(own.count);
  MPI_Allreduce(MPI_IN_PLACE, &total, 1, MPI_INT64_T, MPI_SUM, _mesh->comm());
  if (total == 0)
    return "";
  std::vector<double> here; // cell, point, residual and unknowns of this rank's first
  if (own.count > 0)
  {
    here = {double(input_cell_number(*_mesh->topology(), own.cell)), double(own.point), own.residual};
    here.insert(here.end(), own.unknowns.begin(), own.unknowns.end());
  }
  // Of several materials the first ones may have another number of unknowns on each rank.
  std::int64_t size = std::int64_t(here.size());
  int rank = 0, first = size > 0 ? 0 : std::numeric_limits<int>::max();
  MPI_Comm_rank(_mesh->comm(), &rank);
  first = size > 0 ? rank : first;
  MPI_Allreduce(MPI_IN_PLACE, &first, 1, MPI_INT, MPI_MIN, _mesh->comm());
  MPI_Bcast(&size, 1, MPI_INT64_T, first, _mesh->comm());
  here.resize(std::size_t(size));
  MPI_Bcast(here.data(), int(size), MPI_DOUBLE, first, _mesh->comm());
  std::string unknowns;
  for (std::size_t i = 3; i < here.size(); ++i)
    unknowns += (i > 3 ? ", " : "") + common::text("%.6g", here[i]);
  return "the local equations of the material were not solved at " + std::to_string(total) +
         " points; the first is point " + std::to_string(int(here[1])) + " of cell " +
         std::to_string(std::int64_t(here[0])) + " (number in the mesh's input): residual " +
         common::text("%.3g", here[2]) + " of its scale, unknowns " + unknowns;
}

bool InternalForce::has_history() const
{
  return std::ranges::any_of(_batches, [](const Batches& batches) { return batches.stores(); });
}

std::size_t InternalForce::num_failures() const
{
  std::size_t count = 0;
  for (const Batches& batches : _batches)
    count += batches.failures().count;
  return count;
}

double InternalForce::flops() const
{
  double count = 0.0;
  for (const Batches& batches : _batches)
    count += batches.kernel().flops * batches.num_cells();
  return count;
}
} // namespace dolfinx_impact::operators
