// SPDX-License-Identifier: MIT
#pragma once
#include <array>
#include <cmath>
#include <vector>

namespace dolfinx_impact::operators
{
/// Traces of the powers one to three: matrices that have them in common are those of congruent cells.
struct Traces
{
  double first, second, third;

  bool operator==(const Traces& other) const
  {
    const auto same = [](double a, double b) { return std::abs(a - b) <= 1e-12 * std::abs(a); };
    return same(first, other.first) && same(second, other.second) && same(third, other.third);
  }
};

/// A symmetric matrix, its square and its extreme eigenvalues by BLAS and LAPACK. The memory serves one matrix after
/// the other: write all entries, then ask.
class SymmetricMatrix
{
public:
  /// @param[in] n number of rows
  explicit SymmetricMatrix(int n);

  /// Entry in row i and column j; both triangles are to be written.
  double& operator()(int i, int j) { return _entries[std::size_t(_n) * i + j]; }

  Traces traces();

  /// The smallest and the largest eigenvalue.
  /// @throws std::runtime_error if LAPACK finds none
  std::array<double, 2> extreme_eigenvalues();

private:
  int _n;
  std::vector<double> _entries, _product, _eigenvalues, _work;
};
} // namespace dolfinx_impact::operators
