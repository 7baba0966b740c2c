// SPDX-License-Identifier: MIT
#pragma once
#include "Sampler.h"
#include "plasticity.h"
#include <span>
#include <string>

namespace impact_reference
{
/// What takes the place of the dilatation in a cell: nothing, its mean, or the linear function of position that fits it
/// best in the sense of least squares (displacements of degree 2, discontinuous linear pressures).
enum class Dilatation
{
  pointwise,
  mean,
  linear
};

/// @param name "pointwise", "mean" or "linear"
/// @throws std::invalid_argument for other names
Dilatation dilatation(const std::string& name);

/// What a cell makes of its displacements before the law sees them.
struct PlasticKinematics
{
  Hypothesis hypothesis = Hypothesis::solid;
  PlasticStrain strain = PlasticStrain::small;
  /// Dilatation of all three components of the strain in every hypothesis, written here for the mean over the cell.
  /// Small strain, B-bar (Hughes 1980): eps_bar = dev eps + <tr eps> / 3 I.
  /// Finite strain, F-bar: F_bar = (<J> / J)^(1/3) F (Simo, Taylor & Pister 1985; Bonet & Wood ch. 8.6.5).
  /// <.> is the mean, or the fit, by the reference volumes of the points. Forces are conjugate in work to the varied
  /// eps_bar, F_bar.
  Dilatation dilatation = Dilatation::pointwise;
};

struct PlasticInternal
{
  double energy = 0;               ///< elastic [F L]
  double work = 0;                 ///< plastic, since the start [F L]
  double dissipation = 0;          ///< of the step [F L]
  Vector force;                    ///< [F]
  Matrix tangent;                  ///< derivative of force [F/L]; empty if not asked for
  std::vector<J2History> history;  ///< at the end of the step, by points
  std::vector<J2Answer> answers{}; ///< by points
};

/// Internal force of a cell whose points obey J2 plasticity.
/// @param u displacements (gdim num_nodes) [L]
/// @param committed history at the start of the step, by points; it stays as it is
/// @throws std::invalid_argument for what does not fit; plane stress has no other dilatation
/// @throws std::domain_error see J2
PlasticInternal plastic_internal(const Sampler& sampler, const Matrix& X, const J2& law,
                                 const PlasticKinematics& kinematics, const Vector& u,
                                 std::span<const J2History> committed, bool with_tangent, std::int64_t cell = 0);
} // namespace impact_reference
