// SPDX-License-Identifier: MIT
#pragma once
#include "CellFrequencies.h"
#include "InputChanges.h"
#include "StableStepWatch.h"
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

namespace dolfinx_impact::integrators
{
/// The stable step of a run, found again where it may have changed: as cells deform, every so many steps, or where
/// constants and functions that stiffness depends on have changed.
class SafeStep
{
public:
  /// How the stable step may change.
  struct Kind
  {
    bool watched = false;  ///< with the displacement, as cells deform: StableStepWatch
    bool periodic = false; ///< with the velocity or jumps between cells: it is found every so many steps
    bool flows = false;    ///< plastic flow may change it by a third within 100 steps: given steps are checked soon
  };

  /// Fraction of the stable step that automatic steps take; contact stiffness needs the rest.
  static constexpr double safety = 0.9;

  /// Collective.
  /// @param[in] u displacement that kernels read, ghosts up to date
  /// @param[in] integrator outlives this object
  SafeStep(const std::shared_ptr<const operators::Function>& u, std::shared_ptr<CellFrequencies> frequencies,
           CellSteps steps, Kind kind, CentralDifference& integrator);

  /// Largest stable step, as last computed [T].
  double value() const { return _value; }
  /// Largest stable step at the present state, of all cells; nothing is remembered. Collective [T].
  /// @throws common::BadValue if the stiffness of a cell is not finite
  double compute();
  /// Forget all that was found, as if the object were made at the present state. Collective.
  void begin_anew();
  /// Find the stable step of the present state anew. Collective.
  void find();
  /// How often that was done since the object was made, or began anew.
  std::int64_t num_found() const { return _num_found; }
  /// Has a cell deformed so far that it should be found anew? The same on all ranks.
  bool deformed() const { return _deformed || _integrator.deformed(); }

  /// Steps of a length begin.
  /// @param[in] nominal the length; 0: cells may deform as they like, the steps were given [T]
  void begin(double nominal);
  /// A call of `advance` begins.
  /// @param[in] known nothing has changed since the last one
  /// @param[in] given the steps were given: they are compared with the stable step now and then
  void enter(bool known, bool given);
  /// Should it be found anew before the next step?
  bool due(std::int64_t step) const;
  /// Find it anew and plan the next check. Collective.
  void recheck(std::int64_t step);
  /// Steps until the next check that is planned.
  std::int64_t steps_left(std::int64_t step, std::int64_t otherwise) const;
  /// The run went back to another state.
  void start_again(std::int64_t step);

  InputChanges changes;

  /// What a run that goes on needs beside the watch.
  struct Saved
  {
    double value = 0.0; ///< [T]
    std::int64_t check_step = 0, check_interval = 0;
    bool deformed = false;
  };
  Saved saved() const { return {_value, _check_step, _check_interval, deformed()}; }
  void restore(const Saved& saved);
  /// Null: the stable step does not change with the displacement.
  StableStepWatch* watch() { return _watch ? &*_watch : nullptr; }
  const CellSteps& steps() const { return _steps; }
  /// Steps after which a stable step that changes is computed again, at most; 500 unless set.
  std::int64_t longest_interval() const { return _longest; }
  /// To be set before the first step.
  void set_longest_interval(std::int64_t steps);

private:
  void plan(std::int64_t step, std::int64_t interval);

  std::shared_ptr<const operators::Function> _u;
  std::shared_ptr<CellFrequencies> _frequencies;
  CellSteps _steps;
  Kind _kind;
  CentralDifference& _integrator;
  std::optional<StableStepWatch> _watch;
  double _value = 0.0;
  bool _periodic = false; ///< in the present call
  bool _deformed = false; ///< a cell did, before the checkpoint from which the run goes on
  std::int64_t _longest = 500, _check_step = 0, _check_interval = 0, _num_found = 0;
};
} // namespace dolfinx_impact::integrators
