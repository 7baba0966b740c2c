// SPDX-License-Identifier: MIT
#pragma once
#include "LinearSums.h"
#include <cstddef>
#include <cstdint>
#include <span>

namespace dolfinx_impact::operators
{
/// Place of the component (i, j) in the vector of a strain: normal ones, then xy, in space yz and xz.
constexpr int strain_place(int dim, int i, int j)
{
  return i == j ? i : dim == 2 || i + j == 1 ? dim : i + j == 3 ? 4 : 5;
}

/// Place of the derivative of component i by x_j in the vector of a gradient.
constexpr int gradient_place(int dim, int i, int j)
{
  return dim * i + j;
}

/// Means of a node that a law takes.
constexpr int num_means(MeanLaw law, int dim)
{
  return law == MeanLaw::linear_elastic ? dim * (dim + 1) / 2 : dim * dim;
}

/// Matrix of LinearSums: for each row the integrals of N_a grad N_b, one column after the other.
struct GradientRows
{
  std::span<const std::size_t> ends;
  const std::int32_t* columns;
  const double* entries;
};

/// What LinearSums::add_forces reads and writes. Of shared rows, sums only.
struct StrainRows
{
  MeanStress stress{};
  std::span<const double> inverse_volumes{};
  std::span<const std::int8_t> shared{};
  const double* values = nullptr;
  double* sums = nullptr;
  double* b = nullptr;
};

/// Sums of the strain or gradient of each row, or forces of the stress of its mean: LinearSums::add_forces.
/// @param[in] components of the field, 2 or 3
/// @param[in] stride entries of a node of the field and of the forces: as many, or 4 of which the last is padding
/// @throws std::invalid_argument for another stride
void strain_rows(const GradientRows& rows, int components, int stride, const StrainRows& of);

/// Forces of some rows' means: LinearSums::add_forces_of.
void forces_of_rows(const GradientRows& rows, int components, int stride, std::span<const std::int32_t> nodes,
                    const MeanStress& stress, const double* means, double* b);
} // namespace dolfinx_impact::operators
