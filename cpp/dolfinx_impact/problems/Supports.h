// SPDX-License-Identifier: MIT
#pragma once
#include "FunctionsOfTime.h"
#include <cstdint>
#include <dolfinx/fem/DirichletBC.h>
#include <dolfinx/fem/Function.h>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace dolfinx_impact::problems
{
/// Displacements prescribed in time: those of a boundary condition times an amplitude, or constant.
struct PrescribedMotion
{
  std::shared_ptr<const dolfinx::fem::DirichletBC<double>> bc;
  std::optional<FunctionOfTime> amplitude = std::nullopt; ///< [1]
};

/// Mask of the degrees of freedom that supports prescribe, owned and ghosts.
std::vector<std::int8_t> prescribed_dofs(const dolfinx::fem::FunctionSpace<double>& V,
                                         const std::vector<PrescribedMotion>& supports);

/// Prescribed degrees of freedom of a problem; where several conditions prescribe the same one, the first counts.
class Supports
{
public:
  struct Part
  {
    std::vector<std::int32_t> dofs; ///< owned ones
    std::vector<double> values;     ///< at the amplitude one [L]
    int column = -1;                ///< of its amplitude in the functions of time; -1: constant
  };

  /// Collective.
  /// @param[in] u displacement at the start [L]
  /// @param[in,out] functions receive the amplitudes
  /// @throws std::invalid_argument on all ranks if a prescribed displacement is another one than that of u at the start
  Supports(const dolfinx::fem::Function<double>& u, std::vector<PrescribedMotion> motions, FunctionsOfTime& functions);

  const std::vector<Part>& parts() const { return _parts; }
  /// By degree of freedom, owned and ghosts: is it prescribed?
  const std::vector<std::int8_t>& mask() const { return _mask; }
  /// @throws std::invalid_argument on this rank, without communication, if the value of a condition has been changed
  void check();

private:
  std::vector<PrescribedMotion> _motions;
  std::vector<Part> _parts;
  std::vector<std::int8_t> _mask;
  std::vector<double> _present; ///< values of a condition now, where it prescribes any
};
} // namespace dolfinx_impact::problems
