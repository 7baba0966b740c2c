// SPDX-License-Identifier: MIT
#pragma once
#include <cstdint>
#include <petscmat.h>
#include <span>
#include <vector>

namespace dolfinx_impact::integrators
{
/// Mass matrix M of bodies, consistent or lumped, and the degrees of freedom that have no mass.
class Inertia
{
public:
  /// @param[in] matrix M, of which a reference is kept; its rows are the owned degrees of freedom [M]
  /// @param[in] massless mask of owned degrees of freedom without mass that are not prescribed
  Inertia(Mat matrix, std::vector<std::int8_t> massless);
  ~Inertia();
  Inertia(const Inertia&) = delete;
  Inertia& operator=(const Inertia&) = delete;

  /// M x, owned. Collective.
  std::vector<double> times(std::span<const double> x) const;
  /// Solve M a = f for the free accelerations; those of massless degrees of freedom are zero. Collective.
  /// @param[in] forces f, owned [F]
  /// @param[in] fixed mask of degrees of freedom with given accelerations
  /// @param[in] given accelerations, owned, of which those of `fixed` are read [L/T^2]
  /// @returns accelerations, owned [L/T^2]
  /// @throws common::Failure if conjugate gradients do not converge
  std::vector<double> accelerations(std::span<const double> forces, std::span<const std::int8_t> fixed,
                                    std::span<const double> given) const;

  Mat matrix() const { return _matrix; }
  std::span<const std::int8_t> massless() const { return _massless; }

private:
  Mat _matrix;
  Vec _x = nullptr, _y = nullptr;
  std::vector<std::int8_t> _massless;
};
} // namespace dolfinx_impact::integrators
