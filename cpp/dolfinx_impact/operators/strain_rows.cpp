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

/// Stress of small strain. Means are those of the strain: a symmetric tensor.
template <int d, int S>
struct LinearElastic
{
  static constexpr int num_means = d * (d + 1) / 2;
  double lambda, mu;

  IMPACT_PART_OF_ROWS static void write(const NodeTensor<d, S>& H, double* means)
  {
    for (int c = 0; c < d; ++c)
      for (int i = c; i < d; ++i)
        means[strain_place(d, c, i)] = (H.at[c][i] + H.at[i][c]) / 2;
  }
  IMPACT_PART_OF_ROWS static NodeTensor<d, S> read(const double* means)
  {
    NodeTensor<d, S> H;
    for (int c = 0; c < d; ++c)
      for (int i = 0; i < d; ++i)
        H.at[c][i] = means[strain_place(d, c, i)];
    return H;
  }
  /// Of the gradient of a mean, of which H is a multiple.
  IMPACT_PART_OF_ROWS NodeTensor<d, S> stress(const NodeTensor<d, S>& H, double factor) const
  {
    double strain[d][d], trace = 0.0;
    for (int c = 0; c < d; ++c)
      for (int i = 0; i < d; ++i)
        strain[c][i] = (H.at[c][i] + H.at[i][c]) / 2 * factor;
    for (int c = 0; c < d; ++c)
      trace += strain[c][c];
    NodeTensor<d, S> stress;
    for (int c = 0; c < d; ++c)
      for (int i = 0; i < d; ++i)
        stress.at[c][i] = 2 * mu * strain[c][i] + (c == i ? lambda * trace : 0.0);
    return stress;
  }
};

/// mu (F - F^-T) of the deformation gradient F = I + H. Means are those of H.
template <int d, int S>
struct NeoHookean
{
  static constexpr int num_means = d * d;
  double mu;

  IMPACT_PART_OF_ROWS static void write(const NodeTensor<d, S>& H, double* means)
  {
    for (int c = 0; c < d; ++c)
      for (int i = 0; i < d; ++i)
        means[gradient_place(d, i, c)] = H.at[c][i];
  }
  IMPACT_PART_OF_ROWS static NodeTensor<d, S> read(const double* means)
  {
    NodeTensor<d, S> H;
    for (int c = 0; c < d; ++c)
      for (int i = 0; i < d; ++i)
        H.at[c][i] = means[gradient_place(d, i, c)];
    return H;
  }
  /// Of the gradient of a mean, of which H is a multiple.
  IMPACT_PART_OF_ROWS NodeTensor<d, S> stress(const NodeTensor<d, S>& H, double factor) const
  {
    double F[d][d], cofactors[d][d], determinant = 0.0;
    for (int c = 0; c < d; ++c)
      for (int i = 0; i < d; ++i)
        F[c][i] = H.at[c][i] * factor + (c == i ? 1.0 : 0.0);
    for (int c = 0; c < d; ++c)
      for (int i = 0; i < d; ++i)
        if constexpr (d == 2)
          cofactors[c][i] = (c == i ? 1.0 : -1.0) * F[1 - c][1 - i];
        else
          cofactors[c][i] = F[(c + 1) % 3][(i + 1) % 3] * F[(c + 2) % 3][(i + 2) % 3] -
                            F[(c + 1) % 3][(i + 2) % 3] * F[(c + 2) % 3][(i + 1) % 3];
    for (int i = 0; i < d; ++i)
      determinant += F[0][i] * cofactors[0][i];
    NodeTensor<d, S> stress;
    for (int c = 0; c < d; ++c)
      for (int i = 0; i < d; ++i)
        stress.at[c][i] = mu * (F[c][i] - cofactors[c][i] / determinant);
    return stress;
  }
};

template <int d, int S, typename Law>
IMPACT_PART_OF_ROWS void each_row_of(const GradientRows& rows, const StrainRows& of, const Law& law)
{
  std::size_t begin = 0;
  for (std::size_t row = 0; row < rows.ends.size(); begin = rows.ends[row++])
  {
    const NodeTensor<d, S> H = gradient_sum<d, S>(rows, begin, rows.ends[row], of.values);
    if (of.shared[row])
      law.write(H, of.sums + Law::num_means * row);
    else
      add_force<d, S>(rows, begin, rows.ends[row], law.stress(H, of.inverse_volumes[row]), of.b);
  }
}

template <int d, int S>
IMPACT_PART_OF_ROWS void each_strain_row(const GradientRows& rows, const StrainRows& of)
{
  if (of.stress.law == MeanLaw::linear_elastic)
    each_row_of<d, S>(rows, of, LinearElastic<d, S>{of.stress.lambda, of.stress.mu});
  else
    each_row_of<d, S>(rows, of, NeoHookean<d, S>{of.stress.mu});
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

template <int d, int S, typename Law>
void forces_of_law(const GradientRows& rows, std::span<const std::int32_t> nodes, const Law& law, const double* means,
                   double* b)
{
  for (const std::int32_t node : nodes)
    if (std::size_t(node) < rows.ends.size()) // not beyond the last node with cells
      add_force<d, S>(rows, node == 0 ? 0 : rows.ends[node - 1], rows.ends[node],
                      law.stress(law.read(means + Law::num_means * std::size_t(node)), 1.0), b);
}

template <int d, int S>
void forces_of(const GradientRows& rows, std::span<const std::int32_t> nodes, const MeanStress& stress,
               const double* means, double* b)
{
  if (stress.law == MeanLaw::linear_elastic)
    forces_of_law<d, S>(rows, nodes, LinearElastic<d, S>{stress.lambda, stress.mu}, means, b);
  else
    forces_of_law<d, S>(rows, nodes, NeoHookean<d, S>{stress.mu}, means, b);
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
                    const MeanStress& stress, const double* means, double* b)
{
  if (components == 3 && stride == 4)
    forces_of<3, 4>(rows, nodes, stress, means, b);
  else if (components == 3 && stride == 3)
    forces_of<3, 3>(rows, nodes, stress, means, b);
  else if (components == 2 && stride == 2)
    forces_of<2, 2>(rows, nodes, stress, means, b);
  else
    refuse(components, stride);
}
} // namespace dolfinx_impact::operators
#undef IMPACT_PART_OF_ROWS
