// SPDX-License-Identifier: MIT
#pragma once
#include "KinematicContact.h"
#include <algorithm>
#include <span>
#include <utility>
#include <vector>

namespace dolfinx_impact::enforcement
{
/// Corrects a predicted step by all kinematic contacts of a run together: nodes that several of them act on move once
/// (docs/explicit/kinematic.md, "Several pairs").
class KinematicStep
{
public:
  void add(KinematicContact* contact) { _contacts.push_back(contact); }
  bool empty() const { return _contacts.empty(); }

  /// Take the nodes of a search, after NodalContact::needs and number. Collective.
  /// @param[in] all Halo that was passed to `needs`
  /// @param[in] halo, numbers as for NodalContact::number; a reference to `halo` is kept
  void assign_numbers(operators::Halo& all, operators::Halo& halo, std::span<const std::int32_t> numbers);

  /// Collective. No allocation.
  /// @param[in] step as predicted, ghosts valid
  /// @param[in,out] u predicted displacements, ghosts valid; on return corrected, ghosts valid [L]
  /// @param[in,out] f complete on owned nodes: forces are added [F]
  void correct(const PredictedStep& step, std::span<double> u, std::span<double> f);

private:
  void sum_weights(std::span<const double> inverse_mass);
  template <int D>
  void find_largest_weights(std::span<const double> inverse_mass);
  void sweep(const PredictedStep& step, double factor, KinematicContact::Sweep which);
  /// Calls each(first, last) for ranges of the nodes that contacts act on, or of those that the rank owns.
  void for_ranges(bool owned, auto&& each) const
  {
    const std::size_t end = owned ? _halo->num_owned() : _halo->num_nodes();
    for (const auto& [first, last] : _ranges)
      if (first < end)
        each(first, std::min(last, end));
  }

  std::vector<KinematicContact*> _contacts;
  operators::Halo* _halo = nullptr;
  std::vector<std::pair<std::size_t, std::size_t>> _ranges; ///< of nodes that any contact acts on: first and end
  std::vector<std::int32_t> _shared;                        ///< owned ones that belong to several surfaces
  int _gdim = 0, _stride = 0;
  CorrectedNodes _values;
};
} // namespace dolfinx_impact::enforcement
