// SPDX-License-Identifier: MIT
#include "strain_rows.h"
#include "../common/clones.h"
#include <stdexcept>
#include <string>

namespace dolfinx_impact::operators
{
namespace
{
/// Components of a node in one register, the last of four is padding.
template <int d>
struct Lanes;
template <>
struct Lanes<2>
{
  typedef double type __attribute__((vector_size(16), aligned(8), may_alias));
};
template <>
struct Lanes<3>
{
  typedef double type __attribute__((vector_size(32), aligned(8), may_alias));
};

/// A tensor of a node: row c has the derivatives by x_c of all components.
template <int d>
struct NodeTensor
{
  typedef typename Lanes<d>::type Row;
  Row row[d] = {};
};

/// Entries of a node in an array of S for each.
template <int d, int S>
IMPACT_INLINED void load(const double* from, typename Lanes<d>::type& to)
{
  if constexpr (d == 3 && S == 3)
    to = typename Lanes<3>::type{from[0], from[1], from[2], 0.0};
  else
    to = *reinterpret_cast<const typename Lanes<d>::type*>(from);
}

template <int d, int S>
IMPACT_INLINED void store(const typename Lanes<d>::type& from, double* to)
{
  if constexpr (d == 3 && S == 3)
    for (int i = 0; i < 3; ++i)
      to[i] = from[i];
  else
    *reinterpret_cast<typename Lanes<d>::type*>(to) = from;
}

template <int d, int S>
IMPACT_INLINED void sum_gradients(const GradientRows& rows, std::size_t begin, std::size_t end, const double* values,
                                  NodeTensor<d>& H)
{
  NodeTensor<d> sums[2]; // of every other node: additions need not wait for the last one's
  const auto add = [&](std::size_t k, NodeTensor<d>& sum)
  {
    typename Lanes<d>::type u;
    load<d, S>(values + std::size_t(rows.columns[k]) * S, u);
    for (int c = 0; c < d; ++c)
      sum.row[c] += rows.entries[d * k + c] * u;
  };
  std::size_t k = begin;
  for (; k + 1 < end; k += 2)
  {
    add(k, sums[0]);
    add(k + 1, sums[1]);
  }
  if (k < end)
    add(k, sums[0]);
  for (int c = 0; c < d; ++c)
    H.row[c] = sums[0].row[c] + sums[1].row[c];
}

template <int d, int S>
IMPACT_INLINED void add_force(const GradientRows& rows, std::size_t begin, std::size_t end, const NodeTensor<d>& stress,
                              double* b)
{
  const NodeTensor<d> P = stress; // a copy: what is stored could change it
  for (std::size_t k = begin; k < end; ++k)
  {
    double* node = b + std::size_t(rows.columns[k]) * S;
    typename Lanes<d>::type f;
    load<d, S>(node, f);
    for (int c = 0; c < d; ++c)
      f += rows.entries[d * k + c] * P.row[c];
    store<d, S>(f, node);
  }
}

/// Stress of small strain. Means are those of the strain: a symmetric tensor.
template <int d>
struct LinearElastic
{
  static constexpr int num_means = d * (d + 1) / 2;
  double lambda, mu;

  IMPACT_INLINED static void write(const NodeTensor<d>& H, double* means)
  {
    for (int c = 0; c < d; ++c)
      for (int i = c; i < d; ++i)
        means[strain_place(d, c, i)] = (H.row[c][i] + H.row[i][c]) / 2;
  }
  IMPACT_INLINED static void read(const double* means, NodeTensor<d>& H)
  {
    for (int c = 0; c < d; ++c)
      for (int i = 0; i < d; ++i)
        H.row[c][i] = means[strain_place(d, c, i)];
  }
  IMPACT_INLINED void stress(const NodeTensor<d>& H, NodeTensor<d>& P) const
  {
    double trace = 0.0;
    for (int c = 0; c < d; ++c)
      trace += H.row[c][c];
    for (int c = 0; c < d; ++c)
    {
      for (int i = 0; i < d; ++i)
        P.row[c][i] = mu * (H.row[c][i] + H.row[i][c]);
      P.row[c][c] += lambda * trace;
    }
  }
};

/// mu (F - F^-T) of the deformation gradient F = I + H. Means are those of H.
template <int d>
struct NeoHookean
{
  static constexpr int num_means = d * d;
  double mu;

  IMPACT_INLINED static void write(const NodeTensor<d>& H, double* means)
  {
    for (int c = 0; c < d; ++c)
      for (int i = 0; i < d; ++i)
        means[gradient_place(d, i, c)] = H.row[c][i];
  }
  IMPACT_INLINED static void read(const double* means, NodeTensor<d>& H)
  {
    for (int c = 0; c < d; ++c)
      for (int i = 0; i < d; ++i)
        H.row[c][i] = means[gradient_place(d, i, c)];
  }
  IMPACT_INLINED void stress(const NodeTensor<d>& H, NodeTensor<d>& P) const
  {
    NodeTensor<d> F = H, cofactors;
    for (int c = 0; c < d; ++c)
      F.row[c][c] += 1.0;
    set_cofactors(F, cofactors);
    const typename Lanes<d>::type terms = F.row[0] * cofactors.row[0];
    double determinant = terms[0];
    for (int i = 1; i < d; ++i)
      determinant += terms[i];
    const double factor = mu / determinant;
    for (int c = 0; c < d; ++c)
      P.row[c] = mu * F.row[c] - factor * cofactors.row[c];
  }

private:
  IMPACT_INLINED static void set_cofactors(const NodeTensor<2>& F, NodeTensor<2>& to)
  {
    to.row[0] = typename Lanes<2>::type{F.row[1][1], -F.row[1][0]};
    to.row[1] = typename Lanes<2>::type{-F.row[0][1], F.row[0][0]};
  }
  /// Vector products of rows.
  IMPACT_INLINED static void set_cofactors(const NodeTensor<3>& F, NodeTensor<3>& to)
  {
    NodeTensor<3> next; // component i + 1 in the place of i
    for (int c = 0; c < 3; ++c)
      next.row[c] = __builtin_shufflevector(F.row[c], F.row[c], 1, 2, 0, 3);
    for (int c = 0; c < 3; ++c)
    {
      const int a = (c + 1) % 3, b = (c + 2) % 3;
      const Lanes<3>::type product = F.row[a] * next.row[b] - next.row[a] * F.row[b];
      to.row[c] = __builtin_shufflevector(product, product, 1, 2, 0, 3);
    }
  }
};

/// Rows that are worked on together: what one waits for is hidden behind the others, and their entries are still in the
/// first cache when they are read again.
constexpr std::size_t rows_at_once = 8;

template <int d, int S, typename Law>
IMPACT_INLINED void each_row_of(const GradientRows& rows, const StrainRows& of, const Law& law)
{
  const std::size_t num_rows = rows.ends.size(), *ends = rows.ends.data();
  for (std::size_t first = 0; first < num_rows; first += rows_at_once)
  {
    const std::size_t last = first + rows_at_once < num_rows ? first + rows_at_once : num_rows;
    const std::size_t first_entry = first == 0 ? 0 : ends[first - 1];
    NodeTensor<d> sums[rows_at_once], stress[rows_at_once];
    for (std::size_t row = first, begin = first_entry; row < last; begin = ends[row++])
      sum_gradients<d, S>(rows, begin, ends[row], of.values, sums[row - first]);
    for (std::size_t row = first; row < last; ++row)
      if (of.shared[row])
        law.write(sums[row - first], of.sums + Law::num_means * row);
      else
      {
        NodeTensor<d> mean;
        for (int c = 0; c < d; ++c)
          mean.row[c] = of.inverse_volumes[row] * sums[row - first].row[c];
        law.stress(mean, stress[row - first]);
      }
    for (std::size_t row = first, begin = first_entry; row < last; begin = ends[row++])
      if (!of.shared[row])
        add_force<d, S>(rows, begin, ends[row], stress[row - first], of.b);
  }
}

template <int d, int S>
IMPACT_INLINED void each_row(const GradientRows& rows, const StrainRows& of)
{
  if (of.stress.law == MeanLaw::linear_elastic)
    each_row_of<d, S>(rows, of, LinearElastic<d>{of.stress.lambda, of.stress.mu});
  else
    each_row_of<d, S>(rows, of, NeoHookean<d>{of.stress.mu});
}

IMPACT_CLONES void rows_in_plane(const GradientRows& rows, const StrainRows& of)
{
  each_row<2, 2>(rows, of);
}
IMPACT_CLONES void rows_in_space(const GradientRows& rows, const StrainRows& of)
{
  each_row<3, 3>(rows, of);
}
IMPACT_CLONES void padded_rows_in_space(const GradientRows& rows, const StrainRows& of)
{
  each_row<3, 4>(rows, of);
}

template <int d, int S, typename Law>
void forces_of(const GradientRows& rows, std::span<const std::int32_t> nodes, const Law& law, const double* means,
               double* b)
{
  for (const std::int32_t node : nodes)
  {
    if (std::size_t(node) >= rows.ends.size()) // beyond the last node with cells
      continue;
    NodeTensor<d> mean, stress;
    law.read(means + Law::num_means * std::size_t(node), mean);
    law.stress(mean, stress);
    add_force<d, S>(rows, node == 0 ? 0 : rows.ends[node - 1], rows.ends[node], stress, b);
  }
}

template <int d, int S>
void forces_of_nodes(const GradientRows& rows, std::span<const std::int32_t> nodes, const MeanStress& stress,
                     const double* means, double* b)
{
  if (stress.law == MeanLaw::linear_elastic)
    forces_of<d, S>(rows, nodes, LinearElastic<d>{stress.lambda, stress.mu}, means, b);
  else
    forces_of<d, S>(rows, nodes, NeoHookean<d>{stress.mu}, means, b);
}

[[noreturn]] void refuse(int components, int stride)
{
  throw std::invalid_argument("strains of fields with " + std::to_string(components) + " components and " +
                              std::to_string(stride) + " entries for each node are not summed up");
}
} // namespace

void strain_rows(const GradientRows& rows, int components, int stride, const StrainRows& of)
{
  if (components == 3 && stride == 4)
    padded_rows_in_space(rows, of);
  else if (components == 3 && stride == 3)
    rows_in_space(rows, of);
  else if (components == 2 && stride == 2)
    rows_in_plane(rows, of);
  else
    refuse(components, stride);
}

void forces_of_rows(const GradientRows& rows, int components, int stride, std::span<const std::int32_t> nodes,
                    const MeanStress& stress, const double* means, double* b)
{
  if (components == 3 && stride == 4)
    forces_of_nodes<3, 4>(rows, nodes, stress, means, b);
  else if (components == 3 && stride == 3)
    forces_of_nodes<3, 3>(rows, nodes, stress, means, b);
  else if (components == 2 && stride == 2)
    forces_of_nodes<2, 2>(rows, nodes, stress, means, b);
  else
    refuse(components, stride);
}
} // namespace dolfinx_impact::operators
