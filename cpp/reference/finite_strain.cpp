// SPDX-License-Identifier: MIT
#include "material.h"
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace impact_reference
{
namespace
{
using Matrix3 = Eigen::Matrix3d;
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

// Voigt order of the full tensors: 11 22 33 12 23 13.
constexpr int row[6] = {0, 1, 2, 0, 1, 0}, column[6] = {0, 1, 2, 1, 2, 2};

// Positions of a hypothesis's strain components in the Voigt order of the full tensors.
std::vector<int> components(Hypothesis h)
{
  if (h == Hypothesis::solid)
    return {0, 1, 2, 3, 4, 5};
  return h == Hypothesis::axisymmetric ? std::vector{0, 1, 2, 3} : std::vector{0, 1, 3};
}

struct Response
{
  Vector6 S;
  Matrix6 C;
  double energy;
};

// psi = mu/2 (tr C - 3) - mu ln J + lambda/2 (ln J)^2; S = mu (I - C^-1) + lambda ln J C^-1;
// dS/dE = lambda C^-1 (x) C^-1 + 2 (mu - lambda ln J) sym(C^-1 . C^-1)   (Bonet & Wood 6.27-6.31).
Response neo_hookean(double lambda, double mu, const Matrix3& C)
{
  const double log_j = 0.5 * std::log(C.determinant());
  const Matrix3 inverse = C.inverse();
  const Matrix3 S = mu * (Matrix3::Identity() - inverse) + lambda * log_j * inverse;
  Response r;
  for (int a = 0; a < 6; ++a)
  {
    const int i = row[a], j = column[a];
    r.S(a) = S(i, j);
    for (int b = 0; b < 6; ++b)
    {
      const int k = row[b], l = column[b];
      const double mixed = 0.5 * (inverse(i, k) * inverse(j, l) + inverse(i, l) * inverse(j, k));
      r.C(a, b) = lambda * inverse(i, j) * inverse(k, l) + 2 * (mu - lambda * log_j) * mixed;
    }
  }
  r.energy = 0.5 * mu * (C.trace() - 3) - mu * log_j + 0.5 * lambda * log_j * log_j;
  return r;
}

// C33 with S33 = 0: Newton's method in ln C33, which keeps C33 positive. S33 C33 grows monotonically with ln C33.
double thickness_stretch(double lambda, double mu, const Matrix3& C)
{
  const double in_plane = C(0, 0) * C(1, 1) - C(0, 1) * C(1, 0);
  double y = 0;
  for (int iteration = 0; iteration < 100; ++iteration)
  {
    const double residual = mu * (std::exp(y) - 1) + 0.5 * lambda * (std::log(in_plane) + y);
    const double step = residual / (mu * std::exp(y) + 0.5 * lambda);
    y -= std::clamp(step, -1.0, 1.0);
    if (std::abs(step) < 1e-15 * (1 + std::abs(y)))
      break;
  }
  return std::exp(y);
}

Matrix3 strain(const Matrix3& F)
{
  return 0.5 * (F.transpose() * F - Matrix3::Identity());
}

Vector engineering(Hypothesis h, const Matrix3& E)
{
  const std::vector<int> keep = components(h);
  Vector e(keep.size());
  for (std::size_t a = 0; a < keep.size(); ++a)
    e(a) = (keep[a] < 3 ? 1 : 2) * E(row[keep[a]], column[keep[a]]);
  return e;
}

Stress linear_answer(const Material& material, const Matrix3& E)
{
  const Matrix D = elasticity_matrix(material);
  const Vector e = engineering(hypothesis(material.hypothesis), E);
  return {D * e, D, 0.5 * e.dot(D * e)};
}
} // namespace

Stress small_strain(const Material& material, const Matrix3& F)
{
  return linear_answer(material, 0.5 * (F + F.transpose()) - Matrix3::Identity());
}

Stress second_piola(const Material& material, const Matrix3& F)
{
  // St Venant-Kirchhoff is Hooke's law between S and E, so the condensed matrix D of plane stress is exact.
  if (material.law == "st_venant_kirchhoff")
    return linear_answer(material, strain(F));
  if (not(F.determinant() > 0))
    throw std::domain_error("the deformation turns the material inside out: det F is " +
                            std::to_string(F.determinant()));
  const auto [lambda, mu] = lame(material);
  const Hypothesis h = hypothesis(material.hypothesis);
  Matrix3 C = F.transpose() * F;
  if (h == Hypothesis::plane_stress)
    C(2, 2) = thickness_stretch(lambda, mu, C);
  const Response full = neo_hookean(lambda, mu, C);
  const std::vector<int> keep = components(h);
  Stress s{Vector(keep.size()), Matrix(keep.size(), keep.size()), full.energy};
  for (std::size_t a = 0; a < keep.size(); ++a)
  {
    s.S(a) = full.S(keep[a]);
    for (std::size_t b = 0; b < keep.size(); ++b)
    {
      s.C(a, b) = full.C(keep[a], keep[b]);
      if (h == Hypothesis::plane_stress) // static condensation of dS33 = 0
        s.C(a, b) -= full.C(keep[a], 2) * full.C(2, keep[b]) / full.C(2, 2);
    }
  }
  return s;
}
} // namespace impact_reference
