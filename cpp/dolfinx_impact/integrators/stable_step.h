// SPDX-License-Identifier: MIT
#pragma once
#include "EnergyBalance.h"
#include <dolfinx/mesh/Mesh.h>
#include <span>
#include <vector>

/// Stable steps of explicit integration: seed (3.78)-(3.80), docs/explicit/stable_step.md.
namespace dolfinx_impact::integrators
{
/// Damping of all cells alike.
struct UniformDamping
{
  double alpha = 0.0;     ///< factor of mass-proportional damping [1/T]
  double beta = 0.0;      ///< factor of stiffness-proportional damping [T]
  double viscosity = 0.0; ///< factor of linear bulk viscosity [1]

  /// Eigenvalue of the damping over the mass, of modes of this squared frequency [1/T].
  double rate(double square) const;
};

/// Stable step of a mode with damping; seed (3.78), corrected. All damping adds up to a fraction xi of critical
/// damping: 2 xi omega = rate + that of uniform damping. The classical scheme's stable step does not depend on it.
/// @param[in] square of the angular frequency [1/T^2]
/// @param[in] rate eigenvalue of further damping over the mass [1/T]
/// @returns infinite where nothing limits it [T]
double stable_step(double square, double rate, const UniformDamping& uniform, Scheme scheme = Scheme::half_step);

/// What stable steps of cells depend on beside their own frequencies.
struct CellSteps
{
  UniformDamping uniform;
  Scheme scheme = Scheme::half_step;
  double springs = 0.0; ///< angular frequency that contact adds [1/T]
  double dampers = 0.0; ///< damping over mass that contact adds [1/T]

  /// @param[in] squares of the cells' highest angular frequencies [1/T^2]
  /// @param[in] rates largest eigenvalues of damping over mass [1/T]
  std::vector<double> operator()(std::span<const double> squares, std::span<const double> rates) const;
};

/// Shortest edge between vertices of each owned cell [L].
std::vector<double> cell_sizes(const dolfinx::mesh::Mesh<double>& mesh);
} // namespace dolfinx_impact::integrators
