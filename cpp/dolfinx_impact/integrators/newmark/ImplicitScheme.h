// SPDX-License-Identifier: MIT
#pragma once
#include <array>
#include <string>

namespace dolfinx_impact::integrators
{
/// Parameters of the generalised-alpha method in the form of Arnold and Bruels (2007); seed (3.81), corrected,
/// docs/implicit/scheme.md.
///
/// Equilibrium M a + C v + F(u) = 0 holds at the end of a step. Displacement and velocity follow from Newmark's
/// formulas with an acceleration A of their own,
///
///     u_1 = u_0 + h v_0 + h^2 ((1/2 - beta) A_0 + beta A_1),    v_1 = v_0 + h ((1 - gamma) A_0 + gamma A_1),
///     (1 - alpha_m) A_1 + alpha_m A_0 = (1 - alpha_f) a_1 + alpha_f a_0.
///
/// With alpha_m = alpha_f = 0 it is A = a, Newmark's method. On linear problems without damping the displacements are
/// those of Chung and Hulbert (1993).
struct ImplicitScheme
{
  double beta = 0.25;   ///< weight of the new acceleration in the displacement [1]
  double gamma = 0.5;   ///< weight of the new acceleration in the velocity [1]
  double alpha_m = 0.0; ///< weight of the old A [1]
  double alpha_f = 0.0; ///< weight of the old a [1]

  /// Newmark's method (1959).
  /// @throws std::invalid_argument unless beta is positive and gamma at least 1/2
  static ImplicitScheme newmark(double beta, double gamma);
  /// Chung and Hulbert (1993).
  /// @param[in] rho_inf spectral radius at infinite frequency, 0 to 1 [1]
  /// @throws std::invalid_argument if it is not in that range
  static ImplicitScheme generalised_alpha(double rho_inf);
  /// Hilber, Hughes and Taylor (1977).
  /// @param[in] alpha -1/3 to 0 [1]
  /// @throws std::invalid_argument if it is not in that range
  static ImplicitScheme hht(double alpha);

  /// Is the error of the second power of the step?
  bool second_order() const;
  /// Factor of h^3 times the third derivative of u in the error of one step's displacement [1]; Zienkiewicz and Xie
  /// (1991) for Newmark's method.
  double error_constant() const { return beta - 1.0 / 6.0 - 0.5 * (alpha_f - alpha_m); }
  /// Largest product of angular frequency and step at which a motion without damping does not grow; infinite for
  /// schemes that are stable with any step [1].
  double stable_frequency() const;
  /// Matrix of a step of the oscillator u'' + 2 damping w u' + w^2 u = 0, row by row: it maps (u, h v, h^2 A) at the
  /// start of a step to that at its end.
  /// @param[in] product angular frequency times step, w h [1]
  /// @param[in] damping fraction of critical damping [1]
  std::array<double, 9> amplification(double product, double damping) const;
  /// Largest absolute eigenvalue of that matrix; at most one where the scheme is stable [1].
  double spectral_radius(double product, double damping) const;
  /// The parameters in words, those that are zero left out.
  std::string text() const;
};
} // namespace dolfinx_impact::integrators
