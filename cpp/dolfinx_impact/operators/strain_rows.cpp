// SPDX-License-Identifier: MIT
#include "strain_rows.h"
#include <stdexcept>
#include <string>

namespace dolfinx_impact::operators
{
namespace
{
#if defined(__GNUC__)
#define IMPACT_PART_OF_ROWS __attribute__((always_inline)) inline
#else
#define IMPACT_PART_OF_ROWS inline
#endif

/// A tensor of a node, with rows of S entries as nodes of the field have: [derivative][component].
template <int d, int S>
struct NodeTensor
{
  double at[d][S] = {};
};

template <int d, int S>
IMPACT_PART_OF_ROWS NodeTensor<d, S> gradient_sum(const GradientRows& rows, std::size_t begin, std::size_t end,
                                                  const double* values)
{
  NodeTensor<d, S> H;
  for (std::size_t k = begin; k < end; ++k)
  {
    const double *u = values + std::size_t(rows.columns[k]) * S, *G = rows.entries + d * k;
#pragma GCC unroll 3
    for (int c = 0; c < d; ++c)
#pragma GCC unroll 4
      for (int i = 0; i < S; ++i)
        H.at[c][i] += G[c] * u[i];
  }
  return H;
}

template <int d, int S>
IMPACT_PART_OF_ROWS void add_force(const GradientRows& rows, std::size_t begin, std::size_t end,
                                   const NodeTensor<d, S>& stress, double* b)
{
  for (std::size_t k = begin; k < end; ++k)
  {
    double* f = b + std::size_t(rows.columns[k]) * S;
    const double* G = rows.entries + d * k;
    double sum[S];
#pragma GCC unroll 4
    for (int i = 0; i < S; ++i)
      sum[i] = f[i];
#pragma GCC unroll 3
    for (int c = 0; c < d; ++c)
#pragma GCC unroll 4
      for (int i = 0; i < S; ++i)
        sum[i] += stress.at[c][i] * G[c];
#pragma GCC unroll 4
    for (int i = 0; i < S; ++i)
      f[i] = sum[i];
  }
}

template <int d, int S>
IMPACT_PART_OF_ROWS NodeTensor<d, S> stress_of(const IsotropicModuli& moduli, const double (&strain)[d][d])
{
  double trace = 0.0;
  for (int c = 0; c < d; ++c)
    trace += strain[c][c];
  NodeTensor<d, S> stress;
  for (int c = 0; c < d; ++c)
    for (int i = 0; i < d; ++i)
      stress.at[c][i] = 2 * moduli.mu * strain[c][i] + (c == i ? moduli.lambda * trace : 0.0);
  return stress;
}

template <int d, int S>
IMPACT_PART_OF_ROWS void each_strain_row(const GradientRows& rows, const StrainRows& of)
{
  constexpr int measures = d * (d + 1) / 2;
  std::size_t begin = 0;
  for (std::size_t row = 0; row < rows.ends.size(); begin = rows.ends[row++])
  {
    const NodeTensor<d, S> H = gradient_sum<d, S>(rows, begin, rows.ends[row], of.values);
    if (of.shared[row])
      for (int c = 0; c < d; ++c)
        for (int i = c; i < d; ++i)
          of.sums[measures * row + strain_place(d, c, i)] = (H.at[c][i] + H.at[i][c]) / 2;
    else
    {
      double strain[d][d];
      for (int c = 0; c < d; ++c)
        for (int i = 0; i < d; ++i)
          strain[c][i] = (H.at[c][i] + H.at[i][c]) / 2 * of.inverse_volumes[row];
      add_force<d, S>(rows, begin, rows.ends[row], stress_of<d, S>(of.moduli, strain), of.b);
    }
  }
}

template <int d, int S>
void each_row(const GradientRows& rows, const StrainRows& of)
{
  each_strain_row<d, S>(rows, of);
}

#if defined(__x86_64__) && defined(__GNUC__)
template <int d, int S>
__attribute__((target("avx2,fma"))) void each_row_avx2(const GradientRows& rows, const StrainRows& of)
{
  each_strain_row<d, S>(rows, of);
}
#endif

template <int d, int S>
void forces_of(const GradientRows& rows, std::span<const std::int32_t> nodes, const IsotropicModuli& moduli,
               const double* means, double* b)
{
  constexpr int measures = d * (d + 1) / 2;
  for (const std::int32_t node : nodes)
  {
    if (std::size_t(node) >= rows.ends.size()) // beyond the last node with cells
      continue;
    double strain[d][d];
    for (int c = 0; c < d; ++c)
      for (int i = 0; i < d; ++i)
        strain[c][i] = means[measures * std::size_t(node) + strain_place(d, c, i)];
    add_force<d, S>(rows, node == 0 ? 0 : rows.ends[node - 1], rows.ends[node], stress_of<d, S>(moduli, strain), b);
  }
}

[[noreturn]] void refuse(int components, int stride)
{
  throw std::invalid_argument("strains of fields with " + std::to_string(components) + " components and " +
                              std::to_string(stride) + " entries for each node are not summed up");
}
} // namespace

void strain_rows(const GradientRows& rows, int components, int stride, const StrainRows& of)
{
#if defined(__x86_64__) && defined(__GNUC__)
  static const bool wide = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
  if (components == 3 && stride == 4 && wide)
    return each_row_avx2<3, 4>(rows, of);
#endif
  if (components == 3 && stride == 4)
    each_row<3, 4>(rows, of);
  else if (components == 3 && stride == 3)
    each_row<3, 3>(rows, of);
  else if (components == 2 && stride == 2)
    each_row<2, 2>(rows, of);
  else
    refuse(components, stride);
}

void forces_of_rows(const GradientRows& rows, int components, int stride, std::span<const std::int32_t> nodes,
                    const IsotropicModuli& moduli, const double* means, double* b)
{
  if (components == 3 && stride == 4)
    forces_of<3, 4>(rows, nodes, moduli, means, b);
  else if (components == 3 && stride == 3)
    forces_of<3, 3>(rows, nodes, moduli, means, b);
  else if (components == 2 && stride == 2)
    forces_of<2, 2>(rows, nodes, moduli, means, b);
  else
    refuse(components, stride);
}
} // namespace dolfinx_impact::operators
#undef IMPACT_PART_OF_ROWS
