// SPDX-License-Identifier: MIT
#include "dense.h"
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <petscblaslapack.h>
#include <stdexcept>
#include <string>

namespace dolfinx_impact::solve
{
SymmetricEigen symmetric_eigen(std::vector<double> A, int n)
{
  SymmetricEigen out;
  out.values.resize(n);
  if (n == 0)
    return out;
  PetscBLASInt size = n, info = 0, length = 34 * n;
  std::vector<double> work(length);
  LAPACKsyev_("V", "U", &size, A.data(), &size, out.values.data(), work.data(), &length, &info);
  if (info != 0)
    throw std::runtime_error("LAPACK's dsyev ended with " + std::to_string(int(info)));
  out.vectors = std::move(A); // columns, one behind the other
  return out;
}

std::optional<std::vector<double>> solve_dense(std::vector<double> A, std::vector<double> b)
{
  PetscBLASInt size = PetscBLASInt(b.size()), one = 1, info = 0;
  std::vector<PetscBLASInt> pivots(b.size());
  if (size > 0)
    LAPACKgesv_(&size, &one, A.data(), &size, pivots.data(), b.data(), &size, &info);
  if (info != 0)
    return {};
  return b;
}

double spectral_radius(std::vector<double> A, int n)
{
  // Rows in place of columns: the transposed matrix has the same eigenvalues.
  PetscBLASInt size = n, info = 0, length = 34 * n, one = 1;
  std::vector<double> real(n), imaginary(n), work(length);
  double none = 0.0;
  LAPACKgeev_("N", "N", &size, A.data(), &size, real.data(), imaginary.data(), &none, &one, &none, &one, work.data(),
              &length, &info);
  if (info != 0)
    throw std::runtime_error("LAPACK's dgeev ended with " + std::to_string(int(info)));
  double out = 0.0;
  for (int i = 0; i < n; ++i)
    out = std::max(out, std::hypot(real[i], imaginary[i]));
  return out;
}

double spectral_norm(std::vector<double> A, int n)
{
  if (n == 0)
    return 0.0;
  // Rows in place of columns: the transposed matrix has the same singular values.
  PetscBLASInt size = n, info = 0, length = 10 * n, one = 1;
  std::vector<double> values(n), work(length);
  double none = 0.0;
  LAPACKgesvd_("N", "N", &size, &size, A.data(), &size, values.data(), &none, &one, &none, &one, work.data(), &length,
               &info);
  if (info != 0)
    throw std::runtime_error("LAPACK's dgesvd ended with " + std::to_string(int(info)));
  return values.front();
}

std::vector<double> nonnegative_least_squares(const std::vector<std::vector<double>>& rows,
                                              const std::vector<double>& b)
{
  constexpr double round_off = 1e-10;
  const std::size_t n = rows.size();
  const auto dot = [](const std::vector<double>& v, const std::vector<double>& w)
  { return std::inner_product(v.begin(), v.end(), w.begin(), 0.0); };
  std::vector<double> x(n, 0.0), residual(b);
  std::vector<std::size_t> passive;
  std::vector<std::int8_t> dependent(n, 0);
  // Every solution on a passive set is better than the last: no set comes twice, and few are tried.
  for (std::size_t tries = 0; tries < 3 * n + 10; ++tries)
  {
    std::size_t best = n;
    double steepest = round_off * std::sqrt(dot(b, b));
    for (std::size_t i = 0; i < n; ++i)
      if (const double slope = dot(rows[i], residual) / std::max(std::sqrt(dot(rows[i], rows[i])), 1e-300);
          !dependent[i] && slope > steepest && !std::ranges::count(passive, i))
      {
        best = i;
        steepest = slope;
      }
    if (best == n)
      break;
    passive.push_back(best);
    while (!passive.empty())
    {
      const std::size_t m = passive.size();
      std::vector<double> gram(m * m), right(m);
      for (std::size_t i = 0; i < m; ++i)
      {
        right[i] = dot(rows[passive[i]], b);
        for (std::size_t j = 0; j < m; ++j)
          gram[j * m + i] = dot(rows[passive[i]], rows[passive[j]]);
      }
      const std::optional<std::vector<double>> y = solve_dense(gram, right);
      if (!y)
      {
        dependent[passive.back()] = 1;
        x[passive.back()] = 0.0;
        passive.pop_back();
        continue;
      }
      double part = 1.0;
      for (std::size_t i = 0; i < m; ++i)
        if ((*y)[i] <= 0.0)
          part = std::min(part, x[passive[i]] / (x[passive[i]] - (*y)[i]));
      bool leaves = false;
      for (std::size_t i = 0; i < m; ++i)
      {
        double& value = x[passive[i]];
        value += part * ((*y)[i] - value);
        if ((*y)[i] <= 0.0 && value <= 1e-14 * std::abs((*y)[i]) + 1e-300)
        {
          value = 0.0;
          leaves = true;
        }
      }
      if (!leaves)
        break;
      std::erase_if(passive, [&](std::size_t i) { return x[i] == 0.0; });
    }
    residual = b;
    for (std::size_t i : passive)
      for (std::size_t k = 0; k < b.size(); ++k)
        residual[k] -= x[i] * rows[i][k];
  }
  return x;
}

std::optional<std::vector<double>> inverse(std::vector<double> A, int n)
{
  // Of the transposed matrix, whose inverse is the inverse transposed.
  PetscBLASInt size = n, info = 0, length = 64 * n;
  std::vector<PetscBLASInt> pivots(n);
  std::vector<double> work(length);
  if (n > 0)
    LAPACKgetrf_(&size, &size, A.data(), &size, pivots.data(), &info);
  if (n > 0 && info == 0)
    LAPACKgetri_(&size, A.data(), &size, pivots.data(), work.data(), &length, &info);
  if (info != 0)
    return {};
  return A;
}

std::vector<double> dense_product(std::span<const double> A, std::span<const double> x, int rows)
{
  std::vector<double> y(rows, 0.0);
  PetscBLASInt m = PetscBLASInt(x.size()), n = rows, one = 1;
  const double factor = 1.0, none = 0.0;
  if (m > 0 && n > 0)
    BLASgemv_("T", &m, &n, &factor, A.data(), &m, x.data(), &one, &none, y.data(), &one);
  return y;
}

std::vector<double> normal_matrix(std::span<const double> A, int n)
{
  std::vector<double> out(std::size_t(n) * n);
  PetscBLASInt size = n;
  const double factor = 1.0, none = 0.0;
  if (n > 0) // rows in place of columns: A is seen transposed
    BLASgemm_("N", "T", &size, &size, &size, &factor, A.data(), &size, A.data(), &size, &none, out.data(), &size);
  return out;
}
} // namespace dolfinx_impact::solve
