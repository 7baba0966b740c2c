// SPDX-License-Identifier: MIT
#pragma once
#include "../operators/KernelTangent.h"
#include "../rolling/Flow.h"
#include "LoadedBody.h"
#include <dolfinx/fem/Function.h>

namespace dolfinx_impact::problems
{
/// What a body must be known by for its forces of inertia.
struct SpinningMaterial
{
  double density = 0.0;            ///< [M/L^3]
  std::vector<std::int32_t> cells; ///< owned, whose material spins
  std::string hypothesis = "";     ///< "3d", "plane_strain", ...; empty: the only one
};

/// Bodies with the forces of inertia of a material that spins, which act at deformed places: centrifugal load and W u;
/// seed (3.54)-(3.57), corrected, docs/rolling.md. Both grow with the square of the rate, which is read anew at every
/// call.
class SpinningBody : public LoadedBody
{
public:
  /// Collective.
  /// @param[in] u displacement [L]
  /// @param[in] body internal and external forces without inertia, in all cells of the mesh: its tangent has places for
  /// all entries of W
  /// @param[in] spin a motion of the flow with a Spin
  /// @throws std::runtime_error if there are no kernels for this mesh and degree
  /// @throws std::invalid_argument for a motion that is no Spin
  SpinningBody(std::shared_ptr<dolfinx::fem::Function<double>> u, std::shared_ptr<solve::Body> body,
               const rolling::Motion& spin, const SpinningMaterial& material);
  ~SpinningBody() override;

  Vec residual() override;
  Mat tangent() override;
  std::optional<double> stored_energy() override { return {}; } ///< of the flow it is not known

private:
  double square() const { return _rate->value[0] * _rate->value[0]; }

  std::shared_ptr<dolfinx::fem::Function<double>> _u;
  std::shared_ptr<dolfinx::fem::Constant<double>> _rate;
  std::vector<double> _load;                            ///< centrifugal load at a rate of one, owned
  std::unique_ptr<operators::KernelTangent> _softening; ///< W at a rate of one
  Mat _tangent = nullptr;
  Vec _displacement = nullptr, _product = nullptr; ///< of W
};
} // namespace dolfinx_impact::problems
