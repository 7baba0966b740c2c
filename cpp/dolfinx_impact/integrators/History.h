// SPDX-License-Identifier: MIT
#pragma once
#include "energy.h"
#include <cstddef>
#include <span>

namespace dolfinx_impact::integrators
{
/// Rows of a run's history in the caller's memory, one for each step: the Energies before the step in their order, then
/// three components of each contact's force.
class History
{
public:
  History() = default;
  /// @param[in] values room for whole rows, or empty: nothing is written
  /// @param[in] num_contacts contacts of the run
  History(std::span<double> values, std::size_t num_contacts) : _values(values), _row_size(row_size(num_contacts)) {}
  static std::size_t row_size(std::size_t num_contacts) { return Energies::size + 3 * num_contacts; }

  /// Write a row.
  /// @param[in] step number of the row
  /// @param[in] forces of the contacts, three components each [F]
  void write(std::size_t step, const Energies& energies, std::span<const double> forces) const;

private:
  std::span<double> _values;
  std::size_t _row_size = Energies::size;
};
} // namespace dolfinx_impact::integrators
