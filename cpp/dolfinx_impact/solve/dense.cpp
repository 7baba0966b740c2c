// SPDX-License-Identifier: MIT
#include "dense.h"
#include <algorithm>
#include <cmath>
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
