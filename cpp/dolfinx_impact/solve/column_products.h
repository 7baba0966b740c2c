// SPDX-License-Identifier: MIT
#pragma once
#include <petscmat.h>
#include <span>
#include <vector>

namespace dolfinx_impact::solve
{
/// Products of a sum of matrices with several vectors. Matrices are read once for four of them. Collective.
/// @param[in] matrices of the same size
/// @param[in] num number of vectors
/// @param[in] columns owned entries: those of k at [k*num_owned, (k + 1)*num_owned)
/// @returns products, likewise
std::vector<double> column_products(std::span<const Mat> matrices, int num, std::vector<double> columns);
} // namespace dolfinx_impact::solve
