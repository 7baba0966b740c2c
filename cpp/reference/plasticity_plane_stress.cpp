// SPDX-License-Identifier: MIT
#include "plasticity.h"
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace impact_reference
{
namespace
{
// Column and row of component 33 leave the tangent, whose answer to it makes stress_33 stay zero.
void condense(Tensor4& tangent)
{
  const Eigen::Matrix<double, 9, 1> c = tangent.col(8);
  const Eigen::Matrix<double, 1, 9> r = tangent.row(8);
  tangent -= c * r / r(8);
  tangent.row(8).setZero();
  tangent.col(8).setZero();
}

void check_plane(const Tensor& a, const char* what)
{
  if (a(0, 2) != 0 or a(1, 2) != 0 or a(2, 0) != 0 or a(2, 1) != 0)
    throw std::invalid_argument(std::string("plane stress has no ") + what + " 13 and 23");
}
} // namespace

J2Answer J2::plane_stress(const Tensor& strain, const J2History& history, bool with_tangent) const
{
  check_plane(strain, "shear strains");
  Tensor full = strain;
  // The elastic answer is the first guess; stress_33 grows with strain_33, so that a bracket is safe.
  const double lambda = bulk_ - 2.0 / 3 * shear_;
  const Tensor& p = history.plastic;
  full(2, 2) = p(2, 2) - lambda * (strain(0, 0) + strain(1, 1) - p(0, 0) - p(1, 1)) / (lambda + 2 * shear_);
  double low = -std::numeric_limits<double>::infinity(), high = -low;
  for (int iteration = 0; iteration < 200; ++iteration)
  {
    J2Answer answer = small_strain(full, history, true);
    const double residual = answer.stress(2, 2), here = full(2, 2);
    (residual < 0 ? low : high) = here;
    double next = here - residual / answer.tangent(8, 8);
    if (not(next >= low and next <= high))
      next = (low + high) / 2;
    // Round-off of the stress that the strains of the point make.
    const double noise = 4e-16 * (bulk_ + 2 * shear_) * (full.norm() + p.norm());
    if (std::abs(residual) <= noise or next == here)
    {
      condense(answer.tangent);
      if (not with_tangent)
        answer.tangent.setZero();
      return answer;
    }
    full(2, 2) = next;
  }
  throw std::domain_error("plane stress: no strain_33 was found that makes stress_33 vanish");
}

J2Answer J2::finite_plane_stress(PlasticStrain strain, const Tensor& F, const J2History& history,
                                 bool with_tangent) const
{
  check_plane(F, "shear components");
  const auto solid = [&](const Tensor& full)
  { return strain == PlasticStrain::simo ? simo(full, history, true) : hencky(full, history, true); };
  Tensor full = F;
  // Newton's method in y = ln F_33, from the thickness of the last step. tau_33 = F_33 P_33 grows with y, so that a
  // bracket is safe: it rises with the pressure K/2 (J^2 - 1) or K ln J, and the deviator, which yields, is bounded.
  const double largest = 0.5; // change of y in one iteration
  double y = std::log(history.thickness), low = -std::numeric_limits<double>::infinity(), high = -low;
  bool found = false;
  for (int iteration = 0; iteration < 200; ++iteration)
  {
    full(2, 2) = std::exp(y);
    J2Answer answer = solid(full);
    if (found)
    {
      answer.history.thickness = full(2, 2);
      condense(answer.tangent);
      if (not with_tangent)
        answer.tangent.setZero();
      return answer;
    }
    const double P = answer.stress(2, 2), tau = P * full(2, 2);
    (tau < 0 ? low : high) = y;
    const double slope = full(2, 2) * (full(2, 2) * answer.tangent(8, 8) + P);
    double next = slope > 0 ? y - std::clamp(tau / slope, -largest, largest) : y - std::copysign(largest, tau);
    if (not(next >= low and next <= high))
      next = (low + high) / 2;
    // The change of y is round-off of b_e = F C_p^-1 F^T, of whose small difference from I the stress is made. It is
    // made still: Newton's method has squared it before.
    found = std::abs(next - y) <= 4e-16 * full.squaredNorm() * history.plastic.norm();
    y = next;
  }
  throw std::domain_error("plane stress: no F_33 was found that makes the stress across the plane vanish");
}
} // namespace impact_reference
