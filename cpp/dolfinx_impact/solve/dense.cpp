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
} // namespace dolfinx_impact::solve
