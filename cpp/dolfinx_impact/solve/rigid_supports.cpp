// SPDX-License-Identifier: MIT
#include "rigid_supports.h"
#include "dense.h"
#include <algorithm>

using dolfinx_impact::operators::RigidBodyModes;

namespace dolfinx_impact::solve
{
namespace
{
/// Of the largest eigenvalue of the supports' products: smaller ones are motions that no support sees.
constexpr double unseen = 1e-10;

/// Call a function with the work of each owned support on the modes: number of the support, its row, and the first mode
/// of its body, outside of which the row is zero.
template <typename Function>
void for_each_support(const RigidBodyModes& motions, std::span<const std::int8_t> fixed, Function&& function)
{
  const int gdim = motions.gdim(), per_body = motions.per_body();
  std::vector<double> row(motions.num_modes());
  std::size_t count = 0;
  for (std::int32_t node = 0; node < motions.num_owned(); ++node)
    for (int c = 0; c < gdim; ++c)
    {
      if (!fixed[std::size_t(node) * gdim + c])
        continue;
      double axis[3] = {0.0, 0.0, 0.0};
      axis[c] = 1.0;
      const int first = motions.body()[node] * per_body;
      std::fill_n(row.begin() + first, per_body, 0.0);
      motions.add_work(motions.body()[node], motions.x().data() + std::size_t(node) * gdim, axis, 1.0, row);
      function(count++, row, first);
    }
}
} // namespace

std::vector<double> products_of_supports(const RigidBodyModes& motions, std::span<const std::int8_t> fixed)
{
  const int per_body = motions.per_body(), num = motions.num_modes();
  std::vector<double> out(std::size_t(num) * num, 0.0);
  for_each_support(motions, fixed,
                   [&](std::size_t, std::span<const double> row, int first)
                   {
                     for (int i = first; i < first + per_body; ++i)
                       for (int j = first; j < first + per_body; ++j)
                         out[std::size_t(i) * num + j] += row[i] * row[j];
                   });
  return out;
}

std::vector<double> rigid_extrapolation(const RigidBodyModes& motions, std::span<const std::int8_t> fixed,
                                        std::span<const double> jump)
{
  const int per_body = motions.per_body(), num = motions.num_modes();
  std::vector<double> sums = products_of_supports(motions, fixed), mode(num, 0.0);
  sums.resize(sums.size() + num, 0.0);
  double* const right = sums.data() + std::size_t(num) * num;
  for_each_support(motions, fixed,
                   [&](std::size_t k, std::span<const double> row, int first)
                   {
                     for (int i = first; i < first + per_body; ++i)
                       right[i] += row[i] * jump[k];
                   });
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), int(sums.size()), MPI_DOUBLE, MPI_SUM, motions.comm());
  const std::vector<double> sides(sums.end() - num, sums.end());
  sums.resize(std::size_t(num) * num);
  const SymmetricEigen found = symmetric_eigen(std::move(sums), num);
  for (int k = 0; k < num; ++k)
  {
    if (found.values[k] <= unseen * found.values.back())
      continue;
    const double* const vector = found.vectors.data() + std::size_t(k) * num;
    double along = 0.0;
    for (int i = 0; i < num; ++i)
      along += vector[i] * sides[i];
    for (int i = 0; i < num; ++i)
      mode[i] += along / found.values[k] * vector[i];
  }
  return motions.field(mode);
}
} // namespace dolfinx_impact::solve
