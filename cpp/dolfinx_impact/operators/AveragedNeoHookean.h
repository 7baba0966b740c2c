// SPDX-License-Identifier: MIT
#pragma once
#include "../kernels/averaged_neo_hookean.h"
#include "Batches.h"
#include "Halo.h"
#include "NodalAverage.h"
#include "lanes.h"
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace dolfinx_impact::operators
{
/// Forces of a neo-Hookean material with averaged strains on linear tetrahedra: the forces of kernels that read means
/// of ln J, and those of the stress of mean gradients, together in two sweeps over the cells
/// (kernels/averaged_neo_hookean.h). For explicit runs, which have positions and displacements in arrays of four
/// entries for each node; where something else is given, the kernels and NodalAverage do the same.
class AveragedNeoHookean
{
public:
  /// Collective.
  /// @param[in] integrals numbers of the operator's integrals over the material's cells, the same on all ranks
  /// @param[in] log_mean means of ln J, which their kernels read
  /// @param[in] gradients means of the gradients over the same cells
  /// @param[in] V space of the displacement and of the forces
  /// @param[in] displacement name of the displacement in those kernels
  AveragedNeoHookean(std::vector<std::size_t> integrals, std::shared_ptr<const Function> log_mean,
                     std::shared_ptr<const NodalAverage> gradients, std::shared_ptr<const FunctionSpace> V,
                     std::string displacement, const kernels::AveragedModuli& moduli);

  /// Is it an integral over the material's cells?
  bool is_for(std::size_t integral) const;
  /// Are these the material's means?
  bool is_for(const NodalAverage& average) const
  {
    return average.function() == _log_mean || &average == _gradients.get();
  }
  /// Forget what `can_run` has found: arrays are others. Collective.
  void set_changed() { _can_run.reset(); }
  /// Can the forces be computed? All ranks find the same. Collective after `set_changed`.
  /// @param[in] batches of all integrals
  bool can_run(std::span<const Batches> batches);
  /// Add the forces of the material's cells. Collective.
  /// @param[in] batches of all integrals
  /// @param[in,out] b four entries for each node, owned and ghosts
  /// @pre can_run is true
  void add_forces(std::span<const Batches> batches, std::span<double> b);

private:
  bool fits(const Batches& batches) const;
  void set_entries(std::span<const Batches> batches);
  kernels::AveragedCells cells(const Batches& batches, const std::vector<unsigned>& entries, double* b);

  std::vector<std::size_t> _integrals;
  std::shared_ptr<const Function> _log_mean;
  std::shared_ptr<const NodalAverage> _gradients;
  std::string _displacement;
  kernels::AveragedModuli _moduli;
  Halo _halo;
  std::optional<bool> _can_run;
  std::vector<std::vector<unsigned>> _entries; ///< of each integral: kernels::AveragedCells::entries
  AlignedVector _means;                        ///< kernels::entries_of_means for each node
};
} // namespace dolfinx_impact::operators
