// SPDX-License-Identifier: MIT
#include "AveragedNeoHookean.h"
#include "../common/dolfinx_api.h"
#include <algorithm>
#include <dolfinx/fem/DofMap.h>
#include <string_view>
#include <utility>

namespace dolfinx_impact::operators
{
AveragedNeoHookean::AveragedNeoHookean(std::vector<std::size_t> integrals, std::shared_ptr<const Function> log_mean,
                                       std::shared_ptr<const NodalAverage> gradients,
                                       std::shared_ptr<const FunctionSpace> V, std::string displacement,
                                       const kernels::AveragedModuli& moduli)
    : _integrals(std::move(integrals)), _log_mean(std::move(log_mean)), _gradients(std::move(gradients)),
      _displacement(std::move(displacement)), _moduli(moduli), _halo(V->dofmap()->index_map)
{
}

bool AveragedNeoHookean::is_for(std::size_t integral) const
{
  return std::ranges::find(_integrals, integral) != _integrals.end();
}

bool AveragedNeoHookean::fits(const Batches& batches) const
{
  const impact_kernel& k = batches.kernel();
  const std::size_t num_nodes = std::size_t(_halo.num_nodes());
  return std::string_view(k.cell) == "tetrahedron" && k.geometry_degree == 1 &&
         batches.nodes_of_test().num_nodes == 4 && batches.block_size() == 3 &&
         kernels::averaged_neo_hookean(batches.width()).add_forces && batches.has_nodes_of_test(*_log_mean) &&
         batches.padded_positions() && batches.padded_values(_displacement) &&
         _gradients->inverse_volumes().size() == num_nodes;
}

bool AveragedNeoHookean::can_run(std::span<const Batches> batches)
{
  if (_can_run)
    return *_can_run;
  // Widths are found by each rank; one without cells has nothing to say.
  int mine =
      std::ranges::all_of(_integrals, [&](std::size_t i) { return batches[i].num_cells() == 0 || fits(batches[i]); });
  MPI_Allreduce(MPI_IN_PLACE, &mine, 1, MPI_INT, MPI_MIN, _log_mean->function_space()->mesh()->comm());
  _can_run = mine != 0;
  if (*_can_run && _entries.empty())
    set_entries(batches);
  return *_can_run;
}

/// First entries of the nodes of all integrals.
void AveragedNeoHookean::set_entries(std::span<const Batches> batches)
{
  _entries.clear();
  for (const std::size_t i : _integrals)
  {
    std::vector<unsigned>& entries = _entries.emplace_back();
    for (const std::int32_t node : batches[i].nodes_of_test().numbers)
      entries.push_back(4 * unsigned(node));
  }
}

kernels::AveragedCells AveragedNeoHookean::cells(const Batches& batches, const std::vector<unsigned>& entries,
                                                 double* b)
{
  const std::size_t width = std::size_t(batches.width()), num_batches = (batches.num_cells() + width - 1) / width;
  return {.num_batches = num_batches,
          .used = int(batches.num_cells() - (num_batches - 1) * width),
          .entries = entries.data(),
          .positions = batches.padded_positions(),
          .displacement = batches.padded_values(_displacement),
          .means = _means.data(),
          .forces = b};
}

void AveragedNeoHookean::add_forces(std::span<const Batches> batches, std::span<double> b)
{
  constexpr int entries = kernels::entries_of_means;
  const std::size_t num_nodes = std::size_t(_halo.num_nodes());
  _means.assign(entries * num_nodes, 0.0);
  const auto each = [&](auto&& work)
  {
    for (std::size_t k = 0; k < _integrals.size(); ++k)
      if (const Batches& one = batches[_integrals[k]]; one.num_cells() > 0)
        work(kernels::averaged_neo_hookean(one.width()), cells(one, _entries[k], b.data()));
  };
  each([](const auto& kernel, const auto& cells) { kernel.add_means(cells); });
  _halo.reverse(_means, entries);
  _halo.forward(_means, entries);
  bool known = false; // stresses of the nodes, which all of the material's integrals share
  each(
      [&](const auto& kernel, const auto& cells)
      {
        if (!std::exchange(known, true))
          kernel.set_stress(num_nodes, _gradients->inverse_volumes().data(), _moduli, _means.data());
        kernel.add_forces(cells, _moduli);
      });
}
} // namespace dolfinx_impact::operators
