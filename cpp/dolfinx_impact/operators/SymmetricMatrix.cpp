// SPDX-License-Identifier: MIT
// PETSc declares BLAS and LAPACK. Basix declares them otherwise, so that this file includes none of DOLFINx's headers.
#include "SymmetricMatrix.h"
#include <petscblaslapack.h>
#include <stdexcept>

namespace dolfinx_impact::operators
{
SymmetricMatrix::SymmetricMatrix(int n)
    : _n(n), _entries(std::size_t(n) * n), _product(std::size_t(n) * n), _eigenvalues(n), _work(1)
{
  const PetscBLASInt rows = n, query = -1;
  PetscBLASInt info = 0;
  double size = 0.0;
  LAPACKsyev_("N", "U", &rows, _product.data(), &rows, _eigenvalues.data(), &size, &query, &info);
  _work.resize(std::size_t(size));
}

Traces SymmetricMatrix::traces()
{
  const PetscBLASInt n = _n;
  const double one = 1.0, zero = 0.0;
  BLASgemm_("N", "N", &n, &n, &n, &one, _entries.data(), &n, _entries.data(), &n, &zero, _product.data(), &n);
  Traces t{0.0, 0.0, 0.0};
  for (int i = 0; i < _n; ++i)
    t.first += (*this)(i, i);
  for (std::size_t k = 0; k < _entries.size(); ++k)
  {
    t.second += _entries[k] * _entries[k];
    t.third += _product[k] * _entries[k];
  }
  return t;
}

std::array<double, 2> SymmetricMatrix::extreme_eigenvalues()
{
  const PetscBLASInt n = _n, size = PetscBLASInt(_work.size());
  PetscBLASInt info = 0;
  _product = _entries; // LAPACK overwrites it
  LAPACKsyev_("N", "U", &n, _product.data(), &n, _eigenvalues.data(), _work.data(), &size, &info);
  if (info != 0)
    throw std::runtime_error("LAPACK's syev did not find the eigenvalues of a cell's stiffness");
  return {_eigenvalues.front(), _eigenvalues.back()};
}
} // namespace dolfinx_impact::operators
