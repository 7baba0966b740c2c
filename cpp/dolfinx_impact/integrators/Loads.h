// SPDX-License-Identifier: MIT
#pragma once
#include "../operators/lanes.h"
#include <cstdint>
#include <span>
#include <vector>

namespace dolfinx_impact::integrators
{
/// External nodal forces: arrays of values, each times an amplitude that is a function of time.
class Loads
{
public:
  /// @param[in] size entries that this rank owns in arrays of nodal values (NodalFields)
  explicit Loads(std::size_t size) : _size(size) {}

  /// Add a load.
  /// @param[in] entries owned places in such arrays
  /// @param[in] values forces on them at the amplitude one [F]
  /// @param[in] amplitude column of the amplitudes that `apply` is given; -1: the amplitude is one
  /// @throws std::invalid_argument unless there are as many values as entries
  void add(std::span<const std::int32_t> entries, std::span<const double> values, int amplitude);
  /// Replace the values of a load.
  /// @param[in] i number of the load, in the order added
  /// @param[in] values as many as the load has entries [F]
  /// @throws std::invalid_argument for another number of values; std::out_of_range for a load that is not there
  void set_values(std::size_t i, std::span<const double> values);
  /// Evaluate the sum of all loads.
  /// @param[in] amplitudes at the present time [1]
  void apply(const double* amplitudes);

  /// Forces by owned entry, as `apply` left them [F]; null if there are no loads. Their memory begins
  /// with a cache line.
  const double* forces() const { return _forces.empty() ? nullptr : _forces.data(); }
  /// Force at one owned entry [F].
  double force(std::size_t entry) const { return !_loaded.empty() && _loaded[entry] ? _forces[entry] : 0.0; }

private:
  struct Load
  {
    std::vector<std::int32_t> entries;
    std::vector<double> values;
    int amplitude;
    double applied; ///< amplitude that the sum has of it; not a number: the sum has other values
  };
  std::size_t _size;
  std::vector<Load> _loads;
  operators::AlignedVector _forces;
  std::vector<bool> _loaded; ///< by entry: is it among those of a load? Few are, and most answers come from the cache
};
} // namespace dolfinx_impact::integrators
