// SPDX-License-Identifier: MIT
#include "ImplicitScheme.h"
#include "../../common/text.h"
#include "../../solve/dense.h"
#include <cmath>
#include <limits>
#include <stdexcept>

using dolfinx_impact::common::shortest;

namespace dolfinx_impact::integrators
{
ImplicitScheme ImplicitScheme::newmark(double beta, double gamma)
{
  if (!(beta > 0.0))
    throw std::invalid_argument("beta is " + shortest(beta) +
                                ": an implicit scheme needs a positive one, for example 1/4");
  if (!(gamma >= 0.5))
    throw std::invalid_argument("gamma is " + shortest(gamma) + ": below 1/2 every motion grows; give at least 1/2");
  return {beta, gamma, 0.0, 0.0};
}

ImplicitScheme ImplicitScheme::generalised_alpha(double rho_inf)
{
  if (!(rho_inf >= 0.0 && rho_inf <= 1.0))
    throw std::invalid_argument("rho_inf is " + shortest(rho_inf) +
                                ": the spectral radius at infinite frequency is from 0 to 1");
  const double m = (2.0 * rho_inf - 1.0) / (rho_inf + 1.0), f = rho_inf / (rho_inf + 1.0);
  return {0.25 * (1.0 - m + f) * (1.0 - m + f), 0.5 - m + f, m, f};
}

ImplicitScheme ImplicitScheme::hht(double alpha)
{
  if (!(alpha >= -1.0 / 3.0 && alpha <= 0.0))
    throw std::invalid_argument("hht is " + shortest(alpha) + ": alpha of Hilber, Hughes and Taylor is from -1/3 to 0");
  return {0.25 * (1.0 - alpha) * (1.0 - alpha), 0.5 - alpha, 0.0, -alpha};
}

bool ImplicitScheme::second_order() const
{
  return std::abs(gamma - (0.5 - alpha_m + alpha_f)) <= 1e-9 * gamma;
}

double ImplicitScheme::stable_frequency() const
{
  const double infinite = std::numeric_limits<double>::infinity();
  if (alpha_m != 0.0 || alpha_f != 0.0) // both families are stable with any step
    return infinite;
  const double conditional = 0.5 * gamma - beta;
  return conditional > 1e-15 ? 1.0 / std::sqrt(conditional) : infinite;
}

std::array<double, 9> ImplicitScheme::amplification(double product, double damping) const
{
  // Newmark's two formulas are put into the mean of the accelerations, in which a = -c h v - w^2 h^2 u; that gives A_1.
  const double w2 = product * product, c = 2.0 * damping * product, m = alpha_m, f = alpha_f;
  const double divisor = (1.0 - m) + (1.0 - f) * (w2 * beta + c * gamma);
  const std::array<double, 3> A{-w2 / divisor, -((1.0 - f) * w2 + c) / divisor,
                                -(m + (1.0 - f) * (w2 * (0.5 - beta) + c * (1.0 - gamma))) / divisor};
  return {1.0 + beta * A[0],
          1.0 + beta * A[1],
          0.5 - beta + beta * A[2],
          gamma * A[0],
          1.0 + gamma * A[1],
          1.0 - gamma + gamma * A[2],
          A[0],
          A[1],
          A[2]};
}

double ImplicitScheme::spectral_radius(double product, double damping) const
{
  const auto A = amplification(product, damping);
  return solve::spectral_radius({A.begin(), A.end()}, 3);
}

std::string ImplicitScheme::text() const
{
  std::string out = "beta=" + common::text("%.10g", beta) + ", gamma=" + common::text("%.10g", gamma);
  if (alpha_m != 0.0 || alpha_f != 0.0)
    out += ", alpha_m=" + common::text("%.10g", alpha_m) + ", alpha_f=" + common::text("%.10g", alpha_f);
  return out;
}
} // namespace dolfinx_impact::integrators
