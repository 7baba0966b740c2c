// SPDX-License-Identifier: MIT
#include "frequencies.h"
#include "../common/OnAllRanks.h"
#include "../operators/owned.h"
#include "../operators/petsc_check.h"
#include "../solve/eigenvalues.h"
#include <algorithm>
#include <cmath>
#include <string>

namespace dolfinx_impact::rolling
{
namespace
{
using operators::check;
using operators::OwnedVector;

constexpr double shift = 1e-3;     ///< of the mesh's frequency: keeps the factors regular where rigid motions are free
constexpr double growth = 1e-6;    ///< real part over the largest modulus found, at which a mode grows
constexpr int max_restarts = 500;  ///< of the eigensolver
constexpr int rigid_motions = 6;   ///< of a body in space
constexpr double round_off = 5e-8; ///< of the mesh's frequency: a few times the square root of the unit of round-off
constexpr double rigid = 10.0;     ///< moduli below this many times the larger of the last two belong to rigid motions

double trace(Mat A)
{
  Vec made = nullptr;
  check(MatCreateVecs(A, &made, nullptr), "a vector is made");
  const OwnedVector diagonal(made);
  PetscScalar out = 0.0;
  check(MatGetDiagonal(A, made), "a diagonal is read");
  check(VecSum(made, &out), "a vector is summed up");
  return out;
}

/// a . A b.
double product(Mat A, Vec a, Vec b, Vec work)
{
  PetscScalar out = 0.0;
  check(MatMult(A, b, work), "a matrix is multiplied");
  check(VecDot(work, a, &out), "vectors are multiplied");
  return out;
}
} // namespace

Frequencies frequencies(const VibrationMatrices& m, int count, double least, double tolerance)
{
  const double highest = std::sqrt(trace(m.K) / trace(m.M));
  solve::EigenOptions options;
  options.tolerance = tolerance;
  options.max_iterations = max_restarts;
  // A body that nothing holds has the rigid motions first.
  const std::vector<solve::QuadraticEigenpair> pairs =
      solve::quadratic_eigenpairs(m.K, m.G, m.M, 2 * count + 2 * rigid_motions, shift * highest, options);
  std::vector<OwnedVector> owned;
  double largest = 0.0;
  for (const solve::QuadraticEigenpair& pair : pairs)
  {
    owned.emplace_back(pair.real);
    owned.emplace_back(pair.imaginary);
    largest = std::max(largest, std::abs(pair.value));
  }
  Vec made = nullptr;
  check(MatCreateVecs(m.K, &made, nullptr), "a vector is made");
  const OwnedVector work(made);
  // Free rigid motions have s = 0 as a double root, which round-off splits into a pair of any phase.
  const double small = std::max(growth * largest, round_off * highest);
  Frequencies out;
  for (const auto& [s, real, imaginary] : pairs)
  {
    if (std::abs(s.real()) > small)
    {
      out.growing += s.real() > 0.0;
      continue;
    }
    if (s.imag() < rigid * small)
      continue; // a rigid motion, or the conjugate of a mode, which is the same motion
    // Imaginary part of x^H D x, where D is real and x = a + i b: a.D b - b.D a.
    const double twist = product(m.along, real, imaginary, made) - product(m.along, imaginary, real, made);
    const double size = product(m.M, real, real, made) + product(m.M, imaginary, imaginary, made);
    out.values.push_back(twist > least * size ? -s.imag() : s.imag());
  }
  if (out.values.size() < std::size_t(count))
    throw common::Failure("the eigensolver found " + std::to_string(out.values.size()) + " of " +
                          std::to_string(count) + " frequencies (" + std::to_string(out.growing) + " modes grow)");
  std::ranges::stable_sort(out.values, {}, [](double value) { return std::abs(value); });
  out.values.resize(count);
  return out;
}
} // namespace dolfinx_impact::rolling
