// SPDX-License-Identifier: MIT
#pragma once
#include "Supports.h"
#include <cstdint>
#include <dolfinx/fem/Function.h>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace dolfinx_impact::problems
{
/// External nodal forces that do not follow the bodies, times an amplitude.
struct LoadInTime
{
  std::vector<std::int32_t> dofs;                         ///< owned degrees of freedom
  std::vector<double> values;                             ///< at the amplitude one [F]
  std::optional<FunctionOfTime> amplitude = std::nullopt; ///< nothing: one [1]
};

/// What problems in time share: the motion as functions, supports and loads as functions of time, the present time.
class TransientProblem
{
public:
  typedef dolfinx::fem::Function<double> Function;

  virtual ~TransientProblem() = default;

  /// Displacement at the present time [L].
  const std::shared_ptr<Function>& displacement() const { return _u; }
  /// Velocity at the present time [L/T].
  const std::shared_ptr<Function>& velocity() const { return _v; }
  /// Acceleration at the present time [L/T^2].
  const std::shared_ptr<Function>& acceleration() const { return _a; }
  /// Present time [T].
  double time() const { return _time; }
  /// Number of the present step [1].
  std::int64_t step() const { return _step; }
  FunctionsOfTime& functions() { return _functions; }
  const FunctionsOfTime& functions() const { return _functions; }
  const Supports& supports() const { return _supports; }
  Supports& supports() { return _supports; }

protected:
  /// Collective.
  /// @param[in] u displacement at the start, becomes that of the present time [L]
  /// @param[in] v velocity at the start, becomes that of the present time; null: at rest [L/T]
  /// @param[in] functions those of loads; those of supports are added
  /// @param[in] a becomes the acceleration; null: a new function [L/T^2]
  /// @throws std::invalid_argument on all ranks for a velocity of another space; as Supports
  TransientProblem(std::shared_ptr<Function> u, std::shared_ptr<Function> v, std::vector<PrescribedMotion> motions,
                   FunctionsOfTime functions = {}, std::shared_ptr<Function> a = nullptr);

  MPI_Comm comm() const { return _u->function_space()->mesh()->comm(); }
  /// Number of degrees of freedom that this rank owns.
  std::size_t num_owned() const;
  /// Copy owned entries into the three functions, and bring their ghosts up to date. Collective.
  void set_motion(std::span<const double> u, std::span<const double> v, std::span<const double> a);

  std::shared_ptr<Function> _u, _v, _a;
  FunctionsOfTime _functions;
  Supports _supports;
  double _time = 0.0;
  std::int64_t _step = 0;
};
} // namespace dolfinx_impact::problems
