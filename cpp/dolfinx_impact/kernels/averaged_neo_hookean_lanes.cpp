// SPDX-License-Identifier: MIT
// The sweeps of averaged_neo_hookean.h for batches of IMPACT_LANES cells; compiled once for each. Vectors are of four
// cells also with AVX-512, of which they have the registers: most of the work is to transpose and to add to nodes,
// whose rows have four entries. Vectors of eight take 1.08 to 1.12 of the time on a processor that computes them in
// halves.
#include "averaged_neo_hookean.h"
#include "functions.h"
#include "sweep.h"
#ifdef IMPACT_HAS_SWEEPS

namespace dolfinx_impact::kernels
{
namespace
{
#define IMPACT_ALWAYS_INLINE __attribute__((always_inline)) inline
using swept::Columns;
using swept::Row;
using swept::transposed;

constexpr int W = 4;                ///< cells of a vector
constexpr int batch = IMPACT_LANES; ///< cells whose nodes are numbered together
typedef swept::Column V;

struct Vector
{
  V c[3];
};
/// row[d] belongs to the reference coordinate or position d.
struct Tensor
{
  Vector row[3];
};

IMPACT_ALWAYS_INLINE Vector cross(const Vector& a, const Vector& b)
{
  return {{a.c[1] * b.c[2] - a.c[2] * b.c[1], a.c[2] * b.c[0] - a.c[0] * b.c[2], a.c[0] * b.c[1] - a.c[1] * b.c[0]}};
}
IMPACT_ALWAYS_INLINE V dot(const Vector& a, const Vector& b)
{
  return a.c[0] * b.c[0] + a.c[1] * b.c[1] + a.c[2] * b.c[2];
}
IMPACT_ALWAYS_INLINE Tensor cofactors(const Tensor& a)
{
  return {{cross(a.row[1], a.row[2]), cross(a.row[2], a.row[0]), cross(a.row[0], a.row[1])}};
}
IMPACT_ALWAYS_INLINE Tensor operator+(const Tensor& a, const Tensor& b)
{
  Tensor sum;
  for (int d = 0; d < 3; ++d)
    for (int i = 0; i < 3; ++i)
      sum.row[d].c[i] = a.row[d].c[i] + b.row[d].c[i];
  return sum;
}
/// Row j: the sum over d of a's row d times entry j of b's row d.
IMPACT_ALWAYS_INLINE Tensor product(const Tensor& a, const Tensor& b)
{
  Tensor out;
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < 3; ++i)
      out.row[j].c[i] = a.row[0].c[i] * b.row[0].c[j] + a.row[1].c[i] * b.row[1].c[j] + a.row[2].c[i] * b.row[2].c[j];
  return out;
}

IMPACT_ALWAYS_INLINE Row& row(double* values, unsigned long long entry)
{
  return *reinterpret_cast<Row*>(values + entry);
}
IMPACT_ALWAYS_INLINE const Row& row(const double* values, unsigned long long entry)
{
  return *reinterpret_cast<const Row*>(values + entry);
}

/// Derivatives by the reference coordinates with the other sign: differences of the first node to the others, which are
/// taken before they are transposed.
IMPACT_ALWAYS_INLINE Tensor minus_derivatives(const double* values, const unsigned* entries)
{
  Row first[W];
#pragma GCC unroll 4
  for (int l = 0; l < W; ++l)
    first[l] = row(values, entries[l]);
  Tensor out;
#pragma GCC unroll 3
  for (int d = 0; d < 3; ++d)
  {
    const unsigned* at = entries + (d + 1) * batch;
    const Columns<4> c = transposed(first[0] - row(values, at[0]), first[1] - row(values, at[1]),
                                    first[2] - row(values, at[2]), first[3] - row(values, at[3]));
    out.row[d] = {{c.c[0], c.c[1], c.c[2]}};
  }
  return out;
}

/// Entries of a node one after the other, of each cell.
IMPACT_ALWAYS_INLINE Columns<4> by_cell(const Vector& v, V fourth = V{})
{
  return transposed(v.c[0], v.c[1], v.c[2], fourth);
}

/// First entry of a node's means.
IMPACT_ALWAYS_INLINE unsigned long long entry_of_means(unsigned entry)
{
  return entries_of_means / 4 * static_cast<unsigned long long>(entry);
}

/// Adds the same to all nodes of a cell. Nodes follow each other before cells: neighbouring cells share nodes, and an
/// addition would wait for the last one's store.
IMPACT_ALWAYS_INLINE void add_to_nodes(double* means, const unsigned* entries, const Tensor& H, V log_J)
{
  const Columns<4> first = by_cell(H.row[0], log_J), second = by_cell(H.row[1]), third = by_cell(H.row[2]);
#pragma GCC unroll 4
  for (int l = 0; l < W; ++l)
#pragma GCC unroll 4
    for (int i = 0; i < 4; ++i)
    {
      Row* at = &row(means, entry_of_means(entries[batch * i + l]));
      at[0] = at[0] + first.c[l];
      at[1] = at[1] + second.c[l];
      at[2] = at[2] + third.c[l];
    }
}

/// Sums over the nodes of each cell: entry i of row j in columns[j].c[i].
IMPACT_ALWAYS_INLINE void sum_of_nodes(const double* means, const unsigned* entries, Columns<4> (&columns)[3])
{
  Row sums[3][W];
#pragma GCC unroll 4
  for (int l = 0; l < W; ++l)
  {
    const Row* at[4];
#pragma GCC unroll 4
    for (int i = 0; i < 4; ++i)
      at[i] = &row(means, entry_of_means(entries[batch * i + l]));
#pragma GCC unroll 3
    for (int j = 0; j < 3; ++j)
      sums[j][l] = (at[0][j] + at[1][j]) + (at[2][j] + at[3][j]);
  }
#pragma GCC unroll 3
  for (int j = 0; j < 3; ++j)
    columns[j] = transposed(sums[j][0], sums[j][1], sums[j][2], sums[j][3]);
}

/// Adds forces of all nodes but the first, and to that one the opposite.
IMPACT_ALWAYS_INLINE void scatter(double* forces, const unsigned* entries, const Tensor& f)
{
  const Columns<4> rows[3] = {by_cell(f.row[0]), by_cell(f.row[1]), by_cell(f.row[2])};
#pragma GCC unroll 4
  for (int l = 0; l < W; ++l)
  {
    Row& first = row(forces, entries[l]);
    first = first - (rows[0].c[l] + rows[1].c[l] + rows[2].c[l]);
#pragma GCC unroll 3
    for (int d = 0; d < 3; ++d)
    {
      Row& other = row(forces, entries[(d + 1) * batch + l]);
      other = other + rows[d].c[l];
    }
  }
}

/// One in lanes that count.
IMPACT_ALWAYS_INLINE V ones(int used)
{
  V out{};
  for (int l = 0; l < W; ++l)
    out[l] = l < used ? 1.0 : 0.0;
  return out;
}

/// Calls a function for all vectors of cells, with the entries of their nodes and a weight, zero of cells that do not
/// count.
template <typename Work>
IMPACT_ALWAYS_INLINE void each_vector(const AveragedCells& cells, double weight, Work&& work)
{
  const unsigned* entries = cells.entries;
  V weights = splat<V>(weight);
  for (unsigned long long k = 0; k < cells.num_batches; ++k, entries += 4 * batch)
    for (int part = 0; part < batch; part += W)
    {
      if (k + 1 == cells.num_batches) [[unlikely]]
        weights = weight * ones(cells.used - part);
      work(entries + part, weights);
    }
}

/// With the cofactors C of the Jacobian, whose determinant is det = 6 V up to its sign, grad u = sum_d u_,d C_d / det,
/// and J is the quotient of the determinants of the deformed and the undeformed derivatives of positions.
void add_means(const AveragedCells& cells)
{
  const AveragedCells s = cells; // a copy: what is added could change what is read by reference
  // A quarter of the volume, over the determinant.
  each_vector(s, 1.0 / 24.0,
              [&](const unsigned* entries, V weight) __attribute__((always_inline))
              {
                const Tensor x = minus_derivatives(s.positions, entries),
                             u = minus_derivatives(s.displacement, entries), deformed = x + u;
                Tensor C = cofactors(x);
                const V det = dot(x.row[0], C.row[0]);
                const V log_J = math::log(V(dot(deformed.row[0], cross(deformed.row[1], deformed.row[2])) / det));
                const V signed_weight = math::times_sign(weight, det);
                for (int d = 0; d < 3; ++d)
                  for (int i = 0; i < 3; ++i)
                    C.row[d].c[i] = signed_weight * C.row[d].c[i];
                add_to_nodes(s.means, entries, product(u, C), signed_weight * det * log_J);
              });
}

/// With the cofactors D of the deformed derivatives of positions, V F^-T grad N_d = det D_d / (6 det_deformed): of this
/// part no gradient by positions is computed.
void add_forces(const AveragedCells& cells, const AveragedModuli& moduli)
{
  const AveragedCells s = cells;
  const double mu = moduli.cells_mu;
  // Derivatives of the other sign give forces of the other sign.
  each_vector(s, -1.0 / 6.0,
              [&](const unsigned* entries, V weight) __attribute__((always_inline))
              {
                Columns<4> of_nodes[3];
                sum_of_nodes(s.means, entries, of_nodes);
                const Tensor x = minus_derivatives(s.positions, entries),
                             u = minus_derivatives(s.displacement, entries), deformed = x + u;
                const Tensor C = cofactors(x), D = cofactors(deformed);
                const V det = dot(x.row[0], C.row[0]), deformed_det = dot(deformed.row[0], D.row[0]);
                const V inverse = 1.0 / (det * deformed_det), of_gradient = mu * deformed_det * inverse;
                const V signed_weight = math::times_sign(weight, det), pressure = of_nodes[0].c[3];
                const V of_inverse = signed_weight * (pressure - mu) * det * det * inverse;
                Tensor P = product(u, C); // what the cell's own gradient and the nodes' stress give, times the weight
                for (int j = 0; j < 3; ++j)
                  for (int i = 0; i < 3; ++i)
                  {
                    const V stress = of_nodes[j].c[i];
                    P.row[j].c[i] = signed_weight * ((i == j ? stress + mu : stress) + of_gradient * P.row[j].c[i]);
                  }
                Tensor f;
                for (int d = 0; d < 3; ++d)
                  for (int i = 0; i < 3; ++i)
                    f.row[d].c[i] = P.row[0].c[i] * C.row[d].c[0] + P.row[1].c[i] * C.row[d].c[1] +
                                    P.row[2].c[i] * C.row[d].c[2] + of_inverse * D.row[d].c[i];
                scatter(s.forces, entries, f);
              });
}

/// Entry i + 1 in the place of i, of three.
IMPACT_ALWAYS_INLINE Row next(Row a)
{
  return __builtin_shufflevector(a, a, 1, 2, 0, 3);
}

/// Cofactors are vector products of rows.
void set_stress(unsigned long long num_nodes, const double* inverse_volumes, const AveragedModuli& moduli,
                double* means)
{
  const double mu = moduli.nodes_mu / 4, lambda = moduli.lambda / 4;
  for (unsigned long long k = 0; k < num_nodes; ++k)
  {
    Row* at = reinterpret_cast<Row*>(means + entries_of_means * k);
    const double inverse = inverse_volumes[k];
    if (inverse == 0.0)
      continue; // a node of other materials, without means
    const Row f0 = at[0] * inverse + Row{1.0}, f1 = at[1] * inverse + Row{0.0, 1.0},
              f2 = at[2] * inverse + Row{0.0, 0.0, 1.0};
    const Row n0 = next(f0), n1 = next(f1), n2 = next(f2);
    const Row c0 = next(f1 * n2 - n1 * f2), c1 = next(f2 * n0 - n2 * f0), c2 = next(f0 * n1 - n0 * f1);
    const Row terms = f0 * c0;
    const double factor = mu / (terms[0] + terms[1] + terms[2]);
    Row first = mu * f0 - factor * c0;
    first[3] = lambda * f0[3];
    at[0] = first;
    at[1] = mu * f1 - factor * c1;
    at[2] = mu * f2 - factor * c2;
  }
}
#undef IMPACT_ALWAYS_INLINE
} // namespace

#if IMPACT_LANES == 4
AveragedNeoHookeanKernels averaged_neo_hookean_4();
AveragedNeoHookeanKernels averaged_neo_hookean_4()
#else
AveragedNeoHookeanKernels averaged_neo_hookean_8();
AveragedNeoHookeanKernels averaged_neo_hookean_8()
#endif
{
  return {add_means, set_stress, add_forces};
}
} // namespace dolfinx_impact::kernels
#endif
