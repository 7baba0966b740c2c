// SPDX-License-Identifier: MIT
#include "assembled_step.h"
#include "../common/OnAllRanks.h"
#include "../operators/petsc_check.h"
#include "../solve/eigenvalues.h"
#include <algorithm>
#include <cmath>
#include <memory>
#include <type_traits>
#include <utility>

using dolfinx_impact::operators::check;

namespace dolfinx_impact::integrators
{
namespace
{
constexpr int most_iterations = 30;
constexpr double enough = 1e-9; ///< relative change of the step that ends the iteration: below that of an eigenvalue

struct Destroy
{
  void operator()(Mat matrix) const { MatDestroy(&matrix); }
  void operator()(Vec vector) const { VecDestroy(&vector); }
};
typedef std::unique_ptr<std::remove_pointer_t<Mat>, Destroy> OwnMatrix;
typedef std::unique_ptr<std::remove_pointer_t<Vec>, Destroy> OwnVector;

/// Scale a matrix by the root of the inverse mass from both sides.
void scale(Mat matrix, std::span<const double> inverse_mass)
{
  Vec made = nullptr;
  check(MatCreateVecs(matrix, &made, nullptr), "a vector is made");
  const OwnVector root(made);
  {
    operators::Entries entries(made);
    for (std::size_t i = 0; i < entries.size(); ++i)
      entries[i] = std::sqrt(inverse_mass[i]);
  }
  check(MatDiagonalScale(matrix, made, made), "a matrix is scaled");
}

std::pair<double, OwnVector> largest(Mat matrix)
{
  const auto found = solve::largest_eigenvalue(matrix, nullptr, {.tolerance = 1e-8});
  if (!found)
    throw common::Failure("the highest frequency was not found: use stable_step(method='element')");
  return {found->first, OwnVector(found->second)};
}

/// x . A x, not negative.
double product(Mat matrix, Vec x)
{
  Vec made = nullptr;
  check(VecDuplicate(x, &made), "a vector is made");
  const OwnVector y(made);
  check(MatMult(matrix, x, made), "a matrix is applied");
  double out = 0.0;
  check(VecDot(x, made, &out), "a product is computed");
  return std::max(out, 0.0);
}
} // namespace

double highest_frequency(Mat stiffness, std::span<const double> inverse_mass)
{
  scale(stiffness, inverse_mass);
  return std::sqrt(std::max(largest(stiffness).first, 0.0));
}

double assembled_step(Mat stiffness, Mat damping, std::span<const double> inverse_mass, const UniformDamping& uniform,
                      double start)
{
  scale(stiffness, inverse_mass);
  scale(damping, inverse_mass);
  Mat made = nullptr;
  check(MatTranspose(damping, MAT_INITIAL_MATRIX, &made), "a matrix is transposed");
  const OwnMatrix transposed(made);
  check(MatAXPY(damping, 1.0, made, DIFFERENT_NONZERO_PATTERN), "matrices are added");
  check(MatScale(damping, 0.5), "a matrix is scaled");
  double dt = start;
  for (int i = 0; i < most_iterations; ++i)
  {
    check(MatDuplicate(stiffness, MAT_COPY_VALUES, &made), "a matrix is copied");
    const OwnMatrix matrix(made);
    check(MatScale(made, 0.25 * dt * dt), "a matrix is scaled");
    check(MatAXPY(made, 0.5 * dt, damping, DIFFERENT_NONZERO_PATTERN), "matrices are added");
    check(MatAXPY(made, 0.5 * dt * uniform.beta, stiffness, DIFFERENT_NONZERO_PATTERN), "matrices are added");
    check(MatShift(made, 0.5 * dt * uniform.alpha), "a matrix is shifted");
    const OwnVector x = largest(made).second;
    const double square = product(stiffness, x.get());
    const double half = 0.5 * (product(damping, x.get()) + uniform.rate(square));
    const double before = std::exchange(dt, 2.0 / (half + std::sqrt(half * half + square)));
    if (std::abs(dt - before) <= enough * dt)
      break;
  }
  return dt;
}
} // namespace dolfinx_impact::integrators
