// SPDX-License-Identifier: MIT
#pragma once
#include "CellFrequencies.h"
#include "CentralDifference.h"
#include "stable_step.h"
#include <limits>
#include <memory>
#include <span>
#include <vector>

namespace dolfinx_impact::integrators
{
/// Frequencies of the cells, each at the deformation at which it was computed last; docs/explicit/stable_step.md.
///
/// A cell whose frequency has a distance from what the steps bear may deform for a while before it is looked at again:
/// the integrator stops when one has deformed by more than the distance allows, if ln(omega^2) changes by `sensitivity`
/// times the deformation at most, which is learned.
class StableStepWatch
{
public:
  /// @param[in] integrator outlives this object
  StableStepWatch(const operators::FunctionSpace& V, std::shared_ptr<CellFrequencies> frequencies, CellSteps steps,
                  CentralDifference& integrator);

  /// Compute the frequencies of all cells. Collective.
  /// @param[in] u displacement, owned and ghosts [L]
  /// @returns stable step [T]
  /// @throws common::BadValue if the stiffness of a cell is not finite
  double find_all(std::span<const double> u);
  /// Compute the frequencies of the cells that have deformed on their way to the limit. Collective; as find_all.
  double find_changed(std::span<const double> u);
  /// Tell the integrator how far cells may deform under steps of a length.
  /// @param[in] nominal largest step; 0: cells may deform as they like [T]
  void begin(double nominal);

  /// What a run that goes on needs.
  struct Seen
  {
    std::vector<double> squares;   ///< of the highest angular frequency of each owned cell [1/T^2]
    std::vector<double> rates;     ///< largest eigenvalue of damping over mass of each owned cell [1/T]
    std::vector<double> since;     ///< deformation of each cell since its frequency was computed, at the last look [1]
    std::vector<double> reference; ///< displacement at the last look, owned and ghosts [L]
    double sensitivity = 0.0;      ///< expected change of ln(omega^2) by a deformation of one [1]
  };
  const Seen& seen() const { return _seen; }
  /// @param[in] seen with owned entries of the reference. Collective
  /// @throws std::invalid_argument for another number of cells or degrees of freedom
  void restore(Seen seen);

private:
  std::vector<double> allowed(double nominal) const;
  double step() const;
  void learn(std::span<const double> before, std::span<const double> after, std::span<const double> deformed);

  std::shared_ptr<const dolfinx::common::IndexMap> _map;
  int _bs;
  std::shared_ptr<CellFrequencies> _frequencies;
  CellSteps _steps;
  CentralDifference& _integrator;
  std::vector<double> _sizes; ///< of cells [L]
  Seen _seen;
  double _nominal = std::numeric_limits<double>::infinity();
};
} // namespace dolfinx_impact::integrators
