// SPDX-License-Identifier: MIT
#include "SymmetricEigen.h"
#include "explicit.h"
#include <stdexcept>

namespace impact_reference
{
namespace
{
// Highest eigenvalue of a symmetric operator by Lanczos' method with full reorthogonalisation (Bathe ch. 11.5; Parlett
// ch. 13). A Ritz value is off by the square of its residual over the distance to the next eigenvalue.
template <typename F>
double lanczos(Eigen::Index size, F&& apply)
{
  const Eigen::Index most = std::min<Eigen::Index>(size, 400);
  Eigen::MatrixXd V(size, most);
  Vector alpha(most), beta(most);
  Vector v(size);
  std::uint64_t state = 88172645463325252ull;
  for (Eigen::Index i = 0; i < size; ++i)
  {
    state = state * 6364136223846793005ull + 1442695040888963407ull;
    v(i) = double(state >> 11) / double(1ull << 53) - 0.5;
  }
  V.col(0) = v / v.norm();
  for (Eigen::Index k = 0; k < most; ++k)
  {
    Vector w = apply(V.col(k));
    alpha(k) = w.dot(V.col(k));
    for (int pass = 0; pass < 2; ++pass)
      w -= V.leftCols(k + 1) * (V.leftCols(k + 1).transpose() * w).eval();
    beta(k) = w.norm();
    if (k % 10 == 9 or k + 1 == most or beta(k) < 1e-14 * std::abs(alpha(0)))
    {
      Eigen::MatrixXd T = alpha.head(k + 1).asDiagonal();
      for (Eigen::Index i = 0; i < k; ++i)
        T(i, i + 1) = T(i + 1, i) = beta(i);
      const SymmetricEigen small(T);
      const double top = small.eigenvalues()(k), residual = beta(k) * std::abs(small.eigenvectors()(k, k));
      if (residual < 1e-9 * top or k + 1 == size)
        return top;
    }
    if (k + 1 < most)
      V.col(k + 1) = w / beta(k);
  }
  throw std::runtime_error("Lanczos' method did not find the highest frequency in 400 steps: use method 'element'");
}
} // namespace

double highest_frequency(const Csr& K, const std::vector<Csr*>& springs, const Vector& mass,
                         const std::vector<std::int64_t>& fixed_dofs)
{
  Vector root = mass.cwiseSqrt().cwiseInverse();
  if (not(mass.minCoeff() > 0))
    throw std::invalid_argument("a nodal mass is not positive: choose the lumping scheme hrz or auto");
  for (auto dof : fixed_dofs)
    root(dof) = 0;
  const auto apply = [&](const Vector& x)
  {
    const Vector scaled = root.cwiseProduct(x);
    Vector y = K.dot(scaled);
    for (const Csr* more : springs)
      y += more->dot(scaled);
    return Vector(root.cwiseProduct(y));
  };
  if (K.size > 400)
    return std::sqrt(lanczos(K.size, apply));
  Eigen::MatrixXd A(K.size, K.size);
  for (std::int64_t j = 0; j < K.size; ++j)
    A.col(j) = apply(Vector::Unit(K.size, j));
  const Eigen::MatrixXd symmetric = (A + A.transpose()) / 2;
  const SymmetricEigen solver(symmetric, false);
  return std::sqrt(std::max(0.0, solver.eigenvalues().maxCoeff()));
}
} // namespace impact_reference
