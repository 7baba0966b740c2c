// SPDX-License-Identifier: MIT
#include "element.h"
#include <stdexcept>

namespace impact_reference
{
namespace
{
void check_field(const Sampler& sampler, const Vector& u)
{
  if (u.size() != sampler.gdim() * sampler.num_nodes())
    throw std::invalid_argument("the element has " + std::to_string(sampler.gdim() * sampler.num_nodes()) +
                                " degrees of freedom, but " + std::to_string(u.size()) + " values were given");
  if (not u.allFinite())
    throw std::invalid_argument("the displacement holds a value that is NaN or infinite");
}

void check_hypothesis(const Sampler& sampler, const Material& material)
{
  const Hypothesis h = hypothesis(material.hypothesis);
  if ((h == Hypothesis::solid) != (sampler.gdim() == 3))
    throw std::invalid_argument("hypothesis '" + material.hypothesis + "' does not go with a cell of dimension " +
                                std::to_string(sampler.gdim()) +
                                ": solid cells need 3d, plane cells plane_strain, plane_stress or axisymmetric");
  if ((h == Hypothesis::axisymmetric) != sampler.axisymmetric())
    throw std::invalid_argument("the integration weights and the material disagree about axisymmetry");
}

double hoop_radius(const Sample& s)
{
  if (not(s.radius > 0))
    throw std::invalid_argument(
        "an integration point lies on the axis (r = 0), where the hoop strain u_r / r is not defined: "
        "use a rule with interior points");
  return s.radius;
}

// G^T Sigma G with Sigma = S (x) I, plus the hoop term of the radial displacement: initial stress or geometric
// stiffness.
void add_geometric(Matrix& K, const Sample& s, Hypothesis h, const Vector& S)
{
  const int n = int(s.N.size()), d = int(s.dN.cols());
  Eigen::Matrix3d T = Eigen::Matrix3d::Zero();
  T(0, 0) = S(0);
  T(1, 1) = S(1);
  T(0, 1) = T(1, 0) = S(h == Hypothesis::solid or h == Hypothesis::axisymmetric ? 3 : 2);
  if (h == Hypothesis::solid)
  {
    T(2, 2) = S(2);
    T(1, 2) = T(2, 1) = S(4);
    T(0, 2) = T(2, 0) = S(5);
  }
  const Matrix NT = s.dN.lazyProduct(T.topLeftCorner(d, d)), H = NT.lazyProduct(s.dN.transpose());
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
    {
      for (int a = 0; a < d; ++a)
        K(d * i + a, d * j + a) += s.weight * H(i, j);
      if (h == Hypothesis::axisymmetric)
        K(d * i, d * j) += s.weight * s.N(i) * s.N(j) * S(2) / (s.radius * s.radius);
    }
}
} // namespace

void add_BtCB(Matrix& result, double weight, const Matrix& B, const Matrix& C)
{
  const Matrix CB = C.lazyProduct(B);
  result += weight * B.transpose().lazyProduct(CB);
}

Matrix strain_matrix(Hypothesis h, const Sample& s)
{
  const int n = int(s.N.size()), d = int(s.dN.cols());
  Matrix B = Matrix::Zero(num_strains(h), d * n);
  for (int i = 0; i < n; ++i)
  {
    const double x = s.dN(i, 0), y = s.dN(i, 1);
    if (h == Hypothesis::solid)
    {
      const double z = s.dN(i, 2);
      B.middleCols(3 * i, 3) << x, 0, 0, 0, y, 0, 0, 0, z, y, x, 0, 0, z, y, z, 0, x;
    }
    else if (h == Hypothesis::axisymmetric)
    {
      const double hoop = s.N(i) / hoop_radius(s);
      B.middleCols(2 * i, 2) << x, 0, 0, y, hoop, 0, y, x;
    }
    else
      B.middleCols(2 * i, 2) << x, 0, 0, y, y, x;
  }
  return B;
}

Matrix green_strain_matrix(Hypothesis h, const Sample& s, const Eigen::Matrix3d& F)
{
  const int n = int(s.N.size()), d = int(s.dN.cols());
  Matrix B = Matrix::Zero(num_strains(h), d * n);
  const int shear = num_strains(h) - (d == 3 ? 3 : 1);
  for (int i = 0; i < n; ++i)
    for (int c = 0; c < d; ++c)
    {
      auto column = B.col(d * i + c);
      for (int a = 0; a < d; ++a)
        column(a) = F(c, a) * s.dN(i, a);
      column(shear) = F(c, 0) * s.dN(i, 1) + F(c, 1) * s.dN(i, 0);
      if (d == 3)
      {
        column(4) = F(c, 1) * s.dN(i, 2) + F(c, 2) * s.dN(i, 1);
        column(5) = F(c, 0) * s.dN(i, 2) + F(c, 2) * s.dN(i, 0);
      }
      if (h == Hypothesis::axisymmetric and c == 0)
        column(2) = F(2, 2) * s.N(i) / hoop_radius(s);
    }
  return B;
}

Eigen::Matrix3d deformation_gradient(const Sample& s, const Vector& u)
{
  const int n = int(s.N.size()), d = int(s.dN.cols());
  const Eigen::Map<const Matrix> nodal(u.data(), n, d);
  Eigen::Matrix3d F = Eigen::Matrix3d::Identity();
  F.topLeftCorner(d, d) += nodal.transpose().lazyProduct(s.dN);
  if (s.radius > 0)
    F(2, 2) += nodal.col(0).dot(s.N) / s.radius;
  return F;
}

Matrix stiffness(const Sampler& sampler, const Matrix& X, const Material& material, std::int64_t cell)
{
  check(material);
  check_hypothesis(sampler, material);
  const int n = sampler.gdim() * sampler.num_nodes();
  const Matrix D = elasticity_matrix(material);
  Matrix K = Matrix::Zero(n, n);
  for (int q = 0; q < sampler.num_points(); ++q)
  {
    const Sample s = sampler.at(X, q, cell);
    const Matrix B = strain_matrix(hypothesis(material.hypothesis), s);
    add_BtCB(K, s.weight, B, D);
  }
  return K;
}

Internal internal(const Sampler& sampler, const Matrix& X, const Material& material, const Vector& u, bool with_tangent,
                  std::int64_t cell)
{
  check(material);
  check_hypothesis(sampler, material);
  check_field(sampler, u);
  const int n = sampler.gdim() * sampler.num_nodes();
  const bool linear = material.law == "linear_elastic";
  const Hypothesis h = hypothesis(material.hypothesis);
  Internal result{0, Vector::Zero(n), with_tangent ? Matrix(Matrix::Zero(n, n)) : Matrix()};
  for (int q = 0; q < sampler.num_points(); ++q)
  {
    const Sample s = sampler.at(X, q, cell);
    const Eigen::Matrix3d F = deformation_gradient(s, u);
    const Stress answer = linear ? small_strain(material, F) : second_piola(material, F);
    const Matrix B = linear ? strain_matrix(h, s) : green_strain_matrix(h, s, F);
    result.energy += s.weight * answer.energy;
    result.force += s.weight * B.transpose().lazyProduct(answer.S);
    if (with_tangent)
    {
      add_BtCB(result.tangent, s.weight, B, answer.C);
      if (not linear)
        add_geometric(result.tangent, s, h, answer.S);
    }
  }
  return result;
}

Matrix stress(const Sampler& sampler, const Matrix& X, const Material& material, const Vector& u, std::int64_t cell)
{
  check(material);
  check_hypothesis(sampler, material);
  check_field(sampler, u);
  Matrix result(sampler.num_points(), num_strains(hypothesis(material.hypothesis)));
  for (int q = 0; q < sampler.num_points(); ++q)
  {
    const Eigen::Matrix3d F = deformation_gradient(sampler.at(X, q, cell), u);
    result.row(q) =
        (material.law == "linear_elastic" ? small_strain(material, F) : second_piola(material, F)).S.transpose();
  }
  return result;
}
} // namespace impact_reference
